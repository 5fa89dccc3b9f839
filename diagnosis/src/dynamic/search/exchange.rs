//! Exchanging what was found: an effect for one that it is easily taken for, and terms that others have driven to where
//! they are no physics.

use super::{Augmented, LEAST_GAIN, MOST_EXCHANGES, Search, gain};
use crate::dynamic::data::{CHOOSE, CHOOSE_ROWS, FIT_ROWS};
use crate::dynamic::estimate::Fitted;
use crate::dynamic::model::{Model, Term};
use crate::thresholds::dynamic::search::exchange::{CLOSE, STRONG};

impl Search<'_> {
    /// The model without terms that all rows together drive to where they are no physics, and with an effect in the
    /// place of another where that does better then.
    pub fn settled(&self, chosen: Fitted) -> Fitted {
        let mut chosen = chosen;
        for _ in 0..MOST_EXCHANGES {
            let all = self.complete(&chosen);
            let Some(k) =
                (self.given..all.model.terms.len()).find(|k| !Model::sound(&all.model.terms[*k], self.data))
            else {
                break;
            };
            let Some(shorter) = self.fit(&chosen.model.without(k), &chosen.states) else { break };
            let shorter = self.best_hold(shorter, FIT_ROWS);
            let others = self.near(&shorter, |t, _| t.effect.is_late());
            chosen = others
                .into_iter()
                .map(|f| self.best_hold(f, FIT_ROWS))
                .fold(shorter, |best, f| if f.costs[CHOOSE] < best.costs[CHOOSE] { f } else { best });
        }
        chosen
    }

    /// A better model with a delay or lag in the place of another, or without a term that others have driven to
    /// where it is no physics (a delay before its cause): to first order the three are one, which was taken was
    /// decided beside less, and a later term may be there only to mend it.
    pub(super) fn exchanged(&self, present: &Fitted) -> Option<Fitted> {
        let terms = &present.model.terms[self.given..];
        let unsound: Vec<usize> = (0..terms.len()).filter(|k| !Model::sound(&terms[*k], self.data)).collect();
        let lags = terms.iter().any(|t| t.effect.is_late());
        if unsound.is_empty() && (terms.len() < 2 || !lags) {
            return None;
        }
        let mut others: Vec<Fitted> = self
            .near(present, |t, _| t.effect.is_late())
            .into_iter()
            .map(|f| self.pruned(self.best_hold(f, FIT_ROWS)))
            .collect();
        others.extend(unsound.iter().filter_map(|k| {
            let shorter = self.fit(&present.model.without(self.given + k), &present.states)?;
            Some(self.best_hold(shorter, FIT_ROWS))
        }));
        let better = |f: &Fitted| {
            let fewer = present.model.free() as f64 - f.model.free() as f64;
            let lost = gain(f, present, CHOOSE_ROWS);
            let close = f.costs[CHOOSE] < CLOSE * present.costs[CHOOSE];
            let simpler = fewer > 0.0 && lost < 2.0 + 4.0 * fewer;
            let nearer = fewer >= 0.0 && lost < -LEAST_GAIN && gain(f, present, FIT_ROWS) < -LEAST_GAIN;
            f.model.terms[self.given..].iter().all(|t| Model::sound(t, self.data))
                && (simpler || nearer || (!unsound.is_empty() && close))
        };
        others.retain(better);
        others.into_iter().min_by(|a, b| {
            let merit = |f: &Fitted| gain(f, present, CHOOSE_ROWS) + 4.0 * f.model.free() as f64;
            merit(a).total_cmp(&merit(b))
        })
    }

    /// Models in which one weak term is replaced by an effect that it is easily taken for, and which do
    /// nearly as well on these windows: more rows have to decide.
    pub fn rivals(&self, chosen: &Fitted) -> Vec<Model> {
        self.near(chosen, |_, growth| growth <= STRONG).into_iter().map(|f| f.model).collect()
    }

    /// Models in which one term is replaced, fitted: one for which `may` holds, given the factor by which the squared
    /// residual grows without it.
    fn near(&self, chosen: &Fitted, may: impl Fn(&Term, f64) -> bool) -> Vec<Fitted> {
        let mut near = Vec::new();
        for k in self.given..chosen.model.terms.len() {
            let Some(without) = self.fit(&chosen.model.without(k), &chosen.states) else { continue };
            if !may(&chosen.model.terms[k], without.costs[CHOOSE] / chosen.costs[CHOOSE]) {
                continue;
            }
            let ids = chosen.model.terms[k].effect.confused_with;
            let catalogue = self.catalogue.iter().copied().filter(|e| ids.contains(&e.id)).collect();
            let contenders = Search { data: self.data, catalogue, given: self.given }
                .contenders(std::slice::from_ref(&without));
            near.extend(contenders.into_iter().filter(|f| f.costs[CHOOSE] < CLOSE * chosen.costs[CHOOSE]));
        }
        near
    }
}
