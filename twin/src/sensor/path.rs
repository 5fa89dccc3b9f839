//! Physics of the position alone: the way that was travelled, the surface of the target, the converter.

use super::Kind;

/// A return of the stage by this, in millimetres, is a turn and no scatter.
const TURN_MM: f64 = 0.01;

/// Kinds of the position alone.
pub(super) const KINDS: &[Kind] = &[
    // A ferromagnetic target keeps a magnetisation that follows the travel and saturates: dz = (±1 − z) |dx| / w.
    Kind {
        id: "ooc_magnetic_loop",
        title: "a magnetic hysteresis loop that saturates",
        columns: &[],
        depends_on: &["direction", "history"],
        shape: |uniform, _| vec![uniform(0.12, 0.4)],
        build: |shape| {
            let (width_mm, mut magnetised, mut last_mm) = (shape[0], 0.0, None);
            Box::new(move |at| {
                let moved_mm = at.x_mm - last_mm.unwrap_or(at.x_mm);
                last_mm = Some(at.x_mm);
                let kept = (-moved_mm.abs() / width_mm).exp();
                magnetised = kept * magnetised + (1.0 - kept) * moved_mm.signum();
                magnetised
            })
        },
    },
    // A seal sticks to the rod and is dragged over at every turn; the strain fades.
    Kind {
        id: "ooc_turn_creep",
        title: "creep after every turn, which fades",
        columns: &[],
        depends_on: &["direction", "history", "t_s", "pass"],
        shape: |uniform, duration_s| vec![duration_s * uniform(0.02, 0.06)],
        build: |shape| {
            let time_constant_s = shape[0];
            let (mut furthest_mm, mut heading, mut strained) = (-1.0, 1.0, 0.0);
            Box::new(move |at| {
                strained *= (-at.step_s / time_constant_s).exp();
                let beyond_mm = heading * (at.x_mm - furthest_mm);
                if beyond_mm > 0.0 {
                    furthest_mm = at.x_mm;
                } else if beyond_mm < -TURN_MM {
                    (heading, furthest_mm) = (-heading, at.x_mm);
                    strained += heading;
                }
                strained
            })
        },
    },
    // The mount sits against one of two stops and is dragged over by the cable where the stage has gone far enough.
    Kind {
        id: "ooc_seat_relay",
        title: "a mount that jumps between two seats",
        columns: &[],
        depends_on: &["direction", "history"],
        shape: |uniform, _| vec![uniform(0.1, 0.7), uniform(-0.7, -0.1)],
        build: |shape| {
            let (up_mm, down_mm, mut seat) = (shape[0], shape[1], -1.0);
            Box::new(move |at| {
                if at.x_mm > up_mm {
                    seat = 1.0;
                } else if at.x_mm < down_mm {
                    seat = -1.0;
                }
                seat
            })
        },
    },
    // Grains of the target's surface: bumps of random heights, 80 µm apart, seen through a spot of 60 µm.
    Kind {
        id: "ooc_surface",
        title: "the surface of the target is rough",
        columns: &[],
        depends_on: &["position_mm"],
        shape: |uniform, _| (0..29).map(|_| uniform(-1.0, 1.0)).collect(),
        build: |shape| {
            let heights = shape.to_vec();
            Box::new(move |at| {
                let bump = |(index, height): (usize, &f64)| {
                    let away = (at.x_mm - (0.08 * index as f64 - 1.12)) / 0.06;
                    height * (-0.5 * away * away).exp()
                };
                heights.iter().enumerate().map(bump).sum()
            })
        },
    },
    // A successive-approximation converter whose five highest bits do not weigh what they should.
    Kind {
        id: "ooc_converter",
        title: "bits of the converter that weigh wrongly",
        columns: &[],
        depends_on: &["position_mm"],
        shape: |uniform, _| (0..5).map(|_| uniform(-1.0, 1.0)).collect(),
        build: |shape| {
            let weights = shape.to_vec();
            Box::new(move |at| {
                let code = ((at.raw_mm + 1.2) / 2.4 * 32.0).clamp(0.0, 31.0) as u32;
                weights.iter().enumerate().map(|(bit, weight)| weight * f64::from(code >> bit & 1)).sum()
            })
        },
    },
];
