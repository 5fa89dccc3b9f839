//! What acts on the way of the drive or of the reading. Without a [`Law`] the simulation does what [`Part`] says with the
//! one parameter.

use super::{DynamicEffect, FASTER, Law, MEAN_POSITIONS, Part, Scale, amount, shape};

/// Offset of the drive: an offset of the amplifier, or a constant force.
///
/// Source: Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998).
pub static DRIVE_OFFSET: DynamicEffect = DynamicEffect {
    id: super::DRIVE_OFFSET,
    title: "Offset of the drive",
    formula: "w = u + o",
    variable: "drive",
    confused_with: &["sensor_offset", "quadratic_stiffness"],
    part: Part::Drive,
    law: Law::Offset,
    parameters: &[amount("offset", "u")],
    experiment: MEAN_POSITIONS,
    ..DynamicEffect::USUAL
};

/// Saturation of the drive: an amplifier at its limit.
///
/// Source: Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998).
pub static DRIVE_SATURATION: DynamicEffect = DynamicEffect {
    id: "drive_saturation",
    title: "Saturation of the drive",
    formula: "w = u within ±limit",
    variable: "drive",
    confused_with: &["torque_constant_droop"],
    part: Part::Drive,
    law: Law::Limit,
    parameters: &[shape("limit", "u")],
    starts: |scale| [0.95, 0.85, 0.7, 0.5].iter().map(|part| vec![part * scale.drive]).collect(),
    plausible: |parameters, scale| parameters[0] < scale.drive,
    ..DynamicEffect::USUAL
};

/// Offset of the read-out: an offset of the sensor.
///
/// Source: Fraden, Handbook of Modern Sensors (2016).
pub static SENSOR_OFFSET: DynamicEffect = DynamicEffect {
    id: super::SENSOR_OFFSET,
    title: "Offset of the read-out",
    formula: "y = x + o",
    variable: "position",
    confused_with: &["drive_offset", "quadratic_stiffness"],
    part: Part::SensorOffset,
    parameters: &[amount("offset", "p")],
    experiment: MEAN_POSITIONS,
    ..DynamicEffect::USUAL
};

/// Hysteresis after Rayleigh: domains of a piezo, or of iron at low fields, switch at thresholds of equal density, so that gain and loss grow with the amplitude of the drive.
///
/// Source: Lord Rayleigh, Phil. Mag. 23 (1887) 225; Damjanovic, J. Appl. Phys. 82 (1997) 1788 (piezo).
pub static RAYLEIGH_HYSTERESIS: DynamicEffect = DynamicEffect {
    id: super::RAYLEIGH_HYSTERESIS,
    title: "Hysteresis of the actuator (Rayleigh)",
    formula: "w = u + c R(u), R = R_r + ½(u − u_r)|u − u_r| from every reversal, u|u| from rest",
    variable: "history",
    confused_with: &["drive_saturation", "bouc_wen_hysteresis", "coulomb_friction"],
    part: Part::DriveMemory,
    parameters: &[amount("coefficient", "1/u")],
    ..DynamicEffect::USUAL
};

/// Transport delay of the drive: a pure delay between the recorded drive and the force: a bus, a sampled controller.
///
/// Source: Åström & Wittenmark, Computer-Controlled Systems (1997), section 2.3.
pub static TRANSPORT_DELAY: DynamicEffect = DynamicEffect {
    id: super::TRANSPORT_DELAY,
    title: "Transport delay of the drive",
    formula: "w(t) = u(t − T)",
    variable: "frequency_hz",
    confused_with: &["drive_lag", "sensor_lag"],
    part: Part::Delay,
    parameters: &[amount("delay_s", "s")],
    experiment: FASTER,
    plausible: |parameters, _| parameters[0] > 0.0,
    starts_from: late_alike,
    ..DynamicEffect::USUAL
};

/// Lag of the drive: an amplifier or a coil of finite bandwidth: first-order lag of the force.
///
/// Source: Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998).
pub static DRIVE_LAG: DynamicEffect = DynamicEffect {
    id: super::DRIVE_LAG,
    title: "Lag of the drive",
    formula: "τ w′ = u − w",
    variable: "frequency_hz",
    confused_with: &["transport_delay", "sensor_lag"],
    part: Part::DriveLag,
    parameters: &[shape("time_constant_s", "s")],
    experiment: FASTER,
    starts: time_constants,
    plausible: |parameters, _| parameters[0] > 0.0,
    starts_from: late_alike,
    ..DynamicEffect::USUAL
};

/// Lag of the read-out: a sensor or filter of finite bandwidth: first-order lag of the reading.
///
/// Source: Fraden, Handbook of Modern Sensors (2016).
pub static SENSOR_LAG: DynamicEffect = DynamicEffect {
    id: "sensor_lag",
    title: "Lag of the read-out",
    formula: "τ y′ = x − y",
    variable: "frequency_hz",
    confused_with: &["drive_lag", "transport_delay"],
    part: Part::SensorLag,
    parameters: &[shape("time_constant_s", "s")],
    experiment: FASTER,
    starts: time_constants,
    plausible: |parameters, _| parameters[0] > 0.0,
    starts_from: late_alike,
    ..DynamicEffect::USUAL
};

/// In the place of a delay or lag: as late as that.
fn late_alike(other: &str, parameters: &[f64], _: &Scale) -> Vec<Vec<f64>> {
    let late = [super::TRANSPORT_DELAY, super::DRIVE_LAG, SENSOR_LAG.id].contains(&other);
    if late { vec![parameters.to_vec()] } else { Vec::new() }
}

/// Where the search for a time constant starts: in steps from row to row.
fn time_constants(scale: &Scale) -> Vec<Vec<f64>> {
    [0.2, 1.0, 4.0].iter().map(|step| vec![step * scale.step_s]).collect()
}
