//! A channel that changes slowly (temperature, common mode) without its sensor's own noise. A dependence that is sought
//! on the noise too comes out too small, and in correlated noise, where only what changes from row to row counts, it is
//! lost. The channel is taken for a random walk in time, read with white noise; the ratio of the two is the likeliest
//! one, and every row gets what all rows say of it (Kalman filter and Rauch–Tung–Striebel smoother; Durbin & Koopman,
//! Time Series Analysis by State Space Methods, 2012, chapter 2: the local level model). A channel that is read without
//! noise stays as it is.

use crate::thresholds::slow_channel::{FEWEST_UPDATES, RATIOS, REPEATED};

/// One row as the filter leaves it.
struct Filtered {
    /// The level given this row and those before it.
    level: f64,
    /// Its variance, in that of the reading's noise.
    variance: f64,
    /// Variance of the step that leads to it.
    step: f64,
}

/// The channel at every row, from its `readings` at `t_s` (seconds, not decreasing).
pub fn without_noise(t_s: &[f64], readings: &[f64]) -> Vec<f64> {
    let mut gaps: Vec<f64> = t_s.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > 0.0).collect();
    if gaps.is_empty() {
        return readings.to_vec();
    }
    let typical = numerics::median(&mut gaps);
    let readings = &between_updates(t_s, readings, typical);
    let (low, high, count) = RATIOS;
    let ratio = |k: usize| low * (high / low).powf(k as f64 / (count - 1) as f64);
    let steps = |ratio: f64| move |i: usize| ratio * (t_s[i] - t_s[i - 1]).max(0.0) / typical;
    let best = (0..count)
        .map(|k| filter(readings, steps(ratio(k))))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map_or_else(Vec::new, |best| best.0);
    smooth(&best)
}

/// A channel that is read less often than the rows, each reading being repeated until the next, on straight lines from one
/// reading to the next; any other as it is. Levels that were set, and changed while nothing was recorded, stay.
fn between_updates(t_s: &[f64], readings: &[f64], typical: f64) -> Vec<f64> {
    let updates: Vec<usize> =
        (0..readings.len()).filter(|i| *i == 0 || readings[*i] != readings[*i - 1]).collect();
    let while_recording = updates[1..].iter().filter(|i| t_s[**i] - t_s[**i - 1] <= 2.0 * typical).count();
    if readings.len() < REPEATED * updates.len() || while_recording < FEWEST_UPDATES.max(updates.len() / 2) {
        return readings.to_vec();
    }
    let mut out = readings.to_vec();
    for w in updates.windows(2) {
        let (from, to) = (w[0], w[1]);
        let slope = (readings[to] - readings[from]) / (t_s[to] - t_s[from]).max(f64::MIN_POSITIVE);
        (from..to).for_each(|i| out[i] += slope * (t_s[i] - t_s[from]));
    }
    out
}

/// The filter with these variances of the steps, and the log likelihood of what it says at the noise that suits it
/// best (up to a constant).
fn filter(readings: &[f64], step: impl Fn(usize) -> f64) -> (Vec<Filtered>, f64) {
    let mut out = vec![Filtered { level: readings[0], variance: 1.0, step: 0.0 }];
    let (mut squares, mut log_variances) = (0.0, 0.0);
    for (i, reading) in readings.iter().enumerate().skip(1) {
        let before = &out[i - 1];
        let step = step(i);
        let predicted = before.variance + step;
        let surprise = reading - before.level;
        let scale = predicted + 1.0;
        squares += surprise * surprise / scale;
        log_variances += scale.ln();
        let level = before.level + surprise * predicted / scale;
        out.push(Filtered { level, variance: predicted / scale, step });
    }
    let freedom = (readings.len() - 1).max(1) as f64;
    (out, -0.5 * (freedom * squares.max(1e-300).ln() + log_variances))
}

/// What all rows say of each.
fn smooth(filtered: &[Filtered]) -> Vec<f64> {
    let mut levels: Vec<f64> = filtered.iter().map(|row| row.level).collect();
    for i in (0..filtered.len().saturating_sub(1)).rev() {
        let row = &filtered[i];
        let gain = row.variance / (row.variance + filtered[i + 1].step);
        levels[i] += gain * (levels[i + 1] - row.level);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::without_noise;
    use crate::correlation::tests::white;
    use numerics::rms;

    fn error(found: &[f64], truth: &[f64]) -> f64 {
        rms(&found.iter().zip(truth).map(|(a, b)| a - b).collect::<Vec<f64>>())
    }

    #[test]
    fn noise_goes_and_what_was_read_without_stays() {
        let n = 400;
        let t: Vec<f64> = (0..n).map(|i| 0.5 * i as f64 + if i < 200 { 0.0 } else { 30.0 }).collect();
        let wave: Vec<f64> = t.iter().map(|t| 22.0 + (t / 30.0).sin()).collect();
        let noisy: Vec<f64> = wave.iter().zip(white(n, 4)).map(|(w, e)| w + 0.1 * e).collect();
        // Some ten neighbours say the same of a row: a third of the noise is left, half generously.
        assert!(error(&without_noise(&t, &noisy), &wave) < 0.05);
        assert!(error(&without_noise(&t, &wave), &wave) < 2e-3);
    }

    #[test]
    fn a_held_reading_is_followed_between_its_updates() {
        let t: Vec<f64> = (0..300).map(|i| 3.0 * f64::from(i) + if i < 150 { 0.0 } else { 50.0 }).collect();
        let wave: Vec<f64> = t.iter().map(|t| 22.0 + 4.0 * (t / 150.0).sin()).collect();
        // Read once a minute.
        let held: Vec<f64> =
            t.iter().map(|t| 22.0 + 4.0 * ((t / 60.0).floor() * 60.0 / 150.0).sin()).collect();
        // 0 to 57 s late, 33 s in the root mean square, at 4 K/150 s/√2: 0.63 K. Straight lines leave a chord's 0.06 K and what
        // is not known after the last reading of all.
        assert!(error(&held, &wave) > 0.5);
        assert!(error(&without_noise(&t, &held), &wave) < 0.25);
        // Levels that are set between the passes are what they are.
        let levels: Vec<f64> = (0..300).map(|i| 20.0 + 5.0 * f64::from(i / 150)).collect();
        assert!(error(&without_noise(&t, &levels), &levels) < 0.02);
    }

    #[test]
    fn levels_keep_their_edges() {
        let t: Vec<f64> = (0..90).map(f64::from).collect();
        let levels: Vec<f64> = (0..90).map(|i| 20.0 + 5.0 * f64::from(i / 30)).collect();
        let noisy: Vec<f64> = levels.iter().zip(white(90, 5)).map(|(w, e)| w + 0.01 * e).collect();
        assert!(error(&without_noise(&t, &noisy), &levels) < 0.02);
    }
}
