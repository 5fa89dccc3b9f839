//! Dry friction: against the motion whatever its speed; it holds the mechanism where the other forces are smaller.

use super::{
    COULOMB_FRICTION, CREEP, DynamicEffect, Law, SLOW_TRIANGLES, Scale, amount, place, plain_readings, shape,
};
use crate::thresholds::dynamic::effects::HARD;
use crate::thresholds::dynamic::effects::friction::{
    EXPONENTIAL, GAUSSIAN, NARROWEST, PLACES, PLAYS, WIDEST, WIDEST_PLAY, WIDTHS,
};

/// Coulomb friction: of constant magnitude.
///
/// Source: C. A. Coulomb (1785); Olsson et al., Friction models and friction compensation, Eur. J. Control 4 (1998).
pub static COULOMB: DynamicEffect = DynamicEffect {
    id: COULOMB_FRICTION,
    title: "Coulomb friction",
    formula: "x″ −= F sign v; stuck where |force| ≤ F",
    confused_with: &["stribeck_friction", "bouc_wen_hysteresis", "quadratic_damping"],
    law: Law::Coulomb,
    parameters: &[amount("force_per_inertia", "p/s²"), CREEP],
    kept: 1,
    starts: |scale| vec![vec![0.0, HARD * scale.speed]],
    plausible: |parameters, _| parameters[0] > 0.0,
    ..DRY
};

/// Stribeck friction: larger at rest, and falls with speed.
///
/// Source: R. Stribeck (1902); Armstrong-Hélouvry et al., Automatica 30 (1994), Eq. 3. The exponent is 2 there; 1 is Tustin's, IEE
/// Proc. 94 (1947) 143–151.
pub static STRIBECK: DynamicEffect = DynamicEffect {
    id: "stribeck_friction",
    title: "Stribeck friction",
    formula: "x″ −= (F + E exp(−|v/v_s|ᵟ)) sign v; stuck where |force| ≤ F + E",
    confused_with: &[COULOMB_FRICTION, "bouc_wen_hysteresis"],
    law: Law::Stribeck,
    parameters: &[
        amount("force_per_inertia", "p/s²"),
        amount("extra_static", "p/s²"),
        shape("stribeck_velocity", "p/s"),
        CREEP,
        shape("exponent", "1").usually(GAUSSIAN),
    ],
    kept: 3,
    starts: |scale| stribeck(scale, GAUSSIAN),
    starts_along: |scale| stribeck(scale, EXPONENTIAL),
    readings: |effect, parameters| {
        let mut readings = plain_readings(effect.parameters, parameters, 3);
        let mut exponent = plain_readings(effect.parameters, parameters, 5).split_off(4);
        exponent.retain(|reading| reading.value != GAUSSIAN);
        readings.append(&mut exponent);
        readings
    },
    starts_from: |simpler, parameters, scale| match (simpler, parameters) {
        (COULOMB_FRICTION, [force, creep]) => {
            let start = |part: &f64| vec![0.9 * force, 0.3 * force, part * scale.speed, *creep, GAUSSIAN];
            [0.1, 0.3, 1.0].iter().map(start).collect()
        }
        _ => Vec::new(),
    },
    special_case: Some(&COULOMB),
    // Beyond the speeds of the recording the fall of the friction is a viscous damping.
    plausible: |parameters, scale| {
        parameters[0] >= 0.0 && parameters[1] > 0.0 && parameters[2] < 3.0 * scale.speed
    },
    ..DRY
};

/// More friction at one place: a worn or dented stretch of a guide or a screw.
///
/// Source: Olsson et al., Friction models and friction compensation, Eur. J. Control 4 (1998): friction that depends on the
/// position.
pub static LOCAL: DynamicEffect = DynamicEffect {
    id: "local_friction",
    title: "Friction at one place",
    formula: "x″ −= F exp(−((x − c)/w)²) sign v",
    variable: "position",
    confused_with: &["cogging", COULOMB_FRICTION],
    law: Law::LocalFriction,
    parameters: &[amount("force_per_inertia", "p/s²"), place("centre", "p"), shape("width", "p")],
    starts: |scale| {
        let places = (0..PLACES).map(|k| (2 * k + 1) as f64 / PLACES as f64 - 1.0);
        let at = |part: f64| {
            WIDTHS.map(|width| vec![0.0, scale.middle + part * scale.stroke, width * scale.stroke])
        };
        places.flat_map(at).collect()
    },
    plausible: |parameters, scale| {
        let [force, width] = [parameters[0], parameters[2] / scale.stroke];
        force > 0.0
            && (parameters[1] - scale.middle).abs() < scale.stroke
            && (NARROWEST..WIDEST).contains(&width)
    },
    experiment: "move slowly over the place, forward and back, and beside it",
    ..DynamicEffect::USUAL
};

/// Friction beyond a play: what the drive moves stands still while a worn screw, gear or coupling crosses its play, and does
/// not have to be carried.
///
/// Source: Nordin & Gutman, Controlling mechanical systems with backlash – a survey, Automatica 38 (2002) 1633–1649.
pub static BACKLASH: DynamicEffect = DynamicEffect {
    id: "backlash",
    title: "Backlash: friction beyond a play",
    formula: "x″ += F sign v while x crosses a play of width b",
    variable: "history",
    confused_with: &["bouc_wen_hysteresis", COULOMB_FRICTION],
    law: Law::Backlash,
    parameters: &[amount("friction_beyond", "p/s²"), shape("play", "p")],
    states: 1,
    starts: |scale| PLAYS.iter().map(|part| vec![0.0, part * scale.stroke]).collect(),
    plausible: |parameters, scale| parameters[0] > 0.0 && parameters[1] < WIDEST_PLAY * scale.stroke,
    experiment: SLOW_TRIANGLES,
    ..DynamicEffect::USUAL
};

/// Starts of a search for friction that falls so with the speed.
fn stribeck(scale: &Scale, exponent: f64) -> Vec<Vec<f64>> {
    let start = |part: &f64| vec![0.0, 0.0, part * scale.speed, HARD * scale.speed, exponent];
    [0.03, 0.1, 0.3, 1.0].iter().map(start).collect()
}

const DRY: DynamicEffect = DynamicEffect {
    variable: "velocity",
    creeps: true,
    experiment: SLOW_TRIANGLES,
    abrupt: true,
    ..DynamicEffect::USUAL
};
