//! One explanation, judged: what is kept of it, and its figures before and after. Where the mismatch is gross, two
//! explanations are tried, and held-out readings decide.

mod compared;

use std::sync::OnceLock;

use fitter::Coefficients;
use numerics::rms;

use crate::ambiguity::conflicts;
use crate::condense::Condensed;
use crate::diagnosis::NoiseFloor;
use crate::effects::Effect;
use crate::experiment;
use crate::explain::{Explanation, Found, explain, explain_gross};
use crate::hand_on::HandOn;
use crate::held_out::{self, Fit, Groups, Proof, Score};
use crate::judge::{self, Judge, Settled};
use crate::lasting::in_likeliest_noise;
use crate::model::{self, Model};
use crate::reach::reach;
use crate::search::Term;
use crate::thresholds::AT_FLOOR;
use crate::thresholds::attempt::CLEARLY;
use crate::thresholds::verdict::MOST_ALTERNATIVES;
use crate::verdict::{self, Said, Verdict};

/// What is said where a search without the held-out rows does not find effects that predict them.
const CHOSEN_WITH_ALL: &str = "the effects were chosen with all readings, and only fitted without the held-out ones: the held-out figures are \
     of the fit, not of the choice";

/// An explanation and what became of it.
pub struct Attempt<'a> {
    /// What was found.
    pub explanation: Explanation<'a>,
    /// The base alone.
    pub before: Model,
    /// It as it would be handed on.
    pub before_file: Coefficients,
    /// What is kept.
    pub settled: Settled,
    /// The figures.
    pub fit: Fit,
    /// The noise floor.
    pub noise_floor: NoiseFloor,
    /// What is said of it.
    pub said: Said,
    /// Whether the effects explain everything. Of effects that are not handed on held-out figures say nothing.
    explains_all: bool,
}

impl Attempt<'_> {
    /// Whether structure is left that no effect explains.
    pub fn leaves_structure(&self) -> bool {
        matches!(self.said.verdict, Verdict::PartlyExplained | Verdict::Unexplained)
    }

    /// Lists the forms of a search that did better with all rows, though not without the held-out ones, as alternatives of
    /// the named effects that it did not need.
    fn list_alternatives(&mut self, with_forms: &Explanation, catalogue: &[Effect]) {
        let (search, terms) = (&with_forms.search, &with_forms.terms);
        let own = search.translated(&self.explanation.search, &self.explanation.terms);
        let found: Vec<&Effect> =
            terms.iter().filter_map(|t| search.effect(t.family)).map(|e| &catalogue[e]).collect();
        let forms: Vec<&String> =
            found.iter().filter(|effect| effect.is_form()).map(|form| &form.id).collect();
        if forms.is_empty() || search.merit(terms) <= search.merit(&own) {
            return;
        }
        let not_needed = |id: &String| found.iter().all(|effect| effect.id != *id);
        for effect in self.said.effects.iter_mut().filter(|effect| not_needed(&effect.id)) {
            effect.alternatives.splice(0..0, forms.iter().map(|id| (*id).clone()));
            effect.alternatives.truncate(MOST_ALTERNATIVES);
        }
        let Said { verdict, locations, effects, .. } = &self.said;
        let rows = self.explanation.search.rows;
        self.said.next_experiment = experiment::next(rows, catalogue, effects, locations, *verdict);
    }
}

/// The best judged explanation of a recording. `accuracy` is that of the reference, in the recording's unit.
///
/// # Errors
/// Why not even the base makes a model.
pub fn best<'a>(hand_on: &HandOn<'a>, skip: &[String], accuracy: Option<f64>) -> Result<Attempt<'a>, String> {
    best_of(explain(hand_on.rows, hand_on.outset, hand_on.catalogue, skip), hand_on, skip, accuracy)
}

/// The best with forms among the effects, or `named` where that is to be preferred: then with the forms that do nearly as well
/// in the place of its effects and contradict them elsewhere.
///
/// # Errors
/// Why not even the base makes a model.
pub fn with_forms<'a>(
    hand_on: &HandOn<'a>,
    skip: &[String],
    accuracy: Option<f64>,
    named: Attempt<'a>,
) -> Result<Attempt<'a>, String> {
    let found = explain(hand_on.rows, hand_on.outset, hand_on.catalogue, skip);
    // Where names explain everything, merit decides, which is known before the proof.
    let hopeless =
        !named.leaves_structure() && found.gross.is_none() && !named.has_less_merit_than(&found.explanation);
    let forms = match hopeless {
        true => found.explanation,
        false => match best_of(found, hand_on, skip, accuracy) {
            Ok(attempt) if named.gives_way_to(&attempt, hand_on) => return Ok(attempt),
            Ok(attempt) => attempt.explanation,
            Err(_) => return Ok(named),
        },
    };
    let rivals = conflicts(&named.explanation, hand_on.catalogue, &named.settled.handed, &forms);
    let mut named = match rivals.is_empty() {
        true => named,
        false => judged(named.explanation, hand_on, accuracy, Some(&forms))?,
    };
    named.list_alternatives(&forms, hand_on.catalogue);
    Ok(named)
}

/// The best with curves beside the named effects, where it leaves less than `described`, which leaves structure; else that. A curve
/// follows anything: it counts only where the search without the held-out rows predicts them better. The effects of the
/// catalogue are curves from number `first` on.
pub fn with_curves<'a>(
    hand_on: &HandOn<'a>,
    skip: &[String],
    accuracy: Option<f64>,
    described: Attempt<'a>,
    first: usize,
) -> Attempt<'a> {
    // Without a curve it is what the search without them refused.
    let counts = |attempt: &Attempt| {
        let effects = attempt.settled.handed.terms.iter().filter_map(|term| term.effect);
        let curves: Vec<&Effect> = effects.filter(|e| *e >= first).map(|e| &hand_on.catalogue[e]).collect();
        let follows = curves.iter().any(|curve| curve.remembers());
        !curves.is_empty()
            && attempt.is_chosen_over(&described, hand_on)
            && (!follows || attempt.is_shown_by_passes(hand_on))
    };
    match best(hand_on, skip, accuracy) {
        Ok(attempt) if counts(&attempt) => attempt,
        _ => described,
    }
}

fn best_of<'a>(
    found: Found<'a>,
    hand_on: &HandOn<'a>,
    skip: &[String],
    accuracy: Option<f64>,
) -> Result<Attempt<'a>, String> {
    let Found { explanation, gross } = found;
    let first = attempt(explanation, hand_on, accuracy)?;
    let Some(floor) = gross else { return Ok(first) };
    let of_rows = Condensed::of_rows(hand_on.rows, hand_on.cell_of, hand_on.full, floor);
    if !first.leaves_structure() && first.left() < AT_FLOOR * of_rows {
        return Ok(first);
    }
    let second = explain_gross(hand_on.rows, hand_on.outset, hand_on.catalogue, skip, floor)
        .and_then(|explanation| attempt(explanation, hand_on, accuracy).ok());
    Ok(match second {
        Some(second) if second.left() < CLEARLY * first.left() => second,
        _ => first,
    })
}

/// Judges one explanation.
fn attempt<'a>(
    explanation: Explanation<'a>,
    hand_on: &HandOn<'a>,
    accuracy: Option<f64>,
) -> Result<Attempt<'a>, String> {
    let mut explanation = in_likeliest_noise(explanation);
    model::settle_shapes(&mut explanation, hand_on.catalogue);
    judged(explanation, hand_on, accuracy, None)
}

/// Judges one explanation in the noise in which it was found. `with_forms` is that of the same recording with forms among the
/// effects.
fn judged<'a>(
    explanation: Explanation<'a>,
    hand_on: &HandOn<'a>,
    accuracy: Option<f64>,
    with_forms: Option<&Explanation<'a>>,
) -> Result<Attempt<'a>, String> {
    let rows = hand_on.rows;
    let before = model::expected(&explanation, hand_on.catalogue, hand_on.order_of_fit());
    let before_refitted = hand_on.refitted(&before, None);
    let before_file = hand_on.file(&before_refitted, &before)?;
    let before_left = hand_on
        .left_by(Some(&before_refitted), &before, None)
        .ok_or_else(|| "the base model cannot be applied".to_string())?;
    let proof = held_out::prove(&explanation, hand_on, &before, Groups::Passes);
    let level = Condensed::of_rows(rows, hand_on.cell_of, hand_on.full, explanation.floor);
    let judge = Judge {
        explanation: &explanation,
        with_forms,
        catalogue: hand_on.catalogue,
        hand_on,
        before: &before,
        before_refitted: &before_refitted,
        before_left: &before_left,
        proof: proof.as_ref(),
        blocks: OnceLock::new(),
    };
    let mut settled = judge.settle();
    let kept: Vec<Term> = settled.handed.terms.iter().map(|t| t.term.clone()).collect();
    let proof = judge.proof_of(&kept);
    let rivals = verdict::rivals(&explanation, hand_on.catalogue, &settled.joint);
    let mut said = verdict::say(&explanation, hand_on.catalogue, &settled, &rivals);
    said.unidentifiable.append(&mut settled.ambiguous);
    said.unidentifiable.extend(reach(&explanation, hand_on.catalogue, &mut settled, &rivals));
    let correlation = explanation.search.noise.correlation.typical();
    let noise_floor = NoiseFloor {
        value: judge::floor(level, correlation, &settled.left, settled.handed.base.len()),
        unit: rows.unit.clone(),
        from: if hand_on.full.passes().len() > 1 { "repeated passes" } else { "blocks" }.into(),
        autocorrelation: correlation,
    };
    let beyond_base = !settled.handed.terms.is_empty();
    let fit = Fit {
        unit: rows.unit.clone(),
        held_out_by: proof.map_or("nothing", Proof::by).into(),
        before: Score { train_rms: rms(&before_left), held_out_rms: proof.map(Proof::before) },
        after: Score {
            train_rms: rms(&settled.left),
            held_out_rms: settled.shown.as_ref().map(|shown| shown.rms),
        },
        gain: settled.shown.as_ref().filter(|_| beyond_base).map(|shown| held_out::gain(&shown.gains)),
        of_explainable: match beyond_base {
            true => held_out::of_explainable(&explanation, &before, &settled.joint),
            false => None,
        },
    };
    if settled.shown.as_ref().is_some_and(|shown| !shown.chosen_without) {
        settled.judged.push(CHOSEN_WITH_ALL.into());
    }
    let left = fit.after.held_out_rms.unwrap_or(fit.after.train_rms);
    let meant = said.verdict;
    let (allowed, why) = judge::allowed(meant, left, &noise_floor, accuracy);
    if let Some(why) = why {
        settled.judged.push(why);
        said.verdict = allowed;
        verdict::locate_rest(&explanation, hand_on.catalogue, &settled.handed, &mut said);
    }
    let judged = if beyond_base { said.verdict } else { meant };
    let explains_all = matches!(judged, Verdict::Explained | Verdict::Described);
    Ok(Attempt { before, before_file, settled, fit, noise_floor, said, explains_all, explanation })
}
