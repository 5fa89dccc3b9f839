//! What was concealed in a dynamic recording.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::truth::CAN_TELL;

/// What a trial is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// Nothing concealed.
    Null,
    /// One effect of the table.
    Single,
    /// Two of them.
    Pair,
    /// Physics outside the table.
    Outside,
}

/// The truth of one recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    pub recording: String,
    pub group: Group,
    pub noise: String,
    pub excitation: String,
    /// How the drive runs between its samples.
    pub hold: String,
    /// Root mean square of the noise that is in the recording, in its position unit.
    pub noise_rms: f64,
    pub effects: Vec<Concealed>,
}

/// One concealed effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Concealed {
    pub id: String,
    pub parameters: BTreeMap<String, f64>,
    /// Root mean square of what it adds to the position.
    pub effect_rms: f64,
    /// ρ of the part that no other damping, stiffness and gain, and no other concealed effect takes up.
    pub rho: f64,
    /// Variables of which any may rightly be located first.
    pub depends_on: Vec<String>,
    /// The effect of the table that comes closest, and ρ of what it leaves.
    pub imitation: Option<(String, f64)>,
}

/// The part of an effect that another one has to leave so that the two can be told: less may be only what the
/// comparison of small changes neglects.
const PART: f64 = 0.03;

impl Concealed {
    /// Whether the recording can tell it from every other effect of the table.
    pub fn can_tell(&self) -> bool {
        distinguishable(self.imitation.as_ref(), self.rho)
    }
}

/// Whether a recording can tell an effect of `rho` from the one that comes closest and leaves so much of it.
pub fn distinguishable(imitation: Option<&(String, f64)>, rho: f64) -> bool {
    imitation.is_none_or(|(_, left)| *left >= CAN_TELL && *left >= PART * rho)
}

impl Truth {
    /// Whether the recording can tell every concealed effect from the others of the table.
    pub fn can_tell(&self) -> bool {
        self.effects.iter().all(Concealed::can_tell)
    }
}
