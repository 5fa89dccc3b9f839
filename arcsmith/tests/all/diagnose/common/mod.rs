//! A small laboratory for the tests of the program.

#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const MIRROR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";

pub fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith"))
        .arg("diagnose")
        .args(arguments)
        .output()
        .expect("the program runs")
}

/// Two passes and more over ±1.5° with a deterministic scatter; `edit` may change a row's cells.
pub fn recording(
    folder: &Path,
    name: &str,
    passes: usize,
    mut edit: impl FnMut(usize, &mut Vec<String>),
) -> PathBuf {
    let mut text = String::from("t_s,pass,direction,x1_mm,x2_mm,reference_arcsec,temperature_c\n");
    let mut state: u64 = 7;
    let mut scatter = || {
        // A linear congruential generator is random enough for a scatter (Knuth's constants).
        let mut sum = 0.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum - 6.0
    };
    let mut row = 0;
    for pass in 0..passes {
        for k in 0..31 {
            let forward = pass % 2 == 0;
            let angle = if forward { -1.5 + 0.1 * k as f64 } else { 1.5 - 0.1 * k as f64 };
            let s = 12.0 * f64::to_radians(angle).tan();
            let reference = 3600.0 * angle * 0.97 + 0.5 * scatter();
            let mut cells = vec![
                format!("{:.2}", 3.0 * row as f64),
                pass.to_string(),
                if forward { "1" } else { "-1" }.to_string(),
                format!("{:.7}", -0.5 * s),
                format!("{:.7}", 0.5 * s),
                format!("{reference:.3}"),
                format!("{:.3}", 25.0 + 0.2 * scatter()),
            ];
            edit(row, &mut cells);
            text += &(cells.join(",") + "\n");
            row += 1;
        }
    }
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

pub struct Scene {
    pub folder: tempfile::TempDir,
    pub mirror: String,
}

pub fn scene() -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    let mirror = folder.path().join("mirror.toml");
    std::fs::write(&mirror, MIRROR).expect("a file");
    Scene { mirror: mirror.display().to_string(), folder }
}

impl Scene {
    pub fn diagnose(&self, recordings: &[&Path], more: &[&str]) -> (Output, PathBuf) {
        let out = self.folder.path().join("out");
        let paths: Vec<String> = recordings.iter().map(|p| p.display().to_string()).collect();
        let out_text = out.display().to_string();
        let mut arguments: Vec<&str> = paths.iter().map(String::as_str).collect();
        arguments.extend(["--mirror", &self.mirror, "--out", &out_text]);
        arguments.extend(more);
        (run(&arguments), out)
    }

    pub fn json(&self, out: &Path, stem: &str) -> serde_json::Value {
        let text = std::fs::read_to_string(out.join(format!("{stem}.json"))).expect("the diagnosis");
        serde_json::from_str(&text).expect("JSON")
    }
}

/// Normal deviates, the same for the same seed (twelve uniform numbers; Knuth's generator).
#[allow(dead_code)] // Not every test that shares this module draws noise.
pub fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// Noise of 0.5″ in `rows` readings, one every 3 s, that remembers for 7 s.
#[allow(dead_code)]
pub fn wandering(rows: usize, seed: u64) -> Vec<f64> {
    let mut normal = normal(seed);
    let kept = (-3.0_f64 / 7.0).exp();
    let mut wander = normal();
    (0..rows)
        .map(|_| {
            wander = kept * wander + (1.0 - kept * kept).sqrt() * normal();
            0.5 * wander
        })
        .collect()
}
