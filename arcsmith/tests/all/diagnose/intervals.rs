//! Intervals where they are hard to get right. Beside a polynomial of order 9 on 18 positions a bump near the end leaves
//! nearly what one of the other sign beside it leaves. Read again where the motion turned, a device in closed loop may
//! stand anywhere in its play. The common mode of two probes holds their noise, which takes from what leaks of it.

use std::path::Path;

use crate::diagnose::common::{Scene, normal, recording, scene};

/// Height (arcsec), centre and width (deg) of the bump.
const BUMP: [f64; 3] = [-7.0, 1.237, 0.165];

/// Half width (arcsec) of the play, and the part of the noise that one reading has of the one before.
const HALF_WIDTH: f64 = 1.5;
const REMEMBERED: f64 = 0.95;

/// Leakage of the common mode, arcsec/µm.
const LEAKAGE: f64 = 8.0;

/// Name, value and interval of every parameter of the first effect in a coarse recording of the bump, with white noise
/// of 0.5″.
fn of_bump(seed: u64) -> (String, Vec<(String, f64, [f64; 2])>) {
    let mut draw = normal(seed);
    parameters(|angle| {
        let bump = BUMP[0] * (-0.5 * ((angle / 3600.0 - BUMP[1]) / BUMP[2]).powi(2)).exp();
        angle * 0.97 - bump + 0.5 * draw()
    })
}

/// The same of a play behind a loop that brings the reading onto the command, so that the frame has its noise of 0.5″:
/// slow within a pass, and another one after the pause between passes.
fn of_play(seed: u64) -> (String, Vec<(String, f64, [f64; 2])>) {
    let mut draw = normal(seed);
    let (mut noise, mut row) = (0.0, 0);
    let mut mirror = f64::NAN;
    parameters(|angle| {
        let remembered = if row % 18 == 0 { 0.0 } else { REMEMBERED };
        row += 1;
        noise = remembered * noise + 0.5 * f64::sqrt(1.0 - remembered * remembered) * draw();
        let frame = angle + noise;
        mirror = mirror.clamp(frame - HALF_WIDTH, frame + HALF_WIDTH);
        mirror = if mirror.is_nan() { frame } else { mirror };
        mirror
    })
}

/// Name, value and interval of every parameter of the first effect that is found where `reference` (arcsec) stands
/// beside a reading (arcsec): steps of 0.2°, twelve passes with pauses.
fn parameters(mut reference: impl FnMut(f64) -> f64) -> (String, Vec<(String, f64, [f64; 2])>) {
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", 7, |row, cells| {
        let (pass, k) = (row / 18, row % 18);
        let angle = if pass % 2 == 0 { -1.7 + 0.2 * k as f64 } else { 1.7 - 0.2 * k as f64 };
        let s = 12.0 * f64::to_radians(angle).tan();
        cells[0] = format!("{:.2}", 3.0 * row as f64 + 600.0 * pass as f64);
        cells[1] = pass.to_string();
        cells[2] = if pass % 2 == 0 { "1" } else { "-1" }.to_string();
        cells[3] = format!("{:.7}", -0.5 * s);
        cells[4] = format!("{:.7}", 0.5 * s);
        cells[5] = format!("{:.3}", reference(3600.0 * angle));
    });
    first_effect(&scene, &path)
}

/// The first effect of a diagnosis.
fn first_effect(scene: &Scene, path: &Path) -> (String, Vec<(String, f64, [f64; 2])>) {
    let (output, out) = scene.diagnose(&[path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "r");
    let first = &json["effects"][0];
    let number = |v: &serde_json::Value| v.as_f64().expect("a number");
    let of = first["parameters"].as_array().into_iter().flatten();
    let found = of.map(|p| {
        let name = p["name"].as_str().unwrap_or_default().to_string();
        (name, number(&p["value"]), [number(&p["ci95"][0]), number(&p["ci95"][1])])
    });
    (first["id"].as_str().unwrap_or_default().to_string(), found.collect())
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn an_interval_reaches_every_place_that_does_nearly_as_well() {
    let (mut named, mut held) = (0, [0; 3]);
    for seed in 1..=20 {
        let (id, found) = of_bump(seed);
        if id != "local_defect" {
            continue;
        }
        named += 1;
        for ((name, value, [from, to]), (truth, held)) in found.iter().zip(BUMP.iter().zip(&mut held)) {
            assert!(from <= value && value <= to, "{name} {value} in [{from}, {to}]");
            *held += usize::from(from <= truth && truth <= to);
        }
    }
    println!("{named} named, height, centre and width held: {held:?}");
    // Of 20 intervals of 95 % fewer than 17 hold the truth in 1.6 % of such tests.
    assert!(named >= 10, "{named}");
    assert!(held.iter().all(|held| held + 3 >= named), "{held:?} of {named}");
}

#[test]
fn where_the_motion_turns_the_state_of_the_play_is_left_open() {
    let (mut named, mut held) = (0, 0);
    for seed in 1..=20 {
        let (id, found) = of_play(seed);
        if id != "backlash" {
            continue;
        }
        named += 1;
        let (name, value, [from, to]) = &found[0];
        assert!(from <= value && value <= to, "{name} {value} in [{from}, {to}]");
        held += usize::from((*from..=*to).contains(&HALF_WIDTH));
    }
    println!("{named} named, half width held: {held}");
    assert!(named >= 17, "{named}");
    assert!(held + 3 >= named, "{held} of {named}");
}

/// A leakage of 8″/µm in a scan whose probes have a noise of 7 s, 0.5″ in the angle and half as much in the common mode.
fn of_leakage(seed: u64) -> (String, Vec<(String, f64, [f64; 2])>) {
    let rows = 1240;
    let [first, second] = [2 * seed, 2 * seed + 1].map(|seed| {
        let mut draw = normal(seed);
        let kept = f64::exp(-0.2 / 7.0);
        (0..rows).scan(0.0, move |noise, _| {
            *noise = kept * *noise + f64::sqrt(1.0 - kept * kept) * draw();
            Some(20.6e-6 * *noise)
        })
    });
    let noise: Vec<(f64, f64)> = first.zip(second).collect();
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", rows / 31, |row, cells| {
        let angle = 1.5 * (0.0101 * row as f64).sin();
        let (s, t_s) = (12.0 * f64::to_radians(angle).tan(), 0.2 * row as f64);
        let common_um = 0.106 * ((t_s / 5.0).sin() + (t_s / 6.85 + 1.0).sin());
        cells[0] = format!("{t_s:.2}");
        cells[1] = (row / 311).to_string();
        cells[2] = if (0.0101 * row as f64).cos() > 0.0 { "1" } else { "-1" }.to_string();
        cells[3] = format!("{:.8}", -0.5 * s + 1e-3 * common_um + noise[row].0);
        cells[4] = format!("{:.8}", 0.5 * s + 1e-3 * common_um + noise[row].1);
        cells[5] = format!("{:.3}", 3600.0 * angle - LEAKAGE * common_um);
    });
    first_effect(&scene, &path)
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn the_noise_of_the_probes_is_in_the_interval_of_a_leakage() {
    let (mut named, mut held) = (0, 0);
    for seed in 1..=20 {
        let (id, found) = of_leakage(seed);
        if id != "common_mode_leakage" {
            continue;
        }
        named += 1;
        let (name, value, [from, to]) = &found[0];
        assert!(from <= value && value <= to, "{name} {value} in [{from}, {to}]");
        held += usize::from((*from..=*to).contains(&LEAKAGE));
    }
    println!("{named} named, coefficient held: {held}");
    assert!(named >= 17, "{named}");
    assert!(held + 3 >= named, "{held} of {named}");
}
