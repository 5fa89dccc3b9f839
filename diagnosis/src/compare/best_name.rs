//! The catalogued effect that explains best what came, went, or has no name. A recording by itself judges its effects beside
//! a base of its own, which takes up a part of them; beside the base that both recordings have in common another effect may do
//! better, or an effect may do where the base seemed to differ.

use numerics::{Basis, parallel};

use crate::calibrate::log_tail;
use crate::effects::Effect;
use crate::intervals::widening;
use crate::thresholds::compare::{ALTERNATIVE, CANDIDATES, MOST_CHANGES};

use super::choose::{Chosen, choose};
use super::design::{Design, What, White, explained_by};
use super::joined::Joined;
use super::shared::Shared;

/// An effect in the place of something that differs.
struct InPlace<'a> {
    /// The model with it.
    design: Design<'a>,
    /// −ln of the p-value of what it explains, its columns and fitted shapes counted and its search paid for.
    surprise: f64,
}

/// The model in which everything that came, went or has no name has the catalogued effect that explains it best, and the parts
/// of it that differ; what has another name now is said.
pub fn best_names<'a>(
    mut design: Design<'a>,
    white: &White,
    freedom: f64,
    catalogue: &[Effect],
    notes: &mut Vec<String>,
) -> (Design<'a>, Vec<Chosen>) {
    let mut chosen = choose(&design, white, freedom);
    for _ in 0..MOST_CHANGES {
        let better = |k: usize| Some((k, renamed(&design, white, freedom, catalogue, &chosen, k)?));
        let Some((k, renamed)) = (0..chosen.len()).find_map(better) else { break };
        let of = What::Amplitude(renamed.shared.len() - 1);
        let (old, new) = (design.id(chosen[k].what), renamed.id(of));
        notes.push(format!("{new}: beside the base of both recordings it explains more than {old}"));
        design = renamed;
        chosen = choose(&design, white, freedom);
    }
    (design, chosen)
}

/// The model with a better name for difference number `k`; none where there is none.
fn renamed<'a>(
    design: &Design<'a>,
    white: &White,
    freedom: f64,
    catalogue: &[Effect],
    chosen: &[Chosen],
    k: usize,
) -> Option<Design<'a>> {
    let what = chosen[k].what;
    let known = what.effect().map(|k| &design.shared[k]);
    // What moved has the name that both recordings gave it.
    if known.is_some_and(|shared| shared.found.iter().all(Option::is_some)) {
        return None;
    }
    let others: Vec<What> = chosen.iter().map(|c| c.what).filter(|c| c.effect() != what.effect()).collect();
    let (without, others) = design.without(what, &others);
    let gap = Gap::new(&without, white, freedom, &others);
    let margin = match known.and_then(|shared| shared.effect.as_ref()) {
        Some(effect) if !effect.is_form() => ALTERNATIVE,
        Some(_) => -ALTERNATIVE,
        None => 0.0,
    };
    let all: Vec<What> = chosen.iter().map(|c| c.what).collect();
    let wanted = gap.surprise(design, &all) + margin;
    let is_new = |effect: &&Effect| design.shared.iter().all(|known| known.id() != Some(&effect.id));
    let best = gap.filled(catalogue, is_new, chosen[k].p_value)?;
    (best.surprise > wanted).then_some(best.design)
}

/// A model of both recordings in which something is missing, for which an effect is sought.
struct Gap<'a, 'b> {
    without: &'b Design<'a>,
    white: &'b White,
    /// What else differs.
    others: &'b [What],
    /// What the model leaves, and of how many columns it is.
    left: f64,
    columns: usize,
    /// By how much the noise is larger than it seems.
    wide: f64,
}

impl<'a, 'b> Gap<'a, 'b> {
    fn new(without: &'b Design<'a>, white: &'b White, freedom: f64, others: &'b [What]) -> Self {
        let solution = without.fit(white, &without.parts_of(others)).solution;
        let (left, columns) = (solution.rss, solution.coefficients.len());
        Gap { without, white, others, left, columns, wide: widening(freedom).powi(2) }
    }

    /// −ln of the p-value of what a model explains beyond this one, where these differ.
    fn surprise(&self, with: &Design, differ: &[What]) -> f64 {
        let solution = with.fit(self.white, &with.parts_of(differ)).solution;
        let columns = solution.coefficients.len() - self.columns;
        log_tail((self.left - solution.rss) / self.wide, columns)
    }

    /// The effect that explains most as a difference; `p_value` is that of what it replaces.
    fn filled(
        &self,
        catalogue: &[Effect],
        wanted: impl Fn(&&Effect) -> bool,
        p_value: f64,
    ) -> Option<InPlace<'a>> {
        let both = self.without.both;
        let can_be = |effect: &&Effect| {
            let lasts = !effect.of_one_time && !effect.is_form() && !effect.begins_at_a_row;
            lasts && wanted(effect) && effect.testable(&both.rows).is_ok()
        };
        let catalogue: Vec<&Effect> = catalogue.iter().filter(can_be).collect();
        let beside = self.without.beside(self.white, &self.without.parts_of(self.others));
        let start = |effect: &&Effect| best_start(effect, both, self.white, &beside, p_value);
        let mut starts: Vec<(f64, Shared)> = parallel::filter_map(&catalogue, start);
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        let settled = starts.into_iter().take(CANDIDATES).filter_map(|(_, shared)| {
            let searched = shared.effect.as_ref()?.starts(&both.rows).len().max(1) as f64;
            let differ = [self.others, &[What::Amplitude(self.without.shared.len())]].concat();
            let design = self.without.with(shared, self.white, self.others)?;
            let surprise = self.surprise(&design, &differ) - searched.ln();
            Some(InPlace { design, surprise })
        });
        settled.max_by(|a, b| a.surprise.total_cmp(&b.surprise))
    }
}

/// The shape in one of the recordings with which an effect explains most, and −ln of its p-value.
fn best_start(
    effect: &Effect,
    both: &Joined,
    white: &White,
    (basis, left): &(Basis, Vec<f64>),
    p_value: f64,
) -> Option<(f64, Shared)> {
    let over = [effect.over(&both.rows), effect.over(&both.swapped)];
    let shapes = effect.starts(&both.rows).into_iter().filter(|shape| over[0].possible_shape(shape));
    let all = shapes.flat_map(|shape| {
        let columns = both.each_first(over[0].signature(&shape), over[1].signature(&shape));
        [0, 1].map(|recording| {
            let mut basis = basis.clone();
            let own = columns.iter().map(|column| white.of(&both.only(recording, column)));
            let (explained, rank) = explained_by(&mut basis, own, left);
            (log_tail(explained, rank), shape.clone())
        })
    });
    let (surprise, shape) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((surprise, Shared::together(effect, shape, p_value)))
}
