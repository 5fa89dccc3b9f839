//! Declared effects: a file of `[[effect]]`, each an expression with its parameters and what is known of it. The
//! catalogue of calibrations is such a file, and so are a user's own.

mod parameter;

use std::collections::BTreeMap;

use serde::Deserialize;
use thiserror::Error;

use crate::check::{Names, Parameter, Sentence};
use crate::error::ExpressionError;
use crate::evaluate::Columns;
use crate::expression::is_identifier;
use crate::interval::Interval;
use crate::unit::Unit;

pub use parameter::{DeclaredParameter, Grid, Role, Scale, Starts};
use parameter::{One, ParameterEntry};

/// What is wrong with a file of declarations.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // the messages say what the fields are
pub enum DeclarationError {
    #[error("{file}: {what}")]
    File { file: String, what: String },
    #[error("{file}, effect `{id}`: {what}")]
    Effect { file: String, id: String, what: String },
    #[error("{file}, effect `{id}`, `{field}`: {error}")]
    Expression { file: String, id: String, field: String, error: Box<ExpressionError> },
}

/// A declared effect of a calibration.
#[derive(Debug, Clone)]
pub struct Declared {
    /// Identifier in the diagnosis and in files.
    pub id: String,
    /// Name for a reader.
    pub title: String,
    /// What it adds to the error of the reading: its forms, of which a recording has one.
    pub adds: Vec<Formula>,
    /// Its parameters, by name.
    pub parameters: Vec<DeclaredParameter>,
    /// What is reported where that is not its parameters.
    pub reported: Vec<Reported>,
    /// What is negative where the effect cannot be.
    pub possible: Option<Formula>,
    /// What else is known of it.
    pub known: Known,
}

/// What is known of an effect beside its expressions.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Known {
    /// Where the physics is described; empty where that was not said.
    #[serde(default)]
    pub source: String,
    /// Sign and magnitude that are plausible; empty where that was not said.
    #[serde(default)]
    pub size: String,
    /// Ids of the effects that it is most easily taken for.
    #[serde(default)]
    pub confused_with: Vec<String>,
    /// The observable that it depends on, and the one that multiplies it; empty: its first column.
    #[serde(default)]
    pub place: Vec<String>,
    /// What a recording must have to show it.
    #[serde(default)]
    pub needs: Vec<String>,
    /// The experiments that tell it from others, each with what it does there.
    #[serde(default)]
    pub told_by: BTreeMap<String, String>,
    /// The titles of a first factor above and below zero.
    pub found_as: Option<[String; 2]>,
    /// Whether its column is a measurement of its own; none: unless the angle or the time is in it.
    pub measured: Option<bool>,
    /// Whether it belongs to the recording in which it happened.
    #[serde(default)]
    pub of_one_time: bool,
    /// Whether it can occur more than once in a recording.
    #[serde(default)]
    pub repeatable: bool,
    /// The name of what is reported that is a place on the angle of one probe.
    pub of_a_probe: Option<String>,
    /// Under which name `fit` finds it already in a sensor that turns.
    pub found_by_fit: Option<String>,
    /// What physics has this form, where it is a form without a name.
    #[serde(default)]
    pub readings: Vec<String>,
    /// Since when it is not known what came before; none where it is known, or does not matter.
    pub unsettled: Option<Unsettled>,
}

/// The names of what is missing of an unsettled effect begin with this.
pub const MISSING: &str = "missing_";

/// Of an effect that follows slowly it is not known how far it had come, so that what is missing is fitted. It fades, and says
/// nothing of other recordings.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unsettled {
    /// Name of the time constant.
    pub fades_with: String,
    /// Since when it is not known.
    pub since: Since,
}

/// Since when it is not known how far an effect had come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Since {
    /// The first row.
    Start,
    /// The first row, and again the first row after every pause.
    Pauses,
}

/// An expression with the parameters of the effect that it reads.
#[derive(Debug, Clone)]
pub struct Formula {
    /// The expression.
    pub sentence: Sentence,
    /// Of each of its parameters the index among those of the effect.
    pub of: Vec<usize>,
}

/// What is reported of an effect.
#[derive(Debug, Clone)]
pub struct Reported {
    /// Its name in the declaration.
    pub written: String,
    /// Its name.
    pub name: String,
    /// The name of its unit.
    pub unit: String,
    /// Its value.
    pub value: What,
}

/// How a value that is reported comes about.
#[derive(Debug, Clone)]
pub enum What {
    /// By an expression.
    Formula(Box<Formula>),
    /// By the function of this name.
    Named(String),
}

impl Formula {
    /// The values of its own parameters among those of the effect.
    pub fn own(&self, all: &[f64]) -> Vec<f64> {
        self.of.iter().map(|index| all[*index]).collect()
    }

    /// Its value at every row, a single one of all, where the parameters of the effect have these values.
    ///
    /// # Errors
    /// The name of a column that is missing.
    pub fn values(&self, columns: &dyn Columns, all: &[f64]) -> Result<Vec<f64>, String> {
        self.sentence.values(columns, &self.own(all))
    }
}

/// What the names in a file of declarations mean.
pub struct Vocabulary<'a> {
    /// The unit of the position, for which `p` stands.
    pub position: &'a Unit,
    /// The unit in which places on the angle are reported, with its name.
    pub places: (&'a Unit, &'a str),
    /// The name of the position's unit.
    pub name: &'a str,
    /// The unit of a column; none where there is none of that name.
    pub column: &'a dyn Fn(&str) -> Option<Unit>,
    /// Columns to suggest.
    pub known: &'a [&'a str],
    /// The unit of a figure of the recording that the ends of ranges may name.
    pub figure: &'a dyn Fn(&str) -> Option<Unit>,
    /// Ids that are taken.
    pub taken: &'a [&'a str],
}

impl Vocabulary<'_> {
    /// A unit as it was written, with the position's own in place of `p` and that of places in place of `place`.
    fn unit(&self, text: &str) -> Result<Unit, String> {
        Ok(Unit::parse(text)?.with("p", self.position).with("place", self.places.0))
    }

    /// A text with the name of the position's unit in place of every word `p`, and that of places in place of `place`;
    /// words end at any of `ends`.
    fn named(&self, text: &str, ends: &str) -> String {
        let word = |word: &str| match word.trim_end_matches(|end| ends.contains(end)) {
            "p" => word.replacen('p', self.name, 1),
            "place" => word.replacen("place", self.places.1, 1),
            _ => word.to_string(),
        };
        text.split_inclusive(|end| ends.contains(end)).map(word).collect()
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct File {
    pub effect: Vec<Entry>,
}

#[derive(Deserialize)]
pub(crate) struct Entry {
    pub id: String,
    title: Option<String>,
    adds: Option<One<String>>,
    possible: Option<String>,
    /// Name, expression or `function()`, unit.
    #[serde(default)]
    reported: Vec<[String; 3]>,
    #[serde(flatten)]
    pub known: Known,
    /// Every further key is a parameter.
    #[serde(flatten)]
    parameters: BTreeMap<String, ParameterEntry>,
}

/// Reads declared effects.
///
/// # Errors
/// [`DeclarationError`] with the effect and the place in its expression.
///
/// # Example
/// ```
/// use physics::{Unit, Vocabulary, declared};
///
/// let file = r#"
///     [[effect]]
///     id = "coil_heating"
///     title = "heating by the coil current"
///     adds = "k * lowpass(coil_a^2, tau)"
///     k = { unit = "p/A^2" }
///     tau = { unit = "s", from = 5, to = "duration" }
/// "#;
/// let arcsec = Unit::named("arcsec");
/// let vocabulary = Vocabulary {
///     position: &arcsec,
///     places: (&Unit::named("deg"), "deg"),
///     name: "arcsec",
///     column: &|name| Some(Unit::of_column(name)),
///     known: &[],
///     figure: &|name| (name == "duration").then(|| Unit::named("s")),
///     taken: &[],
/// };
/// let effects = declared("mine.toml", file, &vocabulary)?;
/// assert_eq!(effects[0].adds[0].sentence.columns, ["coil_a"]);
/// assert_eq!(effects[0].adds[0].sentence.expression.to_string(), "k * lowpass(coil_a^2, tau)");
/// # Ok::<(), physics::DeclarationError>(())
/// ```
pub fn declared(file: &str, text: &str, vocabulary: &Vocabulary) -> Result<Vec<Declared>, DeclarationError> {
    let read: File = toml::from_str(text).map_err(|error| DeclarationError::File {
        file: file.to_string(),
        what: error.to_string().trim().to_string(),
    })?;
    let mut effects: Vec<Declared> = Vec::with_capacity(read.effect.len());
    for entry in read.effect {
        let taken = |id: &str| vocabulary.taken.contains(&id) || effects.iter().any(|other| other.id == id);
        let effect = Reader { file, id: &entry.id, vocabulary }.read(&entry, taken(&entry.id))?;
        effects.push(effect);
    }
    Ok(effects)
}

/// Reads one effect.
struct Reader<'a> {
    file: &'a str,
    id: &'a str,
    vocabulary: &'a Vocabulary<'a>,
}

impl Reader<'_> {
    fn refuse(&self, what: impl Into<String>) -> DeclarationError {
        DeclarationError::Effect { file: self.file.into(), id: self.id.into(), what: what.into() }
    }

    fn read(&self, entry: &Entry, taken: bool) -> Result<Declared, DeclarationError> {
        if !is_identifier(self.id) {
            return Err(self.refuse("the id has letters other than a to z, digits and `_`: give another"));
        }
        if taken {
            return Err(self.refuse("there is an effect of this id already: give another"));
        }
        let adds = entry.adds.as_ref().ok_or_else(|| {
            self.refuse("has no `adds`, expected the expression that it adds to the error of the reading")
        })?;
        let entries = &entry.parameters;
        let plain =
            entries.iter().map(|(name, entry)| self.plain(name, entry)).collect::<Result<Vec<_>, _>>()?;
        if plain.iter().all(|parameter| parameter.range.is_some()) {
            return Err(
                self.refuse("has no factor, expected a parameter with a unit alone: its size is fitted")
            );
        }
        let adds = adds.all();
        let adds =
            adds.iter().map(|text| self.formula("adds", text, Some(self.vocabulary.position), &plain, false));
        let adds = adds.collect::<Result<Vec<_>, _>>()?;
        let used = |index: usize| adds.iter().any(|form| form.of.contains(&index));
        if let Some(idle) = (0..plain.len()).find(|index| !used(*index)) {
            let name = &plain[idle].name;
            return Err(
                self.refuse(format!("the parameter `{name}` is not in the expression: use it or drop it"))
            );
        }
        let factors = |form: &Formula| form.of.iter().filter(|index| plain[**index].range.is_none()).count();
        if adds.iter().any(|form| factors(form) != factors(&adds[0])) {
            return Err(self.refuse("has forms of different factors, expected the same in each"));
        }
        let parameters = entries.iter().map(|(name, entry)| self.parameter(name, entry, &plain));
        let parameters = parameters.collect::<Result<Vec<_>, _>>()?;
        if let Some(unsettled) = &entry.known.unsettled {
            self.check_unsettled(unsettled, &parameters)?;
        }
        let possible = entry.possible.as_ref().map(|text| self.formula("possible", text, None, &plain, true));
        let reported = entry.reported.iter().map(|reported| self.reported(reported, &plain));
        Ok(Declared {
            id: self.id.to_string(),
            title: entry.title.clone().unwrap_or_else(|| self.id.replace('_', " ")),
            parameters,
            possible: possible.transpose()?,
            reported: reported.collect::<Result<_, _>>()?,
            known: entry.known.clone(),
            adds,
        })
    }

    /// Refuses what does not fade with a time constant that is searched, and parameters named like what is missing.
    fn check_unsettled(
        &self,
        Unsettled { fades_with, .. }: &Unsettled,
        parameters: &[DeclaredParameter],
    ) -> Result<(), DeclarationError> {
        let is_time = |unit: &Unit| unit.in_units_of(&Unit::named("s")).is_some();
        let is_it = |parameter: &DeclaredParameter| {
            let searched = matches!(parameter.role, Role::Searched(_)) && is_time(&parameter.unit);
            parameter.name == *fades_with && searched
        };
        if !parameters.iter().any(is_it) {
            return Err(self.refuse(format!(
                "`unsettled` fades with `{fades_with}`, expected the name of a time constant that is searched"
            )));
        }
        match parameters.iter().find(|parameter| parameter.name.starts_with(MISSING)) {
            Some(DeclaredParameter { name, .. }) => Err(self.refuse(format!(
                "the parameter `{name}` has the name of what is missing of an unsettled effect: give another"
            ))),
            None => Ok(()),
        }
    }

    fn reported(&self, of: &[String; 3], plain: &[Parameter]) -> Result<Reported, DeclarationError> {
        let [name, value, unit] = of;
        let value = match value.strip_suffix("()") {
            Some(function) => What::Named(function.to_string()),
            None => {
                let unit = self.vocabulary.unit(unit).map_err(|what| self.refuse(what))?;
                What::Formula(Box::new(self.formula(name, value, Some(&unit), plain, true)?))
            }
        };
        let unit = self.vocabulary.named(unit, "/ ()^");
        Ok(Reported { written: name.clone(), name: self.vocabulary.named(name, "_"), unit, value })
    }

    /// An expression of the effect's parameters in `unit`, if any is asked for. One `beside` what it adds reads figures of the recording, and
    /// its factors as any number.
    fn formula(
        &self,
        field: &str,
        text: &str,
        unit: Option<&Unit>,
        parameters: &[Parameter],
        beside: bool,
    ) -> Result<Formula, DeclarationError> {
        let wrong = |error: ExpressionError| DeclarationError::Expression {
            file: self.file.into(),
            id: self.id.into(),
            field: field.into(),
            error: Box::new(error),
        };
        let expression = crate::parse(text).map_err(wrong)?;
        let names = expression.names();
        let of: Vec<usize> =
            (0..parameters.len()).filter(|index| names.contains(&parameters[*index].name.as_str())).collect();
        let any = Interval { from: f64::NEG_INFINITY, to: f64::INFINITY };
        let own = of.iter().map(|index| Parameter {
            range: if beside { Some(any) } else { parameters[*index].range },
            ..parameters[*index].clone()
        });
        let column = |name: &str| match (self.vocabulary.figure)(name).filter(|_| beside) {
            Some(unit) => Some(unit),
            None => (self.vocabulary.column)(name),
        };
        let own: Vec<Parameter> = own.collect();
        let names = Names { column: &column, known: self.vocabulary.known, parameters: &own };
        Ok(Formula { sentence: Sentence::read(text, unit, &names).map_err(wrong)?, of })
    }
}
