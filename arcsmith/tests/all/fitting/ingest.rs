//! Other ways in: semicolons, tabs, decimal commas, other column names and units, Parquet.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;

use fitter::recording::{Mapping, Note, Purpose, Reading};
use fitter::table::{Header, Naming, Table, Use};
use fitter::{Recording, Sensor};
use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

const CALIBRATION: &str = include_str!("../../../../fitter/data/calibration.csv");
const MIRROR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";

fn plain() -> Recording {
    Recording::from_bytes("calibration.csv", CALIBRATION.as_bytes()).unwrap()
}

/// The same columns, wherever they came from.
fn assert_same(found: &Recording, expected: &Recording) {
    assert_eq!(found.time_s, expected.time_s);
    assert_eq!((&found.pass, &found.direction), (&expected.pass, &expected.direction));
    assert_eq!((&found.command_deg, &found.readings), (&expected.command_deg, &expected.readings));
    assert_eq!(found.further, expected.further);
}

#[test]
fn delimiter_and_decimal_comma_are_recognised_and_reported() {
    let expected = plain();
    for (delimiter, comma, said) in [
        (";", false, "semicolons, numbers with a decimal point"),
        (";", true, "semicolons, numbers with a decimal comma"),
        ("\t", false, "tabs, numbers with a decimal point"),
        ("\t", true, "tabs, numbers with a decimal comma"),
    ] {
        let text = CALIBRATION.replace(',', delimiter);
        let text = if comma { text.replace('.', ",") } else { text };
        let found = Recording::from_bytes("other.csv", text.as_bytes()).unwrap();
        assert_same(&found, &expected);
        assert!(found.notes.iter().any(|note| note.to_string().contains(said)), "{:?}", found.notes);
    }
    assert!(!expected.notes.iter().any(|note| matches!(note, Note::Dialect(_))));
}

/// Directions as words, as ones and zeros, or from the motion itself; comments stand anywhere.
#[test]
fn directions_and_comments_are_understood() {
    let expected = plain();
    let with = |edit: &dyn Fn(&mut Vec<&str>)| {
        let line = |line: &str| {
            let mut fields: Vec<&str> = line.split(',').collect();
            edit(&mut fields);
            fields.join(",") + "\n"
        };
        let text: String = CALIBRATION.lines().map(line).collect();
        Recording::from_bytes("calibration.csv", ("# a bench\n".to_string() + &text).as_bytes()).unwrap()
    };
    for [forward, backward] in [["up", "Down"], ["1", "0"], ["+", "-"]] {
        assert_same(
            &with(&|fields| match fields[2] {
                "1" => fields[2] = forward,
                "-1" => fields[2] = backward,
                _ => {}
            }),
            &expected,
        );
    }
    let without = with(&|fields| {
        fields.remove(2);
    });
    assert_same(&without, &expected);
    assert!(without.notes.iter().any(|note| note.to_string().contains("from the motion of the readings")));
    assert_eq!((without.line(0), expected.line(0)), (3, 2));
}

fn read(path: &Path, map: &[&str], sensor: Option<&Sensor>) -> Result<Recording, fitter::RecordingError> {
    let mappings: Vec<Mapping> = map.iter().map(|map| map.parse().unwrap()).collect();
    let reading = Reading { purpose: Purpose::Fit, mappings: &mappings, sensor };
    // As the program does.
    parquet_tables::register();
    Recording::read_as(path, &reading, &mut |_| {})
}

#[test]
fn columns_are_mapped_and_converted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lab.csv");
    let mut lines = CALIBRATION.lines();
    let header = lines.next().unwrap();
    let at = |name: &str| header.split(',').position(|column| column == name).unwrap();
    let changed = [(at("x1_mm"), 1e3), (at("x2_mm"), 1e6), (at("t_s"), 1e3), (at("temperature_c"), 1.0)];
    let mut text = header
        .replace("x1_mm", "Probe 1")
        .replace("x2_mm", "Probe 2")
        .replace("t_s,", "Time,")
        .replace("temperature_c", "Base")
        + "\n";
    for line in lines {
        let mut fields: Vec<String> = line.split(',').map(String::from).collect();
        for (index, factor) in changed {
            let offset = if factor == 1.0 { 273.15 } else { 0.0 };
            fields[index] = (factor * fields[index].parse::<f64>().unwrap() + offset).to_string();
        }
        text += &(fields.join(",") + "\n");
    }
    std::fs::write(&path, text).unwrap();
    let map = ["x1_mm=Probe 1:um", "x2_mm=Probe 2:nm", "t_s=Time:ms", "temperature_c=Base:K"];
    let (found, expected) = (read(&path, &map, None).unwrap(), plain());
    for row in 0..expected.rows() {
        approx::assert_abs_diff_eq!(found.reading(row), expected.reading(row), epsilon = 1e-12);
        approx::assert_abs_diff_eq!(found.time_s[row], expected.time_s[row], epsilon = 1e-9);
        let temperature = |r: &Recording| r.column("temperature_c").unwrap()[row];
        approx::assert_abs_diff_eq!(temperature(&found), temperature(&expected), epsilon = 1e-9);
    }
    let said: Vec<String> = found.notes.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|note| note.contains("x1_mm=Probe 1:um")), "{said:?}");
    // The message names the column as it stands in the file.
    let text = std::fs::read_to_string(&path).unwrap().replacen("\n", "\n1,0,1,0,broken,1,1,1,1,1,1,1", 1);
    let width = header.split(',').count();
    let mut fields: Vec<&str> = text.lines().nth(2).unwrap().split(',').collect();
    fields[at("x1_mm")] = "broken";
    let text = format!("{}\n{}\n", text.lines().next().unwrap(), fields[..width].join(","));
    std::fs::write(&path, text).unwrap();
    let error = read(&path, &map, None).unwrap_err().to_string();
    assert!(error.contains("line 2, column `Probe 1`") && error.contains("`broken`"), "{error}");
}

/// Counts against degrees: each column into the unit of the sensor.
#[test]
fn counts_and_degrees_are_converted_by_the_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("encoder.csv");
    std::fs::write(&path, "t_s,pass,direction,enc,angle\n0,0,1,4096,90\n1,0,1,8192,180\n").unwrap();
    let readings = |unit: &str, revolution: f64, map: &[&str]| {
        let sensor = Sensor::Direct { unit: unit.to_string(), revolution: Some(revolution) };
        let recording = read(&path, map, Some(&sensor)).unwrap();
        (recording.reading(0), recording.reference(0).unwrap())
    };
    assert_eq!(readings("counts", 16384.0, &["measured=enc", "reference=angle:deg"]), (4096.0, 4096.0));
    assert_eq!(readings("deg", 360.0, &["measured=enc:14bit", "reference=angle"]), (90.0, 90.0));
    assert_eq!(
        readings("counts", 16384.0, &["measured=enc:counts", "reference=angle:deg"]),
        (4096.0, 4096.0)
    );
}

/// What a column of a test file holds.
enum Values {
    Numbers(Vec<Option<f64>>),
    Whole(Vec<i64>),
    Text(Vec<&'static str>),
}

fn write_parquet(path: &Path, schema: &str, columns: &[Values], compression: Compression) {
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = Arc::new(WriterProperties::builder().set_compression(compression).build());
    let mut writer = SerializedFileWriter::new(File::create(path).unwrap(), schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for column in columns {
        let mut next = group.next_column().unwrap().unwrap();
        match column {
            Values::Numbers(values) => {
                let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
                let known: Vec<f64> = values.iter().flatten().copied().collect();
                next.typed::<DoubleType>().write_batch(&known, Some(&levels), None).unwrap();
            }
            Values::Whole(values) => {
                next.typed::<Int64Type>().write_batch(values, None, None).unwrap();
            }
            Values::Text(values) => {
                let values: Vec<ByteArray> = values.iter().map(|text| ByteArray::from(*text)).collect();
                next.typed::<ByteArrayType>().write_batch(&values, None, None).unwrap();
            }
        }
        next.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

/// The default recording as a Parquet file; `edit` may change its columns.
fn calibration(path: &Path, compression: Compression, edit: impl Fn(&str, usize, f64) -> Option<f64>) {
    let mut lines = CALIBRATION.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect();
    let whole = |name: &str| matches!(name, "pass" | "direction");
    let mut schema = String::from("message recording {\n");
    let mut columns = Vec::new();
    for (index, name) in names.iter().enumerate() {
        if whole(name) {
            schema += &format!("required int64 {name};\n");
            columns.push(Values::Whole(rows.iter().map(|row| row[index] as i64).collect()));
        } else {
            schema += &format!("optional double {name};\n");
            let values =
                rows.iter().enumerate().map(|(row, values)| edit(name, row, values[index])).collect();
            columns.push(Values::Numbers(values));
        }
    }
    schema += "required binary operator (UTF8);\n}";
    columns.push(Values::Text(vec!["Ann"; rows.len()]));
    write_parquet(path, &schema, &columns, compression);
}

#[test]
fn parquet_gives_the_same_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lab.parquet");
    for compression in [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::LZ4_RAW] {
        calibration(&path, compression, |_, _, value| Some(value));
        let found = read(&path, &[], None).unwrap();
        assert_same(&found, &plain());
        assert!(found.notes.contains(&Note::TextColumn { column: "operator".into() }));
        use sha2::Digest;
        let digest = sha2::Sha256::digest(std::fs::read(&path).unwrap());
        assert_eq!(found.sha256, digest.iter().map(|byte| format!("{byte:02x}")).collect::<String>());
    }
    // What is not used is not kept, and the numbers are as fine as their shortest decimals.
    let used = |name: &String| if name == "t_s" { Use::Printed } else { Use::Ignored };
    let uses = |header: &Header| Ok(header.names.iter().map(used).collect());
    let table = Table::read(&path, &Naming::default(), &uses, &mut |_| {}).unwrap();
    assert_eq!((table.columns.len(), table.rounding), (1, 0.01));
    // A null in an optional column is a blank.
    calibration(&path, Compression::SNAPPY, |name, row, value| {
        (name != "temperature_c" || row != 7).then_some(value)
    });
    let temperature = read(&path, &[], None).unwrap().column("temperature_c").unwrap().to_vec();
    assert!(temperature[7].is_nan() && !temperature[6].is_nan());
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith")).current_dir(folder).args(arguments).output().unwrap()
}

#[test]
fn parquet_that_cannot_be_used_is_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = folder.join("lab.parquet");
    std::fs::write(folder.join("mirror.toml"), MIRROR).unwrap();
    let refused = |message: &[&str]| {
        let output = run(folder, &["fit", "lab.parquet", "--mirror", "mirror.toml", "--out", "c.json"]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(message.iter().all(|fragment| text.contains(fragment)), "{text}");
        assert!(!folder.join("c.json").exists());
    };
    calibration(&path, Compression::SNAPPY, |name, row, value| {
        (name != "x2_mm" || row != 4).then_some(value)
    });
    refused(&["lab.parquet, row 5, column `x2_mm`", "is null", "drop the row"]);
    let group =
        "message recording { required group probes { required double x1_mm; required double x2_mm; } }";
    let numbers = || Values::Numbers(vec![Some(1.0), Some(2.0)]);
    write_parquet(&path, group, &[numbers(), numbers()], Compression::SNAPPY);
    refused(&["column `probes`", "is nested"]);
    let list = "message recording { required double t_s; repeated double x1_mm; }";
    let schema = Arc::new(parse_message_type(list).unwrap());
    SerializedFileWriter::new(File::create(&path).unwrap(), schema, Arc::default()).unwrap().close().unwrap();
    refused(&["column `x1_mm`", "is nested"]);
    calibration(&path, Compression::SNAPPY, |_, _, value| Some(value));
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    refused(&["lab.parquet", "not a Parquet file that can be read"]);
}

/// Every byte of the footer lost, or another: refused in a sentence, or read; the crate's own panics are not shown.
#[test]
fn a_damaged_parquet_footer_is_reported_as_damage() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = folder.join("lab.parquet");
    calibration(&path, Compression::SNAPPY, |_, _, value| Some(value));
    let whole = std::fs::read(&path).unwrap();
    let end = whole.len() - 8;
    let length = u32::from_le_bytes(whole[end..end + 4].try_into().unwrap()) as usize;
    let mut caught = None;
    for at in end - length..end + 4 {
        let (mut shorter, mut other) = (whole.clone(), whole.clone());
        shorter.remove(at);
        other[at] ^= 0x55;
        for bytes in [shorter, other] {
            std::fs::write(&path, &bytes).unwrap();
            if let Err(error) = read(&path, &[], None)
                && error.to_string().contains("it is damaged: ")
            {
                caught = Some(bytes);
            }
        }
    }
    std::fs::write(&path, caught.expect("a footer at which the crate panics")).unwrap();
    std::fs::write(folder.join("mirror.toml"), MIRROR).unwrap();
    let output = run(folder, &["fit", "lab.parquet", "--mirror", "mirror.toml", "--out", "c.json"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && said.contains("is not a Parquet file that can be read"),
        "{said}"
    );
    assert!(!said.contains("panicked") && !said.contains("backtrace"), "{said}");
}

/// A Parquet file that comes through a pipe.
#[test]
fn parquet_is_read_from_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let (file, pipe) = (folder.path().join("lab.parquet"), folder.path().join("pipe"));
    calibration(&file, Compression::SNAPPY, |_, _, value| Some(value));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let writer = std::thread::spawn({
        let (file, pipe) = (file.clone(), pipe.clone());
        move || std::fs::write(pipe, std::fs::read(file).unwrap()).unwrap()
    });
    let found = read(&pipe, &[], None).unwrap();
    writer.join().unwrap();
    assert_same(&found, &plain());
    assert_eq!(found.sha256, read(&file, &[], None).unwrap().sha256);
}
