//! An effect: expressions that a file declares, linear in their factors, whose other parameters are searched.
//!
//! Its shape is the values of the parameters that are searched, then, of several forms, the number of the form. Its
//! amplitudes are those of the factors, for every expression that is added up.

use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

use fitter::terms::{Expressed, ExpressionFactor, Fixed, Operator, Play};
use fitter::turn::Turn;
use physics::{Columns, Declared, DeclaredParameter, Formula, Interval, Role, What};

use super::needs::Need;
use super::read::{Figures, Read};
use super::report::Function;
use super::term::Terms;
use super::{Facts, Handed, Origin, Reading};
use crate::rows::Rows;
use crate::thresholds::effects::effect::{MOVED, RELUCTANCE, STEEPEST};

/// See the module.
#[derive(Clone)]
pub struct Effect {
    pub(super) made: Arc<Made>,
}

/// What an effect is made of.
pub(super) struct Made {
    pub facts: Facts,
    pub declared: Declared,
    pub needs: Vec<Need>,
    /// The functions among what is reported, by name.
    pub functions: BTreeMap<String, Function>,
    /// Whether `fit` found it already in a sensor that turns.
    pub found_by_fit: fn(&Turn) -> bool,
    pub pair: bool,
    /// Of each number of its shape the parameter, and of each factor.
    pub shaped: Vec<usize>,
    pub factors: Vec<usize>,
}

/// An effect is known by its facts.
impl Deref for Effect {
    type Target = Facts;

    fn deref(&self) -> &Facts {
        &self.made.facts
    }
}

impl Effect {
    pub(super) fn parameter(&self, index: usize) -> &DeclaredParameter {
        &self.made.declared.parameters[index]
    }

    /// Name and unit of each factor, as they are reported.
    pub fn factors(&self) -> impl Iterator<Item = (&str, &str)> {
        let own = self.made.factors.iter().map(|index| self.parameter(*index));
        own.map(|parameter| (parameter.reported.as_str(), parameter.unit_text.as_str()))
    }

    /// Name of a number of the shape that is a parameter, as it is reported.
    pub fn shape_name(&self, k: usize) -> &str {
        &self.parameter(self.made.shaped[k]).reported
    }

    /// The number of the form that a shape has.
    pub(super) fn form_of(&self, shape: &[f64]) -> usize {
        let forms = self.made.declared.adds.len();
        if forms > 1 { (shape[self.made.shaped.len()] as usize).min(forms - 1) } else { 0 }
    }

    pub(super) fn form(&self, shape: &[f64]) -> &Formula {
        &self.made.declared.adds[self.form_of(shape)]
    }

    /// How many expressions are added up.
    pub(super) fn count(&self, shape: &[f64]) -> usize {
        let sum = |index: &usize| matches!(self.parameter(*index).role, Role::Sum(_));
        self.made.shaped.iter().position(sum).map_or(1, |k| shape[k] as usize)
    }

    /// The values of all parameters at a shape, the factors being these.
    pub(super) fn values(&self, rows: &Rows, shape: &[f64], factors: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.made.declared.parameters.len()];
        for (index, value) in self.made.shaped.iter().zip(shape) {
            values[*index] = match self.parameter(*index).role {
                Role::Row => rows.t_s[row_of(rows, *value)],
                _ => *value,
            };
        }
        self.made.factors.iter().zip(factors).for_each(|(index, value)| values[*index] = *value);
        values
    }

    /// The value of an expression beside what it adds; NaN where it has none.
    pub(super) fn figure(figures: &Figures, formula: &Formula, values: &[f64]) -> f64 {
        formula.values(figures, values).map_or(f64::NAN, |value| value[0])
    }

    /// Whether it is a form without a name.
    pub fn is_form(&self) -> bool {
        matches!(self.origin, Origin::Form(_))
    }

    /// Whether nothing of it but amplitudes is fitted.
    pub fn is_linear(&self) -> bool {
        self.made.shaped.is_empty() && self.made.declared.adds.len() == 1
    }

    /// The columns that its first form reads and that a recording need not have.
    pub fn further_columns(&self) -> Vec<&str> {
        let columns = self.made.declared.adds[0].sentence.columns.iter();
        columns.map(String::as_str).filter(|name| Read::need_not_be(name).is_some()).collect()
    }

    /// The column of which what it adds at a shape is a function; none where it is of several, or depends on the rows before.
    pub fn argument(&self, shape: &[f64]) -> Option<&str> {
        let sentence = &self.form(shape).sentence;
        match &sentence.columns[..] {
            [column] if !sentence.remembers() => Some(column),
            _ => None,
        }
    }

    /// How a form without a name would be declared as an effect.
    pub fn declaration(&self) -> Option<String> {
        match &self.origin {
            Origin::Form(declaration) => Some(declaration.clone()),
            Origin::Catalogue | Origin::User => None,
        }
    }

    /// Whether `fit` found it already in a sensor that turns.
    pub fn found_by_fit(&self, turn: &Turn) -> bool {
        (self.made.found_by_fit)(turn)
    }

    /// Why this recording cannot show it.
    ///
    /// # Errors
    /// A sentence naming what is missing.
    pub fn testable(&self, rows: &Rows) -> Result<(), String> {
        let read = Read(rows);
        for name in self.made.declared.adds.iter().flat_map(|form| &form.sentence.columns) {
            let Some(known) = Read::need_not_be(name) else { continue };
            let values =
                read.column(name).ok_or_else(|| format!("the recording has no usable column {known}"))?;
            let (low, high) = numerics::range(&values);
            if high <= low {
                return Err(format!("the column {known} is constant"));
            }
        }
        self.made.needs.iter().try_for_each(|need| need.check(rows))?;
        if !self.may_be_unsettled(rows) {
            return Err("there is no pause in the recording".into());
        }
        let ranges = self.ranges(rows);
        if ranges.iter().any(|range| range.low.is_nan() || range.high.is_nan() || range.low > range.high) {
            return Err("its parameters have no range here".into());
        }
        let over = |name: &str| {
            let values = read.column(name).unwrap_or_default();
            Interval::around(values.iter().copied()).unwrap_or(Interval::point(0.0))
        };
        for form in &self.made.declared.adds {
            let mut sentence = form.sentence.clone();
            for (parameter, index) in sentence.parameters.iter_mut().zip(&form.of) {
                let searched = self.made.shaped.iter().position(|shaped| shaped == index);
                parameter.range = match (searched, &self.parameter(*index).role) {
                    (Some(k), Role::Searched(_)) => {
                        Some(Interval { from: ranges[k].low, to: ranges[k].high })
                    }
                    (Some(k), Role::Follows(..)) => Some(Interval { from: ranges[k].low, to: f64::INFINITY }),
                    _ => parameter.range,
                };
            }
            let checked = sentence.interval(&over);
            checked.map_err(|error| format!("its expression has no value here: {error}"))?;
        }
        Ok(())
    }

    /// The columns that the amplitudes multiply, in the recording's unit per unit amplitude.
    pub fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        self.columns(rows, shape, |values| self.form(shape).values(&Read(rows), values))
    }

    /// The same, given how what it adds is computed of the values of its parameters.
    pub(super) fn columns(
        &self,
        rows: &Rows,
        shape: &[f64],
        adds: impl Fn(&[f64]) -> Result<Vec<f64>, String>,
    ) -> Vec<Vec<f64>> {
        let mut columns = Vec::new();
        let mut factors = vec![0.0; self.made.factors.len()];
        for number in 1..=self.count(shape) {
            for factor in 0..factors.len() {
                factors.fill(0.0);
                factors[factor] = 1.0;
                let values = self.numbered(self.values(rows, shape, &factors), number);
                let mut column = adds(&values).unwrap_or_default();
                if column.len() != rows.len() {
                    column = vec![column.first().copied().unwrap_or(f64::NAN); rows.len()];
                }
                columns.push(column);
            }
        }
        columns.extend(self.missing(rows, shape));
        columns
    }

    /// The values with the number of an expression that is added up.
    pub(super) fn numbered(&self, mut values: Vec<f64>, number: usize) -> Vec<f64> {
        for (value, parameter) in values.iter_mut().zip(&self.made.declared.parameters) {
            if matches!(parameter.role, Role::Sum(_)) {
                *value = number as f64;
            }
        }
        values
    }

    /// Whether it depends on what was before.
    pub fn remembers(&self) -> bool {
        self.made.declared.adds.iter().any(|added| added.sentence.remembers())
    }

    /// Whether a shape says how things stood before the first row, which the first rows alone can tell.
    pub fn begins_before(&self, rows: &Rows, shape: &[f64]) -> bool {
        let before = |play: &Play| play.elements.iter().any(|element| element.initial.is_some());
        matches!(self.term(rows, shape), Some(Handed { operator: Operator::Play(play), .. }) if before(&play))
    }

    /// Indices of the rows at which the recording does not determine the signature; they take no part in fitting the
    /// amplitude. `noise` is the standard deviation of a reading in the unit of the rows.
    pub fn undetermined_rows(&self, rows: &Rows, noise: f64) -> Vec<usize> {
        // Read again where the motion turned, a device with a gap as wide as the effect is large may stand on either side of
        // it or between: a loop moves it there by as much as the reading is noisy.
        let turned = |i: &usize| rows.direction[*i] != rows.direction[*i - 1];
        let stayed = |i: &usize| (rows.theta[*i] - rows.theta[*i - 1]).abs() < MOVED * noise;
        (1..if self.shape_follows { rows.len() } else { 1 }).filter(|i| turned(i) && stayed(i)).collect()
    }

    /// Between which values each factor is plausible.
    fn plausible_factors(&self) -> impl Iterator<Item = Interval> + Clone + '_ {
        let limits = |index: &usize| match self.parameter(*index).role {
            Role::Factor(limits) => Some(limits),
            _ => None,
        };
        self.made.factors.iter().filter_map(limits)
    }

    /// Whether an amplitude of this sign can be this effect.
    pub fn plausible_sign(&self, amplitude: f64) -> bool {
        let of_sign = |limits: Interval| if amplitude > 0.0 { limits.to > 0.0 } else { limits.from < 0.0 };
        self.made.factors.len() > 1 || self.plausible_factors().all(of_sign)
    }

    /// Whether any amplitudes at all cannot be this effect.
    pub fn limits_amplitudes(&self) -> bool {
        let everything = |limits: Interval| limits.from == f64::NEG_INFINITY && limits.to == f64::INFINITY;
        self.of_true_angle() || !self.plausible_factors().all(everything)
    }

    /// Whether amplitudes at a shape can be this effect.
    pub fn plausible_at(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> bool {
        let mut limits = self.plausible_factors().cycle().zip(amplitudes);
        limits.all(|(limits, amplitude)| limits.from < *amplitude && *amplitude < limits.to)
            && self.steepest(rows, shape, amplitudes) < STEEPEST
    }

    /// The steepest slope of what it adds by the true angle; 0 where it does not depend on it.
    fn steepest(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> f64 {
        if !self.of_true_angle() {
            return 0.0;
        }
        match self.term(rows, shape) {
            Some(Handed { operator: Operator::Periodic(periodic), map }) => {
                let coefficient = |row: &Vec<f64>| row.iter().zip(amplitudes).map(|(m, a)| m * a).sum();
                periodic.steepest(&map.iter().map(coefficient).collect::<Vec<f64>>())
            }
            _ => 0.0,
        }
    }

    pub(super) fn of_true_angle(&self) -> bool {
        self.made
            .declared
            .adds
            .iter()
            .any(|form| form.sentence.columns.iter().any(|name| name == "true_angle"))
    }

    /// The period of the first harmonic, of an error that repeats with the true angle.
    pub(super) fn period(&self, rows: &Rows, shape: &[f64]) -> Option<f64> {
        match self.term(rows, shape)?.operator {
            Operator::Periodic(periodic) => Some(periodic.period),
            _ => None,
        }
    }

    /// A shape that follows from the amplitudes found (play whose gap is its own amplitude).
    pub fn consistent_shape(&self, shape: &[f64], amplitudes: &[f64], rows: &Rows) -> Vec<f64> {
        let values = self.values(rows, shape, amplitudes);
        let mut next = shape.to_vec();
        for (k, index) in self.made.shaped.iter().enumerate() {
            if let Role::Follows(from, follows) = &self.parameter(*index).role {
                let at = |formula| Effect::figure(&Figures::of(rows), formula, &values);
                next[k] = at(follows).max(at(from));
            }
        }
        next
    }

    /// What a shape must explain beyond others of the effect to be preferred: a correction can follow the readings, and has
    /// to be told the direction.
    pub fn reluctance(&self, shape: &[f64]) -> f64 {
        let reads_direction = |form: &Formula| form.sentence.columns.iter().any(|name| name == "direction");
        if reads_direction(self.form(shape)) && !reads_direction(&self.made.declared.adds[0]) {
            RELUCTANCE
        } else {
            0.0
        }
    }

    /// The title, with what the sign of the amplitudes says.
    pub fn found_as(&self, amplitudes: &[f64]) -> &str {
        match &self.made.declared.known.found_as {
            Some([above, below]) => {
                if amplitudes[0] > 0.0 {
                    above
                } else {
                    below
                }
            }
            None => &self.title,
        }
    }

    /// What it adds at a shape.
    pub fn formula_at(&self, shape: &[f64]) -> String {
        self.form(shape).sentence.expression.to_string()
    }

    /// As an operator that is no mere expression, where it is one.
    pub(super) fn term(&self, rows: &Rows, shape: &[f64]) -> Option<Handed> {
        if self.made.declared.known.unsettled.is_some() {
            return None;
        }
        Terms::of(self, self.form(shape), rows, shape).read()
    }

    /// The effect as a term of the coefficients file, with the factor by which the operator's coefficients
    /// differ from the amplitudes here, one per column.
    pub fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        if let Some(handed) = self.term(rows, shape) {
            return handed;
        }
        let form = self.form(shape);
        let factors = vec![1.0; self.made.factors.len()];
        let values = self.values(rows, shape, &factors);
        let text = form.sentence.settled(&Read(rows), &form.own(&values));
        let text = text.unwrap_or_else(|_| form.sentence.text.clone());
        let expressed = self.with_missing(self.expressed(form, text, &rows.unit, &values), rows);
        let width = expressed.factors.len();
        let map = (0..width).map(|row| (0..width).map(|k| f64::from(u8::from(row == k))).collect()).collect();
        Handed { operator: Operator::Expression(expressed), map }
    }

    /// A form of the effect as an expression of these values.
    fn expressed(&self, form: &Formula, text: String, unit: &str, values: &[f64]) -> Expressed {
        let name =
            |index: &usize| (self.parameter(*index).name.clone(), self.parameter(*index).unit.to_string());
        let is_factor = |index: &&usize| self.made.factors.contains(index);
        let factors = form.of.iter().filter(is_factor).map(|index| {
            let (name, unit) = name(index);
            ExpressionFactor { name, unit }
        });
        let fixed = form.of.iter().filter(|index| !is_factor(index)).map(|index| {
            let (name, unit) = name(index);
            Fixed { name, unit, value: values[*index] }
        });
        Expressed::of(text, unit, self.made.pair, factors.collect(), fixed.collect())
    }

    /// The effect as an expression without a recording, every parameter that is searched between numbers in the middle of
    /// its range, and any other 1.
    pub fn in_the_middle(&self) -> Expressed {
        let form = &self.made.declared.adds[0];
        let middle = |range: Interval| match range {
            Interval { from, to } if !(from.is_finite() && to.is_finite()) => 1.0,
            Interval { from, to } if from > 0.0 => (from * to).sqrt(),
            Interval { from, to } => 0.5 * (from + to),
        };
        let mut values = vec![1.0; self.made.declared.parameters.len()];
        for (parameter, index) in form.sentence.parameters.iter().zip(&form.of) {
            values[*index] = parameter.range.map_or(1.0, middle);
        }
        let sentence = &form.sentence;
        self.expressed(form, sentence.text.clone(), &sentence.unit.to_string(), &values)
    }

    /// The parameters as they are reported.
    pub fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let mut values = self.values(rows, shape, amplitudes);
        for (index, value) in self.made.shaped.iter().zip(shape) {
            if matches!(self.parameter(*index).role, Role::Row) {
                // What is there from a row on fell between it and the one before.
                let row = row_of(rows, *value);
                values[*index] = 0.5 * (rows.t_s[row - 1] + rows.t_s[row]);
            }
        }
        let (Declared { reported, .. }, figures) = (&self.made.declared, Figures::of(rows));
        if reported.is_empty() {
            let own = self.made.factors.iter().chain(&self.made.shaped);
            let reading = |index: &usize| {
                let DeclaredParameter { reported, unit_text, .. } = self.parameter(*index);
                Reading { name: reported.clone(), value: values[*index], unit: unit_text.clone() }
            };
            return own.map(reading).collect();
        }
        let value = |what: &What| match what {
            What::Formula(formula) => Effect::figure(&figures, formula, &values),
            What::Named(name) => self.made.functions[name](self, rows, shape, amplitudes),
        };
        let reading = reported.iter().map(|reported| Reading {
            name: reported.name.clone(),
            value: value(&reported.value),
            unit: reported.unit.clone(),
        });
        reading.collect()
    }
}

/// The row of a shape, which has one before it.
fn row_of(rows: &Rows, shape: f64) -> usize {
    (shape as usize).clamp(1, rows.len().max(2) - 1)
}
