//! What is too large is refused in one message that names the option, before memory or time are gone; pipes are read
//! like files; numbers beyond all measure reach no answer.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use flate2::{Compression, write::GzEncoder};
use serde_json::Value;

const ARCSMITH: &str = env!("CARGO_BIN_EXE_arcsmith");
const MIRROR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";
const CALIBRATION: &str = include_str!("../../../fitter/data/calibration.csv");
/// Two gigabytes of addresses: less than what the files below would fill.
const MEMORY_KIB: u32 = 2 << 20;

fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mirror.toml"), MIRROR).unwrap();
    std::fs::write(folder.path().join("cal.csv"), CALIBRATION).unwrap();
    folder
}

fn arcsmith(folder: &Path, line: &str) -> Output {
    let limited = format!("ulimit -v {MEMORY_KIB}; exec \"$0\" {line}");
    Command::new("sh").current_dir(folder).args(["-c", &limited, ARCSMITH]).output().unwrap()
}

/// Runs a command that must end in one message which says these things, and leave nothing.
fn refused(folder: &Path, line: &str, says: &[&str]) {
    let count = || std::fs::read_dir(folder).unwrap().count();
    let before = count();
    let output = arcsmith(folder, line);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {said}");
    assert!(says.iter().all(|part| said.contains(part)) && !said.contains("panicked"), "{line}: {said}");
    assert_eq!((said.matches("error: ").count(), count()), (1, before), "{line}: {said}");
}

fn accepted(folder: &Path, line: &str) {
    let output = arcsmith(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

fn packed(path: &Path, mut contents: impl Read) {
    let mut packed = GzEncoder::new(File::create(path).unwrap(), Compression::fast());
    io::copy(&mut contents, &mut packed).unwrap();
    packed.finish().unwrap();
}

#[test]
fn a_small_file_that_becomes_a_large_one_is_refused() {
    let folder = scene();
    let (folder, header) = (folder.path(), CALIBRATION.lines().next().unwrap());
    let fit = |file: &str| format!("fit {file} --mirror mirror.toml --out c.json");
    packed(&folder.join("zeros.csv.gz"), io::repeat(0).take(1_500_000_000));
    refused(folder, &fit("zeros.csv.gz"), &["zeros.csv.gz", "a line of more than", "--max-bytes"]);
    refused(folder, "diagnose zeros.csv.gz --mirror mirror.toml --out o", &["--max-bytes"]);
    let rows = format!("{header}\n{}", "0,0,1,0,0,0,0,0,0,0\n".repeat(400_000));
    packed(&folder.join("rows.csv.gz"), rows.as_bytes());
    refused(
        folder,
        &(fit("rows.csv.gz") + " --max-bytes 5000000"),
        &["rows.csv.gz", "more than 5000000 bytes, decompressed", "--max-bytes"],
    );
    let motion = format!("t_s,drive,position\n{}", "0,0,0\n".repeat(400_000));
    packed(&folder.join("motion.csv.gz"), motion.as_bytes());
    std::fs::write(
        folder.join("plant.toml"),
        "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\n",
    )
    .unwrap();
    let few = "motion.csv.gz --plant plant.toml --max-bytes 1000000 --out o";
    refused(folder, &format!("diagnose {few}"), &["--max-bytes"]);
    let few = "--drive motion.csv.gz --plant plant.toml --max-bytes 1000000 --out o.csv";
    refused(folder, &format!("simulate {few}"), &["--max-bytes"]);
    refused(folder, &(fit("cal.csv") + " --max-bytes 50"), &["mirror.toml", "--max-bytes"]);
    refused(
        folder,
        &(fit("cal.csv") + " --max-bytes 5000"),
        &["cal.csv", "more than 5000 bytes", "--max-bytes"],
    );
    refused(folder, "fit cal.csv --mirror /dev/zero --out c.json", &["/dev/zero", "--max-bytes"]);
    accepted(folder, &(fit("cal.csv") + " --max-bytes 50000"));
    refused(folder, "apply cal.csv --coefficients /dev/zero --out a.csv", &["/dev/zero", "--max-bytes"]);
    refused(folder, "generate --coefficients /dev/zero --out g", &["/dev/zero", "--max-bytes"]);
}

#[test]
fn more_columns_than_anyone_records_are_refused_until_they_are_allowed() {
    let folder = scene();
    let folder = folder.path();
    let further = |row: usize| (0..600).map(move |k| if row == 0 { format!(",c{k}_v") } else { ",1".into() });
    let wide: Vec<String> = CALIBRATION
        .lines()
        .enumerate()
        .map(|(row, line)| line.to_owned() + &further(row).collect::<String>())
        .collect();
    std::fs::write(folder.join("wide.csv"), wide.join("\n")).unwrap();
    let fit = "fit wide.csv --mirror mirror.toml --out c.json";
    refused(folder, fit, &["wide.csv", "610 columns", "at most 512", "--max-columns"]);
    accepted(folder, &format!("{fit} --max-columns 610"));
}

/// A recording through a pipe, packed or not, gives what its file gives.
#[test]
fn a_recording_is_read_from_a_pipe() {
    let folder = scene();
    let folder = folder.path();
    packed(&folder.join("cal.csv.gz"), CALIBRATION.as_bytes());
    accepted(folder, "fit cal.csv --mirror mirror.toml --out c.json");
    accepted(folder, "apply cal.csv --coefficients c.json --out a.csv");
    let expected = std::fs::read(folder.join("a.csv")).unwrap();
    for file in ["cal.csv", "cal.csv.gz"] {
        let mut child = Command::new(ARCSMITH)
            .current_dir(folder)
            .args(["apply", "/dev/stdin", "--coefficients", "c.json", "--out", "piped.csv"])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let bytes = std::fs::read(folder.join(file)).unwrap();
        child.stdin.take().unwrap().write_all(&bytes).unwrap();
        assert!(child.wait().unwrap().success());
        assert_eq!(std::fs::read(folder.join("piped.csv")).unwrap(), expected, "{file}");
    }
    let output = arcsmith(folder, "fit /dev/stdin --mirror mirror.toml --out p.json < cal.csv.gz");
    assert!(output.status.success());
    let output = arcsmith(folder, "diagnose /dev/stdin --mirror mirror.toml --out o < cal.csv");
    assert!(output.status.success() && folder.join("o/stdin.json").is_file());
}

/// Keys whose value is null, a place in a list being one without a name.
fn nulls(value: &Value, key: &str, found: &mut Vec<String>) {
    match value {
        Value::Null => found.push(key.to_owned()),
        Value::Array(list) => list.iter().for_each(|value| nulls(value, "in a list", found)),
        Value::Object(map) => map.iter().for_each(|(key, value)| nulls(value, key, found)),
        _ => {}
    }
}

/// Cells beyond all measure are refused or left out; no number of an answer is none, and no picture fails.
#[test]
fn numbers_beyond_all_measure_reach_no_answer() {
    let folder = scene();
    let folder = folder.path();
    let edited = |edit: &dyn Fn(usize, &mut Vec<String>)| -> String {
        let lines = CALIBRATION.lines().enumerate().map(|(row, line)| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            if row > 0 {
                edit(row, &mut fields);
            }
            fields.join(",")
        });
        lines.collect::<Vec<_>>().join("\n")
    };
    let all = |column: usize, text: &'static str| edited(&move |_, fields| fields[column] = text.into());
    let one = |column: usize, text: &'static str| {
        edited(&move |row, fields| {
            if row == 5 {
                fields[column] = text.into();
            }
        })
    };
    let kinds = [
        ("one reference", one(6, "1e200")),
        ("one displacement", one(4, "-1e149")),
        ("one temperature", one(8, "1e308")),
        ("all displacements", all(4, "1e149")),
        ("all references", all(6, "-1e29")),
        ("all temperatures", all(8, "1e300")),
        (
            "a gap in time",
            edited(&|row, fields| {
                if row > 100 {
                    fields[0] = format!("{}e17", row);
                }
            }),
        ),
        ("large times", edited(&|row, fields| fields[0] = format!("{}e300", row))),
    ];
    let known = ["next_experiment", "held_out", "held_out_rms", "diagnosis", "reference_accuracy_arcsec"];
    for (what, text) in kinds {
        std::fs::write(folder.join("x.csv"), text).unwrap();
        for line in [
            "diagnose x.csv --mirror mirror.toml --out o",
            "fit x.csv --mirror mirror.toml --out o/c.json",
            "report x.csv --mirror mirror.toml --out o/r.html --overview o/v.svg",
        ] {
            let output = arcsmith(folder, line);
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(matches!(output.status.code(), Some(0 | 2)), "{what}: {line}: {said}");
        }
        for entry in std::fs::read_dir(folder.join("o")).into_iter().flatten().flatten() {
            let text = std::fs::read_to_string(entry.path()).unwrap();
            if let Ok(value) = serde_json::from_str(&text) {
                let mut found = Vec::new();
                nulls(&value, "", &mut found);
                found.retain(|key| !known.contains(&key.as_str()));
                assert!(found.is_empty(), "{what}: {}: {found:?}", entry.path().display());
            } else if entry.path().extension().is_some_and(|end| end == "svg") {
                assert!(!text.contains("NaN") && !text.contains("inf"), "{what}");
            }
        }
        let _ = std::fs::remove_dir_all(folder.join("o"));
        std::fs::create_dir(folder.join("o")).unwrap();
    }
}
