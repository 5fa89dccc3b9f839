//! What a recording of the paper's device must look like, seen from outside and against the truth.

use super::*;
use crate::angular_error::{AngularError, PAPER};
use crate::geometry::calculated_angle_rad;
use crate::log::{HEADER, write_csv};

fn calculated(x1: f64, x2: f64) -> f64 {
    calculated_angle_rad(x1, x2, 12.0)
}

fn calibration(seed: u64) -> Vec<(Reading, Truth)> {
    record_with_truth(&Device::from_seed(seed), &Protocol::calibration(), seed, &calculated)
}

fn bytes(log: &[Reading]) -> Vec<u8> {
    let mut out = Vec::new();
    write_csv(log, &mut out).unwrap();
    out
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt())
}

#[test]
fn every_device_errs_as_eq_12_in_pure_rotation() {
    let eq_6_rad = |s: f64| 12.0 / (s * s + 144.0) * PAPER.iter().rev().fold(0.0, |sum, a| sum * s + a);
    for seed in 0..50 {
        let device = Device::from_seed(seed);
        for i in -148..=148 {
            let true_angle = f64::from(i) * 1e-2f64.to_radians();
            let [x1, x2] = device.report_mm(true_angle, 0.0);
            let error = arcsec_from_rad(calculated(x1, x2) - true_angle);
            let wanted = arcsec_from_rad(eq_6_rad(x2 - x1));
            // 10⁻⁶″: only rounding may come between.
            approx::assert_abs_diff_eq!(error, wanted, epsilon = 1e-6);
        }
    }
}

#[test]
fn a_reading_scatters_by_half_an_arcsecond() {
    let paper = AngularError::paper();
    let mut all = Vec::new();
    for seed in 0..100 {
        let rows = calibration(seed);
        let residuals: Vec<f64> = rows
            .iter()
            .map(|(r, _)| r.reference_arcsec - arcsec_from_rad(paper.true_angle_rad(r.x2_mm - r.x1_mm)))
            .collect();
        let (zero, deviation) = moments(&residuals);
        // The mean of 210 readings at 0.5″ is α₀ to within 0.035″ (1σ).
        assert!((zero - rows[0].1.zero_arcsec).abs() < 0.2, "seed {seed}");
        assert!((0.4..0.6).contains(&deviation), "seed {seed}: {deviation}");
        all.extend(residuals.iter().map(|r| r - zero));
    }
    let (_, deviation) = moments(&all);
    // 21 000 readings: the standard error of the deviation is 0.0025″.
    approx::assert_abs_diff_eq!(deviation, 0.5, epsilon = 0.015);
}

#[test]
fn the_measured_angle_lands_on_the_command_and_the_true_one_deviates() {
    let paper = AngularError::paper();
    let mut deviations = Vec::new();
    for (reading, truth) in (0..20).flat_map(calibration) {
        let landed = arcsec_from_rad(calculated(reading.x1_mm, reading.x2_mm));
        // Five times the loop's 0.05″, and the resolution of the log.
        assert!((landed - 3600.0 * reading.command_deg).abs() < 0.26);
        let s = reading.x2_mm - reading.x1_mm;
        deviations.push(arcsec_from_rad(paper.true_angle_rad(s) - truth.true_angle_rad));
    }
    let (mean, deviation) = moments(&deviations);
    // √2 · 0.05 µm / 3 over 12 mm is 0.405″ of calculated angle; the device turns 0.80–0.86 as far.
    assert!(mean.abs() < 0.03, "{mean}");
    assert!((0.33..0.36).contains(&deviation), "{deviation}");
}

#[test]
fn the_true_angle_and_the_reading_stay_inside_the_autocollimators_range() {
    for seed in 0..50 {
        let range = Device::from_seed(seed).autocollimator.range_arcsec;
        for (reading, truth) in calibration(seed) {
            assert!(truth.true_angle_rad.abs() < 1.5f64.to_radians());
            assert!(reading.reference_arcsec.abs() < range);
        }
    }
}

/// ∂s/∂u without unit: how much of a small translation of the plate is mistaken for a difference, at the true angle in
/// radians.
fn leak(device: &Device, true_angle_rad: f64) -> f64 {
    // Central difference; 10⁻⁴ mm is a large translation and small against any curvature.
    let step = 1e-4;
    let s = |translation_mm| {
        let [x1, x2] = device.report_mm(true_angle_rad, translation_mm);
        x2 - x1
    };
    (s(step) - s(-step)) / (2.0 * step)
}

#[test]
fn translation_leaks_far_less_than_the_noise() {
    let mut largest = 0f64;
    for seed in 0..50 {
        let device = Device::from_seed(seed);
        let leaks: Vec<f64> = calibration(seed)
            .iter()
            .map(|(_, truth)| {
                arcsec_from_rad(leak(&device, truth.true_angle_rad) * truth.pose.translation_mm / 12.0)
            })
            .collect();
        let rms = (leaks.iter().map(|l| l * l).sum::<f64>() / leaks.len() as f64).sqrt();
        // It is there, and small: an ideal pair would have none.
        assert!(rms > 1e-4, "seed {seed}: {rms}");
        largest = largest.max(rms);
    }
    assert!(largest < 0.1, "{largest}");
}

#[test]
fn matched_probes_leak_nothing() {
    let device = Device::from_seed(3);
    for angle in [-0.024, -0.01, 0.003, 0.02] {
        let fifth = leak(&device.with_mismatch(0.2), angle);
        approx::assert_relative_eq!(fifth, 0.2 * leak(&device, angle), max_relative = 0.02);
        assert!(leak(&device.with_mismatch(0.0), angle).abs() < 1e-6);
    }
}

#[test]
fn verification_stays_inside_what_calibration_covered() {
    let paper = AngularError::paper();
    for seed in 0..20 {
        let device = Device::from_seed(seed);
        let covered = calibration(seed);
        let s = |r: &Reading| r.x2_mm - r.x1_mm;
        let low = covered.iter().map(|(r, _)| s(r)).fold(f64::INFINITY, f64::min);
        let high = covered.iter().map(|(r, _)| s(r)).fold(f64::NEG_INFINITY, f64::max);
        let corrected = |x1: f64, x2: f64| paper.true_angle_rad(x2 - x1);
        for feedback in [&calculated as &dyn Fn(f64, f64) -> f64, &corrected] {
            let log = record(&device, &Protocol::verification(), seed + 1000, feedback);
            assert_eq!(log.len(), 90);
            for r in &log {
                assert!((low..=high).contains(&s(r)), "{r:?}");
                let landed = arcsec_from_rad(feedback(r.x1_mm, r.x2_mm));
                assert!((landed - 3600.0 * r.command_deg).abs() < 0.26);
            }
        }
    }
}

#[test]
fn a_log_has_the_columns_passes_and_slow_channels_of_a_real_one() {
    let log: Vec<Reading> = calibration(1).into_iter().map(|(r, _)| r).collect();
    let text = String::from_utf8(bytes(&log)).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEADER));
    assert_eq!(lines.clone().count(), 210);
    for (line, r) in lines.zip(&log) {
        let fields: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
        let row = [
            r.t_s,
            f64::from(r.pass),
            f64::from(r.direction),
            r.command_deg,
            r.x1_mm,
            r.x2_mm,
            r.reference_arcsec,
            r.cross_arcsec,
            r.temperature_c,
            r.coil_a,
        ];
        // The values that the library hands out are those that the file gives back, to the bit.
        assert_eq!(fields, row);
        assert!((25.9..28.1).contains(&r.temperature_c));
    }
    for pass in 1..=6 {
        let rows: Vec<&Reading> = log.iter().filter(|r| r.pass == pass).collect();
        assert_eq!(rows.len(), 35);
        let direction = if pass % 2 == 1 { 1 } else { -1 };
        for pair in rows.windows(2) {
            assert_eq!(pair[0].direction, direction);
            assert!((f64::from(direction) * (pair[1].command_deg - pair[0].command_deg) - 0.1).abs() < 1e-9);
            assert!(pair[1].t_s > pair[0].t_s);
        }
    }
}

#[test]
fn the_second_axis_stays_below_ten_arcseconds_from_edge_to_edge() {
    for seed in 0..50 {
        for pass in calibration(seed).chunks(35) {
            let cross = pass.iter().map(|(r, _)| r.cross_arcsec);
            let span = cross.clone().fold(f64::NEG_INFINITY, f64::max) - cross.fold(f64::INFINITY, f64::min);
            assert!(span < 10.0, "seed {seed}: {span}");
        }
    }
}

#[test]
fn one_seed_is_one_recording_and_another_is_another() {
    let log = |device, seed| {
        bytes(&record(&Device::from_seed(device), &Protocol::calibration(), seed, &calculated))
    };
    assert_eq!(log(7, 7), log(7, 7));
    assert_ne!(log(7, 7), log(8, 7));
    assert_ne!(log(7, 7), log(7, 8));
    assert_ne!(Device::from_seed(7), Device::from_seed(8));
}
