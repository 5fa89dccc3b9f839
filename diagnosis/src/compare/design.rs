//! One linear model of two recordings: what each has for itself, what is common, and what of the common may differ.

use numerics::{Basis, LeastSquares, add_scaled, dot, least_squares};

use crate::base::base_columns;
use crate::correlation::Whitener;
use crate::effects::{Effect, Place, Range};
use crate::noise::Noise;
use crate::thresholds::compare::{HALVINGS, TURNS};
use crate::thresholds::explain::UNMEASURED;

use super::joined::Joined;
use super::reference;
use super::shared::Shared;

/// What a part of the common model is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The base's slope over the reading.
    Gain,
    /// The rest of the base.
    Base,
    /// The amplitudes of shared effect number `k`.
    Amplitude(usize),
    /// Shape parameter `j` of shared effect number `k`.
    Shape(usize, usize),
}

impl What {
    /// The number of the shared effect that it belongs to; none of the base.
    pub fn effect(self) -> Option<usize> {
        match self {
            What::Amplitude(k) | What::Shape(k, _) => Some(k),
            What::Gain | What::Base => None,
        }
    }

    /// Whether both belong to one effect, or are the same part of the base.
    pub fn belongs_to(self, other: What) -> bool {
        self == other || self.effect().is_some() && self.effect() == other.effect()
    }
}

/// A part of the common model, which may differ between the recordings.
#[derive(Clone)]
pub struct Part {
    /// What it is.
    pub what: What,
    /// Its columns over both recordings.
    pub columns: Vec<Vec<f64>>,
    /// What else the part of a shape has.
    of_shape: Option<OfShape>,
    /// What it does to the base as well where it differs.
    of_base: Vec<Vec<f64>>,
}

/// What the part of a shape has, whose columns go with the amplitudes.
#[derive(Clone)]
struct OfShape {
    /// Its columns where the effect is as strong in both recordings.
    in_common: Vec<Vec<f64>>,
    /// How far a fit may be expected to move it: by its own size, or half its range.
    size: f64,
}

/// The model of both recordings.
#[derive(Clone)]
pub struct Design<'a> {
    /// Both recordings.
    pub both: &'a Joined,
    /// What was found.
    pub shared: Vec<Shared>,
    /// What each recording has for itself: an offset, what happened at one time.
    own: Vec<Vec<f64>>,
    /// The order of the base.
    order: usize,
    /// The parts.
    pub parts: Vec<Part>,
}

/// A least-squares fit of both recordings.
pub struct Fitted {
    /// Which parts differ.
    pub changed: Vec<usize>,
    /// The solution in units of the noise.
    pub solution: LeastSquares,
    /// Per part where its common coefficients begin.
    common: Vec<usize>,
    /// Per changed part where its differences begin.
    differences: Vec<usize>,
    /// All columns, raw.
    columns: Vec<Vec<f64>>,
}

impl Fitted {
    /// The indices of a part's common coefficients and of its differences; the latter none where it is the same in both.
    pub fn of(&self, design: &Design, part: usize) -> (Vec<usize>, Option<Vec<usize>>) {
        let width = design.parts[part].columns.len();
        let at = |first: usize| (first..first + width).collect();
        let changed = self.changed.iter().position(|c| *c == part);
        (at(self.common[part]), changed.map(|c| at(self.differences[c])))
    }

    /// What the model says of every row.
    pub fn value(&self) -> Vec<f64> {
        let mut value = vec![0.0; self.columns.first().map_or(0, Vec::len)];
        for (coefficient, column) in self.solution.coefficients.iter().zip(&self.columns) {
            add_scaled(&mut value, *coefficient, column);
        }
        value
    }

    /// Variance of that in one row.
    pub fn variance(&self, row: usize) -> f64 {
        let n = self.columns.len();
        let term = |i: usize, j: usize| {
            self.columns[i][row] * self.solution.inverse[i * n + j] * self.columns[j][row]
        };
        (0..n * n).map(|k| term(k / n, k % n)).sum::<f64>().max(0.0)
    }

    /// What the differences of a changed part add to every row.
    pub fn difference(&self, design: &Design, part: usize) -> Vec<f64> {
        let mut value = vec![0.0; self.columns.first().map_or(0, Vec::len)];
        for k in self.of(design, part).1.unwrap_or_default() {
            add_scaled(&mut value, self.solution.coefficients[k], &self.columns[k]);
        }
        value
    }
}

/// The whitened observations of both recordings.
pub struct White {
    whiteners: [Whitener; 2],
    split: usize,
    target: Vec<f64>,
}

impl White {
    /// In the noise of each; the rows of `unmeasured`, by their numbers in both recordings, take no part.
    pub fn new(noise: &[Noise; 2], unmeasured: &[usize]) -> White {
        let split = noise[0].sigma.len();
        let mut noise = noise.clone();
        for row in unmeasured {
            let (recording, row) = if *row < split { (0, *row) } else { (1, row - split) };
            noise[recording].sigma[row] = UNMEASURED * noise[recording].level;
        }
        let whiteners = [noise[0].whitener(), noise[1].whitener()];
        let mut white = White { whiteners, split, target: Vec::new() };
        white.target = white.of(&[&noise[0].clean[..], &noise[1].clean[..]].concat());
        white
    }

    /// A column of both recordings in units of the noise.
    pub fn of(&self, column: &[f64]) -> Vec<f64> {
        let (then, now) = column.split_at(self.split);
        [self.whiteners[0].whiten(then), self.whiteners[1].whiten(now)].concat()
    }
}

impl<'a> Design<'a> {
    /// The model with these effects. `own` is what each recording has for itself, over its own rows.
    pub fn new(both: &'a Joined, order: usize, own: [Vec<Vec<f64>>; 2], shared: Vec<Shared>) -> Design<'a> {
        let [then, now] = own;
        let (n, split) = (both.rows.len(), both.split);
        let before = |c: Vec<f64>| [c, vec![0.0; n - split]].concat();
        let after = |c: Vec<f64>| [vec![0.0; split], c].concat();
        let mut own: Vec<Vec<f64>> = then.into_iter().map(before).chain(now.into_iter().map(after)).collect();
        own.push(base_columns(&both.rows, 0).swap_remove(0));
        let mut design = Design { both, shared, own, order, parts: Vec::new() };
        design.assemble();
        design
    }

    /// The parts at the present shapes and amplitudes.
    fn assemble(&mut self) {
        let base = base_columns(&self.both.rows, self.order);
        let mut parts = Vec::new();
        let mut push = |what: What, columns: Vec<Vec<f64>>, of_shape: Option<OfShape>| {
            if !columns.is_empty() {
                let of_base = match what {
                    What::Amplitude(k) => reference::of(&self.shared[k], &columns, &base, self.both),
                    _ => Vec::new(),
                };
                parts.push(Part { what, columns, of_shape, of_base });
            }
        };
        let slope = usize::from(self.both.rows.whole_turn().is_none());
        push(What::Gain, base[1..(1 + slope).min(base.len())].to_vec(), None);
        push(What::Base, base[(1 + slope).min(base.len())..].to_vec(), None);
        for (k, shared) in self.shared.iter().enumerate() {
            push(What::Amplitude(k), shared.columns(self.both), None);
            if !shared.amplitudes[0].is_empty() {
                for (j, range) in shared.free_shapes(self.both) {
                    let at = |amplitudes| vec![shared.derivative(self.both, j, &range, amplitudes)];
                    let ([then, now], larger) = (&shared.amplitudes, &shared.amplitudes[shared.stronger()]);
                    let of_shape =
                        OfShape { in_common: at([larger, larger]), size: shared.size(j, &range, 0) };
                    push(What::Shape(k, j), at([then, now]), Some(of_shape));
                }
            }
        }
        self.parts = parts;
    }

    /// Whether a part may differ. A shape that one recording does not show cannot differ from that of the other.
    pub fn may_differ(&self, part: usize) -> bool {
        match self.parts[part].what {
            What::Shape(k, _) => self.shared[k].found.iter().all(Option::is_some),
            What::Amplitude(_) | What::Gain | What::Base => true,
        }
    }

    /// A part's columns over both recordings where these parts differ. Where an effect is as strong in both, those of its shape
    /// have one amplitude: with that of each recording, those of an effect that came would exist in the later one alone, and
    /// take up the difference.
    fn columns(&self, part: usize, changed: &[usize]) -> &[Vec<f64>] {
        let differs = |what: What| changed.iter().any(|part| self.parts[*part].what == what);
        match &self.parts[part] {
            Part { what: What::Shape(k, _), of_shape: Some(of_shape), .. }
                if !differs(What::Amplitude(*k)) =>
            {
                &of_shape.in_common
            }
            part => &part.columns,
        }
    }

    /// A part's columns on the later recording alone.
    fn differing(&self, part: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
        self.later(&self.parts[part].columns)
    }

    /// What a part that differs does to the base, on the later recording alone.
    fn differing_base(&self, part: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
        self.later(&self.parts[part].of_base)
    }

    fn later<'c>(&self, columns: &'c [Vec<f64>]) -> impl Iterator<Item = Vec<f64>> + use<'c> {
        let split = self.both.split;
        columns.iter().map(move |column| {
            let mut later = column.clone();
            later[..split].fill(0.0);
            later
        })
    }

    /// The id of what a part belongs to: an effect's, that of a form by its number, `structure`, `gain` or `base`.
    pub fn id(&self, what: What) -> String {
        let Some(k) = what.effect() else {
            return if what == What::Gain { "gain".into() } else { "base".into() };
        };
        let is_form = |shared: &Shared| shared.effect.as_ref().is_some_and(Effect::is_form);
        match &self.shared[k].effect {
            None => "structure".into(),
            Some(_) if is_form(&self.shared[k]) => {
                format!("empirical_{}", self.shared[..=k].iter().filter(|shared| is_form(shared)).count())
            }
            Some(effect) => effect.id.clone(),
        }
    }

    /// Its name for a reader.
    pub fn title(&self, what: What) -> String {
        match what.effect().map(|k| &self.shared[k].effect) {
            Some(Some(effect)) => effect.title.clone(),
            Some(None) => "a dependence without a name".into(),
            None if what == What::Gain => "the gain".into(),
            None => "the shape of the base".into(),
        }
    }

    /// Where it lives.
    pub fn place(&self, what: What) -> Place {
        what.effect().map_or_else(|| Place::on("angle_deg"), |k| self.shared[k].place.clone())
    }

    /// The part that is this.
    pub fn part(&self, what: What) -> Option<usize> {
        self.parts.iter().position(|part| part.what == what)
    }

    /// Fits both recordings, with these parts differing. A shape that the readings do not determine stays near where it is:
    /// its size is a standard deviation.
    pub fn fit(&self, white: &White, changed: &[usize]) -> Fitted {
        let mut columns = self.own.clone();
        let mut common = Vec::new();
        let mut shapes = Vec::new();
        let size = |part: usize| self.parts[part].of_shape.as_ref().map(|shape| shape.size);
        for part in 0..self.parts.len() {
            common.push(columns.len());
            shapes.extend(size(part).map(|size| (columns.len(), size)));
            columns.extend_from_slice(self.columns(part, changed));
        }
        let mut differences = Vec::new();
        for part in changed {
            differences.push(columns.len());
            shapes.extend(size(*part).map(|size| (columns.len(), size)));
            columns.extend(self.differing(*part).chain(self.differing_base(*part)));
        }
        let expected = |column: usize| {
            shapes.iter().map(move |(shape, size)| if *shape == column { 1.0 / size } else { 0.0 })
        };
        let whitened: Vec<Vec<f64>> = columns
            .iter()
            .enumerate()
            .map(|(k, c)| white.of(c).into_iter().chain(expected(k)).collect())
            .collect();
        let target = [&white.target[..], &vec![0.0; shapes.len()]].concat();
        let solution = least_squares(&whitened, &target);
        Fitted { changed: changed.to_vec(), solution, common, differences, columns }
    }

    /// The whole model with these parts differing, and what it leaves of the observations.
    pub fn beside(&self, white: &White, changed: &[usize]) -> (Basis, Vec<f64>) {
        let mut basis = Basis::new(self.both.rows.len());
        let parts = (0..self.parts.len()).flat_map(|part| self.columns(part, changed));
        let whole = self.own.iter().chain(parts);
        whole.for_each(|column| {
            basis.add(&white.of(column));
        });
        let differing = |part: &usize| self.differing(*part).chain(self.differing_base(*part));
        changed.iter().flat_map(differing).for_each(|column| {
            basis.add(&white.of(&column));
        });
        let mut left = white.target.clone();
        basis.project_off(&mut left);
        (basis, left)
    }

    /// What it explains that a part differs, beside others that do, and with how many degrees of freedom.
    pub fn explained(&self, white: &White, changed: &[usize]) -> Vec<(f64, usize)> {
        let (basis, left) = self.beside(white, changed);
        let of = |part: usize| {
            let mut basis = basis.clone();
            self.differing_base(part).for_each(|column| {
                basis.add(&white.of(&column));
            });
            explained_by(&mut basis, self.differing(part).map(|column| white.of(&column)), &left)
        };
        let free = |part: &usize| self.may_differ(*part) && !changed.contains(part);
        (0..self.parts.len()).map(|part| if free(&part) { of(part) } else { (0.0, 0) }).collect()
    }

    /// Moves shapes and amplitudes to where a fit puts them, a few times (Gauss–Newton, halving a step that leaves more).
    /// `changed` differ.
    pub fn refine(&mut self, white: &White, changed: &[What]) {
        for _ in 0..TURNS {
            let fitted = self.fit(white, &self.parts_of(changed));
            let moves = self.take_amplitudes(&fitted);
            self.follow();
            self.assemble();
            if moves.is_empty() {
                continue;
            }
            let left = self.left_at_shapes(white, changed);
            let before: Vec<[Vec<f64>; 2]> = self.shared.iter().map(|shared| shared.shape.clone()).collect();
            for halvings in 0..=HALVINGS {
                let part = 0.5f64.powi(halvings);
                for (k, j, range, by) in &moves {
                    for recording in [0, 1] {
                        let from = before[*k][recording][*j];
                        let to = (from + part * by[recording]).clamp(range.low, range.high);
                        self.shared[*k].shape[recording][*j] = to;
                    }
                }
                self.assemble();
                if self.left_at_shapes(white, changed) <= left {
                    break;
                }
                self.shared
                    .iter_mut()
                    .zip(&before)
                    .for_each(|(shared, shape)| shared.shape.clone_from(shape));
            }
            self.assemble();
        }
    }

    /// What a fit at the present shapes leaves.
    fn left_at_shapes(&self, white: &White, changed: &[What]) -> f64 {
        let mut fixed = self.clone();
        fixed.parts.retain(|part| !matches!(part.what, What::Shape(..)));
        fixed.fit(white, &fixed.parts_of(changed)).solution.rss
    }

    /// Puts shapes that follow from the amplitudes where those of the recording put them that has more of the effect: in the
    /// other its columns would vanish, and an amplitude that differs would not be missed.
    fn follow(&mut self) {
        for shared in &mut self.shared {
            let Some(effect) = shared.effect.as_ref().filter(|effect| effect.shape_follows) else { continue };
            let more = shared.stronger();
            if !shared.amplitudes[more].is_empty() {
                let shape =
                    effect.consistent_shape(&shared.shape[more], &shared.amplitudes[more], &self.both.rows);
                shared.shape = [shape.clone(), shape];
            }
        }
    }

    /// Refines with all amplitudes differing, each effect from the shape of either recording: what leaves less stays.
    pub fn settle(&mut self, white: &White, amplitudes: &[What]) {
        self.refine(white, amplitudes);
        for k in 0..self.shared.len() {
            let Some(otherwise) = self.shared[k].with_other_shape() else { continue };
            let mut other = self.clone();
            other.shared[k] = otherwise;
            other.assemble();
            other.refine(white, amplitudes);
            let rss = |design: &Design| design.fit(white, &design.parts_of(amplitudes)).solution.rss;
            if other.parts.len() == self.parts.len() && rss(&other) < rss(self) {
                *self = other;
            }
        }
    }

    /// The same with one effect in the place of two: one is in both recordings, the other in none.
    pub fn with_one(&self, kept: usize, dropped: usize) -> Design<'a> {
        let mut design = self.clone();
        let found = design.shared[dropped].found;
        design.shared[kept].found.iter_mut().zip(found).for_each(|(kept, found)| *kept = kept.or(found));
        design.shared.remove(dropped);
        design.assemble();
        design
    }

    /// The same without an effect, and what `others` are in it. The base stays.
    pub fn without(&self, what: What, others: &[What]) -> (Design<'a>, Vec<What>) {
        let mut design = self.clone();
        let Some(dropped) = what.effect() else { return (design, others.to_vec()) };
        design.shared.remove(dropped);
        design.assemble();
        let moved = |k: usize| if k > dropped { k - 1 } else { k };
        let translated = |other: &What| match *other {
            What::Amplitude(k) => What::Amplitude(moved(k)),
            What::Shape(k, j) => What::Shape(moved(k), j),
            of_base => of_base,
        };
        (design, others.iter().map(translated).collect())
    }

    /// The same with a further effect that differs, at the shape that explains most beside `others`, which differ, too. None
    /// where its difference cannot be that of this effect.
    pub fn with(&self, added: Shared, white: &White, others: &[What]) -> Option<Design<'a>> {
        let mut design = self.clone();
        let of_it = What::Amplitude(design.shared.len());
        design.shared.push(added);
        design.assemble();
        design.refine(white, &[others, &[of_it]].concat());
        let added = design.shared.last()?;
        let (effect, [then, now]) = (added.effect.as_ref()?, &added.amplitudes);
        let plausible = |sign: f64| {
            let difference: Vec<f64> = now.iter().zip(then).map(|(now, then)| sign * (now - then)).collect();
            effect.plausible_at(&design.both.rows, &added.shape[1], &difference)
        };
        (plausible(1.0) || plausible(-1.0)).then_some(design)
    }

    /// The amplitudes of every effect.
    pub fn amplitudes(&self) -> Vec<What> {
        let of_effect = |what: &What| matches!(what, What::Amplitude(_));
        self.parts.iter().map(|part| part.what).filter(of_effect).collect()
    }

    /// The numbers of parts.
    pub fn parts_of(&self, what: &[What]) -> Vec<usize> {
        what.iter().filter_map(|what| self.part(*what)).collect()
    }

    /// Keeps the amplitudes of a fit, and says which shapes it would move in each recording and how far: at most by half.
    fn take_amplitudes(&mut self, fitted: &Fitted) -> Vec<(usize, usize, Range, [f64; 2])> {
        let mut moves = Vec::new();
        for part in 0..self.parts.len() {
            let (common, differences) = fitted.of(self, part);
            let c = |k: &usize| fitted.solution.coefficients[*k];
            let then: Vec<f64> = common.iter().map(c).collect();
            let more = differences.map_or_else(|| vec![0.0; then.len()], |d| d.iter().map(c).collect());
            let now: Vec<f64> = then.iter().zip(more).map(|(a, b)| a + b).collect();
            match self.parts[part].what {
                What::Amplitude(k) => self.shared[k].amplitudes = [then, now],
                What::Shape(k, j) => {
                    let ranges = self.shared[k].free_shapes(self.both);
                    let Some((_, range)) = ranges.into_iter().find(|(of, _)| *of == j) else { continue };
                    let limited = |recording: usize, by: f64| {
                        let size = self.shared[k].size(j, &range, recording);
                        by.clamp(-0.5 * size, 0.5 * size)
                    };
                    let by = [limited(0, then[0]), limited(1, now[0])];
                    moves.push((k, j, range, by));
                }
                What::Gain | What::Base => {}
            }
        }
        moves
    }
}

/// The square sum of whitened observations that further columns explain, and by how many degrees of freedom; the columns are
/// added to the basis. `left` is what the basis left of the observations.
pub fn explained_by(
    basis: &mut Basis,
    columns: impl Iterator<Item = Vec<f64>>,
    left: &[f64],
) -> (f64, usize) {
    let first = basis.rank();
    columns.for_each(|column| {
        basis.add(&column);
    });
    let new = first..basis.rank();
    let freedom = new.len();
    (new.map(|k| dot(basis.columns.get(k), left).powi(2)).sum(), freedom)
}
