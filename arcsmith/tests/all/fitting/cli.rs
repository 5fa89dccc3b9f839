//! The two commands from outside.

use std::path::Path;
use std::process::{Command, Output};

use crate::fitting::common::Device;
use crate::fitting::common::encoder::Encoder;
use fitter::Recording;
use proptest::prelude::*;

const MIRROR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith")).current_dir(folder).args(arguments).output().unwrap()
}

fn folder_with(recording: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("recording.csv"), recording).unwrap();
    std::fs::write(folder.path().join("mirror.toml"), MIRROR).unwrap();
    folder
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn fit_then_apply() {
    let folder = folder_with(&Device::paper().csv(1));
    let arguments = ["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json"];
    let output = run(folder.path(), &arguments);
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.lines().count() <= 24, "more than a screen:\n{text}");
    for word in
        ["210 readings in 6 passes", "order", "before", "after", "a1 - dd/d", "only a1 - dd/d", "c.json"]
    {
        assert!(text.contains(word), "`{word}` is not in:\n{text}");
    }
    assert!(!text.contains("diagnose"));
    let file = fitter::coefficients::read(&folder.path().join("c.json")).unwrap();
    assert_eq!(file.command, "arcsmith fit recording.csv --mirror mirror.toml --out c.json");
    assert_eq!(file.recording.sha256.len(), 64);
    assert_eq!(file.to_sealed_json(), std::fs::read_to_string(folder.path().join("c.json")).unwrap());

    let arguments = ["apply", "recording.csv", "--coefficients", "c.json", "--out", "angles.csv"];
    let output = run(folder.path(), &arguments);
    assert!(output.status.success() && output.stderr.is_empty());
    let angles = std::fs::read_to_string(folder.path().join("angles.csv")).unwrap();
    let mut lines = angles.lines();
    assert_eq!(lines.next(), Some("t_s,angle_arcsec,extrapolated"));
    let recording = Recording::read(&folder.path().join("recording.csv")).unwrap();
    let alpha0 = file.identification.unwrap().zero.unwrap().alpha0_arcsec;
    let mut rows = 0;
    for (row, line) in lines.enumerate() {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        assert_eq!((fields[0], fields[2]), (recording.time_s[row], 0.0));
        let calibrated = recording.reference(row).unwrap() - alpha0;
        approx::assert_abs_diff_eq!(fields[1], calibrated, epsilon = 3.0);
        rows += 1;
    }
    assert_eq!(rows, 210);
}

#[test]
fn a_dependence_is_said_in_one_line_that_points_to_diagnose() {
    let device = Device { extra: |_, _, temperature, _| 3.0 * (temperature - 27.0), ..Device::paper() };
    let folder = folder_with(&device.csv(2));
    let output = run(folder.path(), &["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().filter(|line| line.contains("diagnose")).collect();
    assert_eq!(lines.len(), 1, "{text}");
    assert!(lines[0].contains("temperature_c") && lines[0].contains("`diagnose recording.csv`"));
}

#[test]
fn the_same_bytes_whatever_the_number_of_threads() {
    let folder = folder_with(&Device::paper().csv(3));
    let fit = |threads: &str| {
        let status = Command::new(env!("CARGO_BIN_EXE_arcsmith"))
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .args(["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json"])
            .output()
            .unwrap()
            .status;
        assert!(status.success());
        std::fs::read(folder.path().join("c.json")).unwrap()
    };
    assert_eq!(fit("1"), fit("2"));
}

#[test]
fn what_was_noticed_while_reading_is_said() {
    let text = Device::paper().csv(4);
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    lines[0] += ",operator,humidity_percent";
    for (number, line) in lines.iter_mut().enumerate().skip(1) {
        *line += if number % 3 == 0 { ",Ann,40" } else { ",Bob," };
    }
    lines.swap(20, 21);
    let folder = folder_with(&(lines.join("\n") + "\n"));
    let output = run(folder.path(), &["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("time runs backward at line 22"), "{text}");
    assert!(text.contains("column `operator` holds no numbers"), "{text}");
    let recording = Recording::read(&folder.path().join("recording.csv")).unwrap();
    let humidity = recording.column("humidity_percent").unwrap();
    assert!(humidity[2] == 40.0 && humidity[0].is_nan());
}

/// Blank lines and a mark at the start of the file are no rows; the line in a message is that of the file.
#[test]
fn messages_count_the_lines_of_the_file() {
    let text = Device::paper().csv(5);
    let lines: Vec<&str> = text.lines().collect();
    for end in ["\n", "\r\n"] {
        let rows =
            ["\u{feff}", lines[0], end, end, lines[1], end, end, end, lines[2], end, "x", lines[2]].concat();
        for file in [rows.clone(), format!("{rows}{end}")] {
            let error = Recording::from_bytes("r.csv", file.as_bytes()).unwrap_err().to_string();
            assert!(error.contains("line 7, column `t_s`"), "{error}");
        }
    }
}

#[test]
fn selected_rows_keep_their_lines() {
    let recording = Device::paper().recording(6);
    let held_out: Vec<usize> = (0..recording.rows()).filter(|row| recording.pass[*row] == 2).collect();
    let part = recording.select(&held_out);
    assert_eq!((part.rows(), part.passes()), (35, vec![2]));
    for (index, row) in held_out.iter().enumerate() {
        assert_eq!(part.line(index), recording.line(*row));
        assert_eq!(part.reading(index), recording.reading(*row));
        assert_eq!(part.reference(index), recording.reference(*row));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// Numbers come out of the file as they were printed, compressed or not.
    #[test]
    fn numbers_survive_the_file(
        rows in prop::collection::vec((-1e3..1e3f64, -1.0..1.0f64, -1e4..1e4f64, prop::option::of(-50.0..50.0f64)), 1..40)
    ) {
        let mut text = String::from("t_s, pass ,direction,x1_mm,x2_mm,reference_arcsec,temperature_c\r\n");
        for (index, (x1, x2, reference, temperature)) in rows.iter().enumerate() {
            let temperature = temperature.map_or(String::new(), |t| t.to_string());
            text += &format!("{index},{},+1,{x1}, {x2} ,{reference},{temperature}\r\n", index / 7);
        }
        let plain = Recording::from_bytes("r.csv", text.as_bytes()).unwrap();
        for (index, (x1, x2, reference, temperature)) in rows.iter().enumerate() {
            prop_assert_eq!(plain.reading(index), x2 - x1);
            prop_assert_eq!(plain.reference(index), Some(*reference));
            if let Some(temperature) = temperature {
                prop_assert_eq!(plain.column("temperature_c").unwrap()[index], *temperature);
            }
        }
        let packed = Recording::from_bytes("r.csv.gz", &gzip(text.as_bytes())).unwrap();
        prop_assert_eq!(&packed.readings, &plain.readings);
        prop_assert_eq!(packed.passes(), plain.passes());
        prop_assert!(packed.sha256 != plain.sha256);
    }

    /// Whatever stands in a file, reading it ends in a recording or a message, and fitting it in a fit or a
    /// message.
    #[test]
    fn damage_never_panics(seed in 0..4u64, edits in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..6)) {
        let mut bytes = Device { passes: 2, ..Device::paper() }.csv(seed).into_bytes();
        for (place, byte) in edits {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = byte;
        }
        match Recording::from_bytes("r.csv", &bytes) {
            Ok(recording) => {
                let _ = fitter::fit(&recording, &crate::fitting::common::mirror(), &fitter::Options::default());
            }
            Err(error) => prop_assert!(error.to_string().starts_with("r.csv")),
        }
    }
}

#[test]
fn both_names_of_the_option_are_one() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("r.csv"), Encoder::eccentric(14).csv(360.0, 9)).unwrap();
    let mirror = "[sensor]\nkind = \"direct\"\nunit = \"deg\"\nrevolution = 360.0\n";
    std::fs::write(folder.path().join("m.toml"), mirror).unwrap();
    for option in ["--harmonics", "--turn-harmonics"] {
        let arguments = ["fit", "r.csv", "--mirror", "m.toml", option, "5", "--json"];
        let output = run(folder.path(), &arguments);
        let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(value["harmonics"], 5);
    }
}
