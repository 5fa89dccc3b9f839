//! Locates where a calibration recording departs from its simulation, names the physics, models it, and
//! shows whether the fit improves; or says that the recording cannot tell.

pub mod base;
pub mod calibrate;
pub mod dictionary;
pub mod effects;
pub mod explain;
pub mod generic;
pub mod linear;
pub mod noise;
pub mod observe;
pub mod rows;
pub mod search;
