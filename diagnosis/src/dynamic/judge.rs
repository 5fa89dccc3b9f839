//! The last word on a moving mechanism: an answer that contradicts itself is mended before it is written. What an
//! effect breaks withdraws it, and the rest is fitted again; what only the verdict claims too much lowers it. The plant
//! is judged as it will stand in its file, simulated by the code of `simulate`.

use fitter::plant::equations::StateStart;
use fitter::plant::{Equations, Kind, PlantFile};
use fitter::table::Values;
use motion::{Begin, Series, simulate};

use super::diagnose::{Case, DynamicOutcome, Predicted};
use super::interval::undetermined;
use super::recording::DynamicRecording;
use super::{plant, score};
use crate::DiagnosisError;
use crate::held_out::Score;
use crate::thresholds::dynamic::judge::{FLOOR_OVER_BEFORE, MOST_ROWS, WRITTEN};
use crate::thresholds::{AT_FLOOR, NO_WORSE};
use crate::verdict::{Location, NamedEffect, Parameter, Verdict};

/// What is to be left out of an answer.
#[derive(Debug, Clone, Default)]
pub struct Withdrawn {
    /// Ids of effects.
    pub effects: Vec<String>,
    /// Whether dry friction is to hold without the creep that a file cannot state.
    pub creep: bool,
}

/// What an answer breaks, and the effect that breaks it, where one does.
struct Fault {
    what: String,
    effect: Option<String>,
}

/// A recording of a moving mechanism with what was found in it: what differs between a free run, motion under feedback and
/// a structure of many modes.
pub trait Problem {
    /// The recording and what it is diagnosed with.
    fn case(&self) -> &Case<'_>;

    /// Whether its dry friction creeps while it holds, which no file states.
    fn creeps(&self) -> bool {
        false
    }

    /// Everything that is said without what was withdrawn.
    ///
    /// # Errors
    /// [`DiagnosisError::NoPlant`] where nothing can be fitted without it.
    fn answer(&self, withdrawn: &Withdrawn) -> Result<DynamicOutcome, DiagnosisError>;
}

/// The first answer that stands.
///
/// # Errors
/// What the problem refuses.
pub fn standing(problem: &impl Problem) -> Result<DynamicOutcome, DiagnosisError> {
    let (recording, creeps) = (problem.case().recording, problem.creeps());
    let mut withdrawn = Withdrawn::default();
    let mut said: Vec<String> = Vec::new();
    loop {
        let mut outcome = problem.answer(&withdrawn)?;
        let mut fault = faults(&outcome);
        if fault.is_none() {
            match written(&outcome, recording) {
                Written::Same => {}
                Written::Unusable(what) => fault = Some(Fault { what, effect: None }),
                Written::Other(..) if creeps && !withdrawn.creep => {
                    said.push(
                        "dry friction was fitted again without creep, which the plant's file cannot state"
                            .into(),
                    );
                    withdrawn.creep = true;
                    continue;
                }
                Written::Other(positions, factor) => {
                    said.push(format!(
                        "the figures after are those of the written plant as `simulate` runs it, {factor:.3} times what \
                         the fit's own integration leaves"
                    ));
                    adopt(&mut outcome, positions, factor);
                    fault = faults(&outcome);
                }
            }
        }
        let d = &mut outcome.diagnosis;
        let weakest = || d.effects.last().map(|e| e.id.clone());
        let culprit = fault.as_ref().and_then(|f| f.effect.clone().or_else(weakest));
        match (fault, culprit) {
            (Some(fault), Some(id)) if !withdrawn.effects.contains(&id) => {
                said.push(format!("`{id}` was withdrawn: {}", fault.what));
                withdrawn.effects.push(id);
            }
            (fault, _) => {
                said.extend(fault.map(|fault| format!("left as it is: {}", fault.what)));
                d.judged.append(&mut said);
                settle(&mut outcome, recording);
                return Ok(outcome);
            }
        }
    }
}

/// The first thing that an answer breaks by its own numbers.
fn faults(outcome: &DynamicOutcome) -> Option<Fault> {
    let d = &outcome.diagnosis;
    let parameters = d.effects.iter().flat_map(|e| e.parameters.iter().map(move |p| (e, p)));
    let number = |(e, p): (&NamedEffect, &Parameter)| {
        broken(p).map(|what| Fault { what: format!("its {} {what}", p.name), effect: Some(e.id.clone()) })
    };
    let (before, after) = (&d.fit.before, &d.fit.after);
    let worse = |rows: &str, before: f64, after: f64| {
        (after > NO_WORSE * before || !after.is_finite()).then(|| Fault {
            what: format!("the rms on the {rows} rows rose from {before:.4e} to {after:.4e}"),
            effect: None,
        })
    };
    let held = before.held_out_rms.zip(after.held_out_rms);
    let idle = |id: &String| Fault {
        what: "rows that did not fit it are predicted no better with it".into(),
        effect: Some(id.clone()),
    };
    { parameters }
        .find_map(number)
        .or_else(|| outcome.idle.as_ref().map(idle))
        .or_else(|| worse("fitted", before.train_rms, after.train_rms))
        .or_else(|| held.and_then(|(before, after)| worse("held-out", before, after)))
}

/// What is wrong with a parameter.
fn broken(p: &Parameter) -> Option<String> {
    let [low, high] = p.ci95;
    if !(p.value.is_finite() && low.is_finite() && high.is_finite()) {
        return Some("is no number".into());
    }
    if undetermined(p.value, p.ci95) {
        return Some("is not determined by this recording".into());
    }
    let room = 1e-9 * p.value.abs();
    if !(low - room..=high + room).contains(&p.value) {
        return Some(format!("{:.4e} lies outside its interval {low:.4e} … {high:.4e}", p.value));
    }
    None
}

/// What becomes of a plant on its way through its file.
enum Written {
    Same,
    /// Other positions, and the factor by which they leave more.
    Other(Vec<Vec<f64>>, f64),
    /// It cannot be read or simulated.
    Unusable(String),
}

/// The plant read back from its text and simulated.
fn written(outcome: &DynamicOutcome, recording: &DynamicRecording) -> Written {
    let own = &outcome.own.after;
    let positions = match simulated(&outcome.plant.to_toml(), own, recording) {
        Ok(Some(positions)) => positions,
        Ok(None) => return Written::Same,
        Err(what) => return Written::Unusable(format!("the plant as it is written {what}")),
    };
    let factor = rms(recording, &positions) / rms(recording, own).max(f64::MIN_POSITIVE);
    if (factor - 1.0).abs() <= WRITTEN { Written::Same } else { Written::Other(positions, factor) }
}

/// The positions of a plant's text, begun as the diagnosis's own simulation; none where no simulation can be compared.
fn simulated(
    text: &str,
    own: &[Vec<f64>],
    recording: &DynamicRecording,
) -> Result<Option<Vec<Vec<f64>>>, String> {
    let file = PlantFile::parse("plant.toml", text).map_err(|error| format!("cannot be read ({error})"))?;
    if file.plant.kind == Kind::SecondOrder {
        plant::given("plant.toml", &file).map_err(|error| format!("cannot be used ({error})"))?;
    }
    // Under feedback a simulated position runs away, and the drive that is predicted is judged by its figures; a linear
    // plant is written by its matrices.
    if file.plant.feedback.is_some() || file.plant.kind == Kind::Linear || recording.rows() > MOST_ROWS {
        return Ok(None);
    }
    let open =
        |equations: &Equations| equations.states.0.iter().any(|(_, s)| matches!(s.start, StateStart::Fit(_)));
    if file.equations.as_deref().is_some_and(open) {
        // Of several runs each begins elsewhere, which the file leaves open.
        return Ok(None);
    }
    let series = Series {
        t_s: recording.t_s.clone(),
        run: (recording.runs.len() > 1).then(|| runs(recording)),
        period: recording.period.clone(),
        drives: recording.drives.clone(),
        positions: own.iter().cloned().map(Values::from).collect(),
        ..Series::default()
    };
    let simulated = simulate("plant.toml", &file, &series, Begin::Recorded);
    let positions = |series: Series| series.positions.into_iter().map(Values::into_vec).collect();
    simulated.map(|series| Some(positions(series))).map_err(|error| format!("cannot be simulated ({error})"))
}

/// Lets an answer speak of what its file does.
fn adopt(outcome: &mut DynamicOutcome, positions: Vec<Vec<f64>>, factor: f64) {
    let scaled = |score: &mut Score| {
        score.train_rms *= factor;
        score.held_out_rms.iter_mut().for_each(|rms| *rms *= factor);
    };
    let fit = &mut outcome.diagnosis.fit;
    scaled(&mut fit.after);
    // Without effects the plant before is the same one.
    if outcome.diagnosis.effects.is_empty() && outcome.own.before == outcome.own.after {
        scaled(&mut fit.before);
        outcome.own.before.clone_from(&positions);
    }
    outcome.own.after = positions;
}

fn runs(recording: &DynamicRecording) -> Vec<i64> {
    let mut numbers = vec![0; recording.rows()];
    for (number, run) in (1..).zip(&recording.runs) {
        numbers[run.clone()].fill(number);
    }
    numbers
}

/// Root mean square of what predicted positions leave on the scored rows.
fn rms(recording: &DynamicRecording, predicted: &[Vec<f64>]) -> f64 {
    score::rms(&recording.positions, predicted, recording.scored_rows()).unwrap_or(f64::INFINITY)
}

/// Puts right what only was said: shares, a floor above what there was, and a verdict that claims noise where more is
/// left.
fn settle(outcome: &mut DynamicOutcome, recording: &DynamicRecording) {
    let feedback = outcome.plant.plant.feedback.is_some();
    let d = &mut outcome.diagnosis;
    shares(&mut d.effects);
    d.locations
        .iter_mut()
        .for_each(|l| l.share = if l.share.is_nan() { 0.0 } else { l.share.clamp(0.0, 1.0) });
    let before = d.fit.before.held_out_rms.unwrap_or(0.0).max(d.fit.before.train_rms);
    let most = FLOOR_OVER_BEFORE * before;
    if d.noise_floor.value > most {
        let floor = d.noise_floor.value;
        d.judged.push(format!(
            "the noise floor {floor:.4} was above what the nominal plant leaves, and is now that"
        ));
        d.noise_floor.value = before;
    }
    let Some(left) = d.fit.after.held_out_rms else { return };
    let claimed = matches!(d.verdict, Verdict::Explained | Verdict::Consistent);
    if feedback || !claimed || left <= AT_FLOOR * d.noise_floor.value {
        return;
    }
    d.verdict = if d.effects.is_empty() { Verdict::Unexplained } else { Verdict::PartlyExplained };
    d.judged.push(format!(
        "the verdict was lowered: {left:.4} {} is left on held-out rows, more than {AT_FLOOR} times the noise floor",
        d.fit.unit
    ));
    if d.locations.is_empty() {
        d.locations.extend(loudest(recording, &outcome.own));
    }
}

/// Brings the effects' shares into 0 … 1 and their sum to at most 1.
fn shares(effects: &mut [NamedEffect]) {
    effects.iter_mut().for_each(|e| e.share = if e.share.is_nan() { 0.0 } else { e.share.clamp(0.0, 1.0) });
    let sum: f64 = effects.iter().map(|e| e.share).sum();
    if sum > 1.0 {
        effects.iter_mut().for_each(|e| e.share /= sum);
    }
}

/// The tenth of the time in which most of the residual lies.
fn loudest(recording: &DynamicRecording, own: &Predicted) -> Option<Location> {
    let (recorded, predicted) = (recording.positions.first()?, own.after.first()?);
    let scored = |k: &usize| recording.scored(*k);
    let square = |k: usize| (recorded[k] - predicted[k]).powi(2);
    let all: f64 = (0..recording.rows()).filter(scored).map(square).sum();
    let length = recording.rows().div_ceil(10).max(1);
    let starts = (0..recording.rows()).step_by(length);
    let part = |from: usize| -> f64 {
        (from..(from + length).min(recording.rows())).filter(scored).map(square).sum::<f64>()
    };
    let (from, most) = starts.map(|k| (k, part(k))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let to = (from + length).min(recording.rows()) - 1;
    Some(Location {
        variable: "t_s".into(),
        times: None,
        from: recording.t_s[from],
        to: recording.t_s[to],
        share: most / all.max(f64::MIN_POSITIVE),
        p_value: 1.0,
    })
}
