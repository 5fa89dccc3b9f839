//! Which effects: forward by screening and full refits, each chosen on rows that did not fit it, then
//! backward, and with exchanges. The way in which the drive runs between its samples is chosen anew with
//! every effect, since a missing effect can hide it.

use rayon::prelude::*;

use super::data::{ALL, CHOOSE, Data, FIT, FOLDS, HOLDS};
use super::effects::{CATALOGUE, DynamicEffect, Part};
use super::estimate::{Fitted, PATIENCE, fit};
use super::model::{MOST_TERMS, Model, Term};
use super::noise::autoregression;
use super::screen::{Candidate, Screened, screen};

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
/// Effects that are refitted in full in every round.
const REFITTED: usize = 8;
/// Further effects that are refitted for what they explain before whitening.
const REFITTED_PLAINLY: usize = 2;
/// A term without which the squared residual grows by more than this factor is beyond doubt.
const STRONG: f64 = 10.0;
/// A model whose squared residual is within this factor of the best may be the better one on more rows.
const CLOSE: f64 = 1.15;
/// Times that an effect is exchanged for another, at most.
const MOST_EXCHANGES: usize = 3;
/// Steps after which contenders are compared, and the factor of the squared residual by which one is out.
const HEAT: usize = 8;
const BEHIND: f64 = 4.0;
/// Steps of an estimate of a start.
const SHORT: usize = 4;

/// The delay to which a lag is equal to first order.
const DELAY: &str = "transport_delay";

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

    /// Candidates that may stand beside a model.
    fn candidates(&self, present: &Fitted) -> Vec<Candidate> {
        self.catalogue
            .iter()
            .filter(|e| !present.model.has(e.id()))
            .flat_map(|e| {
                let start = |start| Candidate { effect: *e, start };
                e.starts(&self.data.scale).into_iter().map(start)
            })
            .collect()
    }

    /// Every effect beside a model, fitted on the rows that fit: the best few by screening in full, sorted
    /// by what they leave on the rows that choose.
    pub fn contenders(&self, present: &Fitted) -> Vec<Fitted> {
        let candidates = self.candidates(present);
        let whitening = self.whitening(present);
        let [screened, mut plain] = screen(present, &candidates, self.data, [&whitening, &[]]);
        let mut best: Vec<Screened> = Vec::new();
        for effect in &self.catalogue {
            let own = screened.iter().filter(|s| candidates[s.candidate].effect.id() == effect.id());
            let mut own: Vec<&Screened> = own.collect();
            own.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            best.extend(own.into_iter().take(2).cloned());
        }
        // To first order a lag is a delay: it is tried only where a delay helps.
        let late = candidates.iter().all(|c| c.effect.id() != DELAY)
            || best.iter().any(|s| candidates[s.candidate].effect.id() == DELAY && s.gain > 0.3 * LEAST_GAIN);
        // What has no amount (a lag, a limit) is tried by a short estimate.
        let short: Vec<Screened> = candidates
            .par_iter()
            .enumerate()
            .filter(|(_, c)| !c.linear() && (late || !c.effect.confused_with().contains(&DELAY)))
            .filter_map(|(k, c)| {
                let model = present.model.with(Term::new(c.effect, c.start.clone()));
                let fitted = fit(&model, &present.states, self.data, FIT_ROWS, SHORT)?;
                Some(Screened {
                    candidate: k,
                    gain: gain(present, &fitted, FIT_ROWS),
                    held_out: gain(present, &fitted, CHOOSE_ROWS),
                })
            })
            .collect();
        best.extend(short);
        best.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut ids: Vec<&str> = Vec::new();
        best.retain(|s| {
            let id = candidates[s.candidate].effect.id();
            let new = !ids.contains(&id);
            if new {
                ids.push(id);
            }
            s.gain > 0.3 * LEAST_GAIN && (ids.len() <= REFITTED || !new)
        });
        if !whitening.is_empty() {
            // A residual that is nearly constant, or a few tones, is predicted by its own past, and with it what
            // explains it: the best by plain gain are tried besides. What is worth its parameters is decided later.
            plain.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            let mut ids: Vec<&str> = best.iter().map(|s| candidates[s.candidate].effect.id()).collect();
            let most = best.len() + REFITTED_PLAINLY;
            for s in plain.into_iter().filter(|s| s.gain > 0.3 * LEAST_GAIN) {
                let id = candidates[s.candidate].effect.id();
                if !ids.contains(&id) && best.len() < most {
                    ids.push(id);
                    best.push(s);
                }
            }
        }
        let mut models: Vec<Model> = best
            .iter()
            .map(|s| {
                let Candidate { effect, start } = candidates[s.candidate].clone();
                present.model.with(Term::new(effect, start))
            })
            .collect();
        models.extend(self.late(present, &candidates));
        let tried: Vec<Fitted> = models
            .par_iter()
            .filter_map(|model| fit(model, &present.states, self.data, FIT_ROWS, HEAT))
            .collect();
        // What is far behind after a few steps is not followed to its end.
        let least = tried.iter().map(|f| f.costs[FIT]).fold(f64::INFINITY, f64::min);
        let fits: Vec<Fitted> = tried
            .into_par_iter()
            .filter_map(|f| match f.costs[FIT] < BEHIND * least {
                true => fit(&f.model, &f.states, self.data, FIT_ROWS, PATIENCE - HEAT),
                false => Some(f),
            })
            .filter(|f| f.model.terms.last().is_some_and(|term| self.sound(term)))
            .collect();
        let mut of_effect: Vec<Fitted> = Vec::new();
        for f in fits {
            let id = last_id(&f);
            match of_effect.iter_mut().find(|g| last_id(g) == id) {
                Some(g) if f.costs[FIT] < g.costs[FIT] => *g = f,
                Some(_) => {}
                None => of_effect.push(f),
            }
        }
        of_effect.sort_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE]));
        of_effect
    }

    /// Delays and lags beside the other ways of running between the samples. A held drive is half a sample late:
    /// where the nominal plant took that for a delay of less, the true one beside it would be negative.
    fn late(&self, present: &Fitted, candidates: &[Candidate]) -> Vec<Model> {
        if present.model.terms.iter().any(|t| is_late(t.effect)) {
            return Vec::new();
        }
        let mut models = Vec::new();
        for hold in HOLDS.into_iter().filter(|h| *h != present.model.hold) {
            let mut ids = Vec::new();
            for candidate in candidates.iter().filter(|c| is_late(c.effect)) {
                if !ids.contains(&candidate.effect.id()) {
                    ids.push(candidate.effect.id());
                    let mut model = present.model.with(Term::new(candidate.effect, candidate.start.clone()));
                    model.hold = hold;
                    models.push(model);
                }
            }
        }
        models
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
        let apart: f64 = rows
            .filter(|k| self.data.fold[*k] as usize == CHOOSE)
            .map(|k| (old[k] - new[k]).powi(2))
            .sum();
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

    /// The model with the best way of running between the samples.
    fn best_hold(&self, present: Fitted, folds: [bool; FOLDS]) -> Fitted {
        let others: Vec<Fitted> = HOLDS
            .par_iter()
            .filter(|h| **h != present.model.hold)
            .filter_map(|hold| {
                let mut model = present.model.clone();
                model.hold = *hold;
                fit(&model, &present.states, self.data, folds, PATIENCE)
            })
            .collect();
        others.into_iter().fold(present, |best, f| if f.cost(folds) < best.cost(folds) { f } else { best })
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

    fn grown(&self, mut present: Fitted) -> Fitted {
        while present.model.terms.len() < MOST_TERMS {
            let worthy: Vec<Fitted> =
                self.contenders(&present).into_iter().filter(|f| self.worth(&present, f)).collect();
            let Some(next) = self.simplest(&worthy) else { break };
            let next = self.best_hold(next.clone(), FIT_ROWS);
            present = self.creeping(self.pruned(next));
        }
        present
    }

    /// The model without terms that all rows together drive to where they are no physics, and with an effect in the
    /// place of another where that does better then.
    pub fn settled(&self, chosen: Fitted) -> Fitted {
        let mut chosen = chosen;
        for _ in 0..MOST_EXCHANGES {
            let all = self.complete(&chosen);
            let Some(k) = (self.given..all.model.terms.len()).find(|k| !self.sound(&all.model.terms[*k]))
            else {
                break;
            };
            let Some(shorter) = fit(&chosen.model.without(k), &chosen.states, self.data, FIT_ROWS, PATIENCE)
            else {
                break;
            };
            let shorter = self.best_hold(shorter, FIT_ROWS);
            let others = self
                .near(&shorter, |t, _| is_late(t.effect))
                .into_iter()
                .map(|f| self.best_hold(f, FIT_ROWS));
            let others: Vec<Fitted> = others.collect();
            chosen = others
                .into_iter()
                .fold(shorter, |best, f| if f.costs[CHOOSE] < best.costs[CHOOSE] { f } else { best });
        }
        chosen
    }

    /// A better model with a delay or lag in the place of another, or without a term that others have driven to
    /// where it is no physics (a delay before its cause): to first order the three are one, which was taken was
    /// decided beside less, and a later term may be there only to mend it.
    fn exchanged(&self, present: &Fitted) -> Option<Fitted> {
        let terms = &present.model.terms[self.given..];
        let unsound: Vec<usize> = (0..terms.len()).filter(|k| !self.sound(&terms[*k])).collect();
        let lags = terms.iter().any(|t| is_late(t.effect));
        if unsound.is_empty() && (terms.len() < 2 || !lags) {
            return None;
        }
        let mut others: Vec<Fitted> = self
            .near(present, |t, _| is_late(t.effect))
            .into_iter()
            .map(|f| self.pruned(self.best_hold(f, FIT_ROWS)))
            .collect();
        others.extend(unsound.iter().filter_map(|k| {
            let shorter = present.model.without(self.given + k);
            let shorter = fit(&shorter, &present.states, self.data, FIT_ROWS, PATIENCE)?;
            Some(self.best_hold(shorter, FIT_ROWS))
        }));
        let better = |f: &Fitted| {
            let fewer = present.model.free() as f64 - f.model.free() as f64;
            let lost = gain(f, present, CHOOSE_ROWS);
            let close = f.costs[CHOOSE] < CLOSE * present.costs[CHOOSE];
            let simpler = fewer > 0.0 && lost < 2.0 + 4.0 * fewer;
            let nearer = fewer >= 0.0 && lost < -LEAST_GAIN && gain(f, present, FIT_ROWS) < -LEAST_GAIN;
            f.model.terms[self.given..].iter().all(|t| self.sound(t))
                && (simpler || nearer || (!unsound.is_empty() && close))
        };
        others.retain(better);
        others.into_iter().min_by(|a, b| {
            let merit = |f: &Fitted| gain(f, present, CHOOSE_ROWS) + 4.0 * f.model.free() as f64;
            merit(a).total_cmp(&merit(b))
        })
    }

    /// The model with the creep of its dry friction freed, where the recording shows it.
    fn creeping(&self, present: Fitted) -> Fitted {
        let Some(k) = present.model.terms.iter().position(|t| t.effect.creep().is_some()) else {
            return present;
        };
        let Some(creep) = present.model.terms[k].effect.creep() else { return present };
        let freed: Vec<Fitted> = [3e-4, 3e-3, 3e-2]
            .par_iter()
            .filter_map(|part| {
                let mut model = present.model.clone();
                model.terms[k].parameters[creep] = part * self.data.scale.speed;
                model.terms[k].free[creep] = true;
                fit(&model, &present.states, self.data, FIT_ROWS, PATIENCE)
            })
            .collect();
        let best = freed.into_iter().min_by(|a, b| a.costs[FIT].total_cmp(&b.costs[FIT]));
        match best {
            Some(f) if self.worth(&present, &f) => f,
            _ => present,
        }
    }

    /// The best contender, or a simpler one that does as well.
    fn simplest<'b>(&self, contenders: &'b [Fitted]) -> Option<&'b Fitted> {
        let best = contenders.first()?;
        let near = |f: &&Fitted| {
            let more = best.model.free().saturating_sub(f.model.free()) as f64;
            f.model.free() <= best.model.free() && gain(f, best, CHOOSE_ROWS) < 2.0 + 4.0 * more
        };
        contenders.iter().filter(near).min_by_key(|f| (f.model.free(), self.rank(last_id(f))))
    }

    fn rank(&self, id: &str) -> usize {
        self.catalogue.iter().position(|e| e.id() == id).unwrap_or(usize::MAX)
    }

    /// The model without the terms that a later one has made idle.
    fn pruned(&self, mut present: Fitted) -> Fitted {
        while present.model.terms.len() > 1 + self.given {
            let last = present.model.terms.len() - 1;
            let shorter: Vec<Fitted> = (self.given..last)
                .into_par_iter()
                .filter_map(|k| {
                    fit(&present.model.without(k), &present.states, self.data, FIT_ROWS, PATIENCE)
                })
                .filter(|f| !self.worth(f, &present))
                .collect();
            match shorter.into_iter().min_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE])) {
                Some(f) => present = f,
                None => break,
            }
        }
        present
    }

    /// Models in which one weak term is replaced by an effect that it is easily taken for, and which do
    /// nearly as well on these windows: more rows have to decide.
    pub fn rivals(&self, chosen: &Fitted) -> Vec<Model> {
        self.near(chosen, |_, growth| growth <= STRONG).into_iter().map(|f| f.model).collect()
    }

    /// Models in which one term is replaced, fitted: one for which `may` holds, given the factor by which the squared
    /// residual grows without it.
    fn near(&self, chosen: &Fitted, may: impl Fn(&Term, f64) -> bool) -> Vec<Fitted> {
        let mut near = Vec::new();
        for k in self.given..chosen.model.terms.len() {
            let Some(without) = fit(&chosen.model.without(k), &chosen.states, self.data, FIT_ROWS, PATIENCE)
            else {
                continue;
            };
            if !may(&chosen.model.terms[k], without.costs[CHOOSE] / chosen.costs[CHOOSE]) {
                continue;
            }
            let ids = chosen.model.terms[k].effect.confused_with();
            let catalogue = self.catalogue.iter().copied().filter(|e| ids.contains(&e.id())).collect();
            let contenders = Search { data: self.data, catalogue, given: self.given }.contenders(&without);
            near.extend(contenders.into_iter().filter(|f| f.costs[CHOOSE] < CLOSE * chosen.costs[CHOOSE]));
        }
        near
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
