//! Play between what is measured and what turns: the same angle reads differently from either side.

use fitter::terms::{Operator, Play};

use super::{Effect, Handed, Place, Range, Reading, angle_observable, play, reading};
use crate::rows::Rows;

/// See the module's description.
pub struct Backlash;

impl Effect for Backlash {
    fn id(&self) -> &'static str {
        "backlash"
    }

    fn title(&self) -> &'static str {
        "backlash"
    }

    fn formula(&self) -> &'static str {
        "θ − play_r(θ), half width r small against a step"
    }

    fn source(&self) -> &'static str {
        "Brokate & Sprekels, Hysteresis and Phase Transitions, Springer (1996), chapter 2: the play operator"
    }

    fn size(&self) -> &'static str {
        "positive; up to a few arcsec, far less than a step of the angle"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["hysteresis", "read_lag"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("direction")
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        if rows.both_directions() { Ok(()) } else { Err("the recording moves in one direction only".into()) }
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        // Any width that is small against a step has the same signature but for the turning points.
        vec![vec![1e-3 * rows.step()]]
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        // The width is its own amplitude (`consistent_shape`): it is not searched.
        let start = 1e-3 * rows.step();
        vec![Range { low: start, high: start, logarithmic: true, whole: false }]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let r = shape[0].max(1e-9);
        let p = play(&rows.theta, r);
        vec![rows.theta.iter().zip(&p).map(|(theta, p)| (theta - p) / r).collect()]
    }

    fn plausible(&self, amplitudes: &[f64]) -> bool {
        amplitudes[0] > 0.0
    }

    fn consistent_shape(&self, amplitudes: &[f64]) -> Option<Vec<f64>> {
        Some(vec![amplitudes[0].abs()])
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        let r = shape[0].max(1e-9);
        Handed::scaled(Operator::Play(Play::of(angle_observable(rows), &[r])), 1.0 / r)
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![reading(format!("half_width_{}", rows.unit), amplitudes[0], rows.unit.as_str())]
    }
}
