//! Outside the table: the field of the coils pulls on the iron of the mount, so that the stiffness depends on
//! the drive: x″ −= c·w·x.

use super::specification::{ANY, sign};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_drive_stiffness",
    title: "a stiffness that depends on the drive",
    depends_on: &["drive", "position"],
    parameters: &[Parameter { name: "coefficient", unit: "1/(drive unit s²)", default: None, range: ANY }],
    build: |values, _| Ok(Action::Force(Box::new(Term { coefficient: values["coefficient"] }))),
    draw: |strength, typical, generator| {
        let limit = 0.5 * typical.stiffness / typical.largest_drive;
        let size = strength * typical.acceleration() / (typical.drive * typical.position);
        vec![("coefficient", sign(generator) * size.min(limit))]
    },
};

#[derive(Debug)]
struct Term {
    coefficient: f64,
}

impl Force for Term {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.coefficient * at.drive * at.x
    }
}
