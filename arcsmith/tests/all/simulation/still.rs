//! The program `twin` from outside: files, messages and exit codes.

use std::path::Path;
use std::process::{Command, Output};

fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith")).args(arguments).output().unwrap()
}

fn record(out: &Path, seed: &str) -> Output {
    twin(&["record", "--protocol", "calibration", "--seed", seed, "--out", out.to_str().unwrap()])
}

#[test]
fn one_seed_is_one_file_to_the_byte_compressed_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    for (name, seed) in [("a.csv", "5"), ("b.csv", "5"), ("c.csv", "6"), ("a.csv.gz", "5"), ("b.csv.gz", "5")]
    {
        assert!(record(&file(name), seed).status.success(), "{name}");
    }
    let read = |name: &str| std::fs::read(file(name)).unwrap();
    assert_eq!(read("a.csv"), read("b.csv"));
    assert_ne!(read("a.csv"), read("c.csv"));
    assert_eq!(read("a.csv.gz"), read("b.csv.gz"));
    let mut unpacked = Vec::new();
    let packed = read("a.csv.gz");
    std::io::copy(&mut flate2::read::GzDecoder::new(&packed[..]), &mut unpacked).unwrap();
    assert_eq!(unpacked, read("a.csv"));
    // Nothing else is left behind.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
}

#[test]
fn the_embedded_default_recording_is_reproduced() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("calibration.csv");
    assert!(record(&out, "1").status.success());
    let embedded = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fitter/data/calibration.csv");
    assert!(std::fs::read(&out).unwrap() == std::fs::read(embedded).unwrap(), "fitter/data is stale");
}

#[test]
fn schedules_temperatures_noises_and_effects_are_what_they_are_called() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, options: &str| -> Vec<Vec<f64>> {
        let out = folder.path().join(name).to_str().unwrap().to_owned();
        let fixed = ["record", "--protocol", "calibration", "--seed", "3", "--out", &out];
        let output = twin(&fixed.into_iter().chain(options.split_whitespace()).collect::<Vec<_>>());
        assert!(output.status.success(), "{options}: {}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(out).unwrap();
        text.lines().skip(1).map(|line| line.split(',').map(|f| f.parse().unwrap()).collect()).collect()
    };
    let (t, command, reference, temperature) = (0, 3, 6, 8);
    let plain = run("plain.csv", "");
    assert_eq!(run("paper.csv", "--schedule paper"), plain);
    assert_eq!(run("coarse.csv", "--schedule coarse").len(), 216);
    assert_eq!(run("fine.csv", "--schedule fine").len(), 552);
    let random = run("random.csv", "--schedule random");
    let sorted = |rows: &[Vec<f64>]| {
        let mut angles: Vec<f64> = rows.iter().map(|r| r[command]).collect();
        angles.sort_by(f64::total_cmp);
        angles
    };
    assert_eq!(sorted(&random[..35]), sorted(&plain[..35]));
    assert!(random[..35].iter().zip(&plain).filter(|(a, b)| a[command] != b[command]).count() > 20);
    let scan = run("scan.csv", "--schedule scan");
    assert!(scan.windows(2).all(|w| w[1][t] > w[0][t]));
    let ramp = run("ramp.csv", "--temperature ramp");
    assert!((ramp[209][temperature] - ramp[0][temperature] - 6.0).abs() < 0.5);
    let chamber = run("chamber.csv", "--temperature chamber");
    let hottest = chamber.iter().map(|r| r[temperature]).fold(0.0, f64::max);
    assert!((39.0..42.0).contains(&hottest));
    for noise in ["autocorrelated", "heteroscedastic", "outliers"] {
        assert_ne!(run(&format!("{noise}.csv"), &format!("--noise {noise}")), plain);
    }
    let stepped = run("step.csv", "--effect mount_step:step_arcsec=5,time_s=300");
    for (with, without) in stepped.iter().zip(&plain) {
        let step = without[reference] - with[reference];
        let wanted = if without[t] >= 300.0 { 5.0 } else { 0.0 };
        // Both references are rounded to 0.001″.
        assert!((step - wanted).abs() < 2e-3, "{step} at {}", without[t]);
    }
    run(
        "several.csv",
        "--effect backlash:half_width_arcsec=1 --effect ooc_sway:amplitude_arcsec=1,period_s=200",
    );
    run("lag.csv", "--schedule scan --effect read_lag:delay_s=0.01");
    // The list shows every effect that can be asked for.
    let listing = String::from_utf8(twin(&["effects", "--simulated"]).stdout).unwrap();
    assert!(listing.contains("mount_step") && listing.contains("time_constant_s"));
}

#[test]
fn bad_input_gets_one_message_exit_code_2_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(at("folder.csv")).unwrap();
    let good = at("good.csv");
    let record = |more: &'static str| -> Vec<&str> {
        let fixed = ["--protocol", "calibration", "--seed", "1", "--out", &good];
        fixed.into_iter().chain(more.split_whitespace()).collect()
    };
    let cases: [(&[&str], &str); 15] = [
        (&["--protocol", "calibration", "--seed", "1", "--out", &at("missing/x.csv")], "cannot be written"),
        (&["--protocol", "calibration", "--seed", "1", "--out", &at("folder.csv")], "directory"),
        (&["--protocol", "calibration", "--seed", "1", "--out", &at("x.txt")], ".csv.gz"),
        (&["--protocol", "slow", "--seed", "1", "--out", &good], "verification"),
        (&["--protocol", "calibration", "--seed", "one", "--out", &good], "--seed"),
        (&["--protocol", "calibration", "--seed", "-1", "--out", &good], "-1"),
        (&["--protocol", "calibration", "--out", &good], "--seed"),
        (&["--protocol", "calibration", "--seed", "1"], "--out"),
        (&["--protocol", "verification", "--schedule", "fine", "--seed", "1", "--out", &good], "--schedule"),
        (&record("--effect backlach:half_width_arcsec=1"), "thermal_zero_drift"),
        (&record("--effect backlash:half_width_arcsec=wide"), "wide"),
        (&record("--effect mount_step:step_arcsec=1"), "time_s"),
        (&record("--effect backlash:half_width_arcsec=-1"), "1000 arcsec"),
        (&record("--effect read_lag:delay_s=0.01"), "scan"),
        (&record("--noise loud"), "outliers"),
    ];
    for (arguments, message) in cases {
        let output = twin(&[&["record"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(message), "{arguments:?} said {said}");
        assert!(output.stdout.is_empty());
    }
    // Only the folder that was made above.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
