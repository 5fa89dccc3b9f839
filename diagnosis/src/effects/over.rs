//! An effect over the rows of one recording, of which many shapes are asked: what does not depend on the shape is
//! evaluated once.

use std::ops::Deref;

use physics::{OverRows, Role};

use super::Effect;
use super::read::{Figures, Read};
use crate::rows::Rows;

/// See the module.
pub struct Over<'a> {
    effect: &'a Effect,
    rows: &'a Rows,
    forms: Vec<OverRows>,
    possible: Option<OverRows>,
}

impl Effect {
    /// The effect over some rows.
    pub fn over<'a>(&'a self, rows: &'a Rows) -> Over<'a> {
        let declared = &self.made.declared;
        let forms = declared.adds.iter().map(|form| form.sentence.over(&Read(rows))).collect();
        let possible = declared.possible.as_ref().map(|form| form.sentence.over(&Figures::of(rows)));
        Over { effect: self, rows, forms, possible }
    }
}

impl Deref for Over<'_> {
    type Target = Effect;

    fn deref(&self) -> &Effect {
        self.effect
    }
}

impl Over<'_> {
    /// The columns that the amplitudes multiply, in the recording's unit per unit amplitude.
    pub fn signature(&self, shape: &[f64]) -> Vec<Vec<f64>> {
        let (form, formula) = (&self.forms[self.form_of(shape)], self.form(shape));
        self.columns(self.rows, shape, |values| form.values(&Read(self.rows), &formula.own(values)))
    }

    /// Whether a shape within the ranges can be this effect.
    pub fn possible_shape(&self, shape: &[f64]) -> bool {
        let (Some(over), Some(formula)) = (&self.possible, &self.made.declared.possible) else { return true };
        let none = vec![0.0; self.made.factors.len()];
        let own = formula.own(&self.values(self.rows, shape, &none));
        over.values(&Figures::of(self.rows), &own).is_ok_and(|value| value[0] >= 0.0)
    }

    /// A richer form of the same effect to be tried once this one is found (a further harmonic).
    pub fn richer(&self, shape: &[f64]) -> Option<Vec<f64>> {
        let sum = |index: &usize| match self.parameter(*index).role {
            Role::Sum(most) => Some(most),
            _ => None,
        };
        let (k, most) = (0..).zip(&self.made.shaped).find_map(|(k, index)| Some((k, sum(index)?)))?;
        let mut richer = shape.to_vec();
        richer[k] += 1.0;
        (richer[k] <= f64::from(most) && self.possible_shape(&richer)).then_some(richer)
    }
}
