//! Moving mechanisms on their bench: the physics of [`motion`] under an [`Excitation`], a linear drive in its loop, or the
//! [`PositionLoop`] of the paper.

pub mod bench;
pub mod drive_loop;
pub mod excitation;
pub mod position_loop;
pub mod rig;

pub use bench::Bench;
pub use excitation::Excitation;
pub use motion::*;
pub use position_loop::PositionLoop;
