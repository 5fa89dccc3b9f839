//! Outside the table: damping that is larger on one side than on the other, x″ −= c·x·v, of a magnet that is
//! not centred in its eddy-current damper.

use super::specification::{ANY, sign};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_position_damping",
    title: "damping that changes its sign with the side",
    depends_on: &["velocity", "position"],
    parameters: &[Parameter { name: "coefficient", unit: "1/(position unit s)", default: None, range: ANY }],
    build: |values, _| Ok(Action::Force(Box::new(Term { coefficient: values["coefficient"] }))),
    draw: |strength, typical, generator| {
        // The mechanism stays damped over the whole stroke.
        let limit = 0.8 * typical.damping / typical.largest_position;
        let size = strength * typical.acceleration() / (typical.position * typical.velocity);
        vec![("coefficient", sign(generator) * size.min(limit))]
    },
};

#[derive(Debug)]
struct Term {
    coefficient: f64,
}

impl Force for Term {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.coefficient * at.x * at.v
    }
}
