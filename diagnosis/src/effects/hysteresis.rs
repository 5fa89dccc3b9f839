//! Hysteresis of the flexure or the pads: play distributed over the stroke, a lens-shaped loop.
//!
//! The elements remember what was done before the first row. Either the first row finds them at ease (its own
//! angle is where they begin), or the mirror came to the first angle from rest at zero and dragged them along:
//! the two differ in the first pass only, and the recording decides.

use fitter::terms::{Operator, Play};

use super::{Effect, Experiment, Facts, Handed, Range, Reading, angle_observable, plays_apart, reading};
use crate::rows::Rows;
use crate::thresholds::effects::hysteresis::{AT_EASE, ELEMENTS, FROM_ZERO, LEAST_RADIUS, LOOP_STEPS};

/// See the module's description.
pub struct Hysteresis;

impl Effect for Hysteresis {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "hysteresis",
                title: "hysteresis",
                formula: "Σ w (θ − play_r(θ)) over radii r evenly up to R",
                source: "Brokate & Sprekels, Hysteresis and Phase Transitions, Springer (1996), chapter 2: the Prandtl–Ishlinskii operator",
                size: "positive (the reading runs ahead of the mirror); up to 1 % of the stroke",
                confused_with: &["backlash", "read_lag"],
                variable: "history",
                told_by: &[(Experiment::Loops, "shrinks"), (Experiment::OneByOne, "direction")],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        if rows.both_directions() { Ok(()) } else { Err("the recording moves in one direction only".into()) }
    }

    fn begins_before(&self, shape: &[f64]) -> bool {
        shape[1] == FROM_ZERO
    }

    fn starts(&self, _rows: &Rows) -> Vec<Vec<f64>> {
        [0.3, 0.6, 1.0, 2.0].iter().flat_map(|part| [vec![*part, AT_EASE], vec![*part, FROM_ZERO]]).collect()
    }

    fn ranges(&self, _rows: &Rows) -> Vec<Range> {
        // R as a part of half the stroke; beyond the whole stroke the elements never yield, and where all of them
        // yield within a quarter of a half it is not distributed over the stroke: that is a backlash.
        vec![
            Range { low: LEAST_RADIUS, high: 2.0, logarithmic: true, whole: false },
            Range { low: AT_EASE, high: FROM_ZERO, logarithmic: false, whole: true },
        ]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let (low, high) = rows.stroke();
        let largest = shape[0] * 0.5 * (high - low);
        let start = if shape[1] == FROM_ZERO { 0.0 } else { rows.theta.first().copied().unwrap_or(0.0) };
        let radii: [f64; ELEMENTS] = std::array::from_fn(|k| largest * (k + 1) as f64 / ELEMENTS as f64);
        let scale = 1.0 / (largest * ELEMENTS as f64);
        vec![plays_apart(&rows.theta, &radii, start).map(|sum| sum * scale).collect()]
    }

    fn plausible(&self, amplitudes: &[f64]) -> bool {
        // Play only ever makes the reading run ahead.
        amplitudes[0] > 0.0
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        let (low, high) = rows.stroke();
        let largest = shape[0] * 0.5 * (high - low);
        let radii: Vec<f64> = (1..=ELEMENTS).map(|k| largest * k as f64 / ELEMENTS as f64).collect();
        let weight = 1.0 / (largest * ELEMENTS as f64);
        let mut play = Play::of(angle_observable(rows), &radii);
        if shape[1] == FROM_ZERO {
            play.elements.iter_mut().for_each(|e| e.initial = Some(0.0));
        }
        Handed { operator: Operator::Play(play), map: vec![vec![weight]; ELEMENTS] }
    }

    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![reading(
            format!("half_height_{}", rows.unit),
            half_height(shape[0]) * amplitudes[0],
            rows.unit.as_str(),
        )]
    }
}

/// The largest distance of the steady loop over the stroke from its own polynomial of order 9, for an amplitude of 1 and
/// elements that reach `part` of half the stroke: of positions in any order the rows trace no such loop.
fn half_height(part: f64) -> f64 {
    let forward = (-LOOP_STEPS..=LOOP_STEPS).map(|k| f64::from(k) / f64::from(LOOP_STEPS));
    let cycle: Vec<f64> = forward.clone().chain(forward.rev()).collect();
    let twice = [&cycle[..], &cycle].concat();
    let radii: [f64; ELEMENTS] = std::array::from_fn(|k| part * (k + 1) as f64 / ELEMENTS as f64);
    let scale = 1.0 / (part * ELEMENTS as f64);
    let mut distance: Vec<f64> =
        plays_apart(&twice, &radii, -1.0).skip(cycle.len()).map(|sum| sum * scale).collect();
    let mut polynomial = crate::numerics::Basis::new(cycle.len());
    for column in crate::base::legendre(&cycle, 9) {
        polynomial.add(&column);
    }
    polynomial.project_off(&mut distance);
    distance.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()))
}
