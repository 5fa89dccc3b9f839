//! The recordings of many units in one Parquet dataset: files of the same columns, one of which names the unit of a row. The
//! rows of a unit stand together in one file, so that no more than a row group is held at a time.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};
use parquet::schema::types::Type;

use fitter::table::{Cells, RecordingError};
use fitter::{errors, input, text_safety};

use crate::file::{guarded, number_of};

errors! {
    /// Why a dataset is refused.
    #[derive(Debug)]
    pub enum DatasetError {
        NoFile { folder: String } =>
            at(folder) says("holds no Parquet file") mend("name the folder or the file of the dataset");
        NoColumn { file: String, column: String, found: String } =>
            at(file) says("has no column `{column}`") expected("one of {found}") mend("name the column by its name there");
        Schema { file: String, first: String, differs: String } =>
            at(file) says("its columns are not those of {first}: {differs}")
            mend("write all files of the dataset with the same columns");
        NoName { file: String, line: u64, column: String } =>
            at(file) line(line) column(column) says("names no unit") expected("a name in every row");
        Apart { file: String, line: u64, unit: String, first: String } =>
            at(file) line(line) says("unit `{unit}` again, whose rows began in {first} and ended")
            mend("sort the dataset by the column of units, so that the rows of a unit stand together in one file; a unit that was recorded twice needs two names");
    }
    from { Recording(RecordingError) }
}

/// Where the rows of a unit stand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitRows {
    /// Its name.
    pub name: String,
    /// What stands in the further columns that were asked for, in its first row.
    pub beside: Vec<Option<String>>,
    file: usize,
    first: u64,
    rows: u64,
}

/// See the module.
#[derive(Debug)]
pub struct Dataset {
    files: Vec<PathBuf>,
    /// The columns that say something of the unit, and are none of its recording.
    of_unit: Vec<String>,
    /// The units in the order of their rows.
    pub units: Vec<UnitRows>,
}

/// The columns of one unit.
pub type Columns = Vec<(String, Cells)>;

impl Dataset {
    /// Finds the units of these files by the column `unit`, and what the columns `beside` say of each. Reads no other
    /// column.
    ///
    /// # Errors
    /// [`DatasetError`].
    pub fn open(files: Vec<PathBuf>, unit: &str, beside: &[&str]) -> Result<Dataset, DatasetError> {
        let of_unit: Vec<String> =
            std::iter::once(&unit).chain(beside).map(|name| name.to_string()).collect();
        let mut dataset = Dataset { files, of_unit, units: Vec::new() };
        let mut begun = BTreeMap::new();
        let mut schema = None;
        for number in 0..dataset.files.len() {
            let file = dataset.name(number);
            guarded(&file, || dataset.index(number, &mut schema, &mut begun))?;
        }
        Ok(dataset)
    }

    /// The name of the file in which a unit stands.
    pub fn file_of(&self, unit: &UnitRows) -> String {
        text_safety::file_name(&self.files[unit.file])
    }

    /// Reads some units, one after the other, each given to `take` with its number. `take` says whether to go on.
    ///
    /// # Errors
    /// [`RecordingError`] of a file that cannot be read.
    pub fn read(
        &self,
        units: Range<usize>,
        take: &mut dyn FnMut(usize, Columns) -> bool,
    ) -> Result<(), RecordingError> {
        let mut next = units.start;
        while next < units.end {
            let file = self.units[next].file;
            let last = (next..units.end).take_while(|unit| self.units[*unit].file == file).last();
            let end = last.map_or(next + 1, |last| last + 1);
            if !guarded(&self.name(file), || self.read_file(file, next..end, take))? {
                break;
            }
            next = end;
        }
        Ok(())
    }

    fn name(&self, file: usize) -> String {
        text_safety::path(&self.files[file])
    }

    fn reader(&self, file: usize) -> Result<SerializedFileReader<File>, RecordingError> {
        let name = self.name(file);
        let source =
            File::open(&self.files[file]).map_err(|error| RecordingError::of(&name, &error, false))?;
        SerializedFileReader::new(source).map_err(|error| broken(&name, error))
    }

    /// Adds the units of a file.
    fn index(
        &mut self,
        number: usize,
        schema: &mut Option<(String, BTreeMap<String, String>)>,
        begun: &mut BTreeMap<String, String>,
    ) -> Result<(), DatasetError> {
        let file = self.name(number);
        let reader = self.reader(number)?;
        let metadata = reader.metadata().file_metadata();
        let fields = metadata.schema().get_fields();
        input::check_columns(fields.len())
            .map_err(|limit| RecordingError::from(input::FileError::Limit { file: file.clone(), limit }))?;
        let names: Vec<&str> = fields.iter().map(|field| field.name()).collect();
        for column in &self.of_unit {
            if !names.contains(&column.as_str()) {
                let (column, found) = (column.clone(), names.join(", "));
                return Err(DatasetError::NoColumn { file, column, found });
            }
        }
        same_schema(&file, fields, schema)?;
        let wanted = self.of_unit.iter().filter_map(|name| fields.iter().find(|field| field.name() == name));
        let projection =
            Type::group_type_builder(metadata.schema().name()).with_fields(wanted.cloned().collect());
        let projection = projection.build().map_err(|error| broken(&file, error))?;
        let rows = reader.get_row_iter(Some(projection)).map_err(|error| broken(&file, error))?;
        for (row, read) in (0..).zip(rows) {
            let read = read.map_err(|error| broken(&file, error))?;
            let said: Vec<Option<String>> = self.of_unit.iter().map(|name| said(&read, name)).collect();
            let Some(name) = said[0].clone().filter(|name| !name.is_empty()) else {
                let column = self.of_unit[0].clone();
                return Err(DatasetError::NoName { file, line: row + 1, column });
            };
            match self.units.last_mut().filter(|unit| unit.file == number && unit.name == name) {
                Some(unit) => unit.rows += 1,
                None => {
                    if let Some(first) = begun.insert(name.clone(), file.clone()) {
                        return Err(DatasetError::Apart {
                            file,
                            line: row + 1,
                            unit: text_safety::shown(&name),
                            first,
                        });
                    }
                    let beside = said[1..].to_vec();
                    self.units.push(UnitRows { name, beside, file: number, first: row, rows: 1 });
                }
            }
        }
        Ok(())
    }

    /// Reads units of one file; whether to go on. Row groups before them are passed over.
    fn read_file(
        &self,
        file: usize,
        units: Range<usize>,
        take: &mut dyn FnMut(usize, Columns) -> bool,
    ) -> Result<bool, RecordingError> {
        let name = self.name(file);
        let reader = self.reader(file)?;
        let mut current = units.start;
        let mut columns: Vec<(String, Vec<Field>)> = Vec::new();
        let mut row = 0;
        for group in 0..reader.num_row_groups() {
            let rows = u64::try_from(reader.metadata().row_group(group).num_rows()).unwrap_or(0);
            if current == units.end || row + rows <= self.units[current].first {
                row += rows;
                continue;
            }
            let group = reader.get_row_group(group).map_err(|error| broken(&name, error))?;
            for read in group.get_row_iter(None).map_err(|error| broken(&name, error))? {
                let read = read.map_err(|error| broken(&name, error))?;
                row += 1;
                if current == units.end || row <= self.units[current].first {
                    continue;
                }
                self.push(&mut columns, &read);
                if row == self.units[current].first + self.units[current].rows {
                    let whole = std::mem::take(&mut columns);
                    if !take(current, whole.into_iter().map(|(name, fields)| (name, cells(fields))).collect())
                    {
                        return Ok(false);
                    }
                    current += 1;
                }
            }
        }
        match current == units.end {
            true => Ok(true),
            false => {
                Err(RecordingError::Parquet { file: name, reason: "it has fewer rows than before".into() })
            }
        }
    }

    fn push(&self, columns: &mut Vec<(String, Vec<Field>)>, row: &Row) {
        let own = row.get_column_iter().filter(|(name, _)| !self.of_unit.contains(name));
        for (index, (name, field)) in own.enumerate() {
            if columns.len() == index {
                columns.push((name.clone(), Vec::new()));
            }
            columns[index].1.push(field.clone());
        }
    }
}

fn broken(file: &str, error: parquet::errors::ParquetError) -> RecordingError {
    RecordingError::Parquet { file: file.to_string(), reason: error.to_string() }
}

/// Refuses columns that are not those of the first file.
fn same_schema(
    file: &str,
    fields: &[Arc<Type>],
    first: &mut Option<(String, BTreeMap<String, String>)>,
) -> Result<(), DatasetError> {
    let kind = |field: &Arc<Type>| match field.is_primitive() {
        true => field.get_physical_type().to_string(),
        false => "a group of fields".into(),
    };
    let own: BTreeMap<String, String> =
        fields.iter().map(|field| (field.name().to_string(), kind(field))).collect();
    let Some((first, known)) = first else {
        *first = Some((file.to_string(), own));
        return Ok(());
    };
    let differs = |(name, kind): (&String, &String)| match own.get(name) {
        Some(other) if other == kind => None,
        Some(other) => Some(format!("`{name}` is {other} and was {kind}")),
        None => Some(format!("`{name}` is missing")),
    };
    let further =
        || own.keys().find(|name| !known.contains_key(*name)).map(|name| format!("`{name}` is new"));
    match known.iter().find_map(differs).or_else(further) {
        None => Ok(()),
        Some(differs) => Err(DatasetError::Schema { file: file.to_string(), first: first.clone(), differs }),
    }
}

/// What a row says in a column, as text; none of a null.
fn said(row: &Row, column: &str) -> Option<String> {
    let (_, field) = row.get_column_iter().find(|(name, _)| *name == column)?;
    match field {
        Field::Null => None,
        Field::Str(text) => Some(text.clone()),
        field => Some(number_of(field).map_or_else(|| field.to_string(), |number| number.to_string())),
    }
}

/// Numbers where there is no text.
fn cells(fields: Vec<Field>) -> Cells {
    let is_text = |field: &Field| !matches!(field, Field::Null) && number_of(field).is_none();
    if !fields.iter().any(is_text) {
        return Cells::Nullable(fields.iter().map(number_of).collect());
    }
    let text = |field: Field| match field {
        Field::Null => None,
        Field::Str(text) => Some(text),
        field => Some(field.to_string()),
    };
    Cells::Texts(fields.into_iter().map(text).collect())
}
