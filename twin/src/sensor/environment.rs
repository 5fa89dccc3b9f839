//! Physics that a recorded quantity beside the position carries: the air, the supply, loads and strains.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::surroundings::*;
use super::{Kind, Lag, Moment, Physics};

/// A mechanism without memory.
fn at_once(error: impl Fn(&Moment) -> f64 + Send + 'static) -> Physics {
    Box::new(error)
}

/// Kinds that a recorded quantity carries.
pub(super) const KINDS: &[Kind] = &[
    // A capacitive gap of 1.5 mm + x: the permittivity of the air in it grows with the density of water vapour, relative
    // humidity times saturation pressure (Magnus) over absolute temperature.
    Kind {
        id: "ooc_humid_air",
        title: "the permittivity of moist air in a capacitive gap",
        columns: &[HUMIDITY],
        depends_on: &["humidity_pct"],
        shape: |_, _| Vec::new(),
        build: |_| {
            at_once(|at| {
                let temperature_c = at.around[TEMPERATURE];
                let saturation_hpa = 6.112 * (17.62 * temperature_c / (243.12 + temperature_c)).exp();
                (1.5 + at.x_mm) * at.around[HUMIDITY] * saturation_hpa / (temperature_c + 273.15)
            })
        },
    },
    // A plate of epoxy takes up water by diffusion and swells: the three slowest modes of a plate (Crank), of which each
    // follows the air nine and twenty-five times faster.
    Kind {
        id: "ooc_swelling",
        title: "an epoxy mount swells in moist air",
        columns: &[HUMIDITY],
        depends_on: &["humidity_pct"],
        shape: |uniform, duration_s| vec![duration_s * uniform(0.04, 0.15)],
        build: |shape| {
            let time_constant_s = shape[0];
            let mut modes: [Lag; 3] = Default::default();
            Box::new(move |at| {
                let mode = |(lag, odd): (&mut Lag, f64)| {
                    lag.follow(at.around[HUMIDITY], at.step_s, time_constant_s / (odd * odd)) / (odd * odd)
                };
                modes.iter_mut().zip([1.0, 3.0, 5.0]).map(mode).sum()
            })
        },
    },
    // An interferometer whose wavelength is that in air of 1013.25 hPa and 22 °C: the path, dead path included, is
    // multiplied by how much denser the air is.
    Kind {
        id: "ooc_air_index",
        title: "the refractive index of air is not compensated",
        columns: &[PRESSURE],
        depends_on: &["pressure_hpa"],
        shape: |uniform, _| vec![uniform(2.0, 6.0)],
        build: |shape| {
            let dead_mm = shape[0];
            at_once(move |at| {
                let density = at.around[PRESSURE] / 1013.25 * 295.15 / (273.15 + at.around[TEMPERATURE]);
                (dead_mm + at.x_mm) * (density - 1.0)
            })
        },
    },
    // A differential transformer that is not read ratiometrically: its sensitivity goes with the excitation.
    Kind {
        id: "ooc_supply_gain",
        title: "the sensitivity goes with the supply voltage",
        columns: &[SUPPLY],
        depends_on: &["supply_v"],
        shape: |_, _| Vec::new(),
        build: |_| at_once(|at| at.raw_mm * (at.around[SUPPLY] / 12.0 - 1.0)),
    },
    // Purge air presses on the target with the square of its flow.
    Kind {
        id: "ooc_purge_flow",
        title: "purge air deflects the target",
        columns: &[FLOW],
        depends_on: &["purge_lpm"],
        shape: |_, _| Vec::new(),
        build: |_| at_once(|at| at.around[FLOW].powi(2)),
    },
    // A winding heats its holder: power i²R, with a resistance that grows by the heat itself.
    Kind {
        id: "ooc_self_heating",
        title: "a winding heats the holder of the sensor",
        columns: &[CURRENT],
        depends_on: &["current_a"],
        shape: |uniform, duration_s| vec![duration_s * uniform(0.03, 0.12)],
        build: |shape| {
            let (time_constant_s, mut body) = (shape[0], Lag::default());
            let mut heat = 0.0;
            Box::new(move |at| {
                let power = at.around[CURRENT].powi(2) * (1.0 + 0.15 * heat);
                heat = body.follow(power, at.step_s, time_constant_s);
                heat
            })
        },
    },
    // The bench is tilted: the sensor's carrier sags with the component of gravity along its axis.
    Kind {
        id: "ooc_gravity_tilt",
        title: "the carrier sags with its orientation",
        columns: &[TILT],
        depends_on: &["tilt_deg"],
        shape: |uniform, _| vec![uniform(0.0, TAU)],
        build: |shape| {
            let phase = shape[0];
            at_once(move |at| (at.around[TILT].to_radians() + phase).sin())
        },
    },
    // Strain of the structure reaches the sensor through an adhesive that lets go of it in time (Maxwell).
    Kind {
        id: "ooc_adhesive_creep",
        title: "strain through an adhesive that relaxes",
        columns: &[STRAIN],
        depends_on: &["strain_ue"],
        shape: |uniform, duration_s| vec![duration_s * uniform(0.02, 0.1), uniform(0.5, 0.9)],
        build: |shape| {
            let (time_constant_s, part, mut relaxed) = (shape[0], shape[1], Lag::default());
            Box::new(move |at| {
                let strain = at.around[STRAIN];
                strain - part * relaxed.follow(strain, at.step_s, time_constant_s)
            })
        },
    },
    // A vibration is rectified by the curvature of the sensor's characteristic: its mean square is left.
    Kind {
        id: "ooc_vibration",
        title: "a vibration is rectified",
        columns: &[VIBRATION],
        depends_on: &["vibration_mm_s"],
        shape: |_, _| Vec::new(),
        build: |_| at_once(|at| at.around[VIBRATION].powi(2)),
    },
    // Cooling water flows from where it is measured to the holder, which follows it.
    Kind {
        id: "ooc_coolant",
        title: "cooling water reaches the holder after its way through the pipe",
        columns: &[COOLANT],
        depends_on: &["coolant_c"],
        shape: |uniform, duration_s| {
            vec![duration_s * uniform(0.015, 0.05), duration_s * uniform(0.02, 0.06)]
        },
        build: |shape| {
            let (pipe_s, time_constant_s, mut holder) = (shape[0], shape[1], Lag::default());
            let mut pipe: VecDeque<f64> = VecDeque::new();
            Box::new(move |at| {
                pipe.push_back(at.around[COOLANT]);
                let full = pipe.len() as f64 * at.step_s > pipe_s;
                let arrives = if full { pipe.pop_front() } else { pipe.front().copied() };
                holder.follow(arrives.unwrap_or(at.around[COOLANT]), at.step_s, time_constant_s)
            })
        },
    },
    // The carriage yaws and the sensor stands off the line of the reference by an arm that grows along the travel (Abbe).
    Kind {
        id: "ooc_abbe",
        title: "yaw of the carriage on an arm that grows along the travel",
        columns: &[YAW],
        depends_on: &["yaw_arcsec"],
        shape: |uniform, _| vec![uniform(-0.7, 0.7)],
        build: |shape| {
            let offset = shape[0];
            at_once(move |at| at.around[YAW] * (offset + at.x_mm))
        },
    },
    // Stray light on a detector that saturates.
    Kind {
        id: "ooc_stray_light",
        title: "stray light on a detector that saturates",
        columns: &[LIGHT],
        depends_on: &["light_klx"],
        shape: |uniform, _| vec![uniform(0.5, 1.5)],
        build: |shape| {
            let half_klx = shape[0];
            at_once(move |at| {
                let light_klx = at.around[LIGHT].max(0.0);
                light_klx / (half_klx + light_klx)
            })
        },
    },
    // The screw's coupling runs out of true: once and twice in a turn of the shaft, whose belt slips against the stage.
    Kind {
        id: "ooc_shaft_runout",
        title: "run-out of a shaft, once and twice in its turn",
        columns: &[SHAFT],
        depends_on: &["shaft_deg"],
        shape: |uniform, _| vec![uniform(0.0, TAU), uniform(0.0, TAU), uniform(0.2, 1.0)],
        build: |shape| {
            let (first, second, part) = (shape[0], shape[1], shape[2]);
            at_once(move |at| {
                let turn = at.around[SHAFT].to_radians();
                part * (turn + first).sin() + (2.0 * turn + second).sin()
            })
        },
    },
    // Play of a nut that the load presses open, 4 µm at 12 N, of which a part turns the sensor on the driving side.
    Kind {
        id: "ooc_loaded_play",
        title: "lost motion in proportion to the load",
        columns: &[LOAD],
        depends_on: &["load_n", "direction"],
        shape: |_, _| Vec::new(),
        build: |_| {
            let mut behind_mm: Option<f64> = None;
            Box::new(move |at| {
                let half_mm = 4e-3 * (at.around[LOAD] / 12.0).max(0.0);
                let follows = behind_mm.unwrap_or(at.x_mm).clamp(at.x_mm - half_mm, at.x_mm + half_mm);
                behind_mm = Some(follows);
                (at.x_mm - follows) / 4e-3
            })
        },
    },
];
