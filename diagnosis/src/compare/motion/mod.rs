//! What changed between two recordings of a mechanism in motion. Each is diagnosed by itself, with the other to predict. Where
//! the mechanism runs free, one model of both recordings follows, in which each parameter is the same or differs; else their
//! parameters are held against each other.

mod apart;
mod joined;

use crate::Verdict;
use crate::diagnosis::Diagnosis;
use crate::dynamic::joint::Joint;
use crate::dynamic::{Case, DynamicOutcome, DynamicRecording, diagnose};
use crate::error::DiagnosisError;
use crate::thresholds::NORMAL_95;
use crate::thresholds::compare::FALSE_ALARMS;
use crate::verdict::Parameter;

use super::{Change, Comparison, Estimate, Quantity, Side};

/// Compares two recordings of a mechanism: `case` is that of the earlier one.
///
/// # Errors
/// [`DiagnosisError`] where one of them cannot be diagnosed.
pub fn compare(case: &Case, now: &DynamicRecording) -> Result<Comparison, DiagnosisError> {
    let then = case.recording;
    let of = |recording, held_out| diagnose(&Case { recording, held_out: Some(held_out), ..*case });
    let (a, b) = rayon::join(|| of(then, now), || of(now, then));
    let plant = &case.plant.plant;
    let pair = Pair { then: a?, now: b?, unit: plant.position_unit.clone() };
    let wider = pair.sides().map(wider);
    let joint = match (&pair.then.model, &pair.now.model) {
        (Some(a), Some(b)) => Joint::new([then, now], [a, b], wider),
        _ => None,
    };
    Ok(joint.map_or_else(|| pair.apart(), |joint| pair.joined(&joint, plant)))
}

struct Pair {
    then: DynamicOutcome,
    now: DynamicOutcome,
    unit: String,
}

impl Pair {
    fn sides(&self) -> [&Diagnosis; 2] {
        [&self.then.diagnosis, &self.now.diagnosis]
    }

    /// The comparison in which this changed; `left` is as in [`Comparison`].
    fn of(&self, changes: Vec<Change>, left: [f64; 2]) -> Comparison {
        let [then, now] = self.sides();
        let structured = [then, now].into_iter().filter(|d| structured(d.verdict));
        let note = |d: &Diagnosis| {
            format!(
                "{}: structure is left that no effect explains; standard errors are taken for {:.2} times as large, as what is \
                 left is so many times the noise: an estimate",
                d.recording,
                wider(d)
            )
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

/// By how much standard errors are too small beside structure that is left (Birge's ratio).
fn wider(d: &Diagnosis) -> f64 {
    if structured(d.verdict) { (d.fit.after.train_rms / d.noise_floor.value).max(1.0) } else { 1.0 }
}

fn structured(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::PartlyExplained | Verdict::Unexplained)
}
