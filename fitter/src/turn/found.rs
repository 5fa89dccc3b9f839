//! The solution of a whole turn in the sensor's unit, and the coefficients file that it makes.

use std::f64::consts::SQRT_2;

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::beside::Kind;
use super::correct::Corrections;
use super::description::{Directions, Estimate, Slope};
use super::direction::variation;
use super::harmonics::Harmonics;
use super::solve::Solution;
use super::{Amplitude, Turn};
use crate::coefficients::{Coefficients, Identification, Parameter, Provenance, Recorded};
use crate::error_model::ErrorModel;
use crate::order::OrderSelection;
use crate::statistics::{PointMoments, Statistics, readable, statistics};
use crate::terms::{Operator, Periodic, Product, Rate, Scope, Term};
use crate::weights::{Scatter, Variance};

/// The solution in the sensor's unit.
pub(super) struct Found {
    constant: f64,
    /// Coefficients of the columns beside the harmonics.
    beside: Vec<f64>,
    /// Coefficients of cos and sin, and their covariance.
    waves: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    /// Standard errors of the constant and of the columns beside the harmonics.
    errors: Vec<f64>,
    freedom: usize,
    variance: f64,
    quantile: Option<f64>,
    pub corrections: Corrections,
}

impl Found {
    pub fn of(problem: &Harmonics, solution: &Solution, corrections: Corrections) -> Found {
        let rows = problem.recording.rows();
        let root = (rows as f64).sqrt();
        let (count, before) = (solution.c.len(), 1 + problem.beside.len());
        let scale_of = |column: usize| match column {
            0 => 1.0 / root,
            column if column < before => 1.0 / (root * problem.beside[column - 1].length),
            _ => SQRT_2 / root,
        };
        let freedom = rows.saturating_sub(count);
        let variance = if freedom > 0 { solution.squares / freedom as f64 } else { 0.0 };
        let c: Vec<f64> = (0..count).map(|column| scale_of(column) * solution.c[column]).collect();
        let inverse = solution.factor.inverse(count - 1);
        let covariance = |i: usize, j: usize| scale_of(i) * scale_of(j) * inverse[i][j] * variance;
        let quantile = StudentsT::new(0.0, 1.0, freedom.max(1) as f64).ok().map(|t| t.inverse_cdf(0.975));
        Found {
            constant: c[0],
            beside: c[1..before].to_vec(),
            waves: c[before..].to_vec(),
            covariance: (before..count)
                .map(|i| (before..count).map(|j| covariance(i, j)).collect())
                .collect(),
            errors: (0..before).map(|i| covariance(i, i).max(0.0).sqrt()).collect(),
            freedom,
            variance,
            quantile: quantile.filter(|_| freedom > 0),
            corrections,
        }
    }

    /// What the harmonics leave: they know neither direction nor speed.
    pub fn corrected_residual(&self, problem: &Harmonics, solution: &Solution) -> Vec<f64> {
        (0..solution.residual.len()).map(|row| solution.residual[row] + self.moving(problem, row)).collect()
    }

    /// What the columns beside the harmonics add to the error of a row.
    fn moving(&self, problem: &Harmonics, row: usize) -> f64 {
        problem.beside.iter().zip(&self.beside).map(|(column, c)| c * column.values[row]).sum()
    }

    /// `factor` times the coefficient of a column beside the harmonics; none where it was not fitted.
    fn estimate(&self, problem: &Harmonics, kind: Kind, factor: f64) -> Option<Estimate> {
        let place = problem.place(kind)?;
        let value = self.beside[place];
        match problem.beside[place].tested {
            Some(tested) => Some(tested.estimate(value, factor)),
            None => Some(Estimate::of(factor * value, self.errors[1 + place], self.quantile?)),
        }
    }

    fn directions(&self, problem: &Harmonics, solution: &Solution) -> Directions {
        let mut found = Directions::default();
        if self.quantile.is_some() {
            let phase = |row: usize| problem.phase[row];
            let variation = || variation(problem.recording, &solution.residual, self.freedom, &phase);
            found.half_distance = self.estimate(problem, Kind::Direction, 1.0);
            found.lag_s = self.estimate(problem, Kind::Velocity, -1.0);
            found.lag_corrected = self.corrections.lag;
            found.variation_rms = problem.motion.both.then(variation).flatten();
        }
        found.of(&problem.motion, problem.unit)
    }

    /// The slope over the turn, where it is in the model.
    fn slope(&self, problem: &Harmonics) -> Option<Slope> {
        let per_turn = self.estimate(problem, Kind::Slope, problem.turn)?;
        Some(Slope::of(per_turn, &problem.mirror.sensor))
    }

    /// The terms, the harmonics first.
    fn terms(&self, problem: &Harmonics) -> Vec<Term> {
        let mut terms = Vec::new();
        if !self.waves.is_empty() {
            terms.push(Term {
                effect: physics::found_by_fit("harmonics"),
                scope: Scope::Device,
                operator: Operator::Periodic(Periodic::of(problem.turn, (self.waves.len() / 2) as u16)),
                coefficients: self.waves.clone(),
                covariance: if self.freedom > 0 { self.covariance.clone() } else { Vec::new() },
            });
        }
        let mut also = |found: &str, kind: Kind, operator: Operator| {
            let Some(place) = problem.place(kind) else { return };
            let error = self.estimate(problem, kind, 1.0).map(|estimate| estimate.standard_error);
            terms.push(Term {
                effect: physics::found_by_fit(found),
                scope: Scope::Device,
                operator,
                coefficients: vec![self.beside[place]],
                covariance: error.map_or(Vec::new(), |error| vec![vec![error * error]]),
            });
        };
        if let Some(middle) = self.corrections.middle {
            also("slope", Kind::Slope, Operator::Product(Product::of("measured", middle)));
        }
        if self.corrections.lag {
            also("lag", Kind::Velocity, Operator::Rate(Rate::of("measured")));
        }
        terms
    }

    /// Errors before and after. Where the sensor has its zero is no error: `before` is what harmonics, directions, slope
    /// and lag make.
    pub fn statistics(&self, problem: &Harmonics, residual: &[f64]) -> Statistics {
        let error: Vec<f64> = problem.unwound.error.iter().map(|error| error - self.constant).collect();
        let scatter = self.scatter(problem);
        statistics(&problem.points, &error, residual, 1.0, problem.unit, scatter)
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
        Variance::pooled(&variances).scatter(false)
    }

    pub fn file(
        &self,
        problem: &Harmonics,
        selection: Option<OrderSelection>,
        solution: &Solution,
    ) -> Coefficients {
        let Harmonics { recording, mirror, options, unwound, turn, .. } = problem;
        let (sensor, from) = (mirror.sensor.clone(), unwound.from);
        let model = ErrorModel { sensor, centre: from + 0.5 * turn, coefficients: vec![self.constant] };
        let mut file = Coefficients::of_model(&model, from, from + turn, &options.command);
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
        file.set_recorded(Recorded::of(recording, mirror.reference, &solution.residual));
        file.terms = self.terms(problem);
        file.turn = Some(Turn {
            from,
            counts_turns: unwound.counts_turns,
            wraps: unwound.wraps,
            harmonics: selection,
            amplitudes: self.amplitudes(),
            directions: self.directions(problem, solution),
            slope: self.slope(problem),
            left: self.corrections.left.clone(),
            ..Turn::single(*turn)
        });
        file
    }
}
