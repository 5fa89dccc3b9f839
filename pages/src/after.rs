//! What the correction leaves of a recording's errors, pass by pass and point by point.

use fitter::Fit;
use fitter::apply::{ApplyError, apply};
use fitter::coefficients::Coefficients;
use fitter::error_model::Sensor;
use fitter::points::Points;
use fitter::recording::Recording;
use fitter::statistics::PointMoments;

/// Errors after the correction.
pub struct Corrected {
    /// The recording's name.
    pub name: String,
    /// Whether it is the one that was fitted.
    pub fitted: bool,
    /// Corrected angle in degrees (direct: in the sensor's unit) of every row.
    pub angle: Vec<f64>,
    /// Error in the unit of the statistics of every row.
    pub error: Vec<f64>,
    /// Pass and direction of every row.
    pub pass: Vec<(i32, i8)>,
    /// What the readings of every point have in common.
    pub points: Vec<PointErrors>,
}

/// Errors of the readings at one angle.
pub struct PointErrors {
    /// Mean angle.
    pub angle: f64,
    /// Mean error.
    pub mean: f64,
    /// Standard deviation; none of a single reading.
    pub deviation: Option<f64>,
    /// Number of readings.
    pub readings: usize,
}

impl Corrected {
    /// Of the recording that was fitted: its residual.
    pub(super) fn fitted(recording: &Recording, fit: &Fit) -> Corrected {
        let sensor = &fit.coefficients.sensor;
        let scale = sensor.per_internal();
        let angle = (fit.calibrated.reading.iter().zip(&fit.calibrated.error).zip(&fit.residual))
            .map(|((reading, error), residual)| {
                super::angle(sensor, sensor.calculated(*reading) - (error - residual))
            })
            .collect();
        let error = fit.residual.iter().map(|residual| scale * residual).collect();
        Corrected::new(recording, true, angle, error, &fit.points)
    }

    /// Of another recording: corrected, against its reference.
    pub(super) fn of(recording: &Recording, file: &Coefficients) -> Result<Corrected, ApplyError> {
        let applied = apply(recording, file)?;
        let sensor = &file.sensor;
        let scale = sensor.per_internal();
        let mut error = Vec::with_capacity(recording.rows());
        for (row, corrected) in applied.corrected.iter().enumerate() {
            let reference = recording
                .reference(row)
                .ok_or_else(|| ApplyError::NoReference { file: recording.file.clone() })?;
            let apart = corrected - sensor.internal(reference);
            let turn = file.turn.as_ref().map_or(0.0, |turn| turn.revolution);
            error.push(scale * if turn > 0.0 { apart - turn * (apart / turn).round() } else { apart });
        }
        let reading: Vec<f64> = match &file.turn {
            Some(turn) => (0..recording.rows()).map(|row| turn.within(recording.reading(row)).0).collect(),
            None => (0..recording.rows()).map(|row| recording.reading(row)).collect(),
        };
        let points = match &file.turn {
            Some(turn) => Points::around(recording, &reading, turn.revolution),
            None => Points::of(recording, &reading),
        };
        if matches!(sensor, Sensor::EddyCurrentPair { .. }) {
            set_zero(&mut error, &applied.corrected, &points);
        }
        let angle = applied.corrected.iter().map(|corrected| super::angle(sensor, *corrected)).collect();
        Ok(Corrected::new(recording, false, angle, error, &points))
    }

    fn new(
        recording: &Recording,
        fitted: bool,
        angle: Vec<f64>,
        error: Vec<f64>,
        points: &Points,
    ) -> Corrected {
        let angles = PointMoments::of(points, |row| angle[row]).mean;
        let moments = PointMoments::of(points, |row| error[row]);
        let deviations = moments
            .variances()
            .into_iter()
            .map(|v| (v.freedom > 0).then(|| v.value.sqrt()))
            .collect::<Vec<_>>();
        let points = (angles.into_iter().zip(moments.mean).zip(deviations).zip(&points.rows))
            .map(|(((angle, mean), deviation), readings)| PointErrors {
                angle,
                mean,
                deviation,
                readings: *readings,
            })
            .collect();
        let pass = recording.pass.iter().copied().zip(recording.direction.iter().copied()).collect();
        Corrected { name: recording.file.clone(), fitted, angle, error, pass, points }
    }

    /// Root mean square of the errors.
    pub fn rms(&self) -> f64 {
        (self.error.iter().map(|e| e * e).sum::<f64>() / self.error.len() as f64).sqrt()
    }

    /// Largest error.
    pub fn largest(&self) -> f64 {
        self.error.iter().fold(0.0, |max, e| e.abs().max(max))
    }

    /// Largest mean error of a point.
    pub fn largest_mean(&self) -> f64 {
        self.points.iter().fold(0.0, |max, point| point.mean.abs().max(max))
    }

    /// Largest standard deviation of a point; none where no angle repeats.
    pub fn largest_deviation(&self) -> Option<f64> {
        self.points.iter().filter_map(|point| point.deviation).reduce(f64::max)
    }
}

/// Refers the errors to the reading nearest angle 0, as Eq. 7 does: the autocollimator's own zero is unknown.
fn set_zero(error: &mut [f64], corrected: &[f64], points: &Points) {
    let angle = PointMoments::of(points, |row| corrected[row]).mean;
    let Some(nearest) = (0..angle.len()).min_by(|a, b| angle[*a].abs().total_cmp(&angle[*b].abs())) else {
        return;
    };
    let zero = PointMoments::of(points, |row| error[row]).mean[nearest];
    error.iter_mut().for_each(|error| *error -= zero);
}
