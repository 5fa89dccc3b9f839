//! Where exactly a step falls. The observations that the search works on have gross outliers drawn towards the
//! model, and a row between the true and the supposed place of a high step looks like one: so its place is
//! looked for once more among the neighbouring rows, in the observations as they were read. What slips is as likely
//! to do so in any second: a gap of half a minute between two passes is where it fell unless the readings of a
//! fifth of a second beside it speak clearly against that.

use crate::noise::Noise;
use crate::thresholds::steps::{HIGH, OUTLIERS, REACH};

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
    // What is left, whitened, without the step, and with it after its first row and at it.
    let whitener = noise.whitener();
    let without = whitener.whiten(left);
    let after = whitener.whiten(&left.iter().map(|v| v - height).collect::<Vec<f64>>());
    let first = |k: usize| without[k] - height * whitener.weight(k);
    // A later beginning takes the step from one row more.
    let mut sum = 0.0;
    let mut out = vec![(from, 0.0)];
    for k in from..to {
        sum += cost(first(k)) + cost(after[k + 1]) - cost(without[k]) - cost(first(k + 1));
        out.push((k + 1, sum));
    }
    let best = out.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    out.iter_mut().for_each(|p| p.1 -= best);
    out
}

/// The row at which the step begins, the rows read at `t_s`: the likeliest within reach, `row` itself where it is
/// too low to tell.
pub fn beginning(left: &[f64], noise: &Noise, height: f64, row: usize, t_s: &[f64]) -> usize {
    let places = places(left, noise, height, row);
    let of = |(k, log_likelihood): &(usize, f64)| log_likelihood + (t_s[*k] - t_s[k - 1]).max(1e-9).ln();
    places.into_iter().max_by(|a, b| of(a).total_cmp(&of(b))).map_or(row, |p| p.0)
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
        assert_eq!(beginning(&left, &noise, 8.0, 35, &t), 33);
        assert_eq!(beginning(&left, &noise, 8.0, 30, &t), 33);
        // Too low to tell from single rows.
        assert!(places(&left, &noise, 0.1, 33).is_empty());
    }

    #[test]
    fn a_step_falls_into_a_pause_unless_the_readings_deny_it() {
        let n = 60;
        // Read every 0.2 s, with a pause of half a minute before row 30. The two readings before it lean towards
        // the step by more than half its height.
        let t: Vec<f64> = (0..n).map(|i| 0.2 * i as f64 + if i < 30 { 0.0 } else { 30.0 }).collect();
        let scatter = |i: usize| ((i * 7919 % 101) as f64 / 50.5 - 1.0) * 1.7;
        let lean = |i: usize, by: f64| if i == 28 || i == 29 { by } else { scatter(i) };
        let seen =
            |by: f64| -> Vec<f64> { (0..n).map(|i| lean(i, by) + if i >= 30 { 4.0 } else { 0.0 }).collect() };
        let step: Vec<f64> = (0..n).map(|i| if i >= 30 { 1.0 } else { 0.0 }).collect();
        let noise = estimate(&seen(0.0), &t, &[vec![1.0; n], step], &[], &[], &[]);
        let likeliest = |left: &[f64]| {
            places(left, &noise, 4.0, 30).into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|p| p.0)
        };
        assert_eq!(likeliest(&seen(2.3)), Some(28));
        assert_eq!(beginning(&seen(2.3), &noise, 4.0, 30, &t), 30);
        assert_eq!(beginning(&seen(4.0), &noise, 4.0, 30, &t), 28);
    }

    #[test]
    fn in_correlated_noise_one_reading_decides() {
        let n = 120;
        let t: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let white = crate::correlation::tests::white(n, 3);
        let correlation =
            crate::correlation::Correlation::none(&t).with(&crate::correlation::Process::slow(1.0, 30.0));
        let wander = correlation.colour(white.into_iter());
        let left: Vec<f64> =
            wander.iter().enumerate().map(|(i, e)| e + if i >= 60 { 3.0 } else { 0.0 }).collect();
        let mut noise = estimate(&wander, &t, &[vec![1.0; n]], &[], &[], &[]);
        noise.sigma = vec![1.0; n];
        noise.level = 1.0;
        noise.correlation = correlation;
        for near in [52, 57, 60, 63, 68] {
            assert_eq!(beginning(&left, &noise, 3.0, near, &t), 60);
        }
    }
}
