//! Where the units of a fleet come from: a folder of recordings, one for each unit, or a Parquet dataset with a column that
//! names them.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use codegen::refused;
use fitter::table::Cells;
use fitter::{Recording, RecordingError, text_safety};
use parquet_tables::dataset::{Columns, Dataset, DatasetError};
use rayon::prelude::*;

use super::answer::{Answer, Asked, Unit};
use crate::terminal::Result;

/// Ends of names of recordings; each may be followed by `.gz`.
const ENDS: [&str; 4] = [".csv", ".tsv", ".txt", ".parquet"];
/// Bytes of units of a dataset that are held before they are diagnosed.
const HELD: usize = 64 << 20;

/// The columns of a dataset that say something of a unit.
pub struct OfUnit<'a> {
    /// Its name; none where DATA is a folder of recordings.
    pub unit: Option<&'a str>,
    /// Its lot.
    pub lot: Option<&'a str>,
    /// Its time.
    pub time: Option<&'a str>,
}

/// The units, in the order of their names or of their rows.
pub struct Source {
    /// What is known of each.
    pub units: Vec<Unit>,
    place: Place,
}

enum Place {
    Files(Vec<PathBuf>),
    Dataset(Dataset),
}

impl Source {
    /// Finds the units. Refuses two of one name.
    pub fn find(data: &Path, columns: &OfUnit) -> Result<Source> {
        match columns.unit {
            Some(unit) => Source::of_dataset(data, unit, columns),
            None => Source::of_folder(data),
        }
    }

    fn of_folder(data: &Path) -> Result<Source> {
        if data.is_file() {
            return Err(refused!("is one file")
                .at(&text_safety::path(data))
                .expected("a folder of recordings")
                .mend(
                    "name the folder; of a Parquet dataset say which column names the unit: --unit COLUMN",
                ));
        }
        let mut units: BTreeMap<String, PathBuf> = BTreeMap::new();
        for path in files(data)? {
            let Some(name) = unit_of(&path) else { continue };
            if let Some(first) = units.insert(name.clone(), path.clone()) {
                let [first, path] = [&first, &path].map(|path| text_safety::path(path));
                return Err(refused!("{first} and {path} are both unit `{name}`")
                    .mend("rename one: every unit needs a name of its own"));
            }
        }
        if units.is_empty() {
            return Err(refused!("holds no recording")
                .at(&text_safety::path(data))
                .expected(format_args!("files that end in {}, or in .gz after that", ENDS.join(", ")))
                .mend("name the folder of the recordings"));
        }
        let (names, files): (Vec<String>, Vec<PathBuf>) = units.into_iter().unzip();
        let unit = |(name, path): (String, &PathBuf)| Unit {
            name,
            file: text_safety::file_name(path),
            ..Unit::default()
        };
        Ok(Source { units: names.into_iter().zip(&files).map(unit).collect(), place: Place::Files(files) })
    }

    fn of_dataset(data: &Path, unit: &str, columns: &OfUnit) -> Result<Source> {
        let files = if data.is_dir() { parquet_files(data)? } else { vec![data.to_owned()] };
        let beside: Vec<&str> = [columns.lot, columns.time].into_iter().flatten().collect();
        if files.is_empty() {
            return Err(DatasetError::NoFile { folder: text_safety::path(data) }.into());
        }
        let dataset = Dataset::open(files, unit, &beside)?;
        let mut units = Vec::new();
        for rows in &dataset.units {
            let mut said = rows.beside.iter();
            let mut next = |wanted: Option<&str>| wanted.and_then(|_| said.next().cloned().flatten());
            let (lot, time) = (next(columns.lot), next(columns.time));
            let number = |text: String| match text.parse::<f64>() {
                Ok(time) if time.is_finite() => Ok(time),
                _ => Err(refused!("unit `{}`", text_safety::shown(&rows.name))
                    .at(&dataset.file_of(rows))
                    .column(columns.time.unwrap_or_default())
                    .cell(&text)
                    .expected("a number")),
            };
            let time = time.map(number).transpose()?;
            units.push(Unit { name: rows.name.clone(), file: dataset.file_of(rows), lot, time });
        }
        Ok(Source { units, place: Place::Dataset(dataset) })
    }

    /// Diagnoses some units, several at a time, in their order; `done` is called after each.
    pub fn answers(
        &self,
        units: Range<usize>,
        asked: &Asked,
        done: &(dyn Fn() + Sync),
    ) -> Result<Vec<Answer>> {
        let answer = |number: usize, recording: std::result::Result<Recording, RecordingError>| {
            let answer = asked.answer(self.units[number].clone(), recording);
            done();
            answer
        };
        match &self.place {
            Place::Files(paths) => {
                let read = |number: usize| Recording::read_as(&paths[number], &asked.reading(), &mut |_| {});
                Ok(units.into_par_iter().map(|number| answer(number, read(number))).collect())
            }
            Place::Dataset(dataset) => {
                let mut answers = Vec::with_capacity(units.len());
                let mut next = units.start;
                while next < units.end {
                    let held = held(dataset, next..units.end)?;
                    next += held.len();
                    let of = |(number, columns): (usize, Columns)| {
                        let name = format!("unit {}, table", text_safety::shown(&self.units[number].name));
                        answer(number, Recording::of_columns(&name, columns, &asked.reading()))
                    };
                    answers.par_extend(held.into_par_iter().map(of));
                }
                Ok(answers)
            }
        }
    }
}

/// As many of the next units as are held at a time.
fn held(dataset: &Dataset, units: Range<usize>) -> Result<Vec<(usize, Columns)>> {
    let (mut held, mut bytes) = (Vec::new(), 0);
    dataset.read(units, &mut |number, columns| {
        bytes += columns.iter().map(|(_, cells)| size(cells)).sum::<usize>();
        held.push((number, columns));
        bytes < HELD
    })?;
    Ok(held)
}

fn size(cells: &Cells) -> usize {
    match cells {
        Cells::Numbers(values) => 8 * values.len(),
        Cells::Nullable(values) => 16 * values.len(),
        Cells::Texts(values) => values.iter().map(|text| 24 + text.as_ref().map_or(0, String::len)).sum(),
        Cells::Nested { .. } => 0,
    }
}

/// The name of the unit whose recording this file is; none of another file.
fn unit_of(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    let plain = name.strip_suffix(".gz").unwrap_or(&name);
    ENDS.iter().find_map(|end| plain.strip_suffix(end)).filter(|stem| !stem.is_empty()).map(str::to_string)
}

/// The files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let unreadable = |error: std::io::Error| {
        refused!("cannot be read ({})", error.kind())
            .at(&text_safety::path(folder))
            .expected("a folder of recordings")
    };
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let mut paths = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(unreadable)?;
    paths.sort();
    Ok(paths.into_iter().filter(|path| !path.is_dir()).collect())
}

/// The Parquet files below a folder, as an engine partitions a dataset.
fn parquet_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = files(folder)?;
    found.retain(|path| path.extension().is_some_and(|end| end == "parquet"));
    let entries = std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    for inner in entries.collect::<std::io::Result<Vec<_>>>()?.into_iter().filter(|path| path.is_dir()) {
        found.extend(parquet_files(&inner)?);
    }
    found.sort();
    Ok(found)
}
