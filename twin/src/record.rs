//! One recording: the device is stepped through a protocol in closed loop and every settled reading is
//! logged.

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::controller::settle;
use crate::device::Device;
use crate::environment::Environment;
use crate::log::Reading;
use crate::protocol::Protocol;
use crate::streams::{Stream, stream};
use crate::units::{arcsec_from_rad, rad_from_arcsec, round_to};

/// Standard deviation in arcseconds of the steady-state deviation that the loop leaves. The mirror really
/// stands there, so probes and autocollimator see it alike: it is no error of the reading.
const LOOP_RESIDUE_ARCSEC: f64 = 0.05;

/// Standard deviation of the thermometer in kelvins.
const THERMOMETER_K: f64 = 0.01;

/// What nobody in the laboratory knows about one reading; never written to a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// True angle of the mirror in radians.
    pub true_angle_rad: f64,
    /// Translation of the plate in millimetres.
    pub translation_mm: f64,
    /// The zero α₀ of the autocollimator in arcseconds, the same in every row.
    pub zero_arcsec: f64,
}

/// Steps `device` through `protocol`, each time until `feedback(x1_mm, x2_mm)`, an angle in radians, lands
/// on the command, and returns the log. One seed gives one recording.
///
/// The repeatability error of the probes is inside the loop: the *measured* angle lands on the command, so
/// the true angle deviates, which the autocollimator sees. Values have the resolution that the log prints.
/// A command that the feedback cannot reach leaves the mirror at its stop.
pub fn record(
    device: &Device,
    protocol: &Protocol,
    seed: u64,
    feedback: &dyn Fn(f64, f64) -> f64,
) -> Vec<Reading> {
    record_with_truth(device, protocol, seed, feedback).into_iter().map(|(reading, _)| reading).collect()
}

/// As [`record`], with what was true beside each reading.
pub fn record_with_truth(
    device: &Device,
    protocol: &Protocol,
    seed: u64,
    feedback: &dyn Fn(f64, f64) -> f64,
) -> Vec<(Reading, Truth)> {
    let mut timing = stream(seed, Stream::Timing);
    let mut repeatability = stream(seed, Stream::Probes);
    let mut optics = stream(seed, Stream::Autocollimator);
    let mut residue = stream(seed, Stream::Controller);
    let mut housekeeping = stream(seed, Stream::Housekeeping);
    let mut settling = stream(seed, Stream::Settling);
    let mut environment = Environment::laboratory(device.plate_mm_per_k, stream(seed, Stream::Environment));
    let autocollimator = &device.autocollimator;
    let within = autocollimator.zero_within_arcsec;
    let zero_arcsec = optics.random_range(-within..=within);

    let forward = protocol.angles_deg();
    let mut t_s = 0.0;
    let mut log = Vec::with_capacity(forward.len() * protocol.passes as usize);
    for pass in 0..protocol.passes {
        let direction = if pass % 2 == 0 { 1 } else { -1 };
        if pass > 0 {
            t_s += protocol.pause_s;
        }
        for step in 0..forward.len() {
            let command_deg = if direction > 0 { forward[step] } else { forward[forward.len() - 1 - step] };
            let jitter = protocol.dwell_jitter_s;
            t_s += protocol.dwell_s + timing.random_range(-jitter..=jitter);
            let around = environment.at(t_s);

            let errors: [f64; 2] = std::array::from_fn(|_| {
                device.probes.repeatability_mm * repeatability.sample::<f64, _>(StandardNormal)
            });
            let report = |angle_rad: f64| {
                let [x1, x2] = device.report_mm(angle_rad, around.translation_mm);
                [x1 + errors[0], x2 + errors[1]]
            };
            let left_rad = rad_from_arcsec(LOOP_RESIDUE_ARCSEC * residue.sample::<f64, _>(StandardNormal));
            let true_angle_rad = settle(
                |angle_rad| {
                    let [x1, x2] = report(angle_rad);
                    feedback(x1, x2)
                },
                command_deg.to_radians() + left_rad,
                device.drive.stop_rad,
            );
            let [x1_mm, x2_mm] = report(true_angle_rad);

            let mut normal = || housekeeping.sample::<f64, _>(StandardNormal);
            let reference_noise =
                autocollimator.total_noise_arcsec() * optics.sample::<f64, _>(StandardNormal);
            let mut settled = || settling.sample::<f64, _>(StandardNormal);
            let cross_arcsec = device.second_axis.at(true_angle_rad)
                + around.cross_arcsec
                + device.second_axis.settling_arcsec * settled()
                + autocollimator.cross_noise_arcsec * normal();
            let coil_a = device.drive.stiffness_a_per_rad * true_angle_rad
                + device.drive.offset_a
                + device.drive.creep_a * around.creep
                + device.drive.settling_a * settled()
                + device.drive.noise_a * normal();
            let reading = Reading {
                t_s: round_to(t_s, 2),
                pass: pass + 1,
                direction,
                command_deg: round_to(command_deg, 3),
                x1_mm: round_to(x1_mm, 7),
                x2_mm: round_to(x2_mm, 7),
                reference_arcsec: round_to(
                    arcsec_from_rad(true_angle_rad) + zero_arcsec + reference_noise,
                    3,
                ),
                cross_arcsec: round_to(cross_arcsec, 3),
                temperature_c: round_to(around.temperature_c + THERMOMETER_K * normal(), 3),
                coil_a: round_to(coil_a, 5),
            };
            let truth = Truth { true_angle_rad, translation_mm: around.translation_mm, zero_arcsec };
            log.push((reading, truth));
        }
    }
    log
}

#[cfg(test)]
mod tests;
