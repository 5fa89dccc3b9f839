//! Columns as Parquet files: what pandas, DuckDB, Spark and Polars read.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use codegen::refused;
use fitter::text_safety;
use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as Written};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::{Field, Row};
use parquet::schema::parser::parse_message_type;
use parquet::schema::types::Type;

use super::table::{Cells, Column};
use crate::terminal::Result;

/// A file of these columns, all of one length. The same columns give the same bytes.
pub fn file(columns: &[Column]) -> Result<Vec<u8>> {
    written(columns).map_err(|error| refused!("the table could not be written ({error})"))
}

fn written(columns: &[Column]) -> Written<Vec<u8>> {
    let fields: String = columns.iter().map(|(name, cells)| declared(name, cells)).collect();
    let schema = Arc::new(parse_message_type(&format!("message fleet {{ {fields} }}"))?);
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, cells) in columns {
        let mut column =
            group.next_column()?.ok_or_else(|| ParquetError::General("a column is missing".into()))?;
        write(column.untyped(), cells)?;
        column.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

fn declared(name: &str, cells: &Cells) -> String {
    let list = |element: &str| {
        format!("required group {name} (LIST) {{ repeated group list {{ required {element}; }} }} ")
    };
    match cells {
        Cells::Text(_) => format!("optional binary {name} (STRING); "),
        Cells::Number(_) => format!("optional double {name}; "),
        Cells::Texts(_) => list("binary element (STRING)"),
        Cells::Numbers(_) => list("double element"),
    }
}

fn write(column: &mut ColumnWriter<'_>, cells: &Cells) -> Written<()> {
    let present = |is: bool| i16::from(is);
    match (cells, column) {
        (Cells::Text(cells), ColumnWriter::ByteArrayColumnWriter(column)) => {
            let values: Vec<ByteArray> = cells.iter().flatten().map(|text| text.as_str().into()).collect();
            let levels: Vec<i16> = cells.iter().map(|cell| present(cell.is_some())).collect();
            column.write_batch(&values, Some(&levels), None)?;
        }
        (Cells::Number(cells), ColumnWriter::DoubleColumnWriter(column)) => {
            let values: Vec<f64> = cells.iter().flatten().copied().collect();
            let levels: Vec<i16> = cells.iter().map(|cell| present(cell.is_some())).collect();
            column.write_batch(&values, Some(&levels), None)?;
        }
        (Cells::Texts(cells), ColumnWriter::ByteArrayColumnWriter(column)) => {
            let values: Vec<ByteArray> = cells.iter().flatten().map(|text| text.as_str().into()).collect();
            let (levels, repeats) = levels(cells);
            column.write_batch(&values, Some(&levels), Some(&repeats))?;
        }
        (Cells::Numbers(cells), ColumnWriter::DoubleColumnWriter(column)) => {
            let (levels, repeats) = levels(cells);
            column.write_batch(&cells.concat(), Some(&levels), Some(&repeats))?;
        }
        _ => return Err(ParquetError::General("a column is of another type than its schema".into())),
    }
    Ok(())
}

/// Definition and repetition levels of lists: an empty one is a level without a value.
fn levels<T>(cells: &[Vec<T>]) -> (Vec<i16>, Vec<i16>) {
    let of = |cell: &Vec<T>| {
        (0..cell.len().max(1)).map(|k| (i16::from(!cell.is_empty()), i16::from(k > 0))).collect()
    };
    cells.iter().flat_map(|cell: &Vec<T>| -> Vec<(i16, i16)> { of(cell) }).unzip()
}

/// Reads some columns of a file that was written here, row by row.
pub fn read(path: &Path, columns: &[&str], take: &mut dyn FnMut(&Row)) -> Result<()> {
    let unreadable = |reason: String| {
        refused!("cannot be read ({reason})")
            .at(&text_safety::path(path))
            .mend("delete it, and continue with --resume")
    };
    let source = File::open(path).map_err(|error| unreadable(error.to_string()))?;
    let rows = || -> Written<()> {
        let reader = SerializedFileReader::new(source)?;
        let schema = reader.metadata().file_metadata().schema();
        let fields = schema.get_fields().iter().filter(|field| columns.contains(&field.name()));
        let wanted =
            Type::group_type_builder(schema.name()).with_fields(fields.cloned().collect()).build()?;
        for row in reader.get_row_iter(Some(wanted))? {
            take(&row?);
        }
        Ok(())
    };
    rows().map_err(|error| unreadable(error.to_string()))
}

/// A text of a row; blank where there is none.
pub fn text(row: &Row, column: &str) -> Option<String> {
    match field(row, column)? {
        Field::Str(text) => Some(text.clone()),
        _ => None,
    }
}

/// A number of a row.
pub fn number(row: &Row, column: &str) -> Option<f64> {
    match field(row, column)? {
        Field::Double(value) => Some(*value),
        _ => None,
    }
}

/// A list of texts.
pub fn texts(row: &Row, column: &str) -> Vec<String> {
    let text = |field: &Field| match field {
        Field::Str(text) => Some(text.clone()),
        _ => None,
    };
    list(row, column).iter().filter_map(text).collect()
}

/// A list of numbers.
pub fn numbers(row: &Row, column: &str) -> Vec<f64> {
    let number = |field: &Field| match field {
        Field::Double(value) => Some(*value),
        _ => None,
    };
    list(row, column).iter().filter_map(number).collect()
}

fn list<'a>(row: &'a Row, column: &str) -> &'a [Field] {
    match field(row, column) {
        Some(Field::ListInternal(list)) => list.elements(),
        _ => &[],
    }
}

fn field<'a>(row: &'a Row, column: &str) -> Option<&'a Field> {
    row.get_column_iter().find(|(name, _)| *name == column).map(|(_, field)| field)
}
