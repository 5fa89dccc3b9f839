//! The proof on moving mechanisms: dynamic recordings with effects concealed in them.

pub mod campaign;
mod draw;
pub mod examples;
pub mod feedback;
mod matched;
mod nearest_effect;
mod plan;
pub mod report;
pub mod score;
mod truth;
