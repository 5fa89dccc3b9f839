//! Noise that is louder for a while: a relay that chatters, a door, a pump. In a burst every reading scatters more, and
//! tells less. A reading that lies far out alone is an outlier, and no burst.
//!
//! Two states, quiet and loud, follow each other from reading to reading with fixed probabilities; both scatter normally.
//! Source: Rabiner, A tutorial on hidden Markov models, Proc. IEEE 77 (1989), section III.

use numerics::median;

use crate::thresholds::noise::VARIANCE_GAIN;
use crate::thresholds::noise::bursts::{LEAST_FACTOR, LEAST_LENGTH, MOST_PART, ROUNDS};

/// A chain of two states, the quiet one first.
struct Chain {
    /// Variance of each.
    variances: [f64; 2],
    /// Probability that a state ends with a reading.
    ends: [f64; 2],
    /// Whether bursts last. Else every reading is loud by itself.
    lasts: bool,
}

/// Probabilities of both states at every reading.
type States = Vec<[f64; 2]>;

/// What all readings say of the states, at a chain's parameters.
struct Smoothed {
    /// Density of each reading in either state.
    densities: States,
    /// The states by all readings before each.
    before: States,
    /// What all readings after each say of them.
    after: States,
    log_likelihood: f64,
}

impl Chain {
    /// The likeliest for these squares of residuals, with what it makes of them. `quiet` is about the variance of most.
    fn estimated(squares: &[f64], quiet: f64, lasts: bool) -> (Chain, Smoothed) {
        let ends = if lasts { [0.02, 0.25] } else { [0.02, 0.98] };
        let mut chain = Chain { variances: [quiet, 16.0 * quiet], ends, lasts };
        let mut smoothed = chain.smoothed(squares);
        for _ in 0..ROUNDS {
            chain = chain.improved(squares, &smoothed);
            smoothed = chain.smoothed(squares);
        }
        (chain, smoothed)
    }

    /// The states one reading later.
    fn next(&self, states: [f64; 2]) -> [f64; 2] {
        let changed = [states[0] * self.ends[0], states[1] * self.ends[1]];
        [states[0] - changed[0] + changed[1], states[1] - changed[1] + changed[0]]
    }

    fn smoothed(&self, squares: &[f64]) -> Smoothed {
        let density = |square: &f64| {
            let of = |variance: f64| (-0.5 * square / variance).exp() / variance.sqrt();
            self.variances.map(|variance| of(variance).max(f64::MIN_POSITIVE))
        };
        let densities: States = squares.iter().map(density).collect();
        let loud = self.ends[0] / (self.ends[0] + self.ends[1]);
        let (mut state, mut log_likelihood) = ([1.0 - loud, loud], 0.0);
        let mut before = Vec::with_capacity(squares.len());
        for density in &densities {
            before.push(state);
            log_likelihood += (state[0] * density[0] + state[1] * density[1]).ln();
            state = self.next(product(state, *density));
        }
        let mut after = vec![[0.5; 2]; squares.len()];
        for k in (1..squares.len()).rev() {
            let [quiet, loud] = product(after[k], densities[k]);
            let of = |own: f64, other: f64, ends: f64| own * (1.0 - ends) + other * ends;
            after[k - 1] = product([of(quiet, loud, self.ends[0]), of(loud, quiet, self.ends[1])], [1.0; 2]);
        }
        Smoothed { densities, before, after, log_likelihood }
    }

    /// One round of Baum and Welch's estimate.
    fn improved(&self, squares: &[f64], smoothed: &Smoothed) -> Chain {
        let Smoothed { densities, before, after, .. } = smoothed;
        let (mut weight, mut sum, mut ended) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for (k, square) in squares.iter().enumerate() {
            let own = product(before[k], densities[k]);
            let state = product(own, after[k]);
            for s in 0..2 {
                weight[s] += state[s];
                sum[s] += state[s] * square;
            }
            let Some(next) = after.get(k + 1).map(|after| product(*after, densities[k + 1])) else {
                continue;
            };
            let pair = |from: usize, to: usize| {
                own[from] * next[to] * if from == to { 1.0 - self.ends[from] } else { self.ends[from] }
            };
            let changes = [pair(0, 1), pair(1, 0)];
            let all = pair(0, 0) + pair(1, 1) + changes[0] + changes[1];
            (0..2).for_each(|s| ended[s] += changes[s] / all.max(f64::MIN_POSITIVE));
        }
        let [quiet, loud] = [0, 1].map(|s| sum[s] / weight[s].max(1.0));
        let one = 1.0 / squares.len() as f64;
        let rate = |s: usize| ended[s] / weight[s].max(1.0);
        let ends = if self.lasts {
            let loud = rate(1).max(one).min(1.0 / LEAST_LENGTH);
            [rate(0).max(one).min(loud * MOST_PART / (1.0 - MOST_PART)), loud]
        } else {
            let part = (weight[1] * one).max(one).min(MOST_PART);
            [part, 1.0 - part]
        };
        Chain { variances: [quiet, loud.max(LEAST_FACTOR.powi(2) * quiet)], ends, ..*self }
    }
}

/// The product of two distributions over the states, of sum one.
fn product(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let product = [a[0] * b[0], a[1] * b[1]];
    let sum = (product[0] + product[1]).max(f64::MIN_POSITIVE);
    product.map(|p| p / sum)
}

/// How many times as large the noise of each reading is for the bursts in which it was read, by the squares of the residuals
/// in the order of time; none where they show no bursts. A reading has no part in the probability that it is in one, so that its
/// weight is independent of it.
pub fn louder(squares: &[f64]) -> Option<Vec<f64>> {
    // The median of squares is deaf to outliers; 0.455 is that of χ²₁.
    let quiet = median(&mut squares.to_vec()) / 0.455;
    if quiet.is_nan() || quiet <= 0.0 {
        return None;
    }
    let (chain, lasting) = Chain::estimated(squares, quiet, true);
    let (_, alone) = Chain::estimated(squares, quiet, false);
    if 2.0 * (lasting.log_likelihood - alone.log_likelihood) < VARIANCE_GAIN {
        return None;
    }
    let factor = (chain.variances[1] / chain.variances[0]).sqrt();
    let around = lasting.before.into_iter().zip(lasting.after);
    Some(around.map(|(before, after)| factor.powf(product(before, after)[1])).collect())
}

#[cfg(test)]
mod tests {
    use super::louder;
    use crate::correlation::tests::white;
    use crate::noise::estimate;

    /// Noise that is six times as large in four stretches of five readings of 400.
    fn with_bursts() -> Vec<f64> {
        let is_loud = |k: usize| k % 100 > 94;
        white(400, 11).iter().enumerate().map(|(k, e)| if is_loud(k) { 6.0 * e } else { *e }).collect()
    }

    fn sigma(y: &[f64]) -> Vec<f64> {
        let t_s: Vec<f64> = (0..y.len()).map(|k| k as f64).collect();
        estimate(y, &t_s, &[vec![1.0; y.len()]], &[], &[], &[]).sigma
    }

    #[test]
    fn readings_of_a_burst_count_less() {
        let sigma = sigma(&with_bursts());
        let mean = |rows: &dyn Fn(usize) -> bool| {
            let of: Vec<f64> = (0..400).filter(|k| rows(*k)).map(|k| sigma[k]).collect();
            numerics::mean(&of)
        };
        let (quiet, loud) = (mean(&|k| (5..90).contains(&(k % 100))), mean(&|k| k % 100 == 97));
        assert!((0.9..1.1).contains(&quiet), "{quiet}");
        assert!((4.0..8.0).contains(&loud), "{loud}");
    }

    #[test]
    fn neither_white_noise_nor_outliers_nor_a_step_are_bursts() {
        let constant = |y: &[f64]| {
            let sigma = sigma(y);
            sigma.iter().all(|s| (s / sigma[0] - 1.0).abs() < 1e-9)
        };
        assert!(constant(&white(400, 11)));
        let mut outliers = white(400, 11);
        outliers.iter_mut().step_by(50).for_each(|e| *e += 9.0);
        assert!(constant(&outliers));
        let mut held_up = white(400, 11);
        held_up.iter_mut().skip(200).take(10).for_each(|e| *e += 9.0);
        assert!(constant(&held_up));
    }

    #[test]
    fn a_reading_has_no_part_in_its_own_weight() {
        let squares = |y: Vec<f64>| y.iter().map(|e| e * e).collect::<Vec<f64>>();
        let was = squares(with_bursts());
        let mut is = was.clone();
        is[50] = 16.0;
        let [was, is] = [was, is].map(|squares| louder(&squares).unwrap()[50]);
        assert!((was - is).abs() < 0.02, "{was} {is}");
    }
}
