//! The parameters of a declared effect: factors, and what is searched in a range.

use serde::{Deserialize, Serialize};

use super::{DeclarationError, Formula, Reader, is_identifier};
use crate::check::Parameter;
use crate::interval::Interval;
use crate::unit::Unit;

/// A parameter of an effect.
#[derive(Debug, Clone)]
pub struct DeclaredParameter {
    /// Its name in the expressions.
    pub name: String,
    /// Its unit.
    pub unit: Unit,
    /// Its unit as it was written.
    pub unit_text: String,
    /// Its name where it is reported.
    pub reported: String,
    /// What it is.
    pub role: Role,
}

/// What a parameter is.
#[derive(Debug, Clone)]
pub enum Role {
    /// Fitted: what the effect adds is linear in it. Between which values it is plausible.
    Factor(Interval),
    /// Searched in a range.
    Searched(Box<Grid>),
    /// No smaller than the first, and what the second makes of the factors.
    Follows(Box<Formula>, Box<Formula>),
    /// A time, halfway between a row and the one before it.
    Row,
    /// How many expressions are added up, in which it counts from 1: so many at most, more than one where each is reported.
    Sum(u16),
}

/// A parameter's range, and how it is searched.
#[derive(Debug, Clone)]
pub struct Grid {
    /// The smallest value.
    pub from: Formula,
    /// The largest one.
    pub to: Formula,
    /// The scale; none: by the ratio of the ends.
    pub scale: Option<Scale>,
    /// From which values the search starts.
    pub starts: Starts,
    /// Over what distance it makes little difference: of its logarithm, on a scale that is not linear.
    pub alike: Option<Formula>,
}

/// On which scale a parameter is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By ratios.
    Logarithmic,
    /// By ratios, from starts that lie evenly in its inverse.
    Inverse,
}

/// From which values a search starts.
#[derive(Debug, Clone)]
pub enum Starts {
    /// So many over the range; none: as many as is usual.
    Over(Option<usize>),
    /// These.
    At(Vec<Formula>),
    /// At this distance from each other at least, which may depend on other parameters: over the range, or between two
    /// values.
    Every(Box<Formula>, Vec<Formula>),
}

/// A number, or an expression for it.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(untagged)]
pub(super) enum Bound {
    Number(f64),
    Text(String),
}

impl Bound {
    fn text(&self) -> String {
        match self {
            Bound::Number(value) => value.to_string(),
            Bound::Text(text) => text.clone(),
        }
    }
}

/// One, or several.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum One<T> {
    One(T),
    Several(Vec<T>),
}

impl<T: Clone> One<T> {
    pub(super) fn all(&self) -> Vec<T> {
        match self {
            One::One(one) => vec![one.clone()],
            One::Several(several) => several.clone(),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ParameterEntry {
    unit: String,
    #[serde(rename = "as")]
    reported: Option<String>,
    from: Option<Bound>,
    to: Option<Bound>,
    least: Option<f64>,
    most: Option<f64>,
    scale: Option<Scale>,
    starts: Option<StartsEntry>,
    every: Option<Bound>,
    alike: Option<Bound>,
    follows: Option<String>,
    #[serde(default)]
    row: bool,
    sum: Option<u16>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum StartsEntry {
    Over(usize),
    At(Vec<Bound>),
}

impl Reader<'_> {
    /// As an expression knows it.
    pub(super) fn plain(&self, name: &str, entry: &ParameterEntry) -> Result<Parameter, DeclarationError> {
        let refuse = |what: String| self.refuse(format!("the parameter `{name}` {what}"));
        if !is_identifier(name) {
            return Err(refuse("has letters other than a to z, digits and `_`: give another name".into()));
        }
        let unit =
            self.vocabulary.unit(&entry.unit).map_err(|what| refuse(format!("has no unit: {what}")))?;
        let range = match (&entry.from, &entry.to) {
            _ if entry.row || entry.sum.is_some() => Some(Interval { from: 0.0, to: f64::INFINITY }),
            (Some(_), None) if entry.follows.is_some() => Some(Interval { from: 0.0, to: f64::INFINITY }),
            (None, None) => None,
            (Some(Bound::Number(from)), Some(Bound::Number(to))) => {
                if !(from.is_finite() && to.is_finite() && from < to) {
                    return Err(refuse(format!(
                        "runs from {from} to {to}, expected finite numbers, `to` the larger"
                    )));
                }
                Some(Interval { from: *from, to: *to })
            }
            (Some(_), Some(_)) => Some(Interval { from: f64::NEG_INFINITY, to: f64::INFINITY }),
            _ => return Err(refuse("has one end of its range: give both `from` and `to`".into())),
        };
        Ok(Parameter { name: name.to_string(), unit, range })
    }

    pub(super) fn parameter(
        &self,
        name: &str,
        entry: &ParameterEntry,
        plain: &[Parameter],
    ) -> Result<DeclaredParameter, DeclarationError> {
        let unit = self.vocabulary.unit(&entry.unit).map_err(|what| self.refuse(what))?;
        let beside = |bound: &Bound| self.formula(name, &bound.text(), Some(&unit), plain, true);
        let role = match (&entry.from, &entry.to, &entry.follows) {
            _ if entry.row => Role::Row,
            _ if entry.sum.is_some() => Role::Sum(entry.sum.unwrap_or(1)),
            (Some(from), _, Some(follows)) => Role::Follows(
                Box::new(beside(from)?),
                Box::new(self.formula(name, follows, Some(&unit), plain, true)?),
            ),
            (Some(from), Some(to), None) => {
                let all = |all: &[Bound]| all.iter().map(beside).collect::<Result<Vec<_>, _>>();
                let starts =
                    match (&entry.starts, &entry.every) {
                        (starts, Some(every)) => {
                            let distance = Box::new(self.formula(name, &every.text(), None, plain, true)?);
                            match starts {
                                None => Starts::Every(distance, Vec::new()),
                                Some(StartsEntry::At(ends)) if ends.len() == 2 => {
                                    Starts::Every(distance, all(ends)?)
                                }
                                _ => return Err(self.refuse(format!(
                                    "the parameter `{name}` has `every` beside `starts` that are not two ends"
                                ))),
                            }
                        }
                        (None, _) => Starts::Over(None),
                        (Some(StartsEntry::Over(count)), _) => Starts::Over(Some(*count)),
                        (Some(StartsEntry::At(values)), _) => Starts::At(all(values)?),
                    };
                let alike = entry.alike.as_ref().map(|a| self.formula(name, &a.text(), None, plain, true));
                let (from, to, alike) = (beside(from)?, beside(to)?, alike.transpose()?);
                Role::Searched(Box::new(Grid { from, to, scale: entry.scale, starts, alike }))
            }
            _ => Role::Factor(Interval {
                from: entry.least.unwrap_or(f64::NEG_INFINITY),
                to: entry.most.unwrap_or(f64::INFINITY),
            }),
        };
        Ok(DeclaredParameter {
            name: name.to_string(),
            unit,
            unit_text: self.vocabulary.named(&entry.unit, "/ ()^"),
            reported: entry.reported.as_ref().map_or(name.into(), |to| self.vocabulary.named(to, "_")),
            role,
        })
    }
}
