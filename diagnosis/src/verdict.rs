//! From what was found to what is said: verdict, locations with their ranges, alternatives that the
//! recording cannot exclude, and the experiment that would decide between them.

use fitter::figures::with_interval;
use numerics::{centred, range};
use serde::Serialize;

use crate::calibrate::log_tail;
use crate::dictionary::Kind;
use crate::effects::{Effect, Origin, Place};
use crate::experiment;
use crate::explain::Explanation;
use crate::judge::Settled;
use crate::model::{FittedTerm, Model};
use crate::rows::Rows;
use crate::search::{Search, Term};
use crate::thresholds::NORMAL_95;
use crate::thresholds::search::SHAPE_PRICE;
use crate::thresholds::verdict::{
    ALTERNATIVE_MARGIN, BLUR, MOST_ALTERNATIVES, MOST_BLURRED, MOST_LOG_ODDS, RANGE_PART,
};

/// What is said of the recording as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing beyond the noise.
    Consistent,
    /// Named effects leave noise.
    Explained,
    /// What was found leaves noise, and some of it is a form without a name.
    Described,
    /// Named effects, and structure is left.
    PartlyExplained,
    /// Structure, and no catalogued effect accounts for it.
    Unexplained,
}

impl Verdict {
    /// As it stands in the files.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Consistent => "consistent",
            Verdict::Explained => "explained",
            Verdict::Described => "described",
            Verdict::PartlyExplained => "partly_explained",
            Verdict::Unexplained => "unexplained",
        }
    }
}

/// Where the mismatch lives.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Location {
    /// The observable.
    pub variable: String,
    /// The observable that multiplies it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<String>,
    /// From which value on.
    pub from: f64,
    /// To which value.
    pub to: f64,
    /// Part of the mismatch's variance.
    pub share: f64,
    /// Family-wise p-value.
    pub p_value: f64,
}

/// One reported parameter.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

impl Parameter {
    /// A parameter whose estimate is normal, with this standard error.
    pub(crate) fn normal(name: &str, value: f64, error: f64, unit: &str) -> Parameter {
        let ci95 = [value - NORMAL_95 * error, value + NORMAL_95 * error];
        Parameter { name: name.into(), value, unit: unit.into(), ci95 }
    }
}

/// One named effect.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct NamedEffect {
    /// Id of the catalogue.
    pub id: String,
    /// Whether it stands in the catalogue or was declared by the user.
    pub kind: &'static str,
    /// Name for a reader.
    pub title: String,
    /// What it adds; empty where its page says it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub formula: String,
    /// Family-wise p-value.
    pub p_value: f64,
    /// Part of the mismatch's variance that it explains.
    pub share: f64,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Effects that the recording cannot tell from it.
    pub alternatives: Vec<String>,
    /// Whether a correction can undo it at run time.
    pub runtime_correctable: bool,
    /// More of a form without a name.
    #[serde(flatten)]
    pub form: Form,
}

/// What is said of a form without a name; nothing of a named effect.
#[derive(Debug, Clone, Default, Serialize)]
#[non_exhaustive]
pub struct Form {
    /// What physics has this form, as suggestions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<String>,
    /// How it would be declared as an effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub declaration: Option<String>,
}

fn kind(effect: &Effect) -> &'static str {
    match effect.origin {
        Origin::Catalogue => CATALOGUED,
        Origin::User => DECLARED,
        Origin::Form(_) => EMPIRICAL,
    }
}

/// [`NamedEffect::kind`] of an effect of the catalogue.
pub const CATALOGUED: &str = "catalogued";
/// The same of one that the user declared.
pub const DECLARED: &str = "declared";
/// The same of a form that no effect of the catalogue or of the user's has.
pub const EMPIRICAL: &str = "empirical";

/// Verdict, locations, effects, and what comes next.
#[derive(Debug, Clone)]
pub struct Said {
    /// The verdict.
    pub verdict: Verdict,
    /// Where, the strongest first.
    pub locations: Vec<Location>,
    /// The named effects, the strongest first.
    pub effects: Vec<NamedEffect>,
    /// What this recording does not determine.
    pub unidentifiable: Vec<String>,
    /// What to record next.
    pub next_experiment: Option<String>,
}

/// A catalogued effect that does nearly as well in a named one's place.
pub struct Rival {
    /// Index in the catalogue.
    pub effect: usize,
    /// What part of it it explains.
    pub part: f64,
    /// How likely it is beside the named one.
    pub odds: f64,
}

/// For every term the effects that do nearly as well in its place, the likeliest first.
pub fn rivals(explanation: &Explanation, catalogue: &[Effect], model: &Model) -> Vec<Vec<Rival>> {
    let of = |term: &FittedTerm| match term.effect {
        Some(_) => alternatives(explanation, catalogue, model, &term.term),
        None => Vec::new(),
    };
    model.terms.iter().map(of).collect()
}

/// Forms the verdict. An effect that was withdrawn is structure, and keeps its place.
pub fn say(
    explanation: &Explanation,
    catalogue: &[Effect],
    settled: &Settled,
    rivals: &[Vec<Rival>],
) -> Said {
    let search = &explanation.search;
    let rows = search.rows;
    let model = &settled.joint;
    let named = model.terms.iter().filter(|t| t.effect.is_some()).count();
    let unnamed =
        settled.withdrawn.iter().map(|t| FittedTerm { effect: None, ..t.clone() }).collect::<Vec<_>>();
    let none = Vec::new();
    let with_rivals = model.terms.iter().zip(rivals).chain(unnamed.iter().map(|t| (t, &none)));
    let mut order: Vec<(&FittedTerm, &Vec<Rival>)> = with_rivals.collect();
    order.sort_by(|a, b| b.0.explained.total_cmp(&a.0.explained));
    let total: f64 = order.iter().map(|(t, _)| t.explained).sum::<f64>().max(1e-300);
    let verdict = match (named, order.len() - named) {
        (0, 0) => Verdict::Consistent,
        (_, 0) if model.terms.iter().any(|t| is_form(catalogue, t)) => Verdict::Described,
        (_, 0) => Verdict::Explained,
        (0, _) => Verdict::Unexplained,
        _ => Verdict::PartlyExplained,
    };
    let mut locations: Vec<Location> = Vec::new();
    let mut further: Vec<Location> = Vec::new();
    let mut effects: Vec<NamedEffect> = Vec::new();
    let mut open: Vec<String> = Vec::new();
    for (term, rivals) in &order {
        let share = (term.explained / total).clamp(0.0, 1.0);
        let p_value = p_value(search, term);
        let place = place_of(explanation, catalogue, &term.term);
        push_location(&mut locations, locate(rows, &place, &term.contribution, share, p_value));
        let Some(e) = term.effect else { continue };
        open.extend(too_many(&catalogue[e].id, rivals.len()));
        let rivals = &rivals[..rivals.len().min(MOST_ALTERNATIVES)];
        for rival in rivals {
            let place = &catalogue[rival.effect].place;
            further.push(locate(rows, place, &term.contribution, (share * rival.part).min(share), p_value));
        }
        effects.push(NamedEffect {
            id: catalogue[e].id.clone(),
            kind: kind(&catalogue[e]),
            title: catalogue[e].found_as(&term.amplitudes).into(),
            formula: catalogue[e].formula_at(&term.term.shape),
            p_value,
            share,
            parameters: term
                .parameters
                .iter()
                .map(|(r, ci95)| Parameter {
                    name: r.name.clone(),
                    value: r.value,
                    unit: r.unit.clone(),
                    ci95: *ci95,
                })
                .collect(),
            alternatives: rivals.iter().map(|r| catalogue[r.effect].id.to_string()).collect(),
            runtime_correctable: !catalogue[e].of_one_time,
            form: Form {
                readings: catalogue[e].suggestions.clone(),
                declaration: catalogue[e].declaration(),
            },
        });
    }
    for location in further {
        push_location(&mut locations, location);
    }
    let next_experiment = experiment::next(rows, catalogue, &effects, &locations, verdict);
    open.extend(unidentifiable(rows, catalogue, model));
    Said { verdict, locations, effects, unidentifiable: open, next_experiment }
}

/// Family-wise p-value of a term beside the others.
pub(crate) fn p_value(search: &Search, term: &FittedTerm) -> f64 {
    let (family, tail) = (term.term.family, log_tail(term.explained, term.term.columns.len()));
    let surprise = search.calibration.families[family].surprise(tail);
    (-search.calibration.family_wise(surprise, search.shares[family])).exp().max(1e-300)
}

/// Whether a term is a form without a name.
fn is_form(catalogue: &[Effect], term: &FittedTerm) -> bool {
    term.effect.is_some_and(|e| catalogue[e].is_form())
}

/// What is said where more alternatives fit than are listed.
pub(crate) fn too_many(id: &str, alternatives: usize) -> Option<String> {
    (alternatives > MOST_ALTERNATIVES)
        .then(|| format!("{id}: any of {} effects fits as well; the nearest are listed", alternatives + 1))
}

/// Adds the place of the strongest dependence, of whatever kind, that the handed-on model leaves.
pub fn locate_rest(explanation: &Explanation, catalogue: &[Effect], handed: &Model, said: &mut Said) {
    let search = &explanation.search;
    let terms: Vec<Term> = handed.terms.iter().map(|t| t.term.clone()).collect();
    let found = search.contenders(&terms, |_| true);
    let Some(found) = found.iter().max_by(|a, b| a.surprise.total_cmp(&b.surprise)) else { return };
    let mut with = terms;
    with.push(found.term.clone());
    let model = crate::model::predictive(explanation, &with, handed.order);
    let Some(term) = model.terms.last() else { return };
    let p_value = (-search.family_wise(found)).exp().max(1e-300);
    let place = place_of(explanation, catalogue, &found.term);
    let share = (1.0 - said.effects.iter().map(|e| e.share).sum::<f64>()).clamp(0.0, 1.0);
    push_location(&mut said.locations, locate(search.rows, &place, &term.contribution, share, p_value));
}

fn push_location(locations: &mut Vec<Location>, location: Location) {
    if !locations.iter().any(|l| l.variable == location.variable && l.times == location.times) {
        locations.push(location);
    }
}

/// The place of a term.
pub fn place_of(explanation: &Explanation, catalogue: &[Effect], term: &Term) -> Place {
    match &explanation.search.dictionary.families[term.family].kind {
        Kind::Effect(e) => catalogue[*e].place.clone(),
        Kind::Generic(place) => place.clone(),
        Kind::Order => Place::on("angle_deg"),
    }
}

/// The terms without `term`, and without what stands for the names' rest: a curve of many columns may hold most of the
/// effect, too. A higher order of the base, which is no term of the model any more, stays.
pub fn without(explanation: &Explanation, model: &Model, term: &Term) -> Vec<Term> {
    let is = |a: &Term, b: &Term| a.family == b.family && a.shape == b.shape;
    let rest = &explanation.terms[explanation.chosen..];
    let of_model = model.terms.iter().map(|t| &t.term);
    let others = of_model.filter(|t| !is(t, term) && !rest.iter().any(|r| is(t, r)));
    others.chain(explanation.orders()).cloned().collect()
}

/// Catalogued effects that do nearly as well in the term's place.
fn alternatives(explanation: &Explanation, catalogue: &[Effect], model: &Model, term: &Term) -> Vec<Rival> {
    let search = &explanation.search;
    let others = without(explanation, model, term);
    let mut with = others.clone();
    with.push(term.clone());
    let best = search.explained(&with) - search.explained(&others);
    // A thermometer's own noise blurs every explanation that goes by the temperature: by that part of it.
    let rough = search.rows.temperature_c.as_ref().map_or(0.0, |t| roughness(t));
    let blurred = (BLUR * rough).min(MOST_BLURRED).max(rough.min(1.0));
    let is_thermal =
        |f: usize| search.effect(f).is_some_and(|e| catalogue[e].place.variable == "temperature_c");
    let free = |f: usize| search.effect(f).map_or(0, |e| search.free_shapes(e));
    let mut found: Vec<Rival> = search
        .contenders(&others, |f| search.effect(f).is_some() && f != term.family)
        .into_iter()
        .filter(|f| {
            let thermal = is_thermal(term.family) || is_thermal(f.term.family);
            // A richer explanation follows the noise further than a simpler one.
            let richer = free(term.family).saturating_sub(free(f.term.family)) as f64;
            let margin = ALTERNATIVE_MARGIN + SHAPE_PRICE * richer;
            f.explained > best - margin - if thermal { blurred * best } else { 0.0 }
        })
        .filter_map(|f| {
            let effect = search.effect(f.term.family)?;
            let simpler = free(term.family) as f64 - free(f.term.family) as f64;
            let odds = (0.5 * (f.explained - best + SHAPE_PRICE * simpler)).min(MOST_LOG_ODDS).exp();
            Some(Rival { effect, part: f.explained / best.max(1e-300), odds })
        })
        .collect();
    found.sort_by(|a, b| b.part.total_cmp(&a.part));
    found.retain(|r| !catalogue[r.effect].is_form() && catalogue[r.effect].testable(search.rows).is_ok());
    found
}

/// Part of a slow observable's variance that is its reading noise, from second differences.
fn roughness(values: &[f64]) -> f64 {
    let seconds: Vec<f64> = values.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
    let whole = numerics::rms(&centred(values)).powi(2);
    // The median of squares is deaf to the jumps between passes; 0.455 is that of χ²₁.
    let mut squares: Vec<f64> = seconds.iter().map(|s| s * s).collect();
    numerics::median(&mut squares) / 0.455 / 6.0 / whole.max(1e-300)
}

/// The values of an observable by its name in `locations`.
pub fn values_of(rows: &Rows, variable: &str) -> Vec<f64> {
    let some = |v: &Option<Vec<f64>>| v.clone();
    let per_degree = if rows.pair { rows.per_degree() } else { 1.0 };
    let angle = || rows.theta.iter().map(|t| t / per_degree).collect();
    match variable {
        "t_s" => rows.t_s.clone(),
        "pass" => rows.pass.iter().map(|p| *p as f64).collect(),
        "direction" => rows.direction.clone(),
        "temperature_c" => some(&rows.temperature_c).unwrap_or_else(angle),
        "common_mode_um" => some(&rows.common_mode_um).unwrap_or_else(angle),
        "cross_arcsec" => some(&rows.cross_arcsec).unwrap_or_else(angle),
        "coil_a" => some(&rows.coil_a).unwrap_or_else(angle),
        "velocity" => crate::effects::velocity(rows),
        name => rows.extra.iter().find(|c| c.name == name).map_or_else(angle, |c| c.values.clone()),
    }
}

/// The angle's name in `locations`: `angle_deg` of a mirror, `position_<unit>` of a sensor that reports it itself.
pub fn angle_name(rows: &Rows) -> String {
    if rows.pair { "angle_deg".to_string() } else { format!("position_{}", rows.unit) }
}

/// The range of the observable in which a contribution is felt.
pub(crate) fn locate(rows: &Rows, place: &Place, contribution: &[f64], share: f64, p_value: f64) -> Location {
    let values = values_of(rows, &place.variable);
    let about = centred(contribution);
    // About its most common value rather than its mean, so that a step or a bump counts where it is.
    let mut sorted = contribution.to_vec();
    let middle = numerics::median(&mut sorted);
    let deviation: Vec<f64> =
        if narrow(contribution, middle) { contribution.iter().map(|c| c - middle).collect() } else { about };
    let largest = deviation.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
    let inside: Vec<f64> = values
        .iter()
        .zip(&deviation)
        .filter(|(_, d)| d.abs() >= RANGE_PART * largest)
        .map(|(v, _)| *v)
        .collect();
    let (from, to) = if inside.is_empty() { range(&values) } else { range(&inside) };
    let named =
        |variable: &str| if variable == "angle_deg" { angle_name(rows) } else { variable.to_string() };
    let (variable, times) = (named(&place.variable), place.times.as_deref().map(named));
    Location { variable, times, from, to, share, p_value }
}

/// Whether most rows stand at one value of the contribution.
fn narrow(contribution: &[f64], middle: f64) -> bool {
    let (low, high) = range(contribution);
    let near = contribution.iter().filter(|c| (*c - middle).abs() < 0.05 * (high - low)).count();
    near * 2 > contribution.len()
}

/// What no recording of this kind, and what not this one, determines.
fn unidentifiable(rows: &Rows, catalogue: &[Effect], model: &Model) -> Vec<String> {
    let mut out = Vec::new();
    if rows.pair {
        out.push("probe distance error and a1: only a1 - Δd/d is determined".to_string());
        out.push("a0 and the reference's zero α₀: only their sum is determined".to_string());
    } else {
        out.push("constant error and the reference's zero: only their sum is determined".to_string());
    }
    if !rows.both_directions() {
        out.push(
            "lag, gain and backlash: one move in one direction cannot separate them (a lag at constant speed \
             and a backlash are constant offsets, a lag that grows with the position is a gain)"
                .to_string(),
        );
    }
    out.extend(rows.not_testable.iter().cloned());
    // Effects that this recording cannot show, together where the reason is the same.
    let mut reasons: Vec<(String, Vec<&str>)> = Vec::new();
    for effect in catalogue {
        let Err(reason) = effect.testable(rows) else { continue };
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, ids)) => ids.push(&effect.id),
            None => reasons.push((reason, vec![&effect.id])),
        }
    }
    out.extend(reasons.iter().map(|(reason, ids)| format!("not testable: {} ({reason})", ids.join(", "))));
    for term in &model.terms {
        for (reading, ci) in &term.parameters {
            if reading.value != 0.0 && ci[0] < 0.0 && ci[1] > 0.0 {
                out.push(format!(
                    "{}: {} may as well be zero",
                    reading.name,
                    with_interval(reading.value, *ci, &reading.unit)
                ));
            }
        }
    }
    out
}
