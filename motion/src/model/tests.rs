//! The integrator against solutions in closed form.

use super::*;

fn model(damping: f64, stiffness: f64, gain: f64, hold: Hold, effects: &[(&str, &[(&str, f64)])]) -> Model {
    let effects = effects.iter().map(|(id, parameters)| PlantEffect::new(id, parameters)).collect();
    let context = Context { feedback: false };
    Model { damping, stiffness, gains: vec![gain], effects, hold, context }.check().unwrap()
}

/// Step of a damped oscillator: x = g/k (1 − e^(−ζωt)(cos ω_d t + ζω/ω_d sin ω_d t)).
#[test]
fn a_step_rings_as_it_must() {
    let (w, zeta, gain): (f64, f64, f64) = (200.0, 0.1, 4e8);
    let model = model(2.0 * zeta * w, w * w, gain, Hold::ZeroOrder, &[]);
    let sample_s = 5e-4;
    let got = model.simulate(&[vec![0.05; 2000]], sample_s, REST).unwrap();
    let damped = w * (1.0 - zeta * zeta).sqrt();
    for (index, x) in got.iter().enumerate() {
        let t = index as f64 * sample_s;
        let ring = (damped * t).cos() + zeta * w / damped * (damped * t).sin();
        let exact = gain * 0.05 / (w * w) * (1.0 - (-zeta * w * t).exp() * ring);
        // 10⁻⁹ of the motion per step, of which a ring remembers the last few dozen.
        assert!((x - exact).abs() < 1e-7 * 500.0, "{t}: {x} {exact}");
    }
}

#[test]
fn energy_stays_where_nothing_damps() {
    let cubic = 5e-4;
    let (w, from) = (150.0f64, 4000.0);
    let model = model(0.0, w * w, 1.0, Hold::ZeroOrder, &[("cubic_stiffness", &[("coefficient", cubic)])]);
    let sample_s = 1e-3;
    let start = Start::At { position: from, velocity: 0.0 };
    let x = model.simulate(&[vec![0.0; 20_000]], sample_s, start).unwrap();
    // 20 s are nearly 500 swings; every swing still reaches as far.
    let highest = |range: std::ops::Range<usize>| x[range].iter().fold(0.0f64, |m, x| m.max(x.abs()));
    assert!((highest(19_000..20_000) / highest(0..1000) - 1.0).abs() < 1e-3);
    assert!(highest(0..20_000) <= from * (1.0 + 1e-6));
}

/// Krylov and Bogoliubov: a spring k x + c x³ swings at ω² = k + ¾ c A², to first order in c A²/k.
#[test]
fn describing_function_of_a_cubic_spring() {
    let (k, from) = (4e4f64, 3000.0);
    let cubic = 0.01 * k / (from * from);
    let model = model(0.0, k, 1.0, Hold::ZeroOrder, &[("cubic_stiffness", &[("coefficient", cubic)])]);
    let sample_s = 5e-4;
    let start = Start::At { position: from, velocity: 0.0 };
    let x = model.simulate(&[vec![0.0; 20_000]], sample_s, start).unwrap();
    let crossings: Vec<f64> = x
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] < 0.0 && pair[1] >= 0.0)
        .map(|(index, pair)| sample_s * (index as f64 + pair[0] / (pair[0] - pair[1])))
        .collect();
    let period_s = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    let omega = std::f64::consts::TAU / period_s;
    let expected = (k + 0.75 * cubic * from * from).sqrt();
    // The next order is 3/256 · (c A²/k)² ≈ 10⁻⁶.
    assert!((omega / expected - 1.0).abs() < 5e-6, "{omega} {expected}");
}

/// Free swinging with dry friction: every half swing loses 2F/k, and it ends within ±F/k.
#[test]
fn dry_friction_takes_its_part_of_every_half_swing() {
    let (k, level) = (4e4f64, 4e6);
    let model = model(0.0, k, 1.0, Hold::ZeroOrder, &[("coulomb_friction", &[("force_per_inertia", level)])]);
    let sample_s = 1e-4;
    let start = Start::At { position: 950.0, velocity: 0.0 };
    let x = model.simulate(&[vec![0.0; 3000]], sample_s, start).unwrap();
    let half_s = std::f64::consts::PI / k.sqrt();
    // F/k = 100: turns at −750, 550, −350, 150, and there, 150 > 100, once more to −50 … where it stays.
    let turns = [-750.0, 550.0, -350.0, 150.0, 50.0];
    for (index, turn) in turns.iter().enumerate() {
        let row = ((index + 1) as f64 * half_s / sample_s).round() as usize;
        assert!((x[row] - turn).abs() < 0.5, "{index}: {} {turn}", x[row]);
    }
    assert!(x[2500..].iter().all(|x| (x - 50.0).abs() < 1e-6), "{}", x[2999]);
}

/// Held by friction under a force that grows: it breaks away when the force exceeds what holds.
#[test]
fn friction_holds_until_the_force_exceeds_it() {
    let effects: &[(&str, &[(&str, f64)])] = &[(
        "stribeck_friction",
        &[("force_per_inertia", 10.0), ("extra_static", 5.0), ("stribeck_velocity", 0.1)],
    )];
    let model = model(1.0, 0.0, 1.0, Hold::FirstOrder, effects);
    let ramp: Vec<f64> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
    let x = model.simulate(&[ramp], 0.01, REST).unwrap();
    assert!(x[..=150].iter().all(|x| *x == 0.0), "{}", x[150]);
    assert!(x[155] > 0.0);
}

/// A band-limited drive that jumps swings 9 % too far between its samples: beyond what holds, though no sample is.
#[test]
fn a_drive_frees_between_its_samples() {
    let moved = |level: f64| {
        let effects: &[(&str, &[(&str, f64)])] = &[("coulomb_friction", &[("force_per_inertia", level)])];
        let drive: Vec<f64> = (0..200).map(|k| f64::from(k >= 100)).collect();
        let x = model(1.0, 0.0, 1.0, Hold::BandLimited, effects).simulate(&[drive], 0.01, REST).unwrap();
        x[199]
    };
    assert_eq!(moved(1.2), 0.0);
    // At most 0.04 of force for a third of a row.
    assert!(moved(1.05) > 1e-8, "{}", moved(1.05));
}

#[test]
fn a_delay_of_a_part_of_a_sample_shifts_the_motion() {
    let drive: Vec<f64> =
        (0..2000).map(|k| (0.1 * f64::from(k)).sin() + (0.037 * f64::from(k)).cos()).collect();
    let sample_s = 1e-3;
    let late = model(30.0, 1e4, 1e6, Hold::FirstOrder, &[("transport_delay", &[("delay_s", 2.5e-3)])]);
    let plain = model(30.0, 1e4, 1e6, Hold::FirstOrder, &[]);
    let fine: Vec<f64> = drive.windows(2).flat_map(|u| [u[0], 0.5 * (u[0] + u[1])]).collect();
    let late = late.simulate(std::slice::from_ref(&drive), sample_s, REST).unwrap();
    let plain = plain.simulate(&[fine], 0.5 * sample_s, REST).unwrap();
    // The starts differ: until the delay has passed the drive stands at its first value.
    for row in 1000..1900 {
        assert!((late[row] - plain[2 * row - 5]).abs() < 1e-3, "{row}");
    }
}

/// Two inertias: the transfer function at a frequency from the equations by hand.
#[test]
fn a_flexible_mode_has_its_transfer_function() {
    let (k, d, gain): (f64, f64, f64) = (3e4, 30.0, 1e6);
    let (frequency_hz, mass, zeta) = (60.0f64, 0.1, 0.02);
    let mode: &[(&str, &[(&str, f64)])] = &[(
        "flexible_mode",
        &[("frequency_hz", frequency_hz), ("mass_ratio", mass), ("damping_ratio", zeta)],
    )];
    let model = model(d, k, gain, Hold::BandLimited, mode);
    let omega = std::f64::consts::TAU * 50.0;
    let sample_s = 1e-3;
    let drive: Vec<f64> = (0..1000).map(|i| (omega * sample_s * f64::from(i)).sin()).collect();
    let x = model.simulate(&[drive], sample_s, Start::Steady { period: 1000 }).unwrap();
    let (mut sin, mut cos) = (0.0, 0.0);
    for (index, x) in x.iter().enumerate() {
        let angle = omega * sample_s * index as f64;
        sin += x * angle.sin() / 500.0;
        cos += x * angle.cos() / 500.0;
    }
    // (−ω² + iωd + k + μ P) x = g u, P = −ω² S/(S − ω²) with S = Ω² + 2iζΩω.
    let own = std::f64::consts::TAU * frequency_hz;
    let (s_re, s_im) = (own * own, 2.0 * zeta * own * omega);
    let (n_re, n_im) = (-omega * omega * s_re, -omega * omega * s_im);
    let (q_re, q_im) = (s_re - omega * omega, s_im);
    let q = q_re * q_re + q_im * q_im;
    let (p_re, p_im) = ((n_re * q_re + n_im * q_im) / q, (n_im * q_re - n_re * q_im) / q);
    let (re, im) = (k - omega * omega + mass * p_re, omega * d + mass * p_im);
    let size = re * re + im * im;
    let (want_sin, want_cos) = (gain * re / size, -gain * im / size);
    let total = (want_sin * want_sin + want_cos * want_cos).sqrt();
    assert!((sin - want_sin).abs() < 1e-3 * total && (cos - want_cos).abs() < 1e-3 * total);
}

#[test]
fn a_plant_that_runs_away_is_told() {
    let model = model(-50.0, 1e4, 1e6, Hold::ZeroOrder, &[]);
    let error = model.simulate(&[vec![1.0; 4000]], 1e-3, REST).unwrap_err().to_string();
    assert!(error.contains("unstable"), "{error}");
}

#[test]
fn the_start_of_a_recording_is_found() {
    let model = model(40.0, 4e4, 4e8, Hold::BandLimited, &[("cubic_stiffness", &[("coefficient", 1e-4)])]);
    let drive: Vec<f64> = (0..500).map(|k| 0.05 * (0.2 * f64::from(k)).sin()).collect();
    let start = Start::At { position: 800.0, velocity: -9e4 };
    let recorded = model.simulate(std::slice::from_ref(&drive), 5e-4, start).unwrap();
    let Start::At { position, velocity } = model.start_of(&[drive], 5e-4, &recorded, 50).unwrap() else {
        unreachable!()
    };
    assert!((position - 800.0).abs() < 0.01 && (velocity + 9e4).abs() < 1.0, "{position} {velocity}");
}

/// Rows far apart, of the plant or of what acts in it: refused before hours are spent.
#[test]
fn a_motion_that_takes_far_more_steps_than_rows_is_refused() {
    let plain = model(
        34.5,
        54_735.7,
        7.4e8,
        Hold::BandLimited,
        &[("coulomb_friction", &[("force_per_inertia", 6e5)])],
    );
    let drive: Vec<f64> = (0..2048).map(|k| 0.1 * (0.3 * f64::from(k)).sin()).collect();
    for error in [
        plain.simulate(std::slice::from_ref(&drive), 500.0, REST).unwrap_err(),
        plain.start_of(std::slice::from_ref(&drive), 500.0, &drive, 50).unwrap_err(),
    ] {
        assert!(error.to_string().contains("7.3e7 steps of integration for 1024000 s"), "{error}");
    }
    let fast = model(40.0, 4e4, 4e8, Hold::ZeroOrder, &[("sensor_lag", &[("time_constant_s", 1e-10)])]);
    let error = fast.simulate(&[drive], 5e-4, REST).unwrap_err().to_string();
    assert!(error.contains("steps of integration for 1.024 s of rows 0.0005 s apart"), "{error}");
}
