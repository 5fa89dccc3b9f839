//! What is said of two recordings, as it is written.

use serde::Serialize;

use crate::Verdict;
use crate::diagnosis::Diagnosis;
use crate::held_out::Gain;
use crate::verdict::Location;

use super::Quantity;

/// How something changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Kind {
    /// An effect is there that was not.
    Came,
    /// An effect that was there is not.
    Went,
    /// An effect is stronger, weaker or otherwise than it was.
    Moved,
    /// The base, which is what the reading says of the angle by itself.
    Base,
    /// The noise.
    Noise,
}

/// One change.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Change {
    /// Id of the effect; `gain`, `base`, `noise`, or `structure` without a name; in motion also `inertia`, or a parameter
    /// of the plant.
    pub id: String,
    /// Name for a reader.
    pub title: String,
    /// How it changed.
    pub kind: Kind,
    /// Where the difference lives; none of noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<Location>,
    /// Family-wise p-value over all that could have changed.
    pub p_value: f64,
    /// Root mean square of the difference over the later recording's rows, in the recording's unit; none of noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// Its parameters then and now.
    pub parameters: Vec<Quantity>,
    /// What else would explain the difference nearly as well, and effects that every recording which names this one cannot
    /// distinguish from it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<String>,
    /// The proof on held-out rows; none where nothing can be held out, and of noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}

/// What is left of held-out rows of both recordings, in the later one's unit; the earlier one's count by the ratio of their
/// noise.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct HeldOut {
    /// Root mean square with this part the same in both recordings.
    pub same: f64,
    /// Where it differs.
    pub changed: f64,
    /// The mean improvement over the passes (or blocks) that were held out.
    pub gain: Gain,
}

/// The smallest change that would have been seen.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Visible {
    /// Id of what would have changed; `new effect` of one that neither recording has.
    pub id: String,
    /// Root mean square of the difference over the later recording that is found in 95 of 100 such pairs, in the recording's
    /// unit: an estimate. None in motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// The same of its one parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameter: Option<(String, f64)>,
}

/// One of the recordings.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Side {
    /// File name.
    pub recording: String,
    /// Its own verdict.
    pub verdict: Verdict,
    /// Ids of what was found in it.
    pub effects: Vec<String>,
    /// Standard deviation of a reading's noise.
    pub noise: f64,
}

impl Side {
    pub(super) fn of(diagnosis: &Diagnosis) -> Side {
        Side {
            recording: diagnosis.recording.clone(),
            verdict: diagnosis.verdict,
            effects: diagnosis.effects.iter().map(|effect| effect.id.clone()).collect(),
            noise: diagnosis.noise_floor.value,
        }
    }
}

/// What changed between two recordings.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Comparison {
    /// Version of the format.
    pub schema: u32,
    /// `changed` or `unchanged`.
    pub verdict: &'static str,
    /// The unit of the error.
    pub unit: String,
    /// The earlier recording.
    pub then: Side,
    /// The later one.
    pub now: Side,
    /// The changes, the strongest first.
    pub changes: Vec<Change>,
    /// Root mean square of what the common model leaves of the later recording where nothing differs, and with the changes;
    /// in motion, where no model of both was made, what the earlier recording's model leaves of it, and its own.
    pub left: [f64; 2],
    /// Family-wise false alarms that are allowed.
    pub false_alarms: f64,
    /// How large a change of each kind would have been seen.
    pub would_have_seen: Vec<Visible>,
    /// What could not be compared, and what the comparison rests on, a sentence each.
    pub notes: Vec<String>,
}

/// A comparison with what its page is drawn from.
pub struct Compared {
    /// What is written.
    pub comparison: Comparison,
    /// What is drawn.
    pub points: Points,
}

/// The later recording over what the largest change depends on, over the angle where nothing changed.
pub struct Points {
    /// The observable, as in `locations`.
    pub variable: String,
    /// The observable, what a common model without changes leaves of the recording, and what the changes add.
    pub rows: Vec<[f64; 3]>,
}
