//! How much of its noise a row shares with the row before.
//!
//! What is left after projecting off angles and observables has a serial correlation and a variance of its
//! own, both smaller than those of the noise: the slow part of the noise is what a regression takes first.
//! So the same projection is applied to simulated noise of known correlation, and the correlation that
//! leaves what was seen is the estimate (indirect inference: Gouriéroux, Monfort & Renault 1993).

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::design::Design;

/// First-order autocorrelation and marginal variance of the noise.
pub(super) struct Memory {
    pub correlation: f64,
    pub variance: f64,
}

/// Above so many rows the projection changes next to nothing.
const SIMULATED_ROWS: usize = 5000;
/// Correlations that are simulated, and how often each.
const GRID: [f64; 8] = [0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.87, 0.95];
const REPEATS: usize = 24;

impl Memory {
    /// From `left`, the residual after the regression on `columns`, with its degrees of freedom.
    pub fn of(
        design: &Design,
        columns: &[&DVector<f64>],
        inverse: &DMatrix<f64>,
        left: &DVector<f64>,
        freedom: f64,
    ) -> Memory {
        let rows = left.len();
        let uncorrelated = Memory { correlation: 0.0, variance: left.norm_squared() / freedom };
        let seen = serial(left);
        let error = 1.0 / (rows as f64).sqrt();
        if rows > SIMULATED_ROWS {
            // One standard error on top, here and below: slow noise that is taken for fast passes for a
            // dependence, and not the other way round.
            let correlation = if seen > 2.0 * error { (seen + error).min(0.98) } else { 0.0 };
            return Memory { correlation, ..uncorrelated };
        }
        let curve: Vec<(f64, f64)> =
            GRID.iter().map(|rho| simulated(design, columns, inverse, *rho)).collect();
        if seen < curve[0].0 + 2.0 * error {
            return uncorrelated;
        }
        let cautious = seen + error;
        let above = curve.iter().position(|(serial, _)| *serial >= cautious).unwrap_or(GRID.len() - 1).max(1);
        let (low, high) = (curve[above - 1], curve[above]);
        let share = ((cautious - low.0) / (high.0 - low.0).max(1e-9)).clamp(0.0, 1.0);
        let between = |a: f64, b: f64| a + share * (b - a);
        Memory {
            correlation: between(GRID[above - 1], GRID[above]),
            variance: left.norm_squared() / between(low.1, high.1),
        }
    }
}

/// Lag-one autocorrelation.
fn serial(values: &DVector<f64>) -> f64 {
    let products: f64 = (1..values.len()).map(|row| values[row] * values[row - 1]).sum();
    products / values.norm_squared().max(f64::MIN_POSITIVE)
}

/// Mean serial correlation and mean sum of squares that the projections leave of first-order noise of
/// variance 1.
fn simulated(
    design: &Design,
    columns: &[&DVector<f64>],
    inverse: &DMatrix<f64>,
    correlation: f64,
) -> (f64, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let fresh = (1.0 - correlation * correlation).sqrt();
    let (mut serials, mut squares) = (0.0, 0.0);
    for _ in 0..REPEATS {
        let mut before = normal(&mut random);
        let mut noise = DVector::from_fn(design.residual.len(), |_, _| {
            let now = before;
            before = correlation * before + fresh * normal(&mut random);
            now
        });
        design.project(&mut noise);
        let left = design.without(columns, inverse, noise);
        serials += serial(&left);
        squares += left.norm_squared();
    }
    (serials / REPEATS as f64, squares / REPEATS as f64)
}

/// About standard normal: the sum of twelve uniform numbers less 6, whose first moments are all that counts
/// here.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let uniform = |word: u32| f64::from(word) / 4_294_967_296.0;
    (0..12).map(|_| uniform(random.next_u32())).sum::<f64>() - 6.0
}
