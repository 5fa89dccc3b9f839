//! The position loop of the paper's Figures 2 and 8: mirror on its flexure, voice coils and amplifier, probes
//! and converters, and a sampled controller that steers by whatever angle is computed from the two probes.
//!
//! The mechanism runs in continuous time between the samples of the controller, the drive being held; probes
//! see the plate through their characteristics, converters round.

use fitter::plant::{Hold, PlantEffect};
use motion::integrate::{Progress, integrator};
use motion::{Context, Model, RunError, Signal, Typical};
use rand::RngExt;
use rand_distr::StandardNormal;

use crate::device::Device;
use crate::noise::Wander;
use crate::record::Feedback;
use crate::streams::{Stream, stream};

/// The electronics and the mechanism of the loop, angles in radians.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionLoop {
    /// Natural frequency of the mirror on its flexure in rad/s.
    pub omega_rad_per_s: f64,
    /// Its damping, as a part of the critical one.
    pub damping_ratio: f64,
    /// Time constant of amplifier and coils in seconds.
    pub amplifier_s: f64,
    /// The amplifier's largest current in A.
    pub largest_a: f64,
    /// Samples of the controller per second; an NI cRIO-9034 closes such a loop in its FPGA.
    pub rate_hz: f64,
    /// Poles of the closed loop in rad/s, all three there.
    pub bandwidth_rad_per_s: f64,
    /// Time constant in seconds of the filter of the controller's derivative.
    pub derivative_s: f64,
    /// Resolution of the converter that reads the probes, in millimetres.
    pub converter_mm: f64,
    /// Noise of one sample of one probe in millimetres, beside its repeatability.
    pub sample_noise_mm: f64,
    /// Over how long the repeatability error of a probe wanders, in seconds.
    pub wander_s: f64,
    /// Effects in the mechanism, in radians and amperes.
    pub effects: Vec<PlantEffect>,
}

impl Default for PositionLoop {
    /// 30 Hz, damped by 10 %; sampled at 5 kHz by 16 bits over the probes' range of 0.5 mm.
    fn default() -> Self {
        Self {
            omega_rad_per_s: 190.0,
            damping_ratio: 0.1,
            amplifier_s: 1e-4,
            largest_a: 1.0,
            rate_hz: 5000.0,
            bandwidth_rad_per_s: 250.0,
            derivative_s: 4e-4,
            converter_mm: 0.5 / 65_536.0,
            sample_noise_mm: 5e-6,
            wander_s: 0.5,
            effects: Vec::new(),
        }
    }
}

/// One sample of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time in seconds.
    pub t_s: f64,
    /// Commanded angle in radians.
    pub command_rad: f64,
    /// The angle that was fed back, in radians.
    pub measured_rad: f64,
    /// The true angle in radians.
    pub true_rad: f64,
    /// Readings of the probes in millimetres.
    pub x_mm: [f64; 2],
    /// The current that the controller asked for in A.
    pub drive_a: f64,
}

impl PositionLoop {
    /// Runs the loop on commanded angles in radians, one for each sample of the controller.
    ///
    /// # Errors
    /// A mechanism that cannot be simulated.
    pub fn run(
        &self,
        device: &Device,
        command_rad: &[f64],
        feedback: Feedback,
        seed: u64,
    ) -> Result<Vec<Sample>, RunError> {
        let sample_s = 1.0 / self.rate_hz;
        let k = self.omega_rad_per_s.powi(2);
        let d = 2.0 * self.damping_ratio * self.omega_rad_per_s;
        // In equilibrium the coils hold the flexure with the current that they have in a settled recording.
        let gain = k / device.drive.stiffness_a_per_rad;
        let mut effects = self.effects.clone();
        effects.push(PlantEffect::new("drive_lag", &[("time_constant_s", self.amplifier_s)]));
        effects.push(PlantEffect::new("drive_saturation", &[("limit", self.largest_a)]));
        let context = Context { feedback: false };
        let model =
            Model { damping: d, stiffness: k, gains: vec![gain], effects, hold: Hold::ZeroOrder, context };
        let mut mechanism = model.mechanism()?;
        let size = command_rad.iter().fold(1e-4f64, |most, c| most.max(c.abs()));
        let typical = Typical {
            position: size,
            velocity: size * self.bandwidth_rad_per_s,
            drive: size * k / gain,
            ..Typical::of(&model, &[vec![0.0; 2]], sample_s)
        };
        let start = Progress { t_s: 0.0, state: mechanism.at(0.0, 0.0, &[0.0]) };
        let mut integrator = integrator(&mechanism, &typical, &start)?;
        let mut signals = [Signal::held(sample_s)];
        let mut controller = Controller::new(self, k, d, gain, sample_s);
        let mut electronics = stream(seed, Stream::Probes);
        let deviation_mm = device.probes.repeatability_mm;
        let mut wanders: [Wander; 2] =
            std::array::from_fn(|_| Wander::start(deviation_mm, self.wander_s, &mut electronics));
        let mut samples = Vec::with_capacity(command_rad.len());
        for (index, &command_rad) in command_rad.iter().enumerate() {
            let t_s = index as f64 * sample_s;
            let state = integrator.progress().state;
            // The stop is hard: nothing that the loop is asked for reaches it.
            let true_rad = state[0].clamp(-device.drive.stop_rad, device.drive.stop_rad);
            let mut x_mm = device.report_mm(true_rad, 0.0);
            for (x, wander) in x_mm.iter_mut().zip(&mut wanders) {
                let noise_mm = self.sample_noise_mm * electronics.sample::<f64, _>(StandardNormal);
                let seen_mm = *x + wander.at(t_s, &mut electronics) + noise_mm;
                *x = (seen_mm / self.converter_mm).round() * self.converter_mm;
            }
            let measured_rad = feedback(x_mm[0], x_mm[1]);
            let drive_a = controller.drive_a(command_rad, measured_rad);
            samples.push(Sample { t_s, command_rad, measured_rad, true_rad, x_mm, drive_a });
            signals[0].push(drive_a);
            integrator.advance(&mut mechanism, &signals, t_s + sample_s)?;
        }
        Ok(samples)
    }
}

/// Proportional, integral and derivative control with the three poles of the loop in one place: the derivative
/// of the measured angle, filtered; the integral stops where the amplifier is at its limit.
struct Controller {
    proportional: f64,
    integral: f64,
    derivative: f64,
    keep: f64,
    sample_s: f64,
    largest_a: f64,
    sum_a: f64,
    before_rad: Option<f64>,
    slope: f64,
}

impl Controller {
    /// (s + ω_c)³ = s³ + (d + g K_d) s² + (k + g K_p) s + g K_i.
    fn new(plan: &PositionLoop, k: f64, d: f64, gain: f64, sample_s: f64) -> Self {
        let pole = plan.bandwidth_rad_per_s;
        Self {
            proportional: (3.0 * pole * pole - k) / gain,
            integral: pole.powi(3) / gain,
            derivative: (3.0 * pole - d) / gain,
            keep: (-sample_s / plan.derivative_s).exp(),
            sample_s,
            largest_a: plan.largest_a,
            sum_a: 0.0,
            before_rad: None,
            slope: 0.0,
        }
    }

    fn drive_a(&mut self, command_rad: f64, measured_rad: f64) -> f64 {
        let fresh = (measured_rad - self.before_rad.unwrap_or(measured_rad)) / self.sample_s;
        self.before_rad = Some(measured_rad);
        self.slope = self.keep * self.slope + (1.0 - self.keep) * fresh;
        let deviation_rad = command_rad - measured_rad;
        let sum_a = self.sum_a + self.integral * deviation_rad * self.sample_s;
        // Proportional action on the measured angle alone: a step of the command does not kick.
        let wanted_a = sum_a - self.proportional * measured_rad - self.derivative * self.slope;
        let drive_a = wanted_a.clamp(-self.largest_a, self.largest_a);
        let relieves = (wanted_a - drive_a) * deviation_rad < 0.0;
        if wanted_a == drive_a || relieves {
            self.sum_a = sum_a;
        }
        drive_a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::calculated_angle_rad;
    use crate::units::arcsec_from_rad;

    #[test]
    fn the_mirror_follows_a_step_without_ringing() {
        let device = Device::from_seed(3);
        let step = 0.5f64.to_radians();
        let correct = |x1: f64, x2: f64| device.probes.error.true_angle_rad(x2 - x1);
        let samples = PositionLoop::default().run(&device, &vec![step; 1500], &correct, 1).unwrap();
        let arrived = |s: &Sample| arcsec_from_rad(s.true_rad - step).abs();
        assert!(samples[0].true_rad == 0.0 && arrived(&samples[100]) > 100.0);
        // Three poles at 250 rad/s: after 0.2 s e^(−50).
        assert!(samples[1000..].iter().all(|s| arrived(s) < 6.0));
        let highest = samples.iter().map(|s| s.true_rad).fold(0.0, f64::max);
        assert!(highest < 1.05 * step, "{}", highest / step);
    }

    #[test]
    fn a_command_beyond_the_amplifier_saturates_and_recovers() {
        let device = Device::from_seed(3);
        let weak = PositionLoop { largest_a: 0.04, ..PositionLoop::default() };
        let feedback = |x1: f64, x2: f64| calculated_angle_rad(x1, x2, 12.0);
        let mut command = vec![1.5f64.to_radians(); 2500];
        command.extend(vec![0.2f64.to_radians(); 2500]);
        let samples = weak.run(&device, &command, &feedback, 1).unwrap();
        assert!(samples[2400].drive_a == 0.04);
        assert!((samples[4900].measured_rad - 0.2f64.to_radians()).abs() < 1e-4);
    }
}
