//! Residual statistics, as the file says them.

use serde::{Deserialize, Serialize};

/// Angular errors over all readings, in [`crate::error_model::Sensor::error_unit`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Root mean square.
    pub rms: f64,
    /// Largest absolute value.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Largest absolute value of the mean at one calibration point.
    pub max_of_point_means: f64,
}

/// One calibration point (or block).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointStatistics {
    /// Mean reading there: s in mm, or the direct sensor's.
    pub reading: f64,
    /// Number of readings.
    pub readings: usize,
    /// Mean error before the correction.
    pub mean_before: f64,
    /// Mean error after it (of a mean over passes: the fit error of the paper's Figure 7b).
    pub mean_after: f64,
    /// Standard deviation of the errors about their mean, after the correction; none for one reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_deviation: Option<f64>,
}

/// All statistics of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statistics {
    /// Unit of every figure here.
    pub unit: String,
    /// Errors as calibrated (Eq. 8).
    pub before: Spread,
    /// What the model leaves of them.
    pub after: Spread,
    /// The scatter between passes; none where no angle repeats.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between_passes: Option<Scatter>,
    /// What a point is: see `points::Grouping`.
    pub points_are: String,
    /// Per point, by ascending reading.
    pub points: Vec<PointStatistics>,
}

/// What the passes say about the noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// Standard deviation of one reading between passes at the same angle, pooled over all angles, in the
    /// unit of the errors.
    pub standard_deviation: f64,
    /// Degrees of freedom of that figure.
    pub degrees_of_freedom: usize,
    /// Whether the noise differs between angles so clearly that the rows were weighted.
    pub weighted: bool,
}
