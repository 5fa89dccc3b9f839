//! The mean of several models of one recording, of which none is certain.

use fitter::Coefficients;
use fitter::terms::Term;

use crate::undecided::Weighted;

/// The mean of a model's coefficients and those of others, which have their weights in it. The covariance allows for not knowing
/// which of the models it is (law of total variance).
pub fn mean(file: &Coefficients, others: &[Weighted]) -> Coefficients {
    let rest = 1.0 - others.iter().map(|other| other.weight).sum::<f64>();
    let files: Vec<(f64, &Coefficients)> =
        std::iter::once((rest, file)).chain(others.iter().map(|other| (other.weight, &other.file))).collect();
    let base = files.iter().map(|(_, file)| file.base.coefficients.len()).max().unwrap_or(0);
    let (mut terms, slots) = union(&files);
    let mut count = base;
    let mut firsts = Vec::new();
    for term in &terms {
        firsts.push(count);
        count += term.coefficients.len();
    }
    let parts = files.iter().zip(slots).map(|(&(weight, file), slots)| {
        let of_base = file.base.coefficients.iter().copied().enumerate();
        let of_term = |(term, slot): (&Term, usize)| {
            let first = firsts[slot];
            term.coefficients.clone().into_iter().enumerate().map(move |(k, value)| (first + k, value))
        };
        let places: Vec<(usize, f64)> =
            of_base.chain(file.terms.iter().zip(slots).flat_map(of_term)).collect();
        let mut values = vec![0.0; count];
        places.iter().for_each(|(place, value)| values[*place] = *value);
        let places = places.into_iter().map(|(place, _)| place).collect();
        Part { weight, covariance: &file.joint_covariance, places, values }
    });
    let parts: Vec<Part> = parts.collect();
    let value = |k: usize| parts.iter().map(|part| part.weight * part.values[k]).sum::<f64>();
    let values: Vec<f64> = (0..count).map(value).collect();
    let covariance = covariance(&parts, &values);
    for (term, first) in terms.iter_mut().zip(&firsts) {
        let own = *first..first + term.coefficients.len();
        term.coefficients = values[own.clone()].to_vec();
        let block = covariance.get(own.clone()).unwrap_or_default();
        term.covariance = block.iter().map(|row| row[own.clone()].to_vec()).collect();
    }
    let mut mean = Coefficients { terms, ..file.clone() };
    mean.set_base(values[..base].to_vec());
    mean.joint_covariance = covariance;
    mean.version = files.iter().map(|(_, file)| file.version).max().unwrap_or(file.version);
    mean.observed.extend(others.iter().flat_map(|other| other.file.observed.clone()));
    mean
}

/// One of the models.
struct Part<'a> {
    weight: f64,
    /// Covariance of its coefficients.
    covariance: &'a [Vec<f64>],
    /// Where each of them stands in the mean.
    places: Vec<usize>,
    /// Their values there; 0 of those that it does not have.
    values: Vec<f64>,
}

/// The covariance of the mean; empty where that of a part is not known.
fn covariance(parts: &[Part], mean: &[f64]) -> Vec<Vec<f64>> {
    if parts.iter().any(|part| part.covariance.is_empty()) {
        return Vec::new();
    }
    let mut sum = vec![vec![0.0; mean.len()]; mean.len()];
    for Part { weight, covariance, places, values } in parts {
        for (row, i) in covariance.iter().zip(places) {
            row.iter().zip(places).for_each(|(c, k)| sum[*i][*k] += weight * c);
        }
        let apart: Vec<f64> = values.iter().zip(mean).map(|(value, mean)| value - mean).collect();
        for (row, a) in sum.iter_mut().zip(&apart) {
            row.iter_mut().zip(&apart).for_each(|(c, b)| *c += weight * (a * b));
        }
    }
    sum
}

/// Every term once, and of every file which of them its terms are.
fn union(files: &[(f64, &Coefficients)]) -> (Vec<Term>, Vec<Vec<usize>>) {
    let mut terms: Vec<Term> = Vec::new();
    let mut slots = Vec::new();
    for (_, file) in files {
        let mut own: Vec<usize> = Vec::new();
        for term in &file.terms {
            let is_same = |other: &Term| {
                (&other.effect, other.scope, &other.operator) == (&term.effect, term.scope, &term.operator)
            };
            let known = (0..terms.len()).find(|k| !own.contains(k) && is_same(&terms[*k]));
            own.push(known.unwrap_or(terms.len()));
            if known.is_none() {
                terms.push(term.clone());
            }
        }
        slots.push(own);
    }
    (terms, slots)
}

#[cfg(test)]
mod tests {
    use fitter::Coefficients;
    use fitter::error_model::{ErrorModel, Sensor};
    use fitter::terms::{Operator, Product, Scope, Term};

    use super::mean;
    use crate::undecided::Weighted;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }

    /// A polynomial with a term that goes with a column, all of variance 0.04.
    fn file(coefficients: Vec<f64>, column: &str, term: f64) -> Coefficients {
        let sensor = Sensor::Direct { unit: "mm".into(), revolution: None };
        let count = coefficients.len() + 1;
        let model = ErrorModel { sensor, centre: 0.0, coefficients };
        let mut file = Coefficients::of_model(&model, -1.0, 1.0, "by hand");
        file.terms.push(Term {
            effect: column.into(),
            scope: Scope::Device,
            operator: Operator::Product(Product::of(column, 20.0)),
            coefficients: vec![term],
            covariance: vec![vec![0.04]],
        });
        file.joint_covariance =
            (0..count).map(|i| (0..count).map(|k| if i == k { 0.04 } else { 0.0 }).collect()).collect();
        file.observed.insert(column.into(), [10.0, 30.0]);
        file
    }

    #[test]
    fn the_mean_is_as_uncertain_as_the_choice() {
        let one = file(vec![1.0, 2.0], "temperature_c", 0.4);
        let other = file(vec![2.0, 2.0, 4.0], "humidity_pct", 0.8);
        let mean = mean(&one, &[Weighted { weight: 0.25, file: other }]);
        assert_eq!(mean.base.coefficients, [1.25, 2.0, 1.0]);
        let of: Vec<(&str, f64)> =
            mean.terms.iter().map(|t| (t.effect.as_str(), t.coefficients[0])).collect();
        assert_eq!(of, [("temperature_c", 0.75 * 0.4), ("humidity_pct", 0.25 * 0.8)]);
        assert_eq!(mean.observed.len(), 2);
        // Of each the variance where it is there, and that of whether it is.
        let of_choice = 0.75 * 0.25;
        for (term, (there, value)) in mean.terms.iter().zip([(0.75, 0.4), (0.25, 0.8)]) {
            near(term.covariance[0][0], there * 0.04 + of_choice * value * value);
        }
        // Where the one is there the other is not.
        near(mean.joint_covariance[3][4], -of_choice * 0.4 * 0.8);
        assert!(fitter::acceptance::to_apply(&mean).is_ok());
    }

    #[test]
    fn what_both_have_stands_once() {
        let one = file(vec![1.0], "temperature_c", 0.4);
        let other = file(vec![1.0], "temperature_c", 0.8);
        let mean = mean(&one, &[Weighted { weight: 0.5, file: other }]);
        assert_eq!(mean.terms.len(), 1);
        near(mean.terms[0].coefficients[0], 0.6);
    }
}
