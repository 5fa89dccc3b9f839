//! LabVIEW's TDMS: the same recording as from CSV, and messages for files that cannot be used.
#![cfg(feature = "tdms")]

mod common;

use std::path::Path;

use common::Device;
use fitter::Recording;
use tedium::{ChannelPath, DataLayout, TdmsFile};

/// Columns of a recording by name, as CSV has them.
fn columns(csv: &str) -> Vec<(String, Vec<f64>)> {
    let mut lines = csv.lines();
    let mut columns: Vec<(String, Vec<f64>)> =
        lines.next().unwrap().split(',').map(|name| (name.to_string(), Vec::new())).collect();
    for line in lines {
        for (column, field) in columns.iter_mut().zip(line.split(',')) {
            column.1.push(field.parse().unwrap());
        }
    }
    columns
}

/// Writes channels in two segments, interleaved or not; whole numbers as such.
fn write(path: &Path, group: &str, columns: &[(String, Vec<f64>)], layout: DataLayout) {
    let mut file = TdmsFile::create(path).unwrap();
    let mut writer = file.writer().unwrap();
    let rows = columns[0].1.len();
    for (from, to) in [(0, rows / 3), (rows / 3, rows)] {
        let mut flat = Vec::new();
        match layout {
            DataLayout::Interleaved => {
                (from..to).for_each(|row| flat.extend(columns.iter().map(|(_, values)| values[row])))
            }
            DataLayout::Contigious => columns.iter().for_each(|(_, values)| flat.extend(&values[from..to])),
        }
        let channels: Vec<ChannelPath> =
            columns.iter().map(|(name, _)| ChannelPath::new(group, name)).collect();
        writer.write_channels(&channels, &flat, layout).unwrap();
    }
}

#[test]
fn tdms_gives_the_same_recording_as_csv() {
    let folder = tempfile::tempdir().unwrap();
    let csv = Device::paper().csv(1);
    let expected = Recording::from_bytes("c.csv", csv.as_bytes()).unwrap();
    let columns = columns(&csv);
    for layout in [DataLayout::Interleaved, DataLayout::Contigious] {
        let path = folder.path().join("c.tdms");
        write(&path, "Calibration", &columns, layout);
        let found = Recording::read(&path).unwrap();
        assert_eq!(
            (&found.time_s, &found.pass, &found.direction),
            (&expected.time_s, &expected.pass, &expected.direction)
        );
        assert_eq!(found.readings, expected.readings);
        assert_eq!(found.sha256.len(), 64);
    }
}

#[test]
fn a_file_that_cannot_be_used_gets_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.tdms");
    let mut columns = columns(&Device::paper().csv(1));
    let refused = |words: &[&str]| {
        let message = Recording::read(&path).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    // One channel goes on after the others.
    let mut file = TdmsFile::create(&path).unwrap();
    let mut writer = file.writer().unwrap();
    for (name, values) in &columns {
        writer.write_channels(&[ChannelPath::new("g", name)], values, DataLayout::Contigious).unwrap();
    }
    writer.write_channels(&[ChannelPath::new("g", "x1_mm")], &[0.0], DataLayout::Contigious).unwrap();
    drop(writer);
    drop(file);
    refused(&["column `", "211", "210", "file of their own"]);

    columns.retain(|(name, _)| name != "x2_mm");
    write(&path, "g", &columns, DataLayout::Contigious);
    refused(&["column `x2_mm` is missing"]);

    let whole = std::fs::read(&path).unwrap();
    for length in [40, whole.len() - 100] {
        std::fs::write(&path, &whole[..length]).unwrap();
        refused(&["is not a TDMS file that can be read"]);
    }
}
