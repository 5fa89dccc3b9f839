//! What the rows before and after say of a row where the channel follows a trend: level and slope, both of which may
//! wander, seen through the scatter of single readings (local linear trend; Harvey, Forecasting, Structural Time Series
//! Models, 1989, section 4.5). How much they wander is what predicts the rows best. A pause lets both wander the longer, and at the
//! ends of a recording only one side speaks: every prediction comes with its own uncertainty.

use super::limits;
use super::scale::{median, trimmed};

/// How far level and slope wander from one row to the next, in variances of a single reading.
const LEVELS: [f64; 4] = [0.0, 0.1, 1.0, 10.0];
const SLOPES: [f64; 5] = [0.0, 1e-4, 1e-2, 1.0, 30.0];
/// Variances of level and slope before anything is known, in those of a reading (and of intervals).
const UNKNOWN: (f64, f64) = (1e12, 1e8);

/// How far level and slope wander within a second.
#[derive(Clone, Copy)]
struct Wander {
    level: f64,
    slope: f64,
    /// The usual interval.
    interval: f64,
}

/// What is known of level and slope at a row without its own reading.
#[derive(Clone, Copy)]
struct Known {
    level: f64,
    slope: f64,
    /// Variances of the level, of both, of the slope.
    variance: [f64; 3],
}

/// Every row less what the rows on both sides say, less what those before say, and less what those after say; NaN
/// where one side knows too little. What both leave is divided by how much less certain the prediction is there than
/// usual.
pub fn less_trend(values: &[f64], time: &[f64]) -> [Vec<f64>; 3] {
    let n = values.len();
    let mut gaps: Vec<f64> = time.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|gap| *gap > 0.0).collect();
    let interval = if gaps.is_empty() { 1.0 } else { median(&mut gaps) };
    let wander = wander(values, time, interval);
    let before = predicted(values, time, wander, 0..n);
    let mut after = predicted(values, time, wander, (0..n).rev());
    after.reverse();
    let both: Vec<(f64, f64)> = before.iter().zip(&after).map(|(b, a)| together(*b, *a)).collect();
    let deviation = |variance: f64| (1.0 + variance).sqrt();
    let usual = median(&mut both.iter().map(|(_, variance)| deviation(*variance)).collect::<Vec<f64>>());
    let one = |side: &[Known]| {
        (side.iter().zip(values))
            .map(|(known, value)| {
                let knows = deviation(known.variance[0]) <= limits::SIDE * usual;
                if knows { value - known.level } else { f64::NAN }
            })
            .collect()
    };
    let all = (both.iter().zip(values))
        .map(|((level, variance), value)| (value - level) * usual / deviation(*variance))
        .collect();
    [all, one(&before), one(&after)]
}

/// The wandering by which every row is best predicted from those before: the least product of the predictions' own
/// deviations and of what their standardised errors scatter, of which a tenth may be anything.
fn wander(values: &[f64], time: &[f64], interval: f64) -> Wander {
    let all = LEVELS.iter().flat_map(|level| SLOPES.iter().map(move |slope| (*level, *slope)));
    let all = all.map(|(level, slope)| Wander {
        level: level / interval,
        slope: slope / interval.powi(3),
        interval,
    });
    // Of a long recording a part tells enough.
    let first = values.len().saturating_sub(limits::TREND_ROWS) / 2;
    let part = first..values.len().min(first + limits::TREND_ROWS);
    let cost = |wander: &Wander| {
        let (values, time) = (&values[part.clone()], &time[part.clone()]);
        let known = predicted(values, time, *wander, 0..values.len());
        let (mut errors, mut logarithms) = (Vec::new(), 0.0);
        for (known, value) in known.iter().zip(values).skip(2).filter(|(_, value)| value.is_finite()) {
            let variance = 1.0 + known.variance[0];
            errors.push((value - known.level).abs() / variance.sqrt());
            logarithms += 0.5 * variance.ln();
        }
        let count = errors.len().max(1) as f64;
        trimmed(&mut errors).max(f64::MIN_POSITIVE).ln() + logarithms / count
    };
    all.map(|wander| (cost(&wander), wander))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(Wander { level: 0.0, slope: 0.0, interval }, |best| best.1)
}

/// What the rows that come earlier in `order` say of each; in that order.
fn predicted(values: &[f64], time: &[f64], wander: Wander, order: impl Iterator<Item = usize>) -> Vec<Known> {
    let nothing = [UNKNOWN.0, 0.0, UNKNOWN.1 / wander.interval.powi(2)];
    let mut now = Known { level: 0.0, slope: 0.0, variance: nothing };
    let mut last: Option<usize> = None;
    let mut predicted = Vec::with_capacity(values.len());
    for row in order {
        if let Some(last) = last {
            let passed = (time[row] - time[last]).abs();
            let [p, c, s] = now.variance;
            now.level += passed * now.slope;
            now.variance = [
                p + passed * (2.0 * c + passed * s)
                    + wander.level * passed
                    + wander.slope * passed.powi(3) / 3.0,
                c + passed * s + wander.slope * passed.powi(2) / 2.0,
                s + wander.slope * passed,
            ];
        }
        last = Some(row);
        predicted.push(now);
        if values[row].is_finite() {
            let [p, c, s] = now.variance;
            let (error, total) = (values[row] - now.level, p + 1.0);
            now.level += p / total * error;
            now.slope += c / total * error;
            now.variance = [p / total, c / total, s - c * c / total];
        }
    }
    predicted
}

/// Level and variance of what two sides say together; the slope of the one that comes from the end is in its time.
fn together(before: Known, after: Known) -> (f64, f64) {
    let inverse = |known: Known, sign: f64| {
        let [p, c, s] = known.variance;
        let determinant = (p * s - c * c).max(f64::MIN_POSITIVE);
        let [a, b, d] = [s / determinant, -sign * c / determinant, p / determinant];
        ([a, b, d], [a * known.level + b * sign * known.slope, b * known.level + d * sign * known.slope])
    };
    let ([a1, b1, d1], [x1, y1]) = inverse(before, 1.0);
    let ([a2, b2, d2], [x2, y2]) = inverse(after, -1.0);
    let ([a, b, d], [x, y]) = ([a1 + a2, b1 + b2, d1 + d2], [x1 + x2, y1 + y2]);
    let determinant = a * d - b * b;
    ((d * x - b * y) / determinant, d / determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve of twenty readings' scatter over ten rows, with a pause, and one reading that is off.
    #[test]
    fn follows_a_curve_over_a_pause_and_leaves_what_is_off() {
        let time: Vec<f64> = (0..120).map(|k| f64::from(k) + if k < 60 { 0.0 } else { 10.0 }).collect();
        let scatter = |k: usize| [0.3, -1.1, 0.8, 0.9, -0.7, -0.2, 0.4, -0.5, 1.2, -1.0, 0.1][(7 * k) % 11];
        let mut values: Vec<f64> =
            time.iter().enumerate().map(|(k, t)| 200.0 * (t / 30.0).sin() + scatter(k)).collect();
        let whole = less_trend(&values, &time)[0].clone();
        assert!(whole.iter().all(|away| away.abs() < 4.0), "{whole:?}");
        for row in [0, 30, 59, 60, 119] {
            let mut off = values.clone();
            off[row] += 15.0;
            let [both, before, after] = less_trend(&off, &time);
            let largest = (0..120).max_by(|a, b| both[*a].abs().total_cmp(&both[*b].abs()));
            assert_eq!(largest, Some(row), "{both:?}");
            assert_eq!(
                (before[row].is_nan(), after[row].is_nan()),
                (row == 0 || row == 60, row == 59 || row == 119)
            );
        }
        // After a step those on one side agree.
        values[30..].iter_mut().for_each(|value| *value += 50.0);
        let [_, before, after] = less_trend(&values, &time);
        assert!(before[30] > 30.0 && after[30].abs() < 10.0);
    }
}
