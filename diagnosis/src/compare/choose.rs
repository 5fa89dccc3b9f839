//! Which parts of the common model differ between the recordings: the fewest beside which nothing else does.

use numerics::{mean, rms};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::erf::erfc;

use crate::calibrate::log_tail;
use crate::correlation::Process;
use crate::intervals::widening;
use crate::noise::Noise;
use crate::thresholds::NORMAL_95;
use crate::thresholds::compare::{ALTERNATIVE, FALSE_ALARMS, POWER};

use super::design::{Design, What, White};
use super::proof::Proof;
use super::stepwise::{Step, stepwise};

/// A part that differs.
pub struct Chosen {
    /// What.
    pub what: What,
    /// Its family-wise p-value beside the others that differ.
    pub p_value: f64,
    /// Others that would do nearly as well in its place.
    pub alternatives: Vec<What>,
    /// How held-out rows show it, once that was asked.
    pub proof: Option<Proof>,
}

/// How many differences are tested in all: every part that may differ, and the noise.
pub fn tests_of(design: &Design) -> usize {
    (0..design.parts.len()).filter(|part| design.may_differ(*part)).count() + 1
}

/// The parts that differ.
pub fn choose(design: &Design, white: &White, freedom: f64) -> Vec<Chosen> {
    let tests = tests_of(design);
    let what = |part: usize| design.parts[part].what;
    let steps = stepwise(
        |changed| surprises(design, white, changed, freedom),
        |tails| strongest(design, tails),
        |part, surprise| family_wise(design, what(part), surprise, tests),
    );
    let chosen = |step: Step| Chosen {
        what: what(step.number),
        p_value: step.p_value,
        alternatives: step.alternatives.into_iter().map(what).collect(),
        proof: None,
    };
    steps.into_iter().map(chosen).collect()
}

/// The part whose difference is least likely by chance; in the place of the base an effect that does nearly as well: the base
/// takes what no effect explains.
fn strongest(design: &Design, tails: &[f64]) -> Option<usize> {
    let of = |wanted: &dyn Fn(usize) -> bool| {
        (0..tails.len()).filter(|k| wanted(*k)).max_by(|a, b| tails[*a].total_cmp(&tails[*b]))
    };
    let best = of(&|_| true)?;
    let effect = of(&|k| design.parts[k].what.effect().is_some());
    Some(effect.filter(|k| tails[*k] > tails[best] - ALTERNATIVE).unwrap_or(best))
}

/// −ln of the p-value that each part differs, beside those that do.
fn surprises(design: &Design, white: &White, changed: &[usize], freedom: f64) -> Vec<f64> {
    let wide = widening(freedom).powi(2);
    design
        .explained(white, changed)
        .into_iter()
        .map(|(explained, rank)| log_tail(explained / wide, rank))
        .collect()
}

/// The p-value over all that is looked for. What was found in one recording only was looked for there, too.
fn family_wise(design: &Design, what: What, surprise: f64, tests: usize) -> f64 {
    let own = (tests as f64 * (-surprise).exp()).min(1.0);
    let What::Amplitude(k) = what else { return own };
    let shared = &design.shared[k];
    match shared.found {
        [Some(p), None] | [None, Some(p)] => own.max(p),
        _ => shared.together.map_or(own, |p| own.max(p)),
    }
}

/// The length, in standard deviations, of a difference of `rank` degrees of freedom that is found in 95 of 100 recordings
/// (Fisher's normal approximation of the root of a χ² value).
pub fn visible(rank: usize, tests: usize) -> f64 {
    let quantile = ChiSquared::new(rank.max(1) as f64)
        .map_or(f64::NAN, |c| c.inverse_cdf(1.0 - FALSE_ALARMS / tests as f64));
    ((quantile.sqrt() + POWER).powi(2) - rank as f64 + 0.5).max(0.0).sqrt()
}

/// The noise of the later recording over that of the earlier, outliers apart, with its 95 % interval and the p-value that they
/// are equal.
pub fn noise_ratio(noise: &[Noise; 2]) -> (f64, [f64; 2], f64) {
    let error = noise.iter().map(|noise| log_level_error(noise).powi(2)).sum::<f64>().sqrt();
    let log = (noise[1].level / noise[0].level).ln();
    let p = erfc(log.abs() / error * std::f64::consts::FRAC_1_SQRT_2);
    (log.exp(), [(log - NORMAL_95 * error).exp(), (log + NORMAL_95 * error).exp()], p)
}

/// Standard error of the logarithm of the level. The variance of a variance is taken from the fourth moment of what is left;
/// slow noise has a level that depends on how slow it is, of which the posterior knows how well it is known.
fn log_level_error(noise: &Noise) -> f64 {
    let squares: Vec<f64> = noise.whitened_residual.iter().map(|r| r * r).collect();
    let fourth: Vec<f64> = squares.iter().map(|s| s * s).collect();
    let of_rows = 0.25 * (mean(&fourth) / mean(&squares).powi(2) - 1.0).max(2.0) / noise.freedom.max(1.0);
    let coloured = noise.correlation.colour(noise.whitened_residual.iter().copied());
    let level = |process: &Process| {
        rms(&noise.correlation.with(process).whiten(coloured.iter().copied())).max(f64::MIN_POSITIVE).ln()
    };
    let levels: Vec<(f64, f64)> =
        noise.posterior.iter().map(|(process, weight)| (level(process), *weight)).collect();
    let centre: f64 = levels.iter().map(|(level, weight)| level * weight).sum();
    let of_process: f64 = levels.iter().map(|(level, weight)| weight * (level - centre).powi(2)).sum();
    (of_rows + of_process).sqrt()
}
