//! A spring in parallel that yields and remembers: x″ −= k·z, z′ = v·(1 − (β·sign(v z) + 1 − β)·|z/Y|ⁿ), so
//! that z saturates at Y. Wen, Journal of the Engineering Mechanics Division 102 (1976), 249–263.

use super::specification::{NOT_NEGATIVE, Typical, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "bouc_wen_hysteresis",
    title: "a spring that yields and remembers it",
    depends_on: &["history", "position", "velocity", "amplitude"],
    parameters: &[
        Parameter { name: "stiffness", unit: "1/s²", default: None, range: NOT_NEGATIVE },
        Parameter {
            name: "yield",
            unit: "position unit",
            default: None,
            range: (f64::MIN_POSITIVE, f64::INFINITY),
        },
        Parameter { name: "beta", unit: "1", default: Some(0.5), range: (0.0, 1.0) },
        Parameter { name: "exponent", unit: "1", default: Some(1.0), range: (0.5, 20.0) },
    ],
    build: |values, _| {
        Ok(Action::Force(Box::new(Yielding {
            stiffness: values["stiffness"],
            limit: values["yield"],
            beta: values["beta"],
            exponent: values["exponent"],
        })))
    },
    draw: |strength, typical, generator| {
        let limit = typical.position * uniform(generator, 0.25, 0.7);
        vec![("stiffness", strength * typical.acceleration() / limit), ("yield", limit)]
    },
};

#[derive(Debug)]
struct Yielding {
    stiffness: f64,
    limit: f64,
    beta: f64,
    exponent: f64,
}

impl Force for Yielding {
    fn states(&self) -> usize {
        1
    }

    fn scales(&self, _: &Typical) -> Vec<f64> {
        vec![self.limit]
    }

    fn acceleration(&self, at: &Motion, own: &[f64], rates: &mut [f64]) -> f64 {
        let z = own[0];
        let sense = if at.v * z > 0.0 { 1.0 } else { -1.0 };
        let yielded = (self.beta * sense + 1.0 - self.beta) * (z / self.limit).abs().powf(self.exponent);
        rates[0] = at.v * (1.0 - yielded);
        -self.stiffness * z
    }
}
