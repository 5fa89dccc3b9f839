//! Sensor clipping, a slope beyond a threshold on one side: the probe whose gap is wide there begins to
//! lose sensitivity, probe 2 at positive angles and probe 1 at negative ones.
//!
//! Beyond the report x_c at the threshold the probe reports x_c + (1 − κ)(x − x_c). Per unit of the
//! calculated angle this adds b = −κ r m / (1 − κ r), with r the share of the probe in s and m = dΘ/dθ, both
//! at the threshold; κ follows from the wanted slope.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "sensor_clipping",
    title: "one probe leaves its range on one side",
    scope: Scope::Device,
    depends_on: &["angle_deg"],
    times: None,
    parameters: &[
        Parameter {
            name: "threshold_deg",
            unit: "deg",
            default: None,
            range: (-1.75, 1.75),
            drawn: Drawn::EitherSide(0.55, 0.8),
        },
        Parameter {
            name: "slope_arcsec_per_deg",
            unit: "arcsec/deg",
            default: None,
            range: (-1000.0, 1000.0),
            drawn: Drawn::Strength,
        },
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
        Ok(Box::new(WideGap { probe, from_mm: reports_mm[probe], loss }))
    },
};

#[derive(Debug, Clone)]
struct WideGap {
    /// 0 or 1.
    probe: usize,
    /// x_c, reports beyond which are affected.
    from_mm: f64,
    /// κ.
    loss: f64,
}

impl Mechanism for WideGap {
    fn report(&self, _pose: &Pose, reports_mm: &mut [f64; 2]) {
        let beyond = reports_mm[self.probe] - self.from_mm;
        if beyond > 0.0 {
            reports_mm[self.probe] -= self.loss * beyond;
        }
    }
}
