//! Encoders that turn round and round, simulated with known errors, from 10 to 18 bits.

use crate::common;

use common::encoder::{Encoder, turning};
use fitter::recording::Purpose;
use fitter::{FitError, Options, Recording, fit, turn};

/// Largest distance of the corrected reading from the truth over every count, in counts.
fn worst_counts(encoder: &Encoder, file: &fitter::Coefficients, revolution: f64) -> (f64, f64) {
    let counts = encoder.counts();
    let per_count = revolution / counts;
    let (mut before, mut after) = (0.0f64, 0.0f64);
    for count in 0..(counts as u32) {
        // A count stands for the readings from itself to the next; its middle is the best that it can mean.
        let truth = encoder.truth((f64::from(count) + 0.5) / counts) * revolution;
        let apart = |value: f64| (value - truth) - revolution * ((value - truth) / revolution).round();
        let reading = f64::from(count) * per_count;
        before = before.max(apart(reading - encoder.zero * revolution).abs() / per_count);
        after = after.max(apart(turn::corrected(file, reading).unwrap()).abs() / per_count);
    }
    (before, after)
}

#[test]
fn an_eccentric_encoder_of_any_resolution_in_counts_and_in_degrees() {
    for bits in [10, 12, 14, 16, 18] {
        let encoder = Encoder::eccentric(bits);
        for (unit, revolution) in [("counts", encoder.counts()), ("deg", 360.0)] {
            let recording = encoder.recording(revolution, u64::from(bits));
            let fit = fit(&recording, &turning(unit, revolution), &Options::default()).unwrap();
            let turn = fit.coefficients.turn.as_ref().unwrap();
            assert!(turn.whole && !turn.counts_turns);
            assert!(turn.wraps.measured >= 4 && turn.wraps.reference >= 4, "{:?}", turn.wraps);
            // The second harmonic of 4e-4 turns is 0.4 counts of 10 bits and must be seen even there.
            let chosen = turn.harmonics.as_ref().unwrap().chosen;
            assert!((2..=4).contains(&chosen), "{bits} bits, {unit}: {chosen} harmonics");
            for (amplitude, (truth, _)) in turn.amplitudes.iter().zip(&encoder.harmonics) {
                let error = 4.0 * amplitude.standard_error.unwrap();
                assert!(
                    (amplitude.amplitude / revolution - truth).abs() * revolution < error,
                    "{amplitude:?}"
                );
            }
            let (before, after) = worst_counts(&encoder, &fit.coefficients, revolution);
            // What the fit cannot know is its own standard error: quantisation of 1/√12 counts or the noise of the
            // reference, over √(rows/parameters).
            let noise = (1.0 / 12.0f64 + (encoder.noise * encoder.counts()).powi(2)).sqrt();
            let allowed = 5.0 * noise * ((1 + 2 * chosen) as f64 / recording.rows() as f64).sqrt();
            println!(
                "{bits} bits, {unit}: {chosen} harmonics, {before:.2} → {after:.4} counts (allowed {allowed:.4})"
            );
            assert!(before > 2.0 && after < allowed, "{bits} bits, {unit}: {before} → {after}, {allowed}");
        }
    }
}

#[test]
fn forward_and_backward_are_told_apart() {
    let of = |encoder: &Encoder| {
        let recording = encoder.recording(360.0, 5);
        fit(&recording, &turning("deg", 360.0), &Options::default())
            .unwrap()
            .coefficients
            .turn
            .unwrap()
            .directions
    };
    let near = |estimate: &turn::Estimate, truth: f64| {
        assert!((estimate.value - truth).abs() < 4.0 * estimate.standard_error, "{estimate:?}, {truth}");
        assert!(estimate.standard_error < 0.05 * truth.abs(), "{estimate:?}");
    };
    let plain = Encoder::eccentric(16);
    // Friction at one speed: its size, and that a lag would look the same.
    let friction = of(&Encoder { friction: 1e-3, ..Encoder::eccentric(16) });
    near(friction.half_distance.as_ref().unwrap(), -0.36);
    assert!(friction.lag_s.is_none());
    assert!(friction.statement.contains("a second speed would tell"), "{}", friction.statement);
    assert!(friction.statement.contains("the reading stays behind"), "{}", friction.statement);
    // Friction and lag at two speeds: each its own.
    let both = Encoder { friction: 1e-3, lag_s: 2e-3, step_s: vec![0.01, 0.03], ..Encoder::eccentric(16) };
    let found = of(&both);
    near(found.half_distance.as_ref().unwrap(), -0.36);
    near(found.lag_s.as_ref().unwrap(), 2e-3);
    // Neither.
    let none = of(&Encoder { step_s: vec![0.01, 0.03], ..Encoder::eccentric(16) });
    assert!(
        none.statement.contains("agree within") && none.statement.contains("no lag"),
        "{}",
        none.statement
    );
    assert!(none.variation_rms.is_none());
    // One direction tells nothing, and says so; its correction is off by the friction.
    let encoder = Encoder { friction: 1e-3, backward: false, ..plain };
    let one = of(&encoder);
    assert_eq!((one.backward, one.half_distance.is_none()), (0, true));
    assert!(one.statement.starts_with("one direction only"), "{}", one.statement);
}

/// The friction stays out of the harmonics, and a direction that was run more often does not shift the zero.
#[test]
fn friction_is_not_taken_for_angle_error() {
    let with = Encoder { friction: 5e-3, noise: 0.0, ..Encoder::eccentric(18) };
    let without = Encoder { friction: 0.0, noise: 0.0, ..Encoder::eccentric(18) };
    let rows: Vec<String> = with.csv(360.0, 1).lines().map(String::from).collect();
    // The second half of the backward pass is missing.
    let cut = rows.len() - with.readings;
    let text = rows[..cut].join("\n") + "\n";
    let recording = Recording::from_bytes("cut.csv", text.as_bytes()).unwrap();
    let a = fit(&recording, &turning("deg", 360.0), &Options::default()).unwrap().coefficients;
    let b =
        fit(&without.recording(360.0, 1), &turning("deg", 360.0), &Options::default()).unwrap().coefficients;
    for reading in (0..360).map(f64::from) {
        let (a, b) = (turn::corrected(&a, reading).unwrap(), turn::corrected(&b, reading).unwrap());
        let apart = (a - b) - 360.0 * ((a - b) / 360.0).round();
        assert!(apart.abs() < 2e-3, "{reading}: {apart}"); // the friction is 1.8 degrees
    }
}

#[test]
fn apply_is_exact_at_the_wrap_and_keeps_the_turn_where_turns_are_counted() {
    let encoder = Encoder::eccentric(14);
    let mirror = turning("counts", 16384.0);
    let single = fit(&encoder.recording(16384.0, 3), &mirror, &Options::default()).unwrap().coefficients;
    let readings = [0.0, 1.0, 8191.0, 16383.0, 16384.0, 16385.0, 32767.0, -1.0];
    let text: String = std::iter::once("t_s,measured\n".to_string())
        .chain(readings.iter().enumerate().map(|(i, m)| format!("{i},{m}\n")))
        .collect();
    let recording = read_to_apply(&text);
    let applied = fitter::apply(&recording, &single).unwrap();
    assert!(applied.extrapolated.iter().all(|outside| !outside) && applied.notes.is_empty());
    for (corrected, reading) in applied.corrected.iter().zip(readings) {
        assert!((0.0..16384.0).contains(corrected));
        assert_eq!(turn::corrected(&single, reading), Some(*corrected));
    }
    for (one, other) in [(0, 4), (1, 5), (3, 7)] {
        assert_eq!(applied.corrected[one].to_bits(), applied.corrected[other].to_bits());
    }
    // From the last count to the first it goes on as from any count to the next.
    let step = (applied.corrected[0] - applied.corrected[3]).rem_euclid(16384.0);
    assert!((step - 1.0).abs() < 0.05, "{step}");

    // A reading that counts its turns keeps them.
    let mut text = String::from("t_s,pass,direction,measured,reference\n");
    for i in 0..900 {
        let truth = f64::from(i) / 300.0;
        let measured = (encoder.reading(truth) * 16384.0).floor();
        text += &format!("{i},{},1,{measured},{}\n", i / 300, truth * 16384.0);
    }
    let recording = Recording::from_bytes("counted.csv", text.as_bytes()).unwrap();
    let counted = fit(&recording, &mirror, &Options::default()).unwrap().coefficients;
    assert!(counted.turn.as_ref().unwrap().counts_turns);
    for reading in readings {
        let (here, there) = (
            turn::corrected(&counted, reading).unwrap(),
            turn::corrected(&counted, reading + 163840.0).unwrap(),
        );
        approx::assert_abs_diff_eq!(there - here, 163840.0, epsilon = 1e-9);
    }
}

fn read_to_apply(text: &str) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("readings.csv");
    std::fs::write(&path, text).unwrap();
    Recording::read_for(&path, Purpose::Apply, &mut |_| {}).unwrap()
}

/// One column wraps and the other counts on, or both count from elsewhere: the same coefficients.
#[test]
fn it_does_not_matter_where_either_column_wraps() {
    let wrapping = Encoder::eccentric(14);
    let counting = Encoder { reference_counts_turns: true, ..Encoder::eccentric(14) };
    let mirror = turning("deg", 360.0);
    let of = |encoder: &Encoder| {
        fit(&encoder.recording(360.0, 9), &mirror, &Options::default()).unwrap().coefficients
    };
    let (a, b) = (of(&wrapping), of(&counting));
    approx::assert_abs_diff_eq!(a.base.coefficients[0], b.base.coefficients[0], epsilon = 1e-8);
    for (a, b) in a.terms[0].coefficients.iter().zip(&b.terms[0].coefficients) {
        approx::assert_abs_diff_eq!(a, b, epsilon = 1e-8);
    }
}

#[test]
fn a_part_of_the_turn_across_the_wrap_is_a_polynomial_and_says_so() {
    let encoder = Encoder::eccentric(16);
    let mut text = String::from("t_s,pass,direction,measured,reference\n");
    for pass in 0..4 {
        for i in 0..60 {
            let i = if pass % 2 == 0 { i } else { 59 - i };
            let truth = 0.57 + 0.002 * f64::from(i); // readings from 0.94 to 1.06 turns
            let measured = encoder.reading(truth).rem_euclid(1.0) * 360.0;
            let direction = 1 - 2 * (pass % 2);
            text += &format!("{},{pass},{direction},{measured},{}\n", pass * 60 + i, truth * 360.0);
        }
    }
    let recording = Recording::from_bytes("part.csv", text.as_bytes()).unwrap();
    let fit = fit(&recording, &turning("deg", 360.0), &Options::default()).unwrap();
    let turn = fit.coefficients.turn.as_ref().unwrap();
    assert!(!turn.whole && fit.coefficients.terms.is_empty());
    assert!(fit.notes.iter().any(|note| note.to_string().contains("of a turn: a polynomial was fitted")));
    let range = &fit.coefficients.valid_range;
    assert!(range.to - range.from < 50.0, "{range:?}");
    for (pass, reading) in [(0, 339.0), (1, 359.5), (2, 0.5), (3, 18.0)] {
        let truth = encoder.truth(reading / 360.0) * 360.0;
        let corrected = fitter::turn::corrected(&fit.coefficients, reading).unwrap();
        let apart = (corrected - truth) - 360.0 * ((corrected - truth) / 360.0).round();
        assert!(apart.abs() < 0.01, "{pass}: {reading} gives {corrected}, {truth}");
    }
}

#[test]
fn what_cannot_be_a_turn_is_refused_with_its_row() {
    let encoder = Encoder::eccentric(12);
    let refuse = |text: &str, unit: &str, revolution: f64| -> String {
        let recording = Recording::from_bytes("encoder.csv", text.as_bytes()).unwrap();
        let error: FitError = fit(&recording, &turning(unit, revolution), &Options::default()).unwrap_err();
        error.to_string()
    };
    let edited = |edit: &dyn Fn(usize, &mut [f64])| {
        let text = encoder.csv(360.0, 4);
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        for (number, line) in lines.iter_mut().enumerate().skip(1) {
            let mut fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            edit(number + 1, &mut fields);
            *line = fields.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        }
        lines.join("\n") + "\n"
    };
    let contains = |message: &str, fragments: &[&str]| {
        assert!(fragments.iter().all(|fragment| message.contains(fragment)), "{message}");
        println!("{message}");
    };
    // Two readings before the wrap and two after it, averaged.
    let averaged = edited(&|line, fields| {
        if line == 128 {
            fields[3] = 180.3;
        }
    });
    contains(&refuse(&averaged, "deg", 360.0), &["line 128", "180.3", "average", "wrap-around"]);
    let backward = edited(&|_, fields| fields[4] = 360.0 - fields[4]);
    contains(&refuse(&backward, "deg", 360.0), &["`reference`", "same sense", "turn the sign"]);
    let counts = edited(&|_, fields| fields[3] *= 4096.0 / 360.0);
    contains(&refuse(&counts, "deg", 360.0), &["`measured`", "counts of 12 bits"]);
    contains(&refuse(&counts, "counts", 4096.0), &["`reference`", "degrees"]);
    contains(
        &refuse(&encoder.csv(4096.0, 4), "deg", 360.0),
        &["line ", "no turn of 360 deg", "counts of 12 bits"],
    );
    let unrelated = edited(&|line, fields| fields[3] = (line * line * 7919 % 36000) as f64 / 100.0);
    contains(&refuse(&unrelated, "deg", 360.0), &["nothing in common", "`revolution`"]);
    let recording = encoder.recording(360.0, 4);
    let options = Options { order: Some(3), ..Options::default() };
    let error = fit(&recording, &turning("deg", 360.0), &options).unwrap_err().to_string();
    contains(&error, &["order 3", "expected harmonics for a sensor that turns"]);
}
