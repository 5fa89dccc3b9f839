//! A spring that hardens (c > 0) or softens: x″ −= c·x³, the odd part of a flexure whose blades are stretched
//! as they bend.

use super::specification::{ANY, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "cubic_stiffness",
    title: "a spring that hardens or softens with the square of its deflection",
    depends_on: &["position", "amplitude", "acceleration"],
    parameters: &[Parameter {
        name: "coefficient",
        unit: "1/(position unit² s²)",
        default: None,
        range: ANY,
    }],
    build: |values, _| Ok(Action::Force(Box::new(Term { coefficient: values["coefficient"] }))),
    draw: |strength, typical, generator| {
        // A softening spring still pulls back over the whole stroke.
        let limit = 0.3 * typical.stiffness / typical.largest_position.powi(2);
        let size = strength * typical.acceleration() / typical.position.powi(3);
        let soft = uniform(generator, 0.0, 1.0) < 0.25;
        vec![("coefficient", if soft { -size.min(limit) } else { size })]
    },
};

#[derive(Debug)]
struct Term {
    coefficient: f64,
}

impl Force for Term {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.coefficient * at.x.powi(3)
    }
}
