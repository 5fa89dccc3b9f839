//! Units at the edges: angles are radians and lengths millimetres inside.

/// Arcseconds in one radian, 180·3600/π.
pub const ARCSEC_PER_RAD: f64 = 206_264.806_247_096_36;

/// Converts an angle from radians to arcseconds.
pub fn arcsec_from_rad(angle_rad: f64) -> f64 {
    angle_rad * ARCSEC_PER_RAD
}

/// Converts an angle from arcseconds to radians.
pub fn rad_from_arcsec(angle_arcsec: f64) -> f64 {
    angle_arcsec / ARCSEC_PER_RAD
}

/// Rounds `value` to `decimals` decimal places, to the `f64` that parsing the printed number gives back,
/// and never to a negative zero.
pub fn round_to(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}
