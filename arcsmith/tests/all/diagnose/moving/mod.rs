//! Made recordings of a moving mechanism, and the program run on them.

use std::process::{Command, Output};

use serde_json::Value;

use crate::diagnose::common::run;

pub const PLANT: &str = "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\n";
pub const STEP_S: f64 = 5e-4;

/// Deterministic noise of unit variance (twelve uniform numbers; Knuth's generator).
pub struct Scatter(pub u64);

impl Scatter {
    pub fn next(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

/// A mechanism of 30 Hz with an extra acceleration and a held drive of several sines, recorded with noise.
pub fn made(rows: usize, extra: impl Fn(f64, f64) -> f64) -> Vec<(f64, f64)> {
    moved((0..rows).map(|k| several(2.3 * k as f64 * STEP_S)), 0.9, extra)
}

/// A drive of several sines, all of which come again when `turns` grows by one.
pub fn several(turns: f64) -> f64 {
    (1..40).map(|i| 0.006 * (i as f64 * turns * std::f64::consts::TAU + (i * i) as f64).sin()).sum()
}

/// The mechanism under a held drive, integrated in eighty semi-implicit steps per row: another method than the
/// program's.
pub fn moved(
    drives: impl Iterator<Item = f64>,
    noise: f64,
    extra: impl Fn(f64, f64) -> f64,
) -> Vec<(f64, f64)> {
    let (mut x, mut v, mut scatter) = (0.0, 0.0, Scatter(3));
    drives
        .map(|drive| {
            let row = (drive, x + noise * scatter.next());
            let h = STEP_S / 80.0;
            for _ in 0..80 {
                // Störmer and Verlet, the velocity in two half steps.
                let a = |x: f64, v: f64| 6e8 * drive - 36_000.0 * x - 40.0 * v + extra(x, v);
                v += 0.5 * h * a(x, v);
                x += h * v;
                v += 0.5 * h * a(x, v);
            }
            row
        })
        .collect()
}

/// Not every test that uses this module writes such rows.
#[allow(dead_code)]
pub fn csv(rows: &[(f64, f64)]) -> String {
    let line = |(k, (u, x)): (usize, &(f64, f64))| format!("{:.4},{u:.6},{x:.3}\n", k as f64 * STEP_S);
    String::from("t_s,drive,position\n") + &rows.iter().enumerate().map(line).collect::<String>()
}

pub struct Scene {
    folder: tempfile::TempDir,
}

impl Scene {
    pub fn new() -> Scene {
        let scene = Scene { folder: tempfile::tempdir().expect("a folder") };
        scene.write("plant.toml", PLANT);
        scene
    }

    pub fn write(&self, name: &str, text: &str) -> String {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path.display().to_string()
    }

    pub fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    /// A mirror that is simulated by `excite`, with these options.
    pub fn excited(&self, name: &str, options: &str) -> String {
        let path = self.path(name);
        let mut program = Command::new(env!("CARGO_BIN_EXE_arcsmith"));
        let output = program.arg("excite").args(options.split_whitespace()).args(["--out", &path]).output();
        assert!(output.expect("the program runs").status.success(), "{options}");
        path
    }

    pub fn diagnose(&self, recording: &str, more: &[&str]) -> Output {
        let (plant, out) = (self.path("plant.toml"), self.path("out"));
        let mut arguments = vec![recording, "--plant", &plant, "--out", &out, "--no-report"];
        arguments.extend(more);
        run(&arguments)
    }

    pub fn json(&self, stem: &str) -> Value {
        let text = std::fs::read_to_string(self.path(&format!("out/{stem}.json"))).expect("a diagnosis");
        serde_json::from_str(&text).expect("JSON")
    }
}

pub fn ids(diagnosis: &Value) -> Vec<String> {
    let effects = diagnosis["effects"].as_array().expect("effects");
    effects.iter().map(|e| e["id"].as_str().unwrap_or("").to_string()).collect()
}
