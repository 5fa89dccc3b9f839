//! A part of the inertia μ that swings on the moving one at its own frequency: x″ −= μ·h, q″ = h, with h =
//! Ω²(x − q) + 2ζΩ(v − q′) and Ω = 2πf.

use super::specification::{NOT_NEGATIVE, POSITIVE, Typical, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub const SPECIFICATION: Specification = Specification {
    id: "flexible_mode",
    title: "a part that swings on the moving inertia",
    depends_on: &["frequency_hz", "acceleration"],
    parameters: &[
        Parameter::needed("frequency_hz", "Hz", POSITIVE),
        Parameter::needed("mass_ratio", "1", NOT_NEGATIVE),
        Parameter::usual("damping_ratio", "1", 0.01, NOT_NEGATIVE),
    ],
    build: |values, _| {
        Action::Force(Box::new(Swinging {
            omega: std::f64::consts::TAU * values["frequency_hz"],
            mass_ratio: values["mass_ratio"],
            damping_ratio: values["damping_ratio"],
        }))
    },
    draw: |strength, typical, generator| {
        // Between the mechanism's own resonance and the end of the excited band.
        let own_hz = typical.stiffness.sqrt() / std::f64::consts::TAU;
        let highest = 0.9 * typical.highest_hz;
        let frequency = uniform(generator, (1.6 * own_hz).min(0.8 * highest), highest);
        vec![("frequency_hz", frequency), ("mass_ratio", strength)]
    },
};

struct Swinging {
    omega: f64,
    mass_ratio: f64,
    damping_ratio: f64,
}

impl Force for Swinging {
    fn states(&self) -> usize {
        2
    }

    fn scales(&self, typical: &Typical) -> Vec<f64> {
        vec![typical.position, typical.velocity]
    }

    fn acceleration(&self, at: &Motion, own: &[f64], rates: &mut [f64]) -> f64 {
        let spring = self.omega * self.omega * (at.x - own[0]);
        let pull = spring + 2.0 * self.damping_ratio * self.omega * (at.v - own[1]);
        rates[0] = own[1];
        rates[1] = pull;
        -self.mass_ratio * pull
    }
}
