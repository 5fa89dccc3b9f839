//! The mean of several models of one recording, of which none is certain.

use fitter::Coefficients;
use fitter::terms::Term;

use crate::undecided::Weighted;

/// The mean of a model and others, which have their parts in it; the covariance is that of a coefficient whose model is as
/// uncertain as its value.
pub fn mean(file: &Coefficients, others: &[Weighted]) -> Coefficients {
    let rest = 1.0 - others.iter().map(|other| other.weight).sum::<f64>();
    let parts: Vec<(f64, &Coefficients)> =
        std::iter::once((rest, file)).chain(others.iter().map(|other| (other.weight, &other.file))).collect();
    let mut mean = file.clone();
    let (terms, places) = union(&parts);
    let base = parts.iter().map(|(_, file)| file.base.coefficients.len()).max().unwrap_or(0);
    let firsts: Vec<usize> = terms
        .iter()
        .scan(base, |next, term| Some(std::mem::replace(next, *next + term.coefficients.len())))
        .collect();
    let count = base + terms.iter().map(|term| term.coefficients.len()).sum::<usize>();
    // Of every part where its coefficients stand in the mean.
    let numbers = |(part, places): (&(f64, &Coefficients), &Vec<usize>)| -> Vec<usize> {
        let of_terms = part.1.terms.iter().zip(places);
        let of_terms =
            of_terms.flat_map(|(term, place)| (0..term.coefficients.len()).map(|k| firsts[*place] + k));
        (0..part.1.base.coefficients.len()).chain(of_terms).collect()
    };
    let numbers: Vec<Vec<usize>> = parts.iter().zip(&places).map(numbers).collect();
    let values = |file: &Coefficients, numbers: &[usize]| {
        let mut values = vec![0.0; count];
        let own = file.base.coefficients.iter().chain(file.terms.iter().flat_map(|term| &term.coefficients));
        numbers.iter().zip(own).for_each(|(number, value)| values[*number] = *value);
        values
    };
    let all: Vec<Vec<f64>> = parts.iter().zip(&numbers).map(|((_, file), n)| values(file, n)).collect();
    let middle: Vec<f64> =
        (0..count).map(|k| parts.iter().zip(&all).map(|(p, v)| p.0 * v[k]).sum()).collect();
    let known = parts.iter().all(|(_, file)| !file.joint_covariance.is_empty());
    let mut covariance = vec![vec![0.0; count]; count];
    for (((weight, file), numbers), values) in parts.iter().zip(&numbers).zip(&all) {
        for (row, i) in file.joint_covariance.iter().zip(numbers) {
            row.iter().zip(numbers).for_each(|(c, k)| covariance[*i][*k] += weight * c);
        }
        let apart: Vec<f64> = values.iter().zip(&middle).map(|(value, middle)| value - middle).collect();
        for (row, a) in covariance.iter_mut().zip(&apart) {
            row.iter_mut().zip(&apart).for_each(|(c, b)| *c += weight * (a * b));
        }
    }
    mean.set_base(middle[..base].to_vec());
    mean.terms = terms;
    for (term, first) in mean.terms.iter_mut().zip(firsts) {
        let own = first..first + term.coefficients.len();
        term.coefficients = middle[own.clone()].to_vec();
        let block = || own.clone().map(|i| covariance[i][own.clone()].to_vec()).collect();
        term.covariance = if known { block() } else { Vec::new() };
    }
    if known {
        mean.joint_covariance = covariance;
    }
    mean.version = parts.iter().map(|(_, file)| file.version).max().unwrap_or(mean.version);
    mean.observed.extend(others.iter().flat_map(|other| other.file.observed.clone()));
    mean
}

/// Every term once, and for every part where its terms stand among them.
fn union(parts: &[(f64, &Coefficients)]) -> (Vec<Term>, Vec<Vec<usize>>) {
    let mut terms: Vec<Term> = Vec::new();
    let mut places = Vec::new();
    for (_, file) in parts {
        let mut taken: Vec<usize> = Vec::new();
        for term in &file.terms {
            let is_same = |known: &Term| {
                (&known.effect, known.scope, &known.operator) == (&term.effect, term.scope, &term.operator)
            };
            let at = (0..terms.len()).find(|k| !taken.contains(k) && is_same(&terms[*k]));
            taken.push(at.unwrap_or(terms.len()));
            if at.is_none() {
                terms.push(term.clone());
            }
        }
        places.push(taken);
    }
    (terms, places)
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
