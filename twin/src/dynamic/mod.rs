//! Moving mechanisms on their bench: the physics of [`motion`] under an [`Excitation`], or in the
//! [`PositionLoop`] of the paper.

pub mod bench;
pub mod excitation;
pub mod position_loop;
pub mod rig;

pub use bench::Bench;
pub use excitation::Excitation;
pub use motion::*;
pub use position_loop::PositionLoop;
