//! A second-order plant beside which a user declares effects: it is a sentence of equations, and is diagnosed as one.

use fitter::plant::equations::PlantParameter;
use fitter::plant::{PlantEffect, PlantFile};
use motion::equations::{EquationsError, Plant};

use super::super::data::Data;
use super::super::diagnose::{Case, DynamicOutcome};
use super::super::expected;
use super::catalogue;
use crate::DiagnosisError;
use crate::thresholds::dynamic::diagnose::START_ROWS;
use crate::thresholds::dynamic::equations::GIVEN_RANGE;

/// Diagnoses one recording beside a second-order plant by its equations, which begin at what is identified without the
/// user's effects.
///
/// # Errors
/// One of [`DiagnosisError`]: the recording cannot be diagnosed at all.
pub fn diagnose(case: &Case) -> Result<DynamicOutcome, DiagnosisError> {
    let Case { recording, options, .. } = *case;
    let data = Data::new(recording);
    let seen = expected::nominal(recording, &data.windows(START_ROWS), None, &options.given)?;
    let plant = in_equations(case.plant_file, case.plant, seen.model.nominal)?;
    super::diagnose(&Case { plant: &plant, ..*case })
}

/// A second-order plant in equations, with the effects that its file gives.
///
/// # Errors
/// [`EquationsError`]: a unit that cannot be computed with, feedback, or an effect that equations do not have.
pub fn in_equations(file: &str, plant: &PlantFile, numbers: [f64; 3]) -> Result<PlantFile, EquationsError> {
    let refused = |(key, found, expected)| EquationsError::Key {
        file: file.into(),
        key: format!("`{key}`"),
        what: format!("is {found}, expected {expected}"),
    };
    let mut out = plant.as_equations(numbers).map_err(refused)?;
    let Some(bare) = Plant::of(file, &out) else { return Ok(out) };
    let bare = bare?;
    let known = catalogue::effects(&bare, bare.inputs.len());
    let text = |effect: &PlantEffect| {
        let names =
            |text: &fitter::plant::equations::EffectText| text.parameters.keys().eq(effect.parameters.keys());
        let own = known.iter().find(|own| own.text.id == effect.id && names(&own.text));
        let what = "has no sentence beside effects of your own: leave it out, or declare it among them";
        let key = format!("effect `{}`", effect.id);
        let own = own.ok_or_else(|| EquationsError::Key { file: file.into(), key, what: what.into() })?;
        let mut text = own.text.clone();
        for (name, parameter) in &mut text.parameters {
            let value = effect.number(name);
            let end = |factor: f64| parameter.from.and(value).map(|value| factor * value);
            let (from, to) = (end(1.0 / GIVEN_RANGE), end(GIVEN_RANGE));
            *parameter = PlantParameter { value, from, to, of: None, ..parameter.clone() };
        }
        Ok(text)
    };
    let effects = plant.effects.iter().map(text).collect::<Result<_, _>>()?;
    if let Some(equations) = &mut out.equations {
        equations.effects = effects;
    }
    Ok(out)
}
