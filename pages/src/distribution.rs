//! How errors are distributed: a histogram, and their quantiles against those of normal noise.

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use super::chart::{Chart, Mark, Series, range};
use super::colour::Colour;
use super::{Figure, digits};

/// Columns of the histogram, at most: what a chart has room for.
const MOST_COLUMNS: f64 = 60.0;
/// Points of the normal curve.
const CURVE: i32 = 200;
/// A mean below this part of the standard deviation is rounding and is written as zero.
const ROUNDING: f64 = 1e-6;

/// Histogram and Q–Q plot of errors; none where they do not scatter. `suffix` is that of the figures' names, `whose`
/// says what was recorded.
pub fn distribution(errors: &[f64], suffix: &str, whose: &str, unit: &str) -> Vec<Figure> {
    let mut errors = errors.to_vec();
    errors.sort_by(f64::total_cmp);
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let deviation = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count).sqrt();
    let (Ok(normal), Ok(standard)) = (Normal::new(mean, deviation), Normal::new(0.0, 1.0)) else {
        return Vec::new();
    };
    vec![
        histogram(&errors, &normal, (mean, deviation), &format!("histogram{suffix}"), whose, unit),
        quantiles(&errors, &standard, (mean, deviation), &format!("quantiles{suffix}"), whose, unit),
    ]
}

/// The number of readings over ascending errors, and the normal curve of their mean and standard deviation.
fn histogram(
    errors: &[f64],
    normal: &Normal,
    (mean, deviation): (f64, f64),
    name: &str,
    whose: &str,
    unit: &str,
) -> Figure {
    let count = errors.len() as f64;
    let (low, high) = range(errors.iter().copied()).unwrap_or((mean, mean));
    // Scott's rule (Biometrika 66 (1979) 605–610): the width that estimates a normal density best.
    let columns = ((high - low) / (3.49 * deviation / count.cbrt())).ceil().clamp(1.0, MOST_COLUMNS);
    let width = (high - low) / columns;
    let mut heights = vec![0.0; columns as usize];
    for error in errors {
        let column = (((error - low) / width) as usize).min(heights.len() - 1);
        heights[column] += 1.0;
    }
    let middle = |column: usize| low + width * (column as f64 + 0.5);
    let columns = heights.iter().enumerate().map(|(column, height)| (middle(column), *height)).collect();
    let curve = (0..=CURVE).map(|i| low + (high - low) * f64::from(i) / f64::from(CURVE));
    let curve = curve.map(|error| (error, count * width * normal.pdf(error))).collect();
    let mean = if mean.abs() < ROUNDING * deviation { 0.0 } else { mean };
    Figure::of(
        name,
        "Distribution of the errors",
        format!("Of {whose}: mean {} {unit}, standard deviation {} {unit}.", digits(mean), digits(deviation)),
        Chart {
            label: "Histogram of the errors",
            x: format!("error ({unit})"),
            y: "readings".to_string(),
            series: vec![
                Series::new("readings", Mark::Columns, Colour::Second, columns),
                Series::new("normal", Mark::Line, Colour::First, curve),
            ],
        },
    )
}

/// Every ascending error over the quantile that normal noise would have in its place.
fn quantiles(
    errors: &[f64],
    standard: &Normal,
    (mean, deviation): (f64, f64),
    name: &str,
    whose: &str,
    unit: &str,
) -> Figure {
    let expected = |rank: usize| standard.inverse_cdf((rank as f64 + 0.5) / errors.len() as f64);
    let points = errors.iter().enumerate().map(|(rank, error)| (expected(rank), *error)).collect();
    let ends = [0, errors.len().saturating_sub(1)].map(expected).map(|z| (z, mean + deviation * z));
    Figure::of(
        name,
        "Quantiles against those of normal noise",
        format!("Of {whose}. Normal noise lies on the line; outliers leave it at the ends."),
        Chart {
            label: "Quantiles of the errors against those of the normal distribution",
            x: "normal quantile (σ)".to_string(),
            y: format!("error ({unit})"),
            series: vec![
                Series::new("normal", Mark::Line, Colour::Soft, ends.to_vec()),
                Series::new("readings", Mark::Dots, Colour::Second, points),
            ],
        },
    )
}
