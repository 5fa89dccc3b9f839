//! What acts in the two probes: their reports, and the distance between them.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification, reported};
use crate::environment::LABORATORY_C;
use crate::units::arcsec_from_rad;

/// γ·10⁻⁶ θ (T − T̄): the base expands and carries the probes apart, so that the same rotation moves the pads at the
/// probes further.
///
/// What that adds is proportional to the true angle; the table's θ is the calculated one, a nearly constant
/// factor larger. The expansion is chosen so that the two agree over the stroke.
pub(super) const THERMAL_GAIN_DRIFT: Specification = Specification {
    id: "thermal_gain_drift",
    title: "the gain drifts with the temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
    parameters: &[Parameter::strength("coefficient_ppm_per_k", "ppm/K", 2000.0)],
    build: |values, device| {
        let per_k = 1e-6 * values["coefficient_ppm_per_k"] / device.true_per_calculated();
        Ok(Box::new(Base { per_k }))
    },
};

#[derive(Clone)]
struct Base {
    per_k: f64,
}

impl Mechanism for Base {
    fn probe_distance(&self, pose: &Pose) -> f64 {
        1.0 + self.per_k * (pose.temperature_c - LABORATORY_C)
    }
}

/// λ (x₁+x₂)/2: the plate really moves along X, and the electronics that compare the two probes let a part of what they
/// have in common through, so that the movement does not cancel in s = x₂ − x₁.
///
/// A part g of (x₁+x₂)/2 is taken from one reading and added to the other: s becomes s + g (x₁+x₂), which adds
/// g (x₁+x₂)·dΘ/ds, and (x₁+x₂)/2 stays. dΘ/ds varies by a few per cent over the stroke; g is chosen for its mean.
pub(super) const COMMON_MODE_LEAKAGE: Specification = Specification {
    id: "common_mode_leakage",
    title: "common motion of the plate leaks into the angle",
    scope: Scope::Device,
    depends_on: &["common_mode_um"],
    parameters: &[Parameter::strength("coefficient_arcsec_per_um", "arcsec/µm", 20.0)],
    build: |values, device| {
        let arcsec_per_mm = 1e3 * values["coefficient_arcsec_per_um"];
        let part = 0.5 * arcsec_per_mm / device.arcsec_per_mm();
        reported(move |_, reports_mm| {
            let leaked = part * 0.5 * (reports_mm[0] + reports_mm[1]);
            reports_mm[0] -= leaked;
            reports_mm[1] += leaked;
        })
    },
};

/// η · i: the field of the voice coils reaches the probes, one from each side, and adds to their reports in proportion
/// to the current. The sensitivity dΘ/ds varies by a few per cent over the stroke; the pick-up is chosen for its mean.
pub(super) const COIL_CROSSTALK: Specification = Specification {
    id: "coil_crosstalk",
    title: "the coil current is picked up by the probes",
    scope: Scope::Device,
    depends_on: &["coil_a"],
    parameters: &[Parameter::strength("coefficient_arcsec_per_a", "arcsec/A", 1e4)],
    build: |values, device| {
        let mm_per_a = values["coefficient_arcsec_per_a"] / device.arcsec_per_mm();
        reported(move |pose, reports_mm| {
            let half = 0.5 * mm_per_a * pose.coil_a;
            reports_mm[0] -= half;
            reports_mm[1] += half;
        })
    },
};

/// A slope beyond a threshold on one side: the probe whose gap is wide there begins to lose sensitivity, probe 2 at
/// positive angles and probe 1 at negative ones.
///
/// Beyond the report x_c at the threshold the probe reports x_c + (1 − κ)(x − x_c). Per unit of the
/// calculated angle this adds b = −κ r m / (1 − κ r), with r the share of the probe in s and m = dΘ/dθ, both
/// at the threshold; κ follows from the wanted slope.
pub(super) const SENSOR_CLIPPING: Specification = Specification {
    id: "sensor_clipping",
    title: "one probe leaves its range on one side",
    scope: Scope::Device,
    depends_on: &["angle_deg"],
    parameters: &[
        Parameter::needed("threshold_deg", "deg", (-1.75, 1.75), Drawn::EitherSide(0.55, 0.8)),
        Parameter::strength("slope_arcsec_per_deg", "arcsec/deg", 1000.0),
    ],
    build: |values, device| {
        let threshold_deg = values["threshold_deg"];
        if threshold_deg == 0.0 {
            return Err("`threshold_deg` is 0: expected an angle on one side".to_owned());
        }
        let s_mm = device.geometry.probe_distance_mm * threshold_deg.to_radians().tan();
        let probe = if threshold_deg > 0.0 { 1 } else { 0 };
        let (reports_mm, shares) = device.reports_at(s_mm);
        let m = device.true_per_calculated_at(s_mm);
        let b = values["slope_arcsec_per_deg"] / 3600.0;
        // By symmetry the same on either side: a loss of sensitivity is a negative slope.
        let loss = -b / (m - b) / shares[probe].abs();
        let from_mm = reports_mm[probe];
        reported(move |_, reports_mm| {
            let beyond = reports_mm[probe] - from_mm;
            if beyond > 0.0 {
                reports_mm[probe] -= loss * beyond;
            }
        })
    },
};

/// A Gaussian bump in θ: a flaw in the pad of probe 2, which comes under the probe at one deflection. Place, width and
/// height at the probe follow from the geometry there.
pub(super) const LOCAL_DEFECT: Specification = Specification {
    id: "local_defect",
    title: "a flaw of a pad at one angle",
    scope: Scope::Device,
    depends_on: &["angle_deg"],
    parameters: &[
        Parameter::strength("height_arcsec", "arcsec", 1e3),
        Parameter::needed("centre_deg", "deg", (-1.75, 1.75), Drawn::EitherSide(0.0, 0.75)),
        Parameter::needed("width_deg", "deg", (0.005, 1.0), Drawn::FromSteps(0.8, 0.05)),
    ],
    build: |values, device| {
        let centre_rad = values["centre_deg"].to_radians();
        let d = device.geometry.probe_distance_mm;
        let s_mm = d * centre_rad.tan();
        let (reports_mm, shares) = device.reports_at(s_mm);
        let arcsec_per_mm = arcsec_from_rad(device.probes.error.slope_rad_per_mm(s_mm));
        let s_per_rad = d / centre_rad.cos().powi(2);
        let height_mm = values["height_arcsec"] / arcsec_per_mm;
        let centre_mm = reports_mm[1];
        let width_mm = shares[1] * s_per_rad * values["width_deg"].to_radians();
        reported(move |_, reports_mm| {
            let z = (reports_mm[1] - centre_mm) / width_mm;
            reports_mm[1] += height_mm * (-0.5 * z * z).exp();
        })
    },
};
