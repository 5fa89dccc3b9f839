//! Pairs of recordings of a linear drive in its position loop, along the same or another motion. Half of the drives are as
//! the nominal plant says, but for their friction and lag; the others have a ripple that no effect explains. Half of them rest
//! where they arrive.

use std::f64::consts::TAU;
use std::fmt::Write;

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::dynamic::drive_loop::{Actuator, Carriage, Load, RATE_HZ, run};

use super::{Kind, Pair};

const PLANT: &str = include_str!("feedback.toml");
/// Samples of a recording: ten seconds.
const ROWS: usize = 10_000;
/// What becomes stronger, and by which parts.
const MOVED: [(&str, [f64; 2]); 4] = [
    ("coulomb_friction", [0.15, 0.3]),
    ("damping", [0.2, 0.4]),
    ("inertia", [0.1, 0.15]),
    ("drive_offset", [0.5, 1.0]),
];
/// What comes.
const CAME: [&str; 5] = ["stiffness", "cogging", "stribeck_friction", "backlash", "local_friction"];
/// Longest rest at a target, in seconds.
const LONGEST_REST_S: f64 = 0.6;

/// Draws a pair. Every other pair follows the same motion twice. Whether a recording can tell what changed is not asked.
pub(super) fn pair(kind: Kind, number: usize, generator: &mut ChaCha12Rng) -> Pair {
    let mut then = Carriage {
        mass_kg: generator.random_range(0.7..1.5),
        viscous: generator.random_range(1.0..4.0),
        dry_n: generator.random_range(0.2..0.8),
        low_speed_n: 0.0,
        offset_n: generator.random_range(0.1..0.2),
        spring_n_per_m: 0.0,
        cogging_n: 0.0,
        period_m: 0.025,
        worn_n: 0.0,
        worn_at_m: generator.random_range(-0.03..0.03),
        worn_width_m: generator.random_range(0.002..0.006),
        load: None,
    };
    let mut actuator = Actuator {
        lag_s: 10f64.powf(generator.random_range(-3.7..-2.7)),
        noise_m: 10f64.powf(generator.random_range(-6.3..-5.3)),
        gain: generator.random_range(0.7..1.3),
        ripple_n: [0.0; 3],
        phases_rad: [0.0; 3].map(|_| generator.random_range(0.0..TAU)),
        ripple_m: generator.random_range(0.1..0.15),
    };
    let stronger = generator.random();
    if generator.random() {
        let size = 10f64.powf(generator.random_range(-2.0..-1.4));
        actuator.ripple_n = [0.0; 3].map(|_| size * generator.random_range(-2.0..2.0));
    }
    let (id, mut now) = changed(kind, number, stronger, &then);
    if let Some(load) = now.load {
        // It is there before, without a play; some of the friction and half of the mass are its own.
        then.load = Some(Load { play_m: 0.0, ..load });
        for carriage in [&mut then, &mut now] {
            carriage.mass_kg -= load.mass_kg;
            carriage.dry_n -= load.dry_n;
        }
    }
    let rests = generator.random();
    let first = motion(rests, generator);
    let second = if number.is_multiple_of(2) { motion(rests, generator) } else { first.clone() };
    let mut record = |carriage: &Carriage, command_m: &[f64]| {
        let mut text = String::from("t_s,drive,position,command\n");
        for (row, sample) in run(carriage, &actuator, command_m, generator).iter().enumerate() {
            let t_s = row as f64 / RATE_HZ;
            // Writing to memory does not fail.
            let _ = writeln!(
                text,
                "{t_s:.3},{:.6},{:.9},{:.9}",
                sample.drive_n, sample.position_m, sample.command_m
            );
        }
        text
    };
    Pair {
        then: record(&then, &first),
        now: record(&now, &second),
        nominal: PLANT.into(),
        id: id.map(str::to_string),
        can_tell: false,
    }
}

/// What changes, and the carriage after it. `stronger`, from 0 to 1, says how much within the range of such changes.
fn changed(kind: Kind, number: usize, stronger: f64, then: &Carriage) -> (Option<&'static str>, Carriage) {
    let mut now = *then;
    // Of each change as many pairs with the same motion as with another.
    let turn = number / 2;
    match kind {
        Kind::Same => (None, now),
        Kind::Moved => {
            let (id, [least, most]) = MOVED[turn % MOVED.len()];
            let value = match id {
                "coulomb_friction" => &mut now.dry_n,
                "damping" => &mut now.viscous,
                "inertia" => &mut now.mass_kg,
                _ => &mut now.offset_n,
            };
            *value *= 1.0 + least + (most - least) * stronger;
            (Some(id), now)
        }
        Kind::Came => {
            let id = CAME[turn % CAME.len()];
            match id {
                "stiffness" => now.spring_n_per_m = 3.0 + 2.0 * stronger,
                "cogging" => now.cogging_n = 0.1 + 0.1 * stronger,
                "backlash" => {
                    let play_m = 1e-4 + 3e-4 * stronger;
                    now.load = Some(Load { mass_kg: 0.5 * then.mass_kg, dry_n: 0.6 * then.dry_n, play_m });
                }
                "local_friction" => now.worn_n = (0.4 + 0.4 * stronger) * then.dry_n,
                _ => now.low_speed_n = 0.2 + 0.2 * stronger,
            }
            (Some(id), now)
        }
    }
}

/// Commanded positions: three slow sines, or, twice as often, trapezoids of the speed between random targets, with or without
/// `rests` there.
fn motion(rests: bool, generator: &mut ChaCha12Rng) -> Vec<f64> {
    let sample_s = 1.0 / RATE_HZ;
    let size = 0.08 * generator.random_range(0.6..1.2);
    if generator.random_range(0..3) == 0 {
        let tones: [[f64; 2]; 3] =
            std::array::from_fn(|_| [generator.random_range(0.2..1.2), generator.random_range(0.0..TAU)]);
        let at = |t: f64| tones.iter().map(|[hz, phase]| (TAU * hz * t + phase).sin()).sum::<f64>();
        return (0..ROWS).map(|k| size / 3.0 * (at(k as f64 * sample_s) - at(0.0))).collect();
    }
    let fastest: f64 = 0.25 * generator.random_range(0.6..1.2);
    let acceleration = 2.0 * generator.random_range(0.6..1.3);
    let step = acceleration * sample_s;
    let (mut position, mut speed, mut target, mut rest_s) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let next = |_| {
        if rest_s > 0.0 {
            rest_s -= sample_s;
            return position;
        }
        if (target - position).abs() < 1e-4 && speed.abs() < 2.0 * step {
            target = size * generator.random_range(-1.0..1.0);
            if rests {
                (speed, rest_s) = (0.0, generator.random_range(0.0..LONGEST_REST_S));
            }
        }
        let left = target - position;
        let wanted = left.signum() * fastest.min((2.0 * acceleration * left.abs()).sqrt());
        speed += (wanted - speed).clamp(-step, step);
        position += speed * sample_s;
        position
    };
    (0..ROWS).map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn every_other_pair_follows_the_same_motion_with_other_noise() {
        let draw = |number| pair(Kind::Same, number, &mut ChaCha12Rng::seed_from_u64(3));
        let column = |text: &str, index: usize| -> Vec<f64> {
            let rows = text.lines().skip(1);
            rows.map(|line| line.split(',').nth(index).unwrap().parse().unwrap()).collect()
        };
        for (number, same) in [(0, false), (1, true)] {
            let Pair { then, now, .. } = draw(number);
            assert_eq!(column(&then, 3) == column(&now, 3), same, "{number}");
            assert_ne!(column(&then, 2), column(&now, 2), "{number}");
            // The loop follows.
            let late =
                column(&then, 2).iter().zip(column(&then, 3)).map(|(p, c)| (p - c).abs()).fold(0.0, f64::max);
            assert!(late < 0.02, "{late}");
        }
    }
}
