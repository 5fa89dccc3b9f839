//! Outside the table: the autocollimator's mount reseats at random whenever the passes change, by a normal
//! deviate of its own for every pass.

use rand::RngExt;
use rand_distr::StandardNormal;

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::streams::{Stream, stream};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_reseating",
    title: "the mount reseats at random between passes",
    scope: Scope::Recording,
    depends_on: &["pass", "t_s", "history", "direction"],
    times: None,
    parameters: &[
        Parameter {
            name: "deviation_arcsec",
            unit: "arcsec",
            default: None,
            range: (0.0, 1e3),
            drawn: Drawn::PositiveStrength,
        },
        Parameter {
            name: "pattern",
            unit: "1",
            default: Some(1.0),
            range: (0.0, 4e9),
            drawn: Drawn::Whole(0, 1_000_000),
        },
    ],
    build: |values, _| {
        Ok(Box::new(Seat { deviation_arcsec: values["deviation_arcsec"], pattern: values["pattern"] as u64 }))
    },
};

#[derive(Debug, Clone)]
struct Seat {
    deviation_arcsec: f64,
    /// Seed of the deviates.
    pattern: u64,
}

impl Mechanism for Seat {
    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        let mut generator = stream(self.pattern, Stream::Seat(pose.pass));
        -self.deviation_arcsec * generator.sample::<f64, _>(StandardNormal)
    }
}
