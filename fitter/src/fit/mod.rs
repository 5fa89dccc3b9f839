//! From a recording to coefficients: the whole way in one call.

mod calibrate;
mod error;
mod result;
mod turning;

use std::borrow::Cow;

use crate::acceptance;
use crate::basis::{Basis, MAX_ORDER};
use crate::coefficients::{Coefficients, Zero};
use crate::dependence::{self, Dependence};
use crate::double_double::Double;
use crate::error_model::Sensor;
use crate::gram::{Factor, Grams, Row};
use crate::identify::Problem;
use crate::mirror::Mirror;
use crate::order::{self, OrderSelection, Scores, Splits};
use crate::points::{Grouping, Points};
use crate::recording::Recording;
use crate::statistics::PointMoments;
use crate::turn::{self, MAX_HARMONICS};
use crate::weights::{self, Scatter, Variance};

pub use calibrate::Calibrated;
pub use error::{FitError, FitNote};
pub(crate) use result::order_selection;
use turning::{around, turn_of, unwound};

/// How the least-squares problem is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// Householder QR in an orthonormal basis.
    #[default]
    Qr,
    /// The paper's trust region method on Eq. 11 with Δd among the parameters.
    TrustRegion,
}

/// What is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fitted {
    /// All rows, weighted by the scatter between passes. The default: with the same angles in every pass it
    /// gives the same as the averages, it keeps the residuals of every reading, and it stays right where
    /// angles were read unequally often.
    #[default]
    Rows,
    /// The averages over passes of Eq. 7, each angle counting alike.
    Averages,
}

/// What a fit can be told.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The order; none chooses it by cross-validation.
    pub order: Option<usize>,
    /// Candidate orders.
    pub candidates: std::ops::RangeInclusive<usize>,
    /// Number of harmonics of a sensor that turns; none chooses it by cross-validation.
    pub harmonics: Option<usize>,
    /// The splits of the cross-validation.
    pub splits: Splits,
    /// Solver.
    pub solver: Solver,
    /// Rows or averages.
    pub fitted: Fitted,
    /// Δd in millimetres, measured elsewhere; it frees a₁.
    pub probe_distance_error_mm: Option<f64>,
    /// The command that is recorded in the result.
    pub command: String,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            order: None,
            candidates: 1..=MAX_ORDER,
            harmonics: None,
            splits: Splits::default(),
            solver: Solver::default(),
            fitted: Fitted::default(),
            probe_distance_error_mm: None,
            command: String::from("arcsmith fit"),
        }
    }
}

/// What came out of a fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The coefficients file.
    pub coefficients: Coefficients,
    /// Readings and angular errors of every row as they were fitted.
    pub calibrated: Calibrated,
    /// Angular error less the model, row by row, in the internal unit (radians; direct: the sensor's).
    pub residual: Vec<f64>,
    /// Which rows belong to one calibration point.
    pub points: Points,
    /// Weight of every point's rows, 1 on average.
    pub weights: Vec<f64>,
    /// The orthonormal basis over the recording's readings.
    pub basis: Basis,
    /// What the residual depends on beyond chance, the most significant first.
    pub dependences: Vec<Dependence>,
    /// What a reader of the result should know.
    pub notes: Vec<FitNote>,
}

impl Fit {
    /// Looks for what else the residual depends on, and how far its rows depend on one another.
    pub(crate) fn look_beside(&mut self, recording: &Recording) {
        let correlation;
        (self.dependences, correlation) = dependence::dependences(recording, self);
        if let Some(recorded) = &mut self.coefficients.recorded {
            recorded.correlation = correlation;
        }
    }
}

/// Fits the angular error model (Eq. 6) to a recording of the given mirror.
///
/// # Errors
/// One of [`FitError`]: the recording is not of this kind of sensor, its units contradict each other, or it
/// does not determine the parameters.
///
/// # Example
/// ```
/// use fitter::{Options, fit};
///
/// let (recording, mirror) = fitter::default_recording()?;
/// let fit = fit(&recording, &mirror, &Options::default())?;
/// let model = fit.coefficients.error_model();
/// // At s = 0.3 mm, in radians: the corrected angle differs from atan(s/d) by some tenths of a degree.
/// let error_rad = model.uncorrected(0.3) - model.corrected(0.3);
/// assert!(error_rad.to_degrees().abs() < 0.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit(recording: &Recording, mirror: &Mirror, options: &Options) -> Result<Fit, FitError> {
    options.check()?;
    let fit = match around(recording, mirror, options)? {
        Some(harmonics) => turn::fit(harmonics)?,
        None => polynomial(recording, mirror, options)?,
    };
    let unusable = |refusal| FitError::Unusable { file: recording.file.clone(), refusal };
    acceptance::to_apply(&fit.coefficients).map_err(unusable)?;
    Ok(fit)
}

/// The fit of a polynomial.
fn polynomial(recording: &Recording, mirror: &Mirror, options: &Options) -> Result<Fit, FitError> {
    let prepared = Prepared::of(recording, mirror)?;
    let data = Data::of(&prepared, recording, mirror, options);
    let selection = data.select(options)?;
    let order = data.order(options, selection.as_ref())?;
    let mut notes: Vec<FitNote> = recording.notes.iter().cloned().map(FitNote::Reading).collect();
    if recording.passes().len() == 1 {
        notes.push(FitNote::SinglePass);
    } else if prepared.points.grouping == Grouping::Block {
        notes.push(FitNote::NothingRepeats);
    }
    if selection.is_none() {
        notes.push(FitNote::OrderGiven);
    }
    let c = data.solve(mirror, options, order)?;
    let residual = prepared.calibrated.residual(&mirror.sensor, &data.basis, &c);
    let selection = selection.as_ref();
    let parts = result::Parts { recording, mirror, options, selection, prepared: &prepared, data: &data };
    let mut coefficients = result::coefficients(&parts, &c, &residual)?;
    if let Some(unwound) = unwound(recording, &mirror.sensor)? {
        coefficients.turn = Some(turn::part(recording, turn_of(&mirror.sensor), &unwound));
        let share = (prepared.calibrated.to - prepared.calibrated.from) / turn_of(&mirror.sensor);
        notes.push(FitNote::PartOfTurn { share });
    }
    let basis = data.basis;
    let Prepared { calibrated, points, weights, .. } = prepared;
    let dependences = Vec::new();
    let mut fit = Fit { coefficients, calibrated, residual, points, weights, basis, dependences, notes };
    fit.look_beside(recording);
    Ok(fit)
}

/// Refuses a recording that cannot be a calibration: all readings at one angle, displacements beyond the probes' distance,
/// a reference in another unit or of the other sense. [`fit()`] makes the same checks.
///
/// # Errors
/// One of [`FitError`], which names the column and the unit that it looks like.
pub fn check(recording: &Recording, mirror: &Mirror) -> Result<(), FitError> {
    let whole_turn = unwound(recording, &mirror.sensor)?.is_some_and(|unwound| unwound.whole);
    if whole_turn { Ok(()) } else { Prepared::of(recording, mirror).map(|_| ()) }
}

/// Chooses the order by cross-validation, and identifies nothing: both curves (Eq. 9, 10) and what they say.
///
/// # Errors
/// As [`fit`].
pub fn choose_order(
    recording: &Recording,
    mirror: &Mirror,
    options: &Options,
) -> Result<OrderSelection, FitError> {
    options.check()?;
    let options = Options { order: None, harmonics: None, ..options.clone() };
    if let Some(harmonics) = around(recording, mirror, &options)? {
        return harmonics.choose();
    }
    let prepared = Prepared::of(recording, mirror)?;
    let data = Data::of(&prepared, recording, mirror, &options);
    match data.select(&options)? {
        Some(scores) => {
            let (points, sensor) = (&prepared.points, &mirror.sensor);
            Ok(order_selection(&scores, scores.chosen, false, &options, points, sensor))
        }
        None => Err(data.too_few_to_hold_out()),
    }
}

/// A recording, checked and calibrated.
pub(crate) struct Prepared {
    file: String,
    calibrated: Calibrated,
    points: Points,
    zero: Option<Zero>,
    /// Weight of every point.
    weights: Vec<f64>,
    scatter: Option<Scatter>,
}

impl Prepared {
    fn of(recording: &Recording, mirror: &Mirror) -> Result<Prepared, FitError> {
        let mut calibrated = Calibrated::of(recording, &mirror.sensor)?;
        let points = Points::of(recording, &calibrated.reading);
        calibrated.check_spread(recording, &points, &mirror.sensor)?;
        let zero = calibrated.set_zero(&points, &mirror.sensor);
        let (weights, scatter) = scatter(&calibrated, &points, mirror);
        Ok(Prepared { file: recording.file.clone(), calibrated, points, zero, weights, scatter })
    }
}

impl Options {
    /// Refuses options that no fit can be made with.
    fn check(&self) -> Result<(), FitError> {
        let wrong = |option, found: String, expected| Err(FitError::Option { option, found, expected });
        let orders = 1..=MAX_ORDER;
        if let Some(order) = self.order.filter(|order| !orders.contains(order)) {
            return wrong("order", order.to_string(), "a whole number from 1 to 15");
        }
        if let Some(harmonics) = self.harmonics.filter(|harmonics| *harmonics > MAX_HARMONICS) {
            return wrong("turn_harmonics", harmonics.to_string(), "a whole number from 0 to 32");
        }
        let (first, last) = (*self.candidates.start(), *self.candidates.end());
        if !(orders.contains(&first) && orders.contains(&last) && first <= last) {
            return wrong("candidates", format!("{first}..={last}"), "orders from 1 to 15, ascending");
        }
        let Splits { count, held_out_share: share, .. } = self.splits;
        if count < 2 {
            return wrong("splits", count.to_string(), "at least 2 splits");
        }
        if !(share > 0.0 && share <= 0.5) {
            return wrong("held_out_share", share.to_string(), "a share above 0 and up to 0.5");
        }
        match self.probe_distance_error_mm {
            Some(error) if !error.is_finite() => {
                wrong("probe_distance_error", error.to_string(), "a finite number of millimetres")
            }
            _ => Ok(()),
        }
    }
}

/// Weights per point and the pooled scatter between passes; none where no angle repeats.
fn scatter(calibrated: &Calibrated, points: &Points, mirror: &Mirror) -> (Vec<f64>, Option<Scatter>) {
    if points.grouping == Grouping::Block || !points.single_angles {
        return (vec![1.0; points.count()], None);
    }
    let scale = mirror.sensor.per_internal();
    let variances = PointMoments::of(points, |row| scale * calibrated.error[row]).variances();
    let pooled = Variance::pooled(&variances);
    if pooled.freedom == 0 {
        return (vec![1.0; points.count()], None);
    }
    let (weights, weighted) = weights::weights(&variances);
    (weights, pooled.scatter(weighted))
}

/// The least-squares problem, ready to be solved for any order.
pub(crate) struct Data<'a> {
    file: &'a str,
    pub basis: Basis,
    grams: Grams,
    /// Number of distinct readings in each point.
    distinct: Vec<usize>,
    rows: Rows<'a>,
    grouping: Grouping,
}

/// What is fitted: the rows of the recording, or its averages.
struct Rows<'a> {
    reading: Cow<'a, [f64]>,
    error: Cow<'a, [f64]>,
    /// The point of each row.
    point: Cow<'a, [u32]>,
    /// Weight of each point.
    weights: Cow<'a, [f64]>,
}

/// Up to so many rows the basis is made orthonormal over every row, above over the points.
const BASIS_ROWS: usize = 4096;
/// At most so many folds of passes, and so many cells of folds and points.
const MOST_FOLDS: usize = 40;
const MOST_CELLS: usize = 8192;

impl<'a> Data<'a> {
    fn of(prepared: &'a Prepared, recording: &Recording, mirror: &Mirror, options: &Options) -> Data<'a> {
        let Prepared { calibrated, points, weights, .. } = prepared;
        let passes = recording.passes();
        let averaged = options.fitted == Fitted::Averages;
        let fitted = if averaged {
            Rows {
                reading: Cow::Borrowed(&points.reading),
                error: PointMoments::of(points, |row| calibrated.error[row]).mean.into(),
                point: (0..points.count() as u32).collect(),
                weights: vec![1.0; points.count()].into(),
            }
        } else {
            Rows {
                reading: (&calibrated.reading).into(),
                error: (&calibrated.error).into(),
                point: (&points.of_row).into(),
                weights: weights.into(),
            }
        };
        let Rows { reading, error, point, weights } = &fitted;
        let folds =
            if averaged { 1 } else { passes.len().min(MOST_FOLDS).min((MOST_CELLS / points.count()).max(1)) };
        let weight_of = |row: usize| {
            let gain = mirror.sensor.gain(reading[row]);
            weights[point[row] as usize] * gain * gain
        };
        let distinct = match (points.single_angles, averaged) {
            (false, false) => points.rows.clone(),
            _ => vec![1; points.count()],
        };
        // The scatter of the readings of one angle is noise and determines no polynomial.
        let order = distinct.iter().sum::<usize>().saturating_sub(1).min(MAX_ORDER);
        let basis = if reading.len() <= BASIS_ROWS {
            let squares: Vec<f64> = (0..reading.len()).map(weight_of).collect();
            Basis::new(reading, &squares, order)
        } else {
            let squares: Vec<f64> = (points.reading.iter().zip(&points.rows).zip(weights.iter()))
                .map(|((s, rows), weight)| weight * *rows as f64 * mirror.sensor.gain(*s).powi(2))
                .collect();
            Basis::new(&points.reading, &squares, order)
        };
        let mut last = (0, 0);
        let mut fold_of = |row: usize| {
            let pass = recording.pass[row];
            if row == 0 || pass != last.0 {
                let rank = passes.partition_point(|p| *p < pass);
                last = (pass, rank * folds / passes.len());
            }
            last.1
        };
        let rows = (0..reading.len()).map(|row| Row {
            reading: reading[row],
            gain: mirror.sensor.gain(reading[row]),
            error: error[row],
            fold: if averaged { 0 } else { fold_of(row) },
            point: point[row] as usize,
        });
        let grams = Grams::of(&basis, folds, points.count(), rows);
        Data { file: &prepared.file, basis, grams, distinct, rows: fitted, grouping: points.grouping }
    }

    /// Scores all candidate orders; none where the order is given and there is too little to score with.
    fn select(&self, options: &Options) -> Result<Option<Scores>, FitError> {
        let (first, last) = (*options.candidates.start(), *options.candidates.end());
        let candidates = order::Candidates { first, last, step: 1 };
        let scores =
            order::select(&self.grams, &self.rows.weights, &self.distinct, candidates, &options.splits);
        if scores.is_none() && options.order.is_none() {
            return Err(self.too_few_to_hold_out());
        }
        Ok(scores)
    }

    fn too_few_to_hold_out(&self) -> FitError {
        let (file, points) = (self.file.to_string(), self.distinct.iter().sum());
        FitError::TooFewToHoldOut { file, points, grouping: self.grouping.name() }
    }

    fn too_few_points(&self, order: usize) -> FitError {
        let points = self.distinct.iter().sum::<usize>().min(self.basis.order() + 1);
        FitError::TooFewPoints { file: self.file.to_string(), points, parameters: order + 1, order }
    }

    fn order(&self, options: &Options, scores: Option<&Scores>) -> Result<usize, FitError> {
        let order =
            options.order.or(scores.map(|scores| scores.chosen)).unwrap_or(*options.candidates.start());
        if order > self.basis.order() {
            return Err(self.too_few_points(order));
        }
        Ok(order)
    }

    fn solve(&self, mirror: &Mirror, options: &Options, order: usize) -> Result<Vec<Double>, FitError> {
        let problem = Problem {
            basis: &self.basis,
            order,
            reading: &self.rows.reading,
            gain: &|reading| mirror.sensor.gain(reading),
            error: &self.rows.error,
            weight: &|row| self.rows.weights[self.rows.point[row] as usize],
        };
        match options.solver {
            Solver::Qr => problem.solve_qr().ok_or_else(|| self.too_few_points(order)),
            Solver::TrustRegion => {
                problem.solve_trust_region(matches!(mirror.sensor, Sensor::EddyCurrentPair { .. }))
            }
        }
    }

    /// Factor of the weighted sums over everything, rows of the fit, and weighted squares of the residual.
    fn normal(&self, c: &[f64]) -> (Factor, usize, f64) {
        let sums = self.grams.total(|_, point| self.rows.weights[point]);
        (sums.factor(), sums.rows, sums.squares(c))
    }
}
