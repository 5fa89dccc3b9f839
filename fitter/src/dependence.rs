//! Whether the residual depends on something else that was recorded: the reason to run `diagnose`.
//!
//! Every observable is tested for a level and a gain (its product with the angle), a direction also for a
//! loop, a pass for an offset of its own, and the angle for a misfit of the polynomial. What the angle
//! itself explains is projected off first: where angles repeat, by taking each point's mean from residual
//! and observables alike, so that no misfit of the polynomial can look like something else. The variance
//! of a test allows for noise that is correlated from row to row (first-order) and uneven between angles; both
//! are taken from what is left after all observables were fitted together. The
//! p-values are corrected for the number of observables (Holm 1979), so that the probability of any false
//! alarm in the whole search is at most [`FALSE_ALARM`].

mod design;
mod memory;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::coefficients::Correlation;
use crate::fit::Fit;
use crate::points::Grouping;
use crate::recording::Recording;
use crate::statistics::readable;
use crate::terms::Operator;
use design::{Candidate, Design};
use memory::Memory;

/// Probability that a recording without any dependence is said to have one.
pub const FALSE_ALARM: f64 = 0.01;

/// An observable that the residual depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Dependence {
    /// A column's name, or `angle`, `common_mode_um`.
    pub variable: String,
    /// Probability of so strong a dependence by chance, corrected for the number of observables.
    pub p_value: f64,
}

/// What the residual of a fit depends on, the most significant first, empty if nothing beyond chance; and how far its rows
/// have their noise in common, none where that is not seen.
pub fn dependences(recording: &Recording, fit: &Fit) -> (Vec<Dependence>, Option<Correlation>) {
    let Some(design) = Design::of(recording, fit) else { return (Vec::new(), None) };
    let (mut found, correlation) = tests(&design);
    found.extend(misfit(&design, fit));
    found.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then(a.variable.cmp(&b.variable)));
    // Holm: the k-th smallest of m is multiplied by m − k, and none is smaller than the one before.
    let count = found.len();
    let mut largest = 0.0f64;
    for (rank, dependence) in found.iter_mut().enumerate() {
        largest = largest.max(dependence.p_value * (count - rank) as f64).min(1.0);
        dependence.p_value = largest;
    }
    found.retain(|dependence| dependence.p_value <= FALSE_ALARM);
    let correlation = correlation.map(|neighbours| Correlation {
        neighbours: readable(neighbours),
        of_fitted: readable(of_fitted(&design, fit, neighbours)),
    });
    (found, correlation)
}

/// By how much rows that correlate make the variance of what was fitted larger than independent ones: qᵀRq/qᵀq, on average
/// over the columns q of polynomial and harmonics.
fn of_fitted(design: &Design, fit: &Fit, neighbours: f64) -> f64 {
    let file = &fit.coefficients;
    let of_row = |row: &usize| {
        let reading = fit.calibrated.reading[*row];
        let mut values = vec![0.0; file.base.order + 1];
        fit.basis.evaluate(reading, &mut values);
        for term in &file.terms {
            if let Operator::Periodic(periodic) = &term.operator {
                values.extend(periodic.columns_at(reading));
            }
        }
        values
    };
    let rows: Vec<Vec<f64>> = design.rows.iter().map(of_row).collect();
    let count = rows.first().map_or(0, Vec::len);
    let larger = (0..count).map(|k| {
        let column = DVector::from_iterator(rows.len(), rows.iter().map(|row| row[k]));
        design.correlated(&column, &column, neighbours) / column.norm_squared()
    });
    larger.sum::<f64>() / count.max(1) as f64
}

/// Eigenvalues below this share of the largest are taken as zero: columns that repeat each other.
const RANK: f64 = 1e-9;

/// The inverse of a symmetric matrix on the space that it spans, and the dimension of that space.
fn pseudo_inverse(matrix: DMatrix<f64>) -> (DMatrix<f64>, usize) {
    let eigen = SymmetricEigen::new(matrix);
    let largest = eigen.eigenvalues.iter().fold(0.0f64, |max, value| max.max(*value));
    let kept = |value: f64| value > RANK * largest && value > 0.0;
    let rank = eigen.eigenvalues.iter().filter(|value| kept(**value)).count();
    let inverse = eigen.eigenvalues.map(|value| if kept(value) { 1.0 / value } else { 0.0 });
    (&eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose(), rank)
}

/// One test per candidate, uncorrected; and the autocorrelation.
fn tests(design: &Design) -> (Vec<Dependence>, Option<f64>) {
    let rows = design.residual.len();
    let columns: Vec<&DVector<f64>> = design.candidates.iter().flat_map(|c| &c.columns).collect();
    if columns.is_empty() {
        return (Vec::new(), None);
    }
    let gram = DMatrix::from_fn(columns.len(), columns.len(), |i, j| columns[i].dot(columns[j]));
    let (inverse, rank) = pseudo_inverse(gram);
    let left = design.without(&columns, &inverse, design.residual.clone());
    let freedom = rows as f64 - (design.absorbed + rank) as f64;
    if freedom < 5.0 {
        return (Vec::new(), None);
    }
    let Memory { correlation, variance } = Memory::of(design, &columns, &inverse, &left, freedom);
    // Correlated rows tell less: so many independent ones tell as much about their variance.
    let squared = correlation * correlation;
    let effective = (freedom * (1.0 - squared) / (1.0 + squared)).max(2.0);
    let tested = (design.candidates.iter())
        .filter_map(|Candidate { name, columns }| {
            let count = columns.len();
            let spread = DMatrix::from_fn(count, count, |i, j| {
                design.correlated(&columns[i], &columns[j], correlation)
            });
            let (inverse, rank) = pseudo_inverse(spread);
            let products = DVector::from_fn(count, |i, _| columns[i].dot(&design.residual));
            let ratio = (products.transpose() * inverse * products)[(0, 0)] / (rank as f64 * variance);
            let law = FisherSnedecor::new(rank as f64, effective).ok()?;
            ratio.is_finite().then(|| Dependence { variable: name.clone(), p_value: law.sf(ratio.max(0.0)) })
        })
        .collect();
    (tested, Some(correlation).filter(|correlation| *correlation > 0.0))
}

/// The angle itself: what no polynomial leaves between the points, against the scatter within them; where
/// no angle repeats, whether neighbouring readings have like residuals.
fn misfit(design: &Design, fit: &Fit) -> Option<Dependence> {
    // Of a whole turn the cross-validation of the harmonics says what the angle still explains.
    if fit.coefficients.whole_turn() {
        return None;
    }
    let p_value = if fit.points.grouping == Grouping::Block || !fit.points.single_angles {
        let mut order: Vec<usize> = (0..design.rows.len()).collect();
        let reading = |index: &usize| fit.calibrated.reading[design.rows[*index]];
        order.sort_by(|a, b| reading(a).total_cmp(&reading(b)));
        let value = |index: usize| design.residual[index];
        let squares: f64 = order.iter().map(|index| value(*index).powi(2)).sum();
        let products: f64 = order.windows(2).map(|pair| value(pair[0]) * value(pair[1])).sum();
        // The first serial correlation has a standard error of 1/√n, and loses about one per parameter and n to the fit.
        let n = order.len() as f64;
        let lost = (design.absorbed + 1) as f64 / n;
        let z = (products / squares + lost) * n.sqrt();
        let law = statrs::distribution::Normal::standard();
        law.sf(z)
    } else {
        let points = fit.points.count();
        let (mut sum, mut count, mut within) = (vec![0.0; points], vec![0.0; points], 0.0);
        let point = |row: usize| fit.points.of_row[row] as usize;
        for row in &design.rows {
            let root = fit.weights[point(*row)].sqrt();
            sum[point(*row)] += root * fit.residual[*row];
            count[point(*row)] += 1.0;
        }
        for row in &design.rows {
            let root = fit.weights[point(*row)].sqrt();
            let mean = sum[point(*row)] / count[point(*row)];
            within += (root * fit.residual[*row] - mean).powi(2);
        }
        let mut between: f64 =
            sum.iter().zip(&count).filter(|(_, n)| **n > 0.0).map(|(sum, n)| sum * sum / n).sum();
        let used = count.iter().filter(|n| **n > 0.0).count() as f64;
        let order = fit.coefficients.base.order;
        let beyond =
            (order + BEYOND).min(fit.basis.order()).min((used as usize).saturating_sub(2)).max(order);
        for product in products_beyond(design, fit, order, beyond) {
            between -= product * product;
        }
        let above = used - (beyond + 1) as f64;
        let below = design.rows.len() as f64 - used;
        if above < 1.0 || below < 1.0 {
            return None;
        }
        let law = FisherSnedecor::new(above, below).ok()?;
        law.sf((between.max(0.0) / above) / (within / below))
    };
    p_value.is_finite().then(|| Dependence { variable: "angle".to_string(), p_value })
}

/// How many orders above that of the fit still count as the polynomial: an order that was chosen a little
/// low is no dependence on something else.
const BEYOND: usize = 4;

/// Products of the weighted residual with the basis polynomials of the orders above `order`, to `beyond`.
fn products_beyond(design: &Design, fit: &Fit, order: usize, beyond: usize) -> Vec<f64> {
    let mut products = vec![0.0; beyond - order];
    let mut values = vec![0.0; beyond + 1];
    for row in &design.rows {
        let reading = fit.calibrated.reading[*row];
        fit.basis.evaluate(reading, &mut values);
        let factor = fit.weights[fit.points.of_row[*row] as usize] * fit.coefficients.sensor.gain(reading);
        for (product, p) in products.iter_mut().zip(&values[order + 1..]) {
            *product += factor * p * fit.residual[*row];
        }
    }
    products
}

/// The line that points to `diagnose`, if there is something to point to.
pub fn pointer(dependences: &[Dependence], file: &str) -> Option<String> {
    if dependences.is_empty() {
        return None;
    }
    let list: Vec<String> =
        dependences.iter().map(|found| format!("{} (p = {:.1e})", found.variable, found.p_value)).collect();
    Some(format!("the residual depends on {}: run `diagnose {file}` to find out why", list.join(", ")))
}
