//! An effect that the user declared: an expression, linear in its factors, whose other parameters are searched in their
//! ranges.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use fitter::error_model::Sensor;
use fitter::message::Message;
use fitter::terms::{Expressed, ExpressionFactor, Fixed, Operator};
use physics::{Columns, DeclarationError, Declared, Interval, Time, Unit, Value};
use serde::Serialize;

use super::{Effect, Facts, Handed, Range, Reading, logarithmic, reading};
use crate::rows::Rows;
use crate::thresholds::effects::declared::{LOGARITHMIC, STARTS};

/// Effects that a user declared, for recordings of one kind of sensor.
#[derive(Clone)]
pub struct DeclaredEffect {
    facts: &'static Facts,
    declared: Arc<Declared>,
    pair: bool,
}

/// Reads a file of declared effects for a sensor.
///
/// # Errors
/// [`DeclarationError`], with the effect and the place in its expression.
pub fn read(file: &str, text: &str, sensor: &Sensor) -> Result<Vec<DeclaredEffect>, DeclarationError> {
    let (pair, name) = match sensor {
        Sensor::EddyCurrentPair { .. } => (true, "arcsec"),
        Sensor::Direct { unit, .. } => (false, unit.as_str()),
    };
    let of_file = |what: String| DeclarationError::File { file: file.to_string(), what };
    let unit = Unit::parse(name).map_err(of_file)?;
    let taken = super::catalogue().iter().map(|effect| effect.id()).collect::<Vec<_>>();
    let column = |column: &str| match column {
        // The instrument that knows it is not there at run time.
        "true_angle" | "reference" | "reference_arcsec" => None,
        _ => Expressed::observable(column, pair, name).ok().map(|(_, unit)| unit),
    };
    let known = ["angle", "common_mode", "direction", "t_s", "temperature_c", "coil_a", "cross_arcsec"];
    let declared = physics::declared(file, text, &unit, &column, &known, &taken)?;
    Ok(declared.into_iter().map(|declared| DeclaredEffect::of(declared, pair)).collect())
}

/// Reads declared effects from a file.
///
/// # Errors
/// As [`read`], or the file cannot be read.
pub fn read_file(path: &Path, sensor: &Sensor) -> Result<Vec<DeclaredEffect>, Message> {
    let file = fitter::text_safety::path(path);
    let text = fitter::input::parsed(path, "file of effects (TOML)")?;
    read(&file, &text, sensor).map_err(Message::of)
}

/// What a declared effect says, for its author.
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
    pub from: f64,
    pub to: f64,
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
        if *remembers {
            writeln!(f, "  memory     its value depends on the rows before")?;
        }
        writeln!(f, "  applied    by `apply`; firmware for expressions is not generated")
    }
}

impl DeclaredEffect {
    /// What it says, for its author.
    pub fn explained(&self) -> Explained {
        let Declared { id, title, adds, .. } = &*self.declared;
        let unit_of = |name: &String| {
            Expressed::observable(name, self.pair, &adds.unit.to_string())
                .map_or("?".into(), |(_, unit)| unit.to_string())
        };
        let factors = adds.factors().into_iter().map(|index| &adds.parameters[index]);
        Explained {
            id: id.clone(),
            title: title.clone(),
            adds: adds.expression.to_string(),
            unit: adds.unit.to_string(),
            columns: adds.columns.iter().map(|name| [name.clone(), unit_of(name)]).collect(),
            factors: factors.map(|factor| [factor.name.clone(), factor.unit.to_string()]).collect(),
            searched: (self.ranged())
                .map(|(parameter, Interval { from, to })| Searched {
                    name: parameter.name.clone(),
                    unit: parameter.unit.to_string(),
                    from,
                    to,
                })
                .collect(),
            remembers: adds.remembers(),
        }
    }

    fn of(declared: Declared, pair: bool) -> DeclaredEffect {
        // The catalogue lasts as long as the program; so do declared effects, which are read once.
        let kept = |text: String| -> &'static str { text.leak() };
        let confused_with: Vec<&'static str> = declared.confused_with.iter().cloned().map(kept).collect();
        let place = match declared.adds.columns.first().map(String::as_str) {
            Some("angle" | "measured") | None => "angle_deg",
            Some("common_mode") => "common_mode_um",
            Some(column) => column,
        };
        let facts = Facts {
            id: kept(declared.id.clone()),
            title: kept(declared.title.clone()),
            formula: kept(declared.adds.expression.to_string()),
            source: kept(declared.source.clone()),
            size: "as declared",
            confused_with: confused_with.leak(),
            variable: kept(place.to_string()),
            measured: true,
            declared: true,
            ..Facts::USUAL
        };
        DeclaredEffect { facts: Box::leak(Box::new(facts)), declared: Arc::new(declared), pair }
    }

    /// What it adds per unit of each factor, at these values of the other parameters.
    fn value(&self, rows: &Rows, shape: &[f64]) -> Option<Value> {
        let mut shape = shape.iter();
        let values: Option<Vec<f64>> = (self.declared.adds.parameters.iter())
            .map(|parameter| if parameter.range.is_some() { shape.next().copied() } else { Some(1.0) })
            .collect();
        self.declared.adds.evaluate(&Read(rows), &values?).ok()
    }

    fn ranged(&self) -> impl Iterator<Item = (&physics::Parameter, Interval)> {
        self.declared.adds.parameters.iter().filter_map(|parameter| Some((parameter, parameter.range?)))
    }

    fn range(interval: Interval) -> Range {
        let Interval { from, to } = interval;
        Range { low: from, high: to, logarithmic: from > 0.0 && to > LOGARITHMIC * from, whole: false }
    }
}

impl Effect for DeclaredEffect {
    fn facts(&self) -> &Facts {
        self.facts
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        let read = Read(rows);
        let missing = self.declared.adds.columns.iter().find(|name| read.column(name).is_none());
        if let Some(name) = missing {
            return Err(format!("the recording has no usable column {name}"));
        }
        let over = |name: &str| {
            let values = read.column(name).unwrap_or_default();
            Interval::around(values.iter().copied()).unwrap_or(Interval::point(0.0))
        };
        let adds = &self.declared.adds;
        adds.interval(&over).map(drop).map_err(|error| format!("its expression has no value here: {error}"))
    }

    fn starts(&self, _: &Rows) -> Vec<Vec<f64>> {
        let mut starts = vec![Vec::new()];
        for (_, interval) in self.ranged() {
            let Range { low, high, logarithmic: by_ratio, .. } = DeclaredEffect::range(interval);
            let even = |k: usize| low + (high - low) * (k as f64 + 0.5) / STARTS as f64;
            let values: Vec<f64> =
                if by_ratio { logarithmic(low, high, STARTS) } else { (0..STARTS).map(even).collect() };
            starts = (starts.iter())
                .flat_map(|start: &Vec<f64>| values.iter().map(move |value| [&start[..], &[*value]].concat()))
                .collect();
        }
        starts
    }

    fn ranges(&self, _: &Rows) -> Vec<Range> {
        self.ranged().map(|(_, interval)| DeclaredEffect::range(interval)).collect()
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let Some(value) = self.value(rows, shape) else { return Vec::new() };
        let column = |factor: usize| (0..rows.len()).map(|row| value.slope(factor, row)).collect();
        self.declared.adds.factors().into_iter().map(column).collect()
    }

    fn possible_shape(&self, rows: &Rows, shape: &[f64]) -> bool {
        let finite = |values: &Vec<f64>| values.iter().all(|value| value.is_finite());
        self.value(rows, shape).is_some_and(|value| value.slopes.iter().all(|(_, slopes)| finite(slopes)))
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        let adds = &self.declared.adds;
        let factors: Vec<ExpressionFactor> = (adds.factors().into_iter())
            .map(|index| &adds.parameters[index])
            .map(|factor| ExpressionFactor { name: factor.name.clone(), unit: factor.unit.to_string() })
            .collect();
        let fixed = self.ranged().zip(shape).map(|((parameter, _), value)| Fixed {
            name: parameter.name.clone(),
            unit: parameter.unit.to_string(),
            value: *value,
        });
        let width = factors.len();
        let map = (0..width).map(|row| (0..width).map(|k| f64::from(u8::from(row == k))).collect()).collect();
        let operator = Operator::Expression(Expressed {
            text: adds.expression.to_string(),
            unit: rows.unit.clone(),
            observables: Expressed::observables_of(adds, self.pair, &rows.unit),
            parameters: fixed.collect(),
            factors,
        });
        Handed { operator, map }
    }

    fn readings(&self, _: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let adds = &self.declared.adds;
        let factors = adds.factors().into_iter().map(|index| &adds.parameters[index]).zip(amplitudes);
        let others = self.ranged().map(|(parameter, _)| parameter).zip(shape);
        factors
            .chain(others)
            .map(|(parameter, value)| reading(parameter.name.as_str(), *value, parameter.unit.to_string()))
            .collect()
    }
}

/// The rows of a diagnosis as an expression reads them.
struct Read<'a>(&'a Rows);

impl Columns for Read<'_> {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        let rows = self.0;
        let of = |values: &'_ Option<Vec<f64>>| values.clone().map(Cow::Owned);
        let (observable, _) = Expressed::observable(name, rows.pair, &rows.unit).ok()?;
        match observable {
            "angle_arcsec" if rows.pair => Some(Cow::Borrowed(&rows.theta)),
            "measured" if !rows.pair => Some(Cow::Borrowed(&rows.theta)),
            "t_s" => Some(Cow::Borrowed(&rows.t_s)),
            "direction" => Some(Cow::Borrowed(&rows.direction)),
            "pass" => Some(rows.pass.iter().map(|pass| *pass as f64).collect()),
            "common_mode_um" => of(&rows.common_mode_um),
            "cross_arcsec" => of(&rows.cross_arcsec),
            "temperature_c" => of(&rows.temperature_c),
            "coil_a" => of(&rows.coil_a),
            "command_deg" => of(&rows.command_deg),
            _ => rows
                .extra
                .iter()
                .find(|column| column.name == name)
                .map(|column| Cow::Borrowed(&column.values[..])),
        }
    }

    fn time(&self) -> Time<'_> {
        Time { t_s: &self.0.t_s, pass: &self.0.pass }
    }
}
