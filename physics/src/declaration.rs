//! Effects that a user declares: a file of `[[effect]]`, each an expression with its parameters.

use std::collections::BTreeMap;

use serde::Deserialize;
use thiserror::Error;

use crate::check::{Names, Parameter, Sentence};
use crate::error::ExpressionError;
use crate::expression::is_identifier;
use crate::interval::Interval;
use crate::unit::Unit;

/// What is wrong with a file of declarations.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // the messages say what the fields are
pub enum DeclarationError {
    #[error("{file}: {what}")]
    File { file: String, what: String },
    #[error("{file}, effect `{id}`: {what}")]
    Effect { file: String, id: String, what: String },
    #[error("{file}, effect `{id}`, `{field}`: {error}")]
    Expression { file: String, id: String, field: &'static str, error: Box<ExpressionError> },
}

/// A declared effect of a calibration.
#[derive(Debug, Clone)]
pub struct Declared {
    /// Identifier in the diagnosis and in files.
    pub id: String,
    /// Name for a reader.
    pub title: String,
    /// What it adds to the error of the reading.
    pub adds: Sentence,
    /// Where the physics is described; empty where that was not said.
    pub source: String,
    /// Ids of the effects that it is most easily taken for.
    pub confused_with: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    effect: Vec<Entry>,
}

#[derive(Deserialize)]
struct Entry {
    id: String,
    title: Option<String>,
    adds: Option<String>,
    #[serde(default)]
    source: String,
    #[serde(default)]
    confused_with: Vec<String>,
    /// Every further key is a parameter.
    #[serde(flatten)]
    parameters: BTreeMap<String, ParameterEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ParameterEntry {
    unit: String,
    from: Option<f64>,
    to: Option<f64>,
}

/// Reads declared effects, whose values are in `unit`. `column` says the unit of a column, none where there is none of
/// that name; `known` are columns to suggest; `catalogued` are the ids that are taken.
///
/// # Errors
/// [`DeclarationError`] with the effect and the place in its expression.
///
/// # Example
/// ```
/// use physics::{Unit, declared};
///
/// let file = r#"
///     [[effect]]
///     id = "coil_heating"
///     title = "heating by the coil current"
///     adds = "k * lowpass(coil_a^2, tau)"
///     k = { unit = "arcsec/A^2" }
///     tau = { unit = "s", from = 5, to = 5000 }
/// "#;
/// let arcsec = Unit::parse("arcsec").unwrap();
/// let effects = declared("mine.toml", file, &arcsec, &|name| Some(Unit::of_column(name)), &[], &[])?;
/// assert_eq!(effects[0].adds.columns, ["coil_a"]);
/// assert_eq!(effects[0].adds.expression.to_string(), "k * lowpass(coil_a^2, tau)");
/// # Ok::<(), physics::DeclarationError>(())
/// ```
pub fn declared(
    file: &str,
    text: &str,
    unit: &Unit,
    column: &dyn Fn(&str) -> Option<Unit>,
    known: &[&str],
    catalogued: &[&str],
) -> Result<Vec<Declared>, DeclarationError> {
    let read: File = toml::from_str(text).map_err(|error| DeclarationError::File {
        file: file.to_string(),
        what: error.to_string().trim().to_string(),
    })?;
    let mut effects: Vec<Declared> = Vec::with_capacity(read.effect.len());
    for entry in read.effect {
        let refuse =
            |what: String| DeclarationError::Effect { file: file.to_string(), id: entry.id.clone(), what };
        if !is_identifier(&entry.id) {
            return Err(refuse("the id has letters other than a to z, digits and `_`: give another".into()));
        }
        if catalogued.contains(&entry.id.as_str()) || effects.iter().any(|other| other.id == entry.id) {
            return Err(refuse("there is an effect of this id already: give another".into()));
        }
        let adds = entry.adds.as_ref().ok_or_else(|| {
            refuse("has no `adds`, expected the expression that it adds to the error of the reading".into())
        })?;
        let parameters = entry.parameters.iter().map(|(name, entry)| parameter(name, entry).map_err(&refuse));
        let parameters = parameters.collect::<Result<Vec<_>, _>>()?;
        if parameters.iter().all(|parameter| parameter.range.is_some()) {
            return Err(refuse(
                "has no factor, expected a parameter with a unit alone: its size is fitted".into(),
            ));
        }
        let names = Names { column, known, parameters: &parameters };
        let adds = Sentence::read(adds, unit, &names).map_err(|error| DeclarationError::Expression {
            file: file.to_string(),
            id: entry.id.clone(),
            field: "adds",
            error: Box::new(error),
        })?;
        let title = entry.title.clone().unwrap_or_else(|| entry.id.replace('_', " "));
        let Entry { id, source, confused_with, .. } = entry;
        effects.push(Declared { id, title, adds, source, confused_with });
    }
    Ok(effects)
}

fn parameter(name: &str, entry: &ParameterEntry) -> Result<Parameter, String> {
    if !is_identifier(name) {
        return Err(format!(
            "the parameter `{name}` has letters other than a to z, digits and `_`: give another name"
        ));
    }
    let unit = Unit::parse(&entry.unit).map_err(|what| format!("the parameter `{name}`: {what}"))?;
    let range = match (entry.from, entry.to) {
        (None, None) => None,
        (Some(from), Some(to)) if from.is_finite() && to.is_finite() && from < to => {
            Some(Interval { from, to })
        }
        (Some(from), Some(to)) => {
            return Err(format!(
                "the parameter `{name}` runs from {from} to {to}, expected finite numbers, `to` the larger"
            ));
        }
        _ => {
            return Err(format!(
                "the parameter `{name}` has one end of its range: give both `from` and `to`"
            ));
        }
    };
    Ok(Parameter { name: name.to_string(), unit, range })
}
