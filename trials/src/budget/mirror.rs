//! Mirrors: the paper's calibration, an error curve of the device's own.

use codegen::format::Format;
use codegen::input::{Arity, Encoding, Input};
use codegen::options::{Method, Options, RoutineOptions};
use codegen::output::Output;
use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::protocol::Order;
use twin::units::arcsec_from_rad;
use twin::{Device, Protocol, calculated_angle_rad, record_with_truth, write_csv};

use super::reference::{A_QUARTER, Reference};
use super::{Fresh, TENTHS, Trial};

const ACCURACY_ARCSEC: f64 = 1.0;
/// One count of the 16-bit converter of the difference of the probes: 0.2″.
const COUNT_MM: f64 = 1.2e-5;
const MIDDLE: f64 = 32_768.0;
/// Fresh stops: as far as the calibration went, less what a stop may miss.
const FRESH_DEG: f64 = 1.69;
/// By how much each coefficient of the published error curve is changed, as a part of it.
const CHANGED: f64 = 0.3;

pub fn simulate(generator: &mut ChaCha12Rng) -> Trial {
    let mut device = Device::from_seed(generator.random());
    for coefficient in &mut device.probes.error.coefficients {
        *coefficient *= 1.0 + CHANGED * generator.random_range(-1.0..1.0);
    }
    let reference = Reference::draw(ACCURACY_ARCSEC, A_QUARTER, generator);
    let protocol = Protocol::calibration();
    let d_mm = device.geometry.probe_distance_mm;
    let loop_on = |x1: f64, x2: f64| calculated_angle_rad(x1, x2, d_mm);
    let mut calibration = record_with_truth(&device, &protocol, generator.random(), &loop_on);
    let zero_arcsec = calibration.first().map_or(0.0, |(_, truth)| truth.zero_arcsec);
    let (first, last) = protocol.range_deg;
    for (reading, _) in &mut calibration {
        reading.reference_arcsec += reference.error((reading.command_deg - first) / (last - first));
    }
    let log: Vec<_> = calibration.into_iter().map(|(reading, _)| reading).collect();
    let mut csv = Vec::new();
    // Writing into memory has no way to fail.
    let _ = write_csv(&log, &mut csv);
    let again = Protocol {
        range_deg: (-FRESH_DEG, FRESH_DEG),
        step_deg: FRESH_DEG / 50.0,
        passes: 1,
        order: Order::Random,
        ..protocol
    };
    let stops = record_with_truth(&device, &again, generator.random(), &loop_on);
    let half_mm = d_mm * last.to_radians().tan();
    let one = |(reading, truth): &(twin::Reading, twin::Truth)| {
        let s_mm = reading.x2_mm - reading.x1_mm;
        let tenth = (TENTHS as f64 * 0.5 * (s_mm / half_mm + 1.0)) as usize;
        let word = (s_mm / COUNT_MM + MIDDLE).round() as i64;
        let truth = arcsec_from_rad(truth.true_angle_rad) + zero_arcsec;
        Fresh { tenth: tenth.min(TENTHS - 1), place: s_mm, word, further: None, truth }
    };
    let fresh: Vec<Fresh> = stops.iter().map(one).collect();
    Trial {
        csv,
        mirror: format!(
            "[geometry]\nprobe_distance_mm = {d_mm:?}\ninitial_gap_mm = 0.3\n[reference]\naccuracy_arcsec = \
             {ACCURACY_ARCSEC:?}\nrepeatability_arcsec = {:?}\n",
            device.autocollimator.total_noise_arcsec()
        ),
        diagnosed: false,
        options: counts(16, COUNT_MM, MIDDLE),
        fresh: super::one_in_each(fresh),
        turn: None,
        from_zero: true,
    }
}

/// One q31 routine of a converter's counts.
pub fn counts(bits: u32, gain: f64, offset: f64) -> Options {
    let input = Input { arity: Arity::Reading, encoding: Encoding::Counts { bits, gain, offset } };
    let (method, format, output) = (Method::Fused, Format::Q31, Output::PowerOfTwo);
    Options { routines: vec![RoutineOptions { method, format, input, output }], ..Options::default() }
}
