//! Units at the edges: angles are radians and lengths millimetres inside.

pub use fitter::units::{arcsec_from_rad, rad_from_arcsec};

/// Rounds `value` to `decimals` decimal places, to the `f64` that parsing the printed number gives back,
/// and never to a negative zero.
pub fn round_to(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}
