//! One recording: the device is stepped through a protocol in closed loop and every settled reading is
//! logged.

use std::f64::consts::SQRT_2;

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::chain::Chain;
use crate::controller::settle;
use crate::device::Device;
use crate::environment::Environment;
use crate::geometry::calculated_angle_rad;
use crate::log::Reading;
use crate::noise::{Noise, Source};
use crate::protocol::{Protocol, Stop};
use crate::streams::{Stream, stream};
use crate::truth::Truth;
use crate::units::{arcsec_from_rad, rad_from_arcsec, round_to};

/// Standard deviation in arcseconds of the steady-state deviation that the loop leaves. The mirror really
/// stands there, so probes and autocollimator see it alike: it is no error of the reading.
const LOOP_RESIDUE_ARCSEC: f64 = 0.05;

/// Standard deviation of the thermometer in kelvins.
const THERMOMETER_K: f64 = 0.01;

/// An angle in radians that the controller computes from x₁ and x₂ in millimetres.
pub type Feedback<'a> = &'a dyn Fn(f64, f64) -> f64;

/// A controller that corrects by more than the two probes, and that may remember where it has been.
pub trait Corrector {
    /// The angle in radians that it computes from x₁ and x₂ in millimetres and the temperature in °C, coming
    /// from where it last settled. Called many times on the way to one stop, in no order.
    fn angle_rad(&self, x1_mm: f64, x2_mm: f64, temperature_c: f64) -> f64;

    /// The mirror has come to rest where the probes and the thermometer say this (x₁ and x₂ in mm, temperature in °C);
    /// without memory it need not be known.
    fn settled(&mut self, _: f64, _: f64, _: f64) {}
}

/// A feedback without memory.
struct Stateless<'a>(Feedback<'a>);

impl Corrector for Stateless<'_> {
    fn angle_rad(&self, x1_mm: f64, x2_mm: f64, _: f64) -> f64 {
        (self.0)(x1_mm, x2_mm)
    }
}

/// Steps `device` through `protocol`, each time until `feedback(x1_mm, x2_mm)`, an angle in radians, lands
/// on the command, and returns the log. One seed gives one recording; another seed records the same device
/// again, with other noise and other surroundings.
///
/// The repeatability error of the probes is inside the loop: the *measured* angle lands on the command, so
/// the true angle deviates, which the autocollimator sees. Values have the resolution that the log prints.
/// A command that the feedback cannot reach leaves the mirror at its stop.
pub fn record(device: &Device, protocol: &Protocol, seed: u64, feedback: Feedback) -> Vec<Reading> {
    record_with_truth(device, protocol, seed, feedback).into_iter().map(|(reading, _)| reading).collect()
}

/// As [`record`], with what was true beside each reading.
pub fn record_with_truth(
    device: &Device,
    protocol: &Protocol,
    seed: u64,
    feedback: Feedback,
) -> Vec<(Reading, Truth)> {
    run(device, protocol, seed, &mut Stateless(feedback), 1.0)
}

/// As [`record_with_truth`], with a controller that also reads the temperature and remembers. Between two stops the
/// mirror moves one way only, so that what it remembers is decided by where it stops.
pub fn record_corrected(
    device: &Device,
    protocol: &Protocol,
    seed: u64,
    corrector: &mut dyn Corrector,
) -> Vec<(Reading, Truth)> {
    run(device, protocol, seed, corrector, 1.0)
}

/// As [`record_with_truth`], with no noise in any instrument: the same surroundings and the same commands.
pub fn record_noiseless(
    device: &Device,
    protocol: &Protocol,
    seed: u64,
    feedback: Feedback,
) -> Vec<(Reading, Truth)> {
    run(device, protocol, seed, &mut Stateless(feedback), 0.0)
}

/// What each hidden effect adds to Δθ_M in every row, in arcseconds: the difference between a recording
/// without noise of the device and one of the device without that effect, in the same surroundings and under
/// the same commands. One vector for each effect, in the order of [`Device::effects`]; constants are
/// included, which the unknown zero of the autocollimator takes up.
pub fn contributions(device: &Device, protocol: &Protocol, seed: u64, feedback: Feedback) -> Vec<Vec<f64>> {
    let errors = |device: &Device| -> Vec<f64> {
        let log = record_noiseless(device, protocol, seed, feedback);
        log.iter().map(|(_, truth)| truth.error_arcsec).collect()
    };
    let all = errors(device);
    (0..device.effects().len())
        .map(|index| {
            let without = errors(&device.without(index));
            all.iter().zip(without).map(|(with, without)| with - without).collect()
        })
        .collect()
}

/// Records with the noise of probes, autocollimator and slow channels multiplied by `loudness`.
fn run(
    device: &Device,
    protocol: &Protocol,
    seed: u64,
    corrector: &mut dyn Corrector,
    loudness: f64,
) -> Vec<(Reading, Truth)> {
    let noise = &protocol.noise;
    let stops = protocol.stops(seed);
    let duration_s = stops.last().map_or(0.0, |stop| stop.t_s);
    let Instruments { zero_arcsec, mut optics, mut repeatability } = Instruments::start(device, noise, seed);
    let [mut residue, mut housekeeping, mut settling, mut outliers] =
        [Stream::Controller, Stream::Housekeeping, Stream::Settling, Stream::Outliers]
            .map(|purpose| stream(seed, purpose));
    let drawn = stream(seed, Stream::Environment);
    let mut environment = Environment::start(&protocol.temperature, duration_s, device.plate_mm_per_k, drawn);
    let mut chain = Chain::start(device);

    let (first_deg, last_deg) = protocol.range_deg;
    let mut log = Vec::with_capacity(stops.len());
    for stop in &stops {
        let deviates = std::array::from_fn(|_| settling.sample::<f64, _>(StandardNormal));
        chain.advance(stop, environment.at(stop.t_s), deviates);

        let place = (2.0 * stop.command_deg - first_deg - last_deg) / (last_deg - first_deg);
        let growth = noise.factor_at(place);
        let probe_mm = device.probes.repeatability_mm * growth;
        let errors_mm: [f64; 2] =
            std::array::from_fn(|probe| loudness * probe_mm * repeatability.draw(probe, stop.t_s));
        let report = |frame_rad: f64| {
            let pose = chain.pose_at(frame_rad);
            let [x1, x2] = chain.reports_mm(&pose);
            [x1 + errors_mm[0], x2 + errors_mm[1], pose.temperature_c]
        };
        let left_rad = rad_from_arcsec(LOOP_RESIDUE_ARCSEC * residue.sample::<f64, _>(StandardNormal));
        let command_rad = stop.command_deg.to_radians() + left_rad;
        let land = |command_rad: f64| {
            let angle = |frame_rad| {
                let [x1, x2, temperature_c] = report(frame_rad);
                corrector.angle_rad(x1, x2, temperature_c)
            };
            settle(angle, command_rad, device.drive.stop_rad)
        };
        let frame_rad = land(command_rad);
        let [x1_mm, x2_mm, at_c] = report(frame_rad);
        // What the autocollimator looks at is where the command was then, and the mirror with it.
        let behind_rad = (stop.speed_deg_per_s * chain.reference_delay_s()).to_radians();
        let seen_at_rad = if behind_rad == 0.0 { frame_rad } else { land(command_rad - behind_rad) };
        let seen_rad = chain.pose_at(seen_at_rad).mirror_rad;
        let pose = chain.settle(frame_rad);
        corrector.settled(x1_mm, x2_mm, at_c);

        let optics_arcsec = device.autocollimator.total_noise_arcsec() * growth;
        let disturbed = noise.disturbance(&mut outliers);
        let seen_arcsec = arcsec_from_rad(seen_rad) + chain.reference_arcsec(&pose);
        let reference_noise_arcsec = loudness * optics_arcsec * disturbed * optics.draw(0, stop.t_s);
        let reference_arcsec = seen_arcsec + zero_arcsec + reference_noise_arcsec;

        let mut normal = || loudness * housekeeping.sample::<f64, _>(StandardNormal);
        let cross_arcsec = pose.cross_arcsec + device.autocollimator.cross_noise_arcsec * normal();
        let coil_a = pose.coil_a + device.drive.noise_a * normal();
        let temperature_c = pose.temperature_c + THERMOMETER_K * normal();
        let reading = logged(stop, [x1_mm, x2_mm], reference_arcsec, [cross_arcsec, temperature_c, coil_a]);
        let d = device.geometry.probe_distance_mm;
        let per_mm = arcsec_from_rad(device.probes.error.slope_rad_per_mm(x2_mm - x1_mm));
        let truth = Truth {
            true_angle_rad: pose.mirror_rad,
            zero_arcsec,
            error_arcsec: arcsec_from_rad(calculated_angle_rad(x1_mm, x2_mm, d)) + zero_arcsec
                - reference_arcsec,
            reference_noise_arcsec,
            probe_noise_arcsec: per_mm * SQRT_2 * probe_mm,
            optics_noise_arcsec: optics_arcsec * noise.outlier_variance().sqrt(),
            outlier: disturbed > 1.0,
            pose,
        };
        log.push((reading, truth));
    }
    log
}

/// The zero of the autocollimator, its noise, and that of the probes.
struct Instruments {
    zero_arcsec: f64,
    optics: Source,
    repeatability: Source,
}

impl Instruments {
    fn start(device: &Device, noise: &Noise, seed: u64) -> Instruments {
        let mut optics = stream(seed, Stream::Autocollimator);
        let within = device.autocollimator.zero_within_arcsec;
        Instruments {
            zero_arcsec: optics.random_range(-within..=within),
            optics: Source::start(noise, 1, optics),
            repeatability: Source::start(noise, 2, stream(seed, Stream::Probes)),
        }
    }
}

/// A reading with the digits that the log prints. `slow` holds the second axis in arcsec, °C and amperes.
fn logged(stop: &Stop, [x1_mm, x2_mm]: [f64; 2], reference_arcsec: f64, slow: [f64; 3]) -> Reading {
    let [cross_arcsec, temperature_c, coil_a] = slow;
    Reading {
        t_s: round_to(stop.t_s, 2),
        pass: stop.pass,
        direction: stop.direction,
        command_deg: round_to(stop.command_deg, 3),
        x1_mm: round_to(x1_mm, 7),
        x2_mm: round_to(x2_mm, 7),
        reference_arcsec: round_to(reference_arcsec, 3),
        cross_arcsec: round_to(cross_arcsec, 3),
        temperature_c: round_to(temperature_c, 3),
        coil_a: round_to(coil_a, 5),
    }
}

#[cfg(test)]
mod noise_tests;
#[cfg(test)]
mod tests;
