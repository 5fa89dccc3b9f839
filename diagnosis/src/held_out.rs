//! The proof on what was not fitted: passes are held out in turn, the search is repeated on the others, and what base
//! and augmented model, as they would be handed on, leave of the held-out rows is counted, reading by reading.

use std::sync::OnceLock;

use numerics::{least_squares, mean, parallel, range, rms, student_95};
use serde::Serialize;

use crate::base::base_columns;
use crate::explain::{Explanation, first_order, found_without, without_held};
use crate::generic::saturated;
use crate::hand_on::HandOn;
use crate::model::{FittedTerm, Model, choose_order, predictive};
use crate::rows::Rows;
use crate::search::Term;
use crate::thresholds::held_out::{
    BEYOND, BLOCKS, COVERED, FEW_OF_A_PASS, FOLDS, JUDGED, ROWS_OF_A_BLOCK, ROWS_OF_A_MOVE,
};

/// Root mean square of the residual on the rows that were fitted, and on those that were held out.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Score {
    /// On the rows that were fitted.
    pub train_rms: f64,
    /// On the held-out rows; none where nothing could be held out.
    pub held_out_rms: Option<f64>,
}

/// The proof.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Fit {
    /// Unit of the figures.
    pub unit: String,
    /// What was held out: `pass`, `block`, or the name of another recording.
    pub held_out_by: String,
    /// The base model alone.
    pub before: Score,
    /// With the named effects.
    pub after: Score,
    /// Mean over the held-out groups of rms before less rms after, with its 95 % interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<Gain>,
    /// How much of what a flexible smooth model can explain the named effects explain (1: all).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of_explainable: Option<f64>,
}

impl Fit {
    /// The figures alone.
    pub fn of(unit: &str, held_out_by: &str, [before, after]: [Score; 2]) -> Fit {
        Fit {
            unit: unit.into(),
            held_out_by: held_out_by.into(),
            before,
            after,
            gain: None,
            of_explainable: None,
        }
    }
}

/// The improvement on held-out groups.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Gain {
    /// Mean difference of the rms.
    pub value: f64,
    /// Its paired 95 % interval.
    pub ci95: [f64; 2],
}

/// The fold in which a group is held out. Of a single move the first and the last block are never held out:
/// there the base polynomial would be asked to extrapolate, which no model of the recording promises.
fn fold_of(group: usize, count: usize, folds: usize, by: &str) -> Option<usize> {
    if by != "block" {
        return Some(group * folds / count);
    }
    (group > 0 && group + 1 < count).then(|| (group - 1) % folds)
}

/// What is held out together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Groups {
    /// Whole passes, where enough of each direction are there.
    Passes,
    /// Blocks of rows: of what happened at one time in the recording only (a step, a warm-up) other passes say nothing.
    Blocks,
}

/// The group of every row: its pass, or where there is one pass, or one of a direction, a block of it.
pub(crate) fn groups(rows: &Rows, wanted: Groups) -> (Vec<usize>, usize, &'static str) {
    let passes = rows.passes();
    // The first row of a pass may still have the direction of the one before.
    let moves = |pass: &i64, sign: f64| {
        let of = || rows.pass.iter().zip(&rows.direction).filter(|(p, _)| *p == pass);
        of().filter(|(_, d)| **d * sign > 0.0).count() as f64 > FEW_OF_A_PASS * of().count() as f64
    };
    let passes_of = |sign: f64| passes.iter().filter(|pass| moves(pass, sign)).count();
    // Without its only pass of a direction a recording says nothing of what the direction does.
    let several = passes.len() >= 2 && passes_of(1.0) != 1 && passes_of(-1.0) != 1;
    if several && wanted == Groups::Passes {
        let of = |p: &i64| passes.iter().position(|q| q == p).unwrap_or(0);
        return (rows.pass.iter().map(of).collect(), passes.len(), "pass");
    }
    let blocks = match passes.len() {
        0 | 1 => (rows.len() / ROWS_OF_A_MOVE).clamp(1, BLOCKS),
        _ if several => (rows.len() / ROWS_OF_A_BLOCK).max(1),
        // A pass that no other one repeats.
        _ => (rows.len() / ROWS_OF_A_BLOCK).clamp(1, BLOCKS),
    };
    ((0..rows.len()).map(|i| i * blocks / rows.len()).collect(), blocks, "block")
}

/// The fold of every row that can be judged: near it other rows were taken that are not held out with it. No model promises
/// anything beyond.
fn judged(
    rows: &Rows,
    group: &[usize],
    out_of: &dyn Fn(usize) -> Option<usize>,
    folds: usize,
) -> Vec<Option<usize>> {
    let (low, high) = rows.stroke();
    let mut judged: Vec<Option<usize>> = group.iter().map(|g| out_of(*g)).collect();
    for fold in 0..folds {
        let held: Vec<usize> = (0..rows.len()).filter(|i| out_of(group[*i]) == Some(fold)).collect();
        let others = (0..rows.len()).filter(|i| out_of(group[*i]) != Some(fold));
        let mut others: Vec<f64> = others.map(|i| rows.theta[i]).collect();
        others.sort_by(f64::total_cmp);
        let near = |theta: f64| {
            let at = others.partition_point(|o| *o < theta);
            let beside = others[at.saturating_sub(1)..].iter().take(2);
            beside.map(|o| (o - theta).abs()).fold(f64::INFINITY, f64::min) <= COVERED * (high - low)
        };
        held.into_iter().filter(|i| !near(rows.theta[*i])).for_each(|i| judged[i] = None);
    }
    judged
}

/// What the search of the other rows chose, with one fold held out.
pub struct Fold<'a> {
    /// Whether a cell is held out.
    held: Vec<bool>,
    /// The search without the held-out rows.
    inner: Explanation<'a>,
    /// What it finds, once that is asked for.
    found: OnceLock<Vec<Term>>,
    /// What the base alone, as handed on, leaves of every row.
    before: Vec<f64>,
}

/// The proof by groups that are held out in turn: made once, and asked about several models.
pub struct Proof<'a> {
    by: &'static str,
    /// Fold by which every row of the recording is judged; none of a row that no fold holds out, or near which no other was
    /// taken.
    fold_of_row: Vec<Option<usize>>,
    group_of_row: Vec<usize>,
    folds: Vec<Fold<'a>>,
    /// Further orders of the base that the search found. Beside a straight line a shape would follow the curve of the base.
    orders: Vec<Term>,
    before: f64,
}

/// Figures of a model on rows that were held out.
#[derive(Clone)]
pub struct Shown {
    /// Root mean square of what it leaves, per reading.
    pub rms: f64,
    /// Of the groups: rms before less rms after.
    pub gains: Vec<f64>,
    /// Whether the effects were chosen without the held-out rows, too, and not only fitted.
    pub chosen_without: bool,
}

/// Which terms a model has in each fold.
pub enum Choice<'a> {
    /// Those that the search finds without the held-out rows.
    Searched,
    /// These, whose shapes are found again without them.
    Of(&'a [Term]),
}

/// Holds out every group in turn; none where nothing can be held out.
pub fn prove<'a>(
    explanation: &Explanation<'a>,
    hand_on: &HandOn,
    before: &Model,
    wanted: Groups,
) -> Option<Proof<'a>> {
    let search = &explanation.search;
    let rows = search.rows;
    let (group, count, by) = groups(rows, wanted);
    let folds = count.min(FOLDS);
    let neighbours = |g: usize| fold_of(g, count, folds, by);
    // Where the passes went to different places, folds of every other pass.
    let apart = |g: usize| Some(g % folds);
    let judged = |out_of: &dyn Fn(usize) -> Option<usize>| match by {
        "block" => group.iter().map(|g| out_of(*g)).collect(),
        _ => judged(rows, &group, out_of, folds),
    };
    let (of_neighbours, of_apart) = (judged(&neighbours), judged(&apart));
    let number = |judged: &[Option<usize>]| judged.iter().flatten().count();
    let interleaved = by == "pass" && number(&of_apart) > number(&of_neighbours);
    let judged = if interleaved { of_apart } else { of_neighbours };
    let out_of = |g: usize| if interleaved { apart(g) } else { neighbours(g) };
    if by == "pass" && (number(&judged) as f64) < JUDGED * rows.len() as f64 {
        return prove(explanation, hand_on, before, Groups::Blocks);
    }
    let enough = rows.len() / count * (count - 1) >= 2 * (before.order + 2);
    if count < 2 || !enough || !(0..count).any(|g| out_of(g).is_some()) {
        return None;
    }
    let fold = |fold: usize| {
        let held: Vec<bool> = group.iter().map(|g| out_of(*g) == Some(fold)).collect();
        let inner = without_held(explanation, &held);
        let order = choose_order(&inner, &[]).max(1).min(before.order);
        let base = predictive(&inner, &[], rows.order.unwrap_or(order));
        Some(Fold { before: hand_on.left(&base, Some(&held))?, held, inner, found: OnceLock::new() })
    };
    let folds: Vec<Fold> = parallel::indices(0..folds, fold).into_iter().collect::<Option<_>>()?;
    let group_of_row: Vec<usize> = hand_on.cell_of.iter().map(|cell| group[*cell]).collect();
    let fold_of_row = hand_on.cell_of.iter().map(|cell| judged[*cell]).collect();
    let orders = explanation.orders().cloned().collect();
    let mut proof = Proof { by, fold_of_row, group_of_row, folds, orders, before: 0.0 };
    proof.before = proof.rms(|fold| &proof.folds[fold].before, |_| true);
    Some(proof)
}

impl Proof<'_> {
    /// What was held out: `pass` or `block`.
    pub fn by(&self) -> &'static str {
        self.by
    }

    /// Root mean square of what the base alone leaves of the held-out rows.
    pub fn before(&self) -> f64 {
        self.before
    }

    /// Whether in some fold a term has values far outside those that it has in the other rows: it would have to be foretold
    /// where nothing was recorded.
    pub fn asks_beyond(&self, term: &Term) -> bool {
        let of = |column: &[f64], held: &[bool], wanted: bool| {
            let of_rows = column.iter().zip(held).filter(|(_, h)| **h == wanted);
            range(&of_rows.map(|(v, _)| *v).collect::<Vec<f64>>())
        };
        let beyond = |column: &Vec<f64>, held: &[bool]| {
            let ((low, high), (lowest, highest)) = (of(column, held, false), of(column, held, true));
            (low - lowest).max(highest - high) > BEYOND * (high - low)
        };
        self.folds.iter().any(|fold| term.columns.iter().any(|column| beyond(column, &fold.held)))
    }

    /// Root mean square of the held-out rows of the groups for which `wanted` holds, each by what `left` says without it.
    fn rms<'l>(&self, left: impl Fn(usize) -> &'l [f64], wanted: impl Fn(usize) -> bool) -> f64 {
        let row = |i: usize| {
            let fold = self.fold_of_row[i].filter(|_| wanted(self.group_of_row[i]))?;
            Some(left(fold)[i])
        };
        rms(&(0..self.fold_of_row.len()).filter_map(row).collect::<Vec<f64>>())
    }

    /// What a model leaves of the held-out rows; none where in some fold it cannot be applied.
    pub fn shows(&self, hand_on: &HandOn, choice: &Choice, order: usize) -> Option<Shown> {
        let left = |fold: &Fold| {
            let inner = &fold.inner;
            let named = |t: &&Term| inner.search.effect(t.family).is_some();
            let terms: Vec<Term> = match choice {
                Choice::Searched => {
                    let found = fold.found.get_or_init(|| found_without(inner, &fold.held));
                    found.iter().filter(named).cloned().collect()
                }
                Choice::Of(terms) => {
                    let mut all = [&self.orders, *terms].concat();
                    inner.search.backfit(&mut all);
                    all.split_off(self.orders.len())
                }
            };
            if terms.is_empty() {
                return Some(fold.before.clone());
            }
            let rows = inner.search.rows;
            // Fewer rows never justify a higher order than all of them.
            let order = choose_order(inner, &terms).max(first_order(rows)).min(order);
            hand_on.left(&predictive(inner, &terms, order), Some(&fold.held))
        };
        let left: Vec<Vec<f64>> = parallel::map(&self.folds, left).into_iter().collect::<Option<_>>()?;
        let mut held: Vec<usize> = self
            .group_of_row
            .iter()
            .zip(&self.fold_of_row)
            .filter(|(_, f)| f.is_some())
            .map(|(g, _)| *g)
            .collect();
        held.sort_unstable();
        held.dedup();
        let gain = |g: &usize| {
            self.rms(|fold| &self.folds[fold].before, |h| h == *g) - self.rms(|fold| &left[fold], |h| h == *g)
        };
        let gains = held.iter().map(gain).collect();
        let chosen_without = matches!(choice, Choice::Searched);
        Some(Shown { rms: self.rms(|fold| &left[fold], |_| true), gains, chosen_without })
    }
}

impl Gain {
    /// Whether it is above zero beyond its interval.
    pub fn is_certain(&self) -> bool {
        self.ci95[0] > 0.0
    }
}

/// The gain with its paired 95 % interval.
pub fn gain(gains: &[f64]) -> Gain {
    let value = mean(gains);
    let n = gains.len() as f64;
    let deviation = (gains.iter().map(|g| (g - value).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
    let half = student_95(n - 1.0) * deviation / n.sqrt();
    Gain { value, ci95: [value - half, value + half] }
}

/// Variance explained by the terms over that explained by the saturated model, each for its freedom.
pub fn of_explainable(explanation: &Explanation, before: &Model, after: &Model) -> Option<f64> {
    if after.terms.is_empty() {
        return None;
    }
    let search = &explanation.search;
    let rows = search.rows;
    let noise = &search.noise;
    let target = noise.whiten(&noise.clean);
    let level = |columns: &[Vec<f64>]| {
        let whitened: Vec<Vec<f64>> = columns.iter().map(|c| noise.whiten(c)).collect();
        let rank = whitened.len();
        least_squares(&whitened, &target).rss / (rows.len() as f64 - rank as f64).max(1.0)
    };
    let base = level(&base_columns(rows, before.order));
    let of = |wanted: &dyn Fn(&FittedTerm) -> bool| {
        let mut columns = base_columns(rows, after.order);
        columns.extend(after.terms.iter().filter(|t| wanted(t)).flat_map(|t| t.term.columns.iter().cloned()));
        level(&columns)
    };
    // What was located without a name is part of what can be explained, not of what the named effects explain.
    let named = of(&|t| t.effect.is_some());
    let flexible = level(&saturated(rows, &base_columns(rows, after.order))).min(of(&|_| true)).min(named);
    (base > flexible).then(|| ((base - named) / (base - flexible)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::{Groups, groups, judged};
    use crate::rows::Rows;

    /// Passes over these stretches, eleven rows each, the first of which still has the direction of the pass before.
    fn rows(stretches: &[(f64, f64)]) -> Rows {
        let mut rows = Rows::default();
        let mut before = 0.0;
        for (pass, (from, to)) in (1..).zip(stretches) {
            let heading = (to - from).signum();
            for k in 0..=10 {
                rows.theta.push(from + (to - from) * f64::from(k) / 10.0);
                rows.direction.push(if k == 0 && before != 0.0 { before } else { heading });
                rows.pass.push(pass);
                rows.t_s.push(rows.t_s.len() as f64);
            }
            before = heading;
        }
        rows
    }

    #[test]
    fn an_only_pass_of_a_direction_is_not_held_out_whole() {
        let held_out = |stretches: &[(f64, f64)]| {
            let (_, count, by) = groups(&rows(stretches), Groups::Passes);
            (count, by)
        };
        assert_eq!(held_out(&[(-1.0, 1.0), (1.0, -1.0), (-1.0, 1.0)]), (12, "block"));
        assert_eq!(held_out(&[(-1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, -1.0)]), (4, "pass"));
    }

    #[test]
    fn rows_are_judged_near_others_only() {
        let rows = rows(&[(-1.0, 0.5), (0.5, -1.0), (-0.55, 0.95)]);
        let group: Vec<usize> = rows.pass.iter().map(|pass| *pass as usize - 1).collect();
        let judged = judged(&rows, &group, &|group| Some(group), 3);
        assert!(judged[..22].iter().all(Option::is_some));
        let beyond = |i: &usize| rows.theta[*i] > 0.51;
        assert!((22..33).filter(beyond).all(|i| judged[i].is_none()), "{judged:?}");
        assert!((22..33).filter(|i| !beyond(i)).all(|i| judged[i] == Some(2)), "{judged:?}");
    }
}
