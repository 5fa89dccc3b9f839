//! What many units of one kind show together: estimates of every unit, forced where its own diagnosis names nothing,
//! pooled over the fleet.
//!
//! `forced` holds what one recording says of every effect, named in it or not; `pooled` is the random-effects model of
//! one parameter over the units; `together` seeks the effects that the fleet shows, each unit's share of them too weak to
//! be named; `outlying` says which unit departs from the others. Nothing here reads a file.

mod forced;
mod outlying;
mod pooled;
mod together;

pub use crate::thresholds::fleet::FALSE_ALARMS;
pub use forced::{Forced, Test};
pub use outlying::{Outlying, outlying};
pub use pooled::{Estimate, Lots, Pooled, Trend, lots, pool, trend};
pub use together::{Shared, of_others, shared};
