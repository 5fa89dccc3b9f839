//! From what was found to what is said: how much each effect explains, with which parameters and
//! intervals, what else could be it, where the rest lives, and what to record next.

use fitter::figures::with_interval;
use fitter::plant::Plant;
use numerics::{Symmetric, range};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::data::{ALL, Data, FIT_ROWS};
use super::effects::{Reading, effect, unit_of};
use super::estimate::{Fitted, Simulated};
use super::interval::{Sort, around};
use super::joint::INERTIA;
use super::model::Term;
use super::noise::Autoregression;
use super::recording::DynamicRecording;
use super::search::Search;
use super::structure::Structure;
use crate::thresholds::dynamic::verdict::{
    ALTERNATIVE_MARGIN, IMPERFECT_MARGIN, LEFT_GAIN, LEFT_GAIN_PER_SHAPE, LEFT_PART, MIMICRY, WITHOUT_END,
};
use crate::thresholds::verdict::MOST_ALTERNATIVES;
use crate::verdict::{Location, NamedEffect, Parameter, Verdict, too_many};

/// The families that are significant.
pub fn significant(mut found: Vec<Structure>) -> Vec<Structure> {
    found.retain(|s| {
        let least = LEFT_GAIN + LEFT_GAIN_PER_SHAPE * (s.shapes - 1) as f64;
        s.fitted_gain > least && s.gain > 0.5 * least && s.part > LEFT_PART
    });
    found
}

/// What a model leaves, as squared residuals.
pub struct Left {
    /// What is structure: that of the strongest family, or all that a correlated noise would not be.
    pub structure: f64,
    /// All that is above the noise, structure or not.
    pub above: f64,
}

/// The verdict: whether effects were found, how much of the mismatch they leave as structure, and whether they leave
/// more than noise.
pub fn verdict(nominal: &Fitted, found: &Fitted, left: &Left) -> Verdict {
    let more = left.structure > 0.0 || left.above > 0.0;
    if found.model.terms.len() == nominal.model.terms.len() {
        return if more { Verdict::Unexplained } else { Verdict::Consistent };
    }
    let explained = nominal.cost(ALL) - found.cost(ALL);
    match more {
        _ if left.structure > MIMICRY * explained => Verdict::Unexplained,
        true => Verdict::PartlyExplained,
        false => Verdict::Explained,
    }
}

/// p-value of a gain in −2 log likelihood for so many parameters.
pub fn p_value(gain: f64, parameters: usize) -> f64 {
    match ChiSquared::new(parameters.max(1) as f64) {
        Ok(distribution) => distribution.sf(gain.max(0.0)).max(1e-300),
        Err(_) => 1.0,
    }
}

/// What is said of the effects of a model: on the windows of the search, and on the whole recording.
pub fn effects(
    search: &Search,
    data: &Data,
    [small, found]: [&Fitted; 2],
    covariance: &Symmetric,
    imperfect: bool,
    plant: &Plant,
) -> Vec<NamedEffect> {
    let margin = match imperfect {
        true => ALTERNATIVE_MARGIN.max(IMPERFECT_MARGIN * search.data.count(FIT_ROWS) as f64),
        false => ALTERNATIVE_MARGIN,
    };
    search.named(data, [small, found], margin, |k, gain, alternatives| {
        let (term, own) = (&found.model.terms[k], found.model.packed_of(k));
        named(term, |r| variance(r, term, &own, covariance).sqrt(), gain, alternatives, plant)
    })
}

/// Effects, each with what is lost without it, the largest first and with its share.
pub fn shared(mut said: Vec<(f64, NamedEffect)>) -> Vec<NamedEffect> {
    said.sort_by(|a, b| b.0.total_cmp(&a.0));
    let total: f64 = said.iter().map(|(lost, _)| lost).sum::<f64>().max(f64::MIN_POSITIVE);
    said.into_iter()
        .map(|(lost, effect)| NamedEffect { share: (lost / total).clamp(0.0, 1.0), ..effect })
        .collect()
}

/// An effect as it is named, but for its share; `gain` is what it gains in −2 log likelihood.
pub fn named(
    term: &Term,
    deviation: impl Fn(&Reading) -> f64,
    gain: f64,
    alternatives: Vec<String>,
    plant: &Plant,
) -> NamedEffect {
    let parameter = |r: &Reading| Parameter {
        name: r.name.into(),
        value: r.value,
        unit: unit_of(r.unit, &plant.position_unit, &plant.drive_unit),
        ci95: around(r.value, deviation(r), sort(term, r)),
    };
    NamedEffect {
        id: term.effect.id.into(),
        kind: crate::verdict::CATALOGUED,
        title: term.effect.title.into(),
        formula: String::new(),
        p_value: p_value(gain, term.free.iter().filter(|f| **f).count()),
        share: 0.0,
        parameters: term.effect.readings(&term.parameters).iter().map(parameter).collect(),
        alternatives,
        runtime_correctable: true,
        form: crate::verdict::Form::default(),
    }
}

/// Covariance of the packed parameters, from the whitened normal equations. Of a direction that the rows leave open, one
/// parameter is without end and the others are given beside it: the last of the first `yielding` ones that it moves, or,
/// where it moves none of them, the last of all.
pub fn covariance<M: Simulated>(
    found: &Fitted<M>,
    data: &Data,
    noise: &Autoregression,
    yielding: usize,
) -> Symmetric {
    let free = found.model.packed().len();
    let Ok(whole) = found.model.normal(&found.states, data, &noise.coefficients) else {
        return Symmetric::zero(free);
    };
    let reduced = whole.reduced(ALL, 0.0, &[]);
    let order: Vec<usize> = (yielding..free).chain(0..yielding).collect();
    let ordered = reduced.part(order.iter().copied()).factor().inverse();
    let mut inverse = Symmetric::zero(free);
    for (i, row) in order.iter().enumerate() {
        order.iter().enumerate().for_each(|(j, column)| *inverse.at_mut(*row, *column) = ordered.at(i, j));
    }
    let square = whole.cost(ALL) / whole.rows(ALL).max(1) as f64;
    inverse.entries.iter_mut().for_each(|e| *e *= square);
    // What the rows do not determine has a variance without end, not none.
    for i in 0..free {
        let own = inverse.at(i, i);
        if !(own > 0.0 && own.is_finite()) {
            (0..free).for_each(|j| (*inverse.at_mut(i, j), *inverse.at_mut(j, i)) = (0.0, 0.0));
            *inverse.at_mut(i, i) = WITHOUT_END;
        }
    }
    inverse
}

/// What a reading is to its effect.
pub(super) fn sort(term: &Term, reading: &Reading) -> Sort {
    let shape = term.effect.parameters.iter().any(|p| p.shape && p.name == reading.name);
    match reading.unit {
        "rad" => Sort::Phase,
        _ if shape => Sort::Shape,
        _ => Sort::Amount,
    }
}

/// Damping, stiffness and gain of the identified plant; `deviations` are their standard deviations.
pub fn nominal(values: [f64; 3], deviations: [f64; 3], plant: &Plant) -> Vec<Parameter> {
    let gain = format!("{}/s²/{}", plant.position_unit, plant.drive_unit);
    let all = [("damping", "1/s"), ("stiffness", "1/s²"), ("gain", gain.as_str())];
    let one = |k: usize| Parameter {
        name: all[k].0.into(),
        value: values[k],
        unit: all[k].1.into(),
        ci95: around(values[k], deviations[k], Sort::Amount),
    };
    (0..3).map(one).collect()
}

/// The derivatives of a reading by the term's parameters as they are estimated: a shape by its logarithm.
pub(super) fn slopes(reading: &Reading, term: &Term) -> Vec<f64> {
    let parameters = term.effect.parameters.iter().zip(&term.parameters).zip(&reading.gradient);
    parameters.map(|((p, value), g)| if p.shape { g * value } else { *g }).collect()
}

fn variance(reading: &Reading, term: &Term, own: &[Option<usize>], covariance: &Symmetric) -> f64 {
    let slope = slopes(reading, term);
    let mut sum = 0.0;
    for (a, i) in slope.iter().zip(own) {
        for (b, j) in slope.iter().zip(own) {
            if let (Some(i), Some(j)) = (i, j) {
                sum += a * b * covariance.at(*i, *j);
            }
        }
    }
    sum.max(0.0)
}

/// Where the mismatch lives: on the observables of the named effects, by what they explain, then on those
/// of the structure that is left (or, with nothing named, of the strongest families beside the nominal).
pub fn locations(
    reach: impl Fn(&str) -> (f64, f64),
    named: &[NamedEffect],
    explained_part: f64,
    families: &[Structure],
) -> Vec<Location> {
    let mut out: Vec<Location> = Vec::new();
    let mut add = |variable: &str, times: Option<&str>, at: Option<(f64, f64)>, share: f64, p_value: f64| {
        if out.iter().any(|l| l.variable == variable && l.times.as_deref() == times) {
            return;
        }
        let (from, to) = at.unwrap_or_else(|| reach(variable));
        out.push(Location {
            variable: variable.into(),
            times: times.map(Into::into),
            from,
            to,
            share,
            p_value,
        });
    };
    for e in named {
        if let Some(effect) = effect(&e.id) {
            add(effect.variable, None, None, e.share * explained_part, e.p_value);
        }
    }
    let rest = if named.is_empty() { 1.0 } else { 1.0 - explained_part };
    for s in families {
        add(s.variable, s.times, s.at, s.part * rest, p_value(s.gain, s.shapes));
    }
    out.sort_by(|a, b| b.share.total_cmp(&a.share));
    out
}

/// Ids, titles and observables of the plant's parameters.
pub const PLANT: [[&str; 3]; 3] = [
    ["damping", "the damping of the plant", "velocity"],
    ["stiffness", "the stiffness of the plant", "position"],
    ["gain", "the gain of the plant", "drive"],
];

/// Where an effect, the inertia, or the plant's damping, stiffness or gain acts in a recording of one drive and one position.
pub fn place(id: &str, recording: &DynamicRecording, p_value: f64) -> Option<Location> {
    if recording.drives.len() != 1 || recording.positions.len() != 1 {
        return None;
    }
    let of_plant = PLANT.iter().find(|[of, ..]| *of == id).map(|[.., variable]| *variable);
    let of_plant = of_plant.or((id == INERTIA).then_some("acceleration"));
    let variable = of_plant.or_else(|| Some(effect(id)?.variable))?;
    let (from, to) = reach(&Data::new(recording), &recording.t_s, variable);
    Some(Location { variable: variable.into(), times: None, from, to, share: 1.0, p_value })
}

/// The range of an observable in the recording.
pub fn reach(data: &Data, t_s: &[f64], variable: &str) -> (f64, f64) {
    match variable {
        "position" | "history" => range(data.position),
        "drive" => range(data.drive),
        "t_s" => range(t_s),
        "frequency_hz" => (0.0, 0.5 / data.step_s),
        "acceleration" => {
            let rates = data.runs.iter().flat_map(|run| {
                let of = |w: &[f64]| (w[8] - 2.0 * w[4] + w[0]) / (4.0 * data.step_s).powi(2);
                data.position[run.clone()].windows(9).map(of)
            });
            range(&rates.collect::<Vec<f64>>())
        }
        _ => {
            let speeds = data.runs.iter().flat_map(|run| {
                data.position[run.clone()].windows(9).map(|w| (w[8] - w[0]) / (8.0 * data.step_s))
            });
            range(&speeds.collect::<Vec<f64>>())
        }
    }
}

/// What no recording of this kind determines, and what not this one.
pub fn unidentifiable(named: &[NamedEffect]) -> Vec<String> {
    let mut out = vec!["inertia: everything is per inertia, which the drive's unit alone fixes".to_string()];
    for effect in named {
        out.extend(too_many(&effect.id, effect.alternatives.len()));
        for p in &effect.parameters {
            if p.name != "phase_rad" && p.ci95[0] < 0.0 && p.ci95[1] > 0.0 {
                out.push(format!(
                    "{} {}: {} may as well be zero",
                    effect.id,
                    p.name,
                    with_interval(p.value, p.ci95, &p.unit)
                ));
            }
        }
    }
    out
}

/// What tells an effect of the catalogue from those that it is taken for.
pub fn experiment(id: &str) -> String {
    effect(id).map_or_else(String::new, |known| known.experiment.into())
}

/// What to record to decide what this recording leaves open; `experiment` tells an effect from others.
pub fn next_experiment(
    verdict: Verdict,
    named: &[NamedEffect],
    locations: &[Location],
    experiment: &dyn Fn(&str) -> String,
) -> Option<String> {
    let open: Vec<&NamedEffect> = named.iter().filter(|e| !e.alternatives.is_empty()).collect();
    if let Some(e) = open.first() {
        let pair = format!("{} from {}", e.id, e.alternatives.join(", "));
        return Some(format!("to tell {pair}: {}", experiment(&e.id)));
    }
    let place = locations.first().map(|l| l.variable.as_str());
    match (verdict, place) {
        (Verdict::Unexplained | Verdict::PartlyExplained, Some("t_s")) => Some(
            "repeat the same excitation after some time, warm and cold: what is left changes with time"
                .into(),
        ),
        (Verdict::Unexplained | Verdict::PartlyExplained, Some(variable)) => Some(format!(
            "repeat the excitation at several amplitudes that cover {variable} evenly: what is left depends on it"
        )),
        _ => None,
    }
}

/// The effects with as many alternatives as are listed.
pub fn listed(mut named: Vec<NamedEffect>) -> Vec<NamedEffect> {
    named.iter_mut().for_each(|effect| effect.alternatives.truncate(MOST_ALTERNATIVES));
    named
}
