//! Values that are no readings whatever the others say: codes for "no reading", and values beyond all measure.

use super::scale::quantile;
use super::{Fault, limits};
use crate::limits::LARGEST;
use crate::recording::{Readings, Recording};

/// All columns of numbers but pass and direction.
pub fn columns(recording: &Recording) -> Vec<(&str, &[f64])> {
    let mut columns: Vec<(&str, &[f64])> = vec![("t_s", &recording.time_s)];
    columns.extend(recording.command_deg.as_deref().map(|values| ("command_deg", values)));
    match &recording.readings {
        Readings::Pair { x1_mm, x2_mm, reference_arcsec } => {
            columns.extend([("x1_mm", x1_mm.as_slice()), ("x2_mm", x2_mm)]);
            columns.extend(reference_arcsec.as_deref().map(|values| ("reference_arcsec", values)));
        }
        Readings::Direct { measured, reference } => {
            columns.push(("measured", measured));
            columns.extend(reference.as_deref().map(|values| ("reference", values)));
        }
    }
    columns.extend(recording.further.iter().map(|c| (c.name.as_str(), c.values.as_slice())));
    columns
}

pub fn faults(recording: &Recording) -> Vec<Fault> {
    columns(recording).into_iter().flat_map(|(name, values)| of_column(name, values)).collect()
}

fn of_column(name: &str, values: &[f64]) -> Vec<Fault> {
    let fault = |row: usize, size: f64, reason: String| Fault {
        row,
        column: name.to_string(),
        value: values[row],
        reason,
        size,
    };
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
    let others = || (0..values.len()).filter(|row| values[*row].abs() <= LARGEST);
    if low == high {
        // A column that stands still but for one row.
        let mut different = others().filter(|row| values[*row] != middle);
        if let (Some(row), None) = (different.next(), different.next()) {
            let reason = format!("all other rows have {middle}");
            found.push(fault(row, f64::INFINITY, reason));
        }
    }
    // Where a sensor stands most of the time, the middle half is its noise, and a tenth of the rows at another place is
    // no wrong column.
    let stands = 2.0 * (nine_tenths - tenth) / limits::ABSURD;
    let spread = (three_quarters - quarter).max(1e-3 * middle.abs()).max(stands);
    if spread == 0.0 {
        return found;
    }
    let is_code = |v: f64| limits::CODES.contains(&v.abs());
    let (from, to) = (sorted.iter().filter(|v| !is_code(**v)))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    for row in others() {
        let value = values[row];
        let size = (value - middle).abs() / spread;
        let outside = value < from - 0.5 * spread || value > to + 0.5 * spread;
        let listed = found.iter().any(|fault| fault.row == row);
        if listed {
            continue;
        }
        if is_code(value) && outside && size > limits::CODE {
            let reason = format!(
                "what programs write for \"no reading\": {size:.0} times the column's spread away from its median \
                 {middle}"
            );
            found.push(fault(row, size, reason));
        } else if size > limits::ABSURD && low != high && name != "t_s" {
            // Of times the clock decides: a pause may be long.
            let reason =
                format!("{size:.0} times the column's spread (25 % to 75 %) away from its median {middle}");
            found.push(fault(row, size, reason));
        }
    }
    found
}
