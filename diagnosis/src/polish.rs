//! A steep error that repeats with the true angle, as it is handed on: fitted where it is used.
//!
//! The search fits the error as a function of the true angle Θ, which the reference gives. A correction solves
//! Θ + P(Θ) = y for Θ, and what P misses by e is then off by e/(1 + P′(Θ)): twice as much on a flank where P
//! falls with a slope of one half. Where P is steep, base and harmonics are therefore fitted once more so that
//! the *corrected* reading is nearest to the reference, by Gauss–Newton steps with the period held, which all
//! harmonics together determine best. It matters most where fewer harmonics are handed on than were found.

use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Operator, Term};
use fitter::{Coefficients, Recording};

use crate::linear::least_squares;
use crate::rows::{Rows, range, rms};

/// Steepest slope of the harmonics below which nothing is gained, and from which on no equation may be left.
const STEEP: (f64, f64) = (0.05, 0.98);
/// Steps, and the relative gain below which they end.
const STEPS: usize = 12;
const GAIN: f64 = 1e-9;
/// Rows beyond which the fit of their means is good enough: each step solves the equation for every row.
const MOST_ROWS: usize = 100_000;

/// Keeps the `most` strongest harmonics of every periodic term.
pub fn keep_strongest(file: &mut Coefficients, most: usize) {
    let mut first = file.base.coefficients.len();
    let mut gone: Vec<usize> = Vec::new();
    for term in &mut file.terms {
        let begin = first;
        first += term.coefficients.len();
        let Operator::Periodic(periodic) = &mut term.operator else { continue };
        let size = |k: usize| term.coefficients[2 * k].hypot(term.coefficients[2 * k + 1]);
        let mut order: Vec<usize> = (0..periodic.harmonics.len()).collect();
        order.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
        order.truncate(most);
        order.sort_unstable();
        let columns: Vec<usize> = order.iter().flat_map(|k| [2 * k, 2 * k + 1]).collect();
        periodic.harmonics = order.iter().map(|k| periodic.harmonics[*k]).collect();
        term.covariance =
            columns.iter().map(|a| columns.iter().map(|b| term.covariance[*a][*b]).collect()).collect();
        gone.extend((0..term.coefficients.len()).filter(|k| !columns.contains(k)).map(|k| begin + k));
        term.coefficients = columns.iter().map(|k| term.coefficients[*k]).collect();
    }
    file.keep_in_covariance(|k| !gone.contains(&k));
}

/// Fits base and harmonics of a direct sensor to the corrected reading, where a steep periodic error is all that
/// the file has beside the base; otherwise, or where nothing is gained, the file stays as it is.
pub fn polish(file: &mut Coefficients, recording: &Recording, rows: &Rows) {
    let steepest: f64 = file.terms.iter().filter_map(|t| Some(periodic(t)?.steepest(&t.coefficients))).sum();
    let only_periodic = file.terms.iter().all(|t| periodic(t).is_some());
    if !matches!(file.sensor, Sensor::Direct { .. })
        || file.turn.is_some()
        || !only_periodic
        || steepest < STEEP.0
        || rows.len() > MOST_ROWS
    {
        return;
    }
    let Some(mut left) = errors(file, recording, rows) else { return };
    for _ in 0..STEPS {
        let mut next = file.clone();
        step(&mut next, rows, &left);
        let sound =
            next.terms.iter().all(|t| periodic(t).is_some_and(|p| p.steepest(&t.coefficients) < STEEP.1));
        let Some(errors) = errors(&next, recording, rows).filter(|_| sound) else { return };
        let (before, after) = (rms(&left), rms(&errors));
        if after >= before {
            return;
        }
        *file = next;
        left = errors;
        if before - after < GAIN * before {
            return;
        }
    }
}

fn periodic(term: &Term) -> Option<&fitter::terms::Periodic> {
    match &term.operator {
        Operator::Periodic(periodic) => Some(periodic),
        _ => None,
    }
}

/// Corrected reading less the reference.
fn errors(file: &Coefficients, recording: &Recording, rows: &Rows) -> Option<Vec<f64>> {
    let applied = fitter::apply(recording, file).ok()?;
    Some(applied.corrected.iter().zip(&rows.truth).map(|(c, t)| c - t).collect())
}

/// One Gauss–Newton step from the errors `left`.
fn step(file: &mut Coefficients, rows: &Rows, left: &[f64]) {
    let n = rows.len();
    let (low, high) = range(&rows.reading);
    let half = (0.5 * (high - low)).max(1e-300);
    let centre = file.base.centre;
    // The corrected reading at every row, and 1/(1 + P′) there.
    let corrected: Vec<f64> = left.iter().zip(&rows.truth).map(|(e, t)| e + t).collect();
    let gain: Vec<f64> = corrected
        .iter()
        .map(|c| {
            let slope: f64 = file
                .terms
                .iter()
                .filter_map(|t| Some(periodic(t)?.value_and_slope(&t.coefficients, *c).1))
                .sum();
            1.0 / (1.0 + slope)
        })
        .collect();
    let count = file.base.coefficients.len();
    let mut columns: Vec<Vec<f64>> = (0..count)
        .map(|k| (0..n).map(|i| gain[i] * ((rows.reading[i] - centre) / half).powi(k as i32)).collect())
        .collect();
    for term in &file.terms {
        let Some(periodic) = periodic(term) else { continue };
        let first = columns.len();
        columns.resize(first + term.coefficients.len(), Vec::with_capacity(n));
        for (c, gain) in corrected.iter().zip(&gain) {
            for (column, value) in columns[first..].iter_mut().zip(periodic.columns_at(*c)) {
                column.push(gain * value);
            }
        }
    }
    let found = least_squares(&columns, left).coefficients;
    let mut coefficients = file.base.coefficients.clone();
    for (k, (c, change)) in coefficients.iter_mut().zip(&found).enumerate() {
        *c += change / half.powi(k as i32);
    }
    let model = ErrorModel { sensor: file.sensor.clone(), centre, coefficients };
    let valid = &file.valid_range;
    file.base = Coefficients::of_model(&model, valid.from, valid.to, &file.command).base;
    let mut changes = found[count..].iter();
    for term in &mut file.terms {
        term.coefficients.iter_mut().zip(&mut changes).for_each(|(c, change)| *c += change);
    }
}
