//! Confidence intervals of means, from the scatter of the readings of all points together.

use fitter::points::Points;
use fitter::statistics::PointMoments;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Half the 95 % interval of every point's mean; blank where no point has two readings. The scatter of all points is
/// taken together: that of a single one is known too poorly.
pub(super) fn half_intervals(points: &Points, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let variances = PointMoments::of(points, value).variances();
    let freedom: usize = variances.iter().map(|variance| variance.freedom).sum();
    let squares: f64 = variances.iter().map(|variance| variance.value * variance.freedom as f64).sum();
    half_of(squares, freedom, points.rows.iter().copied())
}

/// The same from the sum of squares about the means, its degrees of freedom, and the readings of every point.
pub(super) fn half_of(squares: f64, freedom: usize, readings: impl Iterator<Item = usize>) -> Vec<f64> {
    let Some(t) = StudentsT::new(0.0, 1.0, freedom as f64).ok().map(|t| t.inverse_cdf(0.975)) else {
        return Vec::new();
    };
    let deviation = (squares / freedom as f64).sqrt();
    readings.map(|count| t * deviation / (count.max(1) as f64).sqrt()).collect()
}
