//! The dynamic part from outside: what it names in made recordings, how it refuses bad input, and what it
//! makes of the real and the opened recordings where they lie about.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::diagnose::common::run;
use crate::diagnose::moving::{PLANT, STEP_S, Scatter, Scene, csv, ids, made, moved, several};

#[test]
fn nothing_is_found_where_there_is_nothing() {
    let scene = Scene::new();
    let recording = scene.write("null.csv", &csv(&made(6000, |_, _| 0.0)));
    let output = scene.diagnose(&recording, &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let diagnosis = scene.json("null");
    assert_eq!(diagnosis["verdict"], "consistent", "{diagnosis}");
    let floor = diagnosis["noise_floor"]["value"].as_f64().unwrap_or(0.0);
    assert!((floor - 0.9).abs() < 0.05, "{floor}");
}

#[test]
fn a_cubic_stiffness_is_named_written_and_predicts_another_recording() {
    let scene = Scene::new();
    let rows = made(9000, |x, _| -3e-4 * x * x * x);
    let recording = scene.write("duffing.csv", &csv(&rows[..5000]));
    let other = scene.write("other.csv", &csv(&rows[5000..]));
    let output = scene.diagnose(&recording, &["--held-out", &other]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let diagnosis = scene.json("duffing");
    assert_eq!(diagnosis["verdict"], "explained", "{diagnosis}");
    assert_eq!(ids(&diagnosis), ["cubic_stiffness"]);
    let ci = diagnosis["effects"][0]["parameters"][0]["ci95"].as_array().expect("an interval").clone();
    let value = diagnosis["effects"][0]["parameters"][0]["value"].as_f64().unwrap_or(0.0);
    assert!((value / 3e-4 - 1.0).abs() < 0.02, "{value} {ci:?}");
    let after = diagnosis["fit"]["after"]["held_out_rms"].as_f64().unwrap_or(f64::NAN);
    assert!(after < 1.05 * 0.9, "{after}");
    let plant =
        fitter::plant::PlantFile::read(Path::new(&scene.path("out/duffing.plant.toml"))).expect("a plant");
    assert_eq!(plant.effects[0].number("coefficient"), Some(value));
    assert!((plant.plant.stiffness.unwrap_or(0.0) / 36_000.0 - 1.0).abs() < 0.01);
    let simulated = std::fs::read_to_string(scene.path("out/duffing.simulated.csv")).expect("a simulation");
    assert!(simulated.starts_with("t_s,before,after\n"));
    assert_eq!(simulated.lines().count(), 1 + 4000);
}

/// What the user's own simulation knows already is not named again, and it is what stands before.
#[test]
fn a_recording_is_explained_against_the_users_own_simulation() {
    let scene = Scene::new();
    let drives = || (0..5000).map(|k| several(2.3 * k as f64 * STEP_S));
    let rows = moved(drives(), 0.9, |x, v| -3e-4 * x * x * x - 2e-5 * v * v.abs());
    let recording = scene.write("duffing.csv", &csv(&rows));
    let known = moved(drives(), 0.0, |x, _| -3e-4 * x * x * x);
    let simulation = scene.write("own.csv", &csv(&known));
    let output = scene.diagnose(&recording, &["--simulated", &simulation]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let diagnosis = scene.json("duffing");
    assert_eq!(ids(&diagnosis), ["quadratic_damping"], "{diagnosis}");
    assert_eq!(diagnosis["verdict"], "explained");
    let plant =
        fitter::plant::PlantFile::read(Path::new(&scene.path("out/duffing.plant.toml"))).expect("a plant");
    let written: Vec<&str> = plant.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(written, ["cubic_stiffness", "quadratic_damping"]);
    let simulated = std::fs::read_to_string(scene.path("out/duffing.simulated.csv")).expect("a simulation");
    let row: Vec<f64> =
        simulated.lines().nth(3001).expect("rows").split(',').map(|v| v.parse().expect("a number")).collect();
    assert!((row[1] - known[3000].1).abs() < 1e-3, "{row:?} {}", known[3000].1);
    assert!((row[2] - rows[3000].1).abs() < 5.0 * 0.9, "{row:?} {}", rows[3000].1);

    let short = scene.write("short.csv", &csv(&known[..4000]));
    let output = scene.diagnose(&recording, &["--simulated", &short]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("4000 rows"));
}

/// Under feedback the simulated motion and the recorded drive state the mechanism that stands before.
#[test]
fn a_simulation_counts_under_feedback_too() {
    let scene = Scene::new();
    scene.write("plant.toml", &format!("{PLANT}feedback = \"command\"\n"));
    let (mut x, mut v, mut free, mut scatter) = (0.0f64, 0.0f64, (0.0f64, 0.0f64), Scatter(5));
    let (mut recorded, mut simulated) = (String::from("t_s,drive,position,command\n"), Vec::new());
    for k in 0..8000 {
        let t = k as f64 * STEP_S;
        let command =
            40.0 * (std::f64::consts::TAU * 0.9 * t).sin() + 15.0 * (std::f64::consts::TAU * 2.3 * t).sin();
        let drive = 60.0 * (command - x) - 3.0 * v;
        recorded += &format!("{t:.4},{drive:.6},{:.6},{command:.6}\n", x + 2e-4 * scatter.next());
        simulated.push((drive, free.0));
        let h = STEP_S / 20.0;
        for _ in 0..20 {
            // Dry friction that is no more than what stops the mechanism.
            let pull = 100.0 * drive - 2.0 * v;
            let held = (pull * h + v).clamp(-900.0 * h, 900.0 * h);
            v += pull * h - held;
            x += h * v;
            free.1 += h * (100.0 * drive - 2.0 * free.1);
            free.0 += h * free.1;
        }
    }
    let recording = scene.write("loop.csv", &recorded);
    let simulation = scene.write("own.csv", &csv(&simulated));
    let output = scene.diagnose(&recording, &["--simulated", &simulation]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let diagnosis = scene.json("loop");
    assert_eq!(ids(&diagnosis), ["coulomb_friction"], "{diagnosis}");
    // The simulation knows inertia and damping; the friction of 900/100 is all that it errs by.
    let before = diagnosis["fit"]["before"]["train_rms"].as_f64().unwrap_or(f64::NAN);
    assert!((before / 9.0 - 1.0).abs() < 0.05, "{before}");
    assert!(scene.diagnose(&recording, &[]).status.success());
    let without = scene.json("loop")["fit"]["before"]["train_rms"].as_f64().unwrap_or(f64::NAN);
    assert!(without < 0.9 * before, "a damping of its own takes part of the friction: {without} {before}");
}

/// Two periods of a steady state, from the third on, of 4096 rows each.
fn steady(extra: impl Fn(f64, f64) -> f64) -> String {
    let length = 4096;
    let rows = moved((0..6 * length).map(|k| several(4.0 * k as f64 / length as f64)), 0.9, extra);
    let line = |(k, (u, x)): (usize, &(f64, f64))| {
        format!("{:.4},{},{u:.6},{x:.3}\n", k as f64 * STEP_S, 1 + k / length)
    };
    String::from("t_s,period,drive,position\n")
        + &rows[4 * length..].iter().enumerate().map(line).collect::<String>()
}

/// Successive periods tell the noise from what comes again, and every row counts.
#[test]
fn periods_of_a_steady_state_give_the_noise() {
    let scene = Scene::new();
    let null = scene.write("null.csv", &steady(|_, _| 0.0));
    let stiff = scene.write("stiff.csv", &steady(|x, _| -3e-4 * x * x * x));
    assert!(scene.diagnose(&null, &[]).status.success() && scene.diagnose(&stiff, &[]).status.success());
    assert_eq!(scene.json("null")["verdict"], "consistent", "{}", scene.json("null"));
    assert_eq!(ids(&scene.json("stiff")), ["cubic_stiffness"]);
    for stem in ["null", "stiff"] {
        let floor = &scene.json(stem)["noise_floor"];
        assert_eq!(floor["from"], "repeated periods");
        // Five standard errors of a deviation from 4096 differences.
        let value = floor["value"].as_f64().unwrap_or(f64::NAN);
        assert!((value / 0.9 - 1.0).abs() < 5.0 / 8192f64.sqrt(), "{value}");
    }
    // In a steady state the first rows are as good as the others.
    let simulated = std::fs::read_to_string(scene.path("out/stiff.simulated.csv")).expect("a simulation");
    let recorded = std::fs::read_to_string(&stiff).expect("the recording");
    let number = |line: &str, k: usize| -> f64 {
        line.split(',').nth(k).and_then(|v| v.parse().ok()).expect("a number")
    };
    let first: f64 = (simulated.lines().zip(recorded.lines()).skip(1).take(50))
        .map(|(s, r)| (number(s, 2) - number(r, 3)).powi(2))
        .sum();
    assert!((first / 50.0).sqrt() < 1.6 * 0.9, "{first}");

    // A last period that is cut off is as good as far as it goes.
    let cut: String = recorded.lines().take(7000).map(|l| format!("{l}\n")).collect();
    let cut = scene.write("cut.csv", &cut);
    assert!(scene.diagnose(&cut, &[]).status.success());
    assert_eq!(ids(&scene.json("cut")), ["cubic_stiffness"]);
    assert_eq!(scene.json("cut")["noise_floor"]["from"], "repeated periods");
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let scene = Scene::new();
    let recording = scene.write("drag.csv", &csv(&made(3000, |_, v| -3e-5 * v * v.abs())));
    let mut texts = Vec::new();
    for jobs in ["1", "3"] {
        assert!(scene.diagnose(&recording, &["--jobs", jobs]).status.success());
        texts.push(std::fs::read(scene.path("out/drag.json")).expect("a diagnosis"));
    }
    assert_eq!(texts[0], texts[1]);
    assert_eq!(ids(&scene.json("drag")), ["quadratic_damping"]);
}

#[test]
fn bad_input_is_refused_in_one_message() {
    let scene = Scene::new();
    let rows = made(600, |_, _| 0.0);
    let good = csv(&rows);
    let lines: Vec<&str> = good.lines().collect();
    let without_row_300: String =
        lines.iter().enumerate().filter(|(k, _)| *k != 300).map(|(_, l)| format!("{l}\n")).collect();
    let unequal = good.replace("0.1000,", "0.1002,");
    let constant: Vec<(f64, f64)> = rows.iter().map(|(_, x)| (0.5, *x)).collect();
    let clipped: Vec<(f64, f64)> = made(3000, |_, _| 0.0).iter().map(|(u, x)| (*u, x.min(300.0))).collect();
    let runs: String = lines
        .iter()
        .enumerate()
        .map(|(k, l)| if k == 0 { format!("run,{l}\n") } else { format!("{},{l}\n", usize::from(k > 350)) })
        .collect();
    let cases = [
        (without_row_300.as_str(), "rows are missing", "line 301"),
        (&unequal, "the steps are unequal", "line 202"),
        (&csv(&constant), "found the constant 0.5", "`drive`"),
        (&csv(&clipped), "reduce the drive or extend the range", "largest 300"),
        (&runs, "run 1 has 250 rows", "350"),
        (&good.replace("0.0100,", "0.0100,x"), "expected a number", "line 22"),
        (&good.replace("position", "angle"), "column `position` is missing", "`t_s`, `drive`, `angle`"),
        ("t_s,drive,position\n", "no reading", "bad.csv"),
    ];
    for (text, expected, also) in cases {
        let recording = scene.write("bad.csv", text);
        let output = scene.diagnose(&recording, &[]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{expected}: {message}");
        assert!(
            message.contains(expected) && message.contains(also),
            "{message}\nexpected {expected}, {also}"
        );
        assert!(!Path::new(&scene.path("out")).exists(), "something was written");
    }
    let recording = scene.write("good.csv", &good);
    let slower: String = lines.iter().step_by(2).map(|l| format!("{l}\n")).collect();
    let other = scene.write("slower.csv", &slower);
    let output = scene.diagnose(&recording, &["--held-out", &other]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("is sampled every"));
    scene.write("plant.toml", &PLANT.replace("drive_unit = \"A\"\n", ""));
    let output = scene.diagnose(&recording, &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("drive_unit"));
    scene.write(
        "plant.toml",
        &format!("{PLANT}\n[[effects]]\nid = \"coulomb_fricton\"\nforce_per_inertia = 1.0\n"),
    );
    let output = scene.diagnose(&recording, &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("did you mean `coulomb_friction`?"));
    assert!(!Path::new(&scene.path("out")).exists(), "something was written");
}

/// Semicolons, decimal commas, comments, other names and units: the same answer.
#[test]
fn another_dialect_with_mapped_columns_gives_the_same_answer() {
    let scene = Scene::new();
    let good = csv(&made(3000, |_, v| -3e-5 * v * v.abs()));
    let plain = scene.write("plain.csv", &good);
    assert!(scene.diagnose(&plain, &[]).status.success());
    let text = good.replacen("t_s,drive,position", "Time,Coil,Angle", 1).replace(',', ";").replace('.', ",");
    let other = scene.write("other.csv", &format!("# exported\n{text}"));
    let map = ["--map", "t_s=Time", "--map", "drive=Coil:A", "--map", "position=Angle:arcsec"];
    let output = scene.diagnose(&other, &map);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let without_name = |stem: &str| {
        let mut json = scene.json(stem);
        json["recording"] = "".into();
        json
    };
    assert_eq!(without_name("other"), without_name("plain"));
    let output = scene.diagnose(&other, &["--map", "drive=Coil:deg"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("its unit is `deg`") && said.contains("converts into A"), "{said}");
    let said = String::from_utf8(scene.diagnose(&other, &[]).stderr).expect("text");
    let missing = "columns `t_s`, `drive`, `position` are missing";
    assert!(said.contains("other.csv, line 2") && said.contains(missing), "{said}");
}

/// What the plant file gives is fitted with the plant, and not named again.
#[test]
fn an_effect_that_is_given_is_not_found() {
    let scene = Scene::new();
    let rows = made(6000, |x, _| -3e-4 * x * x * x);
    let recording = scene.write("given.csv", &csv(&rows));
    let cubic = "\n[[effects]]\nid = \"cubic_stiffness\"\ncoefficient = 1e-4\n";
    scene.write("plant.toml", &format!("{PLANT}{cubic}"));
    assert_eq!(scene.diagnose(&recording, &[]).status.code(), Some(0));
    let diagnosis = scene.json("given");
    assert_eq!(diagnosis["verdict"], "consistent", "{diagnosis}");
    let written = scene.path("out/given.plant.toml");
    let plant = fitter::plant::PlantFile::read(Path::new(&written)).expect("a plant");
    assert_eq!(plant.effects[0].id, "cubic_stiffness");
}

fn folder(variable: &str) -> Option<PathBuf> {
    let folder = std::env::var_os(variable).map(PathBuf::from);
    if folder.is_none() || cfg!(debug_assertions) {
        println!("skipped: {variable} is not set, or this is a debug build");
        return None;
    }
    folder
}

#[test]
fn some_opened_recordings_are_diagnosed() {
    opened_recordings_are_diagnosed(4);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn all_opened_recordings_are_diagnosed() {
    opened_recordings_are_diagnosed(1);
}

/// Every so many of them.
fn opened_recordings_are_diagnosed(step: usize) {
    let Some(folder) = folder("ARCSMITH_EXAMPLES") else { return };
    let scene = Scene::new();
    let text = std::fs::read_to_string(folder.join("truth_dynamic.json")).expect("the truth");
    let truth: Value = serde_json::from_str(&text).expect("JSON");
    for (stem, told) in truth.as_object().expect("an object").iter().step_by(step) {
        let recording = folder.join("dynamic").join(format!("{stem}.csv.gz")).display().to_string();
        assert!(scene.diagnose(&recording, &[]).status.success());
        let diagnosis = scene.json(stem);
        let (mut wanted, mut named) = (ids(told), ids(&diagnosis));
        if wanted.iter().any(|id| id.starts_with("ooc_")) {
            let verdict = diagnosis["verdict"].as_str();
            let unnamed = ["unexplained", "partly_explained", "described"].map(Some).contains(&verdict);
            let effects = diagnosis["effects"].as_array().expect("effects");
            assert!(unnamed && effects.iter().all(|e| e["kind"] == "empirical"), "{stem}: {diagnosis}");
            let place = &diagnosis["locations"][0]["variable"];
            let places = told["effects"][0]["parameters"]["depends_on"].as_array().expect("places");
            assert!(places.contains(place), "{stem}: {place}");
            continue;
        }
        wanted.sort();
        named.sort();
        assert_eq!(named, wanted, "{stem}");
    }
}

/// What is said of a recording on which another one of the device is held out, all three of this folder.
fn of_device(scene: &Scene, folder: &Path, [recording, plant, other]: [&str; 3]) -> Value {
    let at = |name: &str| folder.join(name).display().to_string();
    let out = scene.path("out");
    let output =
        run(&[&at(recording), "--plant", &at(plant), "--held-out", &at(other), "--out", &out, "--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    scene.json(recording.trim_end_matches(".csv.gz"))
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn the_silverbox_is_named() {
    let Some(folder) = folder("ARCSMITH_RECORDINGS") else { return };
    let files = ["silverbox-train.csv.gz", "silverbox.toml", "silverbox-test-multisine.csv.gz"];
    let silverbox = of_device(&Scene::new(), &folder, files);
    assert_eq!(ids(&silverbox)[0], "cubic_stiffness");
    // Millivolts: a black-box state space with many parameters reaches 0.26 on the multisine.
    assert!(silverbox["fit"]["after"]["held_out_rms"].as_f64().is_some_and(|v| v <= 0.26e-3));
}

#[test]
fn the_positioning_drive_is_named() {
    let Some(folder) = folder("ARCSMITH_RECORDINGS") else { return };
    let scene = Scene::new();
    // Published: M = 95.1 kg, Fv = 203.5 N·s/m, Fc = 20.4 N, offset −3.2 N.
    let emps = of_device(&scene, &folder, ["emps-train.csv.gz", "emps.toml", "emps-test.csv.gz"]);
    assert_eq!(ids(&emps), ["coulomb_friction", "drive_offset", "drive_lag"]);
    let plant =
        fitter::plant::PlantFile::read(Path::new(&scene.path("out/emps-train.plant.toml"))).expect("a plant");
    let gain = plant.plant.gain.as_ref().and_then(|g| g.get(0)).expect("a gain");
    let near = |value: f64, published: f64, part: f64| {
        assert!((value / published - 1.0).abs() < part, "{value}, published {published}");
    };
    near(1.0 / gain, 95.1, 0.03);
    near(plant.plant.damping.expect("damping") / gain, 203.5, 0.05);
    assert_eq!(plant.plant.stiffness, Some(0.0));
    let number = |id: &str, name: &str| {
        plant.effects.iter().find(|e| e.id == id).and_then(|e| e.number(name)).expect("a parameter")
    };
    near(number("coulomb_friction", "force_per_inertia") / gain, 20.4, 0.03);
    near(number("drive_offset", "offset"), -3.2, 0.03);
    let error = force_error(&folder.join("emps-test.csv.gz"), &scene.path("out/emps-train.simulated.csv"));
    println!("error of the force on the test: {:.2} %", 100.0 * error);
    assert!(error <= 0.045, "published 5.98 %: {error}");
}

/// Relative error of the predicted force, as it is published: both sides low-passed without phase, the first and
/// last 300 rows left out.
fn force_error(recording: &Path, simulated: &str) -> f64 {
    use diagnosis::dynamic::low_pass;

    const LEFT_OUT: usize = 300;
    let recording =
        diagnosis::dynamic::DynamicRecording::read(recording, &Default::default()).expect("a recording");
    let mut file = csv::Reader::from_path(simulated).expect("a simulation");
    let after = file.headers().expect("a header").iter().position(|name| name == "after").expect("a column");
    let predicted: Vec<f64> =
        file.records().map(|row| row.expect("a row")[after].parse().expect("a number")).collect();
    let smooth = |force: &[f64]| low_pass(force, 40.0, recording.step_s);
    let (recorded, predicted) = (smooth(&recording.drives[0]), smooth(&predicted));
    let rows = LEFT_OUT..recorded.len() - LEFT_OUT;
    let (mut left, mut all) = (0.0, 0.0);
    for k in rows {
        left += (recorded[k] - predicted[k]).powi(2);
        all += recorded[k].powi(2);
    }
    (left / all).sqrt()
}
