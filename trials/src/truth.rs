//! What was concealed in each recording, sealed until every answer is in.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// What a trial is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// Nothing concealed.
    Null,
    /// One effect from below to just above detection: the curve.
    Weak,
    /// One effect that can be seen.
    Strong,
    /// A step of at least 3.5 σ.
    Step,
    /// Two effects.
    Pair,
    /// Three effects.
    Triple,
    /// The temperature ran with time, and something went with one of the two.
    Ambiguous,
    /// Physics outside the table of effects.
    Outside,
    /// One effect that is found for certain, in a given schedule: how often its intervals hold the truth.
    Interval,
    /// One to three effects of any strength, whose device is recorded twice.
    Twice,
}

/// The truth of one recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// The file.
    pub recording: String,
    /// What it is for.
    pub group: Group,
    /// Noise family.
    pub family: String,
    /// Schedule.
    pub schedule: String,
    /// What the temperature did.
    pub temperature: String,
    /// Root mean square of the noise of Δθ_M in arcseconds.
    pub noise_arcsec: f64,
    /// What was concealed.
    pub effects: Vec<Concealed>,
    /// Whether a fresh recording of the device shows the same effects, so that it can be compared with.
    pub fresh_is_fair: bool,
}

/// One concealed effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Concealed {
    /// Its id.
    pub id: String,
    /// Its parameters as named in the table of effects.
    pub parameters: std::collections::BTreeMap<String, f64>,
    /// ρ.
    pub rho: f64,
    /// Variables of which any may rightly be located first.
    pub depends_on: Vec<String>,
    /// The catalogued effect that comes closest, and ρ of what it leaves.
    pub imitation: Option<(String, f64)>,
    /// Of a step: the time of the row before the row before it, and of the row after it, between which a
    /// reported time is right to within one row.
    pub step_window_s: Option<[f64; 2]>,
}

/// ρ of what the closest imitation leaves, from which on a recording can tell the two apart: even between two
/// fully known shapes the wrong one is taken with the probability Φ(−ρ/2), 2 % here.
pub const CAN_TELL: f64 = 4.1;

impl Truth {
    /// Whether nothing but the temperature that ran with time stands in the way of a name.
    pub fn ambiguous(&self) -> bool {
        self.group == Group::Ambiguous
    }

    /// Whether the recording can tell every concealed effect from the others of the table.
    pub fn can_tell(&self) -> bool {
        let distinct = |e: &Concealed| e.imitation.as_ref().is_none_or(|(_, left)| *left >= CAN_TELL);
        !self.ambiguous() && self.effects.iter().all(distinct)
    }

    /// The least ρ of the concealed effects.
    pub fn least_rho(&self) -> f64 {
        self.effects.iter().map(|e| e.rho).fold(f64::INFINITY, f64::min)
    }

    /// The ids, sorted.
    pub fn ids(&self) -> Vec<&str> {
        let mut ids: Vec<&str> = self.effects.iter().map(|e| e.id.as_str()).collect();
        ids.sort_unstable();
        ids
    }
}

/// All truths as the text that is sealed, and its SHA-256.
pub fn seal<T: Serialize>(truths: &[&T]) -> (String, String) {
    let mut text = String::new();
    for truth in truths {
        // Plain numbers, names and lists: cannot fail.
        text += &serde_json::to_string(truth).unwrap_or_default();
        text.push('\n');
    }
    let hash = Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    (text, hash)
}
