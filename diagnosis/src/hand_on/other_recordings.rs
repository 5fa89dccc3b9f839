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
            let form = named.filter(|(_, effect)| effect.is_form());
            let others = form.and_then(|(fitted, _)| self.for_others(&term, fitted, model));
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
                parts.extend(own.clone().map(|k| (k, part)));
                terms.push(Term {
                    scope,
                    operator: operator.clone(),
                    coefficients: scaled(part, &term.coefficients),
                    covariance: term.covariance.iter().map(|row| scaled(part * part, row)).collect(),
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

    /// The expression of a form as other recordings get it, where that differs: a lag may begin in another state. This recording
    /// decides where it knows, else what the lag's state was mostly near.
    fn for_others(&self, term: &Term, fitted: &FittedTerm, model: &Model) -> Option<Operator> {
        let Operator::Expression(here) = &term.operator else { return None };
        let parameters = here.parameters.iter().map(|fixed| fixed.value);
        let values: Vec<f64> = term.coefficients.iter().copied().chain(parameters).collect();
        let sentence = here.sentence(self.rows.pair).ok()?;
        let at_mean = |nearer: f64| sentence.with_first_states(&Read(self.full), &values, nearer).ok();
        let of_text = |text: String| Expressed { text, ..here.clone() };
        let always = of_text(at_mean(0.0)?);
        if always.text == here.text {
            return None;
        }
        let read = |expressed: &Expressed| {
            expressed.sentence(self.rows.pair).ok()?.values(&Read(self.rows), &values).ok()
        };
        let worse = self.worse_by(&read(here)?, &read(&always)?, fitted, model);
        let others = match worse {
            _ if worse >= SEEN => return None,
            _ if worse <= -SEEN => always,
            _ => of_text(at_mean(MUCH_NEARER)?),
        };
        (others.text != here.text).then_some(Operator::Expression(others))
    }

    /// By how much less likely a term makes this recording if its values are `instead`, noise being whatever suits either best, in
    /// −2 log likelihood.
    fn worse_by(&self, values: &[f64], instead: &[f64], fitted: &FittedTerm, model: &Model) -> f64 {
        let base = base_columns(self.rows, model.order);
        let without: Vec<f64> = (self.rows.error.iter().zip(model.value()).zip(&fitted.contribution))
            .zip(&model.base_value)
            .map(|(((error, value), own), base)| error - value + own + base)
            .collect();
        let gain = |values: &[f64]| self.outset.gain(&without, &base, values);
        gain(values) - gain(instead)
    }
}
