//! What the coefficients file says of a turn beside its harmonics.

use serde::{Deserialize, Serialize};

/// An error that grows with the travelled angle and does not repeat with the turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slope {
    /// By how much the error grows in a turn, in the sensor's unit.
    pub per_turn: Estimate,
    /// The same in a sentence, and where such an error comes from.
    pub statement: String,
}

/// What is left of the recording's errors where not everything is corrected: root mean squares about their mean, in the
/// sensor's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Left {
    /// By the harmonics alone.
    pub harmonics_alone_rms: f64,
    /// By all that repeats with the turn or moves with the speed, fitted without the slope: harmonics, and the lag where
    /// one was found.
    pub without_slope_rms: f64,
}

/// What the recording says about its directions of motion.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Directions {
    /// Number of readings in the forward direction.
    pub forward: usize,
    /// Number of readings in the backward direction.
    pub backward: usize,
    /// Half of the distance from backward to forward errors, in the sensor's unit; below zero where the reading
    /// stays behind the reference. None with one direction only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_distance: Option<Estimate>,
    /// Delay of the reading in seconds; none where the speed hardly changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<Estimate>,
    /// Whether the lag is a term of the coefficients, and `apply` takes it off.
    #[serde(default, skip_serializing_if = "is_false")]
    pub lag_corrected: bool,
    /// Root mean square by which half of the distance varies over the turn, in the sensor's unit; none where
    /// it does not beyond chance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variation_rms: Option<f64>,
    /// 10th and 90th percentile of the speed from row to row, in the sensor's unit per second; none without
    /// increasing times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_per_s: Option<[f64; 2]>,
    /// The same in a sentence, and what the recording cannot tell.
    pub statement: String,
}

fn is_false(value: &bool) -> bool {
    !value
}

/// A value with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// 95 % interval (Student's t).
    pub ci95: [f64; 2],
}
