//! Play between what is measured and what turns: the same angle reads differently from either side.

use fitter::terms::{Operator, Play, Product};

use super::{Effect, Experiment, Facts, Handed, Range, Reading, angle_observable, play_from, reading};
use crate::rows::Rows;
use crate::thresholds::effects::backlash::{MOVED, RELUCTANCE};

/// State of the play before the first row: in the middle of the gap, or against one side.
const FREE: f64 = 0.0;
const FORWARD: f64 = 1.0;
const BACKWARD: f64 = -1.0;
/// The side is what the column `direction` states: of settled readings the way there is not in the recording.
const STATED: f64 = 2.0;

/// See the module's description.
pub struct Backlash;

impl Effect for Backlash {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "backlash",
                title: "backlash",
                formula: "±(θ − play_r(θ)), half width r small against a step; + on the driving side, − on the load",
                source: "Brokate & Sprekels, Hysteresis and Phase Transitions, Springer (1996), chapter 2: the play operator",
                size: "of either sense, as the sensor is on the driving side or on the load; up to a few arcsec, less than a step of the angle",
                confused_with: &["hysteresis", "read_lag"],
                variable: "direction",
                shape_follows: true,
                told_by: &[(Experiment::Loops, "keeps its width"), (Experiment::OneByOne, "direction")],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        if rows.both_directions() { Ok(()) } else { Err("the recording moves in one direction only".into()) }
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        // Any width that is small against a step has the same signature but for the turning points.
        [FREE, FORWARD, BACKWARD, STATED].map(|state| vec![narrow(rows), state]).to_vec()
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        // The width is its own amplitude (`consistent_shape`), and the state one of three: neither is searched.
        vec![
            Range { low: narrow(rows), high: narrow(rows), logarithmic: true, whole: false },
            Range { low: BACKWARD, high: STATED, logarithmic: false, whole: true },
        ]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        if shape[1] == STATED {
            return vec![rows.direction.clone()];
        }
        let r = shape[0].max(1e-12);
        let first = rows.theta.first().copied().unwrap_or(0.0);
        let p = play_from(&rows.theta, r, first - shape[1] * r);
        vec![rows.theta.iter().zip(&p).map(|(theta, p)| (theta - p) / r).collect()]
    }

    fn consistent_shape(&self, shape: &[f64], amplitudes: &[f64], rows: &Rows) -> Option<Vec<f64>> {
        // Where the sensor sits on the load its reading does not move within the play: it turns over at once.
        let width = if amplitudes[0] > 0.0 { amplitudes[0] } else { narrow(rows) };
        Some(vec![width, shape[1]])
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        if shape[1] == STATED {
            return Handed::plain(Operator::Product(Product::of("direction", 0.0)));
        }
        let r = shape[0].max(1e-12);
        let mut play = Play::of(angle_observable(rows), &[r]);
        if shape[1] != FREE {
            let first = rows.theta.first().copied().unwrap_or(0.0);
            play.elements[0].initial = Some(first - shape[1] * r);
        }
        Handed::scaled(Operator::Play(play), 1.0 / r)
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![reading(format!("half_width_{}", rows.unit), amplitudes[0].abs(), rows.unit.as_str())]
    }

    fn begins_before(&self, shape: &[f64]) -> bool {
        shape[1] == FORWARD || shape[1] == BACKWARD
    }

    fn undetermined_rows(&self, rows: &Rows, noise: f64) -> Vec<usize> {
        // Read again where the motion turned, the device may stand on either side of its play or between: a loop moves it
        // there by as much as the reading is noisy.
        let turned = |i: &usize| rows.direction[*i] != rows.direction[*i - 1];
        let stayed = |i: &usize| (rows.theta[*i] - rows.theta[*i - 1]).abs() < MOVED * noise;
        (1..rows.len()).filter(|i| turned(i) && stayed(i)).collect()
    }

    fn reluctance(&self, shape: &[f64]) -> f64 {
        if shape[1] == STATED { RELUCTANCE } else { 0.0 }
    }

    fn found_as(&self, amplitudes: &[f64]) -> &'static str {
        if amplitudes[0] > 0.0 {
            "backlash; the sensor is on the driving side, its reading runs ahead"
        } else {
            "backlash; the sensor is on the load, its reading lags"
        }
    }
}

/// Half width from which the play is sought: small against a step, and beyond what a reading at rest wanders.
fn narrow(rows: &Rows) -> f64 {
    1e-3 * rows.step()
}
