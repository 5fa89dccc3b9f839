//! Text, numbers and arguments that mean harm, through the programs: each ends with exit code 2 and one message that
//! holds nothing a terminal obeys, and nothing is written.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

fn arcsmith(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_arcsmith"));
    command.current_dir(folder);
    command
}

fn run(folder: &Path, line: &str) -> Output {
    arcsmith(folder).args(line.split_whitespace()).output().unwrap()
}

/// The message of a refusal, which must be one, and plain.
fn refusal(what: &str, output: &Output) -> String {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(2), "{what}: {said}");
    assert!(!said.contains("panicked"), "{what}: {said}");
    assert!(!said.chars().any(acts), "{what}: {said:?}");
    assert!(said.chars().count() < 4000, "{what}: {} characters", said.chars().count());
    said
}

/// Whether a terminal or a page may obey it: controls but for the line feed, and marks of direction.
fn acts(c: char) -> bool {
    c.is_control() && c != '\n'
        || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}')
}

/// A direct sensor's coefficients with one term of every kind that has numbers of its own.
fn coefficients() -> Value {
    let term = |effect: &str, operator: Value, coefficients: Value| json!({"effect": effect, "scope": "device", "operator": operator, "coefficients": coefficients});
    json!({
        "schema": "arcsmith-coefficients", "version": 1, "tool": "by hand", "command": "by hand",
        "recording": {"file": "scan.csv", "sha256": "", "rows": 1, "passes": 1},
        "sensor": {"kind": "direct", "unit": "mm"},
        "units": {"reading": "mm", "error": "mm", "statistics": "mm"},
        "valid_range": {"variable": "measured", "from": -10.0, "to": 10.0},
        "base": {"order": 1, "centre": 0.0, "coefficients": [0.01, 0.002],
                 "extrapolation": {"constant": 0.01, "slope": 0.002}},
        "terms": [
            term("drift", json!({"kind": "product", "factors": [{"observable": "temperature_c", "mean": 22.0, "power": 1}]}), json!([0.001])),
            term("lagging", json!({"kind": "lag", "observable": "temperature_c", "time_constant_s": 60.0, "mean": 22.0}), json!([0.001])),
            term("screw", json!({"kind": "periodic", "period": 2.0, "harmonics": [1]}), json!([0.001, 0.0])),
            term("defect", json!({"kind": "gaussian", "observable": "measured", "centre": 1.0, "width": 2.0}), json!([0.001])),
            term("warm", json!({"kind": "exponential", "observable": "temperature_c", "start": 16.0, "scale": 5.0}), json!([0.001])),
            term("slack", json!({"kind": "play", "observable": "measured", "elements": [{"half_width": 0.1}]}), json!([0.001])),
        ],
        "observed": {"temperature_c": [15.0, 35.0], "t_s": [0.0, 780.0]},
    })
}

const GENERATE: &str = "generate --coefficients c.json --format q31 --out new --bound 0.01mm --period-s 0.001 \
                        --further temperature_c=15..35";

/// The coefficients are sound as they are, so that each change below is what is refused.
#[test]
fn the_coefficients_are_accepted_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("c.json"), coefficients().to_string()).unwrap();
    let output = run(folder.path(), GENERATE);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn coefficients_with_hostile_text_or_numbers_are_refused_by_apply_and_generate() {
    let text = |field, value: &str, says| (field, json!(value), says);
    let long = "x".repeat(200);
    let cases: Vec<(&str, Value, &str)> = vec![
        text("/terms/0/effect", "*/ int evil; /*", "`terms[0].effect` holds `*/`"),
        text("/terms/0/effect", "a\u{202e}b", "`terms[0].effect` holds the character U+202E"),
        text("/terms/0/effect", "a\nb", "holds the character U+000A"),
        text("/terms/0/effect", &long, "`terms[0].effect` has 200 characters, at most 120"),
        text("/terms/0/operator/factors/0/observable", "t\u{0}", "observable` holds the character U+0000"),
        text("/sensor/unit", "mm*/", "`sensor.unit` holds `*/`"),
        text("/recording/file", "\u{1b}[31m", "`recording.file` holds the character U+001B"),
        text("/recording/sha256", "\u{2066}", "`recording.sha256` holds the character U+2066"),
        text("/command", "a\rb", "`command` holds the character U+000D"),
        ("/observed", json!({"\u{7}": [1.0, 2.0]}), "U+0007"),
        ("/valid_range/to", json!(1e300), "`valid_range` is 1e300, expected"),
        ("/valid_range/to", json!(-9.999_999_999_999_998), "`valid_range` runs from"),
        ("/base/centre", json!(-1e300), "`base.centre` is -1e300"),
        ("/base/coefficients/1", json!(1e200), "`base.coefficients[1]` adds 1.0e201"),
        ("/base/extrapolation/slope", json!(1e200), "`base.extrapolation.slope` adds"),
        ("/observed/t_s/1", json!(1e300), "`observed.t_s` is 1e300"),
        ("/terms/0/coefficients/0", json!(1e300), "`product` of drift: `coefficients` is 1e300"),
        ("/terms/0/operator/factors/0/mean", json!(1e300), "`mean` is 1e300"),
        ("/terms/1/operator/time_constant_s", json!(1e300), "`lag` of lagging: `time_constant_s` is 1e300"),
        ("/terms/1/operator/time_constant_s", json!(1e-300), "`time_constant_s` is 1e-300"),
        ("/terms/1/operator/time_constant_s", json!(1e12), "expected 7.8e8 at most"),
        ("/terms/2/operator/period", json!(1e20), "`periodic` of screw: `period` is 1e20"),
        ("/terms/3/operator/width", json!(1e-300), "`width` is 1e-300"),
        ("/terms/3/operator/centre", json!(1e300), "`centre` is 1e300"),
        ("/terms/4/operator/scale", json!(1e300), "`scale` is 1e300"),
        ("/terms/5/operator/elements/0/half_width", json!(1e-300), "`half_width` is 1e-300"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let scan = (0..50).map(|i| format!("{i},{},{}\n", i % 20 - 10, 20 + i % 10)).collect::<String>();
    fs::write(folder.path().join("scan.csv"), format!("t_s,measured,temperature_c\n{scan}")).unwrap();
    for (field, value, says) in cases {
        let mut file = coefficients();
        *file.pointer_mut(field).unwrap() = value;
        fs::write(folder.path().join("c.json"), file.to_string()).unwrap();
        for line in [GENERATE, "apply scan.csv --coefficients c.json --out new"] {
            let said = refusal(field, &run(folder.path(), line));
            assert!(said.contains(says), "{field}: {says}: {said}");
            assert!(!folder.path().join("new").exists(), "{field}: something was written");
        }
    }
}

#[test]
fn options_that_no_sensor_has_are_refused_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = coefficients();
    file["terms"].as_array_mut().unwrap().truncate(2);
    fs::write(folder.path().join("c.json"), file.to_string()).unwrap();
    for (given, says, by) in [
        ("--full-scale 1e-300", "the full scale is 1e-300", "(give --full-scale)"),
        ("--full-scale inf", "the full scale is inf", "(give --full-scale)"),
        ("--input counts --gain 1e-300", "the gain is 1e-300", "(give --gain)"),
        ("--input counts --gain 0.001 --offset 1e300", "the count of zero is 1e300", "(give --offset)"),
        ("--extrapolate --from -1e300 --to 1e300", "the range is -1e300", "(give --from, --to)"),
        ("--extrapolate --from 1 --to 1.0000000000000002", "the range runs from", "(give --from, --to)"),
        ("--name stdint", "stdint cannot be taken: this is a header", "(give --name)"),
        ("--name Math", "Math cannot be taken: this is a header", "(give --name)"),
        ("--name abs", "the C library", "(give --name)"),
        ("--name limit", "inside the generated files", "(give --name)"),
        ("--name a__b", "reserved", "(give --name)"),
        ("--name _a", "not an identifier", "the name"),
        ("--name int", "not an identifier", "the name"),
        ("--table 2x2147483648", "segments", "(give --table)"),
        ("--table 2x4294967296", "--table 2x4294967296", ""),
        ("--degree 18446744073709551615", "the degree is", "(give --degree)"),
        ("--input counts --gain 1 --bits 4294967295", "4294967295 bits", "(give --bits)"),
    ] {
        let said = refusal(given, &run(folder.path(), &format!("{GENERATE} {given}")));
        assert!(said.contains(says) && said.contains(by), "{given}: {says}: {said}");
    }
    for (given, says, by) in [
        (
            "--period-s 1e-300 --further temperature_c=15..35",
            "between two calls is 1e-300",
            "(give --period-s)",
        ),
        (
            "--period-s 1 --further temperature_c=0..1e300",
            "the range of temperature_c is 1e300",
            "(give --further)",
        ),
        (
            "--period-s 1 --further temperature_c=15..35:counts:12:1e-300:0",
            "the gain of temperature_c is 1e-300",
            "(give --further)",
        ),
        (
            "--period-s 1 --further temperature_c=15..35:counts:12:1:1e300",
            "the count of zero of temperature_c is 1e300",
            "(give --further)",
        ),
        ("--bound 1e-300mm", "the bound is 1e-300", "(give --bound)"),
    ] {
        let line = format!("generate --coefficients c.json --format q31 --out new --extrapolate {given}");
        let said = refusal(given, &run(folder.path(), &line));
        assert!(said.contains(says) && said.contains(by), "{given}: {says}: {said}");
    }
    assert!(!folder.path().join("new").exists());
}

#[test]
fn columns_that_act_are_refused_where_they_are_read() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mirror.toml"), "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n").unwrap();
    let header = |name: &str| format!("t_s,pass,direction,measured,reference,{name}\n0,0,1,1,1,1\n");
    let long = "y".repeat(100_000);
    for (name, says) in [
        ("a\u{202e}b", "column 6, `a\\u{202e}b`, holds the character U+202E; rename"),
        ("\u{1b}[2J", "U+001B"),
        ("x\0y", "U+0000"),
        ("*/ int evil; /*", "holds `*/`"),
        (&long, "has 100000 characters, at most 120"),
    ] {
        fs::write(folder.path().join("bad.csv"), header(name)).unwrap();
        for line in ["fit bad.csv --mirror mirror.toml", "diagnose bad.csv --mirror mirror.toml --out new"] {
            let said = refusal(name, &run(folder.path(), line));
            assert!(said.contains("bad.csv, line 1") && said.contains(says), "{says}: {said}");
        }
    }
    let plant = "[plant]\nkind = \"second-order\"\nposition_unit = \"a\\u202Eb\"\ndrive_unit = \"A\"\n";
    fs::write(folder.path().join("plant.toml"), plant).unwrap();
    let said =
        refusal("unit", &run(folder.path(), "simulate --plant plant.toml --drive bad.csv --out new.csv"));
    assert!(said.contains("`plant.position_unit` is") && said.contains("U+202E"), "{said}");
    // A cell is shown by its beginning.
    fs::write(folder.path().join("bad.csv"), header("t").replace("1,1\n", &format!("\u{1b}{long},1\n")))
        .unwrap();
    let said = refusal("cell", &run(folder.path(), "fit bad.csv --mirror mirror.toml"));
    assert!(said.contains("`\\u{1b}yyyy") && said.contains("y…`"), "{said}");
}

/// A file may be called anything: it is named escaped.
#[test]
fn a_file_with_a_hostile_name_is_named_escaped_wherever_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a\u{1b}[31m\u{202e}<script>&\n*.csv";
    let escaped = "a\\u{1b}[31m\\u{202e}<script>&\\u{a}*.csv";
    assert!(run(folder.path(), "record --protocol calibration --seed 7 --out cal.csv").status.success());
    fs::rename(folder.path().join("cal.csv"), folder.path().join(name)).unwrap();
    let mirror = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";
    fs::write(folder.path().join("mirror.toml"), mirror).unwrap();
    let with_file = |before: &str, after: &str| {
        let words = before.split_whitespace().chain([name]).chain(after.split_whitespace());
        let output = arcsmith(folder.path()).args(words).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8(said).unwrap();
        assert!(!said.chars().any(acts), "{said:?}");
    };
    with_file("fit", "--mirror mirror.toml --out c.json");
    with_file("report", "--mirror mirror.toml --out r.html --overview o.svg");
    with_file("apply", "--coefficients c.json --out a.csv");
    with_file("generate --recording", "--mirror mirror.toml --out made --format q31");
    let read = |path: &str| fs::read_to_string(folder.path().join(path)).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&read("c.json")).unwrap()["recording"]["file"], escaped);
    for made in [
        "r.html",
        "o.svg",
        "made/c/corrected_angle.c",
        "made/src/corrected_angle_q31.rs",
        "made/certificate.json",
    ] {
        let text = read(made);
        assert!(!text.chars().any(acts) && !text.contains("<script>&\u{a}"), "{made}");
    }
    assert!(read("made/c/corrected_angle.h").contains(&format!("Recording:    {escaped}, ")));
    assert!(read("r.html").contains("&lt;script&gt;&amp;") && !read("r.html").contains("<script>"));
    let missing =
        arcsmith(folder.path()).args(["fit", "b\u{202e}", "--mirror", "mirror.toml"]).output().unwrap();
    assert!(refusal("missing", &missing).contains("b\\u{202e}: there is no such file"));
}

#[test]
fn arguments_that_are_not_text_are_taken_as_names_of_files_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("c.json"), coefficients().to_string()).unwrap();
    let odd = OsStr::from_bytes(b"b\xff");
    let call = |line: &str| arcsmith(folder.path()).args(line.split_whitespace()).arg(odd).output().unwrap();
    let output = call(&format!("{} --out", GENERATE.replace("--out new", "")));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path().join(odd).join("c/corrected_mm.c").exists());
    for line in [
        "generate --coefficients",
        "check --coefficients",
        "generate --name",
        "fit",
        "fit a.csv --mirror",
        "apply",
        "apply a.csv --coefficients",
        "diagnose",
        "report",
        "simulate",
        "trials",
        "generate --devices",
        "--",
        "record --out",
    ] {
        refusal(line, &call(line));
    }
}

/// What cannot be said is a failure, whatever it is; what nobody reads to its end is none.
#[test]
fn output_on_a_full_device_fails_and_a_closed_pipe_does_not() {
    let full = || File::options().write(true).open("/dev/full").unwrap();
    let folder = tempfile::tempdir().unwrap();
    for line in [
        "schema",
        "man",
        "completions bash",
        "effects",
        "effects --simulated --json",
        "--help",
        "--version",
        "help fit",
        "generate --demo --format q31 --out made",
        "generate --demo --format q31 --out made --json",
        "check --demo --format q31 --out made",
        "check --demo --format q31 --out made --json",
    ] {
        let mut command = arcsmith(folder.path());
        command.args(line.split_whitespace());
        let output = command.stdout(full()).output().unwrap();
        let said = refusal(line, &output);
        assert!(said.contains("standard output cannot be written (No space left"), "{line}: {said}");
        assert_eq!(
            said.matches("error: ").count() + said.matches("\"error\": {").count(),
            1,
            "{line}: {said}"
        );
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = command.stdout(writer).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{line}");
        assert!(output.status.success(), "{line}");
    }
    for line in ["fit none.csv --mirror mirror.toml", "fit", "generate --name"] {
        let status = arcsmith(folder.path()).args(line.split_whitespace()).stderr(full()).status().unwrap();
        assert_eq!(status.code(), Some(2), "{line}");
    }
}
