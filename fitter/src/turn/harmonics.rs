//! The harmonics of the turn: their number by cross-validation, their coefficients by least squares.

use std::f64::consts::{SQRT_2, TAU};

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::arc::hull;
use super::direction::{Directions, Estimate, Motion, variation};
use super::solve::{Columns, Solution};
use super::{Amplitude, Turn, Unwound};
use crate::basis::Basis;
use crate::coefficients::{Coefficients, Identification, Parameter, Provenance, VERSION_TURN};
use crate::error_model::ErrorModel;
use crate::fit::{Calibrated, Fit, FitError, FitNote, Options, order_selection};
use crate::mirror::Mirror;
use crate::order::{Candidates, OrderSelection, Scores, select};
use crate::points::Points;
use crate::recording::Recording;
use crate::statistics::{PointMoments, readable, statistics};
use crate::terms::{Operator, Periodic, Scope, Term};
use crate::weights::Scatter;

/// Most harmonics that are tried.
pub(crate) const MAX_HARMONICS: usize = 32;
/// Most folds of passes, and most cells of folds and points.
const MOST_FOLDS: usize = 10;
const MOST_CELLS: usize = 2048;

/// The problem of one recording.
pub(crate) struct Harmonics<'a> {
    recording: &'a Recording,
    mirror: &'a Mirror,
    options: &'a Options,
    unwound: Unwound,
    turn: f64,
    unit: &'a str,
    motion: Motion,
    points: Points,
    /// Cosine and sine of the reference's phase, row by row.
    phase: Vec<(f64, f64)>,
    /// Length of the velocity column, to scale it by; 1 without.
    speed: f64,
}

impl<'a> Harmonics<'a> {
    pub fn of(
        recording: &'a Recording,
        mirror: &'a Mirror,
        options: &'a Options,
        unwound: Unwound,
        turn: f64,
    ) -> Harmonics<'a> {
        let motion = Motion::of(recording, &unwound);
        let points = Points::around(recording, &unwound.reading, turn);
        let phase = (unwound.reference.iter())
            .map(|reference| {
                let turns = reference / turn;
                let angle = TAU * (turns - turns.floor());
                (libm::cos(angle), libm::sin(angle))
            })
            .collect();
        let length = |v: &Vec<f64>| (v.iter().map(|v| v * v).sum::<f64>() / v.len() as f64).sqrt();
        let speed = motion.velocity.as_ref().map_or(1.0, length);
        let unit = mirror.sensor.error_unit();
        Harmonics { recording, mirror, options, unwound, turn, unit, motion, points, phase, speed }
    }

    /// Number of columns before the harmonics, apart from the constant: direction, velocity.
    fn beside(&self) -> usize {
        usize::from(self.motion.both) + usize::from(self.motion.velocity.is_some())
    }

    /// Columns of length 1 about: constant, direction, velocity, then cos and sin of each harmonic.
    fn fill(&self, row: usize, values: &mut [f64]) {
        let scale = 1.0 / (self.recording.rows() as f64).sqrt();
        values[0] = scale;
        let mut next = 1;
        if self.motion.both {
            values[next] = scale * f64::from(self.recording.direction[row]);
            next += 1;
        }
        if let Some(velocity) = &self.motion.velocity {
            values[next] = scale * velocity[row] / self.speed;
            next += 1;
        }
        let (cosine, sine) = self.phase[row];
        let (mut c, mut s) = (cosine, sine);
        for pair in values[next..].chunks_exact_mut(2) {
            (pair[0], pair[1]) = (SQRT_2 * scale * c, SQRT_2 * scale * s);
            (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
        }
    }

    /// The most harmonics that the gaps between the readings allow to tell.
    fn most(&self) -> usize {
        let points = self.points.count();
        let gap = self.turn - hull(&self.points.reading, self.turn).length;
        let by_gap = (0.5 * self.turn / gap.max(1e-9 * self.turn)) as usize;
        let by_points = (0.7 * points as f64) as usize;
        MAX_HARMONICS.min(by_gap).min(by_points.saturating_sub(self.beside() + 2) / 2)
    }

    fn scores(&self) -> Option<Scores> {
        let (first, points) = (self.beside(), self.points.count());
        let last = first + 2 * self.most();
        let passes = self.recording.passes();
        let folds = passes.len().min(MOST_FOLDS).min((MOST_CELLS / points).max(1));
        let cell = |row: usize| {
            let rank = passes.partition_point(|pass| *pass < self.recording.pass[row]);
            (rank * folds / passes.len(), self.points.of_row[row] as usize)
        };
        let columns = self.columns(self.most());
        let grams = columns.grams(folds, points, &self.unwound.error, &cell);
        let distinct = if self.points.single_angles { vec![1; points] } else { self.points.rows.clone() };
        let candidates = Candidates { first, last, step: 2 };
        select(&grams, &vec![1.0; points], &distinct, candidates, &self.options.splits)
    }

    fn columns(&self, harmonics: usize) -> Columns<'_> {
        let count = 1 + self.beside() + 2 * harmonics;
        Columns { count, rows: self.recording.rows(), fill: Box::new(|row, values| self.fill(row, values)) }
    }

    /// Both curves over the number of harmonics, which stands in the place of the order.
    fn selection(&self, scores: &Scores, chosen: usize) -> OrderSelection {
        let (options, points, sensor) = (self.options, &self.points, &self.mirror.sensor);
        let harmonics = |order: usize| (order - self.beside()) / 2;
        let mut selection =
            order_selection(scores, chosen, options.harmonics.is_some(), options, points, sensor);
        selection.smallest_testing_error = harmonics(selection.smallest_testing_error);
        selection.curve.iter_mut().for_each(|score| score.order = harmonics(score.order));
        selection
    }

    /// Chooses the number of harmonics alone.
    ///
    /// # Errors
    /// [`FitError::TooFewToHoldOut`].
    pub fn choose(&self) -> Result<OrderSelection, FitError> {
        let scores = self.scores().ok_or_else(|| self.too_few_to_hold_out())?;
        Ok(self.selection(&scores, (scores.chosen - self.beside()) / 2))
    }

    fn too_few_to_hold_out(&self) -> FitError {
        FitError::TooFewToHoldOut {
            file: self.recording.file.clone(),
            points: self.points.count(),
            grouping: self.points.grouping.name(),
        }
    }
}

/// Fits the harmonics of the turn.
///
/// # Errors
/// [`FitError`]: too few angles to choose the number of harmonics, or to determine the one that was given.
pub(crate) fn fit(problem: Harmonics) -> Result<Fit, FitError> {
    let (recording, options) = (problem.recording, problem.options);
    let scores = problem.scores();
    let chosen = match (options.harmonics, &scores) {
        (Some(given), _) => given,
        (None, Some(scores)) => (scores.chosen - problem.beside()) / 2,
        (None, None) => return Err(problem.too_few_to_hold_out()),
    };
    let columns = problem.columns(chosen);
    let solution =
        columns.solve(&problem.unwound.error).filter(|_| chosen <= problem.most()).ok_or_else(|| {
            FitError::TooFewForHarmonics {
                file: recording.file.clone(),
                points: problem.points.count(),
                harmonics: chosen,
                most: problem.most(),
            }
        })?;
    let found = Found::of(&problem, &solution, columns.count);
    drop(columns);
    let mut notes: Vec<FitNote> = recording.notes.iter().cloned().map(FitNote::Reading).collect();
    if recording.passes().len() == 1 {
        notes.push(FitNote::SinglePass);
    }
    let selection = scores.map(|scores| problem.selection(&scores, chosen));
    let residual = found.corrected_residual(&problem, &solution);
    let coefficients = found.file(&problem, selection, &solution, &residual);
    let Harmonics { unwound, points, .. } = problem;
    let weights = vec![1.0; points.count()];
    let basis = Basis::new(&points.reading, &weights, 1);
    let calibrated = Calibrated::from_columns(unwound.reading, unwound.error);
    let dependences = Vec::new();
    // Directions are told already: what else the errors depend on is looked for in what they leave.
    let left = solution.residual;
    let mut fit =
        Fit { coefficients, calibrated, residual: left, points, weights, basis, dependences, notes };
    if fit.points.single_angles {
        fit.dependences = crate::dependence::dependences(recording, &fit);
    }
    fit.residual = residual;
    Ok(fit)
}

/// The solution in the sensor's unit.
struct Found {
    constant: f64,
    /// Coefficients of the direction and of the velocity per row, if they are columns.
    direction: Option<f64>,
    velocity: Option<f64>,
    /// Coefficients of cos and sin, and their covariance.
    waves: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    /// Standard errors of constant, direction and velocity, in that order.
    errors: Vec<f64>,
    freedom: usize,
    variance: f64,
    quantile: Option<f64>,
}

impl Found {
    fn of(problem: &Harmonics, solution: &Solution, count: usize) -> Found {
        let rows = problem.recording.rows();
        let root = (rows as f64).sqrt();
        let before = 1 + problem.beside();
        let scale_of = |column: usize| {
            let velocity = problem.motion.velocity.is_some() && column + 1 == before;
            match (column < before, velocity) {
                (true, true) => 1.0 / (root * problem.speed),
                (true, false) => 1.0 / root,
                (false, _) => SQRT_2 / root,
            }
        };
        let freedom = rows.saturating_sub(count);
        let variance = if freedom > 0 { solution.squares / freedom as f64 } else { 0.0 };
        let c: Vec<f64> = (0..count).map(|column| scale_of(column) * solution.c[column]).collect();
        let inverse = solution.factor.inverse(count - 1);
        let covariance = |i: usize, j: usize| scale_of(i) * scale_of(j) * inverse[i][j] * variance;
        let both = problem.motion.both;
        let quantile = StudentsT::new(0.0, 1.0, freedom.max(1) as f64).ok().map(|t| t.inverse_cdf(0.975));
        Found {
            constant: c[0],
            direction: both.then(|| c[1]),
            velocity: problem.motion.velocity.as_ref().map(|_| c[before - 1]),
            waves: c[before..].to_vec(),
            covariance: (before..count)
                .map(|i| (before..count).map(|j| covariance(i, j)).collect())
                .collect(),
            errors: (0..before).map(|i| covariance(i, i).max(0.0).sqrt()).collect(),
            freedom,
            variance,
            quantile: quantile.filter(|_| freedom > 0),
        }
    }

    /// What the correction leaves: it knows neither direction nor speed.
    fn corrected_residual(&self, problem: &Harmonics, solution: &Solution) -> Vec<f64> {
        (0..solution.residual.len()).map(|row| solution.residual[row] + self.moving(problem, row)).collect()
    }

    /// What direction and velocity add to the error of a row.
    fn moving(&self, problem: &Harmonics, row: usize) -> f64 {
        let direction = self.direction.map_or(0.0, |h| h * f64::from(problem.recording.direction[row]));
        let velocity = self.velocity.zip(problem.motion.velocity.as_ref());
        direction + velocity.map_or(0.0, |(c, velocity)| c * velocity[row])
    }

    fn directions(&self, problem: &Harmonics, solution: &Solution) -> Directions {
        let Some(quantile) = self.quantile else {
            return Directions::of(&problem.motion, None, None, None, problem.unit);
        };
        let half = self.direction.map(|h| Estimate::of(h, self.errors[1], quantile));
        let lag = self.velocity.map(|c| Estimate::of(-c, self.errors[problem.beside()], quantile));
        let phase = |row: usize| problem.phase[row];
        let varies = (problem.motion.both)
            .then(|| variation(problem.recording, &solution.residual, self.freedom, &phase))
            .flatten();
        Directions::of(&problem.motion, half, lag, varies, problem.unit)
    }

    fn amplitudes(&self) -> Vec<Amplitude> {
        (self.waves.chunks_exact(2).enumerate())
            .map(|(index, pair)| {
                let amplitude = pair[0].hypot(pair[1]);
                let (i, j) = (2 * index, 2 * index + 1);
                let (c, s) = (pair[0] / amplitude, pair[1] / amplitude);
                let v = &self.covariance;
                let variance = c * c * v[i][i] + 2.0 * c * s * v[i][j] + s * s * v[j][j];
                Amplitude {
                    harmonic: index as u16 + 1,
                    amplitude: readable(amplitude),
                    phase_deg: readable(libm::atan2(pair[1], pair[0]).to_degrees()),
                    standard_error: self.quantile.map(|_| readable(variance.max(0.0).sqrt())),
                }
            })
            .collect()
    }

    fn scatter(&self, problem: &Harmonics) -> Option<Scatter> {
        let points = &problem.points;
        if !points.single_angles {
            return None;
        }
        let value = |row: usize| problem.unwound.error[row] - self.moving(problem, row);
        let variances = PointMoments::of(points, value).variances();
        let freedom: usize = variances.iter().map(|v| v.freedom).sum();
        let squares: f64 = variances.iter().map(|v| v.value * v.freedom as f64).sum();
        (freedom > 0).then(|| Scatter {
            standard_deviation: readable((squares / freedom as f64).sqrt()),
            degrees_of_freedom: freedom,
            weighted: false,
        })
    }

    fn file(
        &self,
        problem: &Harmonics,
        selection: Option<OrderSelection>,
        solution: &Solution,
        residual: &[f64],
    ) -> Coefficients {
        let Harmonics { recording, mirror, options, unwound, turn, .. } = problem;
        let (sensor, from) = (mirror.sensor.clone(), unwound.from);
        let model = ErrorModel { sensor, centre: from + 0.5 * turn, coefficients: vec![self.constant] };
        let mut file = Coefficients::of_model(&model, from, from + turn, &options.command);
        file.version = VERSION_TURN;
        file.recording = Provenance::of(recording);
        let error = self.errors[0];
        file.identification = Some(Identification {
            solver: "sums of products, refined".to_string(),
            fitted: "rows".to_string(),
            zero: None,
            parameters: vec![Parameter {
                name: "a0".to_string(),
                value: self.constant,
                unit: problem.unit.to_string(),
                standard_error: self.quantile.map(|_| readable(error)),
                ci95: self
                    .quantile
                    .map(|t| [readable(self.constant - t * error), readable(self.constant + t * error)]),
            }],
            covariance: if self.freedom > 0 { vec![vec![error * error]] } else { Vec::new() },
            residual_standard_deviation: readable(self.variance.sqrt()),
            degrees_of_freedom: self.freedom,
            probe_distance_error_mm: None,
            unidentifiable: Vec::new(),
        });
        let scatter = self.scatter(problem);
        // Where the sensor has its zero is no error: `before` is what the harmonics and the directions make.
        let error: Vec<f64> = unwound.error.iter().map(|error| error - self.constant).collect();
        file.statistics = Some(statistics(&problem.points, &error, residual, 1.0, problem.unit, scatter));
        if !self.waves.is_empty() {
            file.terms.push(Term {
                effect: "periodic_error".to_string(),
                scope: Scope::Device,
                operator: Operator::Periodic(Periodic::of(*turn, (self.waves.len() / 2) as u16)),
                coefficients: self.waves.clone(),
                covariance: if self.freedom > 0 { self.covariance.clone() } else { Vec::new() },
            });
        }
        file.turn = Some(Turn {
            revolution: *turn,
            from,
            counts_turns: unwound.counts_turns,
            whole: true,
            wraps: unwound.wraps,
            harmonics: selection,
            amplitudes: self.amplitudes(),
            directions: self.directions(problem, solution),
        });
        file
    }
}
