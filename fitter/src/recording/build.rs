//! From cells, row by row, to a checked recording: the same for every kind of file.

use super::checks::{self, Lines, Watch};
use super::header::{Header, Role};
use super::mapping::Conversion;
use super::read::Purpose;
use super::{Column, Note, Place, Readings, Recording, RecordingError};
use crate::text_safety;

/// What stands in a cell.
pub(super) enum Cell<'a> {
    /// Nothing.
    Blank,
    /// A null of a file that knows them.
    #[cfg_attr(not(feature = "parquet"), allow(dead_code))]
    Null,
    Number(f64),
    /// What is no number, as it stands there.
    Text(&'a [u8]),
}

/// Whether a further column holds numbers; decided by its first cell that is not blank.
#[derive(Clone, Copy, PartialEq)]
enum Content {
    Unknown,
    Numbers,
    Text,
}

/// A recording that is being read.
pub(super) struct Builder<'a> {
    file: &'a str,
    pub header: Header,
    /// Per column of the file.
    conversions: Vec<Option<Conversion>>,
    /// The columns' names in the file, for messages.
    shown: Vec<String>,
    content: Vec<Content>,
    time_s: Vec<f64>,
    pass: Vec<i32>,
    direction: Vec<i8>,
    command: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    reference: Vec<f64>,
    further: Vec<Vec<f64>>,
    watch: Watch,
    lines: Lines,
}

impl<'a> Builder<'a> {
    pub fn new(
        file: &'a str,
        header: Header,
        conversions: Vec<Option<Conversion>>,
        shown: Vec<String>,
    ) -> Builder<'a> {
        let further = header.further.len();
        Builder {
            file,
            header,
            conversions,
            shown,
            content: vec![Content::Unknown; further],
            time_s: Vec::new(),
            pass: Vec::new(),
            direction: Vec::new(),
            command: Vec::new(),
            first: Vec::new(),
            second: Vec::new(),
            reference: Vec::new(),
            further: vec![Vec::new(); further],
            watch: Watch::default(),
            lines: Lines::default(),
        }
    }

    /// Number of columns of a row.
    pub fn columns(&self) -> usize {
        self.header.roles.len()
    }

    /// Where the column `index` of line `line` is, for a message.
    pub fn place(&self, line: u64, index: usize) -> Place {
        Place { file: self.file.to_string(), line, column: self.shown[index].clone() }
    }

    /// Takes the cell of column `index` on `line`.
    pub fn cell(&mut self, line: u64, index: usize, cell: Cell) -> Result<(), RecordingError> {
        match self.header.roles[index] {
            Role::Time => self.time_s.push(self.needed(line, index, cell)?),
            Role::First => self.first.push(self.needed(line, index, cell)?),
            Role::Second => self.second.push(self.needed(line, index, cell)?),
            Role::Reference => self.reference.push(self.needed(line, index, cell)?),
            Role::Command => self.command.push(self.optional(line, index, cell)?),
            Role::Pass => {
                let number = self.needed(line, index, cell)?;
                if number.fract() != 0.0 || number.abs() > 1e9 {
                    let (place, found) = (self.place(line, index), number.to_string());
                    return Err(RecordingError::PassNumber { place, found });
                }
                self.pass.push(number as i32);
            }
            Role::Direction => match self.needed(line, index, cell)? {
                1.0 => self.direction.push(1i8),
                -1.0 => self.direction.push(-1i8),
                other => {
                    let (place, found) = (self.place(line, index), other.to_string());
                    return Err(RecordingError::Direction { place, found });
                }
            },
            Role::Further(which) => {
                if self.content[which] == Content::Unknown {
                    self.content[which] = match cell {
                        Cell::Number(_) => Content::Numbers,
                        Cell::Text(_) => Content::Text,
                        Cell::Blank | Cell::Null => Content::Unknown,
                    };
                }
                if self.content[which] != Content::Text {
                    let value = self.optional(line, index, cell)?;
                    self.further[which].push(value);
                }
            }
        }
        Ok(())
    }

    /// A row ends, which stands on `line`.
    pub fn row(&mut self, line: u64) {
        self.lines.push(self.time_s.len() - 1, line);
        self.watch.row(&self.time_s);
    }

    fn needed(&self, line: u64, index: usize, cell: Cell) -> Result<f64, RecordingError> {
        let place = || self.place(line, index);
        match cell {
            Cell::Number(value) if value.is_finite() => Ok(match self.conversions[index] {
                Some(Conversion { factor, offset }) => factor * value + offset,
                None => value,
            }),
            Cell::Number(value) => {
                Err(RecordingError::NotFinite { place: place(), found: value.to_string() })
            }
            Cell::Text(text) => {
                Err(RecordingError::NotANumber { place: place(), found: text_safety::cell(text) })
            }
            Cell::Blank => Err(RecordingError::Blank { place: place() }),
            Cell::Null => Err(RecordingError::Null { place: place() }),
        }
    }

    fn optional(&self, line: u64, index: usize, cell: Cell) -> Result<f64, RecordingError> {
        match cell {
            Cell::Blank | Cell::Null => Ok(f64::NAN),
            cell => self.needed(line, index, cell),
        }
    }

    /// The recording, once all rows are in; `notes` are what was noticed about the file.
    pub fn finish(self, purpose: Purpose, notes: Vec<Note>) -> Result<Recording, RecordingError> {
        let Builder { time_s, mut pass, mut direction, header, lines, watch, .. } = self;
        let file = self.file.to_string();
        if time_s.is_empty() {
            return Err(RecordingError::NoRows { file });
        }
        let mut notes: Vec<Note> = notes.into_iter().chain(watch.note(&time_s, &lines)).collect();
        if !header.has(Role::Pass) {
            pass = vec![0; time_s.len()];
            notes.push(Note::Assumed { column: "pass" });
        }
        if !header.has(Role::Direction) {
            direction = vec![1; time_s.len()];
            notes.push(Note::Assumed { column: "direction" });
        }
        let reference = header.has(Role::Reference).then_some(self.reference);
        let mut columns = Vec::new();
        for ((name, values), content) in header.further.iter().zip(self.further).zip(self.content) {
            match content {
                Content::Numbers => columns.push(Column { name: name.clone(), values }),
                _ => notes.push(Note::TextColumn { column: name.clone() }),
            }
        }
        let mut recording = Recording {
            file,
            sha256: String::new(),
            time_s,
            pass,
            direction,
            command_deg: header.has(Role::Command).then_some(self.command),
            readings: if header.direct {
                Readings::Direct { measured: self.first, reference }
            } else {
                Readings::Pair { x1_mm: self.first, x2_mm: self.second, reference_arcsec: reference }
            },
            further: columns,
            notes,
            lines,
        };
        if purpose == Purpose::Fit {
            recording.notes.extend(checks::empty_pass(&recording));
        }
        Ok(recording)
    }
}
