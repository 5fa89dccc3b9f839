//! An error that grows over the turn and does not repeat with it: the scale of the reference, or a gearing.

use fitter::terms::{Operator, Product};

use super::{Effect, Facts, Handed, Reading, angle_observable, reading};
use crate::numerics::mean;
use crate::rows::Rows;

/// See the module's description.
pub struct TurnSlope;

impl Effect for TurnSlope {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "turn_slope",
                title: "a slope over the turn, which does not repeat: the scale of the reference or a gearing",
                formula: "k (θ − θ̄), k in the sensor's unit per turn",
                source: "ISO 230-2:2014, Test code for machine tools, part 2: mean reversal and positional deviation of an axis, the part that is linear in the travel",
                size: "either sign; up to some thousandths of the turn",
                confused_with: &["time_drift"],
                variable: "angle_deg",
                found_by_fit: |turn| turn.slope.is_some(),
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        match rows.whole_turn() {
            Some(_) => Ok(()),
            None => Err("the base follows a slope already: nothing turns".into()),
        }
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        let turn = rows.whole_turn().unwrap_or(1.0);
        let middle = mean(&rows.theta);
        vec![rows.theta.iter().map(|theta| (theta - middle) / turn).collect()]
    }

    fn operator(&self, rows: &Rows, _shape: &[f64]) -> Handed {
        let turn = rows.whole_turn().unwrap_or(1.0);
        Handed::scaled(Operator::Product(Product::of(angle_observable(rows), mean(&rows.theta))), 1.0 / turn)
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let unit = &rows.unit;
        vec![reading(format!("slope_{unit}_per_turn"), amplitudes[0], format!("{unit}/turn"))]
    }
}
