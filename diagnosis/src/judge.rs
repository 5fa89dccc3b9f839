//! The answer is held against itself before it is written, with the code that `apply` runs and on every reading: what
//! the named effects' parameters, the handed-on model and the verdict claim must agree with each other. What does not
//! is withdrawn, and said.

use std::sync::OnceLock;

use fitter::Coefficients;
use numerics::{centred, dot, rms};

use crate::diagnosis::NoiseFloor;
use crate::effects::{Effect, Reading};
use crate::explain::{Explanation, first_order};
use crate::hand_on::HandOn;
use crate::held_out::{Choice, Groups, Proof, Shown, gain, prove};
use crate::lasting::Lasting;
use crate::model::{self, FittedTerm, Model, choose_order};
use crate::search::Term;
use crate::thresholds::judge::{
    ABOVE_ACCURACY, BESIDE, BOUNDLESS, FOLLOWED, OF_FITTED, OF_HELD_OUT, OF_ONE_STEP, OF_OTHERS, REMEMBERS,
};
use crate::thresholds::{AT_FLOOR, NO_WORSE};
use crate::undecided::Weighted;
use crate::verdict::Verdict;

/// What is said where named effects are not handed on.
const NOT_SHOWN: &str = "the base alone is handed on: held-out rows do not show that the effects hold \
    beyond the rows that they were fitted to";

/// An answer that agrees with itself.
pub struct Settled {
    /// Base, kept effects and structure without a name, fitted jointly: what is said of effects and places.
    pub joint: Model,
    /// Base and kept effects: what is handed on.
    pub handed: Model,
    /// It as it was refitted.
    pub refitted: Coefficients,
    /// Models with other effects in the place of some of its terms: what is handed on is the mean of all of them.
    pub instead: Vec<Weighted>,
    /// What is handed on leaves of every reading.
    pub left: Vec<f64>,
    /// What it leaves of held-out readings; none where nothing can be held out.
    pub shown: Option<Shown>,
    /// Effects that were found and withdrawn.
    pub withdrawn: Vec<FittedTerm>,
    /// What was done, a sentence each.
    pub judged: Vec<String>,
    /// What other recordings would have to tell apart, a sentence each.
    pub ambiguous: Vec<String>,
}

/// A model that may be handed on, as it was refitted, with what it leaves and shows.
pub struct Handed {
    /// The model.
    pub model: Model,
    /// It as it was refitted.
    pub refitted: Coefficients,
    /// What it leaves of every reading, in the recording's unit.
    pub left: Vec<f64>,
    /// What it leaves of held-out readings; none where nothing can be held out.
    pub shown: Option<Shown>,
}

/// What is judged, and with what.
pub struct Judge<'a, 'b> {
    /// What was found.
    pub explanation: &'b Explanation<'a>,
    /// The same recording with forms among the effects, where that was searched.
    pub with_forms: Option<&'b Explanation<'a>>,
    /// The effects.
    pub catalogue: &'b [Effect],
    /// How a model is handed on.
    pub hand_on: &'b HandOn<'b>,
    /// The base alone.
    pub before: &'b Model,
    /// It as it was refitted, and what it leaves of every reading.
    pub before_refitted: &'b Coefficients,
    pub before_left: &'b [f64],
    /// The held-out passes; none where nothing can be held out.
    pub proof: Option<&'b Proof<'a>>,
    /// The held-out blocks, made where they are needed.
    pub blocks: OnceLock<Option<Proof<'a>>>,
}

impl<'a> Judge<'a, '_> {
    /// Withdraws effects until the answer agrees with itself; the base alone always does.
    pub fn settle(&self) -> Settled {
        let search = &self.explanation.search;
        let is_named = |t: &&Term| search.effect(t.family).is_some();
        let mut named: Vec<Term> = self.explanation.terms.iter().filter(is_named).cloned().collect();
        let unnamed: Vec<Term> = self.explanation.terms.iter().filter(|t| !is_named(t)).cloned().collect();
        let (mut judged, mut withdrawn) = (Vec::new(), Vec::new());
        loop {
            let all: Vec<Term> = named.iter().chain(&unnamed).cloned().collect();
            let mut joint = if all.is_empty() {
                self.before.clone()
            } else {
                model::fit(self.explanation, self.catalogue, &all, None)
            };
            if named.is_empty() {
                return self.base_alone(joint, withdrawn, judged);
            }
            let fault = match self.undetermined(&joint) {
                Some(fault) => Some(fault),
                None => match self.handed(&joint, &named, withdrawn.is_empty()) {
                    Ok(handed) if !self.shows_gain(&handed, &joint) => {
                        self.extend_intervals(&mut joint, &mut judged);
                        judged.push(NOT_SHOWN.into());
                        return self.base_alone(joint, withdrawn, judged);
                    }
                    Ok(handed) => {
                        let mut kept = named.clone();
                        self.keep_beyond_noise(&mut kept, &joint, &mut judged);
                        self.keep_no_single_steps(&mut kept, &mut judged);
                        self.keep_what_others_get(&mut kept, &joint, &mut judged);
                        let undecided = self.undecided(&mut kept, &joint);
                        let Some(handed) = self.only(handed, &kept, named.len()) else {
                            self.extend_intervals(&mut joint, &mut judged);
                            let ambiguous = undecided.said;
                            return Settled { ambiguous, ..self.base_alone(joint, withdrawn, judged) };
                        };
                        self.as_handed_on(&mut joint, &handed.model, &handed.refitted);
                        self.extend_intervals(&mut joint, &mut judged);
                        let (Handed { model: handed, refitted, left, shown }, instead) =
                            self.mean(handed, undecided.instead);
                        let ambiguous = undecided.said;
                        return Settled {
                            joint,
                            handed,
                            refitted,
                            instead,
                            left,
                            shown,
                            withdrawn,
                            judged,
                            ambiguous,
                        };
                    }
                    Err(fault) => Some(fault),
                },
            };
            let Some((worst, reason)) = fault else { continue };
            let id = self.id(&named[worst]);
            judged.push(format!("{id} is withdrawn: {reason}"));
            let is_worst =
                |t: &&FittedTerm| t.term.family == named[worst].family && t.term.shape == named[worst].shape;
            withdrawn.extend(joint.terms.iter().find(is_worst).cloned());
            named.remove(worst);
        }
    }

    /// The terms of a model that would be found if noise lasted.
    fn beyond_noise(&self, model: &Model) -> Vec<Term> {
        let fitted: Vec<Term> = model.terms.iter().map(|term| term.term.clone()).collect();
        let beyond = Lasting::new(self.explanation, model.order).beyond(&fitted);
        fitted.into_iter().zip(beyond).filter_map(|(term, beyond)| beyond.then_some(term)).collect()
    }

    /// Whether held-out rows are predicted better in the mean; true where nothing is held out. Gains on them that are small
    /// beside those on fitted rows are a fit to these.
    ///
    /// Effects that were chosen with all readings look better on held-out rows than they are. They must leave hardly more of
    /// these than of fitted ones. They must also be better beyond the interval of the gain, or be found if noise lasted, where
    /// what chance chooses is paid for.
    fn shows_gain(&self, handed: &Handed, model: &Model) -> bool {
        let Some(shown) = &handed.shown else { return true };
        let gain = gain(&shown.gains);
        let of_fitted = rms(self.before_left) - rms(&handed.left);
        let found_in_any_noise = || {
            let beyond = self.beyond_noise(model);
            model.terms.iter().filter(|t| t.effect.is_some()).all(|t| beyond.iter().any(|b| same(b, &t.term)))
        };
        let overfitted = shown.rms > OF_HELD_OUT * rms(&handed.left);
        gain.value > OF_FITTED * of_fitted.max(0.0)
            && (shown.chosen_without || !overfitted && (gain.is_certain() || found_in_any_noise()))
    }

    /// Leaves out the effects that noise which lasts does as well as.
    fn keep_beyond_noise(&self, kept: &mut Vec<Term>, joint: &Model, judged: &mut Vec<String>) {
        let beyond = self.beyond_noise(joint);
        let shown = |t: &Term| beyond.iter().any(|of| same(of, t));
        let others: Vec<&str> =
            kept.iter().filter(|t| self.of_device(t) && !shown(t)).map(|t| self.id(t)).collect();
        if others.is_empty() {
            return;
        }
        judged.push(format!(
            "{} {} not handed on: noise that lasts, such as a wandering reference, does nearly as well",
            others.join(" and "),
            if others.len() == 1 { "is" } else { "are" }
        ));
        kept.retain(|t| !self.of_device(t) || shown(t));
    }

    /// Leaves out the forms that are one step in this recording: it may be what happened once.
    fn keep_no_single_steps(&self, kept: &mut Vec<Term>, judged: &mut Vec<String>) {
        let is_form = |t: &Term| self.effect(t).is_some_and(|effect| effect.is_form() && !effect.of_one_time);
        let (steps, others): (Vec<Term>, Vec<Term>) =
            kept.drain(..).partition(|t| is_form(t) && matches!(&t.columns[..], [one] if is_one_step(one)));
        judged.extend(steps.iter().map(|t| {
            format!(
                "{} is not handed on: in this recording it is one step, which may have happened once",
                self.id(t)
            )
        }));
        *kept = others;
    }

    /// Leaves out the effects of which too much is missing here: other recordings would get little of what they explain.
    fn keep_what_others_get(&self, kept: &mut Vec<Term>, joint: &Model, judged: &mut Vec<String>) {
        let error = &self.explanation.search.rows.error;
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let squares = |left: &[f64]| rms(&centred(left)).powi(2);
        let left = less(error, &joint.value());
        let explained = squares(&less(error, &self.before.value())) - squares(&left);
        let part = |term: &FittedTerm| {
            let missing = less(&self.hand_on.of_others(term, joint)?, &term.contribution);
            Some(1.0 - (squares(&less(&left, &missing)) - squares(&left)) / explained)
        };
        let fitted = |t: &Term| joint.terms.iter().find(|fitted| same(&fitted.term, t));
        let missing = |t: &Term| fitted(t).and_then(part).is_some_and(|part| part < OF_OTHERS);
        judged.extend(kept.iter().filter(|t| missing(t)).map(|t| {
            format!(
                "{} is not handed on: it explains this recording by what was before it and in its pauses, which is not \
                 known of others",
                self.id(t)
            )
        }));
        kept.retain(|t| !missing(t));
    }

    /// What is handed on of these effects alone; nothing where none remains, or where what remains does not hold.
    fn only(&self, handed: Handed, kept: &[Term], of: usize) -> Option<Handed> {
        if kept.len() == of {
            return Some(handed);
        }
        if kept.is_empty() {
            return None;
        }
        let without = self.handed(&self.alone(kept), kept, false).ok();
        without.filter(|handed| self.shows_gain(handed, &handed.model))
    }

    /// The answer where the base alone is handed on.
    fn base_alone(&self, joint: Model, withdrawn: Vec<FittedTerm>, judged: Vec<String>) -> Settled {
        Settled {
            joint,
            handed: self.before.clone(),
            refitted: self.before_refitted.clone(),
            instead: Vec::new(),
            left: self.before_left.to_vec(),
            shown: self.proof.map(|p| Shown { rms: p.before(), gains: Vec::new(), chosen_without: true }),
            withdrawn,
            judged,
            ambiguous: Vec::new(),
        }
    }

    /// What these effects are shown by: held-out passes, or blocks where some of them belong to a time of the recording,
    /// its beginning among them, or have values in a pass of which the others do not tell.
    pub fn proof_of(&self, named: &[Term]) -> Option<&Proof<'a>> {
        let asks_beyond = |term: &Term| self.proof.is_some_and(|proof| proof.asks_beyond(term));
        if !named.iter().any(|term| self.of_one_time(term) || asks_beyond(term)) {
            return self.proof;
        }
        self.blocks
            .get_or_init(|| prove(self.explanation, self.hand_on, self.before, Groups::Blocks))
            .as_ref()
    }

    /// Whether a term is of one time of the recording, its beginning among them.
    fn of_one_time(&self, term: &Term) -> bool {
        let effect = self.effect(term);
        effect.is_some_and(|e| e.of_one_time || e.begins_before(self.explanation.search.rows, &term.shape))
    }

    /// Whether other recordings of the device get it.
    fn of_device(&self, term: &Term) -> bool {
        self.effect(term).is_none_or(|effect| !effect.of_one_time)
    }

    fn effect(&self, term: &Term) -> Option<&Effect> {
        self.explanation.search.effect(term.family).map(|e| &self.catalogue[e])
    }

    pub fn id(&self, term: &Term) -> &str {
        self.effect(term).map_or("structure", |effect| &effect.id)
    }

    /// The first named effect of which nothing is determined, by its place among the named ones, and why.
    fn undetermined(&self, joint: &Model) -> Option<(usize, String)> {
        let known = |v: f64| v.is_finite() && v.abs() < BOUNDLESS;
        let named = joint.terms.iter().filter(|t| t.effect.is_some());
        named.enumerate().find_map(|(place, term)| {
            let unknown = |(reading, [low, high]): &&(Reading, [f64; 2])| {
                !(known(*low) && known(*high) && known(reading.value))
            };
            let (reading, _) = term.parameters.iter().find(unknown)?;
            Some((place, format!("nothing of the recording determines `{}`", reading.name)))
        })
    }

    /// States the parameters as the handed-on model holds them: beside structure without a name, and in means of rows,
    /// the fit has others. An interval of means goes with the estimate of all rows, which is no less certain.
    fn as_handed_on(&self, joint: &mut Model, handed: &Model, refitted: &Coefficients) {
        for (of, readings) in handed.terms.iter().zip(self.hand_on.parameters(refitted, handed)) {
            let same = |t: &&mut FittedTerm| t.term.family == of.term.family && t.term.shape == of.term.shape;
            let Some(term) = joint.terms.iter_mut().find(same) else { continue };
            for ((stated, ci95), reading) in term.parameters.iter_mut().zip(readings.into_iter().flatten()) {
                if self.hand_on.rows.means {
                    ci95.iter_mut().for_each(|end| *end += reading.value - stated.value);
                }
                *stated = reading;
            }
        }
    }

    /// Extends an interval beside which the estimate lies to the estimate, and says so where it lies far outside.
    fn extend_intervals(&self, joint: &mut Model, judged: &mut Vec<String>) {
        for term in joint.terms.iter_mut().filter(|t| t.effect.is_some()) {
            let id = self.id(&term.term);
            for (reading, ci95) in &mut term.parameters {
                let [low, high] = *ci95;
                let beside = (low - reading.value).max(reading.value - high);
                if beside > BESIDE * (high - low) + f64::EPSILON * reading.value.abs() {
                    judged.push(format!(
                        "{id}: the interval of `{}` is extended to the estimate, which lies far outside it",
                        reading.name
                    ));
                }
                *ci95 = [low.min(reading.value), high.max(reading.value)];
            }
        }
    }

    /// The handed-on model of the named terms with what it leaves and shows; else which term does harm, and how.
    fn handed(&self, joint: &Model, named: &[Term], as_found: bool) -> Result<Handed, (usize, String)> {
        let model = if joint.terms.len() == named.len() { joint.clone() } else { self.alone(named) };
        let before = rms(self.before_left);
        let refitted = self.hand_on.refitted(&model, None);
        let left = match self.hand_on.left_by(Some(&refitted), &model, None) {
            Some(left) if rms(&left) <= NO_WORSE * before => left,
            other => {
                let without = |k: usize| self.hand_on.left(&self.alone(&all_but(named, k)), None);
                let worst = least(named.len(), |k| without(k).map_or(f64::INFINITY, |left| rms(&left)));
                let reason = match other {
                    Some(left) => format!(
                        "with it the handed-on model leaves {:.3} where the base alone leaves {:.3} {}",
                        rms(&left),
                        before,
                        self.hand_on.full.unit
                    ),
                    None => "the model with it could not be applied".to_string(),
                };
                return Err((worst, reason));
            }
        };
        let order = model.order;
        let Some(proof) = self.proof_of(named) else {
            return Ok(Handed { model, refitted, left, shown: None });
        };
        let shows = |choice: &Choice| {
            proof.shows(self.hand_on, choice, order).filter(|shown| shown.rms <= NO_WORSE * proof.before())
        };
        // As the whole search would have found it; where that shows nothing, as these effects do, fitted without the held-out
        // rows.
        let certain = |shown: &Shown| gain(&shown.gains).is_certain();
        let searched = if as_found { shows(&Choice::Searched) } else { None };
        let shown = match searched {
            Some(searched) if certain(&searched) => Some(searched),
            Some(searched) => Some(shows(&Choice::Of(named)).filter(certain).unwrap_or(searched)),
            None => shows(&Choice::Of(named)),
        };
        if let Some(shown) = shown {
            return Ok(Handed { model, refitted, left, shown: Some(shown) });
        }
        let worst = least(named.len(), |k| {
            let others = all_but(named, k);
            proof.shows(self.hand_on, &Choice::Of(&others), order).map_or(f64::INFINITY, |shown| shown.rms)
        });
        Err((worst, "it predicts held-out rows worse than the base alone".to_string()))
    }

    /// Base and these terms, without structure that has no name.
    fn alone(&self, named: &[Term]) -> Model {
        if named.is_empty() {
            return self.before.clone();
        }
        let rows = self.explanation.search.rows;
        let order = choose_order(self.explanation, named).max(first_order(rows));
        model::predictive(self.explanation, named, order)
    }
}

pub fn same(a: &Term, b: &Term) -> bool {
    a.family == b.family && a.shape == b.shape
}

fn all_but(terms: &[Term], k: usize) -> Vec<Term> {
    let mut others = terms.to_vec();
    others.remove(k);
    others
}

/// The index with the smallest figure; the last one where all are infinite.
pub fn least(count: usize, figure: impl Fn(usize) -> f64) -> usize {
    let figures: Vec<f64> = (0..count).map(figure).collect();
    (0..count).rev().min_by(|a, b| figures[*a].total_cmp(&figures[*b])).unwrap_or(0)
}

/// The noise floor that a model's own residual allows: no reading is noisier than what is left of all of them. Noise
/// with a memory moves whole passes, and the saturated model follows a part of it: up to a limit, what is left is
/// its measure.
pub fn floor(estimated: f64, correlation: f64, left: &[f64], parameters: usize) -> f64 {
    let n = left.len() as f64;
    let left = rms(left) * (n / (n - parameters as f64).max(1.0)).sqrt();
    if correlation > REMEMBERS && left < FOLLOWED * estimated { left } else { estimated.min(left) }
}

/// The verdict that the figures allow, and why it is lower than the one that was meant. `left` is what remains of
/// held-out readings (of fitted ones where none were held out), `accuracy` what is stated of the reference, in the
/// floor's unit.
pub fn allowed(
    meant: Verdict,
    left: f64,
    floor: &NoiseFloor,
    accuracy: Option<f64>,
) -> (Verdict, Option<String>) {
    let lower = match meant {
        Verdict::Consistent => Verdict::Unexplained,
        Verdict::Explained | Verdict::Described => Verdict::PartlyExplained,
        other => return (other, None),
    };
    if left > AT_FLOOR * floor.value {
        let why = format!(
            "held-out readings are left with {:.2} times the noise floor: structure remains",
            left / floor.value
        );
        return (lower, Some(why));
    }
    match accuracy.filter(|accuracy| floor.value > ABOVE_ACCURACY * accuracy) {
        Some(accuracy) => {
            let why = format!(
                "the noise floor is {:.1} times the stated accuracy of the reference: something else moves the readings, \
                 or the accuracy is not what is stated",
                floor.value / accuracy
            );
            (lower, Some(why))
        }
        None => (meant, None),
    }
}

/// Whether a step from some row on explains nearly all of a column about its mean.
fn is_one_step(column: &[f64]) -> bool {
    let values = centred(column);
    let whole: f64 = dot(&values, &values);
    let mut sum = 0.0;
    let between = values[..values.len() - 1].iter().enumerate().map(|(k, value)| {
        sum += value;
        let (before, after) = (k as f64 + 1.0, (values.len() - k - 1) as f64);
        sum * sum * (1.0 / before + 1.0 / after)
    });
    between.fold(0.0, f64::max) > OF_ONE_STEP * whole
}
