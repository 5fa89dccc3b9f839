//! Every candidate explanation of a recording, in families: one family per catalogued effect (its shapes on
//! a grid), one per generic dependence, and one that only raises the order of the base polynomial. The
//! dictionary holds them whitened, and projects them off whatever is already in the model.

use std::sync::Arc;

use numerics::{Basis, Columns, add_scaled, dot, parallel};

use crate::base::base_columns;
use crate::correlation::Whitener;
use crate::effects::{Effect, Place};
use crate::generic;
use crate::jumps::Jumps;
use crate::rows::Rows;
use crate::thresholds::dictionary::{
    HIGHEST_OF_A_MOVE, HIGHEST_ORDER, SMALLEST_PART, SMALLEST_PART_MEASURED, SMALLEST_PART_OF_ONE_TIME,
    TOGETHER,
};

/// What a family stands for.
#[derive(PartialEq)]
pub enum Kind {
    /// The effect of this index in the catalogue.
    Effect(usize),
    /// A generic dependence.
    Generic(Place),
    /// A higher order of the base polynomial: neither an effect nor a mismatch.
    Order,
}

/// One family.
pub struct Family {
    /// What it stands for.
    pub kind: Kind,
    /// Range of its candidates.
    pub candidates: std::ops::Range<usize>,
    /// Part of a column that must be left outside a model.
    pub smallest_part: f64,
    /// How many families each one of these was chosen from, by what they explain; 1 where there was no choice.
    pub stands_for: f64,
    /// How many columns of a candidate are the effect's own, where the others are what is missing of it.
    pub own: Option<usize>,
    /// Rows at which it may begin, where it is a step: all of them are tried at once, and not its candidates.
    pub begins: Option<std::ops::Range<usize>>,
}

impl Family {
    /// A family without candidates yet, of a column that is a measurement of its own or of another one.
    fn of(kind: Kind, measured: bool) -> Family {
        let smallest_part = if measured { SMALLEST_PART_MEASURED } else { SMALLEST_PART };
        Family { kind, candidates: 0..0, smallest_part, stands_for: 1.0, own: None, begins: None }
    }
}

/// The raw columns and the shape parameters of a candidate.
type Group = (Vec<Vec<f64>>, Vec<f64>);

/// One candidate.
pub struct Candidate {
    /// Its family.
    pub family: usize,
    /// Its shape parameters; for a generic family the number of the group.
    pub shape: Vec<f64>,
    /// Its raw columns.
    pub columns: Arc<Vec<Vec<f64>>>,
}

/// All families and candidates of a recording.
pub struct Dictionary {
    /// The families.
    pub families: Vec<Family>,
    /// The candidates.
    pub candidates: Vec<Candidate>,
}

/// Candidates after projection: orthonormal columns per candidate.
pub struct Projected {
    /// Orthonormal columns, some candidates' at a time: a candidate's lie in one block.
    pub blocks: Vec<Columns>,
    /// For every candidate the range of its columns among all (empty where nothing is left of it).
    pub of: Vec<std::ops::Range<usize>>,
    /// For every candidate the first of them that is its own: those before are what is missing of it.
    pub own: Vec<usize>,
    /// For every column which part of the raw one's length was left.
    pub parts: Vec<f64>,
}

impl Projected {
    /// The columns' products with further columns, all at once: `further.count × count`, by columns.
    pub fn products(&self, further: &Columns) -> Vec<f64> {
        self.blocks.iter().flat_map(|block| further.products(block)).collect()
    }

    /// Scores of candidate `c` beside further orthonormal columns, which lie outside the basis: their sum of
    /// squares is what the candidate explains of the residual. `products` holds for every column the products with
    /// those and, last, with the residual. Nothing is projected row by row: within the candidate's columns Q the
    /// further ones B take CᵀC, C = BᵀQ, and what is left has the Gram matrix I − CᵀC.
    pub fn scores(&self, c: usize, products: &[f64], further: usize, smallest: f64, scratch: &mut Scratch) {
        let Scratch { factor, kept, scores } = scratch;
        scores.clear();
        kept.clear();
        let of = |k: usize| &products[k * (further + 1)..(k + 1) * (further + 1)];
        let range = self.of[c].clone();
        let width = range.len();
        factor.resize(width * width, 0.0);
        for k in range {
            // Cholesky, row by row, over the columns that are kept.
            let gram = |j: usize| -> f64 {
                let own = if j == k { 1.0 } else { 0.0 };
                own - of(j).iter().zip(&of(k)[..further]).map(|(a, b)| a * b).sum::<f64>()
            };
            let row = kept.len();
            let mut score = of(k)[further];
            let mut pivot = gram(k);
            for m in 0..row {
                let (above, here) = factor.split_at_mut(row * width);
                let earlier = &above[m * width..m * width + m];
                let sum = gram(kept[m]) - earlier.iter().zip(here.iter()).map(|(a, b)| a * b).sum::<f64>();
                here[m] = sum / above[m * width + m];
                pivot -= here[m] * here[m];
                score -= here[m] * scores[m];
            }
            if pivot > 1e-12 && pivot.sqrt() * self.parts[k] > smallest {
                factor[row * width + row] = pivot.sqrt();
                scores.push(score / pivot.sqrt());
                kept.push(k);
            }
        }
    }
}

/// Room for [`Projected::scores`], used again from candidate to candidate.
#[derive(Default)]
pub struct Scratch {
    factor: Vec<f64>,
    kept: Vec<usize>,
    /// The scores.
    pub scores: Vec<f64>,
}

impl Scratch {
    /// The scores of a candidate's own columns beside what is missing of it.
    pub fn own(&self, projected: &Projected, c: usize) -> &[f64] {
        &self.scores[self.kept.partition_point(|k| *k < projected.own[c])..]
    }
}

impl Dictionary {
    /// Builds the dictionary of the effects that the recording can show (`skip` names ids to leave out).
    pub fn new(rows: &Rows, catalogue: &[Effect], order: usize, skip: &[String]) -> Dictionary {
        let mut d = Dictionary { families: Vec::new(), candidates: Vec::new() };
        let of_effect = |effect: &Effect| -> Option<Vec<Group>> {
            if effect.testable(rows).is_err() || skip.contains(&effect.id) {
                return None;
            }
            let over = effect.over(rows);
            let starts = effect.starts(rows).into_iter().filter(|shape| over.possible_shape(shape));
            Some(starts.map(|s| (over.signature(&s), s)).collect())
        };
        let (of_effects, generic) =
            parallel::join(|| parallel::map(catalogue, of_effect), || generic::families(rows));
        for ((index, effect), groups) in catalogue.iter().enumerate().zip(of_effects) {
            let Some(groups) = groups else { continue };
            let begins = match (effect.begins_at_a_row, &effect.ranges(rows)[..]) {
                (true, [range]) => Some(range.low as usize..range.high as usize + 1),
                _ => None,
            };
            let own = effect.own_columns();
            let mut of_effect = Family { own, begins, ..Family::of(Kind::Effect(index), effect.measured) };
            if effect.is_form() && effect.of_one_time {
                of_effect.smallest_part = SMALLEST_PART_OF_ONE_TIME;
            }
            d.add(of_effect, groups);
        }
        for family in generic {
            let groups = family.groups.into_iter().enumerate().map(|(k, g)| (g, vec![k as f64])).collect();
            let Place { variable, times } = &family.place;
            let stands_for =
                rows.stands_for(variable) * times.as_ref().map_or(1.0, |times| rows.stands_for(times));
            let of_place = Family { stands_for, ..Family::of(Kind::Generic(family.place), family.measured) };
            d.add(of_place, groups);
        }
        let highest = highest_order(rows);
        if highest > order {
            let all = base_columns(rows, highest);
            let groups =
                (order + 1..=highest).map(|m| (all[order + 1..=m].to_vec(), vec![m as f64])).collect();
            d.add(Family::of(Kind::Order, false), groups);
        }
        d
    }

    fn add(&mut self, kind: Family, groups: Vec<Group>) {
        let family = self.families.len();
        let first = self.candidates.len();
        for (columns, shape) in groups {
            self.candidates.push(Candidate { family, shape, columns: Arc::new(columns) });
        }
        self.families.push(Family { candidates: first..self.candidates.len(), ..kind });
    }

    /// The steps of a family that begins at a row, beside `basis`.
    pub fn jumps(&self, family: &Family, whitener: &Whitener, basis: &Basis) -> Option<Jumps> {
        let rows = family.begins.clone()?;
        Some(Jumps::beside(whitener, basis, rows, family.smallest_part))
    }

    /// Every candidate's whitened part outside `basis`, orthonormalised within the candidate; nothing of those
    /// that begin at a row.
    pub fn project(&self, whitener: &Whitener, basis: &Basis) -> Projected {
        let together: Vec<_> = self.candidates.chunks(TOGETHER).collect();
        let parts = parallel::map(&together, |some| self.project_some(some, whitener, basis));
        let mut all = Projected { blocks: Vec::new(), of: Vec::new(), own: Vec::new(), parts: Vec::new() };
        for part in parts {
            let first = all.parts.len();
            all.blocks.extend(part.blocks);
            all.of.extend(part.of.into_iter().map(|r| r.start + first..r.end + first));
            all.own.extend(part.own.into_iter().map(|own| own + first));
            all.parts.extend(part.parts);
        }
        all
    }

    fn project_some(&self, candidates: &[Candidate], whitener: &Whitener, basis: &Basis) -> Projected {
        let mut columns = Columns::new(basis.columns.rows);
        // Steps are not projected one by one.
        let raw =
            |c: &'_ Candidate| if self.families[c.family].begins.is_some() { 0 } else { c.columns.len() };
        columns.reserve(candidates.iter().map(raw).sum());
        let missing = |c: &'_ Candidate| self.families[c.family].own.map_or(0, |own| raw(c) - own);
        let of_all = candidates.iter().flat_map(|c| {
            let (own, missing) = c.columns[..raw(c)].split_at(raw(c) - missing(c));
            missing.iter().chain(own)
        });
        whitener.whiten_onto(of_all.map(Vec::as_slice), &mut columns);
        let length = |column: &[f64]| dot(column, column).sqrt();
        let lengths: Vec<f64> = (0..columns.count()).map(|k| length(columns.get(k))).collect();
        columns.project_off(&basis.columns);
        let mut parts = Vec::new();
        let (mut of, mut own) = (Vec::with_capacity(candidates.len()), Vec::new());
        // What is left of a column moves up to where the last one that was kept ends.
        let (mut kept, mut next) = (0, 0);
        for candidate in candidates {
            let first = kept;
            let mut first_own = first;
            for k in 0..raw(candidate) {
                let (earlier, column) = columns.split(next);
                for q in earlier[first * column.len()..kept * column.len()].chunks_exact(column.len()) {
                    let a = dot(q, column);
                    add_scaled(column, -a, q);
                }
                let left = length(column);
                if left > self.families[candidate.family].smallest_part * lengths[next] {
                    column.iter_mut().for_each(|v| *v /= left);
                    parts.push(left / lengths[next]);
                    columns.move_up(next, kept);
                    kept += 1;
                }
                if k < missing(candidate) {
                    first_own = kept;
                }
                next += 1;
            }
            of.push(first..kept);
            own.push(first_own);
        }
        columns.truncate(kept);
        Projected { blocks: vec![columns], of, own, parts }
    }
}

/// The highest order of the base that the recording can carry: as in `fit`, three tenths of the positions must be
/// left to hold out, and one more than the order needs.
pub fn highest_order(rows: &Rows) -> usize {
    if let Some(order) = rows.order {
        return order;
    }
    let (low, high) = rows.stroke();
    let places = (high - low) / rows.step();
    let by_places = (places * 0.6) as usize;
    let positions = rows.positions();
    let held_out = (0.3 * positions as f64).round() as usize;
    let by_positions = positions.saturating_sub(held_out + 2);
    let by_rows = rows.len() / 6;
    // Of a single move nothing repeats, and a wandering error passes for shape.
    let highest = if rows.single_move() { HIGHEST_OF_A_MOVE } else { HIGHEST_ORDER };
    highest.min(by_places).min(by_positions).min(by_rows).max(1)
}

#[cfg(test)]
mod tests {
    use super::{Projected, Scratch};
    use crate::correlation::{Correlation, Process};
    use numerics::{Basis, Columns, dot};

    /// Columns with nothing in common but what comes of their finite length.
    fn column(n: usize, k: usize) -> Vec<f64> {
        (0..n).map(|i| ((i * i * (k + 3) + 7 * i * k) as f64 * 0.618).sin()).collect()
    }

    #[test]
    fn columns_that_are_made_white_together_are_what_each_is_alone() {
        let t_s: Vec<f64> = (0..60).map(f64::from).collect();
        let sigma: Vec<f64> = column(60, 9).iter().map(|v| 1.0 + 0.3 * v).collect();
        for process in [Process::white(), Process::slow(1.0, 6.0)] {
            let whitener = Correlation::none(&t_s).with(&process).whitener(&sigma);
            let columns: Vec<Vec<f64>> = (0..11).map(|k| column(60, k)).collect();
            let mut together = Columns::new(60);
            whitener.whiten_onto(columns.iter().map(Vec::as_slice), &mut together);
            assert_eq!(together.count(), columns.len());
            for (k, alone) in columns.iter().enumerate() {
                assert_eq!(together.get(k), whitener.whiten(alone));
            }
        }
    }

    #[test]
    fn what_nothing_is_left_of_has_no_products() {
        let none = Projected {
            blocks: vec![Columns::new(60)],
            of: std::iter::once(0..0).collect(),
            own: vec![0],
            parts: Vec::new(),
        };
        let mut residual = Columns::new(60);
        residual.push(&column(60, 1));
        assert!(none.products(&residual).is_empty());
    }

    #[test]
    fn scores_explain_what_projection_does() {
        let n = 60;
        // A candidate of three orthonormal columns, beside two further columns, of a residual.
        let mut own = Basis::new(n);
        (0..3).for_each(|k| {
            own.add(&column(n, k));
        });
        let mut beside = Basis::new(n);
        (5..7).for_each(|k| {
            beside.add(&column(n, k));
        });
        let mut residual = column(n, 11);
        beside.project_off(&mut residual);
        let of = std::iter::once(0..3).collect();
        let projected =
            Projected { blocks: vec![own.columns.clone()], of, own: vec![0], parts: vec![1.0; 3] };
        let mut further = Columns::new(n);
        (0..2).for_each(|k| further.push(beside.columns.get(k)));
        further.push(&residual);
        let mut scratch = Scratch::default();
        projected.scores(0, &projected.products(&further), 2, 0.02, &mut scratch);
        let explained = dot(&scratch.scores, &scratch.scores);

        let mut both = beside.clone();
        (0..3).for_each(|k| {
            both.add(own.columns.get(k));
        });
        let wanted: f64 = (2..5).map(|k| dot(both.columns.get(k), &residual).powi(2)).sum();
        assert!((explained - wanted).abs() < 1e-10, "{explained} for {wanted}");
    }
}
