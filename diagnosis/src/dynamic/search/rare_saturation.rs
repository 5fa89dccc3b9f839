//! What acts on hardly any row that fits: a limit that the drive reaches once or twice.

use numerics::parallel;

use super::{Augmented, LEAST_GAIN, LEAST_PART, RARE_GAIN, Search, compared};
use crate::dynamic::data::{CHOOSE_ROWS, FIT_ROWS, UNSCORED};
use crate::dynamic::estimate::{Fitted, fit, fit_in};
use crate::dynamic::model::{Model, Term};
use crate::thresholds::dynamic::model::MOST_TERMS;
use crate::thresholds::dynamic::search::contenders::SHORT;

impl Search<'_> {
    /// The model with a limit of the drive, where the rows that fit and those that choose show it only together: it
    /// must gain on them all what an effect that acts rarely has to gain where it was fitted, and on either kind what
    /// its own simulation says.
    pub fn with_rare_saturation(&self, present: Fitted) -> Fitted {
        if present.model.terms.len() >= MOST_TERMS {
            return present;
        }
        let limits = self.catalogue.iter().filter(|e| e.is_limit() && !present.model.has(e.id));
        let models: Vec<Model> = limits
            .flat_map(|e| (e.starts)(&self.data.scale).into_iter().map(|start| (*e, start)))
            .map(|(effect, start)| present.model.with(Term::new(effect, start)))
            .collect();
        if models.is_empty() {
            return present;
        }
        let Some(base) = fit(&present.model, &present.states, self.data, UNSCORED) else {
            return present;
        };
        let short = |model: &Model| fit_in(SHORT, model, &base.states, self.data, UNSCORED);
        let best = parallel::filter_map(&models, short)
            .into_iter()
            .min_by(|a, b| a.cost(UNSCORED).total_cmp(&b.cost(UNSCORED)))
            .filter(|f| f.cost(UNSCORED) < base.cost(UNSCORED))
            .and_then(|f| fit(&f.model, &f.states, self.data, UNSCORED))
            .filter(|f| f.model.terms.iter().all(|term| Model::sound(term, self.data)));
        match best {
            Some(f) if self.worth_on_both(&base, &f) => f,
            _ => present,
        }
    }

    fn worth_on_both(&self, before: &Fitted, after: &Fitted) -> bool {
        let least = (RARE_GAIN * LEAST_GAIN).max(LEAST_PART * self.data.count(UNSCORED) as f64);
        compared(self.data, before, after).is_some_and(|all| {
            all.iter().all(|gains| {
                gains.of(UNSCORED) > least && gains.as_due(FIT_ROWS) && gains.as_due(CHOOSE_ROWS)
            })
        })
    }
}
