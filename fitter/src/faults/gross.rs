//! Values that are no readings whatever the others say: codes for "no reading", and values beyond all measure.

use super::scale::quantile;
use super::{Fault, limits};
use crate::figures::plain;
use crate::limits::LARGEST;
use crate::recording::Recording;

pub fn faults(recording: &Recording) -> Vec<Fault> {
    recording.columns().into_iter().flat_map(|(name, values)| of_column(name, values)).collect()
}

/// Whether it is what programs write where there is no reading.
fn is_code(value: f64) -> bool {
    limits::CODES.contains(&value.abs())
}

/// The values of a column beside which some are no readings.
struct Others {
    from: f64,
    to: f64,
    /// How far outside a value is none of theirs.
    apart: f64,
}

impl Others {
    /// All values that are no codes, of the `sorted` ones.
    fn than_codes(sorted: &[f64]) -> Others {
        let others: Vec<f64> = sorted.iter().copied().filter(|value| !is_code(*value)).collect();
        let (Some(from), Some(to)) = (others.first().copied(), others.last().copied()) else {
            return Others { from: 0.0, to: 0.0, apart: f64::INFINITY };
        };
        let widest = others.windows(2).fold(0.0_f64, |widest, pair| widest.max(pair[1] - pair[0]));
        let codes = sorted.len() - others.len();
        // Beside one other value a few codes are no readings, and many are the second of two states.
        let is_state = from == to && codes as f64 > limits::MOST_AFFECTED * sorted.len() as f64;
        let apart = (limits::CODE_STEPS * widest).max(limits::CODE_PART * (to - from));
        Others { from, to, apart: if is_state { f64::INFINITY } else { apart } }
    }

    /// All but the few lowest and highest of the `sorted` ones.
    fn than_extremes(sorted: &[f64]) -> Others {
        let (from, to) = (sorted[limits::LONE_ROWS], sorted[sorted.len() - 1 - limits::LONE_ROWS]);
        Others { from, to, apart: if from < to { limits::LONE * (to - from) } else { f64::INFINITY } }
    }

    /// How far outside a value lies, as text; none where it may be one of theirs.
    fn gap(&self, value: f64) -> Option<String> {
        let outside = (self.from - value).max(value - self.to);
        (outside > self.apart).then(|| plain(outside))
    }
}

fn of_column(name: &str, values: &[f64]) -> Vec<Fault> {
    let fault = |row: usize, size: f64, reason: String| Fault::new(row, name, values[row], size, reason);
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.abs() <= LARGEST).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let mut found: Vec<Fault> = (0..values.len())
        .filter(|row| values[*row].abs() > LARGEST)
        .map(|row| fault(row, f64::INFINITY, "beyond any quantity that is measured".to_string()))
        .collect();
    if sorted.len() < limits::FEWEST_ROWS {
        return found;
    }
    let [low, tenth, quarter, middle, three_quarters, nine_tenths, high] =
        [0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98].map(|part| quantile(&sorted, part));
    let mut only = None;
    if low == high {
        // A column that stands still but for one row.
        let is_different = |row: &usize| values[*row].abs() <= LARGEST && values[*row] != middle;
        let mut different = (0..values.len()).filter(is_different);
        if let (Some(row), None) = (different.next(), different.next()) {
            only = Some(row);
            let reason = format!("all other rows have {middle}");
            found.push(fault(row, f64::INFINITY, reason));
        }
    }
    // Where a sensor stands most of the time, the middle half is its noise, and a tenth of the rows at another place is
    // no wrong column.
    let stands = 2.0 * (nine_tenths - tenth) / limits::ABSURD;
    let spread = (three_quarters - quarter).max(1e-3 * middle.abs()).max(stands);
    let (no_codes, no_lone) = (Others::than_codes(&sorted), Others::than_extremes(&sorted));
    for (row, value) in values.iter().enumerate() {
        if only == Some(row) || value.abs() > LARGEST {
            continue;
        }
        let size = (value - middle).abs() / spread;
        if let (true, Some(gap)) = (is_code(*value), no_codes.gap(*value)) {
            let reason = format!("what programs write for \"no reading\", {gap} away from all other values");
            found.push(fault(row, f64::INFINITY, reason));
        } else if name == "t_s" {
            // Of times the clock decides: a pause may be long.
        } else if let Some(gap) = no_lone.gap(*value) {
            let reason =
                format!("{gap} away from all other values, which span {}", plain(no_lone.to - no_lone.from));
            found.push(fault(row, f64::INFINITY, reason));
        } else if spread > 0.0 && size > limits::ABSURD && low != high {
            let reason =
                format!("{size:.0} times the column's spread (25 % to 75 %) away from its median {middle}");
            found.push(fault(row, size, reason));
        }
    }
    found
}
