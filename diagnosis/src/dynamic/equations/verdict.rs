//! From what was found in a plant of equations to what is said and written.

use std::sync::Arc;

use fitter::plant::equations::{PlantParameter, StateStart};
use fitter::plant::{Equations, PlantFile};
use fitter::table::Values;
use motion::equations::Target;
use numerics::{Symmetric, range};

use super::super::data::Data;
use super::super::estimate::Fitted;
use super::super::interval::{Sort, around};
use super::super::verdict::p_value;
use super::model::{Model, Term};
use super::search::Search;
use crate::thresholds::dynamic::verdict::ALTERNATIVE_MARGIN;
use crate::verdict::{Location, NamedEffect, Parameter};

/// Standard deviations of the values of the free parameters.
fn deviations(found: &Fitted<Model>, covariance: &Symmetric) -> Vec<f64> {
    let slopes = found.model.slopes();
    slopes.iter().enumerate().map(|(k, slope)| slope.abs() * covariance.at(k, k).max(0.0).sqrt()).collect()
}

/// What is said of the effects of a model: on the windows of the search, and on the whole recording.
pub fn effects(
    search: &Search,
    data: &Data,
    [small, found]: [&Fitted<Model>; 2],
    covariance: &Symmetric,
    kind: impl Fn(&str) -> &'static str + Sync,
) -> Vec<NamedEffect> {
    let deviations = deviations(found, covariance);
    search.named(data, [small, found], ALTERNATIVE_MARGIN, |k, gain, alternatives| {
        let term = &found.model.terms[k];
        let packed = found.model.packed_of(k);
        let parameters = (term.effect.parameters.iter().zip(&term.values).zip(&packed))
            .map(|((parameter, value), number)| Parameter {
                name: parameter.name.clone(),
                value: *value,
                unit: parameter.unit.to_string(),
                ci95: around(*value, number.map_or(0.0, |k| deviations[k]), Sort::Amount),
            })
            .collect();
        let text = &term.effect.text;
        NamedEffect {
            id: text.id.clone(),
            kind: kind(&text.id),
            title: term.effect.title(),
            formula: term.effect.formula(&found.model.plant),
            p_value: p_value(gain, packed.iter().flatten().count()),
            share: 0.0,
            parameters,
            alternatives,
            runtime_correctable: true,
            form: crate::verdict::Form { readings: text.readings.clone(), declaration: None },
        }
    })
}

/// The parameters of the plant with their intervals, and where its states begin.
pub fn plant(found: &Fitted<Model>, covariance: &Symmetric) -> Vec<Parameter> {
    let (model, deviations) = (&found.model, deviations(found, covariance));
    let mut number = 0;
    let own = model.plant.parameters.iter().zip(&model.values).enumerate().map(|(k, (parameter, value))| {
        let free = model.plant.is_free(k);
        let deviation = if free { deviations[number] } else { 0.0 };
        number += usize::from(free);
        Parameter {
            name: parameter.name.clone(),
            value: *value,
            unit: parameter.unit.to_string(),
            ci95: around(*value, deviation, Sort::Amount),
        }
    });
    own.collect()
}

/// The plant as it is written: its parameters at their values, its effects, and where its states begin, if there is one
/// run.
pub fn to_file(found: &Fitted<Model>, nominal: &PlantFile) -> PlantFile {
    let model = &found.model;
    let Some(mut equations) = nominal.equations.clone() else { return nominal.clone() };
    for ((_, parameter), value) in equations.parameters.0.iter_mut().zip(&model.values) {
        parameter.value = Some(*value);
    }
    if let [start] = &found.states[..] {
        for ((_, state), value) in equations.states.0.iter_mut().zip(start) {
            state.start = StateStart::At(*value);
        }
    }
    equations.sampling = (!equations.inputs.0.is_empty()).then_some(model.hold);
    equations.effects = model.terms.iter().map(text).collect();
    PlantFile { equations: Some(Box::<Equations>::new(*equations)), ..nominal.clone() }
}

/// A term as it is written.
fn text(term: &Term) -> fitter::plant::equations::EffectText {
    let mut text = term.effect.text.clone();
    for (parameter, value) in text.parameters.values_mut().zip(&term.values) {
        *parameter = PlantParameter { value: Some(*value), ..parameter.clone() };
    }
    text
}

/// Where the mismatch lives: on what the effects read, by what they explain.
pub fn locations(
    found: &Fitted<Model>,
    columns: &[(String, Values)],
    named: &[NamedEffect],
    explained: f64,
    reach: impl Fn(&str) -> (f64, f64),
) -> Vec<Location> {
    let mut out: Vec<Location> = Vec::new();
    for effect in named {
        let term = found.model.terms.iter().find(|term| term.effect.text.id == effect.id);
        let Some(term) = term else { continue };
        let location =
            location(&found.model, term, columns, [effect.share * explained, effect.p_value], &reach);
        if out.iter().all(|known| known.variable != location.variable) {
            out.push(location);
        }
    }
    out.sort_by(|a, b| b.share.total_cmp(&a.share));
    out
}

/// Where a term acts, with the share of what it explains and its p-value.
pub fn location(
    model: &Model,
    term: &Term,
    columns: &[(String, Values)],
    [share, p_value]: [f64; 2],
    reach: impl Fn(&str) -> (f64, f64),
) -> Location {
    let further = columns.iter().find(|(name, _)| reads(term, name));
    let of_motion = variable(model, term);
    let (variable, times) = match further {
        Some((name, _)) => (name.as_str(), Some(of_motion)),
        None if reads(term, "t") => ("t_s", Some(of_motion)),
        None => (of_motion, None),
    };
    let (from, to) = further.map_or_else(|| reach(variable), |(_, values)| range(values));
    Location { variable: variable.into(), times: times.map(Into::into), from, to, share, p_value }
}

/// Whether an effect reads a name.
fn reads(term: &Term, name: &str) -> bool {
    term.effect.adds.iter().any(|added| added.sentence.columns.iter().any(|column| column == name))
}

/// The recorded quantity on which an effect depends.
fn variable(model: &Model, term: &Term) -> &'static str {
    let plant = &model.plant;
    let reads = |name: &str| reads(term, name);
    let on_input = term.effect.adds.iter().any(|added| matches!(added.to, Target::Input(_)));
    let output = plant.states.iter().position(|(name, _)| *name == plant.output.1.text);
    let rate = output.map(|k| plant.rates[k].0.text.as_str());
    if on_input || plant.inputs.iter().any(|(name, _)| reads(name)) {
        "drive"
    } else if rate.is_some_and(&reads) {
        "velocity"
    } else {
        "position"
    }
}

/// Effects of a plant without those that were withdrawn.
pub fn without(model: &Model, withdrawn: &[String]) -> Option<Model> {
    let kept: Vec<Term> =
        model.terms.iter().filter(|term| !withdrawn.contains(&term.effect.text.id)).cloned().collect();
    (kept.len() < model.terms.len()).then(|| model.with_terms(kept)).flatten()
}

/// Ids of effects.
pub fn ids(effects: &[Arc<motion::equations::MotionEffect>]) -> Vec<String> {
    effects.iter().map(|effect| effect.text.id.clone()).collect()
}
