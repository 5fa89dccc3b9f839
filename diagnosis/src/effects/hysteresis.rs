//! Hysteresis of the flexure or the pads: play distributed over the stroke, a lens-shaped loop.

use fitter::terms::{Operator, Play};

use super::{Effect, Handed, Place, Range, Reading, angle_observable, play, reading};
use crate::rows::Rows;

/// Number of play elements between 0 and R.
const ELEMENTS: usize = 12;

/// See the module's description.
pub struct Hysteresis;

impl Effect for Hysteresis {
    fn id(&self) -> &'static str {
        "hysteresis"
    }

    fn title(&self) -> &'static str {
        "hysteresis"
    }

    fn formula(&self) -> &'static str {
        "Σ w (θ − play_r(θ)) over radii r evenly up to R"
    }

    fn source(&self) -> &'static str {
        "Brokate & Sprekels, Hysteresis and Phase Transitions (1996), section 2.4: the Prandtl–Ishlinskii operator"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["backlash", "read_lag"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("history")
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        if rows.both_directions() { Ok(()) } else { Err("the recording moves in one direction only".into()) }
    }

    fn starts(&self, _rows: &Rows) -> Vec<Vec<f64>> {
        vec![vec![0.2], vec![0.5], vec![1.0], vec![2.0]]
    }

    fn ranges(&self, _rows: &Rows) -> Vec<Range> {
        // R as a part of half the stroke; beyond the whole stroke the elements never yield.
        vec![Range { low: 0.1, high: 2.0, logarithmic: true, whole: false }]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let (low, high) = rows.stroke();
        let largest = shape[0] * 0.5 * (high - low);
        let mut sum = vec![0.0; rows.len()];
        for k in 1..=ELEMENTS {
            let r = largest * k as f64 / ELEMENTS as f64;
            let p = play(&rows.theta, r);
            for i in 0..sum.len() {
                sum[i] += (rows.theta[i] - p[i]) / (largest * ELEMENTS as f64);
            }
        }
        vec![sum]
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        let (low, high) = rows.stroke();
        let largest = shape[0] * 0.5 * (high - low);
        let radii: Vec<f64> = (1..=ELEMENTS).map(|k| largest * k as f64 / ELEMENTS as f64).collect();
        let weight = 1.0 / (largest * ELEMENTS as f64);
        Handed {
            operator: Operator::Play(Play::of(angle_observable(rows), &radii)),
            map: vec![vec![weight]; ELEMENTS],
        }
    }

    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let loop_: Vec<f64> = self.signature(rows, shape)[0].iter().map(|v| v * amplitudes[0]).collect();
        let x = rows.scaled_reading();
        let mut polynomial = crate::linear::Basis::new(rows.len());
        for column in crate::base::legendre(&x, 9) {
            polynomial.add(&column);
        }
        let mut distance = loop_;
        polynomial.project_off(&mut distance);
        let largest = distance.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        vec![reading(
            format!("half_height_{}", rows.unit),
            largest * amplitudes[0].signum(),
            rows.unit.as_str(),
        )]
    }
}
