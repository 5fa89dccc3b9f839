//! All effects of moving mechanisms.

use super::specification::Specification;
use super::*;

/// Every effect that can be injected, those of the table first.
pub const ALL: &[&Specification] = &[
    &coulomb_friction::SPECIFICATION,
    &stribeck_friction::SPECIFICATION,
    &cubic_stiffness::SPECIFICATION,
    &quadratic_stiffness::SPECIFICATION,
    &quadratic_damping::SPECIFICATION,
    &nonlinear_damping::SPECIFICATION,
    &bouc_wen_hysteresis::SPECIFICATION,
    &rayleigh_hysteresis::SPECIFICATION,
    &transport_delay::SPECIFICATION,
    &drive_lag::SPECIFICATION,
    &sensor_lag::SPECIFICATION,
    &flexible_mode::SPECIFICATION,
    &drive_saturation::SPECIFICATION,
    &drive_offset::SPECIFICATION,
    &sensor_offset::SPECIFICATION,
    &cogging::SPECIFICATION,
    &torque_constant_droop::SPECIFICATION,
    &ooc_ageing_stiffness::SPECIFICATION,
    &ooc_asymmetric_friction::SPECIFICATION,
    &ooc_dead_zone::SPECIFICATION,
    &ooc_drive_stiffness::SPECIFICATION,
    &ooc_mains_hum::SPECIFICATION,
    &ooc_position_damping::SPECIFICATION,
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

/// Where an effect stands on the way from the recorded drive to the mechanism, the first first; the order of
/// effects of equal number is that in which they were given.
pub(crate) fn place(id: &str) -> usize {
    const ORDER: [&str; 7] = [
        "transport_delay",
        "ooc_mains_hum",
        "drive_offset",
        "ooc_dead_zone",
        "drive_saturation",
        "drive_lag",
        "rayleigh_hysteresis",
    ];
    const READ_OUT: [&str; 2] = ["sensor_lag", "sensor_offset"];
    let among = |list: &[&str]| list.iter().position(|other| *other == id);
    among(&ORDER).or_else(|| among(&READ_OUT)).unwrap_or(0)
}
