//! What holds for every effect, in the table or out of it.

use super::super::catalogue::{ALL, draw, find};
use super::*;
use crate::effects::{Drawn, EffectError};
use crate::streams::{Stream, stream};
use crate::temperature::Temperature;

const TABLE: [&str; 15] = [
    "thermal_zero_drift",
    "thermal_gain_drift",
    "thermal_lag",
    "time_drift",
    "warmup_drift",
    "mount_step",
    "backlash",
    "hysteresis",
    "periodic_error",
    "common_mode_leakage",
    "cross_axis_coupling",
    "coil_crosstalk",
    "sensor_clipping",
    "read_lag",
    "local_defect",
];

/// A recording that shows the effect.
fn protocol(effect: &Injected) -> Protocol {
    let schedule = if effect.needs_motion() { Protocol::scan() } else { Protocol::calibration() };
    Protocol { temperature: Temperature::chamber(), ..schedule }
}

#[test]
fn the_table_is_covered_and_more_is_outside_it() {
    let catalogued: Vec<&str> = ALL.iter().filter(|s| s.catalogued()).map(|s| s.id).collect();
    assert_eq!(catalogued, TABLE);
    assert!(ALL.iter().filter(|s| !s.catalogued()).count() >= 6);
    for specification in ALL {
        assert_eq!(specification.parameters.iter().filter(|p| p.is_strength()).count(), 1);
        assert!(!specification.depends_on.is_empty());
    }
}

#[test]
fn whatever_is_drawn_can_be_built_shows_and_is_proportional_to_its_strength() {
    let mut generator = stream(1, Stream::Device);
    for specification in ALL {
        for seed in 0..4 {
            let drawn = draw(specification, &Protocol::calibration(), &mut generator);
            let protocol = protocol(&drawn);
            let unit = Case::new(&drawn.scaled(1e-2), &protocol, seed);
            let per_unit = 1e2 * rms(&unit.beyond(&unit.added, 0));
            assert!(per_unit > 0.0, "{} adds nothing", specification.id);
            // A strength that adds about 1″, and twice that.
            let one = Case::new(&drawn.scaled(1.0 / per_unit), &protocol, seed);
            let two = Case::new(&drawn.scaled(2.0 / per_unit), &protocol, seed);
            let (one, two) = (one.beyond(&one.added, 0), two.beyond(&two.added, 0));
            let bent: Vec<f64> = one.iter().zip(&two).map(|(one, two)| two - 2.0 * one).collect();
            // Play, period and place of a flaw shift with the error itself.
            assert!(rms(&bent) < 0.05 * rms(&two), "{}: {} of {}", specification.id, rms(&bent), rms(&two));
            assert!((rms(&one) - 1.0).abs() < 0.05, "{}: {}", specification.id, rms(&one));
        }
    }
}

#[test]
fn several_effects_at_once_add_what_each_adds_alone() {
    let texts = [
        "thermal_zero_drift:coefficient_arcsec_per_k=0.1",
        "backlash:half_width_arcsec=1",
        "periodic_error:amplitude_arcsec=2,period_arcsec=1500",
        "common_mode_leakage:coefficient_arcsec_per_um=2",
        "mount_step:step_arcsec=2,time_s=300",
    ];
    let effects: Vec<Injected> = texts.iter().map(|text| text.parse().unwrap()).collect();
    let protocol = Protocol { temperature: Temperature::chamber(), ..Protocol::calibration() };
    let device = Device::from_seed(9).with_effects(effects.clone()).unwrap();
    let together = contributions(&device, &protocol, 9, &calculated);
    for (effect, added) in effects.iter().zip(&together) {
        let alone = Case::new(effect, &protocol, 9);
        let (alone, added) = (alone.beyond(&alone.added, 9), alone.beyond(added, 9));
        let apart: Vec<f64> = alone.iter().zip(&added).map(|(a, b)| a - b).collect();
        // Every effect moves the frame a little, and the others act where it then is.
        assert!(rms(&apart) < 0.1 * rms(&alone), "{}: {} of {}", effect.id, rms(&apart), rms(&alone));
    }
    // And without them the recording is that of the bare device.
    let bare = Device::from_seed(9).with_effects(vec![]).unwrap();
    assert_eq!(bare, Device::from_seed(9));
}

#[test]
fn a_second_recording_shows_the_same_device_in_other_surroundings() {
    let effect: Injected = "cross_axis_coupling:coefficient_arcsec_per_arcsec=1".parse().unwrap();
    let device = Device::from_seed(4).with_effects(vec![effect]).unwrap();
    for seed in [4, 5] {
        let rows = record_noiseless(&device, &Protocol::calibration(), seed, &calculated);
        let added = contributions(&device, &Protocol::calibration(), seed, &calculated).remove(0);
        for ((_, truth), added) in rows.iter().zip(added) {
            approx::assert_abs_diff_eq!(added, truth.pose.cross_arcsec, epsilon = 1e-4);
        }
    }
}

#[test]
fn an_effect_survives_its_text_and_bad_ones_are_refused_by_name() {
    let mut generator = stream(2, Stream::Device);
    for specification in ALL {
        let drawn = draw(specification, &Protocol::fine(), &mut generator);
        let values: Vec<String> = drawn.parameters.iter().map(|(name, v)| format!("{name}={v}")).collect();
        let text = format!("{}:{}", drawn.id, values.join(","));
        assert_eq!(text.parse::<Injected>().unwrap(), drawn);
    }
    let refused = |text: &str| {
        let effect = text.parse::<Injected>();
        effect.and_then(|effect| effect.build(&Device::from_seed(0)).map(drop)).unwrap_err()
    };
    assert!(matches!(refused("backlash"), EffectError::Text { .. }));
    assert!(matches!(refused("backlash:half_width_arcsec"), EffectError::Text { .. }));
    assert!(matches!(refused("backlash:half_width_arcsec=wide"), EffectError::Number { .. }));
    assert!(matches!(refused("backlach:half_width_arcsec=1"), EffectError::Id { .. }));
    assert!(matches!(refused("backlash:width_arcsec=1"), EffectError::Parameter { .. }));
    assert!(matches!(refused("mount_step:step_arcsec=1"), EffectError::Missing { parameter: "time_s", .. }));
    assert!(matches!(refused("backlash:half_width_arcsec=-1"), EffectError::Range { .. }));
    assert!(matches!(refused("backlash:half_width_arcsec=NaN"), EffectError::Range { .. }));
    let steep = "periodic_error:amplitude_arcsec=100,period_arcsec=100";
    assert!(matches!(refused(steep), EffectError::Refused { .. }));
    let middle = "sensor_clipping:threshold_deg=0,slope_arcsec_per_deg=1";
    assert!(matches!(refused(middle), EffectError::Refused { .. }));
}

#[test]
fn what_is_out_of_the_table_is_no_sum_of_simple_drifts() {
    // Each leaves at least a fifth of itself beside the angle, temperature and time.
    let mut generator = stream(5, Stream::Device);
    for specification in ALL.iter().filter(|s| !s.catalogued()) {
        let drawn = draw(specification, &Protocol::calibration(), &mut generator);
        assert!(matches!(
            specification.strength().map(|p| p.drawn),
            Some(Drawn::Strength | Drawn::PositiveStrength)
        ));
        let case = Case::new(&drawn.scaled(1e-2), &protocol(&drawn), 6);
        let left = case.beyond(&case.added, 9);
        let linear = [case.formula(|r| r.temperature_c), case.formula(|r| r.t_s)];
        let mut rest = left.clone();
        // Alternating projections converge on what both leave.
        for _ in 0..50 {
            for column in linear.iter().map(|column| case.beyond(column, 9)) {
                let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                let amount = dot(&rest, &column) / dot(&column, &column);
                rest.iter_mut().zip(&column).for_each(|(r, c)| *r -= amount * c);
            }
        }
        assert!(rms(&rest) > 0.2 * rms(&left), "{}: {} of {}", specification.id, rms(&rest), rms(&left));
    }
    assert!(find("ooc_sway").is_some());
}
