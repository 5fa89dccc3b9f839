//! `excite` and `simulate` from outside.

use std::path::Path;
use std::process::{Command, Output};

fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith")).args(arguments).output().unwrap()
}

const PLANT: &str = "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\ndamping = 40.0\n\
                     stiffness = 40000.0\ngain = 4e8\nhold = \"first-order\"\n";

fn column(file: &Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(file).unwrap();
    let at = text.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

#[test]
fn a_recording_that_was_made_is_simulated_to_its_noise() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let text = |name: &str| path(name).to_str().unwrap().to_owned();
    std::fs::write(path("plant.toml"), PLANT).unwrap();
    let drive: String = (0..800)
        .map(|k| format!("{:.4},{:.6}\n", 5e-4 * f64::from(k), 0.05 * (0.1 * f64::from(k)).sin()))
        .collect();
    std::fs::write(path("drive.csv"), format!("t_s,drive\n{drive}")).unwrap();
    let out = twin(&[
        "simulate",
        "--plant",
        &text("plant.toml"),
        "--drive",
        &text("drive.csv"),
        "--out",
        &text("a.csv"),
    ]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let position = column(&path("a.csv"), "position");
    assert_eq!(position.len(), 800);
    assert!(position.iter().fold(0.0f64, |m, x| m.max(x.abs())) > 300.0);

    // The same with an effect.
    std::fs::write(path("more.toml"), format!("{PLANT}[[effects]]\nid = \"sensor_offset\"\noffset = 100\n"))
        .unwrap();
    let run = |plant: &str, drive: &str, begin: &str| {
        let (plant, drive, out) = (text(plant), text(drive), text("out.csv"));
        let fixed = ["simulate", "--plant", &plant, "--drive", &drive, "--begin", begin, "--out", &out];
        let output = twin(&fixed);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        column(&path("out.csv"), "position")
    };
    let rest = run("more.toml", "drive.csv", "rest");
    assert!(rest.iter().zip(&position).all(|(a, b)| (a - b - 100.0).abs() < 1e-3));

    // A recording that begins in the middle of the motion: its first 50 rows say how it moves there.
    let late: String = drive.lines().zip(&position).skip(300).map(|(u, x)| format!("{u},{x}\n")).collect();
    std::fs::write(path("late.csv"), format!("t_s,drive,position\n{late}")).unwrap();
    let far = |simulated: &[f64]| {
        simulated.iter().zip(&position[300..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    assert!(far(&run("plant.toml", "late.csv", "recorded")) < 1e-2);
    assert!(far(&run("plant.toml", "late.csv", "rest")) > 50.0);
}

#[test]
fn one_seed_is_one_recording_to_the_byte() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, options: &str| -> Vec<u8> {
        let out = folder.path().join(name);
        let fixed = ["excite", "--samples", "1000", "--out", out.to_str().unwrap()];
        let output = twin(&fixed.into_iter().chain(options.split_whitespace()).collect::<Vec<_>>());
        assert!(output.status.success(), "{options}: {}", String::from_utf8_lossy(&output.stderr));
        std::fs::read(out).unwrap()
    };
    let plain = run("a.csv", "--seed 4");
    assert_eq!(plain, run("b.csv", "--seed 4"));
    let friction = "--effect coulomb_friction:force_per_inertia=1e6";
    for other in [
        "--seed 5",
        &format!("--seed 4 {friction}"),
        "--seed 4 --excitation sweep",
        "--seed 4 --excitation steps",
        "--seed 4 --noise autocorrelated",
        "--seed 4 --excitation odd-multisine --periods 2 --runs 2",
    ] {
        assert_ne!(plain, run("c.csv", other), "{other}");
    }
    let head = String::from_utf8(run("d.csv", "--seed 4 --periods 2 --runs 2")).unwrap();
    assert!(head.starts_with("t_s,run,period,drive,position\n"));
    assert_eq!(head.lines().count(), 4001);
}

#[test]
fn bad_input_gets_one_message_exit_code_2_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let good = write("good.toml", PLANT);
    let drive = write("drive.csv", "t_s,drive\n0,1\n0.001,2\n0.002,3\n0.003,3\n");
    let out = folder.path().join("out.csv").to_str().unwrap().to_owned();
    let bare = write("bare.toml", &PLANT.replace("damping = 40.0\n", ""));
    let unstable = write("unstable.toml", &PLANT.replace("= 40.0", "= -4000000"));
    let unknown = write("unknown.toml", &format!("{PLANT}[[effects]]\nid = \"friction\"\n"));
    let gap = write("gap.csv", "t_s,drive\n0,1\n0.001,2\n0.005,3\n0.006,1\n0.007,1\n");
    let missing = write("missing.csv", "t_s,force\n0,1\n0.001,2\n");
    let cases: [(&str, &str, &str, &str); 8] = [
        (&bare, &drive, &out, "plant.damping"),
        (&unstable, &drive, &out, "unstable"),
        (&unknown, &drive, &out, "coulomb_friction"),
        (&good, &gap, &out, "line 4"),
        (&good, &missing, &out, "`drive`"),
        ("none.toml", &drive, &out, "none.toml"),
        (&good, "none.csv", &out, "none.csv"),
        (&good, &drive, &drive, "another name"),
    ];
    for (plant, drive, out, message) in cases {
        let output = twin(&["simulate", "--plant", plant, "--drive", drive, "--out", out]);
        assert_eq!(output.status.code(), Some(2), "{message}");
        let said = String::from_utf8(output.stderr).unwrap().replace("\n  │ ", " ");
        assert!(said.contains(message), "{message}: {said}");
    }
    assert!(!Path::new(&out).exists());
}

#[test]
fn an_encoder_is_recorded_in_degrees_and_in_counts() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, options: &str| {
        let out = folder.path().join(name);
        let fixed = ["encode", "--seed", "3", "--out", out.to_str().unwrap()];
        let output = twin(&fixed.into_iter().chain(options.split_whitespace()).collect::<Vec<_>>());
        (output, out)
    };
    let (output, degrees) = run("deg.csv", "");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let measured = column(&degrees, "measured");
    assert_eq!(measured.len(), 870);
    assert!(measured.iter().all(|m| (0.0..=360.0).contains(m)));
    let (_, counts) = run("counts.csv", "--unit counts --unwrapped");
    assert!(column(&counts, "measured").iter().all(|m| m.fract() == 0.0));
    let (output, none) = run("none.csv", "--speed 0");
    assert_eq!(output.status.code(), Some(2));
    assert!(!none.exists());
}
