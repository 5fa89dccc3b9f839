//! Every effect of the table: what it adds is the table's formula of the recorded columns, for several
//! devices. What the formula and the physics may differ by is stated at each.

use super::*;
use crate::temperature::Temperature;

fn chamber() -> Protocol {
    Protocol { temperature: Temperature::chamber(), ..Protocol::calibration() }
}

/// `difference` bounds the relative difference, in the root mean square and in the parameter.
fn is_the_formula(case: &Case, formula: &[f64], order: usize, difference: f64) {
    let (apart, factor) = case.compare(formula, order);
    assert!(apart < difference, "the formula is missed by {apart}");
    assert!((factor - 1.0).abs() < difference, "the parameter is missed by {factor}");
}

#[test]
fn thermal_zero_drift() {
    for seed in 0..5 {
        let effect = Injected::new("thermal_zero_drift", [("coefficient_arcsec_per_k", 0.3)]);
        let case = Case::new(&effect, &chamber(), seed);
        // The log prints the temperature to 0.001 K.
        is_the_formula(&case, &case.formula(|r| 0.3 * r.temperature_c), 0, 2e-4);
    }
}

#[test]
fn thermal_gain_drift() {
    for seed in 0..5 {
        let effect = Injected::new("thermal_gain_drift", [("coefficient_ppm_per_k", -40.0)]);
        let case = Case::new(&effect, &chamber(), seed);
        let mean = case.rows.iter().map(|(r, _)| r.temperature_c).sum::<f64>() / case.rows.len() as f64;
        let formula = case.formula(|r| -40e-6 * theta_arcsec(r) * (r.temperature_c - mean));
        // True and calculated angle are proportional to 1.5 %.
        is_the_formula(&case, &formula, 9, 0.02);
    }
}

#[test]
fn thermal_lag() {
    for seed in 0..5 {
        let effect =
            Injected::new("thermal_lag", [("coefficient_arcsec_per_k", 0.3), ("time_constant_s", 90.0)]);
        let case = Case::new(&effect, &chamber(), seed);
        // Integrated in small steps along straight lines between the rows, from equilibrium in the first.
        let mut lagging = case.rows[0].0.temperature_c;
        let mut formula = vec![0.3 * lagging];
        for pair in case.rows.windows(2) {
            let (a, b) = (&pair[0].0, &pair[1].0);
            let steps = 200;
            for i in 0..steps {
                let part = (f64::from(i) + 0.5) / f64::from(steps);
                let base = a.temperature_c + part * (b.temperature_c - a.temperature_c);
                lagging += (base - lagging) * (b.t_s - a.t_s) / f64::from(steps) / 90.0;
            }
            formula.push(0.3 * lagging);
        }
        is_the_formula(&case, &formula, 0, 1e-3);
    }
}

#[test]
fn time_drift() {
    let case = Case::new(&"time_drift:rate_arcsec_per_h=-7".parse().unwrap(), &Protocol::coarse(), 3);
    is_the_formula(&case, &case.formula(|r| -7.0 * r.t_s / 3600.0), 0, 1e-4);
}

#[test]
fn warmup_drift() {
    let effect = "warmup_drift:amplitude_arcsec=4,time_constant_s=150".parse().unwrap();
    let case = Case::new(&effect, &Protocol::calibration(), 3);
    is_the_formula(&case, &case.formula(|r| 4.0 * (1.0 - (-r.t_s / 150.0).exp())), 0, 1e-4);
}

#[test]
fn mount_step() {
    let effect = "mount_step:step_arcsec=2.5,time_s=400".parse().unwrap();
    let case = Case::new(&effect, &Protocol::calibration(), 3);
    is_the_formula(&case, &case.formula(|r| if r.t_s >= 400.0 { 2.5 } else { 0.0 }), 0, 1e-6);
}

#[test]
fn backlash() {
    for seed in 0..5 {
        let effect = Injected::new("backlash", [("half_width_arcsec", 1.5)]);
        let case = Case::new(&effect, &Protocol::calibration(), seed);
        let mut output: f64 = 0.0;
        let formula = case.formula(theta_arcsec).into_iter().map(|theta| {
            output = output.clamp(theta - 1.5, theta + 1.5);
            theta - output
        });
        let formula: Vec<f64> = formula.collect();
        // Where the passes turn, the mirror creeps by what the loop leaves, 0.05″ of calculated angle.
        for (added, wanted) in case.added.iter().zip(&formula) {
            assert!((added - wanted).abs() < 0.1, "{added} in place of {wanted}");
        }
        // It is forward that the mirror stays behind the probes.
        for ((r, _), added) in case.rows.iter().zip(&case.added) {
            if r.command_deg.abs() < 1.65 {
                assert!((added - 1.5 * f64::from(r.direction)).abs() < 1e-3);
            }
        }
    }
}

#[test]
fn hysteresis() {
    for (seed, skew) in [(0, 0.0), (1, 0.0), (2, 1.0), (3, -0.5)] {
        let effect = Injected::new("hysteresis", [("half_height_arcsec", 2.0), ("skew", skew)]);
        let case = Case::new(&effect, &Protocol::fine(), seed);
        // The way from rest to the first angle already turns every element over.
        let left = case.beyond(&case.added, 9);
        let height = left.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        approx::assert_abs_diff_eq!(height, 2.0, epsilon = 0.04);
        for ((r, _), left) in case.rows.iter().zip(&left) {
            if r.command_deg.abs() < 1.0 {
                assert!(left * f64::from(r.direction) > 0.5, "{left} at {}", r.command_deg);
            }
        }
    }
}

#[test]
fn periodic_error() {
    for harmonics in [1, 3] {
        let text = format!(
            "periodic_error:amplitude_arcsec=3,period_arcsec=1100,phase_deg=30,harmonics={harmonics}"
        );
        let case = Case::new(&text.parse().unwrap(), &Protocol::calibration(), 4);
        let wave = |truth: &Truth| -> f64 {
            let turn =
                std::f64::consts::TAU * arcsec_from_rad(truth.true_angle_rad) / 1100.0 + 30f64.to_radians();
            (1..=harmonics)
                .map(f64::from)
                .map(|n| 3.0 / 3f64.powf(n - 1.0) * (n * turn + n - 1.0).sin())
                .sum()
        };
        let formula: Vec<f64> = case.rows.iter().map(|(_, truth)| wave(truth)).collect();
        is_the_formula(&case, &formula, 0, 1e-5);
        // In the calculated angle it is no sine: the error shifts the place where it is read.
        let explicit = case.formula(|r| (std::f64::consts::TAU * theta_arcsec(r) / 1100.0).sin());
        assert!(case.compare(&explicit, 0).0 > 0.1);
    }
}

#[test]
fn common_mode_leakage() {
    for seed in 0..5 {
        let effect = Injected::new("common_mode_leakage", [("coefficient_arcsec_per_um", -2.0)]);
        let case = Case::new(&effect, &Protocol::calibration(), seed);
        // dΘ/ds varies by ±4 % over the stroke; the log prints 0.1 nm of a motion of 200 nm.
        let formula = case.formula(|r| -2.0 * 500.0 * (r.x1_mm + r.x2_mm));
        is_the_formula(&case, &formula, 9, 0.05);
    }
}

#[test]
fn cross_axis_coupling() {
    for seed in 0..5 {
        let effect = Injected::new("cross_axis_coupling", [("coefficient_arcsec_per_arcsec", 0.8)]);
        let case = Case::new(&effect, &Protocol::calibration(), seed);
        // The log prints 0.001″.
        is_the_formula(&case, &case.formula(|r| 0.8 * r.cross_arcsec), 0, 2e-3);
    }
}

#[test]
fn coil_crosstalk() {
    for seed in 0..5 {
        let effect = Injected::new("coil_crosstalk", [("coefficient_arcsec_per_a", 200.0)]);
        let case = Case::new(&effect, &Protocol::calibration(), seed);
        // dΘ/ds varies by ±4 % over the stroke.
        is_the_formula(&case, &case.formula(|r| 200.0 * r.coil_a), 9, 0.05);
    }
}

#[test]
fn sensor_clipping() {
    for (seed, threshold) in [(0, 1.2), (1, -1.1), (2, 0.9), (3, -1.32)] {
        let values = [("threshold_deg", threshold), ("slope_arcsec_per_deg", -40.0)];
        let case = Case::new(&Injected::new("sensor_clipping", values), &Protocol::fine(), seed);
        let side = f64::signum(threshold);
        let formula = case.formula(|r| {
            let beyond = side * (theta_arcsec(r) / 3600.0 - threshold);
            -40.0 * side * beyond.max(0.0)
        });
        // The slope of the characteristic varies by 3 % from the threshold to the end.
        is_the_formula(&case, &formula, 0, 0.04);
    }
}

#[test]
fn read_lag() {
    let effect = Injected::new("read_lag", [("delay_s", 0.004)]);
    let case = Case::new(&effect, &Protocol::scan(), 3);
    let speed = |pass: u32| [0.1, 0.25, 0.5][((pass - 1) as usize % 6) / 2];
    let formula = case.formula(|r| 0.004 * 3600.0 * f64::from(r.direction) * speed(r.pass));
    // dΘ/dθ varies by ±4 % over the stroke.
    is_the_formula(&case, &formula, 0, 0.05);
    // A mirror that has settled knows no delay.
    let still = Case::new(&effect, &Protocol::calibration(), 3);
    assert!(rms(&still.added) < 1e-6);
}

#[test]
fn local_defect() {
    for (seed, height, centre) in [(0, 6.0, 0.4), (1, -10.0, -1.1), (2, 3.0, 0.0)] {
        let values = [("height_arcsec", height), ("centre_deg", centre), ("width_deg", 0.1)];
        let case = Case::new(&Injected::new("local_defect", values), &Protocol::fine(), seed);
        let formula =
            case.formula(|r| height * (-0.5 * ((theta_arcsec(r) / 3600.0 - centre) / 0.1).powi(2)).exp());
        // The flaw lies on the pad: where it adds to the reading, it is read at a place shifted by itself,
        // by up to 0.6 · 10″ / 0.1° of its height.
        is_the_formula(&case, &formula, 0, 0.04);
    }
}
