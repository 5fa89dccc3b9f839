//! Sensor and reference are read at different times while the mirror moves.

use fitter::terms::{Operator, Rate};

use super::{Effect, Experiment, Facts, Handed, Reading, angle_observable, reading, velocity};
use crate::rows::Rows;

/// See the module's description.
pub struct ReadLag;

impl Effect for ReadLag {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "read_lag",
                title: "readings taken at different times",
                formula: "τ dθ/dt, τ in s",
                source: "Fan et al., Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling and Correction, Sensors 19 (2019) 367, section 3: the probes are read in step through a cable of their own",
                size: "either sign (whichever is read later); microseconds to some ten milliseconds",
                confused_with: &["backlash", "hysteresis"],
                variable: "velocity",
                found_by_fit: |turn| turn.directions.lag_corrected,
                told_by: &[(Experiment::Loops, "grows with speed")],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        super::time_apart(rows)?;
        let velocity = velocity(rows);
        // Settled readings are taken at one pace; only a recording that moves is taken at several speeds.
        if rows.command_deg.is_some() && !several_speeds(rows, &velocity) {
            return Err("the readings are settled ones at commanded angles: nothing moves".into());
        }
        let (low, high) = crate::numerics::range(&velocity);
        let middle = crate::numerics::mean(&velocity).abs().max(1e-12);
        if high - low > 0.2 * middle {
            Ok(())
        } else {
            Err("the speed is constant: a delay is a constant offset".into())
        }
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![velocity(rows)]
    }

    fn operator(&self, rows: &Rows, _shape: &[f64]) -> Handed {
        Handed::plain(Operator::Rate(Rate::of(angle_observable(rows))))
    }

    fn readings(&self, _rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![reading("delay_s", amplitudes[0], "s")]
    }
}

/// Whether some pass was run at least half as fast again as another.
fn several_speeds(rows: &Rows, velocity: &[f64]) -> bool {
    let typical = rows.passes().into_iter().map(|pass| {
        let mut speeds: Vec<f64> =
            velocity.iter().zip(&rows.pass).filter(|(_, p)| **p == pass).map(|(v, _)| v.abs()).collect();
        crate::numerics::median(&mut speeds)
    });
    let (slowest, fastest) = typical.fold((f64::INFINITY, 0.0), |(s, f), v: f64| (v.min(s), v.max(f)));
    fastest > 1.5 * slowest
}
