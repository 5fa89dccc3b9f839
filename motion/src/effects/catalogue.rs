//! All effects of moving mechanisms.

use super::specification::Specification;
use super::*;

/// Every effect that can be injected, those of the table first.
pub const ALL: &[&Specification] = &[
    &friction::COULOMB,
    &friction::STRIBECK,
    &friction::LOCAL,
    &friction::BACKLASH,
    &forces::CUBIC_STIFFNESS,
    &forces::QUADRATIC_STIFFNESS,
    &forces::QUADRATIC_DAMPING,
    &forces::NONLINEAR_DAMPING,
    &bouc_wen_hysteresis::SPECIFICATION,
    &rayleigh_hysteresis::SPECIFICATION,
    &path::TRANSPORT_DELAY,
    &path::DRIVE_LAG,
    &path::SENSOR_LAG,
    &flexible_mode::SPECIFICATION,
    &path::DRIVE_SATURATION,
    &path::DRIVE_OFFSET,
    &path::SENSOR_OFFSET,
    &forces::COGGING,
    &forces::TORQUE_CONSTANT_DROOP,
    &forces::AGEING_STIFFNESS,
    &friction::ASYMMETRIC,
    &path::DEAD_ZONE,
    &forces::DRIVE_STIFFNESS,
    &path::MAINS_HUM,
    &forces::POSITION_DAMPING,
    &ooc_sticking_stop::SPECIFICATION,
];

/// The effect with this id.
pub fn find(id: &str) -> Option<&'static Specification> {
    ALL.iter().find(|s| s.id == id).copied()
}

/// All effects with their parameters, one to a line, as a text for people.
pub fn listing() -> String {
    let mut text = String::new();
    for effect in ALL {
        text += &format!("{}: {}\n", effect.id, effect.title);
        for parameter in effect.parameters {
            let default = parameter.default.map_or("needed".to_owned(), |value| format!("default {value}"));
            text += &format!("    {} in {}, {default}\n", parameter.name, parameter.unit);
        }
    }
    text
}

/// Effects on the way of the drives, in their order from the recorded drive to the mechanism.
pub(crate) const ON_DRIVES: [&str; 7] = [
    "transport_delay",
    "ooc_mains_hum",
    "drive_offset",
    "ooc_dead_zone",
    "drive_saturation",
    "drive_lag",
    "rayleigh_hysteresis",
];
/// Those of the read-out, in theirs.
pub(crate) const ON_READ_OUT: [&str; 2] = ["sensor_lag", "sensor_offset"];

/// Where an effect stands on its way, the first first; the order of effects of equal number is that in which they were
/// given.
pub(crate) fn place(id: &str) -> usize {
    let among = |list: &[&str]| list.iter().position(|other| *other == id);
    among(&ON_DRIVES).or_else(|| among(&ON_READ_OUT)).unwrap_or(0)
}
