//! The order of the polynomial, by cross-validation (Eq. 9 and 10).
//!
//! Candidates 1–15. The paper's split is made by commanded angle: 30 % of the angles are held out with all
//! their readings, 70 % train, repeated over seeded splits. The smallest and the largest angle always
//! train: a held-out edge would score extrapolation, for which the polynomial is never used. Where no angle
//! repeats, contiguous blocks take the place of angles. Leave-one-pass-out stands beside it; its training
//! set holds every angle, so that it sees noise but hardly any over-fitting, and it does not choose.
//!
//! Chosen is the smallest order within one standard error of the minimum. The error is that of the
//! *difference* of the two testing errors on the same splits: what all orders share, the noise of the
//! held-out readings, says nothing about which is better. It comes from a jackknife over passes, the
//! independent repeats of the recording: the angles are not a sample of anything, so that the differences
//! between splits measure how uneven the misfit is rather than how uncertain it is, and averaging over ever
//! more splits removes them. With fewer than three passes there is nothing to repeat, and the error is
//! that of the splits, corrected for their overlap: var·(1/K + held out/training) (Nadeau & Bengio 2003).
//!
//! Where the noise is uneven and the rows are weighted, both errors are weighted alike.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::gram::{Grams, Sums};

pub use crate::coefficients::{OrderScore, OrderSelection};

/// The rule by which an order is chosen, as the coefficients file names it.
pub(crate) const RULE: &str = "one standard error";

/// How the splits are made.
#[derive(Debug, Clone, PartialEq)]
pub struct Splits {
    /// Number of splits.
    pub count: usize,
    /// Share of the angles that is held out, 0.3 in the paper.
    pub held_out_share: f64,
    /// Seed.
    pub seed: u64,
}

impl Default for Splits {
    fn default() -> Splits {
        Splits { count: 100, held_out_share: 0.3, seed: 1 }
    }
}

/// Scores of all orders in the squared internal unit.
pub(crate) struct Scores {
    pub orders: Vec<usize>,
    pub training: Vec<f64>,
    pub testing: Vec<f64>,
    pub excess: Vec<f64>,
    pub excess_error: Vec<f64>,
    pub pass_out: Option<Vec<f64>>,
    pub held_out: usize,
    pub best: usize,
    pub chosen: usize,
}

/// The orders that are tried: `first`, `first` + `step` … up to `last`. A harmonic has two columns, a power one.
#[derive(Clone, Copy)]
pub(crate) struct Candidates {
    pub first: usize,
    pub last: usize,
    pub step: usize,
}

impl Candidates {
    /// Those up to the order that a factor determines.
    fn determined(self, highest: Option<usize>) -> impl Iterator<Item = usize> {
        let end = highest.map_or(0, |order| order + 1).min(self.last + 1);
        (self.first..end).step_by(self.step)
    }
}

/// Scores the candidate orders, and chooses; none if the recording has too few points to hold any out.
/// `weights` and `distinct` (the number of distinct readings) are per point.
pub(crate) fn select(
    grams: &Grams,
    weights: &[f64],
    distinct: &[usize],
    candidates: Candidates,
    splits: &Splits,
) -> Option<Scores> {
    let points = grams.points;
    if points < 4 {
        return None;
    }
    let held_out = ((splits.held_out_share * points as f64).round() as usize).clamp(1, points - 3);
    // One reading in training must be left over beyond the parameters, whichever groups are held out.
    let mut sizes = distinct.to_vec();
    sizes.sort_unstable();
    let training: usize = sizes[..points - held_out].iter().sum();
    let last = candidates.last.min(grams.order).min(training.saturating_sub(2));
    let candidates = Candidates { last, ..candidates };
    let sets = held_out_sets(points, held_out, splits);

    let every = |skip: std::ops::Range<usize>| -> Vec<Sums> {
        (0..points).map(|point| grams.point(point, weights[point], &skip)).collect()
    };
    let whole = Runs::of(&every(0..0), &sets, candidates)?;
    let (training, testing) = (whole.mean(|run| run.0), whole.mean(|run| run.1));
    let orders: Vec<usize> = (0..testing.len()).map(|i| candidates.first + i * candidates.step).collect();
    let best = (0..orders.len()).min_by(|a, b| testing[*a].total_cmp(&testing[*b]))?;
    let excess: Vec<f64> = testing.iter().map(|score| score - testing[best]).collect();
    let repeats: Vec<Vec<f64>> = jackknife_groups(grams.folds)
        .into_iter()
        .filter_map(|group| Runs::of(&every(group), &sets, candidates))
        .map(|runs| runs.mean(|run| run.1))
        .filter(|testing| testing.len() == orders.len())
        .map(|testing| testing.iter().map(|score| score - testing[best]).collect())
        .collect();
    let excess_error = if repeats.len() >= LEAST_REPEATS {
        jackknife(&repeats, orders.len())
    } else {
        let overlap = 1.0 / sets.len() as f64 + held_out as f64 / (points - held_out) as f64;
        whole.spread_of_difference(best).iter().map(|variance| (variance * overlap).sqrt()).collect()
    };
    let chosen = (0..=best).find(|i| excess[*i] <= excess_error[*i])?;
    Some(Scores {
        best: orders[best],
        chosen: orders[chosen],
        pass_out: leave_one_pass_out(grams, weights, &orders),
        orders,
        training,
        testing,
        excess,
        excess_error,
        held_out,
    })
}

/// A jackknife needs three repeats at least; more than ten passes are bundled to ten.
const LEAST_REPEATS: usize = 3;
const MOST_REPEATS: usize = 10;

/// Folds of passes that are left out together in the jackknife.
fn jackknife_groups(folds: usize) -> Vec<std::ops::Range<usize>> {
    let groups = folds.min(MOST_REPEATS);
    if groups < LEAST_REPEATS {
        return Vec::new();
    }
    (0..groups).map(|group| group * folds / groups..(group + 1) * folds / groups).collect()
}

/// Standard error of each entry from its values with one repeat left out at a time (Quenouille, Tukey).
fn jackknife(repeats: &[Vec<f64>], entries: usize) -> Vec<f64> {
    let count = repeats.len() as f64;
    (0..entries)
        .map(|i| {
            let mean = repeats.iter().map(|repeat| repeat[i]).sum::<f64>() / count;
            let squares: f64 = repeats.iter().map(|repeat| (repeat[i] - mean).powi(2)).sum();
            ((count - 1.0) / count * squares).sqrt()
        })
        .collect()
}

/// The groups that each split holds out. The first and the last, the edges of the range, always train.
fn held_out_sets(points: usize, held_out: usize, splits: &Splits) -> Vec<Vec<usize>> {
    let mut random = ChaCha8Rng::seed_from_u64(splits.seed);
    let mut inner: Vec<usize> = (1..points - 1).collect();
    (0..splits.count)
        .map(|_| {
            for position in 0..held_out {
                let other = position + uniform(&mut random, inner.len() - position);
                inner.swap(position, other);
            }
            inner[..held_out].to_vec()
        })
        .collect()
}

/// Mean squared training and testing error of every order, split by split.
struct Runs(Vec<Vec<(f64, f64)>>);

impl Runs {
    /// `plain` holds the weighted sums of each point. None if no candidate is determined.
    fn of(plain: &[Sums], sets: &[Vec<usize>], candidates: Candidates) -> Option<Runs> {
        let mut whole = Sums::zero(plain[0].order);
        plain.iter().for_each(|sums| whole.add(sums, 1.0));
        let mut runs: Vec<Vec<(f64, f64)>> =
            sets.iter().filter_map(|held_out| score_split(plain, &whole, held_out, candidates)).collect();
        let orders = runs.iter().map(Vec::len).min().filter(|orders| *orders > 0)?;
        runs.iter_mut().for_each(|run| run.truncate(orders));
        Some(Runs(runs))
    }

    fn mean(&self, pick: impl Fn(&(f64, f64)) -> f64) -> Vec<f64> {
        let count = self.0.len() as f64;
        (0..self.0[0].len()).map(|i| self.0.iter().map(|run| pick(&run[i])).sum::<f64>() / count).collect()
    }

    /// Variance between splits of each order's testing error less that of order number `best`.
    fn spread_of_difference(&self, best: usize) -> Vec<f64> {
        let mean = self.mean(|run| run.1);
        let freedom = (self.0.len() as f64 - 1.0).max(1.0);
        (0..mean.len())
            .map(|i| {
                let excess = mean[i] - mean[best];
                self.0.iter().map(|run| (run[i].1 - run[best].1 - excess).powi(2)).sum::<f64>() / freedom
            })
            .collect()
    }
}

/// Mean squared training and testing error (Eq. 9, 10) of every candidate that the training set determines. Tested are points
/// between others that train: where a pass is left out that alone went as far as the edge, the next points would score
/// extrapolation. None where nothing is tested.
fn score_split(
    plain: &[Sums],
    whole: &Sums,
    held_out: &[usize],
    candidates: Candidates,
) -> Option<Vec<(f64, f64)>> {
    let (mut training, mut testing) = (whole.clone(), Sums::zero(whole.order));
    let trains = |point: &usize| plain[*point].weight > 0.0 && !held_out.contains(point);
    let first = (0..plain.len()).find(trains)?;
    let last = (0..plain.len()).rev().find(trains)?;
    for point in held_out {
        if (first..last).contains(point) {
            testing.add(&plain[*point], 1.0);
        }
        training.add(&plain[*point], -1.0);
    }
    let factor = training.factor();
    let score = |order: usize| {
        let c = factor.solve(order);
        (training.squares(&c) / training.weight, testing.squares(&c) / testing.weight)
    };
    (testing.weight > 0.0).then(|| candidates.determined(factor.order).map(score).collect())
}

/// Mean squared testing error with each fold of passes held out in turn.
fn leave_one_pass_out(grams: &Grams, weights: &[f64], orders: &[usize]) -> Option<Vec<f64>> {
    if grams.folds < 2 {
        return None;
    }
    let mut squares = vec![0.0; orders.len()];
    let mut weight = 0.0;
    for fold in 0..grams.folds {
        let training = grams.total(|f, point| if f == fold { 0.0 } else { weights[point] });
        let testing = grams.total(|f, point| if f == fold { weights[point] } else { 0.0 });
        let factor = training.factor();
        if factor.order < orders.last().copied() {
            return None;
        }
        for (sum, order) in squares.iter_mut().zip(orders) {
            *sum += testing.squares(&factor.solve(*order));
        }
        weight += testing.weight;
    }
    Some(squares.iter().map(|sum| sum / weight).collect())
}

/// A whole number below `below`, evenly distributed (Lemire's method, with rejection).
fn uniform(random: &mut ChaCha8Rng, below: usize) -> usize {
    let below = below as u64;
    let floor = below.wrapping_neg() % below;
    loop {
        let product = u128::from(random.next_u64()) * u128::from(below);
        if product as u64 >= floor {
            return (product >> 64) as usize;
        }
    }
}
