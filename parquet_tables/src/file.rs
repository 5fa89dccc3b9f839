//! Reading a recording from Parquet: plain columns of numbers (and of text, which is left out), by the `parquet`
//! crate's record reader. Rows are counted from 1 in messages.

use std::cell::Cell as Flag;
use std::fs::File;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use fitter::input::{self, LimitError};
use fitter::table::{Cell, Columns, Dialect, Naming, RecordingError, Table, Uses};

thread_local! {
    static QUIET: Flag<bool> = const { Flag::new(false) };
}

/// Reads the file; its hash is left blank.
pub(crate) fn read(file: &str, source: File, naming: &Naming, uses: &Uses) -> Result<Table, RecordingError> {
    guarded(file, || read_trusting(file, source, naming, uses))
}

/// Runs what reads a file. The crate panics at some files whose parts contradict each other: that is caught here, without
/// a word of its own, and reported as damage.
pub(crate) fn guarded<T, E: From<RecordingError>>(
    file: &str,
    read: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |panicked| {
            if !QUIET.get() {
                usual(panicked);
            }
        }));
    });
    QUIET.set(true);
    let read = panic::catch_unwind(AssertUnwindSafe(read));
    QUIET.set(false);
    read.unwrap_or_else(|panicked| {
        let text = panicked.downcast_ref::<String>().map(String::as_str);
        let text =
            text.or(panicked.downcast_ref::<&str>().copied()).unwrap_or("its parts contradict each other");
        Err(RecordingError::Parquet { file: file.to_string(), reason: format!("it is damaged: {text}") }
            .into())
    })
}

/// Refuses more than is read: the decompressed bytes that the file states, and what its rows take in memory.
fn check_size(metadata: &ParquetMetaData) -> Result<(), LimitError> {
    let stated: u64 = (metadata.row_groups().iter())
        .map(|group| u64::try_from(group.total_byte_size()).unwrap_or(u64::MAX))
        .fold(0, u64::saturating_add);
    let file = metadata.file_metadata();
    let columns = file.schema().get_fields().len();
    input::check_columns(columns)?;
    let cells = u64::try_from(file.num_rows()).unwrap_or(u64::MAX).saturating_mul(columns as u64);
    let most = input::max_bytes();
    if stated.max(cells.saturating_mul(8)) > most {
        return Err(LimitError::Bytes { most, decompressed: true });
    }
    Ok(())
}

fn read_trusting(file: &str, source: File, naming: &Naming, uses: &Uses) -> Result<Table, RecordingError> {
    let broken = |error: parquet::errors::ParquetError| RecordingError::Parquet {
        file: file.to_string(),
        reason: error.to_string(),
    };
    let reader = SerializedFileReader::new(source).map_err(broken)?;
    check_size(reader.metadata())
        .map_err(|limit| input::FileError::Limit { file: file.to_string(), limit })?;
    let mut names = Vec::new();
    for column in reader.metadata().file_metadata().schema().get_fields() {
        let info = column.get_basic_info();
        let found = if info.has_repetition() && info.repetition() == parquet::basic::Repetition::REPEATED {
            "a repeated field"
        } else if column.is_group() {
            "a group of fields"
        } else {
            names.push(column.name().to_string());
            continue;
        };
        let column = column.name().to_string();
        return Err(RecordingError::Nested { file: file.to_string(), column, found });
    }
    let mut columns = Columns::new(file, (file.to_string(), None), names, naming, uses)?;
    for (line, row) in (1..).zip(reader.get_row_iter(None).map_err(broken)?) {
        let row = row.map_err(broken)?;
        for (index, (_, field)) in row.get_column_iter().enumerate() {
            if !columns.reads(index) {
                continue;
            }
            let text = || field.to_string();
            match number_of(field) {
                // A number is as fine as its shortest decimal.
                Some(value) => columns.cell(line, index, Cell::Number(value), || value.to_string())?,
                None if matches!(field, Field::Null) => columns.cell(line, index, Cell::Null, text)?,
                None => columns.cell(line, index, Cell::Text(text().as_bytes()), text)?,
            }
        }
        columns.row(line);
    }
    columns.finish(Dialect::PLAIN)
}

/// The field as a number: times in seconds; none of text, dates and nulls.
pub(crate) fn number_of(field: &Field) -> Option<f64> {
    match field {
        Field::Bool(value) => Some(f64::from(u8::from(*value))),
        Field::Byte(value) => Some(f64::from(*value)),
        Field::Short(value) => Some(f64::from(*value)),
        Field::Int(value) => Some(f64::from(*value)),
        Field::Long(value) => Some(*value as f64),
        Field::UByte(value) => Some(f64::from(*value)),
        Field::UShort(value) => Some(f64::from(*value)),
        Field::UInt(value) => Some(f64::from(*value)),
        Field::ULong(value) => Some(*value as f64),
        // Through text: the shortest decimal of a single-precision number is what was meant.
        Field::Float(value) => value.to_string().parse().ok(),
        Field::Double(value) => Some(*value),
        Field::TimeMillis(value) => Some(1e-3 * f64::from(*value)),
        Field::TimeMicros(value) => Some(1e-6 * *value as f64),
        Field::TimestampMillis(value) => Some(1e-3 * *value as f64),
        Field::TimestampMicros(value) => Some(1e-6 * *value as f64),
        _ => None,
    }
}
