//! No answer contradicts itself, whatever the recording: damaged, short, coarse, one-sided, in tiny units. Every draw
//! goes through `fit`, `diagnose`, `apply` and the check of `generate`; a few have their routines made.
//!
//! `ARCSMITH_RECORDINGS_DRAWN=1000` draws more than the usual number, `ARCSMITH_SEED=358` begins elsewhere,
//! `ARCSMITH_KEEP=folder` writes the recordings there.

mod damage;
mod made;

use std::borrow::Cow;
use std::path::Path;

use damage::Damage;
use diagnosis::Outcome;
use fitter::error_model::Sensor;
use fitter::faults::BadRow;
use fitter::{ApplyError, Coefficients, Mirror, Recording};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;

/// Draws where the environment does not say: a sample. `.ci/full` draws a thousand.
const DRAWN: u64 = 16;
/// Kinds follow one another in strides of this, so that few draws have kinds of every sort.
const STRIDE: u64 = 37;
/// Of so many draws one has its routines made: that takes longer than all the rest.
const GENERATED: u64 = 30;
/// Part of the draws that may be refused, or their model withheld, though nothing that is needed is missing.
const REFUSED: f64 = 0.02;

/// Every number of a JSON text.
fn numbers(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Number(number) => found.extend(number.as_f64()),
        Value::Array(items) => items.iter().for_each(|item| numbers(item, found)),
        Value::Object(items) => items.values().for_each(|item| numbers(item, found)),
        _ => {}
    }
}

/// What is wrong with the figures of an answer; empty where nothing is.
fn contradictions(d: &Value) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut all = Vec::new();
    numbers(d, &mut all);
    wrong.extend(all.iter().filter(|v| !v.is_finite() || v.abs() >= 1e12).map(|v| format!("{v}")));
    let number = |pointer: &str| d.pointer(pointer).and_then(Value::as_f64);
    let mut shares = 0.0;
    for effect in d["effects"].as_array().into_iter().flatten() {
        shares += effect["share"].as_f64().unwrap_or(f64::NAN);
        for p in effect["parameters"].as_array().into_iter().flatten() {
            let [v, low, high] =
                [&p["value"], &p["ci95"][0], &p["ci95"][1]].map(|v| v.as_f64().unwrap_or(f64::NAN));
            let slack = 1e-9 * (low.abs() + high.abs());
            if !(low - slack <= v && v <= high + slack) {
                wrong.push(format!("{}.{} {v} not in [{low}, {high}]", effect["id"], p["name"]));
            }
        }
    }
    if !(0.0..=1.001).contains(&shares) {
        wrong.push(format!("the effects' shares sum to {shares}"));
    }
    for which in ["train_rms", "held_out_rms"] {
        let figure = |model: &str| number(&format!("/fit/{model}/{which}"));
        if let (Some(before), Some(after)) = (figure("before"), figure("after"))
            && after > 1.02 * before
        {
            wrong.push(format!("{which}: {before} -> {after}"));
        }
    }
    let floor = number("/noise_floor/value").unwrap_or(f64::NAN);
    let explained = matches!(d["verdict"].as_str(), Some("consistent" | "explained" | "described"));
    if let (true, Some(held)) = (explained, number("/fit/after/held_out_rms"))
        && held > 1.3 * floor
    {
        wrong.push(format!("{}, but held out {held} at a floor of {floor}", d["verdict"]));
    }
    wrong
}

/// Root mean square of corrected reading less reference, one offset removed, and the part of rows out of range; bad rows
/// apart.
fn applied(recording: &Recording, file: &Coefficients, bad: &[BadRow]) -> Result<(f64, f64), ApplyError> {
    let applied = fitter::apply_screened(recording, file)?;
    let kept: Vec<usize> =
        (0..recording.rows()).filter(|row| bad.iter().all(|bad| bad.line != recording.line(*row))).collect();
    let per = file.sensor.per_internal();
    let turn = match &file.sensor {
        Sensor::Direct { revolution, .. } => *revolution,
        Sensor::EddyCurrentPair { .. } => None,
    };
    let error = |row: &usize| per * applied.corrected[*row] - recording.reference(*row).unwrap_or(f64::NAN);
    let first = error(&kept[0]);
    let errors: Vec<f64> = (kept.iter())
        .map(|row| error(row) - first)
        .map(|error| turn.map_or(error, |turn| error - turn * (error / turn).round()))
        .collect();
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let outside = kept.iter().filter(|row| applied.extrapolated[**row]).count() as f64 / n;
    Ok(((errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt(), outside))
}

/// What is wrong with a coefficients file that claims to leave `said` of the recording.
fn unusable(
    what: &str,
    recording: &Recording,
    file: &Coefficients,
    bad: &[BadRow],
    said: f64,
) -> Vec<String> {
    let file = match fitter::coefficients::parse("coefficients.json", &file.to_sealed_json()) {
        Ok(file) => file,
        Err(error) => return vec![format!("{what}: {error}")],
    };
    let mut wrong = Vec::new();
    if let Err(refusal) = fitter::acceptance::to_generate(&file, true) {
        wrong.push(format!("{what}: {refusal}"));
    }
    let (left, outside) = match applied(recording, &file, bad) {
        Ok(figures) => figures,
        Err(error) => return vec![format!("{what}: {error}")],
    };
    // What is left of a recording without any noise is the rounding of its readings.
    let rounding =
        1e-14 * (0..recording.rows()).fold(0.0_f64, |largest, row| largest.max(recording.reading(row).abs()));
    if (left - said).abs() > 0.03 * said + rounding {
        wrong.push(format!("{what}: applied rms {left}, said {said}"));
    }
    if outside > 0.005 {
        wrong.push(format!("{what}: {outside} of its own rows out of range"));
    }
    wrong
}

/// What is wrong with what `fit` makes of it.
fn fitted(recording: &Recording, mirror: &Mirror) -> Result<Vec<String>, String> {
    let screened = fitter::faults::screen(Cow::Borrowed(recording), &mirror.sensor)
        .map_err(|error| error.to_string())?;
    let options = fitter::Options::default();
    let fit = fitter::fit(&screened.recording, mirror, &options).map_err(|error| error.to_string())?;
    let per = fit.coefficients.sensor.per_internal();
    // A weighted fit leaves a mean, which the zero of the reference takes up.
    let n = fit.residual.len() as f64;
    let mean = fit.residual.iter().sum::<f64>() / n;
    let left = per * (fit.residual.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n).sqrt();
    Ok(unusable("fit", recording, &fit.coefficients, &screened.bad_rows, left))
}

/// Makes the routines; a reason for not making them is an answer.
fn generated(file: &Coefficients, folder: &Path) {
    let path = folder.join("coefficients.json");
    std::fs::write(&path, file.to_sealed_json()).expect("a file");
    match codegen::Builder::new().coefficients(&path).accept_unexplained().generate() {
        Ok(made) => assert!(made.certificate.routines.iter().all(|entry| entry.bound.is_finite())),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn diagnosed(recording: &Recording, mirror: &Mirror) -> Result<Outcome, String> {
    diagnosis::diagnose(recording, mirror, None, None, &diagnosis::Options::default())
        .map_err(|error| error.to_string())
}

/// What is wrong with the answers to one draw, and why it was refused.
fn draw(seed: u64, damage: &Damage, folder: &Path) -> (Vec<String>, Vec<String>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mirror, mut table) = made::draw(&mut random);
    let must_be_listed = (damage.act)(&mut table, &mut random);
    if let Some(folder) = std::env::var_os("ARCSMITH_KEEP") {
        let folder = Path::new(&folder);
        std::fs::write(folder.join(format!("drawn-{seed}.csv")), table.text()).expect("a file");
        std::fs::write(folder.join(format!("mirror-{seed}.toml")), mirror).expect("a file");
    }
    let mirror = Mirror::parse("mirror.toml", mirror).expect("a mirror");
    let recording = match Recording::from_bytes("drawn.csv", table.text().as_bytes()) {
        Ok(recording) => recording,
        Err(error) => return (Vec::new(), vec![error.to_string()]),
    };
    let (mut wrong, mut refused) = (Vec::new(), Vec::new());
    match fitted(&recording, &mirror) {
        Ok(found) => wrong.extend(found),
        Err(reason) => refused.push(format!("fit: {reason}")),
    }
    match diagnosed(&recording, &mirror) {
        Ok(outcome) => {
            let d = &outcome.diagnosis;
            let json = serde_json::to_value(d).expect("JSON");
            wrong.extend(contradictions(&json));
            let listed = |row: &usize| d.bad_rows.iter().any(|bad| bad.line == recording.line(*row));
            wrong.extend(must_be_listed.iter().filter(|row| !listed(row)).map(|row| {
                format!("line {} is not among the bad rows: {:?}", recording.line(*row), table.rows[*row])
            }));
            match &outcome.coefficients {
                Some(file) => {
                    let said = d.fit.after.train_rms;
                    wrong.extend(unusable("diagnose", &recording, file, &d.bad_rows, said));
                    if seed.is_multiple_of(GENERATED) {
                        generated(file, folder);
                    }
                }
                None => refused.push(format!("withheld: {:?}", d.withheld)),
            }
        }
        Err(reason) => refused.push(format!("diagnose: {reason}")),
    }
    (wrong, refused)
}

fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn no_answer_contradicts_itself() {
    let (count, first) = (setting("ARCSMITH_RECORDINGS_DRAWN", DRAWN), setting("ARCSMITH_SEED", 0));
    let (kinds, folder) = (damage::all(), tempfile::tempdir().expect("a folder"));
    let (mut wrong, mut refused) = (Vec::new(), Vec::new());
    let mut with_reason = 0;
    for seed in first..first + count {
        let damage = &kinds[(seed * STRIDE % kinds.len() as u64) as usize];
        let told = |what: String| format!("seed {seed}, {}: {what}", damage.name);
        let (found, reasons) = draw(seed, damage, folder.path());
        wrong.extend(found.into_iter().map(told));
        if damage.may_be_refused {
            with_reason += usize::from(!reasons.is_empty());
        } else if !reasons.is_empty() {
            refused.push(told(reasons.join("; ")));
        }
    }
    println!(
        "{count} draws of {} kinds: {} contradictions, {} refused for what is missing, {} otherwise",
        kinds.len(),
        wrong.len(),
        with_reason,
        refused.len()
    );
    println!("{}\n{}", wrong.join("\n"), refused.join("\n"));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(refused.len() as f64 <= REFUSED * count as f64, "{}", refused.join("\n"));
}
