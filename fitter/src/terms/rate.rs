//! `rate`: dv/dt in units of the observable per second, by the difference to the row before, as a controller
//! would form it; one coefficient, a delay in seconds if v is the angle in the unit of the result.
//!
//! The first row of the recording and of every pass has the difference to the row after it: between
//! passes the mirror may have moved anywhere.

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rate {
    /// Name of the observable.
    pub observable: String,
}

impl Rate {
    /// The rate of an observable.
    pub fn of(observable: &str) -> Rate {
        Rate { observable: observable.to_string() }
    }

    pub(super) fn column(&self, observables: &Observables) -> Result<Vec<f64>, Missing> {
        let values = observables.get(&self.observable)?;
        let (time_s, pass) = (&observables.recording.time_s, &observables.recording.pass);
        let rows = values.len();
        let between = |a: usize, b: usize| {
            let passed = time_s[b] - time_s[a];
            if passed > 0.0 { (values[b] - values[a]) / passed } else { 0.0 }
        };
        let same_pass = |a: usize, b: usize| b < rows && pass[a] == pass[b];
        Ok((0..rows)
            .map(|row| {
                if row > 0 && same_pass(row - 1, row) {
                    between(row - 1, row)
                } else if same_pass(row, row + 1) {
                    between(row, row + 1)
                } else {
                    0.0
                }
            })
            .collect())
    }
}
