//! Moving mechanisms: a drive goes in, a position comes out.
//!
//! The mirror on its flexure with whatever acts in it ([`effects`]) is a [`Model`]: ordinary differential
//! equations that are integrated with adaptive steps ([`integrate`]). It runs on its [`Bench`] under an
//! excitation, in the [`PositionLoop`] of the paper, or, as a plant file, on any recorded drive
//! ([`simulate()`]).

pub mod bench;
pub mod effects;
pub mod excitation;
pub mod integrate;
pub mod linear;
mod linear_loop;
pub mod mechanism;
pub mod model;
pub mod position_loop;
pub mod series;
pub mod signal;
pub mod simulate;

pub use bench::Bench;
pub use effects::{Context, Typical};
pub use excitation::Excitation;
pub use integrate::SimulationError;
pub use mechanism::Mechanism;
pub use model::{Model, RunError, Start};
pub use position_loop::PositionLoop;
pub use series::Series;
pub use signal::{Edge, Signal};
pub use simulate::{Begin, simulate};
