//! A spring in parallel that yields and remembers: x″ −= k·z, z′ = v·(1 − (β·sign(v z) + 1 − β)·|z/Y|ⁿ), so
//! that z saturates at Y. Wen, Journal of the Engineering Mechanics Division 102 (1976), 249–263.

use super::specification::{NOT_NEGATIVE, POSITIVE, Typical, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub const SPECIFICATION: Specification = Specification {
    id: "bouc_wen_hysteresis",
    title: "a spring that yields and remembers it",
    depends_on: &["history", "position", "velocity", "amplitude"],
    parameters: &[
        Parameter::needed("stiffness", "1/s²", NOT_NEGATIVE),
        Parameter::needed("yield", "position unit", POSITIVE),
        Parameter::usual("beta", "1", 0.5, (0.0, 1.0)),
        Parameter::usual("exponent", "1", 1.0, (0.5, 20.0)),
    ],
    build: |values, _| {
        Action::Force(Box::new(Yielding {
            stiffness: values["stiffness"],
            limit: values["yield"],
            beta: values["beta"],
            exponent: values["exponent"],
        }))
    },
    draw: |strength, typical, generator| {
        let limit = typical.position * uniform(generator, 0.25, 0.7);
        vec![("stiffness", strength * typical.acceleration() / limit), ("yield", limit)]
    },
};

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
