//! What changed between two recordings of a mechanism in motion. Each is diagnosed by itself, with the other to predict. Where
//! the mechanism runs free, one model of both recordings follows, in which each parameter is the same or differs; else their
//! parameters are held against each other.

mod apart;
mod best_name;
mod joined;

use numerics::{centred, parallel, rms};

use crate::Verdict;
use crate::diagnosis::Diagnosis;
use crate::dynamic::joint::Joint;
use crate::dynamic::{Case, DynamicOutcome, DynamicRecording, Options, diagnose, feedback, place};
use crate::error::DiagnosisError;
use crate::thresholds::NORMAL_95;
use crate::thresholds::compare::{FALSE_ALARMS, SAME_MOTION};
use crate::verdict::{Location, Parameter};

use self::best_name::with_best_name;
use super::{Change, Comparison, Estimate, Quantity, Side};

/// Compares two recordings of a mechanism: `case` is that of the earlier one.
///
/// # Errors
/// [`DiagnosisError`] where one of them cannot be diagnosed.
pub fn compare(case: &Case, now: &DynamicRecording) -> Result<Comparison, DiagnosisError> {
    let (then, plant) = (case.recording, &case.plant.plant);
    // Under feedback what is estimated depends on how far up the motion is looked at.
    let cutoff_hz = plant.feedback.as_ref().map(|_| feedback::cutoff(then).min(feedback::cutoff(now)));
    let same_motion = same_motion([then, now]);
    let options = Options { cutoff_hz, same_motion, ..case.options.clone() };
    let of = |recording, held_out| {
        diagnose(&Case { recording, held_out: Some(held_out), options: &options, ..*case })
    };
    let (a, b) = parallel::join(|| of(then, now), || of(now, then));
    let pair = Pair {
        recording: now,
        then: a?,
        now: b?,
        unit: if plant.feedback.is_some() { plant.drive_unit.clone() } else { plant.position_unit.clone() },
        under_feedback: plant.feedback.is_some(),
        same_motion,
    };
    let wider = pair.wider();
    let joint = match (&pair.then.model, &pair.now.model) {
        (Some(a), Some(b)) => Joint::new([then, now], [a, b], wider)
            .map(|joint| with_best_name(joint, [then, now], [a, b], wider, &options.skip)),
        _ => None,
    };
    Ok(joint.map_or_else(|| pair.apart(), |joint| pair.joined(&joint, plant)))
}

/// Whether both positions go the same way, as where the same move is commanded again.
fn same_motion(recordings: [&DynamicRecording; 2]) -> bool {
    let [then, now] = recordings.map(|recording| &recording.positions[0][..]);
    if then.len().abs_diff(now.len()) as f64 > SAME_MOTION * then.len() as f64 {
        return false;
    }
    let apart: Vec<f64> = then.iter().zip(now).map(|(then, now)| now - then).collect();
    rms(&centred(&apart)) < SAME_MOTION * rms(&centred(then))
}

struct Pair<'a> {
    /// The later recording.
    recording: &'a DynamicRecording,
    then: DynamicOutcome,
    now: DynamicOutcome,
    unit: String,
    under_feedback: bool,
    same_motion: bool,
}

impl Pair<'_> {
    fn sides(&self) -> [&Diagnosis; 2] {
        [&self.then.diagnosis, &self.now.diagnosis]
    }

    /// By how much the standard errors of each are too small beside structure that is left (Birge's ratio). Under feedback they
    /// allow for it already.
    fn wider(&self) -> [f64; 2] {
        let birge = |d: &Diagnosis| (d.fit.after.train_rms / d.noise_floor.value).max(1.0);
        self.sides().map(|d| if structured(d.verdict) && !self.under_feedback { birge(d) } else { 1.0 })
    }

    /// Where a change lives in the later recording.
    fn place(&self, id: &str, p_value: f64) -> Option<Location> {
        place(id, self.recording, p_value)
    }

    /// The comparison in which this changed; `left` is as in [`Comparison`].
    fn of(&self, changes: Vec<Change>, left: [f64; 2]) -> Comparison {
        let [then, now] = self.sides();
        let structured = [then, now].into_iter().zip(self.wider()).filter(|(d, _)| structured(d.verdict));
        let note = |(d, wider): (&Diagnosis, f64)| {
            let errors = if wider > 1.0 {
                format!(
                    "are taken for {wider:.2} times as large, as what is left is so many times the noise: an estimate"
                )
            } else if self.under_feedback && self.same_motion {
                "are those of the noise, as both follow the same motion".into()
            } else if self.under_feedback {
                "are by how much parts of the recording disagree".into()
            } else {
                "allow for none of it, as no more is left than noise".into()
            };
            format!("{}: structure is left that no effect explains; standard errors {errors}", d.recording)
        };
        Comparison {
            schema: 1,
            verdict: if changes.is_empty() { "unchanged" } else { "changed" },
            unit: self.unit.clone(),
            then: Side::of(then),
            now: Side::of(now),
            changes,
            left,
            false_alarms: FALSE_ALARMS,
            would_have_seen: Vec::new(),
            notes: structured.map(note).collect(),
        }
    }
}

/// A parameter then and now; `error` is the standard error of its difference.
fn quantity(then: &Parameter, now: &Parameter, error: f64) -> Quantity {
    let estimate = |p: &Parameter| Estimate { value: p.value, ci95: p.ci95 };
    Quantity {
        name: then.name.clone(),
        unit: then.unit.clone(),
        then: Some(estimate(then)),
        now: Some(estimate(now)),
        difference: Some(Estimate::new(now.value - then.value, NORMAL_95 * error)),
    }
}

fn structured(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::PartlyExplained | Verdict::Unexplained)
}
