//! The angular error that a device is built to have, Eq. 6 with the coefficients of Eq. 12, and its
//! inverse: which difference s the probes report when the mirror stands at a given true angle.

/// The published coefficients of Eq. 12, of Δs in millimetres as a polynomial of s in millimetres.
pub const PAPER: [f64; 10] = [-6.15e-5, 0.14, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4];

/// Beyond this |s| in millimetres no calibration is known: the pair of probes goes on along its tangent,
/// so that the reading stays monotone up to the mechanical stop.
pub const KNOWN_TO_MM: f64 = 0.42;

/// Angular error as a function of the reported difference s.
#[derive(Debug, Clone, PartialEq)]
pub struct AngularError {
    /// d in millimetres.
    pub probe_distance_mm: f64,
    /// a₀, a₁ − Δd/d, a₂ …, in mm¹⁻ⁱ.
    pub coefficients: Vec<f64>,
}

impl AngularError {
    /// Eq. 12, for probes 12 mm apart.
    pub fn paper() -> Self {
        Self { probe_distance_mm: 12.0, coefficients: PAPER.to_vec() }
    }

    /// The true angle in radians at which the pair reports s: atan(s/d) − Δθ(s), continued along its
    /// tangent beyond [`KNOWN_TO_MM`].
    pub fn true_angle_rad(&self, s_mm: f64) -> f64 {
        let inside = s_mm.clamp(-KNOWN_TO_MM, KNOWN_TO_MM);
        let (angle, slope) = self.angle_and_slope(inside);
        angle + slope * (s_mm - inside)
    }

    /// dΘ/ds in rad/mm.
    pub fn slope_rad_per_mm(&self, s_mm: f64) -> f64 {
        self.angle_and_slope(s_mm.clamp(-KNOWN_TO_MM, KNOWN_TO_MM)).1
    }

    /// The difference s in millimetres that the pair reports at the true angle Θ in radians: the root of
    /// atan(s/d) − Δθ(s) = Θ by Newton's method, held inside a shrinking bracket.
    pub fn reported_s_mm(&self, true_angle_rad: f64) -> f64 {
        let (at_rest, slope) = self.angle_and_slope(0.0);
        let end = KNOWN_TO_MM.copysign(true_angle_rad - at_rest);
        let (mut low, mut high) = (end.min(0.0), end.max(0.0));
        let mut s = (true_angle_rad - at_rest) / slope;
        if s.abs() > 0.7 * KNOWN_TO_MM {
            let (angle, slope) = self.angle_and_slope(end);
            if (true_angle_rad - angle) * end >= 0.0 {
                return end + (true_angle_rad - angle) / slope;
            }
            s = s.clamp(low, high);
        }
        for _ in 0..60 {
            let (angle, slope) = self.angle_and_slope(s);
            let excess = angle - true_angle_rad;
            if excess > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let newton = s - excess / slope;
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            // Newton's next step is smaller by far: 10⁻¹⁰ mm squared, times a curvature of the order of 1/mm.
            if (next - s).abs() < 1e-10 {
                return next;
            }
            s = next;
        }
        s
    }

    /// atan(s/d) − Δθ(s) in radians and its derivative in rad/mm.
    fn angle_and_slope(&self, s: f64) -> (f64, f64) {
        let d = self.probe_distance_mm;
        let (mut sum, mut derivative) = (0.0, 0.0);
        for a in self.coefficients.iter().rev() {
            derivative = derivative * s + sum;
            sum = sum * s + a;
        }
        let factor = d / (s * s + d * d);
        let factor_derivative = -2.0 * s / d * factor * factor;
        ((s / d).atan() - factor * sum, factor - factor * derivative - factor_derivative * sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_papers_device_errs_by_0_28_degrees_at_the_ends() {
        let paper = AngularError::paper();
        // θ = ±1.7° is the end of the calibration.
        let s = 12.0 * 1.7f64.to_radians().tan();
        let error_rad = |s: f64| (s / 12.0).atan() - paper.true_angle_rad(s);
        let largest = error_rad(-s).abs().max(error_rad(s).abs()).to_degrees();
        assert!((0.27..0.285).contains(&largest), "{largest}");
    }

    proptest! {
        #[test]
        fn the_inverse_returns(s in -0.5f64..0.5) {
            let paper = AngularError::paper();
            let back = paper.reported_s_mm(paper.true_angle_rad(s));
            // 10⁻¹² mm is 2·10⁻⁸ arcsec.
            prop_assert!((back - s).abs() < 1e-12);
        }

        #[test]
        fn the_true_angle_grows_with_s(s in -0.5f64..0.5, step in 1e-6f64..0.1) {
            let paper = AngularError::paper();
            prop_assert!(paper.true_angle_rad(s + step) > paper.true_angle_rad(s));
        }
    }
}
