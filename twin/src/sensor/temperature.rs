//! Physics that the temperature carries otherwise than by a drift of zero or gain.

use std::f64::consts::{LN_2, TAU};

use super::surroundings::TEMPERATURE;
use super::{Kind, Lag, Moment, Physics};

/// The middle of the room's temperature in °C.
const ROOM_C: f64 = 24.0;

/// Kinds that the temperature carries.
pub(super) const KINDS: &[Kind] = &[
    // Two bodies, the post of the sensor and the table, follow the room at their own rates and expand against each other.
    Kind {
        id: "ooc_gradient",
        title: "a difference of two temperatures that lag",
        columns: &[TEMPERATURE],
        depends_on: &["temperature_c"],
        shape: |uniform, duration_s| vec![duration_s * uniform(0.015, 0.04), duration_s * uniform(0.08, 0.2)],
        build: |shape| {
            let (post_s, table_s) = (shape[0], shape[1]);
            let [mut post, mut table]: [Lag; 2] = Default::default();
            Box::new(move |at| {
                let room_c = at.around[TEMPERATURE];
                post.follow(room_c, at.step_s, post_s) - table.follow(room_c, at.step_s, table_s)
            })
        },
    },
    // A preamplifier in its box follows the room with a lag, and its gain drifts with its own temperature.
    Kind {
        id: "ooc_preamplifier_gain",
        title: "a gain that drifts with a temperature that lags",
        columns: &[TEMPERATURE],
        depends_on: &["temperature_c"],
        shape: |uniform, duration_s| vec![duration_s * uniform(0.04, 0.15)],
        build: |shape| {
            let (time_constant_s, mut boxed) = (shape[0], Lag::default());
            Box::new(move |at| {
                at.raw_mm * (boxed.follow(at.around[TEMPERATURE], at.step_s, time_constant_s) - ROOM_C)
            })
        },
    },
    // Leakage of a junction, which doubles every 6 K.
    Kind {
        id: "ooc_leakage",
        title: "a leakage current that doubles every 6 K",
        columns: &[TEMPERATURE],
        depends_on: &["temperature_c"],
        shape: |_, _| Vec::new(),
        build: |_| -> Physics {
            Box::new(|at: &Moment| (LN_2 * (at.around[TEMPERATURE] - ROOM_C) / 6.0).exp())
        },
    },
    // A fan switches on above one temperature and off below another; what it cools follows.
    Kind {
        id: "ooc_fan",
        title: "a fan that a thermostat switches",
        columns: &[TEMPERATURE],
        depends_on: &["temperature_c"],
        shape: |uniform, duration_s| {
            vec![ROOM_C + uniform(0.3, 1.5), ROOM_C - uniform(0.3, 1.5), duration_s * uniform(0.005, 0.03)]
        },
        build: |shape| {
            let (on_c, off_c, time_constant_s) = (shape[0], shape[1], shape[2]);
            let (mut runs, mut cooled) = (false, Lag::default());
            Box::new(move |at| {
                let room_c = at.around[TEMPERATURE];
                runs = room_c > on_c || runs && room_c > off_c;
                cooled.follow(f64::from(u8::from(runs)), at.step_s, time_constant_s)
            })
        },
    },
    // The interpolation of a scale errs with the period of the scale, the more the further the room is from where its
    // light source was adjusted.
    Kind {
        id: "ooc_interpolation",
        title: "a periodic error whose amplitude goes with the temperature",
        columns: &[TEMPERATURE],
        depends_on: &["temperature_c"],
        shape: |uniform, _| vec![uniform(0.25, 0.6), uniform(0.0, TAU), ROOM_C + uniform(-2.0, 2.0)],
        build: |shape| {
            let (period_mm, phase, adjusted_c) = (shape[0], shape[1], shape[2]);
            Box::new(move |at| {
                (at.around[TEMPERATURE] - adjusted_c) * (TAU * at.x_mm / period_mm + phase).sin()
            })
        },
    },
];
