//! Long recordings are searched on cell means: a cell is a range of the angle, a direction, and a group of
//! successive passes. A mismatch that a mean over such a cell would lose (a period shorter than a cell) is
//! below what the search looks for; the noise floor is then that of the means, and is scaled back to rows.

use crate::rows::Rows;

/// Rows above which a recording is condensed, and about how many cells are made of it.
pub const MOST_ROWS: usize = 1100;
/// Fewest ranges of the angle in a pass.
const FEWEST_RANGES: usize = 72;

/// A condensed recording and how many rows are in a cell on average.
pub struct Condensed {
    /// The cells as rows.
    pub rows: Rows,
    /// Mean number of rows per cell.
    pub per_cell: f64,
}

/// Condenses a recording that is too long to be searched row by row; `None` where it is not.
pub fn condense(rows: &Rows) -> Option<Condensed> {
    let n = rows.len();
    if n <= MOST_ROWS {
        return None;
    }
    // Index of the pass in order of appearance, row by row.
    let mut index = Vec::with_capacity(n);
    let mut current = 0;
    for i in 0..n {
        if i > 0 && rows.pass[i] != rows.pass[i - 1] {
            current += 1;
        }
        index.push(current);
    }
    let passes = current + 1;
    let ranges = (MOST_ROWS / passes).max(FEWEST_RANGES).min((n / passes).max(1));
    let ranges = even_ranges(n / passes, ranges);
    let group = (passes * ranges).div_ceil(MOST_ROWS).max(1);
    let limits = limits(&rows.theta, ranges);
    let groups = passes.div_ceil(group);
    // Cell number: group, then forward cells upward, then backward cells downward, so that the order of the
    // cells is a path that the mirror could have taken.
    let cell_of = |i: usize| {
        let k = limits.partition_point(|limit| *limit <= rows.theta[i]);
        let place = if rows.direction[i] >= 0.0 { k } else { 2 * ranges - 1 - k };
        (index[i] / group) * 2 * ranges + place
    };
    let mut count = vec![0_u32; groups * 2 * ranges];
    let cells: Vec<usize> = (0..n).map(cell_of).collect();
    cells.iter().for_each(|&c| count[c] += 1);
    let kept: Vec<usize> = (0..count.len()).filter(|&c| count[c] > 0).collect();
    let mut position = vec![usize::MAX; count.len()];
    kept.iter().enumerate().for_each(|(k, &c)| position[c] = k);
    let average = |values: &[f64]| -> Vec<f64> {
        let mut sums = vec![0.0; kept.len()];
        for (v, &c) in values.iter().zip(&cells) {
            sums[position[c]] += v;
        }
        sums.iter().zip(&kept).map(|(s, &c)| s / f64::from(count[c])).collect()
    };
    let pass = kept.iter().map(|c| (c / ranges) as i64).collect();
    let mut condensed = rows.changed(pass, average);
    condensed.direction.iter_mut().for_each(|d| *d = if *d >= 0.0 { 1.0 } else { -1.0 });
    // Within a group of passes the cells' mean times are mixed: keep them from running backward.
    for k in 1..condensed.len() {
        condensed.t_s[k] = condensed.t_s[k].max(condensed.t_s[k - 1]);
    }
    Some(Condensed { per_cell: n as f64 / condensed.len() as f64, rows: condensed })
}

/// The number of ranges, from `wanted` to twice as many, that cuts a pass of `length` readings into equal parts:
/// where angles repeat from pass to pass, uneven cells would make a pattern of their own.
fn even_ranges(length: usize, wanted: usize) -> usize {
    (wanted..2 * wanted).find(|r| length.is_multiple_of(*r)).unwrap_or(wanted)
}

/// Limits between ranges that hold equally many rows: half way between the rows on either side.
fn limits(theta: &[f64], ranges: usize) -> Vec<f64> {
    let mut sorted = theta.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    (1..ranges)
        .map(|k| {
            let first = k * sorted.len() / ranges;
            0.5 * (sorted[first - 1] + sorted[first])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{MOST_ROWS, condense, even_ranges, limits};
    use crate::rows::{Rows, mean};

    #[test]
    fn cells_keep_the_mean_and_the_path() {
        let n = 40_000;
        let sweep = |i: usize| {
            let k = i % 400;
            if k < 200 { k as f64 } else { 399.0 - k as f64 }
        };
        let column: Vec<f64> = (0..n).map(|i| (i as f64 * 0.37).sin()).collect();
        let rows = Rows {
            t_s: (0..n).map(|i| i as f64).collect(),
            pass: (0..n).map(|i| (i / 200) as i64).collect(),
            direction: (0..n).map(|i| if i % 400 < 200 { 1.0 } else { -1.0 }).collect(),
            reading: (0..n).map(sweep).collect(),
            theta: (0..n).map(sweep).collect(),
            truth: column.clone(),
            error: column.clone(),
            weight: vec![1.0; n],
            ..Rows::default()
        };
        let Some(condensed) = condense(&rows) else { panic!("not condensed") };
        assert!(condensed.rows.len() <= 2 * MOST_ROWS);
        // The cells are not all of one size, so that the mean of means is near, not equal.
        assert!((mean(&condensed.rows.error) - mean(&column)).abs() < 0.02);
        assert!(condensed.rows.t_s.windows(2).all(|w| w[1] >= w[0]));
    }

    #[test]
    fn ranges_cut_a_pass_evenly_where_they_can() {
        assert_eq!(even_ranges(500, 72), 100);
        assert_eq!(even_ranges(210, 100), 105);
        // No divisor of a prime: as many as wanted.
        assert_eq!(even_ranges(997, 72), 72);
        let theta: Vec<f64> = (0..12).map(|i| f64::from(i % 6)).collect();
        assert_eq!(limits(&theta, 3), vec![1.5, 3.5]);
    }
}
