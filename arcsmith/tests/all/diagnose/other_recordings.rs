//! What of an effect is handed on to other recordings, where this one does not tell it from a drift.

use crate::diagnose::common::{normal, recording, scene};
use diagnosis::{Options, diagnose};
use fitter::terms::{Operator, Scope};
use fitter::{Mirror, Recording};

/// Passes of 31 rows with noise of 0.5″; `of` says of row and angle (degrees) the temperature and by how much the reading is
/// too large (″).
fn diagnosed(passes: usize, of: impl Fn(usize, f64) -> (f64, f64)) -> (diagnosis::Outcome, Recording) {
    let mut draw = normal(11);
    let noise: Vec<f64> = (0..31 * passes).map(|_| 0.5 * draw()).collect();
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", passes, |row, cells| {
        let (pass, k) = (row / 31, row % 31);
        let angle = if pass % 2 == 0 { -1.5 + 0.1 * k as f64 } else { 1.5 - 0.1 * k as f64 };
        let (temperature, error) = of(row, angle);
        cells[5] = format!("{:.3}", 3600.0 * angle * 0.97 - error + noise[row]);
        cells[6] = format!("{temperature:.4}");
    });
    let recording = Recording::read(&path).expect("a recording");
    let mirror = Mirror::read(scene.mirror.as_ref()).expect("mirror.toml");
    let outcome = diagnose(&recording, &mirror, None, None, &Options::default()).expect("a diagnosis");
    (outcome, recording)
}

/// Seven passes beside a temperature that runs with time but for a ripple of `ripple` K, 1.5″/K.
fn drift(ripple: f64) -> (diagnosis::Outcome, Recording) {
    diagnosed(7, |row, _| {
        let above = 0.01 * row as f64 + ripple * (0.37 * row as f64).sin();
        (25.0 + above, 1.5 * above)
    })
}

/// The effects of which something is handed on to other recordings.
fn of_device(outcome: &diagnosis::Outcome) -> Vec<&str> {
    let file = outcome.coefficients.as_ref().expect("coefficients");
    let of_device = file.terms.iter().filter(|t| t.scope == Scope::Device);
    of_device.map(|t| t.effect.as_str()).collect()
}

/// Scope and coefficient of the terms of the temperature.
fn terms(outcome: &diagnosis::Outcome) -> Vec<(Scope, f64)> {
    let file = outcome.coefficients.as_ref().expect("coefficients");
    file.terms
        .iter()
        .filter(|t| t.effect == "thermal_zero_drift")
        .map(|t| (t.scope, t.coefficients[0]))
        .collect()
}

#[test]
fn a_part_stays_here_where_a_drift_may_be_what_happened() {
    let (outcome, recording) = drift(0.09);
    let of_temperature = terms(&outcome);
    let [(Scope::Device, device), (Scope::Recording, here)] = of_temperature[..] else {
        panic!("{of_temperature:?}: {:?}", outcome.diagnosis.effects);
    };
    let told = outcome.diagnosis.effects[0].parameters[0].value;
    assert!((device + here - told).abs() < 1e-9 * told.abs(), "{device} and {here} of {told}");
    assert!((0.1..0.95).contains(&(device / told)), "{device} of {told}");
    assert!(outcome.diagnosis.unidentifiable.iter().any(|s| s.contains("is handed on to them")));
    // The recording itself is corrected as if it were one.
    let file = outcome.coefficients.as_ref().expect("coefficients");
    let corrected = fitter::apply(&recording, file).expect("it is applied").corrected;
    let reference = outcome.rows.truth.iter();
    let left: Vec<f64> =
        corrected.iter().zip(reference).map(|(c, t)| c * file.sensor.per_internal() - t).collect();
    let mean = left.iter().sum::<f64>() / left.len() as f64;
    let rms = (left.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / left.len() as f64).sqrt();
    assert!((rms - outcome.diagnosis.fit.after.train_rms).abs() < 1e-3 * rms, "{rms}");
}

#[test]
fn all_of_it_is_handed_on_where_the_recording_tells() {
    let (outcome, _) = drift(1.0);
    let of_temperature = terms(&outcome);
    assert!(matches!(of_temperature[..], [(Scope::Device, _)]), "{of_temperature:?}");
}

#[test]
fn two_effects_that_only_other_recordings_tell_apart_are_handed_on_as_their_mean() {
    // The temperature goes with the angle but for half a kelvin, so that its square is a gain that changes with it.
    let (outcome, _) = diagnosed(6, |row, angle| {
        let above = 7.0 * angle + 0.5 * (0.13 * row as f64).sin();
        (27.0 + above, 0.3 * above * above)
    });
    assert!(!outcome.diagnosis.effects.is_empty());
    assert_eq!(of_device(&outcome).len(), 2, "{:?}", outcome.diagnosis.effects);
    let said = outcome.diagnosis.unidentifiable.iter().find(|s| s.contains("predicts something else"));
    let parts: Vec<f64> = said.expect("it is said").split(" %").filter_map(last_number).collect();
    assert_eq!(parts.iter().sum::<f64>(), 100.0, "{said:?}");
    assert!(parts.iter().all(|part| (1.0..100.0).contains(part)), "{said:?}");
    // On the recording itself the mean of both leaves the noise of 0.5″, as either would.
    let fit = &outcome.diagnosis.fit;
    assert!(fit.after.train_rms < 0.55 && fit.before.train_rms > 1.0, "{fit:?}");
    assert!(fit.gain.as_ref().is_some_and(|gain| gain.ci95[0] > 0.0), "{fit:?}");
}

/// Seven passes in which the coil's heat follows the square of its current within 200 s, from `before` (A²) on or, if there is
/// none, from that of the first row on, which is three times the mean: its terms as other recordings get them, and all.
fn heated(before: Option<f64>) -> (diagnosis::Outcome, Vec<(Scope, String)>) {
    let (mut noise, mut heat) = (normal(5), before);
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", 7, |row, cells| {
        let (pass, k) = (row / 31, row % 31);
        let angle = if pass % 2 == 0 { -1.5 + 0.1 * k as f64 } else { 1.5 - 0.1 * k as f64 };
        let current = 0.15 + 0.45 * (std::f64::consts::TAU * row as f64 / 60.0).cos();
        let before: f64 = heat.unwrap_or(current * current);
        heat = Some(before + (1.0 - f64::exp(-3.0 / 200.0)) * (current * current - before));
        cells[5] = format!("{:.3}", 3600.0 * angle * 0.97 - 60.0 * before + 0.5 * noise());
        cells.push(format!("{current:.5}"));
    });
    let text = std::fs::read_to_string(&path).expect("a recording");
    std::fs::write(&path, text.replacen("temperature_c", "temperature_c,coil_a", 1)).expect("a file");
    let recording = Recording::read(&path).expect("a recording");
    let mirror = Mirror::read(scene.mirror.as_ref()).expect("mirror.toml");
    let outcome = diagnose(&recording, &mirror, None, None, &Options::default()).expect("a diagnosis");
    let file = outcome.coefficients.as_ref().expect("coefficients");
    let texts = file.terms.iter().map(|term| match &term.operator {
        Operator::Expression(expression) => (term.scope, expression.text.clone()),
        operator => (term.scope, operator.kind().to_string()),
    });
    let texts = texts.collect();
    (outcome, texts)
}

#[test]
fn a_lag_that_is_seen_to_begin_at_what_it_follows_does_so_on_other_recordings() {
    let (_, terms) = heated(None);
    assert_eq!(terms, [(Scope::Device, "k * lowpass(coil_a^2, tau)".to_string())]);
}

#[test]
fn heat_from_before_the_recording_stays_with_it() {
    let (outcome, terms) = heated(Some(0.6));
    let [(Scope::Device, elsewhere), (Scope::Recording, here), (Scope::Recording, _)] = &terms[..] else {
        panic!("{terms:?}: {:?}", outcome.diagnosis.effects);
    };
    assert!(
        elsewhere.starts_with("k * lowpass(coil_a^2, tau") && !elsewhere.contains("missing"),
        "{elsewhere}"
    );
    assert!(here.contains("+ missing_1 * step(t_s, "), "{here}");
    let [effect] = &outcome.diagnosis.effects[..] else { panic!("{:?}", outcome.diagnosis.effects) };
    let value =
        |name: &str| effect.parameters.iter().find(|p| p.name.starts_with(name)).expect("it is stated").value;
    assert!(
        (value("k") - 60.0).abs() < 6.0 && (value("tau") - 200.0).abs() < 20.0,
        "{:?}",
        effect.parameters
    );
    assert!(outcome.diagnosis.fit.after.train_rms < 0.55, "{:?}", outcome.diagnosis.fit);
}

/// The number at the end of a text.
fn last_number(text: &str) -> Option<f64> {
    text.rsplit(' ').next()?.parse().ok()
}

#[test]
fn an_effect_of_a_temperature_of_its_own_is_no_other() {
    // The same square where the temperature goes its own way.
    let (outcome, _) = diagnosed(6, |row, _| {
        let above = 10.0 * (0.05 * row as f64).sin();
        (27.0 + above, 0.05 * above * above)
    });
    assert_eq!(of_device(&outcome).len(), 1, "{:?}", outcome.diagnosis.effects);
}

#[test]
fn a_pass_at_a_temperature_of_its_own_is_not_foretold_from_the_others() {
    let (outcome, _) = diagnosed(4, |row, _| {
        let temperature = [15.0, 16.0, 17.0, 40.0][row / 31] + 5.0 * (row % 31) as f64 / 31.0;
        (temperature, 0.03 * (temperature - 20.0_f64).powi(2))
    });
    assert_eq!(outcome.diagnosis.fit.held_out_by, "block");
    assert_eq!(of_device(&outcome).len(), 1, "{:?}", outcome.diagnosis.effects);
    let after = outcome.diagnosis.fit.after.held_out_rms.expect("held-out rows");
    assert!(after < 0.6, "{after}");
}
