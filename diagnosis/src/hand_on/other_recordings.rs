//! What other recordings of the device get of an effect, and what stays with the recording that it was found on.

use fitter::Coefficients;
use fitter::terms::{Expressed, Operator, Scope, Term};

use super::HandOn;
use crate::base::base_columns;
use crate::effects::{Effect, Read};
use crate::model::{FittedTerm, Model};
use crate::thresholds::hand_on::{MUCH_NEARER, SEEN};

impl HandOn<'_> {
    /// Parts every effect that is not the same on other recordings into terms: what they get, with the effect's own scope, and
    /// what holds here alone, with that of the recording. On this recording the sum is what was fitted.
    pub(super) fn share_out(&self, file: &mut Coefficients, model: &Model) {
        let named: Vec<(&FittedTerm, &Effect)> =
            model.terms.iter().filter_map(|term| Some((term, &self.catalogue[term.effect?]))).collect();
        let harmonics_of_turn = file.terms.len() - named.len();
        // Of every coefficient of the new file: which one of the old it is a part of, and what part.
        let mut parts: Vec<(usize, f64)> = (0..file.base.coefficients.len()).map(|k| (k, 1.0)).collect();
        let mut first = parts.len();
        let mut terms = Vec::with_capacity(file.terms.len());
        for (k, term) in std::mem::take(&mut file.terms).into_iter().enumerate() {
            let own = first..first + term.coefficients.len();
            first = own.end;
            let named = k.checked_sub(harmonics_of_turn).map(|k| named[k]);
            let reach = named.map_or(1.0, |(fitted, _)| fitted.reach);
            let form = named.filter(|(_, effect)| effect.is_form() || effect.own_columns().is_some());
            let others = form.and_then(|(fitted, effect)| {
                let Operator::Expression(here) = &term.operator else { return None };
                self.for_others(here, &term.coefficients, effect, fitted, model).map(Operator::Expression)
            });
            let shares = match &others {
                None => {
                    vec![(term.scope, &term.operator, reach), (Scope::Recording, &term.operator, 1.0 - reach)]
                }
                Some(others) => vec![
                    (term.scope, others, reach),
                    (Scope::Recording, &term.operator, 1.0),
                    (Scope::Recording, others, -reach),
                ],
            };
            for (scope, operator, part) in shares.into_iter().filter(|(.., part)| *part != 0.0) {
                let scaled = |by: f64, values: &[f64]| values.iter().map(|v| by * v).collect::<Vec<f64>>();
                // Other recordings lack the last coefficients, of what only this one lacks.
                let count = operator.width();
                parts.extend(own.clone().take(count).map(|k| (k, part)));
                let covariance = term.covariance.iter().take(count);
                terms.push(Term {
                    scope,
                    operator: operator.clone(),
                    coefficients: scaled(part, &term.coefficients[..count]),
                    covariance: covariance.map(|row| scaled(part * part, &row[..count])).collect(),
                    ..term.clone()
                });
            }
        }
        file.terms = terms;
        if !file.joint_covariance.is_empty() {
            let old = std::mem::take(&mut file.joint_covariance);
            let row = |(i, p): &(usize, f64)| parts.iter().map(|(k, q)| p * q * old[*i][*k]).collect();
            file.joint_covariance = parts.iter().map(row).collect();
        }
    }

    /// What a form would add to this recording as other recordings get it; none of one of which nothing is missing here.
    pub fn of_others(&self, fitted: &FittedTerm, model: &Model) -> Option<Vec<f64>> {
        let effect = &self.catalogue[fitted.effect?];
        let own = effect.own_columns()?;
        let Operator::Expression(here) = effect.operator(self.rows, &fitted.term.shape).operator else {
            return None;
        };
        let others = self.for_others(&here, &fitted.amplitudes, effect, fitted, model)?;
        self.values(&others, &fitted.amplitudes[..own])
    }

    /// The expression of a form as other recordings get it, where that differs: what is missing here is not known there, and a
    /// lag may begin in another state. This recording decides where it knows, else what the lag's state was mostly near.
    fn for_others(
        &self,
        here: &Expressed,
        coefficients: &[f64],
        effect: &Effect,
        fitted: &FittedTerm,
        model: &Model,
    ) -> Option<Expressed> {
        let given = effect.without_missing(here);
        let of_text = |text: String| Expressed { text, ..given.clone() };
        let settled = of_text(given.sentence(self.rows.pair).ok()?.where_lags_state_nothing());
        let own = &coefficients[..settled.factors.len()];
        let values = [own, &here.parameters.iter().map(|fixed| fixed.value).collect::<Vec<f64>>()].concat();
        let sentence = settled.sentence(self.rows.pair).ok()?;
        let usual = of_text(sentence.with_first_states(&Read(self.full), &values, MUCH_NEARER).ok()?);
        let cold = if given.text == settled.text { of_text(sentence.from_nothing()) } else { given.clone() };
        let others = if cold.text == settled.text {
            settled
        } else {
            let likely = self.likelihood(fitted, model);
            let likely = |other: &Expressed| Some(likely(&self.values(other, own)?));
            let of_usual = likely(&usual)?;
            let (of_settled, of_cold) = (likely(&settled)?, likely(&cold)?);
            match (of_settled.max(of_cold) >= of_usual + SEEN, of_settled >= of_cold) {
                (false, _) => usual,
                (true, true) => settled,
                (true, false) => cold,
            }
        };
        (others.text != here.text).then_some(others)
    }

    /// The values of an expression over the rows that were searched.
    fn values(&self, expressed: &Expressed, coefficients: &[f64]) -> Option<Vec<f64>> {
        let fixed = expressed.parameters.iter().map(|fixed| fixed.value);
        let values: Vec<f64> = coefficients.iter().copied().chain(fixed).collect();
        expressed.sentence(self.rows.pair).ok()?.values(&Read(self.rows), &values).ok()
    }

    /// How likely values of a term make this recording, noise being whatever suits best, in −2 log likelihood less that without it.
    fn likelihood(&self, fitted: &FittedTerm, model: &Model) -> impl Fn(&[f64]) -> f64 + use<'_> {
        let base = base_columns(self.rows, model.order);
        let without: Vec<f64> = (self.rows.error.iter().zip(model.value()).zip(&fitted.contribution))
            .zip(&model.base_value)
            .map(|(((error, value), own), base)| error - value + own + base)
            .collect();
        move |values| self.outset.gain(&without, &base, values)
    }
}
