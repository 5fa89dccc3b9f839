//! Long recordings are searched on means of neighbouring rows. Where the sensor moves slowly a cell is a block of
//! successive rows of one pass and direction; where it moves fast, in many passes, a range of the angle, a direction
//! and a group of successive passes. A mismatch that a mean over such a cell would lose (a period shorter than a cell)
//! is below what the search looks for. What is handed on is fitted to the rows again, and every figure is of rows.

use numerics::range;

use crate::rows::Rows;
use crate::thresholds::condense::{COARSEST_BLOCK, FEWEST_GROUPS, FEWEST_RANGES, MOST_ROWS, MOST_ROWS_APART};

/// A condensed recording.
pub struct Condensed {
    /// The cells as rows.
    pub rows: Rows,
    /// The cell of every row.
    pub cell_of: Vec<usize>,
}

impl Condensed {
    /// A recording that is searched row by row.
    pub fn none(rows: &Rows) -> Condensed {
        Condensed { rows: rows.clone(), cell_of: (0..rows.len()).collect() }
    }

    /// Standard deviation of a single reading, where the noise of a cell's mean has the standard deviation `of_means`:
    /// with the scatter of the rows about a line through their cell.
    pub fn of_rows(cells: &Rows, cell_of: &[usize], full: &Rows, of_means: f64) -> f64 {
        if full.len() == cells.len() {
            return of_means;
        }
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); cells.len()];
        cell_of.iter().enumerate().for_each(|(row, cell)| members[*cell].push(row));
        // Two rows always lie on a line: with those of the next cell of their pass they scatter about one.
        let place = |row: usize| (full.pass[row], full.direction[row] > 0.0);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for rows in members {
            match groups.last_mut() {
                Some(last) if last.len() <= 2 && place(last[0]) == place(rows[0]) => last.extend(rows),
                _ => groups.push(rows),
            }
        }
        let groups: Vec<Vec<usize>> = groups.into_iter().filter(|rows| rows.len() > 2).collect();
        let freedom: usize = groups.iter().map(|rows| rows.len() - 2).sum();
        let about_lines = |place: &[f64]| -> f64 {
            let about_one = |rows: &Vec<usize>| {
                let n = rows.len() as f64;
                let mean = |v: &[f64]| rows.iter().map(|row| v[*row]).sum::<f64>() / n;
                let (x, y) = (mean(place), mean(&full.error));
                let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
                for row in rows {
                    let (dx, dy) = (place[*row] - x, full.error[*row] - y);
                    (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
                }
                yy - if xx > 0.0 { xy * xy / xx } else { 0.0 }
            };
            groups.iter().map(about_one).sum()
        };
        // The error is the one less the other: where either stands still in a cell, the other's noise is on a line with it.
        let squares = about_lines(&full.theta).max(about_lines(&full.truth));
        let per_cell = full.len() as f64 / cells.len() as f64;
        // Of the scatter within a cell its mean keeps a part already.
        let within = if freedom > 0 { squares / freedom as f64 * (1.0 - 1.0 / per_cell) } else { 0.0 };
        (of_means * of_means + within.max(0.0)).sqrt()
    }
}

/// Condenses a recording that is too long to be searched row by row.
pub fn condense(rows: &Rows) -> Condensed {
    if rows.len() <= MOST_ROWS {
        return Condensed::none(rows);
    }
    if let Some(condensed) = blocks(rows) {
        return condensed;
    }
    if rows.len() <= MOST_ROWS_APART { Condensed::none(rows) } else { ranges_of_angle(rows) }
}

/// Blocks of successive rows; none where they would move too far.
fn blocks(rows: &Rows) -> Option<Condensed> {
    let length = rows.len().div_ceil(MOST_ROWS);
    let mut cell_of = Vec::with_capacity(rows.len());
    let mut first = 0;
    let mut cell = 0;
    for i in 0..rows.len() {
        let apart = i > 0 && (rows.pass[i] != rows.pass[i - 1] || rows.direction[i] != rows.direction[i - 1]);
        if i > 0 && (apart || i - first == length) {
            cell += 1;
            first = i;
        }
        cell_of.push(cell);
    }
    if cell >= 2 * MOST_ROWS {
        return None;
    }
    let mut spans: Vec<f64> = Vec::with_capacity(cell + 1);
    for members in cell_of.chunk_by(|a, b| a == b).scan(0, |at, members| {
        *at += members.len();
        Some(*at - members.len()..*at)
    }) {
        let (low, high) = range(&rows.theta[members]);
        spans.push(high - low);
    }
    let (low, high) = rows.stroke();
    let coarse = spans.iter().filter(|span| **span > COARSEST_BLOCK * (high - low)).count();
    if coarse * 10 > spans.len() {
        return None;
    }
    let mut pass = vec![0; cell + 1];
    cell_of.iter().zip(&rows.pass).for_each(|(cell, p)| pass[*cell] = *p);
    Some(averaged(rows, cell_of, pass))
}

/// The means over the cells, which are numbered without gaps.
fn averaged(rows: &Rows, cell_of: Vec<usize>, pass: Vec<i64>) -> Condensed {
    let mut count = vec![0_u32; pass.len()];
    cell_of.iter().for_each(|cell| count[*cell] += 1);
    let average = |values: &[f64]| -> Vec<f64> {
        let mut sums = vec![0.0; count.len()];
        for (v, cell) in values.iter().zip(&cell_of) {
            sums[*cell] += v;
        }
        sums.iter().zip(&count).map(|(s, n)| s / f64::from(*n)).collect()
    };
    let mut condensed = Rows { means: true, ..rows.changed(pass, average) };
    condensed.direction.iter_mut().for_each(|d| *d = if *d >= 0.0 { 1.0 } else { -1.0 });
    Condensed { rows: condensed, cell_of }
}

/// Ranges of the angle, by direction, in groups of successive passes.
fn ranges_of_angle(rows: &Rows) -> Condensed {
    let n = rows.len();
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
    // To the nearest: some rows may have been left out.
    let length = (n + passes / 2) / passes;
    let ranges = (MOST_ROWS / passes).max(FEWEST_RANGES).min(length.max(1));
    let ranges = even_ranges(length, ranges);
    // A group has cells of either direction: of one pass and of two there are equally many.
    let least = (passes * ranges).div_ceil(MOST_ROWS).max(1);
    let group = if least > 1 && passes >= 2 * least * FEWEST_GROUPS { 2 * least } else { least };
    let limits = limits(&rows.theta, ranges);
    let groups = passes.div_ceil(group);
    // Cell number: group, then forward cells upward, then backward cells downward, so that the order of the
    // cells is a path that the mirror could have taken.
    let cell_at = |i: usize| {
        let k = limits.partition_point(|limit| *limit <= rows.theta[i]);
        let place = if rows.direction[i] >= 0.0 { k } else { 2 * ranges - 1 - k };
        (index[i] / group) * 2 * ranges + place
    };
    let cells: Vec<usize> = (0..n).map(cell_at).collect();
    let mut taken = vec![false; groups * 2 * ranges];
    cells.iter().for_each(|&c| taken[c] = true);
    let kept: Vec<usize> = (0..taken.len()).filter(|&c| taken[c]).collect();
    let mut position = vec![usize::MAX; taken.len()];
    kept.iter().enumerate().for_each(|(k, &c)| position[c] = k);
    let pass = kept.iter().map(|c| (c / ranges) as i64).collect();
    let mut condensed = averaged(rows, cells.iter().map(|c| position[*c]).collect(), pass);
    // Within a group of passes the cells' mean times are mixed: keep them from running backward.
    let cells = &mut condensed.rows;
    for k in 1..cells.len() {
        cells.t_s[k] = cells.t_s[k].max(cells.t_s[k - 1]);
    }
    condensed
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
    use super::{Condensed, MOST_ROWS, even_ranges, limits, ranges_of_angle};
    use crate::rows::Rows;
    use numerics::mean;

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
        let condensed = ranges_of_angle(&rows);
        assert!(condensed.rows.len() <= 2 * MOST_ROWS);
        // The cells are not all of one size, so that the mean of means is near, not equal.
        assert!((mean(&condensed.rows.error) - mean(&column)).abs() < 0.02);
        assert!(condensed.rows.t_s.windows(2).all(|w| w[1] >= w[0]));
    }

    /// Two thousand rows in ten passes, whose errors are `error`; the reference stands where `truth` says.
    fn ten_passes(truth: Vec<f64>, error: Vec<f64>) -> Rows {
        let n = truth.len();
        Rows {
            t_s: (0..n).map(|i| i as f64).collect(),
            pass: (0..n).map(|i| (i * 10 / n) as i64).collect(),
            direction: vec![1.0; n],
            theta: truth.iter().zip(&error).map(|(t, e)| t + e).collect(),
            truth,
            error,
            ..Rows::default()
        }
    }

    #[test]
    fn cells_hold_whole_places_also_where_a_row_was_left_out() {
        let (passes, places) = (300, 35);
        let mut place: Vec<usize> = (0..passes * places).map(|i| i % places).collect();
        place.remove(500);
        let n = place.len();
        let noise = crate::correlation::tests::white(n, 7);
        let rows = Rows {
            t_s: (0..n).map(|i| i as f64).collect(),
            pass: (0..n).map(|i| ((i + usize::from(i >= 500)) / places) as i64).collect(),
            direction: vec![1.0; n],
            theta: place.iter().zip(&noise).map(|(p, e)| *p as f64 + 0.01 * e).collect(),
            truth: place.iter().map(|p| *p as f64).collect(),
            error: noise,
            ..Rows::default()
        };
        let condensed = ranges_of_angle(&rows);
        let whole = |truth: &f64| (truth - truth.round()).abs() < 0.1;
        assert!(condensed.rows.truth.iter().all(whole), "{:?}", condensed.rows.truth);
    }

    #[test]
    fn the_noise_of_a_reading_is_that_of_its_cells_of_two_and_within_them() {
        let n = 2000;
        let noise = crate::correlation::tests::white(n, 5);
        let truth: Vec<f64> = (0..n).map(|i| 100.0 * (i % 200) as f64).collect();
        let error = truth.iter().zip(&noise).map(|(x, e)| 0.003 * x + e).collect();
        let rows = ten_passes(truth, error);
        let cell_of: Vec<usize> = (0..n).map(|i| i / 2).collect();
        let cells = Rows { t_s: vec![0.0; n / 2], ..Rows::default() };
        let found = Condensed::of_rows(&cells, &cell_of, &rows, 0.5_f64.sqrt());
        assert!((found - 1.0).abs() < 0.03, "{found}");
    }

    #[test]
    fn the_noise_within_cells_at_one_angle_is_no_slope() {
        let (n, cells) = (2000, 20);
        let truth: Vec<f64> = (0..n).map(|i| 100.0 * (i % cells) as f64).collect();
        let rows = ten_passes(truth, crate::correlation::tests::white(n, 5));
        let cell_of: Vec<usize> = (0..n).map(|i| i % cells).collect();
        let means = Rows { t_s: vec![0.0; cells], ..Rows::default() };
        let found = Condensed::of_rows(&means, &cell_of, &rows, 0.1);
        assert!((found - 1.0).abs() < 0.03, "{found}");
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
