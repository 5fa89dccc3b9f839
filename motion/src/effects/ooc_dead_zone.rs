//! Outside the table: the output stage of the amplifier has a gap around zero: w = 0 within ±z, u ∓ z beyond.

use super::specification::NOT_NEGATIVE;
use super::{Action, DriveElement, Parameter, Specification};
use crate::signal::Flow;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_dead_zone",
    title: "an amplifier that is dead around zero",
    depends_on: &["drive", "amplitude"],
    parameters: &[Parameter { name: "half_width", unit: "drive unit", default: None, range: NOT_NEGATIVE }],
    build: |values, _| Ok(Action::Drive(Box::new(Gap { half_width: values["half_width"] }))),
    draw: |strength, typical, _| vec![("half_width", strength * typical.drive)],
};

#[derive(Debug)]
struct Gap {
    half_width: f64,
}

impl DriveElement for Gap {
    fn pass(&self, _: f64, drive: Flow, _: &[f64], _: &mut [f64]) -> Flow {
        let value = drive.value - drive.value.clamp(-self.half_width, self.half_width);
        Flow { value, rate: if value == 0.0 { 0.0 } else { drive.rate } }
    }
}
