//! Residual statistics before and after the correction, over all readings and per calibration point.

use crate::points::Points;
use crate::weights::{Scatter, Variance};

pub use crate::coefficients::{PointStatistics, Spread, Statistics};

/// Mean and sum of squared deviations of each point's values, in their unit (Welford's recurrence).
#[derive(Debug, Clone)]
pub struct PointMoments {
    /// One mean for each point.
    pub mean: Vec<f64>,
    squares: Vec<f64>,
    count: Vec<usize>,
}

impl PointMoments {
    /// Those of `value`, which is given for each row.
    pub fn of(points: &Points, value: impl Fn(usize) -> f64) -> PointMoments {
        let count = points.count();
        let mut moments =
            PointMoments { mean: vec![0.0; count], squares: vec![0.0; count], count: vec![0; count] };
        for (row, point) in points.of_row.iter().enumerate() {
            let point = *point as usize;
            moments.count[point] += 1;
            let step = value(row) - moments.mean[point];
            moments.mean[point] += step / moments.count[point] as f64;
            moments.squares[point] += step * (value(row) - moments.mean[point]);
        }
        moments
    }

    /// One variance for each point.
    pub fn variances(&self) -> Vec<Variance> {
        (self.squares.iter().zip(&self.count))
            .map(|(squares, count)| {
                let freedom = count - 1;
                Variance { value: if freedom > 0 { squares / freedom as f64 } else { 0.0 }, freedom }
            })
            .collect()
    }
}

fn spread(points: &Points, means: &[f64], value: impl Fn(usize) -> f64) -> Spread {
    let rows = points.of_row.len();
    let (mut squares, mut sum, mut max) = (0.0, 0.0, 0.0f64);
    for row in 0..rows {
        let value = value(row);
        squares += value * value;
        sum += value;
        max = max.max(value.abs());
    }
    Spread {
        rms: readable((squares / rows as f64).sqrt()),
        max: readable(max),
        mean: readable(sum / rows as f64),
        max_of_point_means: readable(means.iter().fold(0.0, |max, mean| mean.abs().max(max))),
    }
}

/// Statistics of errors and residuals given in the internal unit; `scale` turns it into `unit`.
pub(crate) fn statistics(
    points: &Points,
    error: &[f64],
    residual: &[f64],
    scale: f64,
    unit: &str,
    between_passes: Option<Scatter>,
) -> Statistics {
    let before = PointMoments::of(points, |row| scale * error[row]);
    let after = PointMoments::of(points, |row| scale * residual[row]);
    let deviations = after.variances();
    Statistics {
        unit: unit.to_string(),
        before: spread(points, &before.mean, |row| scale * error[row]),
        after: spread(points, &after.mean, |row| scale * residual[row]),
        between_passes,
        points_are: points.grouping.name().to_string(),
        points: (0..points.count())
            .map(|point| PointStatistics {
                reading: readable(points.reading[point]),
                readings: points.rows[point],
                mean_before: readable(before.mean[point]),
                mean_after: readable(after.mean[point]),
                standard_deviation: (deviations[point].freedom > 0)
                    .then(|| readable(deviations[point].value.sqrt())),
            })
            .collect(),
    }
}

/// The smallest and the largest value; infinite, and the other way round, of none.
pub(crate) fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// A descriptive figure to nine significant digits: more than it means, and few enough that it does not
/// change with the last bit of a library's logarithm.
pub(crate) fn readable(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    format!("{value:.8e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_readable_number_has_nine_digits() {
        assert_eq!(readable(std::f64::consts::PI * 1e-7), 3.14159265e-7);
        assert_eq!(readable(-1234567891.23), -1234567890.0);
    }
}
