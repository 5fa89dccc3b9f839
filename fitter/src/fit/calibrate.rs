//! From columns to the angular errors of Eq. 8, with checks of what only shows when both sides are compared.

use super::FitError;
use crate::basis::Basis;
use crate::coefficients::Zero;
use crate::double_double::Double;
use crate::error_model::Sensor;
use crate::points::{Grouping, Points};
use crate::recording::{Readings, Recording};
use crate::statistics::{ends, readable};
use crate::units::ARCSEC_PER_RAD;

/// Readings and errors of every row.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    /// s = x₂ − x₁ in millimetres; direct: the measured reading.
    pub reading: Vec<f64>,
    /// Angular error Δθ_M = θ − (α − α₀) in radians (Eq. 7, 8); direct: measured − reference.
    pub error: Vec<f64>,
    /// Smallest reading.
    pub from: f64,
    /// Largest reading.
    pub to: f64,
}

impl Calibrated {
    /// Compares sensor and reference row by row, α₀ being 0 still.
    pub(super) fn of(recording: &Recording, sensor: &Sensor) -> Result<Calibrated, FitError> {
        let file = || recording.file.clone();
        if let Some(recording) = recording.readings.other_than(sensor) {
            return Err(FitError::OtherSensor { file: file(), recording, mirror: sensor.kind() });
        }
        let (reference, column) = match &recording.readings {
            Readings::Pair { reference_arcsec, .. } => (reference_arcsec, "reference_arcsec"),
            Readings::Direct { reference, .. } => (reference, "reference"),
        };
        let Some(reference) = reference else {
            return Err(FitError::NoReference { file: file(), column });
        };
        if let Some(unwound) = super::unwound(recording, sensor)? {
            return Ok(Calibrated::from_columns(unwound.reading, unwound.error));
        }
        let reading: Vec<f64> = (0..recording.rows()).map(|row| recording.reading(row)).collect();
        let error: Vec<f64> = (reading.iter().zip(reference))
            .map(|(reading, reference)| sensor.calculated(*reading) - sensor.internal(*reference))
            .collect();
        Ok(Calibrated::from_columns(reading, error))
    }

    pub(crate) fn from_columns(reading: Vec<f64>, error: Vec<f64>) -> Calibrated {
        let (from, to) = ends(reading.iter().copied());
        Calibrated { reading, error, from, to }
    }

    /// Refuses recordings at one angle and units that contradict each other.
    pub(super) fn check_spread(
        &self,
        recording: &Recording,
        points: &Points,
        sensor: &Sensor,
    ) -> Result<(), FitError> {
        let file = recording.file.clone();
        let (from, to, unit) = (self.from, self.to, sensor.reading_unit().to_string());
        let narrow = match sensor {
            // Two micrometres are 35″ and forty times the repeatability of an eddy-current probe.
            Sensor::EddyCurrentPair { .. } => to - from < 0.002,
            Sensor::Direct { .. } => to == from,
        };
        if narrow || (points.count() < 2 && points.grouping == Grouping::Commanded) {
            return Err(FitError::OneAngle { file, from, to, unit });
        }
        if let Sensor::EddyCurrentPair { probe_distance_mm: distance_mm, .. } = *sensor {
            let largest = from.abs().max(to.abs());
            if largest > distance_mm {
                return Err(FitError::Displacement { file, largest, distance_mm });
            }
        }
        check_slope(self, recording, sensor)
    }

    /// Finds α₀ and takes it into the errors; none for a direct sensor, whose polynomial's constant takes it.
    pub(super) fn set_zero(&mut self, points: &Points, sensor: &Sensor) -> Option<Zero> {
        let Sensor::EddyCurrentPair { .. } = sensor else { return None };
        let angle: Vec<f64> = points.reading.iter().map(|s| sensor.calculated(*s)).collect();
        let count = points.count();
        let nearest = (0..count).min_by(|a, b| angle[*a].abs().total_cmp(&angle[*b].abs()))?;
        let step = (angle[count - 1] - angle[0]) / (count - 1).max(1) as f64;
        let at_zero =
            points.grouping != Grouping::Block && points.single_angles && angle[nearest].abs() < 0.25 * step;
        let inside = self.from < 0.0 && self.to > 0.0;
        let (alpha0, standard_error, from) = if at_zero || !inside {
            // The autocollimator's reading at calculated angle 0 (Eq. 7). The angle itself, which the
            // controller leaves a little off zero, is taken off each reading.
            let rows: Vec<f64> = (points.of_row.iter().zip(&self.error))
                .filter(|(point, _)| **point as usize == nearest)
                .map(|(_, error)| -error)
                .collect();
            let n = rows.len() as f64;
            let mean = rows.iter().sum::<f64>() / n;
            let squares: f64 = rows.iter().map(|x| (x - mean) * (x - mean)).sum();
            let error = (rows.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt());
            let degrees = angle[nearest].to_degrees();
            let from = if at_zero {
                format!("mean of {} readings at the point nearest zero ({degrees:.4} deg)", rows.len())
            } else {
                format!(
                    "mean of {} readings at the point nearest zero, which at {degrees:.4} deg is not near: the \
                     angular error there was set to zero",
                    rows.len()
                )
            };
            (mean, error, from)
        } else {
            let intercept = self.intercept(points);
            (-intercept, None, "intercept of the errors at angle 0: no point lies near zero".to_string())
        };
        self.error.iter_mut().for_each(|error| *error += alpha0);
        Some(Zero {
            alpha0_arcsec: readable(alpha0 * ARCSEC_PER_RAD),
            standard_error_arcsec: standard_error.map(|error| readable(error * ARCSEC_PER_RAD)),
            from,
        })
    }

    /// The error at reading 0 by a polynomial of order 5 at most through the 24 nearest points' means.
    fn intercept(&self, points: &Points) -> f64 {
        let means = crate::statistics::PointMoments::of(points, |row| self.error[row]).mean;
        let mut order: Vec<usize> = (0..points.count()).collect();
        order.sort_by(|a, b| points.reading[*a].abs().total_cmp(&points.reading[*b].abs()));
        order.truncate(24);
        order.sort_unstable();
        let readings: Vec<f64> = order.iter().map(|point| points.reading[*point]).collect();
        let weights = vec![1.0; readings.len()];
        let basis = Basis::new(&readings, &weights, (readings.len() / 3).clamp(1, 5));
        let mut values = vec![0.0; basis.order() + 1];
        let mut c = vec![0.0; values.len()];
        for (reading, point) in readings.iter().zip(&order) {
            basis.evaluate(*reading, &mut values);
            c.iter_mut().zip(&values).for_each(|(c, p)| *c += p * means[*point]);
        }
        basis.evaluate(0.0, &mut values);
        values.iter().zip(&c).map(|(p, c)| p * c).sum()
    }

    /// Error less the model Σ cₖ gain pₖ, row by row.
    pub(super) fn residual(&self, sensor: &Sensor, basis: &Basis, c: &[Double]) -> Vec<f64> {
        let c: Vec<f64> = c.iter().map(|c| c.round()).collect();
        let mut values = vec![0.0; c.len()];
        (self.reading.iter().zip(&self.error))
            .map(|(reading, error)| {
                basis.evaluate(*reading, &mut values);
                error - sensor.gain(*reading) * values.iter().zip(&c).map(|(p, c)| p * c).sum::<f64>()
            })
            .collect()
    }
}

/// The reference has to follow the sensor with a slope of about 1 (0.86 on the paper's mirror): another one
/// is a unit, a sign or a wrong column.
fn check_slope(data: &Calibrated, recording: &Recording, sensor: &Sensor) -> Result<(), FitError> {
    let rows = data.reading.len() as f64;
    let sensor_value = |row: usize| sensor.calculated(data.reading[row]);
    // Reference = sensor − error, wherever the turns of a revolution were counted.
    let reference = |row: usize| sensor_value(row) - data.error[row];
    let (mut x_mean, mut y_mean) = (0.0, 0.0);
    for row in 0..data.reading.len() {
        x_mean += sensor_value(row) / rows;
        y_mean += reference(row) / rows;
    }
    let (mut xx, mut xy) = (0.0, 0.0);
    for row in 0..data.reading.len() {
        let x = sensor_value(row) - x_mean;
        xx += x * x;
        xy += x * (reference(row) - y_mean);
    }
    let slope = xy / xx;
    if (0.5..=2.0).contains(&slope) {
        return Ok(());
    }
    let file = recording.file.clone();
    let (column, against, unit, guesses): (_, _, _, &[(f64, &'static str)]) = match sensor {
        Sensor::EddyCurrentPair { .. } => (
            "reference_arcsec",
            "the calculated angle atan((x2-x1)/d)",
            "arcsec".to_string(),
            &[
                (1.0 / 3600.0, "degrees"),
                (1.0 / 60.0, "arcminutes"),
                (1.0 / ARCSEC_PER_RAD, "radians"),
                (1e3 / ARCSEC_PER_RAD, "milliradians"),
                (1e6 / ARCSEC_PER_RAD, "microradians"),
                (1e3, "milliarcseconds (or the displacements like metres)"),
                (1e-3, "values whose displacements are in micrometres"),
            ],
        ),
        Sensor::Direct { unit, .. } => (
            "reference",
            "`measured`",
            format!("both in {unit}"),
            &[
                (1e3, "a unit 1000 times smaller than that of `measured`"),
                (1e-3, "a unit 1000 times larger than that of `measured`"),
                (180.0 / std::f64::consts::PI, "degrees against radians"),
                (std::f64::consts::PI / 180.0, "radians against degrees"),
                (3600.0, "arcseconds against degrees"),
                (1.0 / 3600.0, "degrees against arcseconds"),
            ],
        ),
    };
    let column = column.to_string();
    if (-2.0..=-0.5).contains(&slope) {
        let mend = match sensor {
            Sensor::EddyCurrentPair { .. } => "exchange x1_mm and x2_mm, or turn the reference's sign",
            Sensor::Direct { .. } => "turn the sign of one of the two columns",
        };
        return Err(FitError::Sense { file, column, slope, against, mend });
    }
    let near = |factor: f64| (0.5..=2.0).contains(&(slope.abs() / factor));
    // Of several units within a factor of two, the nearest.
    let guess = (guesses.iter().filter(|(factor, _)| near(*factor)))
        .min_by(|a, b| (slope.abs() / a.0).ln().abs().total_cmp(&(slope.abs() / b.0).ln().abs()))
        .map(|(_, name)| *name);
    Err(FitError::Unit { file, column, slope, against, unit, guess })
}
