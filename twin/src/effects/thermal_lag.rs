//! Thermal lag, k (T_L − T̄) with τ dT_L/dt = T − T_L: the bracket turns with a temperature of its own,
//! which follows that of the base plate. Before the first reading it has followed it for long.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::environment::LABORATORY_C;
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "thermal_lag",
    title: "the zero follows the temperature with a delay",
    scope: Scope::Device,
    depends_on: &["temperature_c", "history", "t_s"],
    times: None,
    parameters: &[
        Parameter {
            name: "coefficient_arcsec_per_k",
            unit: "arcsec/K",
            default: None,
            range: (-100.0, 100.0),
            drawn: Drawn::Strength,
        },
        Parameter {
            name: "time_constant_s",
            unit: "s",
            default: None,
            range: (1.0, 1e5),
            drawn: Drawn::OfDuration(0.05, 0.2),
        },
    ],
    build: |values, _| {
        Ok(Box::new(Bracket {
            arcsec_per_k: values["coefficient_arcsec_per_k"],
            time_constant_s: values["time_constant_s"],
            last: None,
        }))
    },
};

#[derive(Debug, Clone)]
struct Bracket {
    arcsec_per_k: f64,
    time_constant_s: f64,
    last: Option<Last>,
}

/// Time, temperature of the base plate and of the bracket at the last reading.
#[derive(Debug, Clone, Copy)]
struct Last {
    t_s: f64,
    base_c: f64,
    bracket_c: f64,
}

impl Mechanism for Bracket {
    fn advance(&mut self, pose: &Pose) {
        let base_c = pose.temperature_c;
        let bracket_c = match self.last {
            None => base_c,
            Some(last) => {
                // Exact for a temperature that runs straight from reading to reading.
                let step_s = pose.t_s - last.t_s;
                let behind = if step_s > 0.0 { (base_c - last.base_c) / step_s } else { 0.0 };
                let behind = behind * self.time_constant_s;
                let kept = (-step_s / self.time_constant_s).exp();
                base_c - behind + (last.bracket_c - last.base_c + behind) * kept
            }
        };
        self.last = Some(Last { t_s: pose.t_s, base_c, bracket_c });
    }

    fn seen_rotation_rad(&self, _pose: &Pose) -> f64 {
        let bracket_c = self.last.map_or(LABORATORY_C, |last| last.bracket_c);
        rad_from_arcsec(self.arcsec_per_k * (bracket_c - LABORATORY_C))
    }
}
