//! Every kind of bad input: its one message, exit code 2, nothing written.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const CALIBRATION: &str = include_str!("../../../../fitter/data/calibration.csv");
const MIRROR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";
const DIRECT: &str = "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n";

const PLANT: &str = "# a plant\n[plant]\nkind = \"linear\"\n";

/// The files of one case, and what is expected.
struct Case {
    name: &'static str,
    recording: Vec<u8>,
    /// Name of the recording's file.
    file: &'static str,
    mirror: String,
    arguments: &'static [&'static str],
    /// All of them stand in the message.
    message: &'static [&'static str],
}

fn case(name: &'static str, recording: impl Into<Vec<u8>>, message: &'static [&'static str]) -> Case {
    let (recording, mirror) = (recording.into(), MIRROR.to_string());
    Case { name, recording, file: "recording.csv", mirror, arguments: &[], message }
}

fn mirror(name: &'static str, mirror: &str, message: &'static [&'static str]) -> Case {
    Case { mirror: mirror.to_string(), ..case(name, CALIBRATION, message) }
}

/// The default recording with one field of one line (the header is line 1) replaced.
fn with(line: usize, column: &str, value: &str) -> String {
    change(|number, fields, names| {
        if number == line {
            fields[index(names, column)] = value.to_string();
        }
    })
}

/// The default recording with every value of a column changed.
fn scaled(column: &str, factor: f64) -> String {
    change(|number, fields, names| {
        if number > 1 {
            let field = &mut fields[index(names, column)];
            *field = format!("{}", field.parse::<f64>().unwrap() * factor);
        }
    })
}

fn index(names: &[String], column: &str) -> usize {
    names.iter().position(|name| name == column).unwrap()
}

fn change(mut edit: impl FnMut(usize, &mut Vec<String>, &[String])) -> String {
    let names: Vec<String> = CALIBRATION.lines().next().unwrap().split(',').map(String::from).collect();
    let mut text = String::new();
    for (number, line) in CALIBRATION.lines().enumerate() {
        let mut fields: Vec<String> = line.split(',').map(String::from).collect();
        edit(number + 1, &mut fields, &names);
        text += &(fields.join(",") + "\n");
    }
    text
}

/// The default recording without a column.
fn without(column: &str) -> String {
    change(|_, fields, names| {
        fields.remove(index(names, column));
    })
}

/// The rows of the default recording that pass a test of (pass, command_deg).
fn only(keep: impl Fn(i32, f64) -> bool) -> String {
    let kept = |line: &&str| {
        let fields: Vec<&str> = line.split(',').collect();
        keep(fields[1].parse().unwrap(), fields[3].parse().unwrap())
    };
    let mut lines = CALIBRATION.lines();
    let header = lines.next().unwrap();
    std::iter::once(header).chain(lines.filter(kept)).map(|line| format!("{line}\n")).collect()
}

fn direct(rows: &str) -> String {
    format!("t_s,pass,direction,measured,reference\n{rows}")
}

fn sweep(reference: impl Fn(f64) -> f64) -> String {
    let row = |i: i32| {
        let x = 0.1 * f64::from(i);
        format!("{i},0,1,{x},{}\n", reference(x))
    };
    direct(&(0..60).map(row).collect::<String>())
}

fn cases() -> Vec<Case> {
    let first_row = CALIBRATION.lines().nth(1).unwrap();
    let gzip_cut = {
        use std::io::Write;
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(CALIBRATION.as_bytes()).unwrap();
        let mut bytes = encoder.finish().unwrap();
        bytes.truncate(bytes.len() / 2);
        bytes
    };
    let mut latin1 = CALIBRATION.replacen("temperature_c", "temperature_XC", 1).into_bytes();
    let at = latin1.windows(2).position(|pair| pair == b"XC").unwrap();
    latin1[at] = 0xb0;
    let utf16: Vec<u8> = CALIBRATION.encode_utf16().flat_map(u16::to_le_bytes).collect();
    vec![
        case("empty file", "", &["recording.csv: is empty", "expected a header"]),
        case("header only", CALIBRATION.lines().next().unwrap(), &["has a header but no reading"]),
        case("missing column", without("x2_mm"), &["line 1", "column `x2_mm` is missing", "found `t_s`"]),
        case(
            "a column that is nearly two missing ones",
            CALIBRATION.replacen("x1_mm,x2_mm", "Probe1,X2_mm", 1),
            &["x1_mm=<your column> x2_mm=X2_mm"],
        ),
        case(
            "several missing columns",
            CALIBRATION.replacen("x1_mm,x2_mm", "left,right", 1),
            &["columns `x1_mm`, `x2_mm` are missing", "x1_mm=<your column> x2_mm=<your column>"],
        ),
        case(
            "misspelt column",
            CALIBRATION.replacen("reference_arcsec", "reference_arcsecs", 1),
            &["`reference_arcsec` is missing", "rename `reference_arcsecs`"],
        ),
        case(
            "doubled column",
            CALIBRATION.replacen("coil_a", "cross_arcsec", 1),
            &["line 1", "`cross_arcsec` stands there twice"],
        ),
        case("unnamed column", CALIBRATION.replacen("coil_a", "", 1), &["line 1", "column 10 has no name"]),
        case(
            "text in a number",
            with(7, "x1_mm", "abc"),
            &["line 7, column `x1_mm`", "found `abc`", "expected a number"],
        ),
        case(
            "text in an optional column",
            with(9, "temperature_c", "warm"),
            &["line 9, column `temperature_c`", "found `warm`"],
        ),
        case("NaN", with(8, "x2_mm", "NaN"), &["line 8, column `x2_mm`", "found `NaN`", "finite"]),
        case(
            "infinity",
            with(8, "reference_arcsec", "inf"),
            &["line 8, column `reference_arcsec`", "finite"],
        ),
        case(
            "blank in a needed column",
            with(3, "reference_arcsec", ""),
            &["line 3, column `reference_arcsec`", "is blank"],
        ),
        case(
            "row cut short",
            CALIBRATION.replacen(first_row, "2.56,1,1", 1),
            &["line 2", "found 3 fields", "10"],
        ),
        case("decimal commas", CALIBRATION.replacen("2.56,", "2,56,", 1), &["line 2", "found 11 fields"]),
        case("spaces", CALIBRATION.replace(',', " "), &["spaces", "expected commas, semicolons or tabs"]),
        case(
            "points among decimal commas",
            CALIBRATION.replace(',', ";").replace('.', ",").replacen("2,", "2.", 1),
            &["expected a decimal comma"],
        ),
        Case {
            arguments: &["--map", "x1_mm=Probe1:um"],
            ..case(
                "mapped column that is not there",
                CALIBRATION,
                &["x1_mm=Probe1 is mapped", "no such column", "(give --map)"],
            )
        },
        Case {
            arguments: &["--map", "x1_mm=x2_mm:deg"],
            ..case("unit that does not convert", CALIBRATION, &["x1_mm is mapped", "`deg`", "into mm"])
        },
        Case {
            arguments: &["--map", "x1_mm=x2_mm:parsec"],
            ..case("unit that is none", CALIBRATION, &["`parsec`", "um"])
        },
        Case {
            arguments: &["--map", "x1_mm=x2_mm", "--map", "x1_mm=x1_mm"],
            ..case("mapped twice", CALIBRATION, &["mapped twice"])
        },
        case("pass that is no whole number", with(5, "pass", "1.5"), &["line 5, column `pass`", "`1.5`"]),
        case("direction 0", with(6, "direction", "0"), &["line 6, column `direction`", "1 (forward)"]),
        case(
            "comments",
            format!("# by the bench\n#\n{}", with(7, "x1_mm", "abc").replacen('\n', "\n# begins\n", 1)),
            &["line 10, column `x1_mm`"],
        ),
        case("UTF-16", utf16, &["recording.csv: is UTF-16", "save it as UTF-8"]),
        case("mirror as recording", MIRROR, &["is a mirror file (TOML), expected a recording"]),
        case("plant as recording", PLANT, &["is a plant file (TOML), expected a recording"]),
        case("JSON as recording", "{\"a\": 1}", &["is JSON, expected a recording"]),
        mirror("UTF-16 mirror", &MIRROR.chars().flat_map(|c| [c, '\0']).collect::<String>(), &["is UTF-16"]),
        mirror("recording as mirror", CALIBRATION, &["is a recording, expected a mirror file (TOML)"]),
        mirror("plant as mirror", PLANT, &["is a plant file (TOML), expected a mirror file (TOML)"]),
        case("latin-1", latin1, &["line 1", "not UTF-8"]),
        Case { file: "recording.csv.gz", ..case("gzip cut short", gzip_cut, &["not a whole gzip file"]) },
        Case { file: "recording.csv.gz", ..case("no gzip", CALIBRATION, &["not a whole gzip file"]) },
        case(
            "columns of two sensors",
            CALIBRATION.replacen("coil_a", "measured", 1),
            &["found both `x1_mm` and `measured`"],
        ),
        case(
            "degrees in an arcsec column",
            scaled("reference_arcsec", 1.0 / 3600.0),
            &["column `reference_arcsec`", "look like degrees"],
        ),
        case(
            "radians in an arcsec column",
            scaled("reference_arcsec", 1.0 / 206_264.8),
            &["look like radians"],
        ),
        case(
            "arcminutes in an arcsec column",
            scaled("reference_arcsec", 1.0 / 60.0),
            &["look like arcminutes"],
        ),
        case(
            "micrometres in mm columns",
            change(|number, fields, _| {
                if number > 1 {
                    for field in &mut fields[4..6] {
                        *field = format!("{}", field.parse::<f64>().unwrap() * 1000.0);
                    }
                }
            }),
            &["`x1_mm` and `x2_mm`", "micrometres"],
        ),
        case(
            "probes exchanged",
            scaled("reference_arcsec", -1.0),
            &["same sense", "exchange x1_mm and x2_mm"],
        ),
        case(
            "reference of something else",
            scaled("reference_arcsec", 1e-9),
            &["or whether this is the right column"],
        ),
        case("all readings at one angle", only(|_, angle| angle == 0.5), &["all readings are at one angle"]),
        Case {
            arguments: &["--order", "9"],
            ..case(
                "fewer points than parameters",
                only(|_, angle| [-1.0, 0.0, 1.0].contains(&angle)),
                &["3 distinct angles", "10 parameters of order 9"],
            )
        },
        case(
            "too few angles to hold out",
            only(|_, angle| [-1.0, 0.0, 1.0].contains(&angle)),
            &["too few to choose an order", "(give --order)"],
        ),
        Case { arguments: &["--order", "16"], ..case("order above 15", CALIBRATION, &["--order", "16"]) },
        Case {
            arguments: &["--probe-distance-error", "nan"],
            ..case("probe distance error NaN", CALIBRATION, &["--probe-distance-error", "finite"])
        },
        Case {
            mirror: DIRECT.to_string(),
            ..case(
                "mirror file of another sensor",
                CALIBRATION,
                &["columns of an eddy-current pair", "describes a direct sensor"],
            )
        },
        Case {
            mirror: DIRECT.to_string(),
            ..case(
                "reference a thousand times smaller",
                sweep(|x| 1e-3 * x),
                &["column `reference`", "1000 times larger"],
            )
        },
        Case {
            mirror: DIRECT.to_string(),
            ..case("reference of the other sense", sweep(|x| 5.0 - x), &["same sense", "turn the sign"])
        },
        Case {
            mirror: DIRECT.to_string(),
            ..case(
                "direct sensor that stands still",
                direct("0,0,1,5,5\n1,0,1,5,5.1\n2,0,1,5,5.2\n"),
                &["all readings are at one angle"],
            )
        },
        mirror("mirror that is no TOML", "[geometry\n", &["mirror.toml, line 1", "not TOML"]),
        mirror(
            "unknown key",
            &MIRROR.replace("initial_gap_mm", "inital_gap_mm"),
            &["unknown key `geometry.inital_gap_mm`", "did you mean `initial_gap_mm`"],
        ),
        mirror("unknown section", "[geometrie]\n", &["unknown key `geometrie`", "did you mean `geometry`"]),
        mirror(
            "missing key",
            "[geometry]\ninitial_gap_mm = 0.3\n",
            &["`geometry.probe_distance_mm` is missing"],
        ),
        mirror(
            "negative distance",
            &MIRROR.replace("12.0", "-12.0"),
            &["`geometry.probe_distance_mm` is -12"],
        ),
        mirror("distance as text", &MIRROR.replace("12.0", "\"12\""), &["expected a number"]),
        mirror(
            "unknown kind",
            "[sensor]\nkind = \"resolver\"\n",
            &["`sensor.kind`", "\"resolver\"", "\"direct\""],
        ),
        mirror(
            "unit that is no identifier",
            "[sensor]\nkind = \"direct\"\nunit = \"µm\"\n",
            &["`sensor.unit`", "um"],
        ),
        mirror("no unit", "[sensor]\nkind = \"direct\"\n", &["`sensor.unit` is missing"]),
        mirror(
            "revolution of zero",
            "[sensor]\nkind = \"direct\"\nunit = \"deg\"\nrevolution = 0\n",
            &["`sensor.revolution` is 0"],
        ),
    ]
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith")).current_dir(folder).args(arguments).output().unwrap()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// One message with all fragments, exit code 2, and the same files as before.
fn assert_refused(name: &str, folder: &Path, arguments: &[&str], message: &[&str]) {
    let before = files(folder);
    let output = run(folder, arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{name}: {text}");
    assert!(output.stdout.is_empty(), "{name}: printed on standard output");
    for fragment in message {
        assert!(text.contains(fragment), "{name}: `{fragment}` is not in: {text}");
    }
    // Clap's own messages about options are longer; all others are one line.
    let lines = text.lines().filter(|line| !line.trim().is_empty()).count();
    assert!(lines == 1 || text.contains("Usage") || text.contains("--help"), "{name}: {lines} lines: {text}");
    assert_eq!(files(folder), before, "{name}: something was written");
}

#[test]
fn every_kind_of_bad_input_has_its_message() {
    let cases = cases();
    assert!(cases.len() >= 40);
    for case in cases {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(case.file), &case.recording).unwrap();
        std::fs::write(folder.path().join("mirror.toml"), &case.mirror).unwrap();
        let mut arguments = vec!["fit", case.file, "--mirror", "mirror.toml", "--out", "coefficients.json"];
        arguments.extend(case.arguments);
        assert_refused(case.name, folder.path(), &arguments, case.message);
    }
}

#[test]
fn files_that_are_not_there_or_not_files() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("directory")).unwrap();
    std::fs::write(folder.path().join("recording.csv"), CALIBRATION).unwrap();
    std::fs::write(folder.path().join("mirror.toml"), MIRROR).unwrap();
    let refused = |name: &str, recording: &str, mirror: &str, out: &str, message: &[&str]| {
        let arguments = ["fit", recording, "--mirror", mirror, "--out", out];
        assert_refused(name, folder.path(), &arguments, message);
    };
    refused("no recording", "nothing.csv", "mirror.toml", "c.json", &["nothing.csv: there is no such file"]);
    refused("directory", "directory", "mirror.toml", "c.json", &["directory: is a directory"]);
    refused("no mirror", "recording.csv", "no.toml", "c.json", &["no.toml: cannot be read"]);
    refused("no such folder", "recording.csv", "mirror.toml", "nowhere/c.json", &["cannot be written"]);
    refused("output is a directory", "recording.csv", "mirror.toml", "directory", &["is a directory"]);
    refused(
        "output is the input",
        "recording.csv",
        "mirror.toml",
        "recording.csv",
        &["is the file that was read"],
    );
}

/// Root may read everything, so that the check is made only where the file is really unreadable.
#[cfg(unix)]
#[test]
fn a_file_without_permission() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording.csv");
    std::fs::write(&path, CALIBRATION).unwrap();
    std::fs::write(folder.path().join("mirror.toml"), MIRROR).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o000)).unwrap();
    if std::fs::File::open(&path).is_ok() {
        println!("skipped: this user may read any file");
        return;
    }
    let arguments = ["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json"];
    assert_refused("no permission", folder.path(), &arguments, &["cannot be read", "permissions"]);
}

#[test]
fn damaged_coefficients() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("recording.csv"), CALIBRATION).unwrap();
    std::fs::write(path.join("mirror.toml"), MIRROR).unwrap();
    assert!(
        run(path, &["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "good.json"])
            .status
            .success()
    );
    let good = std::fs::read_to_string(path.join("good.json")).unwrap();
    let order =
        format!("\"order\": {}", good.split("\"order\": ").nth(1).unwrap().split(',').next().unwrap());
    let first = good.find("\"coefficients\": [").unwrap() + 17;
    let digit = first + good[first..].find(|sign: char| sign.is_ascii_digit() && sign != '0').unwrap();
    let cases: [(&str, String, &[&str]); 10] = [
        ("a recording", CALIBRATION.to_string(), &["is a recording, expected a coefficients file (JSON)"]),
        (
            "a coefficient edited",
            format!(
                "{}{}{}",
                &good[..digit],
                if &good[digit..=digit] == "7" { 3 } else { 7 },
                &good[digit + 1..]
            ),
            &["bad.json", "changed after it was written", "sha256", "fit again"],
        ),
        ("not JSON", good[..good.len() / 2].to_string(), &["bad.json, line", "not JSON", "damaged"]),
        ("other JSON", "{\"schema\": 1}".to_string(), &["`schema` is 1", "no coefficients file"]),
        ("no schema", "{}".to_string(), &["`schema` is missing"]),
        (
            "newer",
            good.replace("\"version\": 4", "\"version\": 7"),
            &["version 7", "reads up to 4", "newer program"],
        ),
        (
            "coefficient lost",
            good.replacen(&order, "\"order\": 3", 1),
            &["damaged", "order 3 needs 4 coefficients"],
        ),
        ("unknown field", good.replacen("\"tool\"", "\"tul\"", 1), &["damaged", "tul"]),
        ("range upside down", good.replacen("\"to\": 0.", "\"to\": -10.", 1), &["damaged", "`valid_range`"]),
        ("number too large", good.replacen("\"constant\": -", "\"constant\": -1e999", 1), &["damaged"]),
    ];
    for (name, text, message) in cases {
        assert_ne!(text, good, "{name}");
        std::fs::write(path.join("bad.json"), text).unwrap();
        let arguments = ["apply", "recording.csv", "--coefficients", "bad.json", "--out", "angles.csv"];
        assert_refused(name, path, &arguments, message);
    }
    let arguments = ["apply", "recording.csv", "--coefficients", "none.json", "--out", "angles.csv"];
    assert_refused("no coefficients", path, &arguments, &["none.json: cannot be read"]);
    assert_refused(
        "coefficients as recording",
        path,
        &["apply", "good.json", "--coefficients", "good.json", "--out", "angles.csv"],
        &["is a coefficients file (JSON), expected a recording"],
    );
    std::fs::write(path.join("direct.csv"), sweep(|x| x)).unwrap();
    let arguments = ["apply", "direct.csv", "--coefficients", "good.json", "--out", "angles.csv"];
    assert_refused("other sensor", path, &arguments, &["columns of a direct sensor"]);
    // With other spaces, or with its hash taken out, the file is used as it stands.
    let spaced = good.replace("  ", "\t");
    let unsealed: String =
        good.lines().filter(|line| !line.contains("\"sha256\"") || line.ends_with(',')).collect();
    let unsealed = unsealed.replace("],}", "]}").replace(",}", "}");
    for (name, text) in [("spaces", spaced), ("hash taken out", unsealed)] {
        std::fs::write(path.join("other.json"), text).unwrap();
        let arguments = ["apply", "recording.csv", "--coefficients", "other.json", "--out", "angles.csv"];
        assert!(run(path, &arguments).status.success(), "{name}");
        std::fs::remove_file(path.join("angles.csv")).unwrap();
    }
    std::fs::write(path.join("nothing.csv"), "t_s,x1_mm\n0,0\n").unwrap();
    let arguments = ["apply", "nothing.csv", "--coefficients", "good.json", "--out", "angles.csv"];
    assert_refused("column missing", path, &arguments, &["`x2_mm` is missing"]);
}

/// An effect that depends on a column which the recording lacks: left out with a warning, or refused.
#[test]
fn a_column_that_the_coefficients_need() {
    use fitter::terms::{Factor, Operator, Product, Scope, Term};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("recording.csv"), CALIBRATION).unwrap();
    std::fs::write(path.join("mirror.toml"), MIRROR).unwrap();
    std::fs::write(path.join("without.csv"), without("temperature_c")).unwrap();
    assert!(
        run(path, &["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json"]).status.success()
    );
    let mut file = fitter::coefficients::read(&path.join("c.json")).unwrap();
    file.terms.push(Term {
        effect: "thermal_zero_drift".to_string(),
        scope: Scope::Device,
        operator: Operator::Product(Product {
            factors: vec![Factor { observable: "temperature_c".to_string(), power: 1, mean: 27.0 }],
        }),
        coefficients: vec![0.5],
        covariance: Vec::new(),
    });
    std::fs::write(path.join("c.json"), file.to_sealed_json()).unwrap();
    let arguments = ["apply", "without.csv", "--coefficients", "c.json", "--out", "angles.csv", "--strict"];
    assert_refused(
        "strict",
        path,
        &arguments,
        &["without.csv", "`temperature_c` is missing", "thermal_zero_drift"],
    );
    let output = run(path, &arguments[..6]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && text.contains("that effect is not corrected"), "{text}");
}
