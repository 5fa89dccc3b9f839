//! What is said of each effect of a model, and which of them does the rows that score no good.

use numerics::parallel;

use super::{Augmented, Search, gain, last_id};
use crate::dynamic::data::{ALL, Data, FIT_ROWS, SCORE, SCORE_ROWS, UNSCORED};
use crate::dynamic::estimate::{Fitted, fit};
use crate::dynamic::verdict::shared;
use crate::thresholds::dynamic::diagnose::MOVED;
use crate::verdict::NamedEffect;

impl<M: Augmented> Search<'_, M> {
    /// The effects of a model, `small` on the windows of the search and `found` on the whole recording: `said` is given
    /// the number of a term, what it gains in −2 log likelihood and the effects that are at most `margin` behind in its
    /// place. Without a term that keeps the plant from running away nothing of the motion is explained.
    pub fn named(
        &self,
        data: &Data,
        [small, found]: [&Fitted<M>; 2],
        margin: f64,
        said: impl Fn(usize, f64, Vec<String>) -> NamedEffect + Sync,
    ) -> Vec<NamedEffect> {
        let one = |k: usize| {
            let without = found.model.without(k).and_then(|model| fit(&model, &found.states, data, ALL));
            let cost = without.map_or_else(|| found.cost(ALL) / found.part_left(data), |f| f.cost(ALL));
            let rows: usize = found.rows.iter().sum();
            let gain = rows as f64 * (cost / found.cost(ALL).max(f64::MIN_POSITIVE)).ln();
            (cost - found.cost(ALL), said(k, gain, self.alternatives(small, k, margin)))
        };
        shared(parallel::indices(self.given..found.model.terms().len(), one))
    }

    /// Effects that do as well in the place of term `k`: at most `margin` behind in −2 log likelihood, the nearest first.
    fn alternatives(&self, found: &Fitted<M>, k: usize, margin: f64) -> Vec<String> {
        let effect = M::effect(&found.model.terms()[k]);
        let rivals = self.catalogue.iter().filter(|e| M::confused(effect, e) && !found.model.has(M::id(e)));
        let rivals = Search { data: self.data, catalogue: rivals.cloned().collect(), given: self.given };
        let refit = |model: &M| self.fit(model, &found.states);
        let without = found.model.without(k).and_then(|model| refit(&model));
        let Some((with, without)) = refit(&found.model).zip(without) else { return Vec::new() };
        let mut near: Vec<(f64, String)> = rivals
            .in_place_of(found, k, &without)
            .iter()
            .map(|f| (gain(f, &with, FIT_ROWS), last_id(f).to_string()))
            .filter(|(behind, _)| *behind < margin)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.into_iter().map(|(_, id)| id).collect()
    }

    /// The effect without which the rows that score are predicted as well, of those whose part they show.
    pub fn idle(&self, with: &Fitted<M>, data: &Data) -> Option<String> {
        let predicted = with.positions(data).ok()?;
        let gained = |k: usize| {
            let without = fit(&with.model.without(k)?, &with.states, data, UNSCORED)?;
            let other = without.positions(data).ok()?;
            let rows = data.runs.iter().flat_map(|r| r.clone()).filter(|k| data.fold[*k] as usize == SCORE);
            let moved: f64 = rows.map(|k| (predicted[k] - other[k]).powi(2)).sum();
            let shown = moved > MOVED * with.rms(SCORE_ROWS).powi(2);
            shown.then(|| (k, gain(&without, with, SCORE_ROWS)))
        };
        let gains = parallel::indices(self.given..with.model.terms().len(), gained);
        let worst = gains.into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1));
        let (k, _) = worst.filter(|(_, gain)| *gain <= 0.0)?;
        Some(M::id(M::effect(&with.model.terms()[k])).to_string())
    }
}
