//! No answer contradicts itself, whatever the recording: damaged, short, coarse, one-sided, in tiny units.

mod common;

use std::path::{Path, PathBuf};

use common::{normal, run};
use fitter::{Coefficients, Recording};

/// A recording of a direct sensor: how many passes over which positions, and what disturbs it.
struct Damage {
    passes: usize,
    positions: usize,
    /// Unit of length: positions run over ten of it.
    scale: f64,
    offset: f64,
    one_way: bool,
    kind: usize,
    size: f64,
}

/// So many kinds of disturbance.
const KINDS: usize = 12;

impl Damage {
    fn draw(seed: u64) -> Damage {
        let mut normal = normal(seed * 977 + 5);
        let mut pick = |count: usize| (normal().abs() * 1e6) as usize % count;
        let positions: usize = [4, 6, 17, 35, 80][pick(5)];
        Damage {
            // Of fewer than sixteen readings nothing is said.
            passes: [1, 2, 4, 6][pick(4)].max(16_usize.div_ceil(positions)),
            positions,
            scale: [1e-6, 1.0, 1e3][pick(3)],
            offset: [0.0, 1e3][pick(2)],
            one_way: pick(4) == 0,
            kind: pick(KINDS),
            size: [3.0, 30.0, 1000.0][pick(3)],
        }
    }

    /// The recording; noise is a ten-thousandth of the range.
    fn write(&self, path: &Path, seed: u64) {
        let mut normal = normal(seed);
        let sigma = 1e-3 * self.scale;
        let mut text = String::from("t_s,pass,direction,measured,reference,temperature_c\n");
        let rows = self.passes * self.positions;
        for row in 0..rows {
            let (pass, k) = (row / self.positions, row % self.positions);
            let forward = self.one_way || pass % 2 == 0;
            let place = if forward { k } else { self.positions - 1 - k } as f64 / (self.positions - 1) as f64;
            let (t, d) = (row as f64, if forward { 1.0 } else { -1.0 });
            let truth = self.scale * 10.0 * (place - 0.5);
            let a = self.size * sigma;
            let temperature = 25.0 + 0.01 * t + 0.02 * normal();
            let error = match self.kind {
                0 => 0.0,
                1 => a * (7.0 * place).sin(),
                2 => a * d,
                3 => -a * d,
                4 => a * (temperature - 25.0),
                5 => a * (25.0 * place).sin() * (1.0 + temperature - 25.0),
                6 => a * f64::from(u8::from(row > rows / 2)),
                7 => a * (place - 0.3).abs(),
                8 => a * normal() * f64::from(u8::from(row % 17 == 0)),
                9 => a * (t / 7.0).sin(),
                10 => a * (normal() - 0.5).max(0.0),
                _ => (a * normal() / 0.3).round() * 0.3 * place,
            };
            let measured = truth + error + sigma * normal() + self.offset * self.scale;
            text += &format!("{t},{pass},{d},{measured:.12},{:.12},{temperature:.3}\n", truth);
        }
        std::fs::write(path, text).expect("a file");
    }
}

/// What `diagnose` wrote for a recording, or its message.
fn diagnosed(folder: &Path, seed: u64) -> Result<(PathBuf, serde_json::Value), String> {
    let (path, mirror) = (folder.join(format!("r{seed}.csv")), folder.join("mirror.toml"));
    Damage::draw(seed).write(&path, seed);
    std::fs::write(&mirror, "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n").expect("a file");
    let text = |p: &Path| p.display().to_string();
    let output = run(&[&text(&path), "--mirror", &text(&mirror), "--out", &text(folder), "--no-report"]);
    match output.status.code() {
        Some(0) => {
            let json = std::fs::read_to_string(folder.join(format!("r{seed}.json"))).expect("the diagnosis");
            Ok((path, serde_json::from_str(&json).expect("JSON")))
        }
        Some(2) => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        other => panic!("seed {seed}: {other:?}: {}", String::from_utf8_lossy(&output.stderr)),
    }
}

/// Every number of a JSON text.
fn numbers(value: &serde_json::Value, found: &mut Vec<f64>) {
    match value {
        serde_json::Value::Number(number) => found.extend(number.as_f64()),
        serde_json::Value::Array(items) => items.iter().for_each(|item| numbers(item, found)),
        serde_json::Value::Object(items) => items.values().for_each(|item| numbers(item, found)),
        _ => {}
    }
}

/// What is wrong with an answer; empty where nothing is.
fn contradictions(path: &Path, d: &serde_json::Value) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut all = Vec::new();
    numbers(d, &mut all);
    wrong.extend(all.iter().filter(|v| !v.is_finite() || v.abs() >= 1e12).map(|v| format!("{v}")));
    let number = |pointer: &str| d.pointer(pointer).and_then(serde_json::Value::as_f64);
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
    if let (true, Some(held)) =
        (matches!(d["verdict"].as_str(), Some("consistent" | "explained")), number("/fit/after/held_out_rms"))
        && held > 1.3 * floor
    {
        wrong.push(format!("{}, but held out {held} at a floor of {floor}", d["verdict"]));
    }
    let coefficients = path.with_extension("coefficients.json");
    let said = number("/fit/after/train_rms").unwrap_or(f64::NAN);
    let bad: Vec<u64> =
        d["bad_rows"].as_array().into_iter().flatten().filter_map(|row| row["line"].as_u64()).collect();
    match fitter::coefficients::read(&coefficients) {
        Ok(file) => {
            let (left, outside) = applied(path, &file, &bad);
            if (left - said).abs() > 0.03 * said {
                wrong.push(format!("applied rms {left}, said {said}"));
            }
            if outside > 0.005 {
                wrong.push(format!("{outside} of its own rows out of range"));
            }
        }
        Err(error) if d["withheld"].is_null() => wrong.push(error.to_string()),
        Err(_) => {}
    }
    wrong
}

/// Root mean square of corrected reading less reference, one offset removed, and the part of rows out of range.
fn applied(path: &Path, file: &Coefficients, bad: &[u64]) -> (f64, f64) {
    let recording = Recording::read(path).expect("the recording");
    let applied = fitter::apply(&recording, file).expect("corrected readings");
    let kept: Vec<usize> = (0..recording.rows()).filter(|row| !bad.contains(&recording.line(*row))).collect();
    let errors: Vec<f64> = kept
        .iter()
        .map(|row| applied.corrected[*row] - recording.reference(*row).unwrap_or(f64::NAN))
        .collect();
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let outside = kept.iter().filter(|row| applied.extrapolated[**row]).count() as f64 / n;
    ((errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt(), outside)
}

#[test]
fn no_answer_contradicts_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let count = std::env::var("ARCSMITH_RECORDINGS_DRAWN").ok().and_then(|n| n.parse().ok()).unwrap_or(60);
    let mut refused = Vec::new();
    let mut wrong = Vec::new();
    for seed in 0..count {
        match diagnosed(folder.path(), seed) {
            Ok((path, json)) => {
                let found = contradictions(&path, &json);
                wrong.extend(found.into_iter().map(|what| format!("seed {seed}: {what}")));
                if !json["withheld"].is_null() {
                    refused.push(format!("seed {seed}: {}", json["withheld"]));
                }
            }
            Err(message) => refused.push(format!("seed {seed}: {message}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(refused.len() as f64 <= 0.05 * count as f64, "{}", refused.join("\n"));
}
