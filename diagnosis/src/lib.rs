//! Locates where a calibration recording departs from its simulation, names the physics, models it, and
//! shows whether the fit improves; or says that the recording cannot tell.
//!
//! [`diagnose`] runs it all for a calibration: `observe` takes a recording apart into observables, `noise` measures the
//! floor and `correlation` how it hangs together in time, `dictionary` holds every candidate explanation, `calibrate`
//! learns by resampling how strong the strongest of them is when there is nothing, `search` chooses among them, `model`
//! fits what was chosen, `held_out` shows it on rows that were not fitted, `judge` holds the answer against itself, and
//! [`verdict`] says it. [`dynamic`] does the same for a moving mechanism, and [`fleet`] pools what many units show.
//!
//! ```
//! use diagnosis::{Options, Verdict, diagnose};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (recording, mirror) = fitter::default_recording()?;
//! let outcome = diagnose(&recording, &mirror, None, None, &Options::default())?;
//! assert_eq!(outcome.diagnosis.verdict, Verdict::Consistent);
//! assert!(outcome.diagnosis.effects.is_empty() && outcome.coefficients.is_some());
//! # Ok(())
//! # }
//! ```

mod alone;
mod ambiguity;
mod attempt;
mod averaging;
mod base;
mod bursts;
mod calibrate;
pub mod compare;
mod compose;
mod condense;
mod content;
mod correlation;
mod diagnosis;
mod dictionary;
pub mod dynamic;
pub mod effects;
mod error;
mod experiment;
mod explain;
pub mod fleet;
mod generic;
mod hand_on;
mod held_out;
mod intervals;
mod judge;
mod jumps;
mod lasting;
mod memory;
mod mixture;
mod model;
mod noise;
pub mod observe;
mod reach;
mod refit;
pub mod report;
mod rows;
mod screened;
mod search;
pub mod simulated;
mod slow_channel;
mod steps;
mod thresholds;
mod undecided;
pub mod verdict;

pub use diagnosis::{Diagnosis, NoiseFloor, Options, Outcome, diagnose};
pub use error::DiagnosisError;
pub use held_out::{Fit, Gain, Score};
pub use verdict::Verdict;
