//! What is said of the effects along a recorded motion: parameters with intervals, and alternatives.

use fitter::plant::Plant;

use super::filter;
use super::inverse::Solved;
use super::motion::Motion;
use super::search::Along;
use crate::dynamic::data::{CHOOSE, FIT};
use crate::dynamic::effects::{DynamicEffect, Reading, Scale};
use crate::dynamic::model::{Model, Term};
use crate::dynamic::verdict;
use crate::thresholds::dynamic::feedback::search::ALTERNATIVE;
use crate::verdict::NamedEffect;

/// Whether a residual that has passed the filter still has most of its power far below the cut-off.
pub fn coloured(residual: &[f64], motion: &Motion) -> bool {
    let slow: Vec<f64> = (motion.runs.iter())
        .flat_map(|r| filter::low_pass(&residual[r.clone()], 0.2 * motion.cutoff_hz, motion.step_s))
        .collect();
    motion.rms(&slow).powi(2) > 0.4 * motion.rms(residual).powi(2)
}

/// The effects of a model, the strongest first: its terms, fitted to all rows, with the standard deviations of their parameters.
pub fn named(
    along: &Along,
    present: &Model,
    (terms, deviations): (&[Term], &[Vec<f64>]),
    catalogue: &[&'static DynamicEffect],
    scale: &Scale,
    plant: &Plant,
) -> Vec<NamedEffect> {
    let Some(fitted) = along.fit(present) else { return Vec::new() };
    let mut said: Vec<(f64, NamedEffect)> = Vec::new();
    for (t, term) in terms.iter().enumerate() {
        let Some(without) = along.fit(&present.without(t)) else { continue };
        let gain = along.gain(&without, &fitted, FIT) + along.gain(&without, &fitted, CHOOSE);
        let rivals: Vec<&'static DynamicEffect> =
            catalogue.iter().copied().filter(|e| term.effect.confused_with.contains(&e.id)).collect();
        let own = along.square(&fitted.residual, FIT) * (1.0 + ALTERNATIVE);
        let alternatives = along
            .contenders(&without, &rivals, scale)
            .iter()
            .filter(|c| along.square(&c.residual, FIT) <= own)
            .filter_map(|c| c.model.terms.last().map(|t| t.effect.id.to_string()))
            .collect();
        let deviation = |r: &Reading| {
            let parts = r.gradient.iter().zip(&deviations[t]);
            parts.map(|(g, d)| (g * d).powi(2)).sum::<f64>().sqrt()
        };
        let square = |solved: &Solved| along.motion.rms(&solved.residual).powi(2);
        let lost = square(&without) - square(&fitted);
        said.push((lost.max(0.0), verdict::named(term, deviation, gain, alternatives, plant)));
    }
    verdict::shared(said)
}
