//! All effects, and how a random one is drawn.

use rand::{Rng, RngExt};

use super::specification::{Drawn, Specification};
use super::{Injected, *};
use crate::protocol::Protocol;

/// Every effect that can be injected, those of the table first.
pub const ALL: &[&Specification] = &[
    &bracket::THERMAL_ZERO_DRIFT,
    &probes::THERMAL_GAIN_DRIFT,
    &bracket::THERMAL_LAG,
    &autocollimator::TIME_DRIFT,
    &autocollimator::WARMUP_DRIFT,
    &autocollimator::MOUNT_STEP,
    &frame::BACKLASH,
    &frame::HYSTERESIS,
    &bracket::PERIODIC_ERROR,
    &probes::COMMON_MODE_LEAKAGE,
    &bracket::CROSS_AXIS_COUPLING,
    &probes::COIL_CROSSTALK,
    &probes::SENSOR_CLIPPING,
    &autocollimator::READ_LAG,
    &probes::LOCAL_DEFECT,
    &autocollimator::AGING,
    &bracket::COIL_HEATING,
    &bracket::COMMON_MODE_SQUARE,
    &autocollimator::CROSS_SQUARE,
    &bracket::DIRECTION_GAIN,
    &bracket::REMANENCE,
    &autocollimator::RESEATING,
    &bracket::SOFTENING,
    &autocollimator::SWAY,
    &bracket::TEMPERATURE_SQUARE,
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
            let (least, most) = parameter.range;
            text += &format!("    {} {least} to {most} {}, {default}\n", parameter.name, parameter.unit);
        }
    }
    text
}

/// Draws the parameters of an effect for a recording by `protocol`: strength 1 (of either sign where it
/// has a sign), to be scaled with [`Injected::scaled`], and the others where they make sense.
pub fn draw(specification: &Specification, protocol: &Protocol, generator: &mut impl Rng) -> Injected {
    let (first, last) = protocol.range_deg;
    let stroke_deg = last - first;
    let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
    let mut parameters = std::collections::BTreeMap::new();
    for parameter in specification.parameters {
        let value = match parameter.drawn {
            Drawn::Strength => uniform(-1.0, 1.0).signum(),
            Drawn::PositiveStrength => 1.0,
            Drawn::Uniform(from, to) => uniform(from, to),
            Drawn::Whole(from, to) => uniform(f64::from(from), f64::from(to) + 1.0).floor(),
            Drawn::OfDuration(from, to) => protocol.duration_s() * uniform(from, to),
            Drawn::EitherSide(from, to) => {
                let side = uniform(-1.0, 1.0).signum();
                0.5 * (first + last) + side * 0.5 * stroke_deg * uniform(from, to)
            }
            Drawn::FromSteps(steps, fraction) => uniform(steps * protocol.step_deg, fraction * stroke_deg),
            Drawn::PeriodFromSteps(steps, fraction) => {
                3600.0 * uniform(steps * protocol.step_deg, fraction * stroke_deg)
            }
        };
        parameters.insert(parameter.name.to_owned(), value);
    }
    Injected { id: specification.id.to_owned(), parameters }
}
