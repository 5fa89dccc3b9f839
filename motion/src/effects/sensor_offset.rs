//! The zero of the sensor: y = x + o.

use super::specification::{ANY, sign};
use super::{Action, Parameter, ReadOut, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "sensor_offset",
    title: "a constant part of the read-out",
    depends_on: &["position", "drive", "t_s"],
    parameters: &[Parameter { name: "offset", unit: "position unit", default: None, range: ANY }],
    build: |values, _| Ok(Action::ReadOut(Box::new(Zero { offset: values["offset"] }))),
    draw: |strength, typical, generator| vec![("offset", sign(generator) * strength * typical.position)],
};

#[derive(Debug)]
struct Zero {
    offset: f64,
}

impl ReadOut for Zero {
    fn read(&self, position: f64, _: &[f64], _: &mut [f64]) -> f64 {
        position + self.offset
    }
}
