//! One recording of a linear nominal from rows to everything that is said of it.

use std::ops::Range;

use fitter::plant::Order;
use numerics::Limits;

use super::looped::{Looped, Stretch};
use super::modal::Modal;
use super::offset::{self, Offset, offset};
use super::plan::{self, Plan};
use super::{file, hysteresis, nominal, sensitivity, verdict};
use crate::DiagnosisError;
use crate::diagnosis::NoiseFloor;
use crate::dynamic::diagnose::{Case, Identified, Predicted};
use crate::dynamic::effects::CUBIC_STIFFNESS;
use crate::dynamic::judge::{self, Problem, Withdrawn};
use crate::dynamic::score;
use crate::dynamic::spectrum::Response;
use crate::dynamic::spectrum::experiments::mean_period;
use crate::dynamic::{DynamicOutcome, DynamicRecording, OwnSimulation};
use crate::held_out::{Fit, Score};
use crate::thresholds::dynamic::linear::diagnose::{
    FINAL_STEPS, GROWS, LINEAR_STEPS, NOISE, RIVAL, RIVAL_STEPS, STEPS,
};
use crate::thresholds::dynamic::linear::plan::{FINAL_ROWS, FIT_ROWS};
use crate::verdict::{NamedEffect, Said, Verdict};

/// Diagnoses a recording whose plant is `kind = "linear"`.
///
/// # Errors
/// [`DiagnosisError::NoPlant`] where the drives do not determine a model.
pub fn diagnose(case: &Case) -> Result<DynamicOutcome, DiagnosisError> {
    let Case { recording, plant, simulated, options, .. } = *case;
    let lost = || recording.lost(100.0);
    let plan = Plan::new(recording);
    let expected = match simulated {
        Some(own) => theirs(recording, own)?,
        None => recording.clone(),
    };
    let order = match plant.plant.order {
        Some(Order::States(states)) => Some(states.div_ceil(2) * 2),
        _ => None,
    };
    let given = file::to_model(plant);
    let (before, start) = match given {
        Some(model) if agrees(&model.linear, recording) => (model.clone(), model.linear),
        _ => {
            let (pooled, lowest) = nominals(&expected, &plan, order).ok_or_else(lost)?;
            (Looped::plain(pooled), lowest)
        }
    };
    let fitting = plan.chosen(recording, FIT_ROWS);
    let held = plan.held();
    let judged = plan.stretches(recording, if held.is_empty() { &[] } else { &held });
    let judged = if judged.is_empty() { fitting.clone() } else { judged };
    let named = if options.skip.iter().any(|id| id == file::ID) {
        None
    } else {
        name(recording, &plan, &before, &start, &fitting, &judged)
    };
    judge::standing(&Modes {
        case,
        responses: verdict::responses(recording, &plan),
        noise: period_noise(recording, &plan),
        plan,
        before,
        fitting,
        named,
    })
}

/// A structure of many modes, and what was found in it.
struct Modes<'a> {
    case: &'a Case<'a>,
    plan: Plan,
    /// The linear model.
    before: Looped,
    fitting: Vec<Stretch>,
    /// The hysteresis that was found.
    named: Option<Named>,
    responses: Vec<(f64, Response)>,
    /// Standard deviation of a reading from repeated periods, and its correlation.
    noise: Option<(f64, f64)>,
}

impl Problem for Modes<'_> {
    fn case(&self) -> &Case<'_> {
        self.case
    }

    fn answer(&self, withdrawn: &Withdrawn) -> Result<DynamicOutcome, DiagnosisError> {
        let (recording, plant, before) = (self.case.recording, self.case.plant, &self.before);
        let out = |id: &str| self.case.options.skip.iter().chain(&withdrawn.effects).any(|other| other == id);
        let named = self.named.as_ref().filter(|_| !out(file::ID));
        let mut effects: Vec<NamedEffect> = named.map(|found| self.hysteresis(found)).into_iter().collect();
        let after = named.map_or(before, |found| &found.model);
        let mut own = predict(recording, before, after);
        let mut other = self.case.held_out.map(|r| predict(r, before, after));
        let stated = Offset::stated(plant, recording.positions.len());
        if let Some(stated) = &stated {
            for predicted in std::iter::once(&mut own).chain(&mut other) {
                stated.add_to(&mut predicted.before);
                stated.add_to(&mut predicted.after);
            }
        }
        let constant = if out(offset::ID) { None } else { offset(recording, &own.after, &self.plan) };
        if let Some(found) = &constant {
            found.add_to(&mut own.after);
            other.iter_mut().for_each(|o| found.add_to(&mut o.after));
            effects.push(found.named(&plant.plant.position_unit, recording.drives.len()));
        }
        let (said, floor) = self.said(effects, &own);
        let fit = self.fit(&own, other.as_ref());
        let diagnosis = self.case.said(said, floor, fit);
        let mut written = file::to_file(after, &plant.plant);
        let constant = constant.map(|found| found.and(stated.as_ref())).or(stated);
        written.effects.extend(constant.map(|o| o.effect()));
        let identified = Identified::Modes(Box::new(after.clone()));
        Ok(DynamicOutcome { diagnosis, plant: written, own, other, idle: None, identified })
    }
}

impl Modes<'_> {
    fn hysteresis(&self, found: &Named) -> NamedEffect {
        let error = sensitivity::exponent_error(&found.model, &self.fitting);
        let mut effect = verdict::hysteresis(&found.model, found.gain, &self.responses, error);
        effect.alternatives.extend(found.rival.then(|| CUBIC_STIFFNESS.to_string()));
        effect
    }

    /// Verdict and places, and the noise that they are measured by.
    fn said(&self, effects: Vec<NamedEffect>, own: &Predicted) -> (Said, NoiseFloor) {
        let (recording, plan, noise) = (self.case.recording, &self.plan, self.noise);
        let held = plan.held();
        let left = rms(recording, &own.after, if held.is_empty() { &recording.runs } else { &held });
        let level = noise.map_or(left, |(level, _)| level);
        let around = verdict::locations(recording, plan, &self.before.linear, &self.responses);
        // Without repeated periods nothing tells noise from distortion but its dependence on the amplitude.
        let grows = around.iter().any(|l| l.variable == "amplitude" && l.share > GROWS);
        let verdict = match (effects.first(), noise) {
            (Some(_), Some(_)) if left > NOISE * level => Verdict::PartlyExplained,
            (Some(_), _) => Verdict::Explained,
            (None, Some(_)) if left > NOISE * level => Verdict::Unexplained,
            (None, None) if grows => Verdict::Unexplained,
            (None, _) => Verdict::Consistent,
        };
        let next_experiment = match verdict {
            Verdict::Unexplained => Some(String::from(
                "repeat the excitation at two amplitudes or more, of each more runs than drives: then what depends on the amplitude \
             is told from what the order of the model leaves",
            )),
            Verdict::PartlyExplained if plan.groups.len() < 2 => Some(String::from(
                "repeat the excitation at another amplitude: one alone does not show the growth",
            )),
            _ => None,
        };
        let floor = NoiseFloor {
            value: level,
            unit: self.case.plant.plant.position_unit.clone(),
            from: if noise.is_some() { "repeated periods" } else { "what the model leaves" }.into(),
            autocorrelation: noise.map_or(0.0, |(_, correlation)| correlation),
        };
        let said = Said {
            verdict,
            locations: if verdict == Verdict::Consistent { Vec::new() } else { around },
            effects,
            unidentifiable: vec![String::from(
                "the states of the linear model: any regular change of their coordinates gives the same positions",
            )],
            next_experiment,
        };
        (said, floor)
    }

    fn fit(&self, own: &Predicted, other: Option<&Predicted>) -> Fit {
        let (recording, held) = (self.case.recording, self.plan.held());
        let score = |own: &[Vec<f64>], other: Option<&Vec<Vec<f64>>>| Score {
            train_rms: rms(recording, own, &self.plan.fitted()),
            held_out_rms: match (self.case.held_out, other) {
                (Some(r), Some(columns)) => Some(rms(r, columns, &r.runs)),
                _ if held.is_empty() => None,
                _ => Some(rms(recording, own, &held)),
            },
        };
        let scores =
            [score(&own.before, other.map(|o| &o.before)), score(&own.after, other.map(|o| &o.after))];
        let by = self.case.held_out.map_or(self.plan.held_out_by, |r| &r.file);
        Fit::of(&self.case.plant.plant.position_unit, by, scores)
    }
}

/// The linear model of all amplitudes, and that of the lowest, both of one order.
fn nominals(recording: &DynamicRecording, plan: &Plan, order: Option<usize>) -> Option<(Modal, Modal)> {
    let all = plan.experiments(recording, &plan.fitted());
    let lowest = plan.groups.first()?;
    let low = plan.experiments(recording, &lowest.fitted);
    // The lowest amplitude shows the modes best; where its runs do not span the drives, all are taken.
    let low = if low.each.len() > low.inputs && plan.groups.len() > 1 { low } else { all.clone() };
    let order = match order {
        Some(order) => order,
        None => {
            let held = (!lowest.held.is_empty()).then(|| plan.experiments(recording, &lowest.held));
            let held = held.filter(|h| h.lines == low.lines && !h.each.is_empty());
            nominal::choose_order(&low, held.as_ref())?
        }
    };
    let mut pooled = nominal::identify(&all, order)?;
    if plan.period.is_none() {
        // Windows smear the resonances: the rows themselves decide.
        let rows = plan.chosen(recording, FINAL_ROWS);
        let limits = Limits { steps: LINEAR_STEPS, decrease: 1e-4 };
        pooled = sensitivity::fit(&Looped::plain(pooled), &rows, limits).linear;
        return Some((pooled.clone(), pooled));
    }
    let start = if plan.groups.len() > 1 { nominal::identify(&low, order)? } else { pooled.clone() };
    Some((pooled, start))
}

/// A hysteresis that is worth its name.
struct Named {
    model: Looped,
    gain: (f64, f64),
    /// Whether a rival without memory does as well.
    rival: bool,
}

fn name(
    recording: &DynamicRecording,
    plan: &Plan,
    before: &Looped,
    linear: &Modal,
    fitting: &[Stretch],
    judged: &[Stretch],
) -> Option<Named> {
    let limits = |steps| Limits { steps, decrease: 2e-3 };
    let whole = plan.chosen(recording, FINAL_ROWS);
    let finish = |model: &Looped| {
        let (model, steps) = if whole.len() > fitting.len() {
            (sensitivity::fit(model, fitting, limits(STEPS - RIVAL_STEPS)), FINAL_STEPS)
        } else {
            (model.clone(), STEPS - RIVAL_STEPS)
        };
        sensitivity::fit(&model, &whole, limits(steps))
    };
    let first = hysteresis::fit(linear, fitting, true, limits(RIVAL_STEPS))?;
    // What does nothing after these steps will not be named after more.
    verdict::gain(before, &first, judged).filter(|g| g.0 > 0.0)?;
    let rival = hysteresis::fit(linear, fitting, false, limits(RIVAL_STEPS))
        .and_then(|rival| verdict::gain(&first, &rival, judged))
        .is_some_and(|(gain, _)| gain > -RIVAL);
    let model = finish(&first);
    let mut gain = verdict::gain(before, &model, judged)?;
    if plan.held().is_empty() {
        // Rows that were fitted flatter the larger model: as Akaike's final prediction error has it.
        let rows: usize = judged.iter().map(|s| s.position.len()).sum();
        let more = model.parameters().len().saturating_sub(before.parameters().len());
        gain.0 = 1.0 - (1.0 - gain.0) * (1.0 + 2.0 * more as f64 / rows.max(1) as f64);
    }
    verdict::worth(gain).then_some(Named { model, gain, rival })
}

/// Whether a model that the plant file states is one of this recording.
fn agrees(model: &Modal, recording: &DynamicRecording) -> bool {
    model.inputs == recording.drives.len()
        && model.outputs == recording.positions.len()
        && (model.step_s / recording.step_s - 1.0).abs() < 1e-3
}

/// The recording with the user's simulated position in the place of the measured one.
fn theirs(recording: &DynamicRecording, own: &OwnSimulation) -> Result<DynamicRecording, DiagnosisError> {
    match recording.positions.len() {
        1 => own.in_place(recording),
        found => Err(own.wrong("one `position`".into(), format!("a recording of one, not {found}"))),
    }
}

/// Free runs of every run by two models, row for row; what runs away stands still at zero.
fn predict(recording: &DynamicRecording, before: &Looped, after: &Looped) -> Predicted {
    Predicted::by(recording, [before, after], |model| {
        let p = recording.positions.len();
        let mut columns = vec![vec![0.0; recording.rows()]; p];
        for rows in &recording.runs {
            let Some(y) = free_run(model, recording, rows) else { continue };
            for (t, row) in y.chunks_exact(p).enumerate() {
                for (column, value) in columns.iter_mut().zip(row) {
                    column[rows.start + t] = *value;
                }
            }
        }
        columns
    })
}

/// Positions of one run, rows × outputs: in steady state where it is periodic, otherwise from the initial
/// state that its first rows give.
pub fn free_run(model: &Looped, recording: &DynamicRecording, rows: &Range<usize>) -> Option<Vec<f64>> {
    let period = plan::period(recording);
    let y = sensitivity::predict(model, &plan::stretch(recording, rows.clone(), period))?;
    Some(y.repeat(period.map_or(1, |length| rows.len() / length)))
}

/// Root mean square of recorded less predicted over the scored of the rows and all positions.
pub fn rms(recording: &DynamicRecording, predicted: &[Vec<f64>], rows: &[Range<usize>]) -> f64 {
    let rows = rows.iter().cloned().flatten().filter(|row| recording.scored(*row));
    score::rms(&recording.positions, predicted, rows).unwrap_or(0.0)
}

/// Standard deviation of a reading from the scatter over periods, and the correlation of successive ones.
fn period_noise(recording: &DynamicRecording, plan: &Plan) -> Option<(f64, f64)> {
    let length = plan.period?;
    let (mut sum, mut lagged, mut freedom) = (0.0, 0.0, 0.0);
    for run in &recording.runs {
        let periods = run.len() / length;
        if periods < 2 {
            return None;
        }
        for position in &recording.positions {
            let mean = mean_period(position, run, length);
            for period in position[run.clone()].chunks_exact(length) {
                let rest: Vec<f64> = period.iter().zip(&mean).map(|(v, m)| v - m).collect();
                sum += rest.iter().map(|r| r * r).sum::<f64>();
                lagged += rest.windows(2).map(|w| w[0] * w[1]).sum::<f64>();
            }
            freedom += ((periods - 1) * length) as f64;
        }
    }
    Some(((sum / freedom.max(1.0)).sqrt(), lagged / sum.max(f64::MIN_POSITIVE)))
}
