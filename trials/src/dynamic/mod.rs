//! The proof on moving mechanisms: dynamic recordings with effects concealed in them.

pub mod campaign;
pub(crate) mod draw;
pub mod examples;
pub mod feedback;
mod matched;
pub(crate) mod nearest_effect;
pub(crate) mod plan;
pub mod report;
pub mod score;
pub(crate) mod truth;
