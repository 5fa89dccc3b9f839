//! A linear drive in its position loop: a carriage with friction, its actuator and a sampled controller. Lengths in metres,
//! forces in newtons.
//!
//! It calls nothing of [`motion`], by which drives are diagnosed: friction passes through rest smoothly, falls off
//! exponentially at low speed, a play lies between two masses that meet in it, and a ripple of the force is no effect of the
//! catalogue.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_distr::StandardNormal;

/// Samples of the controller per second.
pub const RATE_HZ: f64 = 1000.0;
/// Steps of the integration in one sample.
const STEPS: usize = 10;
/// Below this speed in m/s friction passes from one sign to the other.
const CREEP_M_PER_S: f64 = 1e-3;
/// Speed in m/s over which friction falls from its value at rest.
const STRIBECK_M_PER_S: f64 = 0.03;
/// Stiffness in N/m and damping in N s/m where a load and what drives it touch.
const CONTACT: [f64; 2] = [5e5, 300.0];
/// Gains of the controller: in N/m of the position's error, in N s/m of the estimated speed.
const GAINS: [f64; 2] = [4000.0, 80.0];
/// Part of each new difference that the controller's estimate of the speed takes.
const SPEED_PART: f64 = 0.2;

/// What moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Carriage {
    /// Mass in kg.
    pub mass_kg: f64,
    /// Viscous friction in N s/m.
    pub viscous: f64,
    /// Dry friction in N.
    pub dry_n: f64,
    /// Further dry friction at low speed in N.
    pub low_speed_n: f64,
    /// Constant force in N.
    pub offset_n: f64,
    /// Stiffness of a spring to the origin in N/m.
    pub spring_n_per_m: f64,
    /// Amplitude in N of a force that is periodic in the position.
    pub cogging_n: f64,
    /// Its period in m.
    pub period_m: f64,
    /// Further dry friction in N at one place.
    pub worn_n: f64,
    /// Where that place is, in m.
    pub worn_at_m: f64,
    /// Half of its width in m.
    pub worn_width_m: f64,
    /// A load that is driven through a play.
    pub load: Option<Load>,
}

/// What is driven through a screw or a coupling, beside the carriage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Mass in kg.
    pub mass_kg: f64,
    /// Dry friction in N.
    pub dry_n: f64,
    /// Play between it and the carriage in m.
    pub play_m: f64,
}

/// What drives and measures it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actuator {
    /// Time constant of its force in seconds.
    pub lag_s: f64,
    /// Noise of the measured position in metres (rms).
    pub noise_m: f64,
    /// Factor of the controller's gains.
    pub gain: f64,
    /// Amplitudes in N of a ripple that follows the position at one and two periods, and of one that also changes sign with
    /// the direction at three.
    pub ripple_n: [f64; 3],
    /// Phases of these in radians.
    pub phases_rad: [f64; 3],
    /// Longest of their periods in metres.
    pub ripple_m: f64,
}

/// One sample of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Commanded position in metres.
    pub command_m: f64,
    /// Measured position in metres.
    pub position_m: f64,
    /// Force that the controller asks for in N.
    pub drive_n: f64,
}

/// Follows commanded positions, one for each sample of the controller, from rest at the origin; as many samples.
pub fn run(
    carriage: &Carriage,
    actuator: &Actuator,
    command_m: &[f64],
    generator: &mut ChaCha12Rng,
) -> Vec<Sample> {
    let sample_s = 1.0 / RATE_HZ;
    let step_s = sample_s / STEPS as f64;
    let [proportional, derivative] = GAINS.map(|gain| gain * actuator.gain);
    let (mut position, mut speed, mut force) = (0.0, 0.0, 0.0);
    let (mut load_position, mut load_speed) = (0.0, 0.0);
    let (mut before, mut estimate) = (0.0, 0.0);
    let one = |&command_m: &f64| {
        let position_m = position + actuator.noise_m * generator.sample::<f64, _>(StandardNormal);
        estimate += SPEED_PART * ((position_m - before) / sample_s - estimate);
        before = position_m;
        let drive_n = proportional * (command_m - position_m) - derivative * estimate;
        for _ in 0..STEPS {
            force += step_s / actuator.lag_s * (drive_n - force);
            let mut against = carriage.resistance_n(position, speed) + actuator.ripple_n(position, speed);
            if let Some(load) = &carriage.load {
                let contact = load.contact_n(position - load_position, speed - load_speed);
                load_speed += step_s * (contact - load.dry_n * sign(load_speed)) / load.mass_kg;
                load_position += step_s * load_speed;
                against += contact;
            }
            speed += step_s * (force - against) / carriage.mass_kg;
            position += step_s * speed;
        }
        Sample { command_m, position_m, drive_n }
    };
    command_m.iter().map(one).collect()
}

/// Sign of a speed, smooth about rest.
fn sign(speed: f64) -> f64 {
    (speed / CREEP_M_PER_S).tanh()
}

impl Carriage {
    fn resistance_n(&self, position: f64, speed: f64) -> f64 {
        let from_worn = (position - self.worn_at_m) / self.worn_width_m;
        let dry = self.dry_n
            + self.low_speed_n * (-speed.abs() / STRIBECK_M_PER_S).exp()
            + self.worn_n / (1.0 + from_worn.powi(4));
        dry * sign(speed)
            + self.viscous * speed
            + self.offset_n
            + self.spring_n_per_m * position
            + self.cogging_n * (TAU * position / self.period_m).sin()
    }
}

impl Load {
    /// The force that carries it along where it is so far behind, and falls behind so fast.
    fn contact_n(&self, behind: f64, falls: f64) -> f64 {
        let pressed = behind - behind.clamp(-0.5 * self.play_m, 0.5 * self.play_m);
        let force = CONTACT[0] * pressed + CONTACT[1] * falls;
        // Surfaces push, and do not pull, unless there is no play.
        if self.play_m == 0.0 || force * pressed > 0.0 { force } else { 0.0 }
    }
}

impl Actuator {
    fn ripple_n(&self, position: f64, speed: f64) -> f64 {
        let wave = |k: usize| {
            let angle = TAU * (k + 1) as f64 * position / self.ripple_m + self.phases_rad[k];
            self.ripple_n[k] * angle.sin()
        };
        wave(0) + wave(1) + wave(2) * sign(speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn at_constant_speed_the_drive_carries_what_resists() {
        let carriage = Carriage {
            mass_kg: 1.0,
            viscous: 2.0,
            dry_n: 0.5,
            low_speed_n: 0.2,
            offset_n: 0.1,
            spring_n_per_m: 0.0,
            cogging_n: 0.0,
            period_m: 0.025,
            worn_n: 0.3,
            worn_at_m: 0.1,
            worn_width_m: 0.005,
            load: Some(Load { mass_kg: 1.0, dry_n: 0.4, play_m: 1e-4 }),
        };
        let actuator = Actuator {
            lag_s: 1e-3,
            noise_m: 0.0,
            gain: 1.0,
            ripple_n: [0.0; 3],
            phases_rad: [0.0; 3],
            ripple_m: 0.02,
        };
        let ramp: Vec<f64> = (0..3000).map(|k| 0.2 * k as f64 / RATE_HZ).collect();
        let run = run(&carriage, &actuator, &ramp, &mut ChaCha12Rng::seed_from_u64(1));
        let last = run.last().unwrap();
        let low_speed = 0.2 * (-0.2f64 / STRIBECK_M_PER_S).exp();
        assert!((last.drive_n - (0.5 + low_speed + 2.0 * 0.2 + 0.1 + 0.4)).abs() < 1e-3, "{last:?}");
    }
}
