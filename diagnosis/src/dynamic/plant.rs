//! A model to and from `plant.toml`.

use fitter::plant::{Numbers, Plant, PlantEffect, PlantFile};

use super::effects::effect;
use super::model::{Model, Term};
use crate::DiagnosisError;

/// The plant file of a model, with the units and the kind of `nominal`.
pub fn to_file(model: &Model, nominal: &Plant) -> PlantFile {
    let plant = Plant {
        damping: Some(model.nominal[0]),
        stiffness: Some(model.nominal[1]),
        gain: Some(Numbers::One(model.nominal[2])),
        hold: Some(model.hold),
        ..nominal.clone()
    };
    PlantFile { plant, state_space: None, effects: effects(model), equations: None }
}

/// The effects of a model as a file states them.
pub fn effects(model: &Model) -> Vec<PlantEffect> {
    let one = |term: &Term| {
        let readings = term.effect.readings(&term.parameters);
        let values: Vec<(&str, f64)> = readings.iter().map(|r| (r.name, r.value)).collect();
        PlantEffect::new(term.effect.id, &values)
    };
    model.terms.iter().map(one).collect()
}

/// The effects that a plant file states.
///
/// # Errors
/// [`DiagnosisError::Effect`] where an effect is unknown or lacks a parameter.
pub fn given(file: &str, plant: &PlantFile) -> Result<Vec<Term>, DiagnosisError> {
    let one = |given: &PlantEffect| {
        let wrong =
            |reason: String| DiagnosisError::Effect { file: file.into(), id: given.id.clone(), reason };
        let known = effect(&given.id)
            .ok_or_else(|| wrong("is not in the catalogue; correct its id or leave it out".into()))?;
        let parameters = (known.parameters_from)(known, &|name| given.number(name)).ok_or_else(|| {
            let names = known.names();
            wrong(format!("expected the parameters {}, each a number; add what is missing", names.join(", ")))
        })?;
        let shapes = known.parameters.iter().zip(&parameters).filter(|(p, _)| p.shape);
        if let Some((p, value)) = shapes.into_iter().find(|(_, value)| **value <= 0.0) {
            return Err(wrong(format!("`{}` is {value}, expected a number above zero; correct it", p.name)));
        }
        Ok(Term::new(known, parameters))
    };
    plant.effects.iter().map(one).collect()
}
