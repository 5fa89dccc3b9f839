//! Where exactly a step falls. The observations that the search works on have gross outliers drawn towards the
//! model, and a row between the true and the supposed place of a high step looks like one: so its place is
//! looked for once more among the neighbouring rows, in the observations as they were read.

use crate::noise::Noise;

/// Rows to either side that are looked at.
const REACH: usize = 10;
/// Height in σ of a reading from which the single row decides.
pub const HIGH: f64 = 2.5;
/// Part of the readings that may be gross outliers, and how many times wider they scatter.
const OUTLIERS: (f64, f64) = (0.05, 6.0);

/// −ln of the density of a standardised residual, outliers allowed for (up to a constant).
fn cost(z: f64) -> f64 {
    let (part, wider) = OUTLIERS;
    let w = z / wider;
    -((1.0 - part) * (-0.5 * z * z).exp() + part / wider * (-0.5 * w * w).exp()).ln()
}

/// Log likelihood of a step of `height` that begins at each row within reach of `row`, relative to the best:
/// (row, log likelihood). `left` is what the observations leave without the step. Empty where the step is
/// too low for single rows to decide.
pub fn places(left: &[f64], noise: &Noise, height: f64, row: usize) -> Vec<(usize, f64)> {
    let n = left.len();
    if row == 0 || row >= n || height.abs() < HIGH * noise.level {
        return Vec::new();
    }
    let (from, to) = (row.saturating_sub(REACH).max(1), (row + REACH).min(n - 1));
    // A later beginning takes the step from one row more.
    let mut sum = 0.0;
    let mut out = vec![(from, 0.0)];
    for (i, (left, sigma)) in left.iter().zip(&noise.sigma).enumerate().take(to).skip(from) {
        sum += cost((left - height) / sigma) - cost(left / sigma);
        out.push((i + 1, sum));
    }
    let best = out.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    out.iter_mut().for_each(|p| p.1 -= best);
    out
}

/// The row at which the step begins: the likeliest within reach, `row` itself where it is too low to tell.
pub fn beginning(left: &[f64], noise: &Noise, height: f64, row: usize) -> usize {
    places(left, noise, height, row).into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(row, |p| p.0)
}

#[cfg(test)]
mod tests {
    use super::{beginning, cost, places};
    use crate::noise::estimate;

    #[test]
    fn the_cost_falls_with_the_density() {
        assert!(cost(0.0) < cost(2.0) && cost(2.0) < cost(6.0));
        // An outlier costs far less than its square.
        assert!(cost(10.0) - cost(0.0) < 12.0);
    }

    #[test]
    fn a_step_is_found_two_rows_off() {
        let n = 60;
        let scatter = |i: usize| ((i * 7919 % 101) as f64 / 50.5 - 1.0) * 1.7;
        let left: Vec<f64> = (0..n).map(|i| scatter(i) + if i >= 33 { 8.0 } else { 0.0 }).collect();
        let t: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let step: Vec<f64> = (0..n).map(|i| if i >= 33 { 1.0 } else { 0.0 }).collect();
        let noise = estimate(&left, &t, &[vec![1.0; n], step], &[], &[], &[]);
        assert_eq!(beginning(&left, &noise, 8.0, 35), 33);
        assert_eq!(beginning(&left, &noise, 8.0, 30), 33);
        // Too low to tell from single rows.
        assert!(places(&left, &noise, 0.1, 33).is_empty());
    }
}
