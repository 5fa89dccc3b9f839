//! Units at the edges: angles are radians and lengths millimetres inside, and every other unit stands
//! in a name. This is the only place where a conversion factor is written down.

/// Arcseconds in one radian, 180·3600/π, to the last bit of an `f64`.
pub const ARCSEC_PER_RAD: f64 = 206_264.806_247_096_36;

/// Converts an angle from radians to arcseconds.
pub fn arcsec_from_rad(angle_rad: f64) -> f64 {
    angle_rad * ARCSEC_PER_RAD
}

/// Converts an angle from arcseconds to radians.
pub fn rad_from_arcsec(angle_arcsec: f64) -> f64 {
    angle_arcsec / ARCSEC_PER_RAD
}
