//! From a column of Arrow's memory format to cells: 64-bit floats without nulls in one piece are lent, all else is converted.

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef};
use arrow_cast::cast;
use arrow_schema::{ArrowError, DataType, TimeUnit};
use fitter::table::{Cells, Values};

/// A column of a table, and whether it holds timestamps.
pub struct Taken {
    /// Its cells.
    pub cells: Cells,
    /// Whether its numbers are seconds since its first timestamp.
    pub timestamps: bool,
}

impl From<Cells> for Taken {
    fn from(cells: Cells) -> Taken {
        Taken { cells, timestamps: false }
    }
}

/// Takes a column that lies in these pieces.
pub fn take(pieces: &[ArrayRef], kind: &DataType) -> Result<Taken, ArrowError> {
    let rows = pieces.iter().map(|piece| piece.len()).sum();
    let nested = |found| Ok(Cells::Nested { rows, found }.into());
    match kind {
        DataType::Float64 => Ok(lent(pieces).unwrap_or_else(|| numbers(pieces)).into()),
        // Through text: the shortest decimal of a single-precision number is what was meant.
        DataType::Float32 => {
            let meant = |value: f32| value.to_string().parse().unwrap_or_else(|_| f64::from(value));
            let all = pieces.iter().flat_map(|piece| piece.as_primitive::<Float32Type>().iter());
            Ok(of_optional(all.map(|value| value.map(meant)).collect()).into())
        }
        DataType::Null => Ok(Cells::Nullable(vec![None; rows]).into()),
        DataType::Boolean | DataType::Decimal128(..) | DataType::Decimal256(..) => as_numbers(pieces),
        kind if kind.is_numeric() => as_numbers(pieces),
        DataType::Timestamp(..) | DataType::Date32 | DataType::Date64 => timestamps(pieces),
        DataType::Duration(unit) => durations(pieces, *unit),
        DataType::Time32(unit) | DataType::Time64(unit) => durations(pieces, *unit),
        DataType::Dictionary(_, inner) => take(&all_as(pieces, inner)?, inner),
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => texts(pieces),
        DataType::List(_)
        | DataType::LargeList(_)
        | DataType::FixedSizeList(..)
        | DataType::ListView(_)
        | DataType::LargeListView(_) => nested("a list"),
        DataType::Struct(_) => nested("a group of fields"),
        DataType::Map(..) => nested("a map"),
        other => Ok(Cells::Texts(vec![Some(other.to_string()); rows]).into()),
    }
}

/// The numbers where they lie.
fn lent(pieces: &[ArrayRef]) -> Option<Cells> {
    let [one] = pieces else { return None };
    let numbers = one.as_primitive::<Float64Type>();
    (numbers.null_count() == 0).then(|| Cells::Numbers(Values::lent(Arc::new(numbers.values().clone()))))
}

fn numbers(pieces: &[ArrayRef]) -> Cells {
    of_optional(pieces.iter().flat_map(|piece| piece.as_primitive::<Float64Type>().iter()).collect())
}

/// Numbers where all are there, else numbers and nulls.
pub fn of_optional(values: Vec<Option<f64>>) -> Cells {
    if values.contains(&None) {
        Cells::Nullable(values)
    } else {
        Cells::Numbers(values.into_iter().flatten().collect())
    }
}

fn all_as(pieces: &[ArrayRef], kind: &DataType) -> Result<Vec<ArrayRef>, ArrowError> {
    pieces.iter().map(|piece| cast(piece, kind)).collect()
}

fn as_numbers(pieces: &[ArrayRef]) -> Result<Taken, ArrowError> {
    Ok(numbers(&all_as(pieces, &DataType::Float64)?).into())
}

fn whole(pieces: &[ArrayRef]) -> Result<Vec<Option<i64>>, ArrowError> {
    let pieces = all_as(pieces, &DataType::Int64)?;
    Ok(pieces.iter().flat_map(|piece| piece.as_primitive::<Int64Type>().iter()).collect())
}

/// Ticks of a clock in a second.
fn per_second(unit: TimeUnit) -> f64 {
    match unit {
        TimeUnit::Second => 1.0,
        TimeUnit::Millisecond => 1e3,
        TimeUnit::Microsecond => 1e6,
        TimeUnit::Nanosecond => 1e9,
    }
}

fn durations(pieces: &[ArrayRef], unit: TimeUnit) -> Result<Taken, ArrowError> {
    let second = per_second(unit);
    let ticks = whole(pieces)?;
    Ok(of_optional(ticks.into_iter().map(|ticks| Some(ticks? as f64 / second)).collect()).into())
}

/// Seconds since the first timestamp: the difference of whole ticks is exact.
fn timestamps(pieces: &[ArrayRef]) -> Result<Taken, ArrowError> {
    let (unit, zone) = match pieces.first().map(|piece| piece.data_type()) {
        Some(DataType::Timestamp(unit, zone)) => (*unit, zone.clone()),
        _ => (TimeUnit::Millisecond, None),
    };
    let ticks = whole(&all_as(pieces, &DataType::Timestamp(unit, zone))?)?;
    Ok(Taken { cells: since_first(&ticks, unit), timestamps: true })
}

/// Seconds since the first of these instants.
pub fn since_first(ticks: &[Option<i64>], unit: TimeUnit) -> Cells {
    let first = ticks.iter().flatten().next().copied().unwrap_or(0);
    let second = per_second(unit);
    let since = |ticks: i64| (i128::from(ticks) - i128::from(first)) as f64 / second;
    of_optional(ticks.iter().map(|ticks| ticks.map(since)).collect())
}

fn texts(pieces: &[ArrayRef]) -> Result<Taken, ArrowError> {
    let pieces = all_as(pieces, &DataType::LargeUtf8)?;
    let all = pieces.iter().flat_map(|piece| piece.as_string::<i64>().iter());
    Ok(Cells::Texts(all.map(|text| text.map(str::to_string)).collect()).into())
}
