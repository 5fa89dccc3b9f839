//! `expression`: what an expression of physics adds, linear in its factors: one coefficient per factor.

use std::borrow::Cow;
use std::collections::BTreeMap;

use physics::{Columns, Interval, Names, Parameter, Sentence, Time, Unit};
use serde::{Deserialize, Serialize};

use super::{Missing, Observables};
use crate::error_model::Sensor;

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expressed {
    /// The expression, of columns, factors and parameters by name: `k * lowpass(coil_a^2, tau)`.
    pub text: String,
    /// The unit of its values: that of the statistics.
    pub unit: String,
    /// The observables that it reads, as [`Observables::get`] knows them.
    pub observables: Vec<String>,
    /// The parameters on which it depends linearly, one for each coefficient.
    pub factors: Vec<Factor>,
    /// The other parameters with their values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<Fixed>,
    /// Between which values columns are limited before they are read: far beyond what was recorded nothing speaks for a form
    /// without a name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub limits: BTreeMap<String, [f64; 2]>,
}

/// A parameter on which an expression depends linearly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// Its name in the expression.
    pub name: String,
    /// Its unit.
    pub unit: String,
}

/// A parameter with its value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fixed {
    /// Its name in the expression.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
}

impl Expressed {
    /// The observable and the unit that a name in an expression stands for: `angle` and `common_mode` by the sensor (a
    /// pair of probes or not, of this `unit`), anything else a column by its name, whose end says its unit.
    ///
    /// # Errors
    /// The sensor's own unit is none that can be read.
    pub fn observable<'a>(name: &'a str, pair: bool, unit: &str) -> Result<(&'a str, Unit), String> {
        match (name, pair) {
            ("angle", true) => Ok(("angle_arcsec", Unit::parse("arcsec")?)),
            ("angle" | "measured", false) => Ok(("measured", Unit::parse(unit)?)),
            ("common_mode", true) => Ok(("common_mode_um", Unit::parse("um")?)),
            ("direction" | "pass", _) => Ok((name, Unit::one())),
            _ => Ok((name, Unit::of_column(name))),
        }
    }

    /// The observables that an expression reads; the time as well where it remembers.
    fn observables_of(sentence: &Sentence, pair: bool, unit: &str) -> Vec<String> {
        let named = |name: &String| match Expressed::observable(name, pair, unit) {
            Ok((observable, _)) => observable.to_string(),
            Err(_) => name.clone(),
        };
        let mut observables: Vec<String> = sentence.columns.iter().map(named).collect();
        if sentence.remembers() && !observables.iter().any(|name| name == "t_s") {
            observables.push("t_s".into());
        }
        observables
    }

    /// An expression for a sensor: a pair of probes or not, of this unit. What is wrong in it is said when it is read.
    pub fn of(
        text: String,
        unit: &str,
        pair: bool,
        factors: Vec<Factor>,
        parameters: Vec<Fixed>,
    ) -> Expressed {
        let (observables, limits) = (Vec::new(), BTreeMap::new());
        let made = Expressed { text, unit: unit.to_string(), observables, factors, parameters, limits };
        let sentence = made.sentence(pair);
        let observables = sentence.map(|sentence| Expressed::observables_of(&sentence, pair, unit));
        Expressed { observables: observables.unwrap_or_default(), ..made }
    }

    /// The expression, read again for a pair of probes or another sensor.
    ///
    /// # Errors
    /// A sentence that says what is wrong with it and where.
    pub fn sentence(&self, pair: bool) -> Result<Sentence, String> {
        let unit = Unit::parse(&self.unit)?;
        let factors = self.factors.iter().map(|factor| (&factor.name, &factor.unit, None));
        // A value is a range of one number: of a factor there is none.
        let fixed = self
            .parameters
            .iter()
            .map(|fixed| (&fixed.name, &fixed.unit, Some(Interval::point(fixed.value))));
        let parameters = factors
            .chain(fixed)
            .map(|(name, unit, range)| Ok(Parameter { name: name.clone(), unit: Unit::parse(unit)?, range }));
        let parameters = parameters.collect::<Result<Vec<_>, String>>()?;
        let column = |name: &str| Expressed::observable(name, pair, &self.unit).ok().map(|(_, unit)| unit);
        let names = Names { column: &column, known: &[], parameters: &parameters };
        Sentence::read(&self.text, Some(&unit), &names).map_err(|error| error.to_string())
    }

    /// What contradicts itself in it; none if it can be evaluated.
    pub(super) fn contradiction(&self) -> Option<String> {
        if let Some(fixed) = self.parameters.iter().find(|fixed| !fixed.value.is_finite()) {
            return Some(format!("`{}` of an `expression` term is {}", fixed.name, fixed.value));
        }
        let ordered = |[from, to]: &[f64; 2]| from.partial_cmp(to).is_some_and(|order| order.is_le());
        if let Some((name, [from, to])) = self.limits.iter().find(|(_, ends)| !ordered(ends)) {
            return Some(format!("`limits` of `{name}` in an `expression` term are {from} and {to}"));
        }
        let wrong = |error: String| format!("the expression `{}` of a term: {error}", self.text);
        let (of_pair, of_other) = (self.sentence(true), self.sentence(false));
        let stated = |sentence: &Sentence, pair| {
            Expressed::observables_of(sentence, pair, &self.unit) == self.observables
        };
        match (of_pair, of_other) {
            (Err(error), Err(_)) => Some(wrong(error)),
            (Ok(sentence), _) if stated(&sentence, true) => None,
            (_, Ok(sentence)) if stated(&sentence, false) => None,
            _ => Some(wrong("`observables` are not those that it reads".into())),
        }
    }

    pub(super) fn columns(&self, observables: &Observables) -> Result<Vec<Vec<f64>>, Missing> {
        let pair = matches!(observables.sensor, Sensor::EddyCurrentPair { .. });
        let missing = |observable: String| Missing { observable };
        let sentence = self.sentence(pair).map_err(missing)?;
        let read = Read {
            observables,
            pair,
            unit: &self.unit,
            limits: &self.limits,
            pass: observables.recording.pass.iter().map(|pass| i64::from(*pass)).collect(),
        };
        let values: Vec<f64> =
            self.factors.iter().map(|_| 1.0).chain(self.parameters.iter().map(|fixed| fixed.value)).collect();
        let value = sentence.evaluate(&read, &values).map_err(missing)?;
        let rows = observables.recording.rows();
        let mut columns: Vec<Vec<f64>> =
            (0..self.factors.len()).map(|k| (0..rows).map(|row| value.slope(k, row)).collect()).collect();
        // Beyond what was recorded an expression may have no value (a division by zero): as a blank cell has none.
        let without = columns.iter_mut().flatten().filter(|value| !value.is_finite());
        without.for_each(|value| *value = f64::NAN);
        if !sentence.remembers() {
            for name in &sentence.columns {
                let cells = read.cells(name).ok_or_else(|| missing(name.clone()))?;
                for column in &mut columns {
                    let blank = column.iter_mut().zip(cells.iter()).filter(|(_, cell)| cell.is_nan());
                    blank.for_each(|(value, _)| *value = f64::NAN);
                }
            }
        }
        Ok(columns)
    }
}

/// A recording as an expression reads it.
struct Read<'a> {
    observables: &'a Observables<'a>,
    pair: bool,
    unit: &'a str,
    limits: &'a BTreeMap<String, [f64; 2]>,
    pass: Vec<i64>,
}

impl Read<'_> {
    /// The cells of a column, NaN where blank.
    fn cells(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        let (observable, _) = Expressed::observable(name, self.pair, self.unit).ok()?;
        let cells = self.observables.get(observable).ok()?;
        Some(match self.limits.get(name) {
            Some([from, to]) => cells.iter().map(|cell| cell.clamp(*from, *to)).collect(),
            None => cells,
        })
    }
}

impl Columns for Read<'_> {
    /// Where a cell is blank the last known one stands, so that memory goes on.
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        let cells = self.cells(name)?;
        if !cells.iter().any(|cell| cell.is_nan()) {
            return Some(cells);
        }
        let mut last = cells.iter().copied().find(|cell| !cell.is_nan())?;
        let held = cells.iter().map(|cell| {
            last = if cell.is_nan() { last } else { *cell };
            last
        });
        Some(held.collect())
    }

    fn time(&self) -> Time<'_> {
        Time { t_s: &self.observables.recording.time_s, pass: &self.pass }
    }
}

#[cfg(test)]
mod tests {
    use super::{Expressed, Factor};
    use crate::Recording;
    use crate::error_model::Sensor;
    use crate::terms::Observables;

    #[test]
    fn a_column_is_limited_to_what_was_recorded() {
        let flows: Vec<f64> = (0..40).map(|row| f64::from(row % 20)).collect();
        let line = |(row, flow): (usize, &f64)| format!("{row},0,1,{row},{row}.5,{flow}\n");
        let rows: String = flows.iter().enumerate().map(line).collect();
        let text = format!("t_s,pass,direction,measured,reference,flow_l_min\n{rows}");
        let recording = Recording::from_bytes("r.csv", text.as_bytes()).unwrap();
        let sensor = Sensor::Direct { unit: "mm".into(), revolution: None };
        let observables = Observables { recording: &recording, sensor: &sensor };
        let factor = Factor { name: "k".into(), unit: "mm/(l/min)".into() };
        let plain = Expressed::of("k * flow_l_min".into(), "mm", false, vec![factor], Vec::new());
        assert_eq!(plain.columns(&observables).unwrap(), std::slice::from_ref(&flows));
        let limits = [("flow_l_min".to_string(), [3.0, 11.0])].into();
        let limited = Expressed { limits, ..plain.clone() }.columns(&observables).unwrap();
        assert_eq!(limited[0], flows.iter().map(|flow| flow.clamp(3.0, 11.0)).collect::<Vec<f64>>());
        let wrong = Expressed { limits: [("flow_l_min".to_string(), [3.0, 1.0])].into(), ..plain };
        assert!(wrong.contradiction().unwrap().contains("3 and 1"));
    }
}
