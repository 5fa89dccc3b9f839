//! What is said of the effects along a recorded motion: parameters with intervals, and alternatives.

use super::inverse::{Inverse, Solved};
use super::motion::Motion;
use super::search::Along;
use super::{filter, square};
use crate::dynamic::data::CHOOSE;
use crate::dynamic::data::FIT;
use crate::dynamic::effects::{DynamicEffect, Reading, Scale};
use crate::dynamic::verdict::{self, Units};
use crate::thresholds::dynamic::feedback::search::ALTERNATIVE;
use crate::verdict::NamedEffect;

/// Whether a residual that has passed the filter still has most of its power far below the cut-off.
pub fn coloured(residual: &[f64], motion: &Motion) -> bool {
    let slow: Vec<f64> = (motion.runs.iter())
        .flat_map(|r| filter::low_pass(&residual[r.clone()], 0.2 * motion.cutoff_hz, motion.step_s))
        .collect();
    square(&slow) > 0.4 * square(residual)
}

/// The effects of a model, the strongest first.
pub fn named(
    along: &Along,
    present: &Inverse,
    after: &Solved,
    catalogue: &[&'static dyn DynamicEffect],
    scale: &Scale,
    units: &Units,
) -> Vec<NamedEffect> {
    let Some(fitted) = along.fit(present) else { return Vec::new() };
    let mut said: Vec<NamedEffect> = Vec::new();
    for (t, term) in after.model.terms.iter().enumerate() {
        let mut shorter = present.clone();
        shorter.terms.remove(t);
        let Some(without) = along.fit(&shorter) else { continue };
        let gain = along.gain(&without, &fitted, FIT) + along.gain(&without, &fitted, CHOOSE);
        let rivals: Vec<&'static dyn DynamicEffect> =
            catalogue.iter().copied().filter(|e| term.effect.confused_with.contains(&e.id)).collect();
        let own = along.square(&fitted.residual, FIT) * (1.0 + ALTERNATIVE);
        let alternatives = along
            .contenders(&shorter, &rivals, scale)
            .iter()
            .filter(|c| along.square(&c.1.residual, FIT) <= own)
            .filter_map(|c| c.0.terms.last().map(|(e, _)| e.id.to_string()))
            .collect();
        let deviation = |r: &Reading| {
            let parts = r.gradient.iter().zip(&after.deviations[1 + t]);
            parts.map(|(g, d)| (g * d).powi(2)).sum::<f64>().sqrt()
        };
        let lost = square(&without.residual) - square(&fitted.residual);
        let effect = verdict::named(term, deviation, gain, alternatives, units);
        said.push(NamedEffect { share: lost.max(0.0), ..effect });
    }
    said.sort_by(|a, b| b.share.total_cmp(&a.share));
    let total: f64 = said.iter().map(|e| e.share).sum::<f64>().max(f64::MIN_POSITIVE);
    said.iter_mut().for_each(|e| e.share /= total);
    said
}
