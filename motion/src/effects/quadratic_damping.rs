//! Turbulent drag of the air that the plate moves: x″ −= c·v·|v|.

use super::specification::NOT_NEGATIVE;
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "quadratic_damping",
    title: "drag with the square of the velocity",
    depends_on: &["velocity", "amplitude"],
    parameters: &[Parameter {
        name: "coefficient",
        unit: "1/position unit",
        default: None,
        range: NOT_NEGATIVE,
    }],
    build: |values, _| Ok(Action::Force(Box::new(Term { coefficient: values["coefficient"] }))),
    draw: |strength, typical, _| {
        vec![("coefficient", strength * typical.acceleration() / typical.velocity.powi(2))]
    },
};

#[derive(Debug)]
struct Term {
    coefficient: f64,
}

impl Force for Term {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.coefficient * at.v * at.v.abs()
    }
}
