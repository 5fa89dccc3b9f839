//! What a line over the time through the rows before and after says of a row: for channels that change fast and
//! evenly, as a temperature.

use super::limits;
use super::scale::trimmed;

/// Every row less the line through `window` rows before and after, less that through the rows before, and through the
/// rows after; NaN where there are none. Beside a pause and at the ends of the recording the first is the line of one
/// side, and what it leaves is divided by how much worse such a line predicts.
pub fn less_line(values: &[f64], time: &[f64], window: usize) -> [Vec<f64>; 3] {
    let n = values.len();
    let mut gaps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let pause = limits::PAUSE * super::scale::median(&mut gaps);
    let continues = |from: usize, to: usize| (from..to).all(|k| (time[k + 1] - time[k]).abs() <= pause);
    let before = |row: usize| row >= 2 * window && continues(row - 2 * window, row);
    let after = |row: usize| row + 2 * window < n && continues(row, row + 2 * window);
    let beside = |row: usize| row >= window && row + window < n && continues(row - window, row + window);
    let beside: Vec<Option<f64>> = (0..n)
        .map(|row| beside(row).then(|| less(values, time, row, row - window..row + window + 1)))
        .collect();
    let before: Vec<Option<f64>> =
        (0..n).map(|row| before(row).then(|| less(values, time, row, row - 2 * window..row))).collect();
    let after: Vec<Option<f64>> = (0..n)
        .map(|row| after(row).then(|| less(values, time, row, row + 1..row + 2 * window + 1)))
        .collect();
    let size = |way: &[Option<f64>]| {
        let mut absolute: Vec<f64> =
            way.iter().flatten().filter(|r| r.is_finite()).map(|r| r.abs()).collect();
        trimmed(&mut absolute).max(f64::MIN_POSITIVE)
    };
    let (usual, worse) = (size(&beside), [size(&before), size(&after)]);
    let both = (0..n)
        .map(|row| match beside[row] {
            Some(away) => away,
            None => [before[row].map(|a| a * usual / worse[0]), after[row].map(|a| a * usual / worse[1])]
                .into_iter()
                .flatten()
                .min_by(|a, b| a.abs().total_cmp(&b.abs()))
                .unwrap_or(0.0),
        })
        .collect();
    let blank = |way: Vec<Option<f64>>| way.into_iter().map(|away| away.unwrap_or(f64::NAN)).collect();
    [both, blank(before), blank(after)]
}

/// The value of a row less the least-squares line through the others of a range.
fn less(values: &[f64], time: &[f64], row: usize, range: std::ops::Range<usize>) -> f64 {
    let (mut count, mut t, mut y, mut tt, mut ty) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for k in range.filter(|k| *k != row && values[*k].is_finite()) {
        let (dt, value) = (time[k] - time[row], values[k]);
        count += 1.0;
        t += dt;
        y += value;
        tt += dt * dt;
        ty += dt * value;
    }
    let determinant = count * tt - t * t;
    if count < 3.0 || determinant <= 1e-9 * count * tt {
        return values[row] - if count > 0.0 { y / count } else { values[row] };
    }
    values[row] - (tt * y - t * ty) / determinant
}
