//! Forces without states of their own.

use super::{DynamicEffect, Law, MEAN_POSITIONS, Reading, amount, shape};

/// Cubic stiffness: a flexure or spring that hardens (or softens) with the cube of the deflection (Duffing).
///
/// Source: G. Duffing (1918); Kovacic & Brennan, The Duffing Equation (2011).
pub static CUBIC_STIFFNESS: DynamicEffect = DynamicEffect {
    id: super::CUBIC_STIFFNESS,
    title: "Cubic stiffness",
    formula: "x″ −= c x³",
    variable: "position",
    confused_with: &["torque_constant_droop", "quadratic_stiffness"],
    parameters: &[amount("coefficient", "1/(p²s²)")],
    law: Law::Cubic,
    ..DynamicEffect::USUAL
};

/// Quadratic stiffness: a spring that is stiffer on one side.
///
/// Source: Nayfeh & Mook, Nonlinear Oscillations (1979), section 4.1.
pub static QUADRATIC_STIFFNESS: DynamicEffect = DynamicEffect {
    id: "quadratic_stiffness",
    title: "Quadratic stiffness",
    formula: "x″ −= c x²",
    variable: "position",
    confused_with: &["sensor_offset", "drive_offset", "cubic_stiffness"],
    parameters: &[amount("coefficient", "1/(p·s²)")],
    experiment: MEAN_POSITIONS,
    law: Law::Square,
    ..DynamicEffect::USUAL
};

/// Quadratic damping: drag of a turbulent fluid, with the square of the speed.
///
/// Source: Morison et al. (1950); Nayfeh & Mook, Nonlinear Oscillations (1979), section 3.3.
pub static QUADRATIC_DAMPING: DynamicEffect = DynamicEffect {
    id: "quadratic_damping",
    title: "Quadratic damping",
    formula: "x″ −= c v |v|",
    variable: "velocity",
    confused_with: &["coulomb_friction", "nonlinear_damping"],
    parameters: &[amount("coefficient", "1/p")],
    law: Law::Drag,
    plausible: |parameters, _| parameters[0] > 0.0,
    ..DynamicEffect::USUAL
};

/// Damping that grows with the deflection: damping that depends on the square of the deflection (van der Pol; squeeze film, eddy currents).
///
/// Source: B. van der Pol (1926); Lifshitz & Cross, Nonlinear Dynamics of Nanomechanical Resonators (2008).
pub static NONLINEAR_DAMPING: DynamicEffect = DynamicEffect {
    id: "nonlinear_damping",
    title: "Damping that grows with the deflection",
    formula: "x″ −= c x² v",
    variable: "velocity",
    confused_with: &["quadratic_damping"],
    parameters: &[amount("coefficient", "1/(p²s)")],
    law: Law::Damping,
    ..DynamicEffect::USUAL
};

/// Droop of the torque constant: a motor whose force per current falls where its coil leaves the magnet.
///
/// Source: Clarke, Mirror-scanner actuators, in Handbook of Optical and Laser Scanning (2004).
pub static TORQUE_CONSTANT_DROOP: DynamicEffect = DynamicEffect {
    id: "torque_constant_droop",
    title: "Droop of the torque constant",
    formula: "gain (1 − δ x²)",
    variable: "drive",
    confused_with: &["cubic_stiffness"],
    parameters: &[amount("droop", "1/p²")],
    by_gain: true,
    law: Law::Droop,
    ..DynamicEffect::USUAL
};

/// Cogging: a force that repeats with the position: the teeth of a motor, the balls of a bearing.
///
/// Source: Hanselman, Brushless Permanent Magnet Motor Design (2003), chapter 6.
pub static COGGING: DynamicEffect = DynamicEffect {
    id: "cogging",
    title: "Cogging",
    formula: "x″ −= A sin(2πx/p + φ)",
    variable: "position",
    confused_with: &["cubic_stiffness", "quadratic_stiffness"],
    law: Law::Cogging,
    parameters: &[amount("sine", "p/s²"), amount("cosine", "p/s²"), shape("period", "p")],
    // Steps of half a turn over the whole stroke: between two of them a period is at most a quarter of a turn out over
    // the stroke, an eighth at either end, and still shows.
    starts: |scale| (0..40).map(|k| vec![0.0, 0.0, 2.0 * scale.stroke / (0.8 + 0.5 * k as f64)]).collect(),
    // Less than one and a half turns within the stroke are a polynomial of the position.
    plausible: |parameters, scale| parameters[2] < 2.0 * scale.stroke / 1.3,
    readings: |_, parameters| {
        let [a, b, period] = [parameters[0], parameters[1], parameters[2]];
        let amplitude = a.hypot(b).max(f64::MIN_POSITIVE);
        let square = amplitude * amplitude;
        let reading = |name, unit, value, gradient: [f64; 3]| Reading {
            name,
            unit,
            value,
            gradient: gradient.to_vec(),
        };
        vec![
            reading("amplitude_per_inertia", "p/s²", amplitude, [a / amplitude, b / amplitude, 0.0]),
            reading("period", "p", period, [0.0, 0.0, 1.0]),
            reading("phase_rad", "rad", b.atan2(a), [-b / square, a / square, 0.0]),
        ]
    },
    parameters_from: |_, value| {
        let (amplitude, phase) = (value("amplitude_per_inertia")?, value("phase_rad").unwrap_or(0.0));
        Some(vec![amplitude * phase.cos(), amplitude * phase.sin(), value("period")?])
    },
    ..DynamicEffect::USUAL
};
