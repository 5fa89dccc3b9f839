//! Drift with time, ρ t: the table of the autocollimator creeps and turns it evenly.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "time_drift",
    title: "the zero drifts evenly with time",
    scope: Scope::Recording,
    depends_on: &["t_s"],
    times: None,
    parameters: &[Parameter {
        name: "rate_arcsec_per_h",
        unit: "arcsec/h",
        default: None,
        range: (-1e4, 1e4),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Table { arcsec_per_s: values["rate_arcsec_per_h"] / 3600.0 })),
};

#[derive(Debug, Clone)]
struct Table {
    arcsec_per_s: f64,
}

impl Mechanism for Table {
    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        -self.arcsec_per_s * pose.t_s
    }
}
