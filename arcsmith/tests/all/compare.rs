//! `compare`: what changed between two recordings, and what is refused.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Output};

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;
use twin::dynamic::drive_loop::{self, Actuator, Carriage, Load};

fn arcsmith(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_arcsmith"));
    command.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

fn run(folder: &Path, line: &str) -> String {
    let output = arcsmith(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Records the same mirror.
fn record_mirror(folder: &Path, rest: &str) {
    run(folder, &format!("record --protocol calibration --device-seed 7 -q {rest}"));
}

/// Records it with a zero drift of so many arcsec/K.
fn record(folder: &Path, name: &str, seed: u32, schedule: &str, drift: f64) {
    let effect = format!("--effect thermal_zero_drift:coefficient_arcsec_per_k={drift}");
    let rest = format!("--seed {seed} --schedule {schedule} --temperature chamber {effect} --out {name}");
    record_mirror(folder, &rest);
}

#[test]
fn a_moved_parameter_is_named_and_an_unchanged_device_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "init --out mirror.toml -q");
    record(folder, "then.csv", 1, "paper", 0.2);
    record(folder, "same.csv", 2, "fine", 0.2);
    record(folder, "now.csv", 3, "fine", 0.4);
    let same = run(folder, "compare then.csv same.csv --mirror mirror.toml --out same --json");
    let same: Value = serde_json::from_str(&same).unwrap();
    assert_eq!(same["verdict"], "unchanged", "{same}");
    assert!(same["would_have_seen"].as_array().unwrap().len() > 2, "{same}");
    let text = run(folder, "compare then.csv now.csv --mirror mirror.toml --out moved --json");
    let moved: Value = serde_json::from_str(&text).unwrap();
    let changes = moved["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{moved}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"thermal_zero_drift".into(), &"moved".into()));
    // The intervals hold what was concealed.
    for (side, truth) in [("then", 0.2), ("now", 0.4), ("difference", 0.2)] {
        let ci95 = &changes[0]["parameters"][0][side]["ci95"];
        let end = |k: usize| ci95[k].as_f64().unwrap();
        assert!(end(0) < truth && truth < end(1), "{side}: {ci95}");
    }
    let held_out = &changes[0]["held_out"];
    assert!(held_out["changed"].as_f64() < held_out["same"].as_f64(), "{held_out}");
    let page = std::fs::read_to_string(folder.join("moved/compare.html")).unwrap();
    assert!(page.contains("thermal_zero_drift changed") && page.contains("<svg"));
}

#[test]
fn an_effect_that_each_recording_names_differently_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "init --out mirror.toml -q");
    for (name, seed, width) in [("then.csv", 31, 0.55), ("now.csv", 1031, 0.95)] {
        let device = format!("--protocol calibration --seed {seed} --device-seed 31");
        run(folder, &format!("record {device} --effect backlash:half_width_arcsec={width} --out {name} -q"));
    }
    let text = run(folder, "compare then.csv now.csv --mirror mirror.toml --out moved --json");
    let moved: Value = serde_json::from_str(&text).unwrap();
    // A small play looks like a hysteresis: what this test is about.
    assert_eq!(
        (&moved["then"]["effects"][0], &moved["now"]["effects"][0]),
        (&"hysteresis".into(), &"backlash".into())
    );
    let changes = moved["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{moved}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"backlash".into(), &"moved".into()));
    for (side, truth) in [("then", 0.55), ("now", 0.95)] {
        let ci95 = &changes[0]["parameters"][0][side]["ci95"];
        let end = |k: usize| ci95[k].as_f64().unwrap();
        assert!(end(0) < truth && truth < end(1), "{side}: {ci95}");
    }
}

/// At one angle of a coarse schedule neither the place nor the width of a defect is determined: a change of these must not be
/// taken for its height.
#[test]
fn a_defect_that_came_where_few_readings_show_it_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "init --out mirror.toml -q");
    for seed in [3, 4, 5] {
        record_mirror(folder, &format!("--seed {seed} --schedule fine --out then.csv"));
        let defect = "--effect local_defect:height_arcsec=2,centre_deg=0.7,width_deg=0.08";
        record_mirror(folder, &format!("--seed 10{seed} --schedule coarse {defect} --out now.csv"));
        let text = run(folder, "compare then.csv now.csv --mirror mirror.toml --out came --json");
        let came: Value = serde_json::from_str(&text).unwrap();
        let change = &came["changes"][0];
        assert_eq!(change["id"], "local_defect", "{seed}: {came}");
        // Twice what it adds to the readings at most.
        let rms = change["rms"].as_f64().unwrap();
        assert!((0.2..1.0).contains(&rms), "{seed}: {rms}");
    }
}

/// The earlier recording was taken within a kelvin, at another mean temperature than the later one, where the drift is so far
/// out of the noise that a form with more coefficients takes its place.
#[test]
fn an_effect_that_came_at_another_temperature_is_named_and_no_change_of_the_gain() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "init --out mirror.toml -q");
    record_mirror(folder, "--seed 3 --temperature lab --out then.csv");
    let drift = "--effect thermal_gain_drift:coefficient_ppm_per_k=400";
    record_mirror(folder, &format!("--seed 13 --schedule fine --temperature chamber {drift} --out now.csv"));
    let text = run(folder, "compare then.csv now.csv --mirror mirror.toml --out came --json");
    let came: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(came["now"]["effects"][0], "empirical_1", "what this test is about: {came}");
    let changes = came["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{came}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"thermal_gain_drift".into(), &"came".into()));
    let then = &changes[0]["parameters"][0]["then"]["ci95"];
    assert!(then[0].as_f64() < Some(0.0) && then[1].as_f64() > Some(0.0), "{then}");
}

/// A wide defect looks like a part of the base to a recording by itself; the base of both tells them apart.
#[test]
fn a_defect_that_no_recording_shows_by_itself_is_named_by_both() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "init --out mirror.toml -q");
    let record =
        |rest: &str| run(folder, &format!("record --protocol calibration --device-seed 3 -q {rest}"));
    record("--seed 3 --out then.csv");
    let defect = "--effect local_defect:height_arcsec=2,centre_deg=1.3,width_deg=0.25";
    record(&format!("--seed 13 --schedule fine {defect} --out now.csv"));
    let text = run(folder, "compare then.csv now.csv --mirror mirror.toml --out came --json");
    let came: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(came["now"]["effects"].as_array().unwrap().len(), 0, "what this test is about: {came}");
    let changes = came["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{came}");
    // Whether it came or went the base of unknown shape hides.
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"local_defect".into(), &"moved".into()));
    assert!(changes[0]["parameters"][0].get("now").is_none(), "{came}");
    let parameters =
        [("height_arcsec", "difference", 2.0), ("centre_deg", "now", 1.3), ("width_deg", "now", 0.25)];
    for (name, side, truth) in parameters {
        let all = changes[0]["parameters"].as_array().unwrap();
        let ci95 = &all.iter().find(|p| p["name"] == name).unwrap()[side]["ci95"];
        let end = |k: usize| ci95[k].as_f64().unwrap();
        assert!(end(0) < truth && truth < end(1), "{name}: {ci95}");
    }
}

/// A folder with the plant of a mirror in motion.
fn of_a_mirror_in_motion() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let plant = "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\n";
    std::fs::write(folder.path().join("plant.toml"), plant).unwrap();
    folder
}

/// What is said of two recordings of a mirror in motion, given by options of `excite`.
fn compared_in_motion(device_seed: u32, then: &str, now: &str) -> Value {
    let folder = of_a_mirror_in_motion();
    let folder = folder.path();
    for (name, options) in [("then.csv", then), ("now.csv", now)] {
        run(folder, &format!("excite --device-seed {device_seed} {options} --out {name} -q"));
    }
    let text = run(folder, "compare then.csv now.csv --plant plant.toml --out new --json");
    serde_json::from_str(&text).unwrap()
}

/// Driven otherwise, a mechanism is the same; a dry friction that moved is told from its damping.
#[test]
fn in_motion_a_moved_parameter_is_named_and_an_unchanged_mechanism_is_not() {
    let folder = of_a_mirror_in_motion();
    let folder = folder.path();
    let record = |name: &str, rest: &str, force: f64| {
        let friction = format!("--effect coulomb_friction:force_per_inertia={force}");
        run(folder, &format!("excite --device-seed 7 --samples 6144 {rest} {friction} --out {name} -q"));
    };
    record("then.csv", "--seed 1", 20_000.0);
    record("same.csv", "--seed 2 --excitation sweep", 20_000.0);
    record("now.csv", "--seed 3 --excitation sweep", 24_000.0);
    let compared = |now: &str| -> Value {
        let text = run(folder, &format!("compare then.csv {now} --plant plant.toml --out new --json"));
        serde_json::from_str(&text).unwrap()
    };
    let same = compared("same.csv");
    assert_eq!(same["verdict"], "unchanged", "{same}");
    let moved = compared("now.csv");
    let changes = moved["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{moved}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"coulomb_friction".into(), &"moved".into()));
    for (side, truth) in [("then", 20_000.0), ("now", 24_000.0), ("difference", 4000.0)] {
        let ci95 = &changes[0]["parameters"][0][side]["ci95"];
        let end = |k: usize| ci95[k].as_f64().unwrap();
        assert!(end(0) < truth && truth < end(1), "{side}: {ci95}");
    }
    let held_out = &changes[0]["held_out"];
    assert!(held_out["changed"].as_f64() < held_out["same"].as_f64(), "{held_out}");
}

/// A drag that came, too weak to be named in its own recording, is told from damping that moved.
#[test]
fn in_motion_a_weak_effect_that_came_is_no_change_of_damping() {
    let folder = of_a_mirror_in_motion();
    let folder = folder.path();
    let record = |rest: &str| run(folder, &format!("excite --device-seed 7 {rest} -q"));
    record("--seed 1 --out then.csv");
    record("--seed 2 --effect quadratic_damping:coefficient=1e-8 --out now.csv");
    run(folder, "diagnose now.csv --plant plant.toml --out alone -q --no-report");
    let json = |name: &str| -> Value {
        serde_json::from_str(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap()
    };
    assert_eq!(json("alone/now.json")["effects"], Value::Array(Vec::new()));
    run(folder, "compare then.csv now.csv --plant plant.toml --out new -q");
    let compared = json("new/compare.json");
    let changes = compared["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{compared}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"quadratic_damping".into(), &"came".into()));
    let ci95 = &changes[0]["parameters"][0]["difference"]["ci95"];
    assert!(ci95[0].as_f64().unwrap() < 1e-8 && 1e-8 < ci95[1].as_f64().unwrap(), "{ci95}");
}

/// A drive that is straight between its samples and half a sample late is nearly one that is held, which is no change.
#[test]
fn in_motion_a_held_drive_is_no_delay_that_came() {
    let compared = compared_in_motion(9, "--seed 1", "--seed 2 --excitation sweep");
    assert_eq!(compared["verdict"], "unchanged", "{compared}");
}

/// By one excitation a lag of the drive is named a lag, by another a delay.
#[test]
fn in_motion_a_lag_with_another_name_in_each_recording_is_no_change() {
    let record = |excitation: &str| {
        format!(
            "--seed 15 --excitation {excitation} --samples 6144 --effect drive_lag:time_constant_s=0.0002"
        )
    };
    let compared = compared_in_motion(5, &record("multisine"), &record("sweep"));
    let effects = |side: &str| compared[side]["effects"].clone();
    assert_ne!(effects("then"), effects("now"), "{compared}");
    assert_eq!(compared["verdict"], "unchanged", "{compared}");
}

/// By its own recording a lag that came is a delay, beside which the gain would have changed; both together tell.
#[test]
fn in_motion_a_lag_that_came_is_told_from_a_delay() {
    let lag = "--seed 15 --excitation sweep --samples 6144 --effect drive_lag:time_constant_s=0.0002";
    let compared = compared_in_motion(5, "--seed 14 --samples 6144", lag);
    assert_eq!(compared["now"]["effects"], serde_json::json!(["transport_delay"]));
    let changes = compared["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{compared}");
    let named = |id: &str| changes[0]["id"] == id || changes[0]["alternatives"][0] == id;
    assert!(named("drive_lag") && named("sensor_lag"), "{compared}");
    assert_eq!(changes[0]["kind"], "came");
    assert!(changes[0]["parameters"][0]["then"].is_null(), "{compared}");
}

/// A limit of the drive changes nothing while it is not reached, so that nothing about a model without it shows it.
#[test]
fn in_motion_a_limit_that_came_is_named() {
    let compared = compared_in_motion(7, "--seed 1", "--seed 2 --effect drive_saturation:limit=0.05");
    let changes = compared["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{compared}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"drive_saturation".into(), &"came".into()));
    let limit = &changes[0]["parameters"][0];
    assert!(limit["then"].is_null() && limit["difference"].is_null(), "{limit}");
    let now = limit["now"]["value"].as_f64().unwrap();
    assert!((now - 0.05).abs() < 1e-4, "{limit}");
}

/// A recording without a hysteresis says nothing of its yield: to first order damping seemed to explain more.
#[test]
fn in_motion_a_hysteresis_that_came_is_no_change_of_damping() {
    let hysteresis = "--effect bouc_wen_hysteresis:stiffness=12,yield=524";
    let of = |seed: u32| format!("--seed {seed} --samples 16384");
    let compared = compared_in_motion(9, &of(1), &format!("{} {hysteresis}", of(2)));
    let changes = compared["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{compared}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"bouc_wen_hysteresis".into(), &"came".into()));
    let stiffness = &changes[0]["parameters"][0]["now"]["ci95"];
    assert!(stiffness[0].as_f64() < Some(12.0) && Some(12.0) < stiffness[1].as_f64(), "{stiffness}");
    // The recording without it says nothing of its yield.
    let yields = &changes[0]["parameters"][1];
    assert!(
        yields["then"].is_null() && yields["difference"].is_null() && !yields["now"].is_null(),
        "{yields}"
    );
}

/// In a model that both have in common the frequency of a weak mode is a compromise, about which stiffness seems to explain more.
#[test]
fn in_motion_a_weak_mode_that_came_is_no_change_of_stiffness() {
    let of = |rest: &str| format!("--samples 8192 --noise autocorrelated {rest}");
    let mode = "--seed 2 --effect flexible_mode:frequency_hz=8.6,mass_ratio=0.0003";
    let compared = compared_in_motion(7, &of("--seed 1 --excitation steps"), &of(mode));
    assert_eq!(compared["now"]["effects"], Value::Array(Vec::new()), "what this test is about");
    let changes = compared["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{compared}");
    assert_eq!((&changes[0]["id"], &changes[0]["kind"]), (&"flexible_mode".into(), &"came".into()));
    for (name, truth) in [("frequency_hz", 8.6), ("mass_ratio", 0.0003)] {
        let all = changes[0]["parameters"].as_array().unwrap();
        let ci95 = &all.iter().find(|p| p["name"] == name).unwrap()["now"]["ci95"];
        let end = |k: usize| ci95[k].as_f64().unwrap();
        assert!(end(0) < truth && truth < end(1), "{name}: {ci95}");
    }
}

/// Two tanks, the first running into the second, at 4 s a sample, pumped by steps: the outflow of the second, and how much the
/// pump gives.
fn tanks(seed: u32, outflow: f64, pump: f64) -> String {
    let mut scatter = scatter(seed);
    let (mut first, mut second, mut drive) = (3.0_f64, 4.0_f64, 0.0);
    let mut text = "t_s,drive,position\n".to_string();
    for k in 0..1000 {
        if k % 25 == 0 {
            drive = 2.5 + 0.8 * scatter().clamp(-2.0, 2.0);
        }
        text += &format!("{},{drive:.4},{:.4}\n", 4 * k, second + 0.005 * scatter());
        for _ in 0..400 {
            let between = 0.05 * first.max(0.0).sqrt();
            second += 0.01 * (between - outflow * second.max(0.0).sqrt());
            first += 0.01 * (pump * drive - between);
        }
    }
    text
}

const TANKS: &str = "\
[plant]
kind = \"equations\"
inputs = { u = \"V\" }
states = { h1 = { unit = \"m\", start = \"fit\" }, h2 = { unit = \"m\", start = \"fit\" } }
output = { y = \"h2\" }
sampling = \"held\"
[plant.equations]
h1 = \"-between * sqrt(h1) + pump * u\"
h2 = \"between * sqrt(h1) - outflow * sqrt(h2)\"
[plant.parameters]
outflow = { unit = \"m^0.5/s\", from = 0.01, to = 0.2 }
between = { unit = \"m^0.5/s\", value = 0.05 }
pump = { unit = \"m/V/s\", from = 0.001, to = 0.5 }
";

#[test]
fn in_equations_a_parameter_that_moved_is_named_and_other_steps_are_no_change() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let then = tanks(1, 0.05, 0.035);
    let (ids, same) = changes(folder, TANKS, &then, &tanks(2, 0.05, 0.035));
    assert!(ids.is_empty(), "{same}");
    // What runs out and what is pumped in show alike here, to 0.1 in −ln p: the other one is an alternative.
    for (outflow, pump, ratio) in [(0.0505, 0.035, 1.01), (0.05, 0.0345, 0.035 / 0.0345)] {
        let (ids, moved) = changes(folder, TANKS, &then, &tanks(3, outflow, pump));
        let change = &moved["changes"][0];
        let mut either = [ids[0].as_str(), change["alternatives"][0].as_str().unwrap()];
        either.sort_unstable();
        assert_eq!((ids.len(), &either[..]), (1, &["outflow", "pump"][..]), "{moved}");
        let of = |side: &str| change["parameters"][0][side]["value"].as_f64().unwrap();
        let found = if ids[0] == "outflow" { of("now") / of("then") } else { of("then") / of("now") };
        assert!((found - ratio).abs() < 1e-3, "{moved}");
    }
}

/// Nearly normal numbers.
fn scatter(seed: u32) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        let mut sum = 0.0;
        for _ in 0..12 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += f64::from(state) / f64::from(u32::MAX);
        }
        sum - 6.0
    }
}

/// A drive in its position loop, 8 s at 1 kHz: its inertia, its friction, how far and how often it goes to and fro.
fn drive_in_its_loop(seed: u32, [inertia, friction]: [f64; 2], stroke: f64, hz: f64) -> String {
    let mut scatter = scatter(seed);
    let (mut x, mut v) = (0.0, 0.0);
    let mut text = "t_s,drive,position,command\n".to_string();
    for k in 0..8000 {
        let t = f64::from(k) * 1e-3;
        let command = stroke * (std::f64::consts::TAU * hz * t).sin();
        let read = x + 2e-6 * scatter();
        let drive = 4000.0 * (command - read) - 80.0 * v;
        text += &format!("{t:.3},{drive:.6},{read:.9},{command:.9}\n");
        for _ in 0..20 {
            v += 5e-5 / inertia * (drive - 2.0 * v - friction * f64::tanh(v / 1e-3));
            x += 5e-5 * v;
        }
    }
    text
}

const DRIVE: &str = "\
[plant]
kind = \"second-order\"
position_unit = \"m\"
drive_unit = \"N\"
feedback = \"command\"
";

/// The changes between two recordings of a plant: their ids, and the page's figures.
fn changes(folder: &Path, plant: &str, then: &str, now: &str) -> (Vec<String>, Value) {
    std::fs::write(folder.join("then.csv"), then).unwrap();
    std::fs::write(folder.join("now.csv"), now).unwrap();
    std::fs::write(folder.join("plant.toml"), plant).unwrap();
    let answer = run(folder, "compare then.csv now.csv --plant plant.toml --out new --json");
    let answer: Value = serde_json::from_str(&answer).unwrap();
    let ids = answer["changes"].as_array().unwrap().iter().map(|c| c["id"].as_str().unwrap().to_string());
    (ids.collect(), answer)
}

#[test]
fn under_feedback_worn_friction_is_named_and_another_motion_is_no_change() {
    let folder = tempfile::tempdir().unwrap();
    let then = drive_in_its_loop(1, [1.0, 0.4], 0.1, 0.5);
    let changes = |now: &str| changes(folder.path(), DRIVE, &then, now);
    let (ids, same) = changes(&drive_in_its_loop(2, [1.0, 0.4], 0.1, 0.5));
    assert!(ids.is_empty(), "{same}");
    let (ids, other) = changes(&drive_in_its_loop(3, [1.0, 0.4], 0.07, 0.8));
    assert!(ids.is_empty(), "{other}");
    let (ids, worn) = changes(&drive_in_its_loop(4, [1.0, 0.44], 0.1, 0.5));
    assert_eq!(ids, ["coulomb_friction"], "{worn}");
    assert_eq!(worn["changes"][0]["place"]["variable"], "velocity");
    let difference = &worn["changes"][0]["parameters"][0]["difference"]["ci95"];
    let end = |k: usize| difference[k].as_f64().unwrap();
    assert!(end(0) < 0.04 && 0.04 < end(1), "{difference}");
}

/// Every parameter is per inertia. A load that came changes them all, and is one change.
#[test]
fn under_feedback_a_load_that_came_is_one_change() {
    let folder = tempfile::tempdir().unwrap();
    let then = drive_in_its_loop(1, [1.0, 0.4], 0.1, 0.5);
    let (ids, loaded) = changes(folder.path(), DRIVE, &then, &drive_in_its_loop(2, [1.2, 0.4], 0.1, 0.5));
    assert_eq!(ids, ["inertia"], "{loaded}");
    assert_eq!(loaded["changes"][0]["place"]["variable"], "acceleration");
    let ratio = &loaded["changes"][0]["parameters"][0]["difference"]["ci95"];
    let end = |k: usize| ratio[k].as_f64().unwrap();
    assert!(end(0) < 1.2 && 1.2 < end(1), "{ratio}");
}

/// A drive and its load, to and fro with rests, 10 s at 1 kHz.
fn to_and_fro(seed: u64, carriage: &Carriage) -> String {
    let actuator = Actuator {
        lag_s: 5e-4,
        noise_m: 1e-6,
        gain: 1.0,
        ripple_n: [0.0; 3],
        phases_rad: [0.0; 3],
        ripple_m: 0.1,
    };
    // A second's move, smooth at both ends, and a rest.
    let travelled = |part: f64| 0.08 * (part - (std::f64::consts::TAU * part).sin() / std::f64::consts::TAU);
    let command = |k: usize| match (k / 1250 % 2, (k % 1250) as f64 / 1000.0) {
        (0, part) => travelled(part.min(1.0)),
        (_, part) => 0.08 - travelled(part.min(1.0)),
    };
    let command: Vec<f64> = (0..10_000).map(command).collect();
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    let rows = drive_loop::run(carriage, &actuator, &command, &mut generator);
    let line = |(k, row): (usize, &drive_loop::Sample)| {
        format!("{:.3},{:.6},{:.9},{:.9}\n", k as f64 * 1e-3, row.drive_n, row.position_m, row.command_m)
    };
    let rows: String = rows.iter().enumerate().map(line).collect();
    format!("t_s,drive,position,command\n{rows}")
}

#[test]
fn under_feedback_a_play_and_a_worn_place_are_named_and_rests_are_no_change() {
    let folder = tempfile::tempdir().unwrap();
    let load = Load { mass_kg: 0.5, dry_n: 0.3, play_m: 0.0 };
    let healthy = Carriage {
        mass_kg: 0.5,
        viscous: 2.0,
        dry_n: 0.2,
        low_speed_n: 0.0,
        offset_n: 0.1,
        spring_n_per_m: 0.0,
        cogging_n: 0.0,
        period_m: 0.025,
        worn_n: 0.0,
        worn_at_m: 0.03,
        worn_width_m: 0.004,
        load: Some(load),
    };
    let then = to_and_fro(1, &healthy);
    let changes = |now: &Carriage| changes(folder.path(), DRIVE, &then, &to_and_fro(2, now));
    let (ids, same) = changes(&healthy);
    assert!(ids.is_empty(), "{same}");
    let (ids, loose) = changes(&Carriage { load: Some(Load { play_m: 3e-4, ..load }), ..healthy });
    assert_eq!(ids.first().map(String::as_str), Some("backlash"), "{loose}");
    let (ids, worn) = changes(&Carriage { worn_n: 0.3, ..healthy });
    assert_eq!(ids, ["local_friction"], "{worn}");
    let centre = &worn["changes"][0]["parameters"][1];
    assert!((centre["now"]["value"].as_f64().unwrap() - 0.03).abs() < 5e-4, "{centre}");
}

/// A real drive: its first half against its second, and with a tenth more friction concealed in the second.
#[test]
fn friction_concealed_in_a_recording_of_a_real_drive_is_named_alone() {
    let Ok(folder) = std::env::var("ARCSMITH_RECORDINGS") else {
        println!("skipped: set ARCSMITH_RECORDINGS to a folder with emps-train.csv.gz");
        return;
    };
    let file = std::fs::File::open(Path::new(&folder).join("emps-train.csv.gz")).unwrap();
    let mut text = String::new();
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let (head, rows) = (rows[0].join(","), &rows[1..]);
    let part = |rows: &[Vec<&str>], force: f64| {
        let position: Vec<f64> = rows.iter().map(|row| row[2].parse().unwrap()).collect();
        let row = |k: usize| {
            let (before, after) = (k.saturating_sub(8), (k + 8).min(rows.len() - 1));
            let speed = (position[after] - position[before]) / (1e-3 * (after - before) as f64);
            let drive = rows[k][1].parse::<f64>().unwrap() + force * f64::tanh(speed / 1e-3);
            format!("{},{drive:.6},{},{}\n", rows[k][0], rows[k][2], rows[k][3])
        };
        format!("{head}\n") + &(0..rows.len()).map(row).collect::<String>()
    };
    let (first, second) = rows.split_at(rows.len() / 2);
    let folder = tempfile::tempdir().unwrap();
    let (ids, same) = changes(folder.path(), DRIVE, &part(first, 0.0), &part(second, 0.0));
    assert!(ids.is_empty(), "{same}");
    // Its own friction is 20.4 N, its mass 95 kg.
    let (ids, worn) = changes(folder.path(), DRIVE, &part(first, 0.0), &part(second, 2.04));
    assert_eq!(ids, ["coulomb_friction"], "{worn}");
    let difference = &worn["changes"][0]["parameters"][0]["difference"]["ci95"];
    let end = |k: usize| difference[k].as_f64().unwrap();
    assert!(end(0) < 2.04 / 95.0 && 2.04 / 95.0 < end(1), "{difference}");
}

#[test]
fn recordings_without_a_common_range_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let table = |from: f64| {
        let row = |i: i32| {
            let at = from + f64::from(i % 21) * 0.1;
            format!("{i},{},{at},{}\n", i / 21, at + 1e-4 * f64::from(i * i % 7))
        };
        "t_s,pass,measured,reference\n".to_string() + &(0..126).map(row).collect::<String>()
    };
    std::fs::write(folder.join("a.csv"), table(0.0)).unwrap();
    std::fs::write(folder.join("b.csv"), table(5.0)).unwrap();
    run(folder, "init --kind direct --out direct.toml -q");
    let output = arcsmith(folder, "compare a.csv b.csv --mirror direct.toml --out new");
    let message = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("b.csv") && message.contains("too little in common"), "{message}");
    assert!(!folder.join("new").exists());
}
