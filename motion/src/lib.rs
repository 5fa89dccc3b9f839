//! A moving mechanism in free run: a drive goes in, a position comes out.
//!
//! The mirror on its flexure with whatever acts in it ([`effects`]) is a [`Model`]: ordinary differential
//! equations that are integrated with adaptive steps ([`integrate`]). It is what `simulate` runs a plant file
//! by ([`simulate()`]). Nothing here knows who drew a mechanism, or how one is identified.

pub mod effects;
pub mod equations;
mod error;
pub mod integrate;
pub mod linear;
mod linear_loop;
pub mod mechanism;
pub mod model;
pub mod series;
pub mod signal;
pub mod simulate;
pub mod values;

pub use effects::{Context, Typical};
pub use error::RunError;
pub use mechanism::Mechanism;
pub use model::{Model, Start};
pub use series::Series;
pub use signal::{Edge, Flow, Signal};
pub use simulate::{Begin, simulate};
pub use values::EffectError;
