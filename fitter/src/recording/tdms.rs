//! Reading a recording from LabVIEW's TDMS, by the `tedium` crate: every channel of numbers is a column, under its
//! own name where the file has one group and as `group/channel` where it has several. Rows are counted from 1.

use std::fs::File;

use tedium::{ChannelPath, PropertyPath, TdmsError, TdmsFile};

use super::build::Cell;
use super::read::Reading;
use super::{Recording, RecordingError};

/// A channel's name as a column, and its values.
type Column = (String, Vec<f64>);

/// Reads the file; its hash is left blank.
pub(super) fn read(file: &str, source: File, reading: &Reading) -> Result<Recording, RecordingError> {
    let broken =
        |error: TdmsError| RecordingError::Tdms { file: file.to_string(), reason: error.to_string() };
    let mut tdms = TdmsFile::new(source).map_err(broken)?;
    let columns = columns(&mut tdms).map_err(broken)?;
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    if let Some((name, values)) = columns.iter().find(|(_, values)| values.len() != rows) {
        let (file, column, found) = (file.to_string(), name.clone(), values.len());
        return Err(RecordingError::TdmsLength { file, column, found, first: columns[0].0.clone(), rows });
    }
    let mut builder = reading.builder(file, columns.iter().map(|(name, _)| name.clone()).collect())?;
    for row in 0..rows {
        let line = row as u64 + 1;
        for (index, (_, values)) in columns.iter().enumerate() {
            builder.cell(line, index, Cell::Number(values[row]))?;
        }
        builder.row(line);
    }
    builder.finish(reading.purpose, reading.notes())
}

/// The channels that hold numbers; those of text and of absolute times are left out.
fn columns(tdms: &mut TdmsFile<File>) -> Result<Vec<Column>, TdmsError> {
    let groups: Vec<String> = tdms.list_groups().map(str::to_string).collect();
    let mut columns = Vec::new();
    for group in &groups {
        let path = PropertyPath::group(group);
        // The order of the channels is that of their paths: the same for the same file.
        let mut channels: Vec<ChannelPath> = tdms.list_channels_in_group(&path).collect();
        channels.sort_by(|a, b| a.path().cmp(b.path()));
        for channel in channels {
            let Some(length) = tdms.channel_length(&channel).filter(|length| *length > 0) else { continue };
            if let Some(values) = values(tdms, &channel, length as usize)? {
                let own = name(&channel);
                columns.push((if groups.len() > 1 { format!("{group}/{own}") } else { own }, values));
            }
        }
    }
    Ok(columns)
}

/// `/'group'/'channel'`: the last part, without its quotes.
fn name(channel: &ChannelPath) -> String {
    let path = channel.path();
    path.rsplit("/'").next().unwrap_or(path).trim_end_matches('\'').to_string()
}

/// The channel as numbers; none where it holds something else.
fn values(
    tdms: &mut TdmsFile<File>,
    channel: &ChannelPath,
    length: usize,
) -> Result<Option<Vec<f64>>, TdmsError> {
    // The crate does not tell a channel's type, but refuses to read it as another.
    macro_rules! attempt {
        ($kind:ty, $blank:expr, $number:expr) => {
            let mut values: Vec<$kind> = vec![$blank; length];
            match tdms.read_channel(channel, &mut values) {
                Ok(()) => return Ok(Some(values.into_iter().map($number).collect())),
                Err(TdmsError::DataTypeMismatch(..)) => {}
                Err(error) => return Err(error),
            }
        };
    }
    attempt!(f64, 0.0, |value| value);
    // Through text: the shortest decimal of a single-precision number is what was meant.
    attempt!(f32, 0.0, |value: f32| value.to_string().parse().unwrap_or(f64::from(value)));
    attempt!(i32, 0, f64::from);
    attempt!(i16, 0, f64::from);
    attempt!(i8, 0, f64::from);
    attempt!(u32, 0, f64::from);
    attempt!(u16, 0, f64::from);
    attempt!(u8, 0, f64::from);
    attempt!(i64, 0, |value| value as f64);
    attempt!(u64, 0, |value| value as f64);
    attempt!(bool, false, |value| f64::from(u8::from(value)));
    Ok(None)
}
