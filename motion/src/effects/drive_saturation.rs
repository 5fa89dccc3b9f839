//! The amplifier gives no more than its limit: w = u within ±limit.

use super::{Action, DriveElement, Parameter, Specification};
use crate::signal::Flow;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "drive_saturation",
    title: "an amplifier at its limit",
    depends_on: &["drive", "amplitude"],
    parameters: &[Parameter {
        name: "limit",
        unit: "drive unit",
        default: None,
        range: (f64::MIN_POSITIVE, f64::INFINITY),
    }],
    build: |values, _| Ok(Action::Drive(Box::new(Amplifier { limit: values["limit"] }))),
    draw: |strength, typical, _| vec![("limit", typical.largest_drive * (1.0 - strength).max(0.1))],
};

#[derive(Debug)]
struct Amplifier {
    limit: f64,
}

impl DriveElement for Amplifier {
    fn pass(&self, _: f64, drive: Flow, _: &[f64], _: &mut [f64]) -> Flow {
        let value = drive.value.clamp(-self.limit, self.limit);
        Flow { value, rate: if value == drive.value { drive.rate } else { 0.0 } }
    }
}
