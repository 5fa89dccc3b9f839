//! The proof on moving mechanisms: dynamic recordings with effects concealed in them.

pub mod campaign;
pub mod draw;
pub mod examples;
pub mod feedback;
pub mod matched;
pub mod nearest_effect;
pub mod plan;
pub mod report;
pub mod score;
pub mod truth;
