//! The drive takes effect later: w(t) = u(t − T), of a bus or a sampled controller.

use super::specification::NOT_NEGATIVE;
use super::{Action, DriveElement, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "transport_delay",
    title: "a delay of the drive",
    depends_on: &["frequency_hz", "acceleration", "velocity", "history"],
    parameters: &[Parameter { name: "delay_s", unit: "s", default: None, range: NOT_NEGATIVE }],
    build: |values, _| Ok(Action::Drive(Box::new(Late { delay_s: values["delay_s"] }))),
    draw: |strength, typical, _| vec![("delay_s", strength / typical.corner_rad_per_s())],
};

#[derive(Debug)]
struct Late {
    delay_s: f64,
}

impl DriveElement for Late {
    fn delay_s(&self) -> f64 {
        self.delay_s
    }
}
