//! `apply` and the terms: what every operator adds, where it is left out, and that files survive.

use crate::common;

use common::{D_MM, Device, arcsec, direct, mirror, normal};
use fitter::terms::{
    Element, Exponential, Factor, Gaussian, Hinge, Lag, Operator, Periodic, Play, Product, Rate, Scope, Side,
    Step, Term,
};
use fitter::{
    ApplyNote, Coefficients, ErrorModel, Options, Recording, apply, apply_screened, coefficients, fit,
};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn term(effect: &str, scope: Scope, operator: Operator, coefficients: &[f64]) -> Term {
    Term {
        effect: effect.to_string(),
        scope,
        operator,
        coefficients: coefficients.to_vec(),
        covariance: vec![],
    }
}

/// A perfect pair (Δθ = 0) over ±1.7°.
fn perfect_pair() -> Coefficients {
    let model = ErrorModel { sensor: mirror().sensor, centre: 0.0, coefficients: vec![0.0, 0.0] };
    Coefficients::of_model(&model, -0.36, 0.36, "test")
}

fn with_terms(mut file: Coefficients, terms: Vec<Term>) -> Coefficients {
    file.terms = terms;
    let text = file.to_json();
    let back = coefficients::parse("test.json", &text).unwrap();
    assert_eq!(back, file);
    back
}

fn recording(rows: &[&str]) -> Recording {
    let text = format!(
        "t_s,pass,direction,x1_mm,x2_mm,reference_arcsec,temperature_c,coil_a\n{}\n",
        rows.join("\n")
    );
    Recording::from_bytes("r.csv", text.as_bytes()).unwrap()
}

/// What the terms take off the angle, in arcsec, row by row.
fn taken_off(file: &Coefficients, recording: &Recording) -> Vec<f64> {
    let applied = apply(recording, file).unwrap();
    let angle = |row: usize| arcsec((recording.reading(row) / D_MM).atan());
    (0..recording.rows()).map(|row| angle(row) - arcsec(applied.corrected[row])).collect()
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-9);
    }
}

#[test]
fn every_operator_adds_what_its_file_says() {
    // s = 0, 0.12, 0.24, 0.12 mm at t = 0, 10, 20, 30 s.
    let recording = recording(&[
        "0,0,1,0,0,0,20,0.5",
        "10,0,1,-0.06,0.06,2062.6,30,1",
        "20,0,1,-0.12,0.12,4125.1,30,1.5",
        "30,1,-1,-0.06,0.06,2062.6,20,2",
    ]);
    let theta: Vec<f64> = (0..4).map(|row| arcsec((recording.reading(row) / D_MM).atan())).collect();
    let check = |operator: Operator, coefficients: &[f64], expected: &[f64]| {
        let file = with_terms(perfect_pair(), vec![term("effect", Scope::Device, operator, coefficients)]);
        assert_near(&taken_off(&file, &recording), expected);
    };
    check(Operator::Product(Product::of("temperature_c", 25.0)), &[0.2], &[-1.0, 1.0, 1.0, -1.0]);
    let gain = Product::of("temperature_c", 25.0).times("angle_arcsec", 0.0, 1);
    check(Operator::Product(gain), &[1e-5], &[0.0, 5e-5 * theta[1], 5e-5 * theta[2], -5e-5 * theta[3]]);
    let square = Product { factors: vec![Factor { observable: "coil_a".into(), mean: 1.0, power: 2 }] };
    check(Operator::Product(square), &[4.0], &[1.0, 0.0, 1.0, 4.0]);
    let power = Product::of("s_mm", 0.0).times("s_mm", 0.0, 2);
    check(Operator::Product(power), &[1000.0], &[0.0, 1.728, 13.824, 1.728]);
    let r = 500.0;
    let slack = theta[3] - (theta[2] - r);
    check(Operator::Play(Play::of("angle_arcsec", &[r])), &[1.0], &[0.0, r, r, slack.max(-r)]);
    let started =
        Play { observable: "coil_a".into(), elements: vec![Element { half_width: 0.2, initial: Some(0.6) }] };
    check(Operator::Play(started), &[10.0], &[-1.0, 2.0, 2.0, 2.0]);
    let lag = Operator::Lag(Lag::of("temperature_c", 10.0, 20.0));
    let e = (-1.0f64).exp();
    let (one, two) = (10.0 * e, 10.0 * (1.0 - e + e * e));
    check(lag, &[1.0], &[0.0, one, two, e * two + (1.0 - e) * 10.0 - 10.0 * e]);
    let warm = 1.0 - (-0.5f64).exp();
    check(
        Operator::Exponential(Exponential { observable: "t_s".into(), start: 0.0, scale: 20.0 }),
        &[3.0],
        &[0.0, 3.0 * warm, 3.0 * (1.0 - e), 3.0 * (1.0 - (-1.5f64).exp())],
    );
    check(Operator::Step(Step { observable: "t_s".into(), at: 10.0 }), &[2.0], &[0.0, 2.0, 2.0, 2.0]);
    let degrees = theta[1] / 3600.0;
    let bump = Gaussian::of("angle_deg", degrees, 0.1);
    let side = |row: usize| 5.0 * (-0.5 * ((theta[row] / 3600.0 - degrees) / 0.1).powi(2)).exp();
    check(Operator::Gaussian(bump), &[5.0], &[side(0), 5.0, side(2), 5.0]);
    let above = Hinge::of("temperature_c", 22.0, Side::Above);
    check(Operator::Hinge(above), &[0.5], &[0.0, 4.0, 4.0, 0.0]);
    let below = Hinge::of("temperature_c", 22.0, Side::Below);
    check(Operator::Hinge(below), &[0.5], &[1.0, 0.0, 0.0, 1.0]);
    // The first row takes the difference to the next; the last is a pass of its own.
    check(Operator::Rate(Rate::of("coil_a")), &[20.0], &[1.0, 1.0, 1.0, 0.0]);
}

#[test]
fn the_periodic_term_is_one_of_the_true_angle() {
    let (period, coefficients) = (900.0, [20.0, -35.0]);
    let periodic = Periodic::of(period, 1);
    let truth: Vec<f64> = (0..50).map(|i| -3000.0 + 117.3 * f64::from(i)).collect();
    let rows: Vec<String> = (truth.iter().enumerate())
        .map(|(i, truth)| {
            let measured = truth + periodic.value_and_slope(&coefficients, *truth).0;
            let s = D_MM * (measured / arcsec(1.0)).tan();
            format!("{i},0,1,{:.17},{:.17},0,20,1", -s / 2.0, s / 2.0)
        })
        .collect();
    let recording = recording(&rows.iter().map(String::as_str).collect::<Vec<_>>());
    let terms = vec![term("periodic_error", Scope::Device, Operator::Periodic(periodic), &coefficients)];
    let applied = apply(&recording, &with_terms(perfect_pair(), terms)).unwrap();
    for (corrected, truth) in applied.corrected.iter().zip(truth) {
        approx::assert_abs_diff_eq!(arcsec(*corrected), truth, epsilon = 1e-8);
    }
}

#[test]
fn terms_that_cannot_be_applied_are_left_out_and_named() {
    let product = |name: &str| Operator::Product(Product::of(name, 25.0));
    let terms = vec![
        term("thermal_zero_drift", Scope::Device, product("temperature_c"), &[1.0]),
        term("cross_axis_coupling", Scope::Device, product("cross_arcsec"), &[1.0]),
        term(
            "mount_step",
            Scope::Recording,
            Operator::Step(Step { observable: "t_s".into(), at: -1.0 }),
            &[7.0],
        ),
    ];
    let mut file = with_terms(perfect_pair(), terms);
    let recording = recording(&["0,0,1,0,0,0,26,1", "1,0,1,-0.01,0.01,0,,1"]);
    let applied = apply(&recording, &file).unwrap();
    assert!(applied.notes.contains(&ApplyNote::MissingColumn {
        effect: "cross_axis_coupling".into(),
        column: "cross_arcsec".into()
    }));
    assert!(applied.notes.contains(&ApplyNote::OtherRecording { effect: "mount_step".into() }));
    assert!(applied.notes.contains(&ApplyNote::Blank { effect: "thermal_zero_drift".into(), rows: 1 }));
    assert_near(&taken_off(&file, &recording), &[1.0, 0.0]);
    // On the recording that it was found in the step counts.
    file.recording.sha256 = recording.sha256.clone();
    assert_near(&taken_off(&file, &recording), &[8.0, 7.0]);
}

#[test]
fn outside_the_range_only_what_extrapolates_is_used() {
    let model =
        ErrorModel { sensor: direct("mm").sensor, centre: 5.0, coefficients: vec![0.1, 0.01, 0.0, 0.002] };
    let terms = vec![
        term("local_defect", Scope::Device, Operator::Gaussian(Gaussian::of("measured", 30.0, 1.0)), &[9.0]),
        term(
            "sensor_clipping",
            Scope::Device,
            Operator::Hinge(Hinge::of("measured", 9.0, Side::Above)),
            &[9.0],
        ),
        term("time_drift", Scope::Device, Operator::Product(Product::of("t_s", 0.0)), &[0.5]),
        term("periodic_error", Scope::Device, Operator::Periodic(Periodic::of(0.25, 1)), &[0.01, 0.0]),
    ];
    let file = with_terms(Coefficients::of_model(&model, 0.0, 10.0, "test"), terms);
    let text = "t_s,measured\n0,5\n2,30\n";
    let path = tempfile::tempdir().unwrap();
    let name = path.path().join("use.csv");
    std::fs::write(&name, text).unwrap();
    let recording = Recording::read_for(&name, fitter::recording::Purpose::Apply, &mut |_| {}).unwrap();
    let applied = apply(&recording, &file).unwrap();
    assert_eq!(applied.extrapolated, [false, true]);
    assert!(applied.notes.iter().any(|note| note.to_string().contains("1 of 2 rows lie outside")));
    // From the end of 0.1 + 0.01 x + 0.002 x³ over |x| ≤ 5 with the slope of its least-squares line: 0.01 + 0.002·(3/5)·25.
    let line = 0.1 + 0.05 + 0.25 + (0.01 + 0.03) * 20.0;
    let observed = 30.0 - line - 0.5 * 2.0;
    let truth = applied.corrected[1];
    approx::assert_abs_diff_eq!(
        truth + 0.01 * (std::f64::consts::TAU * truth / 0.25).cos(),
        observed,
        epsilon = 1e-12
    );
}

/// The slit axis of a beam line: a polynomial of the resolver's error says nothing 24 mm away, a line does.
/// Play, a lag and a rate remember: a cell that cannot be a reading must not be remembered.
#[test]
fn no_row_depends_on_a_cell_that_cannot_be_a_reading() {
    let line = |row: usize, x2: &str, temperature: &str| {
        let s = 0.3 * (f64::from(row as u32) / 9.0).sin();
        let x2 = if x2.is_empty() { format!("{:.7}", 0.5 * s) } else { x2.to_string() };
        let temperature = if temperature.is_empty() {
            format!("{:.3}", 20.0 + 0.05 * row as f64)
        } else {
            temperature.into()
        };
        let wobble = 1e-3 * ((row * 7919) % 11) as f64;
        format!("{row},0,1,{:.7},{x2},{:.4},{temperature},0.5", -0.5 * s, arcsec((s / D_MM).atan()) + wobble)
    };
    let of = |bad: &[(usize, &str, &str)]| {
        let lines: Vec<String> = (0..80)
            .map(|row| {
                let bad = bad.iter().find(|bad| bad.0 == row);
                bad.map_or_else(|| line(row, "", ""), |(_, x2, temperature)| line(row, x2, temperature))
            })
            .collect();
        recording(&lines.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let terms = vec![
        term("backlash", Scope::Device, Operator::Play(Play::of("angle_arcsec", &[40.0])), &[0.5]),
        term("thermal_lag", Scope::Device, Operator::Lag(Lag::of("temperature_c", 5.0, 20.0)), &[2.0]),
        term("read_lag", Scope::Device, Operator::Rate(Rate::of("angle_arcsec")), &[0.1]),
        // Of the angle alone: the row of a cell of another column has its own, far from that of the row before.
        term(
            "sensor_clipping",
            Scope::Device,
            Operator::Hinge(Hinge::of("angle_arcsec", -5000.0, Side::Above)),
            &[0.3],
        ),
    ];
    let file = with_terms(perfect_pair(), terms);
    let whole = apply(&of(&[]), &file).unwrap();
    let damaged = of(&[(20, "9999", ""), (50, "", "-9999")]);
    let screened = apply_screened(&damaged, &file).unwrap();
    let told: Vec<(u64, &str)> =
        screened.bad_rows.iter().map(|bad| (bad.line, bad.column.as_str())).collect();
    assert_eq!(told, [(22, "x2_mm"), (52, "temperature_c")]);
    assert!(matches!(screened.notes.as_slice(), [ApplyNote::Bad { rows: 2, .. }]), "{:?}", screened.notes);
    for row in 0..80 {
        assert_eq!(screened.extrapolated[row], row == 20 || row == 50, "{row}");
        let away = arcsec(screened.corrected[row] - whole.corrected[row]).abs();
        // The row after has the rate and the lag of two steps in place of one; a cell of another column takes nothing
        // from the correction of its own row but what the row before had.
        let allowed = if row == 20 { f64::INFINITY } else { 10.0 };
        assert!(away < allowed, "{row}: {away}");
        assert!(row <= 21 || row == 50 || row == 51 || away < 0.1, "{row}: {away}");
    }
    // Taken as they are, the cells are remembered.
    let taken = apply(&of(&[(50, "", "-9999")]), &file).unwrap();
    assert!(arcsec(taken.corrected[51] - whole.corrected[51]).abs() > 100.0);
}

#[test]
fn a_real_sensor_outside_its_range() {
    let Some(folder) = std::env::var_os("ARCSMITH_RECORDINGS") else {
        println!("skipped: ARCSMITH_RECORDINGS is unset (slit-train, slit-test: a beam-line slit axis, ESS)");
        return;
    };
    let folder = std::path::PathBuf::from(folder);
    let train = Recording::read(&folder.join("slit-train.csv.gz")).unwrap();
    let test = Recording::read(&folder.join("slit-test.csv.gz")).unwrap();
    let mirror = fitter::Mirror::read(&folder.join("slit.toml")).unwrap();
    let fit = fit(&train, &mirror, &Options::default()).unwrap();
    assert!(fit.dependences.iter().any(|found| found.variable == "angle"));
    let applied = apply(&test, &fit.coefficients).unwrap();
    assert!(applied.extrapolated.iter().all(|outside| *outside));
    let error: Vec<f64> =
        (0..test.rows()).map(|row| applied.corrected[row] - test.reference(row).unwrap()).collect();
    let mean = error.iter().sum::<f64>() / error.len() as f64;
    let rms_um = 1e3 * (error.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / error.len() as f64).sqrt();
    println!("slit-test, offset removed: {rms_um:.2} µm");
    assert!((14.0..16.0).contains(&rms_um), "{rms_um} µm");
}

#[test]
fn a_term_that_contradicts_itself_is_refused() {
    let refused = |operator: Operator, coefficients: &[f64]| {
        let mut file = perfect_pair();
        file.terms = vec![term("effect", Scope::Device, operator, coefficients)];
        coefficients::parse("bad.json", &file.to_json()).unwrap_err().to_string()
    };
    let step = || Operator::Step(Step { observable: "t_s".into(), at: 1.0 });
    assert!(refused(step(), &[1.0, 2.0]).contains("1 columns has 2 coefficients"));
    assert!(refused(Operator::Periodic(Periodic::of(1.0, 1)), &[1.0, 0.0]).contains("no inverse"));
    assert!(refused(Operator::Lag(Lag::of("t_s", -1.0, 0.0)), &[1.0]).contains("time_constant_s"));
    assert!(refused(Operator::Play(Play::of("s_mm", &[])), &[]).contains("0 columns"));
}

fn any_operator() -> impl Strategy<Value = (Operator, usize)> {
    let name = prop::sample::select(vec!["temperature_c", "coil_a", "s_mm", "t_s"]);
    let number = -1e3..1e3f64;
    let positive = 1e-3..1e3f64;
    (name, number, positive, 0..9usize, 1..4u8).prop_map(|(name, number, positive, kind, count)| {
        let wide = usize::from(count);
        match kind {
            0 => (Operator::Product(Product::of(name, number).times("s_mm", 0.0, count)), 1),
            1 => (Operator::Play(Play::of(name, &vec![positive; wide])), wide),
            2 => (Operator::Lag(Lag { initial: Some(number), ..Lag::of(name, positive, number) }), 1),
            3 => (
                Operator::Exponential(Exponential {
                    observable: name.into(),
                    start: number,
                    scale: positive,
                }),
                1,
            ),
            4 => (Operator::Step(Step { observable: name.into(), at: number }), 1),
            5 => (Operator::Periodic(Periodic::of(1e6 * positive, u16::from(count))), 2 * wide),
            6 => (Operator::Gaussian(Gaussian::of(name, number, positive)), 1),
            7 => (Operator::Hinge(Hinge::of(name, number, Side::Below)), 1),
            _ => (Operator::Rate(Rate::of(name)), 1),
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Any file comes back from its text with every bit, and applying it gives finite angles.
    #[test]
    fn files_survive_a_round_trip(
        coefficients in prop::collection::vec(prop::num::f64::NORMAL.prop_map(|x| x % 10.0), 2..=16),
        operators in prop::collection::vec((any_operator(), prop::collection::vec(-1.0..1.0f64, 8)), 0..4),
        (from, width) in (-1.0..0.0f64, 0.1..2.0f64),
        seed in any::<u64>(),
    ) {
        let model = ErrorModel { sensor: mirror().sensor, centre: 0.0, coefficients };
        let mut file = Coefficients::of_model(&model, from, from + width, "arcsmith fit 'a b.csv' --out ü.json");
        for ((operator, width), values) in operators {
            let covariance = vec![vec![values[0]; width]; width];
            file.terms.push(Term {
                effect: "effect".into(),
                scope: Scope::Device,
                operator,
                coefficients: values[..width].to_vec(),
                covariance,
            });
        }
        let back = coefficients::parse("test.json", &file.to_json()).unwrap();
        prop_assert_eq!(&back, &file);
        prop_assert_eq!(back.to_json(), file.to_json());
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let rows: Vec<String> = (0..20)
            .map(|i| format!("{i},0,1,{},{},0,{},{}", -0.1 * normal(&mut random), 0.1, normal(&mut random), i))
            .collect();
        let recording = recording(&rows.iter().map(String::as_str).collect::<Vec<_>>());
        let applied = apply(&recording, &back).unwrap();
        prop_assert!(applied.corrected.iter().all(|angle| angle.is_finite()));
    }

    /// A damaged text is refused with a sentence, never a panic, and never read as something else.
    #[test]
    fn damaged_files_do_not_panic(cut in 0.0..1.0f64, byte in any::<u8>()) {
        let text = perfect_pair().to_json();
        let at = (cut * text.len() as f64) as usize;
        let mut bytes = text.clone().into_bytes();
        bytes[at] = byte;
        let damaged = String::from_utf8_lossy(&bytes).into_owned();
        if let Err(error) = coefficients::parse("test.json", &damaged) {
            prop_assert!(error.to_string().starts_with("test.json"));
        }
        prop_assert!(coefficients::parse("test.json", &text[..at.min(text.len() - 2)]).is_err());
    }

    /// Random devices without noise are given back by a fit of their order.
    #[test]
    fn a_fit_gives_back_a_device_without_noise(
        scaled in prop::collection::vec(-1.0..1.0f64, 2..=10),
        centre_deg in -0.5..0.5f64,
    ) {
        // Every power contributes up to 0.02 mm at the end of the range, but the constant a thousandth of it:
        // what it adds, the unknown α₀ takes out again, apart from the 0.1 % that d/(s² + d²) varies.
        let share = |power: usize| if power == 0 { 2e-5 } else { 0.02 };
        let polynomial: Vec<f64> = (scaled.iter().enumerate())
            .map(|(power, a)| share(power) * a / 0.36f64.powi(power as i32))
            .collect();
        let device = Device {
            polynomial: &polynomial,
            noise_arcsec: 0.0,
            passes: 2,
            angles: (-17..=17).map(|step| centre_deg + 0.07 * f64::from(step)).collect(),
            ..Device::paper()
        };
        let order = polynomial.len() - 1;
        let options = Options { order: Some(order), ..Options::default() };
        let fit = fit(&device.recording(1), &mirror(), &options).unwrap();
        // The printed columns are rounded: 1e-9 mm and 1e-5 arcsec.
        prop_assert!(fit.residual.iter().all(|residual| arcsec(*residual).abs() < 1e-3));
    }
}
