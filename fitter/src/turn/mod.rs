//! A direct sensor that turns round and round (an encoder, a resolver): its error repeats with the turn, so
//! that harmonics of the turn take the place of a polynomial.
//!
//! With r the reference (the true position) and m the reading,
//! m − r = c + P(r) + k·(m − m₀) + h·direction − τ·dm/dt: a constant, harmonics 1 … K of the turn, a slope over the
//! travelled angle, half the distance between forward and backward, and the lag of a moving reading. c goes into the
//! base polynomial, of order 0; P into a term `periodic`, whose number of harmonics is chosen by held-out error. k and τ
//! go into terms of their own where they are significant (`correct.rs`): neither is in a single reading, so `apply`
//! corrects them and a routine *counts in → counts out* does not. h is reported and not corrected, because a reading does
//! not tell where it came from. The harmonics are of the *true* position: an eccentric scale then needs one, and the
//! quantisation of the reading stays on the side of the error, where least squares expects it.

mod arc;
#[cfg(feature = "fit")]
mod beside;
#[cfg(feature = "fit")]
mod correct;
mod description;
#[cfg(feature = "fit")]
mod direction;
#[cfg(feature = "fit")]
mod fit;
#[cfg(feature = "fit")]
mod found;
#[cfg(feature = "fit")]
mod harmonics;
#[cfg(feature = "fit")]
mod significance;
#[cfg(feature = "fit")]
mod solve;
mod travelled;
#[cfg(feature = "fit")]
mod unwind;

use serde::{Deserialize, Serialize};

use crate::coefficients::{Coefficients, OrderSelection};
use crate::terms::{Operator, Periodic};

pub use description::{Directions, Estimate, Left, Slope};
#[cfg(feature = "fit")]
pub(crate) use direction::part;
#[cfg(feature = "fit")]
pub(crate) use fit::fit;
#[cfg(feature = "fit")]
pub(crate) use harmonics::{Harmonics, MAX_HARMONICS};
pub(crate) use travelled::{nearest, travelled, travelled_about};
#[cfg(feature = "fit")]
pub(crate) use unwind::{Unwound, unwind};

/// What the coefficients file says of a sensor that turns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// One whole turn in the sensor's unit.
    pub revolution: f64,
    /// Where the turn begins in which readings are counted: they lie from here to here + `revolution`.
    pub from: f64,
    /// Whether the recording's readings count the turns, so that a corrected reading keeps its turn;
    /// otherwise it is brought back into the turn that begins at `from` (of a part of a turn it stays beside
    /// its reading).
    pub counts_turns: bool,
    /// Whether the whole turn was recorded and harmonics were fitted to it; otherwise a polynomial to a part.
    pub whole: bool,
    /// How often the recorded reading, and the reference, passed from the end of the turn to its beginning
    /// or back.
    pub wraps: Wraps,
    /// How the number of harmonics was chosen (`order` stands for it throughout); none for a part of a turn,
    /// or where there was too little to choose with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<OrderSelection>,
    /// The harmonics as amplitude and phase, in the sensor's unit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub amplitudes: Vec<Amplitude>,
    /// Forward and backward, told apart as far as the recording allows.
    pub directions: Directions,
    /// What grows over the turn and does not repeat with it; none where nothing does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope: Option<Slope>,
    /// What is left where slope or lag are not corrected; none where the harmonics are all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<Left>,
}

/// See [`Turn::wraps`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wraps {
    /// In the column `measured`.
    pub measured: usize,
    /// In the column `reference`.
    pub reference: usize,
}

/// One harmonic: amplitude·cos(2πk r/revolution − phase).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Amplitude {
    /// k, periods in a turn.
    pub harmonic: u16,
    /// In the sensor's unit.
    pub amplitude: f64,
    /// In degrees of this harmonic, −180 … 180.
    pub phase_deg: f64,
    /// Standard error of the amplitude; none where no freedom is left to tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
}

impl Turn {
    /// The reading within the turn that begins at `from`, and how many turns were taken off.
    pub fn within(&self, reading: f64) -> (f64, f64) {
        let turns = ((reading - self.from) / self.revolution).floor();
        let mut within = reading - turns * self.revolution;
        // A reading a hair below the beginning may round to the end, which is the beginning.
        if within >= self.from + self.revolution {
            within = self.from;
            return (within, turns + 1.0);
        }
        (within, turns)
    }

    /// What contradicts itself; none if it can be evaluated.
    pub(crate) fn contradiction(&self) -> Option<String> {
        if !(self.revolution.is_finite() && self.revolution > 0.0) {
            return Some(format!("`turn.revolution` is {}", self.revolution));
        }
        (!self.from.is_finite()).then(|| format!("`turn.from` is {}", self.from))
    }
}

/// The corrected reading of a sensor that turns, from its reading alone: readings one turn apart give results
/// one turn apart, or, unless turns are counted, the same to the last bit. Terms other than `periodic` are
/// left out: what they depend on is not in the reading. None if the coefficients are of another sensor.
///
/// # Example
/// ```
/// # use fitter::{ErrorModel, Sensor, Coefficients};
/// let sensor = Sensor::Direct { unit: "counts".into(), revolution: Some(1024.0) };
/// let model = ErrorModel { sensor, centre: 512.0, coefficients: vec![3.0] };
/// let mut file = Coefficients::of_model(&model, 0.0, 1024.0, "example");
/// file.turn = Some(fitter::turn::Turn::single(1024.0));
/// assert_eq!(fitter::turn::corrected(&file, 1.0), Some(1022.0));
/// ```
pub fn corrected(file: &Coefficients, reading: f64) -> Option<f64> {
    let turn = file.turn.as_ref()?;
    let (within, turns) = turn.within(reading);
    let terms: Vec<(&Periodic, &[f64])> = (file.terms.iter())
        .filter_map(|term| match &term.operator {
            Operator::Periodic(periodic) => Some((periodic, term.coefficients.as_slice())),
            _ => None,
        })
        .collect();
    let less_base = within - base_error(file, turn, within);
    Some(turn.finish(crate::terms::solve_periodic(&terms, less_base), turns))
}

/// The base error at a reading within the turn: outside the arc that a polynomial was fitted to, its line.
pub(crate) fn base_error(file: &Coefficients, turn: &Turn, within: f64) -> f64 {
    let inside = turn.whole || file.valid_range.contains(within);
    if inside { file.error_model().error(within) } else { file.error_beyond(within) }
}

impl Turn {
    /// A sensor that counts one turn from 0, for a file that was not fitted here.
    pub fn single(revolution: f64) -> Turn {
        Turn {
            revolution,
            from: 0.0,
            counts_turns: false,
            whole: true,
            wraps: Wraps { measured: 0, reference: 0 },
            harmonics: None,
            amplitudes: Vec::new(),
            directions: Directions::default(),
            slope: None,
            left: None,
        }
    }

    /// A corrected reading of the turn that `within` cut out, as the file counts.
    pub(crate) fn finish(&self, corrected: f64, turns: f64) -> f64 {
        let one_turn = self.whole && !self.counts_turns;
        if one_turn { self.within(corrected).0 } else { corrected + turns * self.revolution }
    }
}
