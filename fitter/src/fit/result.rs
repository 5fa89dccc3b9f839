//! What a fit writes down: parameters with intervals, covariance, the null direction, curves, statistics.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{Calibrated, Data, FitError, Fitted, Options, Prepared, Solver};
use crate::coefficients::{
    Coefficients, Identification, Movement, Parameter, Provenance, Recorded, Unidentifiable,
};
use crate::double_double::Double;
use crate::error_model::{ErrorModel, Sensor};
use crate::identify::null_direction;
use crate::mirror::Mirror;
use crate::order::{OrderScore, OrderSelection, RULE, Scores};
use crate::points::Points;
use crate::recording::Recording;
use crate::statistics::{readable, statistics};

/// Everything that the result is put together from.
pub(super) struct Parts<'a> {
    pub recording: &'a Recording,
    pub mirror: &'a Mirror,
    pub options: &'a Options,
    pub selection: Option<&'a Scores>,
    pub prepared: &'a Prepared,
    pub data: &'a Data<'a>,
}

/// The polynomial in powers of s must give back the orthogonal one to this, in radians.
const CONVERSION_RAD: f64 = 1e-10;

pub(super) fn coefficients(parts: &Parts, c: &[Double], residual: &[f64]) -> Result<Coefficients, FitError> {
    let Parts { recording, mirror, options, prepared, data, .. } = *parts;
    let Prepared { calibrated, points, scatter, .. } = prepared;
    let sensor = &mirror.sensor;
    let order = c.len() - 1;
    let centre = match sensor {
        Sensor::EddyCurrentPair { .. } => 0.0,
        Sensor::Direct { .. } => readable(0.5 * (calibrated.from + calibrated.to)),
    };
    let model =
        ErrorModel { sensor: sensor.clone(), centre, coefficients: data.basis.rounded_powers(c, centre) };
    check_conversion(&recording.file, calibrated, residual, &model)?;

    let rounded: Vec<f64> = c.iter().map(|c| c.round()).collect();
    let (factor, rows, squares) = data.normal(&rounded);
    let freedom = rows.saturating_sub(order + 1);
    let variance = if freedom > 0 { squares / freedom as f64 } else { 0.0 };
    let scaled: Vec<Vec<f64>> = (factor.inverse(order).into_iter())
        .map(|row| row.into_iter().map(|value| value * variance).collect())
        .collect();
    let covariance = data.basis.covariance_in_powers(&scaled, centre);
    let mut file = Coefficients::of_model(&model, calibrated.from, calibrated.to, &options.command);
    file.recording = Provenance::of(recording);
    let scale = sensor.per_internal();
    let weighted = scatter.as_ref().is_some_and(|scatter| scatter.weighted);
    file.identification = Some(Identification {
        solver: match options.solver {
            Solver::Qr => "qr".to_string(),
            Solver::TrustRegion => "trust-region".to_string(),
        },
        fitted: match (options.fitted, weighted) {
            (Fitted::Averages, _) => "averages over passes (Eq. 7)".to_string(),
            (Fitted::Rows, true) => "rows weighted by the scatter between passes".to_string(),
            (Fitted::Rows, false) => "rows".to_string(),
        },
        zero: prepared.zero.clone(),
        parameters: parameters(&model, &covariance, freedom, options.probe_distance_error_mm),
        covariance: if freedom > 0 { covariance } else { Vec::new() },
        residual_standard_deviation: readable(scale * variance.sqrt()),
        degrees_of_freedom: freedom,
        probe_distance_error_mm: options.probe_distance_error_mm,
        unidentifiable: unidentifiable(parts, &model)?,
    });
    let given = options.order.is_some();
    file.order_selection =
        parts.selection.map(|scores| order_selection(scores, order, given, options, points, sensor));
    let unit = sensor.error_unit();
    file.statistics = Some(statistics(points, &calibrated.error, residual, scale, unit, scatter.clone()));
    let left: Vec<f64> = residual.iter().map(|residual| scale * residual).collect();
    file.set_recorded(Recorded::of(recording, mirror.reference, &left));
    Ok(file)
}

/// The model in powers of the reading against the orthogonal one, at every row.
fn check_conversion(
    file: &str,
    calibrated: &Calibrated,
    residual: &[f64],
    model: &ErrorModel,
) -> Result<(), FitError> {
    let order = model.coefficients.len() - 1;
    let loss = (0..calibrated.reading.len())
        .map(|row| (calibrated.error[row] - residual[row] - model.error(calibrated.reading[row])).abs())
        .fold(0.0, f64::max);
    // A direct sensor's unit is its own: there the loss is held against the largest error.
    let largest = calibrated.error.iter().fold(0.0f64, |max, error| max.max(error.abs()));
    let allowed = match model.sensor {
        Sensor::EddyCurrentPair { .. } => CONVERSION_RAD,
        Sensor::Direct { .. } => 1e-9 * largest.max(f64::MIN_POSITIVE),
    };
    if loss <= allowed { Ok(()) } else { Err(FitError::Conversion { file: file.to_string(), order, loss }) }
}

fn parameters(
    model: &ErrorModel,
    covariance: &[Vec<f64>],
    freedom: usize,
    probe_distance_error_mm: Option<f64>,
) -> Vec<Parameter> {
    let quantile = (freedom > 0)
        .then(|| StudentsT::new(0.0, 1.0, freedom as f64).ok().map(|t| readable(t.inverse_cdf(0.975))))
        .flatten();
    let with_interval = |name: String, unit: String, value: f64, error: f64| Parameter {
        name,
        value,
        unit,
        standard_error: quantile.map(|_| readable(error)),
        ci95: quantile.map(|t| [readable(value - t * error), readable(value + t * error)]),
    };
    let (pair, distance) = match model.sensor {
        Sensor::EddyCurrentPair { probe_distance_mm, .. } => (true, probe_distance_mm),
        Sensor::Direct { .. } => (false, 1.0),
    };
    let unit_of = |power: usize| match (power, model.sensor.reading_unit()) {
        (0, unit) => unit.to_string(),
        (1, _) => "1".to_string(),
        (_, unit) => format!("{unit}^{}", 1 - power as i64),
    };
    let mut list: Vec<Parameter> = (model.coefficients.iter().enumerate())
        .map(|(power, value)| {
            let name = if power == 1 && pair { "a1 - dd/d".to_string() } else { format!("a{power}") };
            with_interval(name, unit_of(power), *value, covariance[power][power].sqrt())
        })
        .collect();
    if let (true, Some(error)) = (pair, probe_distance_error_mm) {
        let a1 = model.coefficients[1] + error / distance;
        list.push(with_interval("a1".to_string(), "1".to_string(), a1, covariance[1][1].sqrt()));
        list.push(Parameter {
            name: "dd".to_string(),
            value: error,
            unit: "mm".to_string(),
            standard_error: None,
            ci95: None,
        });
    }
    list
}

/// Which combinations of parameters the recording leaves open; with Δd given, none.
fn unidentifiable(parts: &Parts, model: &ErrorModel) -> Result<Vec<Unidentifiable>, FitError> {
    let Sensor::EddyCurrentPair { probe_distance_mm: distance, .. } = model.sensor else {
        return Ok(Vec::new());
    };
    if parts.options.probe_distance_error_mm.is_some() {
        return Ok(Vec::new());
    }
    let order = model.coefficients.len() - 1;
    let found = null_direction(&parts.prepared.points.reading, distance, order)?;
    let names = std::iter::once("dd".to_string()).chain((0..=order).map(|power| format!("a{power}")));
    let slope = found.direction[2];
    // What the decomposition's rounding leaves in the other parameters is not part of the direction.
    let direction: Vec<Movement> = (names.zip(&found.direction))
        .map(|(parameter, change)| Movement { parameter, change: (change * 1e9).round() / 1e9 })
        .filter(|movement| movement.change != 0.0)
        .collect();
    Ok(vec![Unidentifiable {
        statement: format!(
            "the probe distance error dd and a1 cannot be told apart: raising dd by 1 mm and a1 by {slope:.6} \
             leaves every predicted angle as it is; only a1 - dd/d = {:.6} is determined, until the probe distance \
             error is measured otherwise",
            model.coefficients[1]
        ),
        direction,
        // Zero up to rounding; the exact figure would differ from machine to machine.
        relative_singular_value: if found.singular_value < 1e-12 {
            0.0
        } else {
            readable(found.singular_value)
        },
    }])
}

/// What the scores say, in the unit of the errors.
pub(crate) fn order_selection(
    scores: &Scores,
    chosen: usize,
    given: bool,
    options: &Options,
    points: &Points,
    sensor: &Sensor,
) -> OrderSelection {
    let scale = sensor.per_internal();
    let root = |squared: f64| readable(scale * squared.max(0.0).sqrt());
    let curve = (0..scores.orders.len())
        .map(|i| OrderScore {
            order: scores.orders[i],
            training: root(scores.training[i]),
            testing: root(scores.testing[i]),
            excess: readable(scale * scale * scores.excess[i]),
            excess_standard_error: readable(scale * scale * scores.excess_error[i]),
            leave_one_pass_out: scores.pass_out.as_ref().map(|scores| root(scores[i])),
        })
        .collect();
    OrderSelection {
        chosen,
        rule: if given { "given" } else { RULE }.to_string(),
        smallest_testing_error: scores.best,
        held_out_by: points.grouping.name().to_string(),
        groups: points.count(),
        held_out_groups: scores.held_out,
        splits: options.splits.count,
        seed: options.splits.seed,
        unit: sensor.error_unit().to_string(),
        curve,
    }
}
