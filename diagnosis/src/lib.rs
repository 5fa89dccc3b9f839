//! Locates where a calibration recording departs from its simulation, names the physics, models it, and
//! shows whether the fit improves; or says that the recording cannot tell.
//!
//! [`diagnosis::diagnose`] runs it all: [`observe`] takes a recording apart into observables, [`noise`]
//! measures the floor and [`correlation`] how it hangs together in time, [`dictionary`] holds every candidate
//! explanation, [`calibrate`] learns by resampling how strong the strongest of them is when there is nothing,
//! [`search`] chooses among them, [`model`] fits what was chosen, [`held_out`] shows it on rows that were not fitted,
//! [`judge`] holds the answer against itself, and [`verdict`] says it.

pub mod attempt;
pub mod averaging;
pub mod base;
pub mod calibrate;
pub mod condense;
pub mod content;
pub mod correlation;
pub mod diagnosis;
pub mod dictionary;
pub mod dynamic;
pub mod effects;
pub mod experiment;
pub mod explain;
pub mod generic;
pub mod hand_on;
pub mod held_out;
pub mod intervals;
pub mod judge;
pub mod jumps;
pub mod linear;
pub mod memory;
pub mod mixture;
pub mod model;
pub mod noise;
pub mod observe;
mod reach;
pub mod refit;
pub mod report;
pub mod rows;
pub mod screened;
pub mod search;
pub mod simulated;
pub mod slow_channel;
pub mod steps;
mod thresholds;
pub mod verdict;

pub use diagnosis::{Diagnosis, Options, Outcome, diagnose};
