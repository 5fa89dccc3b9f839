//! Forces with one amount and no shape: the acceleration that they take off is the amount times a formula.

use super::{DynamicEffect, Facts, Flow, MEAN_POSITIONS, Physics, Scale, amount};
use crate::numerics::Number;

/// Such a force.
pub struct Force {
    facts: Facts,
    formula: Formula,
    /// Whether its amount is positive.
    positive: bool,
}

/// What the amount multiplies.
enum Formula {
    Cubic,
    Square,
    Drag,
    Damping,
    Droop,
}

/// Cubic stiffness: a flexure or spring that hardens (or softens) with the cube of the deflection (Duffing).
///
/// x″ −= c x³; c in 1/(p² s²)
///
/// Source: G. Duffing (1918); Kovacic & Brennan, The Duffing Equation (2011).
pub static CUBIC_STIFFNESS: Force = Force {
    facts: Facts {
        id: super::CUBIC_STIFFNESS,
        title: "Cubic stiffness",
        variable: "position",
        confused_with: &["torque_constant_droop", "quadratic_stiffness"],
        parameters: &[amount("coefficient", "1/(p²s²)")],
        ..Facts::USUAL
    },
    formula: Formula::Cubic,
    positive: false,
};

/// Quadratic stiffness: a spring that is stiffer on one side.
///
/// x″ −= c x²; c in 1/(p s²)
///
/// Source: Nayfeh & Mook, Nonlinear Oscillations (1979), section 4.1.
pub static QUADRATIC_STIFFNESS: Force = Force {
    facts: Facts {
        id: "quadratic_stiffness",
        title: "Quadratic stiffness",
        variable: "position",
        confused_with: &["sensor_offset", "drive_offset", "cubic_stiffness"],
        parameters: &[amount("coefficient", "1/(p·s²)")],
        experiment: MEAN_POSITIONS,
        ..Facts::USUAL
    },
    formula: Formula::Square,
    positive: false,
};

/// Quadratic damping: drag of a turbulent fluid, with the square of the speed.
///
/// x″ −= c v |v|; c in 1/p
///
/// Source: Morison et al. (1950); Nayfeh & Mook, Nonlinear Oscillations (1979), section 3.3.
pub static QUADRATIC_DAMPING: Force = Force {
    facts: Facts {
        id: "quadratic_damping",
        title: "Quadratic damping",
        variable: "velocity",
        confused_with: &["coulomb_friction", "nonlinear_damping"],
        parameters: &[amount("coefficient", "1/p")],
        ..Facts::USUAL
    },
    formula: Formula::Drag,
    positive: true,
};

/// Damping that grows with the deflection: damping that depends on the square of the deflection (van der Pol; squeeze film, eddy currents).
///
/// x″ −= c x² v; c in 1/(p² s)
///
/// Source: B. van der Pol (1926); Lifshitz & Cross, Nonlinear Dynamics of Nanomechanical Resonators (2008).
pub static NONLINEAR_DAMPING: Force = Force {
    facts: Facts {
        id: "nonlinear_damping",
        title: "Damping that grows with the deflection",
        variable: "velocity",
        confused_with: &["quadratic_damping"],
        parameters: &[amount("coefficient", "1/(p²s)")],
        ..Facts::USUAL
    },
    formula: Formula::Damping,
    positive: false,
};

/// Droop of the torque constant: a motor whose force per current falls where its coil leaves the magnet.
///
/// gain (1 − δ x²); δ in 1/p²
///
/// Source: Clarke, Mirror-scanner actuators, in Handbook of Optical and Laser Scanning (2004).
pub static TORQUE_CONSTANT_DROOP: Force = Force {
    facts: Facts {
        id: "torque_constant_droop",
        title: "Droop of the torque constant",
        variable: "drive",
        confused_with: &["cubic_stiffness"],
        parameters: &[amount("droop", "1/p²")],
        by_gain: true,
        ..Facts::USUAL
    },
    formula: Formula::Droop,
    positive: false,
};

impl<T: Number> Physics<T> for Force {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let (x, v) = (*flow.position, *flow.velocity);
        let force = match self.formula {
            Formula::Cubic => parameters[0] * x * x * x,
            Formula::Square => parameters[0] * x * x,
            Formula::Drag => parameters[0] * v * v.abs(),
            Formula::Damping => parameters[0] * x * x * v,
            Formula::Droop => *flow.gain * *flow.drive * parameters[0] * x * x,
        };
        *flow.acceleration = *flow.acceleration - force;
    }
}

impl DynamicEffect for Force {
    fn facts(&self) -> &Facts {
        &self.facts
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        !self.positive || parameters[0] > 0.0
    }
}
