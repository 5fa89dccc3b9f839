//! The plate and the two probes, Eq. 1–3: displacements of the pads for a rotation about the axis and a
//! translation of the plate along X.

/// Where the probes sit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// d, the design distance between the axes of the two probes, in millimetres.
    pub probe_distance_mm: f64,
    /// x₁₀ = x₂₀, the distance of either probe from its pad at rest, in millimetres.
    pub initial_gap_mm: f64,
}

impl Default for Geometry {
    /// The paper's mirror: 12 mm between the probes, 0.3 mm from each to its pad.
    fn default() -> Self {
        Self { probe_distance_mm: 12.0, initial_gap_mm: 0.3 }
    }
}

impl Geometry {
    /// The distances x₁₁ and x₂₁ in millimetres from the probes to the pads when the plate has turned by
    /// `angle_rad` about the axis, midway between the probes, and moved by `translation_mm` along X.
    ///
    /// The probes stand still and look along X, so a plane plate moves by Y·tan Θ at the height Y of a
    /// probe.
    pub fn pad_distances_mm(&self, angle_rad: f64, translation_mm: f64) -> [f64; 2] {
        let lever = 0.5 * self.probe_distance_mm * angle_rad.tan();
        let rest = self.initial_gap_mm + translation_mm;
        [rest - lever, rest + lever]
    }
}

/// The calculated angle θ = atan((x₂ − x₁)/d) of Eq. 1 in radians, everything in millimetres.
pub fn calculated_angle_rad(x1_mm: f64, x2_mm: f64, probe_distance_mm: f64) -> f64 {
    ((x2_mm - x1_mm) / probe_distance_mm).atan()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ideal_probes_measure_the_angle_whatever_the_translation() {
        let geometry = Geometry::default();
        for angle_rad in [-0.025, -1e-4, 0.0, 0.02] {
            for translation_mm in [-0.01, 0.0, 0.003] {
                let [x11, x21] = geometry.pad_distances_mm(angle_rad, translation_mm);
                let gap = geometry.initial_gap_mm;
                let measured = calculated_angle_rad(x11 - gap, x21 - gap, 12.0);
                approx::assert_abs_diff_eq!(measured, angle_rad, epsilon = 1e-15);
            }
        }
    }
}
