//! What any detector can reach that does not know which effect to look for: one that knows the true covariance
//! of the noise and the formulas of the table, but neither the effect nor its nonlinear parameters. Between it
//! and the matched filter lies the price of searching; between it and the answers what is lost by estimating
//! the noise, and by looking for what no table holds.
//!
//! The recording is whitened by the truth and projected off the base model. A family is one formula over its
//! grid; the statistic is its most significant place, calibrated family by family on noise drawn from the true
//! distribution, so that a formula of many places does not drown one of a single place; an alarm is the best
//! family beyond what 1 % of further draws reach.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use twin::{Noise, Truth, noise_covariance};

use crate::formulas::{Columns, FORMULAS, Formula};
use crate::linear::{Basis, Whitener, dot};
use crate::statistics::{phi, standard_normal};

/// Strength below which trials are shown to it: beyond, nobody misses anything.
pub const FAINT: f64 = 10.0;
/// False alarms of the detector.
pub const FALSE_ALARMS: f64 = 0.01;
/// Draws of noise for the families' tails, and as many for the best family.
const DRAWS: usize = 300;
/// Part of the draws that a tail is fitted to.
const TAIL: f64 = 0.2;

/// P(m) = part · e^(−slope (m − from)) beyond `from`.
#[derive(Clone, Copy)]
struct Tail {
    from: f64,
    slope: f64,
}

impl Tail {
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let kept = (values.len() as f64 * TAIL) as usize;
        let from = values[values.len() - kept - 1];
        let excess: f64 = values[values.len() - kept..].iter().map(|v| v - from).sum();
        Self { from, slope: kept as f64 / excess.max(1e-9) }
    }

    /// −ln of the probability to exceed `m`.
    fn surprise(self, m: f64) -> f64 {
        -TAIL.ln() + self.slope * (m - self.from)
    }

    /// The value that is exceeded with the probability `p`.
    fn at(self, p: f64) -> f64 {
        self.from + (TAIL / p).ln() / self.slope
    }
}

/// Orthonormal columns of every place of every formula, outside the base.
struct Families(Vec<Vec<Basis>>);

impl Families {
    fn new(columns: &Columns, whitener: &Whitener, base: &Basis) -> Self {
        let family = |formula: &'static Formula| -> Vec<Basis> {
            let places = (formula.grid)(columns).places;
            places
                .iter()
                .filter_map(|place| {
                    let mut own = Basis::default();
                    for column in (formula.signature)(columns, place) {
                        let white = whitener.whiten(&column);
                        let left = base.residual(&white);
                        // What the base model follows to a thousandth is the rounding of the observable.
                        if dot(&left, &left) > 1e-6 * dot(&white, &white) {
                            own.push(&left);
                        }
                    }
                    (own.rank() > 0).then_some(own)
                })
                .collect()
        };
        Self(FORMULAS.iter().map(family).filter(|places| !places.is_empty()).collect())
    }

    /// Every family's largest −ln P(χ² > what a place explains).
    fn statistics(&self, target: &[f64]) -> Vec<f64> {
        let of = |place: &Basis| {
            let explained = place.square_of(target);
            match place.rank() {
                1 => -(2.0 * phi(-explained.sqrt())).max(1e-300).ln(),
                _ => 0.5 * explained,
            }
        };
        self.0.iter().map(|family| family.iter().map(of).fold(0.0, f64::max)).collect()
    }
}

/// What the detector knows.
pub struct Known<'a> {
    /// What was true beside each reading.
    pub truths: &'a [Truth],
    pub noise: &'a Noise,
    pub distance_mm: f64,
}

/// Whether the detector finds something in a recording; none where the covariance of its noise is not positive
/// definite. `seed` is that of its draws.
pub fn detects(columns: &Columns, known: &Known, seed: u64) -> Option<bool> {
    let whitener = Whitener::new(&noise_covariance(known.truths, known.noise), columns.rows())?;
    let mut base = Basis::default();
    for column in columns.base(columns.half_mm(), known.distance_mm) {
        base.push(&whitener.whiten(&column));
    }
    let families = Families::new(columns, &whitener, &base);
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    let mut draw = || base.residual(&white_noise(known, &mut generator));
    let first: Vec<Vec<f64>> = (0..DRAWS).map(|_| families.statistics(&draw())).collect();
    let tails: Vec<Tail> =
        (0..families.0.len()).map(|f| Tail::of(first.iter().map(|s| s[f]).collect())).collect();
    let best = |statistics: Vec<f64>| {
        let surprises = statistics.iter().zip(&tails).map(|(m, tail)| tail.surprise(*m));
        surprises.fold(f64::NEG_INFINITY, f64::max)
    };
    let nulls = Tail::of((0..DRAWS).map(|_| best(families.statistics(&draw()))).collect());
    let seen = base.residual(&whitener.whiten(&columns.error_arcsec));
    Some(best(families.statistics(&seen)) > nulls.at(FALSE_ALARMS))
}

/// Whitened noise of the true distribution: standard normal, but for outliers, of which the covariance knows
/// only the mean square.
fn white_noise(known: &Known, generator: &mut ChaCha12Rng) -> Vec<f64> {
    let usual = known.noise.outlier_variance().sqrt();
    known
        .truths
        .iter()
        .map(|truth| {
            let larger = match *known.noise {
                Noise::Outliers { share, factor } if generator.random_bool(share) => factor,
                _ => 1.0,
            };
            let deviation = truth.probe_noise_arcsec.hypot(truth.optics_noise_arcsec / usual * larger);
            standard_normal(generator) * deviation / truth.noise_arcsec()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use crate::draw::Trial;
    use crate::plan::Assignment;
    use crate::truth::Group;

    fn found(group: Group) -> usize {
        let assignments =
            (0..12).map(|number| Assignment { group, number, seed: 300 + number as u64, cell: None });
        let trials = assignments.map(|a| Trial::draw(&a, "r.csv".to_owned()).unwrap());
        trials.filter(|trial| trial.benchmark() == Some(true)).count()
    }

    /// Of twelve recordings of nothing two raise an alarm of 1 % once in 160 times; what has ρ ≥ 8 lies four
    /// standard deviations above any threshold for a thousand places.
    #[test]
    #[ignore = "takes long: in .ci/full"]
    fn the_detector_is_quiet_on_nothing_and_misses_nothing_strong() {
        assert!(found(Group::Null) <= 1);
        assert_eq!(found(Group::Strong), 12);
    }

    /// Prints how far the detector lies from the matched filter, without anything being diagnosed:
    /// `cargo test --release -p trials --lib benchmark -- --ignored --nocapture`.
    #[test]
    #[ignore = "a minute of two processors"]
    fn the_price_of_searching() {
        let points: Vec<(f64, bool)> = (0..120usize)
            .into_par_iter()
            .filter_map(|number| {
                let assignment =
                    Assignment { group: Group::Weak, number, seed: 9_000 + number as u64, cell: None };
                let trial = Trial::draw(&assignment, "r.csv".to_owned()).unwrap();
                Some((trial.truth.least_rho(), trial.benchmark()?))
            })
            .collect();
        let curve = crate::curve::fit(&points, super::FALSE_ALARMS).unwrap();
        println!("shift {:.2}, half at {:.2}, width {:.2}", curve.shift, curve.half, curve.width);
        for bin in &curve.bins {
            println!("{} to {}: {} of {}", bin.from, bin.to, bin.hits, bin.of);
        }
        assert!(curve.shift > 0.0, "better than a filter that is told the effect");
    }
}
