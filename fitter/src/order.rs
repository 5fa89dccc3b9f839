//! The order of the polynomial, by cross-validation (Eq. 9 and 10).
//!
//! Candidates 1–15. The paper's split is made by commanded angle: 30 % of the angles are held out with all
//! their readings, 70 % train, repeated over seeded splits. The smallest and the largest angle always
//! train: a held-out edge would score extrapolation, for which the polynomial is never used. Where no angle
//! repeats, contiguous blocks take the place of angles. Leave-one-pass-out stands beside it; its training
//! set holds every angle, so that it sees noise but hardly any over-fitting, and it does not choose.
//!
//! Chosen is the smallest order within one standard error of the minimum. The error is that of the
//! *difference* of the two testing errors on the same splits, because what all orders share (the noise of
//! the held-out readings) says nothing about which is better; and it is corrected for the overlap of the
//! splits, var·(1/K + held out/training) (Nadeau & Bengio 2003), without which repeating the splits would
//! make it as small as one likes.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use crate::gram::{Grams, Sums};

/// Errors of one candidate order, in the unit of the errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderScore {
    /// The order n.
    pub order: usize,
    /// J_training of Eq. 9, root mean square over the splits.
    pub training: f64,
    /// J_testing of Eq. 10, root mean square over the splits.
    pub testing: f64,
    /// Mean squared testing error less that of the best order, and its standard error, in the squared unit.
    pub excess: f64,
    /// See `excess`.
    pub excess_standard_error: f64,
    /// Testing error with one pass held out at a time; none with a single pass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub leave_one_pass_out: Option<f64>,
}

/// How the order was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderSelection {
    /// The order that was chosen.
    pub chosen: usize,
    /// `one standard error`, or `given` where the user gave it.
    pub rule: String,
    /// The order with the smallest testing error.
    pub smallest_testing_error: usize,
    /// What was held out together: `commanded angle`, `angle, by reading`, `contiguous block`.
    pub held_out_by: String,
    /// Number of such groups, and how many of them each split holds out.
    pub groups: usize,
    /// See `groups`.
    pub held_out_groups: usize,
    /// Number of splits.
    pub splits: usize,
    /// Seed of the splits.
    pub seed: u64,
    /// Unit of the errors in `curve`.
    pub unit: String,
    /// Both curves of the paper's Figure 6, one entry per order that the recording determines.
    pub curve: Vec<OrderScore>,
}

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

/// Scores the orders from `first` to `last`, and chooses; none if the recording has too few points to
/// hold any out. `weights` and `distinct` (the number of distinct readings) are per point.
pub(crate) fn select(
    grams: &Grams,
    weights: &[f64],
    distinct: &[usize],
    first: usize,
    last: usize,
    splits: &Splits,
) -> Option<Scores> {
    let points = grams.points;
    let held_out = ((splits.held_out_share * points as f64).round() as usize).clamp(1, points.max(4) - 3);
    if points < 4 {
        return None;
    }
    // One reading in training must be left over beyond the parameters, whichever groups are held out.
    let mut sizes = distinct.to_vec();
    sizes.sort_unstable();
    let training: usize = sizes[..points - held_out].iter().sum();
    let last = last.min(grams.order).min(training.saturating_sub(2));
    let mut random = ChaCha8Rng::seed_from_u64(splits.seed);
    let plain: Vec<Sums> =
        (0..points).map(|point| grams.total(|_, p| f64::from(u8::from(p == point)))).collect();
    let mut inner: Vec<usize> = (1..points - 1).collect();
    let mut runs = Vec::with_capacity(splits.count);
    for _ in 0..splits.count {
        for position in 0..held_out {
            let other = position + uniform(&mut random, inner.len() - position);
            inner.swap(position, other);
        }
        runs.push(score_split(&plain, weights, &inner[..held_out], first, last));
    }
    let last =
        runs.iter().map(|run| first + run.len()).min()?.checked_sub(1).filter(|last| *last >= first)?;
    let orders: Vec<usize> = (first..=last).collect();
    let count = runs.len() as f64;
    let mean_of = |pick: &dyn Fn(&(f64, f64)) -> f64| -> Vec<f64> {
        (0..orders.len()).map(|i| runs.iter().map(|run| pick(&run[i])).sum::<f64>() / count).collect()
    };
    let (training, testing) = (mean_of(&|run| run.0), mean_of(&|run| run.1));
    let best = (0..orders.len()).min_by(|a, b| testing[*a].total_cmp(&testing[*b]))?;
    let excess: Vec<f64> = testing.iter().map(|score| score - testing[best]).collect();
    let overlap = 1.0 / count + held_out as f64 / (points - held_out) as f64;
    let excess_error: Vec<f64> = (0..orders.len())
        .map(|i| {
            let squares: f64 = runs.iter().map(|run| (run[i].1 - run[best].1 - excess[i]).powi(2)).sum();
            (squares / (count - 1.0).max(1.0) * overlap).sqrt()
        })
        .collect();
    let chosen = (0..=best).find(|i| excess[*i] <= excess_error[*i])?;
    let pass_out = leave_one_pass_out(grams, weights, &orders);
    Some(Scores {
        best: orders[best],
        chosen: orders[chosen],
        orders,
        training,
        testing,
        excess,
        excess_error,
        pass_out,
        held_out,
    })
}

/// Mean squared training and testing error (Eq. 9, 10) of every order from `first` on that the training
/// set determines.
fn score_split(
    plain: &[Sums],
    weights: &[f64],
    held_out: &[usize],
    first: usize,
    last: usize,
) -> Vec<(f64, f64)> {
    let order = plain[0].order;
    let empty = || Sums { order, rows: 0, values: vec![0.0; plain[0].values.len()] };
    let (mut training, mut weighted, mut testing) = (empty(), empty(), empty());
    let add = |to: &mut Sums, sums: &Sums, factor: f64| {
        to.rows += sums.rows;
        to.values.iter_mut().zip(&sums.values).for_each(|(to, sum)| *to += factor * sum);
    };
    for (point, sums) in plain.iter().enumerate() {
        if held_out.contains(&point) {
            add(&mut testing, sums, 1.0);
        } else {
            add(&mut training, sums, 1.0);
            add(&mut weighted, sums, weights[point]);
        }
    }
    let factor = weighted.factor();
    let determined = factor.order.map_or(0, |order| order + 1).min(last + 1);
    (first..determined)
        .map(|order| {
            let c = factor.solve(order);
            (training.squares(&c) / training.rows as f64, testing.squares(&c) / testing.rows as f64)
        })
        .collect()
}

/// Mean squared testing error with each fold of passes held out in turn.
fn leave_one_pass_out(grams: &Grams, weights: &[f64], orders: &[usize]) -> Option<Vec<f64>> {
    if grams.folds < 2 {
        return None;
    }
    let mut squares = vec![0.0; orders.len()];
    let mut rows = 0;
    for fold in 0..grams.folds {
        let training = grams.total(|f, point| if f == fold { 0.0 } else { weights[point] });
        let testing = grams.total(|f, _| f64::from(u8::from(f == fold)));
        let factor = training.factor();
        if factor.order < orders.last().copied() {
            return None;
        }
        for (sum, order) in squares.iter_mut().zip(orders) {
            *sum += testing.squares(&factor.solve(*order));
        }
        rows += testing.rows;
    }
    Some(squares.iter().map(|sum| sum / rows as f64).collect())
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
