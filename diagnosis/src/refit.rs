//! The model that is handed on, fitted where it is used: to the corrected reading of every row.
//!
//! The search fits the error as a function of the true angle Θ, which the reference gives, and of a long recording it
//! sees means of neighbouring rows. A correction is made row by row, and it solves Θ + P(Θ) = y for Θ: what the
//! harmonics P miss by e is then off by e/(1 + P′(Θ)), twice as much on a flank where P falls with a slope of one half.
//! So base and terms are fitted once more so that the *corrected* readings are nearest to the reference, by
//! Gauss–Newton steps with the shapes held. It matters most where fewer harmonics are handed on than were found.

use fitter::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Observables, Operator, Periodic, Term};
use numerics::{least_squares, range, rms};

use crate::rows::Rows;
use crate::screened::Seen;
use crate::thresholds::refit::{GAIN, HARMONIC_GAIN, MOST_HARMONICS, MOST_ROWS, STEEP, STEPS};

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

/// Fits base and terms of a direct sensor to the corrected readings of the rows for which `used` holds, where the
/// search saw means of rows or a periodic error is steep; otherwise, or where nothing is gained, the file stays as it
/// is. Harmonics that are too short for means of rows are added where single rows show them, `most` at most.
pub fn refit(
    file: &mut Coefficients,
    seen: &Seen<'_>,
    rows: &Rows,
    used: &[bool],
    searched: usize,
    most: Option<usize>,
) {
    let means = searched < rows.len();
    if !matches!(file.sensor, Sensor::Direct { .. })
        || (steepest(file) < STEEP.0 && !means)
        || rows.len() > MOST_ROWS
    {
        return;
    }
    let Some(mut left) = settle(file, seen, rows, used) else { return };
    if !means {
        return;
    }
    let most = most.map_or(MOST_HARMONICS, |most| most.min(MOST_HARMONICS));
    for k in 0..file.terms.len() {
        while let Some(mut richer) = with_harmonic(file, k, rows.step(), most) {
            let Some(next) = settle(&mut richer, seen, rows, used) else { break };
            if next > HARMONIC_GAIN * left {
                break;
            }
            (*file, left) = (richer, next);
        }
    }
}

/// The file with one more harmonic, of amplitude 0, in term `k`; none where it is not periodic with a free period, or
/// where no more are resolved.
fn with_harmonic(file: &Coefficients, k: usize, step: f64, most: usize) -> Option<Coefficients> {
    let mut richer = file.clone();
    let of_turn = file.turn.as_ref().map(|turn| turn.revolution);
    let term = &mut richer.terms[k];
    let Operator::Periodic(periodic) = &mut term.operator else { return None };
    let next = periodic.harmonics.iter().max()? + 1;
    let resolved = periodic.period / f64::from(next) >= 2.2 * step;
    if !resolved || usize::from(next) > most || of_turn == Some(periodic.period) {
        return None;
    }
    periodic.harmonics.push(next);
    term.coefficients.extend([0.0; 2]);
    // What is known of the others does not hold beside it.
    term.covariance.clear();
    richer.joint_covariance.clear();
    Some(richer)
}

/// Gauss–Newton steps until nothing is gained; what is then left of the used rows. None where the file cannot be
/// applied.
fn settle(file: &mut Coefficients, seen: &Seen<'_>, rows: &Rows, used: &[bool]) -> Option<f64> {
    let of_used = |left: &[f64]| -> f64 {
        rms(&left.iter().zip(used).filter(|(_, used)| **used).map(|(left, _)| *left).collect::<Vec<f64>>())
    };
    let mut left = errors(file, seen, rows)?;
    for _ in 0..STEPS {
        let before = of_used(&left);
        let mut next = file.clone();
        step(&mut next, seen, rows, &left, used)?;
        let Some(errors) = errors(&next, seen, rows).filter(|_| steepest(&next) < STEEP.1) else {
            break;
        };
        let after = of_used(&errors);
        if after.is_nan() || after >= before {
            break;
        }
        *file = next;
        left = errors;
        if before - after < GAIN * before {
            break;
        }
    }
    Some(of_used(&left))
}

/// The steepest slope that all harmonics of a file may have together.
fn steepest(file: &Coefficients) -> f64 {
    file.terms.iter().filter_map(|t| Some(periodic(t)?.steepest(&t.coefficients))).sum()
}

fn periodic(term: &Term) -> Option<&Periodic> {
    match &term.operator {
        Operator::Periodic(periodic) => Some(periodic),
        _ => None,
    }
}

/// Corrected reading less the reference, row by row, in the recording's unit; of a sensor that turns within half a
/// turn. None where the file cannot be applied.
pub fn errors(file: &Coefficients, seen: &Seen<'_>, rows: &Rows) -> Option<Vec<f64>> {
    let corrected = seen.corrected(file)?;
    let per = file.sensor.per_internal();
    let turn = match &file.sensor {
        Sensor::Direct { revolution, .. } => *revolution,
        Sensor::EddyCurrentPair { .. } => None,
    };
    let error = |(c, t): (&f64, &f64)| {
        let error = c * per - t;
        turn.map_or(error, |turn| error - turn * (error / turn).round())
    };
    Some(corrected.iter().zip(&rows.truth).map(error).collect())
}

/// One Gauss–Newton step from the errors `left`.
fn step(file: &mut Coefficients, seen: &Seen<'_>, rows: &Rows, left: &[f64], used: &[bool]) -> Option<()> {
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
        if let Some(periodic) = periodic(term) {
            let first = columns.len();
            columns.resize(first + term.coefficients.len(), Vec::with_capacity(n));
            for (c, gain) in corrected.iter().zip(&gain) {
                for (column, value) in columns[first..].iter_mut().zip(periodic.columns_at(*c)) {
                    column.push(gain * value);
                }
            }
        } else {
            let raw = term
                .operator
                .columns(&Observables { recording: seen.recording, sensor: &file.sensor })
                .ok()?;
            columns.extend(raw.iter().map(|c| c.iter().zip(&gain).map(|(c, gain)| c * gain).collect()));
        }
    }
    // A row that is not used has no say.
    let mut target = left.to_vec();
    for column in columns.iter_mut().chain(std::iter::once(&mut target)) {
        column.iter_mut().zip(used).filter(|(_, used)| !**used).for_each(|(v, _)| *v = 0.0);
    }
    let found = least_squares(&columns, &target).coefficients;
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
    Some(())
}
