//! The fit of a whole turn: what belongs into it, its coefficients, and what they leave.

use super::arc::wrapped;
use super::correct::identify;
use super::found::Found;
use super::harmonics::Harmonics;
use crate::apply::apply;
use crate::basis::Basis;
use crate::coefficients::Coefficients;
use crate::fit::{Calibrated, Fit, FitError, FitNote};

/// Fits the harmonics of the turn, and beside them what does not repeat with it.
///
/// # Errors
/// [`FitError`]: too few angles to choose the number of harmonics, or to determine the one that was given.
pub(crate) fn fit(mut problem: Harmonics) -> Result<Fit, FitError> {
    let recording = problem.recording;
    let (choice, corrections) = identify(&mut problem)?;
    let found = Found::of(&problem, &choice.solution, corrections);
    let mut notes: Vec<FitNote> = recording.notes.iter().cloned().map(FitNote::Reading).collect();
    if recording.passes().len() == 1 {
        notes.push(FitNote::SinglePass);
    }
    let mut coefficients = found.file(&problem, choice.selection, &choice.solution);
    // The harmonics are of the true angle: applied, they are solved for it, and a steep flank leaves more than the fit did.
    let residual = left_by(&coefficients, &problem)
        .unwrap_or_else(|| found.corrected_residual(&problem, &choice.solution));
    coefficients.statistics = Some(found.statistics(&problem, &residual));
    let Harmonics { unwound, points, .. } = problem;
    let weights = vec![1.0; points.count()];
    let basis = Basis::new(&points.reading, &weights, 1);
    let calibrated = Calibrated::from_columns(unwound.reading, unwound.error);
    let dependences = Vec::new();
    // Directions are told already: what else the errors depend on is looked for in what they leave.
    let left = choice.solution.residual;
    let mut fit =
        Fit { coefficients, calibrated, residual: left, points, weights, basis, dependences, notes };
    if fit.points.single_angles {
        fit.look_beside(recording);
    }
    fit.residual = residual;
    Ok(fit)
}

/// What the file leaves of the errors when it is applied.
fn left_by(file: &Coefficients, problem: &Harmonics) -> Option<Vec<f64>> {
    let applied = apply(problem.recording, file).ok()?;
    let reference = &problem.unwound.reference;
    Some(applied.corrected.iter().zip(reference).map(|(c, r)| wrapped(c - r, problem.turn)).collect())
}
