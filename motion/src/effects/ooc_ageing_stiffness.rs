//! Outside the table: a flexure that fatigues, or an adhesive that cures, while it is recorded: x″ −= r·t·x.

use super::specification::{ANY, sign};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_ageing_stiffness",
    title: "a stiffness that changes with time",
    depends_on: &["t_s"],
    parameters: &[Parameter { name: "stiffness_per_s", unit: "1/s³", default: None, range: ANY }],
    build: |values, _| Ok(Action::Force(Box::new(Ageing { rate: values["stiffness_per_s"] }))),
    draw: |strength, typical, generator| {
        let limit = 0.5 * typical.stiffness / typical.duration_s;
        let size = 2.0 * strength * typical.acceleration() / (typical.position * typical.duration_s);
        vec![("stiffness_per_s", sign(generator) * size.min(limit))]
    },
};

#[derive(Debug)]
struct Ageing {
    rate: f64,
}

impl Force for Ageing {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.rate * at.t_s * at.x
    }
}
