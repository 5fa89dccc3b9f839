//! What is said of the effects along a recorded motion: parameters with intervals, alternatives, places.

use fitter::plant::Plant;

use super::inverse::{Inverse, Solved};
use super::motion::Motion;
use super::search::Along;
use super::{filter, square};
use crate::dynamic::data::CHOOSE;
use crate::dynamic::data::FIT;
use crate::dynamic::effects::{DynamicEffect, Scale, effect, unit_of};
use crate::dynamic::interval::around;
use crate::dynamic::verdict::{p_value, sort};
use crate::rows::range;
use crate::thresholds::dynamic::feedback::search::ALTERNATIVE;
use crate::verdict::{Location, NamedEffect, Parameter};

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
    nominal: &Plant,
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
        let parameters = term
            .effect
            .readings(&term.parameters)
            .iter()
            .map(|r| {
                let variance: f64 =
                    r.gradient.iter().zip(&after.deviations[1 + t]).map(|(g, d)| (g * d).powi(2)).sum();
                let unit = unit_of(r.unit, &nominal.position_unit, &nominal.drive_unit);
                Parameter {
                    name: r.name.into(),
                    value: r.value,
                    unit,
                    ci95: around(r.value, variance.sqrt(), sort(term, r)),
                }
            })
            .collect();
        let lost = square(&without.residual) - square(&fitted.residual);
        said.push(NamedEffect {
            id: term.effect.id.into(),
            title: term.effect.title.into(),
            p_value: p_value(gain, term.free.iter().filter(|f| **f).count()),
            share: lost.max(0.0),
            parameters,
            alternatives,
            runtime_correctable: true,
        });
    }
    said.sort_by(|a, b| b.share.total_cmp(&a.share));
    let total: f64 = said.iter().map(|e| e.share).sum::<f64>().max(f64::MIN_POSITIVE);
    said.iter_mut().for_each(|e| e.share /= total);
    said
}

/// Where the mismatch lives.
pub fn locations(effects: &[NamedEffect], explained: f64, motion: &Motion) -> Vec<Location> {
    let mut out: Vec<Location> = Vec::new();
    for e in effects {
        let variable = effect(&e.id).map_or("velocity", |e| e.variable);
        if out.iter().any(|l| l.variable == variable) {
            continue;
        }
        let (from, to) = match variable {
            "position" | "history" => range(&motion.position),
            "drive" => range(&motion.drive),
            "frequency_hz" => (0.0, motion.cutoff_hz),
            _ => range(&motion.velocity),
        };
        let (share, p_value) = (e.share * explained, e.p_value);
        out.push(Location { variable: variable.into(), times: None, from, to, share, p_value });
    }
    out
}
