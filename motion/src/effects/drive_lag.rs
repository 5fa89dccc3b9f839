//! The inductance of the coils: τ w′ = u − w.

use super::{Action, DriveElement, Parameter, Specification};
use crate::signal::Flow;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "drive_lag",
    title: "a drive that follows with a time constant",
    depends_on: &["frequency_hz", "acceleration", "velocity", "history"],
    parameters: &[Parameter {
        name: "time_constant_s",
        unit: "s",
        default: None,
        range: (f64::MIN_POSITIVE, f64::INFINITY),
    }],
    build: |values, _| Ok(Action::Drive(Box::new(Inductance { time_constant_s: values["time_constant_s"] }))),
    draw: |strength, typical, _| vec![("time_constant_s", strength / typical.corner_rad_per_s())],
};

#[derive(Debug)]
struct Inductance {
    time_constant_s: f64,
}

impl DriveElement for Inductance {
    fn states(&self) -> usize {
        1
    }

    fn pass(&self, _: f64, drive: Flow, own: &[f64], rates: &mut [f64]) -> Flow {
        rates[0] = (drive.value - own[0]) / self.time_constant_s;
        Flow { value: own[0], rate: rates[0] }
    }
}
