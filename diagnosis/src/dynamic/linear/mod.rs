//! The multivariable linear nominal of structures with many modes, and the one effect that such recordings
//! show and that a linear model cannot: hysteresis inside the loop.

pub mod hysteresis;
pub mod initial;
pub mod looped;
pub mod marquardt;
pub mod modal;
pub mod operator;
pub mod refine;
pub mod sensitivity;
pub mod subspace;
