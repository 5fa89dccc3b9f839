//! Bad input over the whole command line: exit code 2, one message that says what is wrong, where, and how to
//! mend it, and nothing written.

use std::fs;
use std::path::Path;

use arcsmith_tests::programs::{both, root, run};
use fitter::coefficients::Diagnosed;
use rayon::prelude::*;

/// What the user did wrong.
struct Bad {
    /// In words.
    what: &'static str,
    /// Program and arguments, separated by spaces; files as [`prepare`] lays them out.
    command: &'static str,
    /// What the message must say: place, found, expected, mend.
    says: &'static [&'static str],
}

const fn bad(what: &'static str, command: &'static str, says: &'static [&'static str]) -> Bad {
    Bad { what, command, says }
}

const FIT: &str = "arcsmith fit {} --mirror mirror.toml --out new/c.json";

/// Recordings that `fit` must refuse; the `generate` that fits on the way says the same.
const RECORDINGS: &[Bad] = &[
    bad("a column is missing", "missing.csv", &["missing.csv, line 1", "`x2_mm`", "missing"]),
    bad("a column stands there twice", "doubled.csv", &["doubled.csv, line 1", "`x1_mm`", "twice"]),
    bad(
        "text in a number",
        "text.csv",
        &["text.csv, line 5", "`reference_arcsec`", "`oops`", "expected a number"],
    ),
    bad("not a number", "nan.csv", &["nan.csv, line 5", "`x1_mm`", "`NaN`", "finite"]),
    bad("infinity", "infinity.csv", &["infinity.csv, line 5", "`x2_mm`", "`inf`", "finite"]),
    bad("a blank in a needed column", "blank.csv", &["blank.csv, line 5", "`x1_mm`", "blank"]),
    bad(
        "degrees in an arcsecond column",
        "degrees.csv",
        &["degrees.csv", "`reference_arcsec`", "degrees", "convert"],
    ),
    bad(
        "micrometres in a millimetre column",
        "micrometres.csv",
        &["micrometres.csv", "`x1_mm`", "micrometres", "onvert"],
    ),
    bad("the probes exchanged", "exchanged.csv", &["exchanged.csv", "exchange x1_mm and x2_mm"]),
    bad("all readings at one angle", "one-angle.csv", &["one-angle.csv", "one angle", "record several"]),
    bad("an empty file", "empty.csv", &["empty.csv", "is empty", "header"]),
    bad("a header without rows", "header.csv", &["header.csv", "no reading"]),
    bad("a directory", "folder.csv", &["folder.csv", "is a directory"]),
    bad("no such file", "nowhere.csv", &["nowhere.csv", "no such file", "check the path"]),
    bad("a row cut short", "short.csv", &["short.csv, line 5", "fields", "expected 10"]),
    bad("spaces between columns", "spaces.csv", &["spaces.csv, line 1", "by spaces", "commas"]),
    bad("a direction that is none", "direction.csv", &["direction.csv, line 5", "`direction`", "`0`", "-1"]),
    bad(
        "a pass that is no whole number",
        "pass.csv",
        &["pass.csv, line 5", "`pass`", "`1.5`", "whole number"],
    ),
    bad("bytes that are no text", "binary.csv", &["binary.csv", "UTF-8"]),
    bad("no gzip", "plain.csv.gz", &["plain.csv.gz", "gzip"]),
    bad(
        "columns of two sensors",
        "two-sensors.csv",
        &["two-sensors.csv, line 1", "`measured`", "one sensor"],
    ),
    bad("another sensor than the mirror's", "direct.csv", &["direct.csv", "direct sensor", "mirror file"]),
];

/// Everything else.
const COMMANDS: &[Bad] = &[
    bad(
        "fewer points than parameters",
        "arcsmith fit few.csv --mirror mirror.toml --order 9 --out new/c.json",
        &["5 distinct angles", "10 parameters", "--order"],
    ),
    bad(
        "too few points to choose an order",
        "arcsmith fit three.csv --mirror mirror.toml --out new/c.json",
        &["3 readings", "--order"],
    ),
    bad(
        "an order that is none",
        "arcsmith fit good.csv --mirror mirror.toml --order 99 --out new/c.json",
        &["99", "1..=15"],
    ),
    bad(
        "a probe distance error that is no number",
        "arcsmith fit good.csv --mirror mirror.toml --probe-distance-error NaN --out new/c.json",
        &["NaN", "finite"],
    ),
    bad(
        "an unknown key in the mirror",
        "arcsmith fit good.csv --mirror unknown-key.toml --out new/c.json",
        &["unknown-key.toml", "`geometry.probe_distance`", "did you mean `probe_distance_mm`"],
    ),
    bad(
        "a key missing in the mirror",
        "arcsmith fit good.csv --mirror missing-key.toml --out new/c.json",
        &["missing-key.toml", "`geometry.initial_gap_mm`", "add it"],
    ),
    bad(
        "a probe distance below zero",
        "arcsmith fit good.csv --mirror negative.toml --out new/c.json",
        &["negative.toml", "`geometry.probe_distance_mm`", "above zero"],
    ),
    bad(
        "a mirror that is no TOML",
        "arcsmith fit good.csv --mirror broken.toml --out new/c.json",
        &["broken.toml, line 2", "TOML"],
    ),
    bad(
        "a unit that is no identifier",
        "arcsmith fit direct.csv --mirror unit.toml --out new/c.json",
        &["unit.toml", "`sensor.unit`", "letter"],
    ),
    bad(
        "no mirror",
        "arcsmith fit good.csv --mirror nowhere.toml --out new/c.json",
        &["nowhere.toml", "cannot be read"],
    ),
    bad(
        "an output folder that is not there",
        "arcsmith fit good.csv --mirror mirror.toml --out nowhere/c.json",
        &["nowhere/c.json", "cannot be written", "--out"],
    ),
    bad(
        "the recording as output",
        "arcsmith fit good.csv --mirror mirror.toml --out good.csv",
        &["good.csv", "the file that was read"],
    ),
    bad(
        "a directory as output",
        "arcsmith fit good.csv --mirror mirror.toml --out new",
        &["new", "is a directory"],
    ),
    bad(
        "coefficients cut short",
        "arcsmith apply good.csv --coefficients cut.json --out new/a.csv",
        &["cut.json, line", "not JSON", "fit again"],
    ),
    bad(
        "coefficients of a newer program",
        "arcsmith apply good.csv --coefficients newer.json --out new/a.csv",
        &["newer.json", "version 99", "newer program"],
    ),
    bad(
        "coefficients for another sensor",
        "arcsmith apply direct.csv --coefficients good.json --out new/a.csv",
        &["direct.csv", "eddy-current pair"],
    ),
    bad(
        "generate: coefficients that are none",
        "arcsmith generate --coefficients other.json --out new/g",
        &["other.json", "`schema`", "no coefficients file"],
    ),
    bad(
        "generate: coefficients that contradict themselves",
        "arcsmith generate --coefficients contradiction.json --out new/g",
        &["contradiction.json", "damaged", "order"],
    ),
    bad(
        "generate: a directory as coefficients",
        "arcsmith generate --coefficients new --out new/g",
        &["new", "cannot be read"],
    ),
    bad(
        "generate: nothing to generate from",
        "arcsmith generate --out new/g",
        &["nothing is named", "no coefficients.json", "--coefficients", "--recording", "--demo"],
    ),
    bad(
        "generate: a model that leaves more than it names",
        "arcsmith generate --coefficients unexplained.json --out new/g",
        &["ended `unexplained`", "leaves 12.0 arcsec rms at a noise of 0.500 arcsec", "--accept-unexplained"],
    ),
    bad(
        "generate: a recording without its mirror",
        "arcsmith generate --recording good.csv --out new/g",
        &["--mirror"],
    ),
    bad(
        "generate: a recording with text in it",
        "arcsmith generate --recording text.csv --mirror mirror.toml --out new/g",
        &["text.csv, line 5", "`oops`"],
    ),
    bad(
        "generate: a bound that no program can meet",
        "arcsmith generate --demo --bound-arcsec 1e-9 --out new/g",
        &["1e-9 arcsec", "the best is", "ask for that"],
    ),
    bad(
        "generate: a bound below zero",
        "arcsmith generate --demo --bound-arcsec=-1 --out new/g",
        &["the bound is -1", "positive"],
    ),
    bad(
        "generate: a bound that is no number",
        "arcsmith generate --demo --bound-arcsec NaN --out new/g",
        &["the bound is NaN", "positive"],
    ),
    bad(
        "generate: a bound in another unit",
        "arcsmith generate --demo --bound 0.01mm --out new/g",
        &["--bound 0.01mm", "\"mm\"", "\"arcsec\"", "0.01arcsec"],
    ),
    bad(
        "generate: a bound without a unit",
        "arcsmith generate --demo --bound 0.01 --out new/g",
        &["--bound 0.01", "0.01arcsec"],
    ),
    bad(
        "generate: a bound in words",
        "arcsmith generate --demo --bound smallarcsec --out new/g",
        &["--bound smallarcsec", "not a number"],
    ),
    bad(
        "generate: arcseconds for a length",
        "arcsmith generate --coefficients direct.json --bound-arcsec 1 --out new/g",
        &["in mm", "--bound"],
    ),
    bad(
        "generate: a range beyond the recording",
        "arcsmith generate --demo --from -0.4 --to 0.4 --out new/g",
        &["-0.4…0.4 mm", "covers -0.356", "--extrapolate"],
    ),
    bad(
        "generate: a range the wrong way round",
        "arcsmith generate --demo --from 0.2 --to 0.1 --out new/g",
        &["0.2…0.1", "lower end first"],
    ),
    bad(
        "generate: a range that is no number",
        "arcsmith generate --demo --from NaN --to 0.1 --out new/g",
        &["NaN", "finite"],
    ),
    bad("generate: a range with one end", "arcsmith generate --demo --from 0.1 --out new/g", &["--to"]),
    bad(
        "generate: a range steeper than the probes can be",
        "arcsmith generate --demo --from -9 --to 9 --extrapolate --out new/g",
        &["s = 9", "d = 12", "narrow the range"],
    ),
    bad(
        "generate: a name that is no identifier",
        "arcsmith generate --demo --name 9lives --out new/g",
        &["\"9lives\"", "not an identifier", "letter"],
    ),
    bad(
        "generate: a name that is a keyword",
        "arcsmith generate --demo --name while --out new/g",
        &["\"while\"", "keyword"],
    ),
    bad(
        "generate: counts without a gain",
        "arcsmith generate --demo --input counts --out new/g",
        &["--gain"],
    ),
    bad(
        "generate: a gain without counts",
        "arcsmith generate --demo --gain 1e-5 --out new/g",
        &["--gain", "--input counts"],
    ),
    bad(
        "generate: a table that is none",
        "arcsmith generate --demo --table 3by7 --out new/g",
        &["--table 3by7", "2x32"],
    ),
    bad(
        "generate: a gain below zero",
        "arcsmith generate --demo --input counts --gain -1 --out new/g",
        &["gain is -1", "positive"],
    ),
    bad(
        "generate: a converter of 40 bits",
        "arcsmith generate --demo --input counts --gain 1e-5 --bits 40 --out new/g",
        &["40 bits", "1 to 24"],
    ),
    bad(
        "generate: a converter that does not reach the range",
        "arcsmith generate --demo --input counts --gain 1e-6 --out new/g",
        &["reaches", "the range is", "gain"],
    ),
    bad(
        "generate: an offset that is no number",
        "arcsmith generate --demo --input counts --gain 2e-5 --offset inf --out new/g",
        &["offset", "inf"],
    ),
    bad(
        "generate: a full scale below the range",
        "arcsmith generate --demo --full-scale 0.1 --out new/g",
        &["0.1", "full scale"],
    ),
    bad(
        "generate: a full scale of zero",
        "arcsmith generate --demo --full-scale 0 --out new/g",
        &["full scale is 0", "positive"],
    ),
    bad(
        "generate: two probes of a direct sensor",
        "arcsmith generate --coefficients direct.json --input x1x2-f32 --out new/g",
        &["one reading", "x1x2"],
    ),
    bad(
        "generate: an integer from floats",
        "arcsmith generate --demo --format f32 --output nano --out new/g",
        &["f32"],
    ),
    bad(
        "generate: a format that is none",
        "arcsmith generate --demo --format q63 --out new/g",
        &["q63", "q31", "f32"],
    ),
    bad(
        "generate: a format twice",
        "arcsmith generate --demo --format q31,q31 --out new/g",
        &["q31", "twice"],
    ),
    bad(
        "generate: a degree of zero",
        "arcsmith generate --demo --degree 0 --out new/g",
        &["degree is 0", "1 to 16"],
    ),
    bad(
        "generate: an output folder under a file",
        "arcsmith generate --demo --out good.csv/g",
        &["good.csv/g", "cannot be written", "--out"],
    ),
    bad(
        "record: a name that says no format",
        "arcsmith record --protocol calibration --seed 1 --out new/r.txt",
        &["new/r.txt", ".csv"],
    ),
    bad(
        "record: a folder that is not there",
        "arcsmith record --protocol calibration --seed 1 --out nowhere/r.csv",
        &["nowhere/r.csv", "folder that exists"],
    ),
    bad(
        "record: a seed that is none",
        "arcsmith record --protocol calibration --seed -1 --out new/r.csv",
        &["-1"],
    ),
    bad(
        "record: an effect that is none",
        "arcsmith record --protocol calibration --seed 1 --effect moonlight:x=1 --out new/r.csv",
        &["moonlight"],
    ),
    bad(
        "record: a schedule for a verification",
        "arcsmith record --protocol verification --schedule fine --seed 1 --out new/r.csv",
        &["--schedule", "calibration"],
    ),
];

/// The embedded recording as lines, header first.
fn lines() -> Vec<String> {
    let text = fs::read_to_string(root().join("fitter/data/calibration.csv")).unwrap();
    text.lines().map(str::to_string).collect()
}

/// The embedded recording with field `column` of line `line` (the header is line 1) set.
fn with_cell(line: usize, column: usize, cell: &str) -> Vec<String> {
    let mut lines = lines();
    let mut fields: Vec<&str> = lines[line - 1].split(',').collect();
    fields[column] = cell;
    lines[line - 1] = fields.join(",");
    lines
}

/// The embedded recording with each row's fields changed.
fn with_rows(change: impl Fn(&mut Vec<String>)) -> Vec<String> {
    let mut lines = lines();
    for line in lines.iter_mut().skip(1) {
        let mut fields: Vec<String> = line.split(',').map(str::to_string).collect();
        change(&mut fields);
        *line = fields.join(",");
    }
    lines
}

/// Columns of the recording.
const PASS: usize = 1;
const DIRECTION: usize = 2;
const COMMAND: usize = 3;
const X1: usize = 4;
const X2: usize = 5;
const REFERENCE: usize = 6;

/// Lays out good and bad files.
fn prepare(folder: &Path) {
    let put = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    let csv = |name: &str, lines: Vec<String>| put(name, &(lines.join("\n") + "\n"));
    fs::create_dir(folder.join("new")).unwrap();
    fs::create_dir(folder.join("folder.csv")).unwrap();
    csv("good.csv", lines());
    csv(
        "missing.csv",
        lines()
            .iter()
            .map(|l| {
                l.split(',')
                    .enumerate()
                    .filter(|(i, _)| *i != X2)
                    .map(|(_, f)| f)
                    .collect::<Vec<_>>()
                    .join(",")
            })
            .collect(),
    );
    let with_header = |from: &str, to: &str| {
        let mut lines = lines();
        lines[0] = lines[0].replace(from, to);
        lines
    };
    csv("doubled.csv", with_header("coil_a", "x1_mm"));
    csv("two-sensors.csv", with_header("coil_a", "measured"));
    csv("text.csv", with_cell(5, REFERENCE, "oops"));
    csv("nan.csv", with_cell(5, X1, "NaN"));
    csv("infinity.csv", with_cell(5, X2, "inf"));
    csv("blank.csv", with_cell(5, X1, ""));
    csv("direction.csv", with_cell(5, DIRECTION, "0"));
    csv("pass.csv", with_cell(5, PASS, "1.5"));
    let scaled = |field: &mut String, factor: f64| {
        *field = format!("{:.7}", field.parse::<f64>().unwrap() * factor);
    };
    csv("degrees.csv", with_rows(|f| scaled(&mut f[REFERENCE], 1.0 / 3600.0)));
    csv(
        "micrometres.csv",
        with_rows(|f| {
            scaled(&mut f[X1], 1e3);
            scaled(&mut f[X2], 1e3);
        }),
    );
    csv("exchanged.csv", with_rows(|f| f.swap(X1, X2)));
    let at_angles = |angles: &[&str]| -> Vec<String> {
        let all = lines();
        let kept = |line: &&String| angles.contains(&line.split(',').nth(COMMAND).unwrap());
        all.iter().take(1).chain(all.iter().skip(1).filter(kept)).cloned().collect()
    };
    csv("one-angle.csv", at_angles(&["0.500"]));
    csv("three.csv", at_angles(&["-1.000", "0.000", "1.000"]));
    csv("few.csv", at_angles(&["-1.600", "-0.800", "0.000", "0.800", "1.600"]));
    put("empty.csv", "");
    csv("header.csv", lines()[..1].to_vec());
    let mut short = lines();
    short[4] = short[4].rsplit_once(',').unwrap().0.to_string();
    csv("short.csv", short);
    csv("spaces.csv", lines().iter().map(|l| l.replace(',', " ")).collect());
    fs::write(folder.join("binary.csv"), [0xff, 0xfe, 0x00, 0x41, 0x0a]).unwrap();
    csv("plain.csv.gz", lines());
    let direct = |i: i32| format!("{i}.0,{},1,{}.0,{}.001", i / 40, i % 40, i % 40);
    csv(
        "direct.csv",
        std::iter::once("t_s,pass,direction,measured,reference".to_string())
            .chain((0..80).map(direct))
            .collect(),
    );

    let geometry = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";
    put("mirror.toml", geometry);
    put("unknown-key.toml", &geometry.replace("probe_distance_mm", "probe_distance"));
    put("missing-key.toml", "[geometry]\nprobe_distance_mm = 12.0\n");
    put("negative.toml", &geometry.replace("12.0", "-12.0"));
    put("broken.toml", "[geometry]\nprobe_distance_mm = = 12\n");
    put("unit.toml", "[sensor]\nkind = \"direct\"\nunit = \"m/s\"\n");
    put("direct.toml", "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n");

    for (recording, mirror, out) in
        [("good.csv", "mirror.toml", "good.json"), ("direct.csv", "direct.toml", "direct.json")]
    {
        let output = run("arcsmith", folder, &["fit", recording, "--mirror", mirror, "--out", out]);
        assert!(output.status.success(), "{}", both(&output));
    }
    let good = fs::read_to_string(folder.join("good.json")).unwrap();
    put("cut.json", &good[..good.len() / 2]);
    put("newer.json", &good.replacen("\"version\": 4", "\"version\": 99", 1));
    put("other.json", "{\"schema\": \"something else\"}");
    let order = good.find("\"order\":").unwrap();
    let digit = order + good[order..].find(|c: char| c.is_ascii_digit()).unwrap();
    put("contradiction.json", &format!("{}5{}", &good[..digit], &good[digit + 1..]));
    let mut open = fitter::coefficients::read(&folder.join("good.json")).unwrap();
    let verdict = "unexplained".to_string();
    open.diagnosis = Some(Diagnosed { verdict, before_rms: 12.0, after_rms: 12.0, noise_floor: 0.5 });
    put("unexplained.json", &open.to_sealed_json());
}

/// Every file below `folder` with its length, sorted.
fn everything(folder: &Path) -> Vec<(std::path::PathBuf, u64)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let data = entry.metadata().unwrap();
        found.push((entry.path(), data.len()));
        if data.is_dir() {
            found.extend(everything(&entry.path()));
        }
    }
    found.sort();
    found
}

/// What is wrong with how a program took it, if anything.
fn complaint(what: &str, command: &str, says: &[&str], folder: &Path) -> Option<String> {
    let mut words = command.split(' ');
    let program = words.next().unwrap();
    let output = run(program, folder, &words.collect::<Vec<_>>());
    let said = both(&output);
    let wrong = if output.status.code() != Some(2) {
        format!("exit code {:?}, expected 2", output.status.code())
    } else if said.contains("panicked") {
        "it panicked".to_string()
    } else if let Some(missing) = says.iter().find(|part| !said.contains(**part)) {
        format!("the message does not say {missing:?}")
    } else if said.lines().filter(|line| line.contains("error:")).count() > 1 {
        "it gives more than one message".to_string()
    } else {
        return None;
    };
    Some(format!("{what}: {wrong}\n  $ {command}\n{said}"))
}

#[test]
fn every_kind_of_bad_input_has_its_message() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    let before = everything(folder.path());
    let fits: Vec<String> = RECORDINGS.iter().map(|bad| FIT.replace("{}", bad.command)).collect();
    let recordings = RECORDINGS.iter().zip(&fits).map(|(b, command)| (b.what, command.as_str(), b.says));
    let all: Vec<(&str, &str, &[&str])> =
        recordings.chain(COMMANDS.iter().map(|b| (b.what, b.command, b.says))).collect();
    assert!(all.len() >= 30);
    let complaints: Vec<String> = (all.par_iter())
        .filter_map(|(what, command, says)| complaint(what, command, says, folder.path()))
        .collect();
    assert!(
        complaints.is_empty(),
        "{} of {} kinds:\n\n{}",
        complaints.len(),
        all.len(),
        complaints.join("\n")
    );
    assert_eq!(everything(folder.path()), before, "something was written");
    println!("{} kinds of bad input", all.len());
}
