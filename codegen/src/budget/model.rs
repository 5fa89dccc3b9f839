//! How well the model itself is known, from the joint covariance C of what was fitted: √(vᵀCv) at a reading, v being what the
//! coefficients of polynomial and terms are multiplied by there; the largest over the boxes of the further inputs, and
//! whatever a memory can hold.
//!
//! A budget adds squares of what is independent. So it is taken apart by Cholesky's factor, the terms' coefficients first: each
//! contributes what it does not share with those before it, the others following it as the fit makes them.

use fitter::coefficients::Coefficients;
use fitter::terms::{Operator, Side, Term};

use crate::physics::{Physics, by_time, of_reading};
use crate::quantity::Quantity;

/// Values of each further input.
const OF_AN_INPUT: u32 = 5;
/// Combinations of what memories hold that are tried; where there are more, each counts by itself.
const MOST_COMBINATIONS: u32 = 256;

/// How well a model is known at a place.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Known {
    /// Standard deviation of what the coefficients of terms leave, in the budget's unit.
    pub rest: f64,
    /// Every coefficient of the terms.
    pub terms: Vec<OfTerm>,
}

/// A coefficient of a term.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OfTerm {
    /// Which.
    pub what: String,
    /// Its unit.
    pub unit: String,
    /// Its standard deviation beyond what it shares with those before it.
    pub deviation: f64,
    /// The change of the result by one unit of it, the coefficients after it following.
    pub sensitivity: f64,
}

impl Known {
    /// Standard deviation of the model.
    pub fn deviation(&self) -> f64 {
        self.terms.iter().fold(self.rest, |sum, of| sum.hypot(of.deviation * of.sensitivity))
    }
}

/// How well the model is known at readings, in the bound's unit; none where the covariance is not known.
pub(crate) fn known(
    coefficients: &Coefficients,
    physics: &Physics,
    quantity: &Quantity,
    range: (f64, f64),
    readings: &[f64],
) -> Option<Vec<Known>> {
    let all = coefficients.covariance_of_all()?;
    let size = coefficients.base.coefficients.len();
    // What is left out of the routine is left out of its interval. The terms come first.
    let (mut kept, mut terms): (Vec<usize>, Vec<&Term>) = (Vec::new(), Vec::new());
    let mut first = size;
    for term in &coefficients.terms {
        if physics.terms.contains(term) {
            kept.extend(first..first + term.coefficients.len());
            terms.push(term);
        }
        first += term.coefficients.len();
    }
    let of_terms = kept.len();
    kept.extend(0..size);
    let covariance: Vec<Vec<f64>> = kept.iter().map(|i| kept.iter().map(|j| all[*i][*j]).collect()).collect();
    let model = Model { coefficients, physics, terms, per_unit: quantity.bound_units_per_unit, range };
    let (points, gain) = (model.inputs(), model.gain_of_harmonics());
    let (names, factor) = (model.names(), cholesky(&covariance));
    let at = |reading: &f64| {
        let over = points.iter().map(|inputs| worst(&covariance, &model.columns(*reading, inputs)));
        let (deviation, columns) = over.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        let own = |k: usize| (k..columns.len()).map(|i| factor[i][k] * columns[i]).sum::<f64>();
        let own: Vec<f64> = (0..columns.len()).map(own).collect();
        let sum = own.iter().map(|own| own * own).sum::<f64>().sqrt();
        let scale = if sum > 0.0 { gain * deviation / sum } else { 0.0 };
        let of_term = |(k, (what, unit)): (usize, &(String, String))| {
            let deviation = factor[k][k];
            let sensitivity = if deviation > 0.0 { scale * own[k] / deviation } else { 0.0 };
            OfTerm { what: what.clone(), unit: unit.clone(), deviation, sensitivity }
        };
        Known {
            rest: scale * own[of_terms..].iter().map(|own| own * own).sum::<f64>().sqrt(),
            terms: names.iter().enumerate().map(of_term).collect(),
        }
    };
    Some(readings.iter().map(at).collect())
}

/// The lower triangle L with L Lᵀ = C. What the earlier coefficients determine wholly has a column of zeros.
fn cholesky(covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    /// Part of a variance below which what is left of it is rounding.
    const ROUNDING: f64 = 1e-12;
    let n = covariance.len();
    let mut factor = vec![vec![0.0; n]; n];
    for k in 0..n {
        let left = |i: usize, factor: &[Vec<f64>]| {
            covariance[i][k] - (0..k).map(|j| factor[i][j] * factor[k][j]).sum::<f64>()
        };
        let pivot = left(k, &factor);
        if pivot > ROUNDING * covariance[k][k] {
            for i in k..n {
                factor[i][k] = left(i, &factor) / pivot.sqrt();
            }
        }
    }
    factor
}

/// What a coefficient is multiplied by: a number that reading and inputs give, twice, or anything between two ends, by
/// what came before.
type Column = [f64; 2];

fn fixed(value: f64) -> Column {
    [value, value]
}

/// The largest standard deviation, whatever the memories hold, and the columns there: it is convex in them, so the ends are
/// enough.
fn worst(covariance: &[Vec<f64>], columns: &[Column]) -> (f64, Vec<f64>) {
    let open: Vec<usize> = (0..columns.len()).filter(|k| columns[*k][0] != columns[*k][1]).collect();
    let combinations = 1u32.checked_shl(open.len() as u32).filter(|n| (1..=MOST_COMBINATIONS).contains(n));
    let combined = |bits: u32| {
        let upper = |k: usize| open.iter().position(|o| *o == k).is_some_and(|i| bits >> i & 1 == 1);
        let v: Vec<f64> = columns.iter().enumerate().map(|(k, c)| c[usize::from(upper(k))]).collect();
        (quadratic(covariance, &v).sqrt(), v)
    };
    if let Some(n) = combinations {
        return (0..n).map(combined).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    }
    // A sum's deviation is at most the sum of its parts' deviations.
    let certain: Vec<f64> = columns.iter().map(|[low, high]| if low == high { *low } else { 0.0 }).collect();
    let largest = |k: usize| columns[k][1].abs().max(columns[k][0].abs());
    let of_one = |k: &usize| largest(*k) * covariance[*k][*k].max(0.0).sqrt();
    let sum = quadratic(covariance, &certain).sqrt() + open.iter().map(of_one).sum::<f64>();
    let v = (0..columns.len()).map(|k| if open.contains(&k) { largest(k) } else { certain[k] });
    (sum, v.collect())
}

/// vᵀCv.
pub(crate) fn quadratic(covariance: &[Vec<f64>], v: &[f64]) -> f64 {
    let row = |row: &Vec<f64>| row.iter().zip(v).map(|(c, x)| c * x).sum::<f64>();
    covariance.iter().zip(v).map(|(r, x)| x * row(r)).sum::<f64>().max(0.0)
}

/// What is known.
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
        // Coefficients of terms are in the unit of statistics, as the bound is.
        for term in &self.terms {
            self.of_term(term, reading, inputs, &mut columns);
        }
        for _ in &self.coefficients.base.coefficients {
            columns.push(fixed(power));
            power *= x;
        }
        columns
    }

    /// What each coefficient of the terms is, and its unit.
    fn names(&self) -> Vec<(String, String)> {
        let of = |term: &&Term| {
            let unit = &self.coefficients.units.statistics;
            let name = |k: usize| {
                let which = if term.coefficients.len() > 1 { format!(" {}", k + 1) } else { String::new() };
                (format!("term {}: coefficient{which}", term.effect), term.operator.coefficient_unit(k, unit))
            };
            (0..term.coefficients.len()).map(name).collect::<Vec<_>>()
        };
        self.terms.iter().flat_map(of).collect()
    }

    fn of_term(&self, term: &Term, reading: f64, inputs: &[f64], into: &mut Vec<Column>) {
        let observed = |name: &str| self.observed(name, reading, inputs);
        into.push(match &term.operator {
            Operator::Product(product) => {
                let factors = product.factors.iter();
                fixed(factors.map(|f| (observed(&f.observable) - f.mean).powi(i32::from(f.power))).product())
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
                fixed(if hinge.side == Side::Above { beyond } else { -beyond }.max(0.0))
            }
            Operator::Gaussian(gaussian) => {
                let z = (observed(&gaussian.observable) - gaussian.centre) / gaussian.width;
                fixed((-0.5 * z * z).exp())
            }
            Operator::Exponential(e) if by_time(e, &self.physics.further) => [0.0, 1.0],
            Operator::Exponential(e) => {
                let since = (observed(&e.observable) - e.start).max(0.0);
                fixed(-(-since / e.scale).exp_m1())
            }
            Operator::Step(step) => fixed(f64::from(u8::from(observed(&step.observable) >= step.at))),
            Operator::Expression(_) => {
                return into.extend((0..term.coefficients.len()).map(|k| self.of_factor(term, k, &observed)));
            }
            Operator::Periodic(periodic) => {
                let truth = self.coefficients.error_model().corrected(reading) * self.per_unit;
                return into.extend(periodic.columns_at(truth).into_iter().map(fixed));
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
            return fixed(tree.at(observed));
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
        let sum = worst(&covariance, &[fixed(1.0), fixed(1.0)]).0;
        assert!((sum - 0.2f64.sqrt()).abs() < 1e-12, "{sum}");
        // A memory that can take either sign takes the worse.
        let free = worst(&covariance, &[fixed(1.0), [-1.0, 1.0]]).0;
        assert!((free - 15.8f64.sqrt()).abs() < 1e-12, "{free}");
        // Too many to be combined: the sum of the deviations, which is more than any combination's.
        let n = 12;
        let unit: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        let many = worst(&unit, &vec![[-1.0, 1.0]; n]).0;
        assert!((many - n as f64).abs() < 1e-12, "{many}");
    }
}
