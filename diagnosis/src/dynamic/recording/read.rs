//! Reading a dynamic recording from CSV or CSV.gz, every cell checked.

use std::io::Read;
use std::path::Path;

use csv::{ByteRecord, ErrorKind};
use fitter::RecordingError;
use fitter::input;
use fitter::recording::{Place, safe_column};
use fitter::text_safety;
use sha2::{Digest, Sha256};

use super::{DynamicRecording, checks, faults};
use crate::dynamic::fault::DynamicError;

impl DynamicRecording {
    /// Reads the recording at `path`; `command` is the column that the controller followed, where the plant
    /// names one.
    ///
    /// # Errors
    /// One of [`DynamicError`].
    pub fn read(path: &Path, command: Option<&str>) -> Result<DynamicRecording, DynamicError> {
        let shown = text_safety::path(path);
        if path.is_dir() {
            return Err(RecordingError::IsDirectory { file: shown }.into());
        }
        let bytes = input::bytes(path).map_err(|error| RecordingError::of(&shown, &error, false))?;
        let mut recording = DynamicRecording::from_bytes(&shown, &bytes, command)?;
        recording.file = text_safety::file_name(path);
        Ok(recording)
    }

    /// Reads from bytes; `file` is the name in messages, and one that ends in `.gz` is decompressed.
    ///
    /// # Errors
    /// As [`DynamicRecording::read`].
    pub fn from_bytes(
        file: &str,
        bytes: &[u8],
        command: Option<&str>,
    ) -> Result<DynamicRecording, DynamicError> {
        let sha256: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        let text = input::text(bytes, input::is_gzip(file, bytes));
        let mut recording = parse(file, text, command)?;
        recording.sha256 = sha256;
        Ok(recording)
    }
}

/// The columns that are read, in the order in which they are kept.
struct Header {
    names: Vec<String>,
    time: usize,
    drives: Vec<usize>,
    positions: Vec<usize>,
    run: Option<usize>,
    period: Option<usize>,
    amplitude: Option<usize>,
    command: Option<usize>,
}

impl Header {
    fn new(file: &str, names: Vec<String>, command: Option<&str>) -> Result<Header, DynamicError> {
        for (k, name) in names.iter().enumerate() {
            if name.is_empty() {
                return Err(RecordingError::UnnamedColumn { file: file.into(), number: k + 1 }.into());
            }
            if names[..k].contains(name) {
                let column = name.clone();
                return Err(RecordingError::DoubledColumn { file: file.into(), column }.into());
            }
            safe_column(file, k, name)?;
        }
        let find = |name: &str| names.iter().position(|n| n == name);
        let missing = |column: &str| RecordingError::MissingColumn {
            file: file.into(),
            column: column.into(),
            found: names.join(", "),
            similar: None,
        };
        let channels = |name: &str| -> Vec<usize> {
            match find(name) {
                Some(k) => vec![k],
                None => (1..).map_while(|i| find(&format!("{name}_{i}"))).collect(),
            }
        };
        let (drives, positions) = (channels("drive"), channels("position"));
        if drives.is_empty() {
            return Err(missing("drive").into());
        }
        if positions.is_empty() {
            return Err(missing("position").into());
        }
        let command = match command {
            None => None,
            Some(name) => Some(find(name).ok_or_else(|| DynamicError::Feedback {
                file: file.into(),
                column: name.into(),
                found: names.join(", "),
            })?),
        };
        Ok(Header {
            time: find("t_s").ok_or_else(|| missing("t_s"))?,
            drives,
            positions,
            run: find("run"),
            period: find("period"),
            amplitude: find("amplitude"),
            command,
            names,
        })
    }
}

fn parse<R: Read>(file: &str, text: R, command: Option<&str>) -> Result<DynamicRecording, DynamicError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text);
    let names: Vec<String> = match reader.headers() {
        Ok(headers) => headers.iter().map(String::from).collect(),
        Err(error) => return Err(fault(file, &error, 1).into()),
    };
    if names.is_empty() {
        return Err(RecordingError::Empty { file: file.into() }.into());
    }
    if names.len() == 1 && names[0].contains([';', '\t']) {
        return Err(RecordingError::Separator { file: file.into(), found: "semicolons or tabs" }.into());
    }
    input::check_columns(names.len()).map_err(|limit| RecordingError::Limit { file: file.into(), limit })?;
    let header = Header::new(file, names, command)?;
    let mut wanted: Vec<usize> = vec![header.time];
    wanted.extend(&header.drives);
    wanted.extend(&header.positions);
    wanted.extend([header.run, header.period, header.amplitude, header.command].iter().flatten());
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); header.names.len()];
    let mut lines: Vec<u64> = Vec::new();
    let mut decimals = 0;
    let mut row = ByteRecord::new();
    loop {
        match reader.read_byte_record(&mut row) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => return Err(fault(file, &error, lines.last().map_or(2, |l| l + 1)).into()),
        }
        let line = row.position().map_or(0, csv::Position::line);
        for &column in &wanted {
            let cell = row.get(column).unwrap_or_default();
            let place = || Place { file: file.into(), line, column: header.names[column].clone() };
            let shown = String::from_utf8_lossy(cell);
            if cell.is_empty() {
                return Err(RecordingError::Blank { place: place() }.into());
            }
            let value: f64 = shown
                .parse()
                .map_err(|_| RecordingError::NotANumber { place: place(), found: text_safety::cell(cell) })?;
            if !value.is_finite() {
                return Err(
                    RecordingError::NotFinite { place: place(), found: text_safety::cell(cell) }.into()
                );
            }
            columns[column].push(value);
            if column == header.time {
                decimals = decimals.max(printed_decimals(&shown));
            }
        }
        lines.push(line);
    }
    if lines.is_empty() {
        return Err(RecordingError::NoRows { file: file.into() }.into());
    }
    build(file, &header, columns, &lines, 10f64.powi(-decimals))
}

/// Power of ten of the last printed digit, negated: 4 of `0.0005`, 7 of `5e-7`.
fn printed_decimals(text: &str) -> i32 {
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().unwrap_or(0)),
        None => (text, 0),
    };
    mantissa.split_once('.').map_or(0, |(_, digits)| digits.len() as i32) - exponent
}

fn build(
    file: &str,
    header: &Header,
    mut columns: Vec<Vec<f64>>,
    lines: &[u64],
    resolution_s: f64,
) -> Result<DynamicRecording, DynamicError> {
    let mut take = |column: usize| std::mem::take(&mut columns[column]);
    let t_s = take(header.time);
    let whole = |values: Vec<f64>, column: &'static str| -> Result<Vec<i64>, DynamicError> {
        match values.iter().position(|v| v.fract() != 0.0 || v.abs() > 1e15) {
            Some(k) => {
                Err(DynamicError::Whole { file: file.into(), line: lines[k], column, found: values[k] })
            }
            None => Ok(values.iter().map(|v| *v as i64).collect()),
        }
    };
    let run = header.run.map(|c| whole(take(c), "run")).transpose()?;
    let period = header.period.map(|c| whole(take(c), "period")).transpose()?;
    let (mut runs, mut run_numbers) = (Vec::new(), Vec::new());
    match &run {
        None => {
            runs.push(0..t_s.len());
            run_numbers.push(0);
        }
        Some(run) => {
            let mut start = 0;
            for k in 1..=run.len() {
                if k == run.len() || run[k] != run[start] {
                    runs.push(start..k);
                    run_numbers.push(run[start]);
                    start = k;
                }
            }
        }
    }
    let step_s = checks::step(file, &t_s, &runs, lines, resolution_s)?;
    let names = [&header.drives, &header.positions]
        .map(|group| group.iter().map(|c| header.names[*c].clone()).collect::<Vec<_>>());
    let [mut drives, mut positions] =
        [&header.drives, &header.positions].map(|group| group.iter().map(|c| take(*c)).collect::<Vec<_>>());
    let mut bad_rows = Vec::new();
    for (group, names, is_position) in [(&mut drives, &names[0], false), (&mut positions, &names[1], true)] {
        for (values, name) in group.iter_mut().zip(names) {
            let listed = faults::mend(file, name, values, &runs, lines, is_position).map_err(Box::new)?;
            bad_rows.extend(listed);
        }
    }
    let recording = DynamicRecording {
        file: file.into(),
        sha256: String::new(),
        step_s,
        drives,
        positions,
        bad_rows,
        runs,
        run_numbers,
        period,
        amplitude: header.amplitude.map(&mut take),
        command: header.command.map(&mut take),
        t_s,
    };
    checks::columns(&recording, &names, lines)?;
    Ok(recording)
}

/// What the CSV reader, or the decompression below it, complains of.
fn fault(file: &str, error: &csv::Error, line: u64) -> RecordingError {
    let file = file.to_string();
    match error.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => RecordingError::FieldCount {
            file,
            line: pos.as_ref().map_or(line, csv::Position::line),
            found: *len,
            expected: *expected_len,
        },
        ErrorKind::Utf8 { .. } => RecordingError::NotText { file, line },
        ErrorKind::Io(error) => RecordingError::of(&file, error, file.ends_with(".gz")),
        _ => RecordingError::Unreadable { file, reason: error.to_string() },
    }
}
