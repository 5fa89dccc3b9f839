//! `fleet`: one row for every unit, whatever becomes of it; the same bytes however it is run; what cannot be mixed is refused.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Arc;
use std::time::Duration;

use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::{Field, Row};
use parquet::schema::parser::parse_message_type;
use serde_json::Value;

const FLEET: &str = "fleet recordings --mirror mirror.toml --out results";

/// A folder with a mirror and recordings of some units.
struct Scene {
    root: tempfile::TempDir,
}

impl Scene {
    fn new(units: &[&str]) -> Scene {
        let scene = Scene { root: tempfile::tempdir().unwrap() };
        fs::write(scene.path("mirror.toml"), "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n")
            .unwrap();
        fs::create_dir(scene.path("recordings")).unwrap();
        for (seed, unit) in (1..).zip(units) {
            scene.record(seed, &format!("recordings/{unit}.csv"), "");
        }
        scene
    }

    fn record(&self, seed: u64, file: &str, more: &str) {
        let line = format!("record --protocol calibration --seed {seed}{more} --out");
        let output = self.command(&line).arg(file).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_arcsmith"));
        command.current_dir(self.root.path()).args(line.split(' '));
        command
    }

    fn ok(&self, line: &str) -> String {
        let output = self.command(line).output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    fn refused(&self, line: &str) -> String {
        let Output { status, stderr, .. } = self.command(line).output().unwrap();
        assert_eq!(status.code(), Some(2), "{line}");
        String::from_utf8(stderr).unwrap()
    }

    fn json(&self) -> Value {
        serde_json::from_slice(&fs::read(self.path("results/fleet.json")).unwrap()).unwrap()
    }

    /// All rows of a table.
    fn rows(&self, table: &str) -> Vec<Row> {
        let mut parts: Vec<PathBuf> =
            fs::read_dir(self.path(table)).unwrap().map(|entry| entry.unwrap().path()).collect();
        parts.sort();
        let read = |path: &PathBuf| {
            let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
            reader.get_row_iter(None).unwrap().map(|row| row.unwrap()).collect::<Vec<Row>>()
        };
        parts.iter().flat_map(read).collect()
    }

    /// What one column says of every unit.
    fn column(&self, column: &str) -> Vec<(String, Field)> {
        let rows = self.rows("results/units");
        rows.iter().map(|row| (text(row, "unit"), field(row, column))).collect()
    }
}

fn field(row: &Row, column: &str) -> Field {
    row.get_column_iter().find(|(name, _)| *name == column).unwrap().1.clone()
}

fn text(row: &Row, column: &str) -> String {
    match field(row, column) {
        Field::Str(text) => text,
        other => panic!("{column}: {other}"),
    }
}

/// Every file below a folder.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        match path.is_dir() {
            true => found.extend(files(&path)),
            false => drop(found.insert(path.clone(), fs::read(path).unwrap())),
        }
    }
    found
}

/// A Parquet file of text and numbers.
fn parquet(path: &Path, texts: &[(&str, Vec<&str>)], numbers: &[(String, Vec<f64>)]) {
    let declared: String = (texts.iter().map(|(name, _)| format!("required binary {name} (STRING); ")))
        .chain(numbers.iter().map(|(name, _)| format!("required double {name}; ")))
        .collect();
    let schema = Arc::new(parse_message_type(&format!("message m {{ {declared} }}")).unwrap());
    let mut writer = SerializedFileWriter::new(File::create(path).unwrap(), schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for (_, values) in texts {
        let values: Vec<ByteArray> = values.iter().map(|text| (*text).into()).collect();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<ByteArrayType>().write_batch(&values, None, None).unwrap();
        column.close().unwrap();
    }
    for (_, values) in numbers {
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<DoubleType>().write_batch(values, None, None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

/// The columns of CSV files one below the other, and of every row the stem of its file.
fn stacked(paths: &[PathBuf]) -> (Vec<String>, Vec<(String, Vec<f64>)>) {
    let (mut units, mut columns) = (Vec::new(), Vec::<(String, Vec<f64>)>::new());
    for path in paths {
        let text = fs::read_to_string(path).unwrap();
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        columns.resize_with(names.len(), Default::default);
        for line in lines {
            units.push(path.file_stem().unwrap().to_string_lossy().into_owned());
            for ((column, name), cell) in columns.iter_mut().zip(&names).zip(line.split(',')) {
                column.0 = name.to_string();
                column.1.push(cell.parse().unwrap());
            }
        }
    }
    (units, columns)
}

#[test]
fn every_unit_is_one_row_and_one_that_fails_says_why() {
    let scene = Scene::new(&["b", "a unit, with ünicode"]);
    fs::write(scene.path("recordings/broken.csv"), "t_s,pass,x1_mm,x2_mm,reference_arcsec\n1,1,?,2,3\n")
        .unwrap();
    fs::write(scene.path("recordings/empty.csv"), "t_s,pass,x1_mm,x2_mm,reference_arcsec\n").unwrap();
    fs::write(scene.path("recordings/notes.md"), "no recording").unwrap();
    scene.record(
        7,
        "recordings/packed.csv.gz",
        " --temperature levels --effect thermal_zero_drift:coefficient_arcsec_per_k=2",
    );
    let said = scene.ok(FLEET);
    assert!(said.contains("5 units") && said.contains("failed"), "{said}");
    let names: Vec<String> = scene.column("unit").into_iter().map(|(unit, _)| unit).collect();
    assert_eq!(names, ["a unit, with ünicode", "b", "broken", "empty", "packed"]);
    let errors: Vec<Field> = scene.column("error").into_iter().map(|(_, error)| error).collect();
    assert!(matches!(&errors[2], Field::Str(text) if text.contains("line 2, column `x1_mm`")), "{errors:?}");
    assert!(
        matches!(&errors[3], Field::Str(text) if text.contains("has a header but no reading")),
        "{errors:?}"
    );
    assert!([0, 1, 4].iter().all(|unit| errors[*unit] == Field::Null), "{errors:?}");
    let packed = &scene.rows("results/units")[4];
    assert!(field(packed, "effects").to_string().contains("thermal_zero_drift"), "{packed}");
    assert!(field(packed, "coefficients").to_string().contains("thermal"), "{packed}");
    let parameters = scene.rows("results/parameters");
    let of = |kind: &str| {
        let is = |row: &&Row| {
            text(row, "unit") == "packed"
                && text(row, "effect") == "thermal_zero_drift"
                && text(row, "kind") == kind
        };
        let row = parameters.iter().find(is).unwrap();
        ["low", "high"].map(|column| match field(row, column) {
            Field::Double(value) => value,
            other => panic!("{other}"),
        })
    };
    for [low, high] in [of("named"), of("forced")] {
        assert!(low < 2.0 && 2.0 < high && high - low < 0.5, "{low} to {high}");
    }
    let json = scene.json();
    assert_eq!((json["units"].as_u64(), json["failed"].as_array().map(Vec::len)), (Some(5), Some(2)));
    let page = fs::read_to_string(scene.path("results/fleet.html")).unwrap();
    assert!(page.contains("thermal zero drift") && page.contains("has a header but no reading"));
}

#[test]
fn the_same_bytes_whatever_the_threads_and_however_often_it_is_killed() {
    let units = ["a", "b", "c", "d", "e", "f", "g", "h"];
    let scene = Scene::new(&units);
    let line = format!("{FLEET} --units-of-part 1 --quiet");
    scene.ok(&format!("{line} --jobs 1"));
    let once = files(&scene.path("results"));
    fs::remove_dir_all(scene.path("results")).unwrap();
    scene.ok(&format!("{line} --jobs 3"));
    assert!(files(&scene.path("results")) == once);
    fs::remove_dir_all(scene.path("results")).unwrap();
    let parts = || {
        fs::read_dir(scene.path("results/units"))
            .map_or(0, |all| all.flatten().filter(|one| one.path().is_file()).count())
    };
    let mut killed = 0;
    while killed < 3 {
        let mut child =
            scene.command(&format!("{line} --jobs 1 --resume")).stderr(Stdio::null()).spawn().unwrap();
        let before = parts();
        while parts() < before + 1 && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let finished = child.try_wait().unwrap().is_some();
        let _ = child.kill();
        child.wait().unwrap();
        assert!(!finished, "it ended before it was killed three times");
        killed += 1;
    }
    assert!(parts() < units.len());
    scene.ok(&format!("{line} --resume"));
    assert!(files(&scene.path("results")) == once);
}

#[test]
fn results_of_other_options_are_not_mixed_and_damaged_parts_are_reported() {
    let scene = Scene::new(&["a", "b", "c"]);
    let line = format!("{FLEET} --units-of-part 2");
    scene.ok(&line);
    assert!(scene.refused(&line).contains("holds results already"));
    for other in ["--without time_drift", "--order 9", "--map temperature_c=coil_a"] {
        let said = scene.refused(&format!("{line} --resume {other}"));
        assert!(said.contains("results of another version or other options cannot be mixed"), "{said}");
    }
    let manifest = scene.path("results/manifest.json");
    let own = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, own.replace("arcsmith ", "arcsmith 9")).unwrap();
    assert!(scene.refused(&format!("{line} --resume")).contains("cannot be mixed: the program"));
    fs::write(&manifest, own.replace('}', "")).unwrap();
    assert!(scene.refused(&format!("{line} --resume")).contains("is no manifest of a fleet"));
    fs::write(&manifest, &own).unwrap();
    let before = files(&scene.path("results"));
    let part = scene.path("results/units/part-00001.parquet");
    fs::write(&part, &fs::read(&part).unwrap()[..100]).unwrap();
    let said = scene.refused(&format!("{line} --resume"));
    assert!(said.contains("part-00001.parquet: is damaged") && said.contains("--resume"), "{said}");
    let said = scene.refused(&format!("{} --against results", FLEET.replace("--out results", "--out later")));
    assert!(said.contains("is damaged"), "{said}");
    fs::remove_file(&part).unwrap();
    scene.ok(&format!("{line} --resume"));
    assert!(files(&scene.path("results")) == before);
    fs::remove_file(scene.path("recordings/c.csv")).unwrap();
    assert!(scene.refused(&format!("{line} --resume")).contains("the data holds other units"));
}

#[test]
fn a_dataset_gives_what_a_folder_gives() {
    let scene = Scene::new(&["a", "b", "c"]);
    scene.ok(FLEET);
    let folder = ["verdict", "rms_after", "noise", "scores"].map(|column| scene.column(column));
    fs::remove_dir_all(scene.path("results")).unwrap();
    let paths = ["a", "b", "c"].map(|unit| scene.path(&format!("recordings/{unit}.csv")));
    let (units, columns) = stacked(&paths);
    let lots = units.iter().map(|unit| if unit == "a" { "one" } else { "two" }).collect();
    let texts = [("serial", units.iter().map(String::as_str).collect()), ("batch", lots)];
    parquet(&scene.path("all.parquet"), &texts, &columns);
    scene.ok("fleet all.parquet --unit serial --lot batch --mirror mirror.toml --out results --units-of-part 2 --quiet");
    assert_eq!(folder, ["verdict", "rms_after", "noise", "scores"].map(|column| scene.column(column)));
    let lots: Vec<Field> = scene.column("lot").into_iter().map(|(_, lot)| lot).collect();
    assert_eq!(lots, ["one", "two", "two"].map(|lot| Field::Str(lot.into())));
}

#[test]
fn what_is_no_fleet_is_refused() {
    let scene = Scene::new(&["a", "b"]);
    let refused = |line: &str, what: &str| {
        let said = scene.refused(&format!("{line} --mirror mirror.toml --out results"));
        assert!(said.contains(what), "{line}: {said}");
        assert!(!scene.path("results").exists(), "{line}");
    };
    refused("fleet nowhere", "nowhere: cannot be read");
    refused("fleet recordings/a.csv", "--unit COLUMN");
    fs::create_dir(scene.path("none")).unwrap();
    refused("fleet none", "holds no recording");
    refused("fleet none --unit serial", "holds no Parquet file");
    refused("fleet recordings/a.csv --unit serial", "is not a Parquet file");
    fs::copy(scene.path("recordings/a.csv"), scene.path("recordings/a.txt")).unwrap();
    refused("fleet recordings", "are both unit `a`");
    fs::remove_file(scene.path("recordings/a.txt")).unwrap();
    fs::write(scene.path("lots.csv"), "unit,lot,time\na,1,noon\n").unwrap();
    refused("fleet recordings --lots lots.csv", "lots.csv, line 2, column `time`");
    fs::write(scene.path("lots.csv"), "unit,lot\na,1\na,2\n").unwrap();
    refused("fleet recordings --lots lots.csv", "lots.csv, line 3: unit `a` stands there twice");
    let (_, columns) = stacked(&[scene.path("recordings/a.csv")]);
    let rows = columns[0].1.len();
    let dataset = |name: &str, units: Vec<&str>, columns: &[(String, Vec<f64>)]| {
        fs::create_dir_all(scene.path("set")).unwrap();
        parquet(&scene.path(&format!("set/{name}.parquet")), &[("serial", units)], columns);
    };
    dataset("1", vec!["a"; rows], &columns);
    refused("fleet set --unit nothing", "has no column `nothing`");
    dataset("2", vec!["a"; rows], &columns);
    refused("fleet set --unit serial", "unit `a` again");
    dataset("2", vec!["b"; rows], &columns[..columns.len() - 1]);
    refused("fleet set --unit serial", "its columns are not those of set/1.parquet: `coil_a` is missing");
    let apart = (0..rows).map(|row| if row % 100 < 50 { "b" } else { "c" }).collect();
    dataset("2", apart, &columns);
    refused("fleet set --unit serial", "set/2.parquet, row 101: unit `b` again");
    dataset("2", vec![""; rows], &columns);
    refused("fleet set --unit serial", "set/2.parquet, row 1, column `serial`: names no unit");
    fs::write(scene.path("set/2.parquet"), &fs::read(scene.path("set/1.parquet")).unwrap()[..2000]).unwrap();
    refused("fleet set --unit serial", "set/2.parquet: is not a Parquet file");
}

#[cfg(unix)]
#[test]
fn a_file_that_vanishes_is_a_row_with_its_error() {
    let scene = Scene::new(&["a"]);
    // Its name is there, and the file is not.
    std::os::unix::fs::symlink(scene.path("gone"), scene.path("recordings/b.csv")).unwrap();
    scene.ok(FLEET);
    let errors = scene.column("error");
    assert!(
        matches!(&errors[1].1, Field::Str(text) if text.contains("b.csv: there is no such file")),
        "{errors:?}"
    );
}

#[test]
fn a_campaign_is_compared_with_an_earlier_one_and_a_unit_that_departs_is_reported() {
    let scene = Scene::new(&[]);
    let drift = |value: f64| {
        format!(" --temperature levels --effect thermal_zero_drift:coefficient_arcsec_per_k={value}")
    };
    for unit in 0..12 {
        scene.record(unit + 1, &format!("recordings/u{unit:02}.csv"), &drift(1.0 + 0.02 * unit as f64));
    }
    scene.ok(&FLEET.replace("results", "earlier"));
    for unit in 0..12 {
        let value = if unit == 7 { 4.0 } else { 1.5 + 0.02 * unit as f64 };
        let again = format!("{} --device-seed {}", drift(value), unit + 1);
        scene.record(unit + 101, &format!("recordings/u{unit:02}.csv"), &again);
    }
    let said = scene.ok(&format!("{FLEET} --against earlier"));
    assert!(said.contains("thermal zero drift"), "{said}");
    let json = scene.json();
    let parameters = json["parameters"].as_array().unwrap();
    let drifting = parameters.iter().find(|one| one["effect"] == "thermal_zero_drift").unwrap();
    assert!(drifting["shown_by_fleet"].as_f64().unwrap() < 1e-3, "{drifting}");
    assert_eq!(drifting["drift"]["of_same_units"], true);
    let outlying = &json["outlying"][0];
    assert_eq!(
        (outlying["unit"].as_str(), outlying["effect"].as_str()),
        (Some("u07"), Some("thermal_zero_drift"))
    );
    let page = fs::read_to_string(scene.path("results/fleet.html")).unwrap();
    assert!(page.contains("Since the earlier campaign") && page.contains("u07"));
}
