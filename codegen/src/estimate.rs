//! How well the model itself is known: its 95 % band, from the covariance of what was fitted. This is an estimate
//! of statistics, not a proof, and stands apart from the bound: the bound says how near the routine is to the
//! model, the band how near the model is to the device.
//!
//! The band at a reading is 1.96·√(vᵀCv), v being what the coefficients of polynomial and terms are multiplied by
//! there and C their joint covariance. The bound's estimate states its largest value over the range, the boxes of the further
//! inputs, and whatever a memory can hold.

use fitter::coefficients::Coefficients;
use fitter::terms::{Operator, Side, Term};

use crate::physics::{Physics, by_time, of_reading};
use crate::quantity::Quantity;

/// Two-sided 95 % of a normal distribution.
pub const NORMAL_95: f64 = 1.959_964;
/// Readings at which the band is evaluated, and values of each further input.
const POINTS: u32 = 401;
const OF_AN_INPUT: u32 = 5;
/// Combinations of what memories hold that are tried; where there are more, each counts by itself.
const MOST_COMBINATIONS: u32 = 256;

/// The largest half-width of the 95 % band over the range and the boxes, in the bound's unit; none where the
/// covariance is not known.
pub fn band(
    coefficients: &Coefficients,
    physics: &Physics,
    quantity: &Quantity,
    range: (f64, f64),
) -> Option<f64> {
    let at = |i: u32| range.0 + (range.1 - range.0) * f64::from(i) / f64::from(POINTS - 1);
    let readings: Vec<f64> = (0..POINTS).map(at).collect();
    let largest =
        deviations(coefficients, physics, quantity, range, &readings)?.into_iter().fold(0.0, f64::max);
    Some(NORMAL_95 * largest)
}

/// The standard deviation of the model at readings, in the bound's unit: the largest over the boxes of the further inputs
/// and what memories can hold; none where the covariance is not known.
pub fn deviations(
    coefficients: &Coefficients,
    physics: &Physics,
    quantity: &Quantity,
    range: (f64, f64),
    readings: &[f64],
) -> Option<Vec<f64>> {
    let all = coefficients.covariance_of_all()?;
    let size = coefficients.base.coefficients.len();
    // What is left out of the routine is left out of its band.
    let mut kept: Vec<usize> = (0..size).collect();
    let mut terms: Vec<&Term> = Vec::new();
    let mut first = size;
    for term in &coefficients.terms {
        if physics.terms.contains(term) {
            kept.extend(first..first + term.coefficients.len());
            terms.push(term);
        }
        first += term.coefficients.len();
    }
    let covariance: Vec<Vec<f64>> = kept.iter().map(|i| kept.iter().map(|j| all[*i][*j]).collect()).collect();
    let model = Model { coefficients, physics, terms, per_unit: quantity.bound_units_per_unit, range };
    let (points, gain) = (model.inputs(), model.gain_of_harmonics());
    let at = |reading: &f64| {
        let over = points.iter().map(|inputs| worst(&covariance, &model.columns(*reading, inputs)));
        gain * over.fold(0.0, f64::max)
    };
    Some(readings.iter().map(at).collect())
}

/// What a coefficient is multiplied by: a number that reading and inputs give, twice, or anything between two ends, by
/// what came before.
type Column = [f64; 2];

fn known(value: f64) -> Column {
    [value, value]
}

/// The largest standard deviation, whatever the memories hold: it is convex in them, so the ends are enough.
fn worst(covariance: &[Vec<f64>], columns: &[Column]) -> f64 {
    let open: Vec<usize> = (0..columns.len()).filter(|k| columns[*k][0] != columns[*k][1]).collect();
    let combinations = 1u32.checked_shl(open.len() as u32).filter(|n| (1..=MOST_COMBINATIONS).contains(n));
    if let Some(n) = combinations {
        let combined = |bits: u32| {
            let upper = |k: usize| open.iter().position(|o| *o == k).is_some_and(|i| bits >> i & 1 == 1);
            let v: Vec<f64> = columns.iter().enumerate().map(|(k, c)| c[usize::from(upper(k))]).collect();
            quadratic(covariance, &v).sqrt()
        };
        return (0..n).map(combined).fold(0.0, f64::max);
    }
    // A sum's deviation is at most the sum of its parts' deviations.
    let known: Vec<f64> = columns.iter().map(|[low, high]| if low == high { *low } else { 0.0 }).collect();
    let of_one =
        |k: &usize| columns[*k][1].abs().max(columns[*k][0].abs()) * covariance[*k][*k].max(0.0).sqrt();
    quadratic(covariance, &known).sqrt() + open.iter().map(of_one).sum::<f64>()
}

/// vᵀCv.
pub(crate) fn quadratic(covariance: &[Vec<f64>], v: &[f64]) -> f64 {
    let row = |row: &Vec<f64>| row.iter().zip(v).map(|(c, x)| c * x).sum::<f64>();
    covariance.iter().zip(v).map(|(r, x)| x * row(r)).sum::<f64>().max(0.0)
}

/// What the band is of.
struct Model<'a> {
    coefficients: &'a Coefficients,
    physics: &'a Physics,
    terms: Vec<&'a Term>,
    /// The bound's unit per unit of the polynomial's error.
    per_unit: f64,
    range: (f64, f64),
}

impl Model<'_> {
    /// Values of the further inputs all over their boxes.
    fn inputs(&self) -> Vec<Vec<f64>> {
        let mut points = vec![Vec::new()];
        for input in &self.physics.further {
            let at =
                |i: u32| input.from + (input.to - input.from) * f64::from(i) / f64::from(OF_AN_INPUT - 1);
            let longer = |point: &Vec<f64>, i: u32| point.iter().copied().chain([at(i)]).collect();
            points = points.iter().flat_map(|p| (0..OF_AN_INPUT).map(move |i| longer(p, i))).collect();
        }
        points
    }

    /// An observable where the reading is this and the further inputs are these.
    fn observed(&self, name: &str, reading: f64, inputs: &[f64]) -> f64 {
        let further = self.physics.further.iter().zip(inputs).find(|(g, _)| g.observable == name);
        let of_reading = || of_reading(&self.coefficients.sensor, name, reading).unwrap_or(reading);
        further.map_or_else(of_reading, |(_, value)| *value)
    }

    /// The ends between which an observable lies: each rises with what it is a function of.
    fn ends(&self, name: &str) -> [f64; 2] {
        [0, 1].map(|end| {
            let inputs: Vec<f64> =
                self.physics.further.iter().map(|g| if end == 0 { g.from } else { g.to }).collect();
            self.observed(name, if end == 0 { self.range.0 } else { self.range.1 }, &inputs)
        })
    }

    /// What each coefficient is multiplied by, in the bound's unit.
    fn columns(&self, reading: f64, inputs: &[f64]) -> Vec<Column> {
        let sensor = &self.coefficients.sensor;
        let x = reading - self.coefficients.base.centre;
        let mut power = sensor.gain(reading) * self.per_unit;
        let mut columns = Vec::new();
        for _ in &self.coefficients.base.coefficients {
            columns.push(known(power));
            power *= x;
        }
        // Coefficients of terms are in the unit of statistics, as the bound is.
        for term in &self.terms {
            self.of_term(term, reading, inputs, &mut columns);
        }
        columns
    }

    fn of_term(&self, term: &Term, reading: f64, inputs: &[f64], into: &mut Vec<Column>) {
        let observed = |name: &str| self.observed(name, reading, inputs);
        into.push(match &term.operator {
            Operator::Product(product) => {
                let factors = product.factors.iter();
                known(factors.map(|f| (observed(&f.observable) - f.mean).powi(i32::from(f.power))).product())
            }
            Operator::Play(play) => {
                return into.extend(play.elements.iter().map(|e| [-e.half_width, e.half_width]));
            }
            Operator::Lag(lag) => self.ends(&lag.observable).map(|v| v - lag.mean),
            // Across the whole range from one call to the next.
            Operator::Rate(rate) => {
                let [low, high] = self.ends(&rate.observable);
                let most = (high - low).abs() / self.physics.period_s;
                [-most, most]
            }
            Operator::Hinge(hinge) => {
                let beyond = observed(&hinge.observable) - hinge.threshold;
                known(if hinge.side == Side::Above { beyond } else { -beyond }.max(0.0))
            }
            Operator::Gaussian(gaussian) => {
                let z = (observed(&gaussian.observable) - gaussian.centre) / gaussian.width;
                known((-0.5 * z * z).exp())
            }
            Operator::Exponential(e) if by_time(e, &self.physics.further) => [0.0, 1.0],
            Operator::Exponential(e) => {
                let since = (observed(&e.observable) - e.start).max(0.0);
                known(-(-since / e.scale).exp_m1())
            }
            Operator::Step(step) => known(f64::from(u8::from(observed(&step.observable) >= step.at))),
            Operator::Expression(_) => {
                return into.extend((0..term.coefficients.len()).map(|k| self.of_factor(term, k, &observed)));
            }
            Operator::Periodic(periodic) => {
                let truth = self.coefficients.error_model().corrected(reading) * self.per_unit;
                return into.extend(periodic.columns_at(truth).into_iter().map(known));
            }
        });
    }

    /// What factor `k` of an expression is multiplied by: of one that remembers, anything that it can be over the range
    /// and the boxes.
    fn of_factor(&self, term: &Term, k: usize, observed: &dyn Fn(&str) -> f64) -> Column {
        let mut unit = Term { coefficients: vec![0.0; term.coefficients.len()], ..term.clone() };
        unit.coefficients[k] = 1.0;
        let anything = [f64::NEG_INFINITY, f64::INFINITY];
        let Some(tree) = self.physics.tree(&unit) else { return anything };
        if !tree.remembers() {
            return known(tree.at(observed));
        }
        let over = |name: &str| {
            let [from, to] = self.ends(name);
            physics::Interval { from, to }
        };
        tree.interval(&over, self.physics.period_s).map_or(anything, |found| [found.from, found.to])
    }

    /// How much an error of the model is enlarged where the result is a solution with harmonics of itself.
    fn gain_of_harmonics(&self) -> f64 {
        let steepest = self.terms.iter().map(|t| match &t.operator {
            Operator::Periodic(periodic) => periodic.steepest(&t.coefficients),
            _ => 0.0,
        });
        1.0 / (1.0 - steepest.sum::<f64>()).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two coefficients that are known only together: their sum is known well, each by itself badly.
    #[test]
    fn what_is_fitted_jointly_is_known_jointly() {
        let covariance = vec![vec![4.0, -3.9], vec![-3.9, 4.0]];
        let sum = worst(&covariance, &[known(1.0), known(1.0)]);
        assert!((sum - 0.2f64.sqrt()).abs() < 1e-12, "{sum}");
        // A memory that can take either sign takes the worse.
        let free = worst(&covariance, &[known(1.0), [-1.0, 1.0]]);
        assert!((free - 15.8f64.sqrt()).abs() < 1e-12, "{free}");
        // Too many to be combined: the sum of the deviations, which is more than any combination's.
        let n = 12;
        let unit: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        let many = worst(&unit, &vec![[-1.0, 1.0]; n]);
        assert!((many - n as f64).abs() < 1e-12, "{many}");
    }
}
