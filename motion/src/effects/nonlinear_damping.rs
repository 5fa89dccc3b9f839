//! Damping that grows with the deflection: x″ −= c·x²·v, of a film of air squeezed at either end of the
//! stroke.

use super::specification::ANY;
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "nonlinear_damping",
    title: "damping that grows with the deflection",
    depends_on: &["velocity", "position", "amplitude"],
    parameters: &[Parameter {
        name: "coefficient", unit: "1/(position unit² s)", default: None, range: ANY
    }],
    build: |values, _| Ok(Action::Force(Box::new(Term { coefficient: values["coefficient"] }))),
    draw: |strength, typical, _| {
        let moved = typical.position.powi(2) * typical.velocity;
        vec![("coefficient", strength * typical.acceleration() / moved)]
    },
};

#[derive(Debug)]
struct Term {
    coefficient: f64,
}

impl Force for Term {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.coefficient * at.x * at.x * at.v
    }
}
