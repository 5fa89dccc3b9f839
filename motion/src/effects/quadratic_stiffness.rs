//! A spring that is stiffer on one side: x″ −= c·x², of a flexure that was mounted bent.

use super::specification::{ANY, sign};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "quadratic_stiffness",
    title: "a spring that is stiffer on one side",
    depends_on: &["position", "amplitude"],
    parameters: &[Parameter {
        name: "coefficient", unit: "1/(position unit s²)", default: None, range: ANY
    }],
    build: |values, _| Ok(Action::Force(Box::new(Term { coefficient: values["coefficient"] }))),
    draw: |strength, typical, generator| {
        // It still pulls back on the soft side.
        let limit = 0.3 * typical.stiffness / typical.largest_position;
        let size = strength * typical.acceleration() / typical.position.powi(2);
        vec![("coefficient", sign(generator) * size.min(limit))]
    },
};

#[derive(Debug)]
struct Term {
    coefficient: f64,
}

impl Force for Term {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.coefficient * at.x * at.x
    }
}
