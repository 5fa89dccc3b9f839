//! The amplifier adds a constant: w = u + o. Under feedback the drive is what is predicted and the constant
//! is part of it: w = u − o.

use super::specification::{ANY, sign};
use super::{Action, DriveElement, Parameter, Specification};
use crate::signal::Flow;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "drive_offset",
    title: "a constant part of the drive",
    depends_on: &["position", "drive", "t_s"],
    parameters: &[Parameter { name: "offset", unit: "drive unit", default: None, range: ANY }],
    build: |values, context| {
        let sign = if context.feedback { -1.0 } else { 1.0 };
        Ok(Action::Drive(Box::new(Constant { added: sign * values["offset"] })))
    },
    draw: |strength, typical, generator| vec![("offset", sign(generator) * strength * typical.drive)],
};

#[derive(Debug)]
struct Constant {
    added: f64,
}

impl DriveElement for Constant {
    fn pass(&self, _: f64, drive: Flow, _: &[f64], _: &mut [f64]) -> Flow {
        Flow { value: drive.value + self.added, rate: drive.rate }
    }
}
