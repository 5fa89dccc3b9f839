//! SimpleFOC.

use std::f64::consts::TAU;

use codegen::generate::Generated;
use codegen::tables::simplefoc::{calibrated, raw_angle};
use codegen::tables::single::Fused;
use codegen::tables::{Firmware, Wanted};

use super::compiled::Sources;
use super::device::{COUNTS, Device, READINGS, Random, fitted};
use super::{Compared, devices, entry, fixtures, left, lines, table, worst, zero};

const FILE: &str = "calibration_lut.h";
/// Pole pairs of the motor that its own calibration turns.
const POLE_PAIRS: usize = 7;

/// The table as the source has it.
fn parsed(generated: &Generated) -> Vec<f32> {
    let rows = lines(generated, FILE, "//");
    let values = rows.iter().filter(|row| row.starts_with("    ")).flat_map(|row| row.split(','));
    let values = values.map(str::trim).filter(|value| !value.is_empty());
    values.map(|value| value.strip_suffix('f').unwrap().parse().unwrap()).collect()
}

/// All counts in turns.
fn results(lut: &[f32], counts: u32, fused: Fused) -> Vec<f64> {
    (0..counts).map(|count| f64::from(calibrated(lut, raw_angle(count, counts), fused)) / TAU).collect()
}

/// `calibrate` of the same version, on a motor that follows its field exactly: five places in every electrical turn, forward
/// and backward. Here each error is the mean of many readings, so that as many are used as in a calibration.
fn own_calibration(device: &Device, random: &mut Random, entries: usize) -> Vec<f32> {
    let (window, ticks) = (5, 5 * POLE_PAIRS);
    let repeated = READINGS / ticks;
    // It starts where the field stands at first: anywhere.
    let start = random.uniform();
    let first = device.reading(start, random);
    let wrapped = |turns: f64| turns - turns.round();
    let mut error = |tick: usize| {
        let moved = (tick + 1) as f64 / ticks as f64;
        let of = |_| wrapped(device.reading(start + moved, random) - first - moved);
        (0..repeated).map(of).sum::<f64>() / repeated as f64
    };
    let mut errors: Vec<f64> = (0..ticks).map(&mut error).collect();
    filter(&mut errors, window);
    let mean = errors.iter().sum::<f64>() / ticks as f64;
    let offset = (entries as f64 * first).floor() as usize;
    let mut lut = vec![0.0; entries];
    for index in 0..entries {
        let tick = (index as f64 * ticks as f64 / entries as f64) as usize;
        lut[(offset + index) % entries] = (TAU * (errors[tick] - mean)) as f32;
    }
    lut
}

/// `filter_error`: the moving average, written over what it averages.
fn filter(errors: &mut [f64], window: usize) {
    let ticks = errors.len();
    let mut buffer: Vec<f64> = (0..window).map(|i| errors[(ticks - window / 2 - 1 + i) % ticks]).collect();
    for tick in 0..ticks {
        buffer[tick % window] = errors[(tick + window / 2) % ticks];
        errors[tick] = buffer.iter().sum::<f64>() / window as f64;
    }
}

#[test]
fn every_count_is_within_the_bound_and_the_bound_within_a_tenth_of_the_worst() {
    for (device, mut random) in devices() {
        let counts = [4000, 4096, COUNTS, 65_536][(4.0 * random.uniform()) as usize];
        let entries = [None, Some(64), Some(128), Some(500)][(4.0 * random.uniform()) as usize];
        let file = device.coefficients();
        let wanted = Wanted { entries, ..Wanted::default() };
        let generated = table(Firmware::Simplefoc, &file, counts, wanted, None).unwrap();
        let lut = parsed(&generated);
        assert_eq!(lut.len(), entries.unwrap_or(200));
        let (bound, zero) = (entry(&generated).bound, zero(&generated));
        for fused in Fused::ALL {
            let found = worst(&file, &results(&lut, counts, fused), zero);
            assert!(found <= bound, "{counts} counts: {found} > {bound}");
            assert!(1.1 * found >= bound, "{counts} counts: {found}, and {bound} is claimed");
        }
    }
}

#[test]
fn its_own_calibration_leaves_more() {
    let mut compared = Compared::default();
    for (device, mut random) in devices() {
        let rows = device.calibration(&mut random);
        let generated = table(Firmware::Simplefoc, &fitted(&rows), COUNTS, Wanted::default(), None).unwrap();
        let of = |lut: &[f32]| left(&device, &results(lut, COUNTS, Fused::ALL[0]));
        compared.add(of(&parsed(&generated)), of(&own_calibration(&device, &mut random, 200)));
    }
    compared.print("SimpleFOC");
}

#[test]
fn the_firmwares_own_code_gives_the_same_bits() {
    let Some(sources) =
        Sources::of("Arduino-FOC-drivers", "https://github.com/simplefoc/Arduino-FOC-drivers")
    else {
        return;
    };
    let source = sources.read("src/encoders/calibrated/CalibratedSensor.cpp");
    let function = sources.function(&source, "float CalibratedSensor::getSensorAngle()");
    let device = Device::draw(&mut Random::new(7));
    let generated =
        table(Firmware::Simplefoc, &device.coefficients(), COUNTS, Wanted::default(), None).unwrap();
    let lut = parsed(&generated);
    // What the function needs of the library, and the generated file itself.
    let program = format!(
        "#include <cmath>\n#include <cstdint>\n#include <cstdio>\n#define _2PI 6.28318530718f\n{}\n\
         struct Wrapped {{ float angle; float getMechanicalAngle() {{ return angle; }} }};\n\
         struct CalibratedSensor {{ Wrapped _wrapped; int n_lut; float *calibrationLut; float getSensorAngle(); }};\n\
         {function}\nint main() {{ CalibratedSensor sensor{{{{0}}, {}, calibration_lut}};\n\
         for (uint32_t count = 0; count < {COUNTS}; count++) {{ sensor._wrapped.angle = count / (float){COUNTS} * _2PI;\n\
         std::printf(\"%a\\n\", sensor.getSensorAngle()); }} }}\n",
        generated.files[std::path::Path::new(FILE)],
        lut.len(),
    );
    let ours: Vec<f64> =
        (0..COUNTS).map(|c| calibrated(&lut, raw_angle(c, COUNTS), Fused::ALL[0]).into()).collect();
    assert_eq!(sources.run(&program), ours);
}

#[test]
fn what_it_cannot_hold_is_refused_in_one_message() {
    let usual = fixtures::encoder(360.0, 0.0, &[0.5, 0.0, 0.0, 0.0, 0.1, 0.0]);
    let refused = |file, entries, bound| {
        let wanted = Wanted { entries, ..Wanted::default() };
        table(Firmware::Simplefoc, file, COUNTS, wanted, bound).unwrap_err().to_string()
    };
    let said = refused(&usual, Some(11), None);
    assert_eq!(said, "11 entries for an error of 3 periods; give 12 to 4096, four for each period at least");
    let said = refused(&usual, Some(5000), None);
    assert!(said.starts_with("5000 entries for an error"), "{said}");
    let said = refused(&usual, Some(16), Some(1e-4));
    assert!(said.contains("the table of simplefoc (16 entries, float in radians) can reach"), "{said}");
    let mut linear = usual.clone();
    linear.turn = None;
    assert!(refused(&linear, None, None).starts_with("simplefoc corrects an encoder"));
}
