//! Readings that a model which explains all others leaves far out. The screen before the fit knows a row by its
//! neighbours only, whose own noise adds to that of the prediction; a model knows it from all rows.

use std::borrow::Cow;

use super::culprit::{beyond_the_tail, jumping, reason};
use super::scale::with_tail;
use super::{BadRow, Fault, Screened, limits, listed, trend};
use crate::recording::{Readings, Recording};

/// The rows whose reading is left far out of the noise, where `left` is what a model leaves of every row and `sigma` the
/// standard deviation of its noise. Correlated noise is predicted from the rows before and after.
pub fn beyond_noise(recording: &Recording, left: &[f64], sigma: &[f64]) -> Vec<(usize, BadRow)> {
    if left.len() < limits::FEWEST_ROWS {
        return Vec::new();
    }
    let standard: Vec<f64> = left.iter().zip(sigma).map(|(left, sigma)| left / sigma).collect();
    let [away, _, _] = trend::less_trend(&standard, &recording.time_s);
    let scatter = with_tail(&mut away.iter().map(|away| away.abs()).collect::<Vec<f64>>());
    let alone = |row: usize| {
        let keeps =
            |other: usize| (away[row] - away[other]) * away[row].signum() >= limits::ALONE * away[row].abs();
        (row == 0 || keeps(row - 1)) && (row + 1 == away.len() || keeps(row + 1))
    };
    let of = |row: usize| {
        let size = away[row].abs() / scatter;
        let column = match &recording.readings {
            Readings::Pair { .. } => "reference_arcsec",
            Readings::Direct { .. } => jumping(recording, row),
        };
        let value = recording.values(column).map_or(f64::NAN, |values| values[row]);
        let reason = reason(away[row] * sigma[row], column, "all other rows and what explains them", size);
        let counts = size > limits::CLOSER_LOOK && alone(row);
        counts.then(|| Fault { row, column: column.into(), value, reason, size })
    };
    let found = beyond_the_tail((0..away.len()).filter_map(of).collect(), away.len());
    found.iter().map(|fault| (fault.row, listed(recording, fault))).collect()
}

impl<'a> Screened<'a> {
    /// The same without further rows of it.
    pub fn without(self, further: Vec<(usize, BadRow)>) -> Screened<'a> {
        let rest: Vec<usize> =
            (0..self.kept.len()).filter(|row| further.iter().all(|(bad, _)| bad != row)).collect();
        let mut bad_rows = self.bad_rows;
        bad_rows.extend(further.into_iter().map(|(_, bad)| bad));
        bad_rows.sort_by_key(|bad| bad.line);
        Screened {
            recording: Cow::Owned(self.recording.select(&rest)),
            kept: rest.iter().map(|row| self.kept[*row]).collect(),
            bad_rows,
            notes: self.notes,
        }
    }
}
