//! What a declared effect says, for its author.

use std::fmt;

use fitter::terms::Expressed;
use physics::{DeclaredParameter, Role};
use serde::Serialize;

use crate::effects::Effect;

/// What a declared effect says.
#[derive(Debug, Clone, Serialize)]
pub struct Explained {
    /// Its id.
    pub id: String,
    /// Its title.
    pub title: String,
    /// What it adds, as it was understood.
    pub adds: String,
    /// The unit of that.
    pub unit: String,
    /// The columns that it reads, with their units.
    pub columns: Vec<[String; 2]>,
    /// The parameters whose size is fitted, with their units.
    pub factors: Vec<[String; 2]>,
    /// The parameters that are searched in a range, with their units.
    pub searched: Vec<Searched>,
    /// Whether its value depends on the rows before.
    pub remembers: bool,
}

/// A parameter that is searched.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)] // the names say it
pub struct Searched {
    pub name: String,
    pub unit: String,
    /// A number, or an expression of figures of the recording.
    pub from: String,
    pub to: String,
}

impl fmt::Display for Explained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Explained { id, title, adds, unit, columns, factors, searched, remembers } = self;
        let pairs = |pairs: &[[String; 2]]| {
            pairs.iter().map(|[name, unit]| format!("{name} ({unit})")).collect::<Vec<_>>().join(", ")
        };
        writeln!(f, "{id}: {title}")?;
        writeln!(f, "  adds       {adds}, in {unit}")?;
        writeln!(f, "  columns    {}", pairs(columns))?;
        writeln!(f, "  fitted     {}", pairs(factors))?;
        for Searched { name, unit, from, to } in searched {
            writeln!(f, "  searched   {name} from {from} to {to} {unit}")?;
        }
        match remembers {
            true => writeln!(f, "  memory     its value depends on the rows before"),
            false => Ok(()),
        }
    }
}

impl Effect {
    /// What it says, for its author.
    pub fn explained(&self) -> Explained {
        let declared = &self.made.declared;
        let sentence = &declared.adds[0].sentence;
        let unit = sentence.unit.to_string();
        let unit_of = |name: &String| {
            let known = Expressed::observable(name, self.made.pair, &unit);
            known.map_or("?".into(), |(_, unit)| unit.to_string())
        };
        let searched = |parameter: &DeclaredParameter| {
            let (from, to) = match &parameter.role {
                Role::Searched(grid) => (&grid.from, &grid.to),
                Role::Follows(from, to) => (&**from, &**to),
                _ => return None,
            };
            let [from, to] = [from, to].map(|end| end.sentence.text.clone());
            Some(Searched { name: parameter.name.clone(), unit: parameter.unit.to_string(), from, to })
        };
        let factors = self.made.factors.iter().map(|index| self.parameter(*index));
        Explained {
            id: declared.id.clone(),
            title: declared.title.clone(),
            adds: self.formula.clone(),
            columns: sentence.columns.iter().map(|name| [name.clone(), unit_of(name)]).collect(),
            factors: factors.map(|factor| [factor.name.clone(), factor.unit.to_string()]).collect(),
            searched: declared.parameters.iter().filter_map(searched).collect(),
            remembers: sentence.remembers(),
            unit,
        }
    }
}
