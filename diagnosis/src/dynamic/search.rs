//! Which effects: forward by screening and full refits, each chosen on rows that did not fit it, then
//! backward, and with exchanges. The way in which the drive runs between its samples is chosen anew with
//! every effect, since a missing effect can hide it.

mod exchange;
mod grow;

use super::data::{ALL, CHOOSE, Data, FOLDS};
use super::effects::{CATALOGUE, DynamicEffect, Part};
use super::estimate::{Fitted, PATIENCE, fit};
use super::model::Term;
use super::noise::autoregression;

/// −2 log likelihood that an effect has to gain where it is fitted: with some hundred candidates and starts
/// pure noise exceeds 30 (1 parameter, p ≈ 4·10⁻⁸ each) in less than one of 10⁵ recordings, and a further
/// parameter costs its own.
const LEAST_GAIN: f64 = 30.0;
/// The same for every parameter beyond the first.
const GAIN_PER_PARAMETER: f64 = 6.0;
/// Part of the residual's variance that an effect has to explain: below it the figures of the proof do not
/// change, and the integrator of whoever simulated the plant would be found.
const LEAST_PART: f64 = 0.003;
/// How often over an effect that acts seldom has to gain where it was fitted what others have to: the rows that
/// choose say little of it.
const SELDOM: f64 = 2.0;
/// Times that an effect is exchanged for another, at most.
const MOST_EXCHANGES: usize = 3;

/// Rows that fit.
pub const FIT_ROWS: [bool; FOLDS] = [true, false, false];
/// Rows that choose.
pub const CHOOSE_ROWS: [bool; FOLDS] = [false, true, false];

/// What a model gains over another on some rows, as −2 log likelihood of white noise.
pub fn gain(before: &Fitted, after: &Fitted, folds: [bool; FOLDS]) -> f64 {
    let rows: usize = (0..FOLDS).filter(|f| folds[*f]).map(|f| before.rows[f]).sum();
    let ratio = before.cost(folds).max(f64::MIN_POSITIVE) / after.cost(folds).max(f64::MIN_POSITIVE);
    rows as f64 * ratio.ln()
}

/// The search.
pub struct Search<'a> {
    /// The axis.
    pub data: &'a Data<'a>,
    /// The effects that may be named.
    pub catalogue: Vec<&'static dyn DynamicEffect>,
    /// Number of terms, the first ones, that the nominal plant has and that are not in question.
    pub given: usize,
}

impl<'a> Search<'a> {
    /// A search in the catalogue without the effects `skip`, beside a nominal plant of `given` terms.
    pub fn new(data: &'a Data<'a>, skip: &[String], given: usize) -> Search<'a> {
        let catalogue = CATALOGUE.iter().copied().filter(|e| skip.iter().all(|id| id != e.id())).collect();
        Search { data, catalogue, given }
    }

    /// The whitening filter of a model's residual.
    pub fn whitening(&self, fitted: &Fitted) -> Vec<f64> {
        let Ok(y) = fitted.positions(self.data) else { return Vec::new() };
        let residual: Vec<f64> = self.data.position.iter().zip(&y).map(|(a, b)| a - b).collect();
        autoregression(&residual, &self.data.runs).coefficients
    }

    /// Whether a term's parameters can be its effect.
    fn sound(&self, term: &Term) -> bool {
        let finite = term.parameters.iter().all(|v| v.is_finite());
        finite && term.effect.plausible(&term.parameters, &self.data.scale)
    }

    /// Whether the last effect of `after` is worth its parameters beside `before`.
    fn worth(&self, before: &Fitted, after: &Fitted) -> bool {
        let further = after.model.free().saturating_sub(before.model.free() + 1) as f64;
        let least = LEAST_GAIN + GAIN_PER_PARAMETER * further;
        let part = |folds| LEAST_PART * self.data.count(folds) as f64;
        let enough = |gain: &dyn Fn([bool; FOLDS]) -> f64| {
            let (fitted, chosen) = (gain(FIT_ROWS), gain(CHOOSE_ROWS));
            let plenty = fitted > least.max(part(FIT_ROWS));
            let there = (0.25 * least).max(part(CHOOSE_ROWS));
            let seldom = || {
                let due = self.due(before, after);
                due < there && chosen > due - 4.0 * due.sqrt()
            };
            plenty && (chosen > there || (fitted > SELDOM * least && seldom()))
        };
        // Noise that is alike in samples that follow counts for less than its rows.
        enough(&|folds| gain(before, after, folds))
            && self.white_gain(before, after).is_none_or(|gains| enough(&|folds| gains(folds)))
    }

    /// What a model gains over another on the rows that choose if it is right, give or take twice the root of it
    /// (one standard deviation): what acts seldom, as a limit that the drive reaches twice, may not act there at all.
    fn due(&self, before: &Fitted, after: &Fitted) -> f64 {
        let (Ok(old), Ok(new)) = (before.positions(self.data), after.positions(self.data)) else {
            return f64::INFINITY;
        };
        let rows = self.data.runs.iter().flat_map(|run| run.clone());
        let apart: f64 =
            rows.filter(|k| self.data.fold[*k] as usize == CHOOSE).map(|k| (old[k] - new[k]).powi(2)).sum();
        after.rows[CHOOSE] as f64 * (apart / after.costs[CHOOSE].max(f64::MIN_POSITIVE)).ln_1p()
    }

    /// What a model gains over another, as [`gain`], after both residuals have passed the filter that whitens
    /// the better one's; none where that is white already.
    fn white_gain(&self, before: &Fitted, after: &Fitted) -> Option<impl Fn([bool; FOLDS]) -> f64> {
        let whitening = self.whitening(after);
        if whitening.is_empty() {
            return None;
        }
        let costs = |f: &Fitted| -> Option<[f64; FOLDS]> {
            let y = f.positions(self.data).ok()?;
            let mut costs = [0.0; FOLDS];
            for run in &self.data.runs {
                for k in run.start + whitening.len()..run.end {
                    let at = |k: usize| self.data.position[k] - y[k];
                    let past: f64 = whitening.iter().enumerate().map(|(j, c)| c * at(k - 1 - j)).sum();
                    costs[self.data.fold[k] as usize] += (at(k) - past).powi(2);
                }
            }
            Some(costs)
        };
        let (old, new, rows) = (costs(before)?, costs(after)?, before.rows);
        Some(move |folds: [bool; FOLDS]| {
            let sum = |costs: &[f64; FOLDS]| (0..FOLDS).filter(|f| folds[*f]).map(|f| costs[f]).sum::<f64>();
            let rows: usize = (0..FOLDS).filter(|f| folds[*f]).map(|f| rows[f]).sum();
            rows as f64 * (sum(&old).max(f64::MIN_POSITIVE) / sum(&new).max(f64::MIN_POSITIVE)).ln()
        })
    }

    /// The effects beside the nominal plants (one per way of running between the samples), on the rows that
    /// fit and choose.
    pub fn run(&self, nominal: &Fitted) -> Fitted {
        let refit = |f: &Fitted| fit(&f.model, &f.states, self.data, FIT_ROWS, PATIENCE);
        let Some(mut present) = refit(nominal) else { return nominal.clone() };
        for _ in 0..MOST_EXCHANGES {
            present = self.grown(present);
            match self.exchanged(&present) {
                Some(better) => present = better,
                None => break,
            }
        }
        present
    }

    /// The model fitted to all rows.
    pub fn complete(&self, chosen: &Fitted) -> Fitted {
        fit(&chosen.model, &chosen.states, self.data, ALL, PATIENCE).unwrap_or_else(|| chosen.clone())
    }
}

/// Whether the effect makes the recording late.
fn is_late(effect: &dyn DynamicEffect) -> bool {
    matches!(effect.part(), Part::Delay | Part::DriveLag | Part::SensorLag)
}

/// Id of the last term.
pub fn last_id(fitted: &Fitted) -> &'static str {
    fitted.model.terms.last().map_or("", |t| t.effect.id())
}
