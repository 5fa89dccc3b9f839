//! Standard errors of an inverse model. No model explains all of a real drive, and what it leaves is correlated over long
//! stretches, so that the errors of white noise are too small. Successive parts of the recording disagree by as much as the
//! estimates are really uncertain.

use numerics::Symmetric;

use super::inverse::{Column, Solved, model_columns, normal_equations};
use super::motion::Motion;
use crate::dynamic::effects::Part;
use crate::intervals::widening;
use crate::thresholds::dynamic::feedback::errors::PARTS;

/// A sum of coefficients: their numbers and weights.
type Sum = Vec<(usize, f64)>;

/// What the errors of sums of coefficients follow from, on some rows.
struct Errors {
    /// Of white noise below the cut-off.
    of_noise: Symmetric,
    /// By how much parts disagree; none where the estimates are compared with those of the same motion, along which what is
    /// left of structure is the same.
    of_parts: Option<Symmetric>,
}

impl Errors {
    fn of(
        residual: &[f64],
        motion: &Motion,
        same_motion: bool,
        rows: &[usize],
        columns: &[Column],
    ) -> Errors {
        let inverse = normal_equations(columns, rows, &motion.drive).0.factor().inverse();
        let square: f64 = rows.iter().map(|k| residual[*k].powi(2)).sum();
        let independent = rows.len().max(1) as f64 * motion.independent_per_row();
        let mut of_noise = inverse.clone();
        of_noise.entries.iter_mut().for_each(|entry| *entry *= square / independent);
        let of_parts = (!same_motion).then(|| by_parts(columns, rows, residual, &inverse));
        Errors { of_noise, of_parts }
    }

    /// That of white noise, and no less than that by parts.
    fn deviation(&self, sum: &Sum) -> f64 {
        let parts = self.of_parts.as_ref().map_or(0.0, |of_parts| product(sum, sum, of_parts));
        product(sum, sum, &self.of_noise).max(parts).max(0.0).sqrt()
    }

    /// Of noise and parts together.
    fn product(&self, a: &Sum, b: &Sum) -> f64 {
        product(a, b, &self.of_noise) + self.of_parts.as_ref().map_or(0.0, |parts| product(a, b, parts))
    }
}

fn product(a: &Sum, b: &Sum, covariance: &Symmetric) -> f64 {
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
    pairs.map(|((i, a), (j, b))| a * b * covariance.at(*i, *j)).sum()
}

/// Standard deviations of damping, stiffness and gain, then of every term's parameters, each in its parameter's unit; 0 of
/// what was not fitted. They are those of white noise below the cut-off, and no less than those by parts, unless the estimates
/// are compared with those of the `same_motion`.
pub fn deviations(solved: &Solved, motion: &Motion, same_motion: bool) -> Vec<Vec<f64>> {
    let columns = model_columns(solved, motion);
    let rows: Vec<usize> = motion.rows().collect();
    let errors = Errors::of(&solved.residual, motion, same_motion, &rows, &columns);
    let of_term = |of_term: &Vec<Sum>| of_term.iter().map(|sum| errors.deviation(sum)).collect();
    sums(solved, &columns).iter().map(of_term).collect()
}

/// Covariance of the coefficients of columns by some rows of what they leave: each with the larger deviation of [`deviations`],
/// correlated as noise and parts are together.
pub fn covariance(
    columns: &[Column],
    residual: &[f64],
    motion: &Motion,
    same_motion: bool,
    rows: &[usize],
) -> Symmetric {
    let errors = Errors::of(residual, motion, same_motion, rows, columns);
    let chosen: Vec<Sum> = (0..columns.len()).map(|i| vec![(i, 1.0)]).collect();
    let scale = |sum: &Sum| {
        let together = errors.product(sum, sum).sqrt();
        if together > 0.0 { errors.deviation(sum) / together } else { 0.0 }
    };
    let mut covariance = Symmetric::zero(chosen.len());
    for (i, a) in chosen.iter().enumerate() {
        for (j, b) in chosen.iter().enumerate() {
            *covariance.at_mut(i, j) = scale(a) * scale(b) * errors.product(a, b);
        }
    }
    covariance
}

/// Damping, stiffness and gain, then every term's parameters, as sums of the coefficients of columns by their slopes.
fn sums(solved: &Solved, columns: &[Column]) -> Vec<Vec<Sum>> {
    let model = &solved.model;
    let [damping, stiffness, gain] = model.nominal;
    // A coefficient per inertia, which is itself estimated.
    let per_inertia = |i: usize, value: f64| vec![(i, gain), (0, -value * gain)];
    let stiff = model.nominal_free[1];
    let of_stiffness = if stiff { per_inertia(2, stiffness) } else { Vec::new() };
    let mut sums = vec![vec![per_inertia(1, damping), of_stiffness, vec![(0, gain * gain)]]];
    sums.extend(model.terms.iter().map(|term| vec![Vec::new(); term.parameters.len()]));
    for (i, (_, owner)) in columns.iter().enumerate() {
        let Some((t, j)) = *owner else { continue };
        sums[1 + t][j] = match model.terms[t].effect.part {
            Part::Force => per_inertia(i, model.terms[t].parameters[j]),
            Part::SensorOffset if stiff => vec![(i, gain / stiffness)],
            _ => vec![(i, 1.0)],
        };
    }
    sums
}

/// Covariance of the coefficients by how much successive parts of the rows disagree, whatever the residual is correlated with
/// within a part: the sandwich of White, clustered, with the correction for few parts (Cameron & Miller, A practitioner's guide
/// to cluster-robust inference, J. Human Resources 50 (2015) 317–372). `inverse` is that of the normal equations.
fn by_parts(columns: &[Column], rows: &[usize], residual: &[f64], inverse: &Symmetric) -> Symmetric {
    let n = columns.len();
    let mut sum = Symmetric::zero(n);
    let parts = rows.chunks(rows.len().div_ceil(PARTS).max(1));
    let count = parts.len() as f64;
    for part in parts {
        let pull = |column: &Column| -> f64 { part.iter().map(|k| column.0[*k] * residual[*k]).sum() };
        let pulls: Vec<f64> = columns.iter().map(pull).collect();
        let moved: Vec<f64> = (0..n).map(|i| (0..n).map(|j| inverse.at(i, j) * pulls[j]).sum()).collect();
        for i in 0..n {
            for j in 0..n {
                *sum.at_mut(i, j) += moved[i] * moved[j];
            }
        }
    }
    // Of so few parts a normal interval is too narrow.
    let few = count / (count - 1.0).max(1.0) * widening(count - 1.0).powi(2);
    sum.entries.iter_mut().for_each(|entry| *entry *= few);
    sum
}

#[cfg(test)]
mod tests {
    use super::{Column, PARTS, by_parts, normal_equations};

    #[test]
    fn parts_that_disagree_make_a_coefficient_uncertain() {
        let rows: Vec<usize> = (0..4000).collect();
        let columns: Vec<Column> = vec![(vec![1.0; 4000], None)];
        let inverse = normal_equations(&columns, &rows, &[0.0; 4000]).0.factor().inverse();
        let deviation = |residual: &dyn Fn(usize) -> f64| {
            let residual: Vec<f64> = (0..4000).map(residual).collect();
            by_parts(&columns, &rows, &residual, &inverse).at(0, 0).sqrt()
        };
        // Every part is off by 1, to one side or the other: the mean of so many parts has an error of 1/√PARTS.
        let apart = deviation(&|k| if (k / (4000 / PARTS)).is_multiple_of(2) { 1.0 } else { -1.0 });
        let mean = 1.0 / (PARTS as f64).sqrt();
        assert!((1.0..1.2).contains(&(apart / mean)), "{apart} for {mean}");
        // The same within every part.
        assert!(deviation(&|k| if k.is_multiple_of(2) { 1.0 } else { -1.0 }) < 1e-9);
    }
}
