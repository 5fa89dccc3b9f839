//! Samples of a motion that cannot be readings: listed, and replaced by what the samples before and after say, since the
//! rows of a moving recording have to stay equidistant.

use std::ops::Range;

use super::{BadRow, limits, shown};
use crate::limits::LARGEST;
use crate::recording::RecordingError;
use crate::table::{Place, Values};

/// Replaces the samples of a column that cannot be readings. Of a drive those only that are codes for "no reading" or
/// beyond all measure: a single high sample may be a pulse that was meant. Lent numbers stay lent where nothing is replaced.
///
/// # Errors
/// [`RecordingError::TooManyFaults`] where more than a tenth of the samples are affected.
pub fn mend(
    place: &dyn Fn(usize) -> Place,
    values: &mut Values,
    runs: &[Range<usize>],
    is_position: bool,
) -> Result<Vec<BadRow>, RecordingError> {
    let mut found = gross(values);
    let bad: Vec<usize> = found.iter().map(|(row, _)| *row).collect();
    let rows = values.len();
    let listed = |(row, reason): &(usize, String), value: f64| {
        let Place { line, column, .. } = place(*row);
        let reason = format!("{reason}; replaced by what the samples before and after say");
        BadRow { line, column, value: shown(value), reason }
    };
    if bad.len() as f64 > limits::MOST_AFFECTED * rows as f64 {
        let (row, reason) = found.swap_remove(0);
        let (place, found, affected) = (place(row), format!("{} ({reason})", shown(values[row])), bad.len());
        return Err(RecordingError::TooManyFaults { place, found, affected, rows });
    }
    let whole: Vec<f64> = values.to_vec();
    fill(values, runs, &bad);
    if is_position {
        let mut spikes: Vec<(usize, String)> = runs.iter().flat_map(|run| spikes(values, run)).collect();
        // What was put in is no reading.
        spikes.retain(|(row, _)| bad.iter().all(|other| other.abs_diff(*row) > 2));
        // More than a few are the movement itself.
        if spikes.len() as f64 <= (limits::TAIL_PART * rows as f64).max(2.0) {
            fill(values, runs, &spikes.iter().map(|(row, _)| *row).collect::<Vec<_>>());
            found.extend(spikes);
        }
    }
    found.sort_by_key(|(row, _)| *row);
    Ok(found.iter().map(|one| listed(one, whole[one.0])).collect())
}

/// Codes for "no reading", and values beyond all measure.
fn gross(values: &[f64]) -> Vec<(usize, String)> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |part: f64| sorted[((sorted.len() - 1) as f64 * part) as usize];
    let (middle, spread) = (at(0.5), at(0.95) - at(0.05));
    if spread <= 0.0 {
        return Vec::new();
    }
    let of = |(row, value): (usize, &f64)| {
        let size = (value - middle).abs() / spread;
        let code = limits::CODES.contains(&value.abs()) && size > limits::BEYOND;
        let absurd = size > limits::ABSURD;
        let reason = if value.abs() > LARGEST {
            "beyond any quantity that is measured".to_string()
        } else {
            format!("{size:.0} times the column's spread (5 % to 95 %) away from its median {middle}")
        };
        (code || absurd).then_some((row, reason))
    };
    values.iter().enumerate().filter_map(of).collect()
}

/// Single positions far from the cubic through the two samples before and the two after.
fn spikes(values: &[f64], run: &Range<usize>) -> Vec<(usize, String)> {
    let y = &values[run.clone()];
    if y.len() < 2 * limits::AROUND {
        return Vec::new();
    }
    let n = y.len();
    let away = |k: usize| y[k] - (4.0 * (y[k - 1] + y[k + 1]) - y[k - 2] - y[k + 2]) / 6.0;
    let away: Vec<f64> = (0..n).map(|k| if k < 2 || k + 2 >= n { 0.0 } else { away(k) }).collect();
    (3..n - 3)
        .filter_map(|k| {
            let own = away[k];
            let image = |other: f64| (other / own + 2.0 / 3.0).abs() < limits::IMAGE;
            if own == 0.0 || !image(away[k - 1]) || !image(away[k + 1]) {
                return None;
            }
            let start = k.saturating_sub(limits::AROUND).min(n - 2 * limits::AROUND);
            let mut around: Vec<f64> = (start..start + 2 * limits::AROUND)
                .filter(|other| other.abs_diff(k) > 2)
                .map(|other| away[other].abs())
                .collect();
            around.sort_unstable_by(f64::total_cmp);
            // The 90 % quantile; more where the sixth largest shows that the movement itself has such peaks.
            let scatter = around[around.len() * 9 / 10].max(0.2 * around[around.len() - 6]);
            let size = own.abs() / scatter.max(f64::MIN_POSITIVE);
            let reason =
                || format!("{own:+.6} away from the samples before and after, {size:.0} times their scatter");
            (size > limits::SPIKE && scatter > 0.0).then(|| (run.start + k, reason()))
        })
        .collect()
}

/// Puts in the place of bad samples the cubic through the two good ones before and after, or the line between the nearest
/// good ones of the same run.
fn fill(values: &mut Values, runs: &[Range<usize>], bad: &[usize]) {
    for run in runs {
        for &row in bad.iter().filter(|row| run.contains(row)) {
            let good = |other: &usize| !bad.contains(other);
            let before = (run.start..row).rev().find(good);
            let after = (row + 1..run.end).find(good);
            let beside = [row.wrapping_sub(2), row.wrapping_sub(1), row + 1, row + 2];
            if beside.iter().all(|other| run.contains(other) && good(other)) {
                let [a, b, c, d] = beside.map(|other| values[other]);
                values[row] = (4.0 * (b + c) - a - d) / 6.0;
                continue;
            }
            values[row] = match (before, after) {
                (Some(a), Some(b)) => values[a] + (values[b] - values[a]) * (row - a) as f64 / (b - a) as f64,
                (Some(one), None) | (None, Some(one)) => values[one],
                (None, None) => values[row],
            };
        }
    }
}

/// First row, end and number of rows at which a read-out is cut off: it stands at its extreme for several
/// rows in a row, again and again, and gets there at speed. (A mechanism that rests arrives slowly.)
pub fn cut_off(column: &[f64]) -> Option<(usize, &'static str, usize)> {
    let moves: f64 = column.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
    let speed = (moves / column.len() as f64).sqrt();
    for (end, extreme) in [
        ("largest", column.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
        ("smallest", column.iter().copied().fold(f64::INFINITY, f64::min)),
    ] {
        let (mut rows, mut first, mut k) = (0, None, 0);
        while k < column.len() {
            let length = column[k..].iter().take_while(|v| **v == extreme).count();
            let abrupt = k > 0 && (column[k] - column[k - 1]).abs() > 0.25 * speed;
            if length >= limits::MOVING_CUT_OFF_ROWS && abrupt {
                rows += length;
                first = first.or(Some(k));
            }
            k += length.max(1);
        }
        if let Some(first) = first
            && rows as f64 > limits::MOVING_CUT_OFF * column.len() as f64
        {
            return Some((first, end, rows));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(rows: usize) -> Values {
        (0..rows).map(|k| (0.05 * k as f64).sin() + 1e-4 * (k as f64 * 12.9898).sin()).collect()
    }

    fn mended(values: &mut Values) -> Vec<BadRow> {
        let place = |row| Place { file: "r.csv".into(), line: row as u64 + 2, column: "position".into() };
        let runs = [0..values.len(); 1];
        mend(&place, values, &runs, true).unwrap()
    }

    #[test]
    fn a_code_and_a_spike_are_listed_and_replaced() {
        let clean = swing(1000);
        let mut values = clean.clone();
        values[400] = -9999.0;
        values[700] += 0.1;
        let listed = mended(&mut values);
        assert_eq!(listed.iter().map(|bad| bad.line).collect::<Vec<_>>(), [402, 702]);
        assert!((values[400] - clean[400]).abs() < 2e-3 && (values[700] - clean[700]).abs() < 2e-3);
    }

    #[test]
    fn steps_and_clean_samples_are_left_alone() {
        let mut values = swing(1000);
        values[500..].iter_mut().for_each(|value| *value += 0.5);
        let whole = values.clone();
        assert_eq!(mended(&mut values), []);
        assert_eq!(values, whole);
    }

    #[test]
    fn lent_samples_are_copied_only_where_one_is_replaced() {
        let lent = std::sync::Arc::new(swing(1000).into_vec());
        let mut values = Values::lent(lent.clone());
        assert_eq!(mended(&mut values), []);
        assert_eq!(values.as_ptr(), lent.as_ptr());
        values[400] = -9999.0;
        assert_eq!(mended(&mut values).len(), 1);
        assert_eq!(lent[..], swing(1000)[..]);
    }
}
