//! The user's own simulation of a recording: `t_s` and the predicted reference, row for row.

use std::path::Path;

use fitter::Recording;
use fitter::limits::LARGEST;
use fitter::recording::Readings;
use fitter::table::{Cells, Header, Lines, Naming, RecordingError, Table, Use, Uses};

use crate::error::DiagnosisError;
use crate::observe::Simulated;

/// A simulation as read.
#[derive(Debug, Clone)]
pub struct Simulation {
    header: Header,
    t_s: Vec<f64>,
    name: &'static str,
    values: Vec<f64>,
    lines: Lines,
}

/// What may be predicted, the first of which that is there is taken.
const PREDICTED: [&str; 3] = ["reference_arcsec", "reference", "position"];

/// Reads a simulation.
///
/// # Errors
/// See [`DiagnosisError`].
pub fn read(path: &Path) -> Result<Simulation, DiagnosisError> {
    table(|naming, uses| Table::read(path, naming, uses, &mut |_| {}))
}

/// Takes columns in memory for a simulation; `file` is as in [`Table::of_columns`].
///
/// # Errors
/// See [`DiagnosisError`].
pub fn of_columns(file: &str, columns: Vec<(String, Cells)>) -> Result<Simulation, DiagnosisError> {
    table(|naming, uses| Table::of_columns(file, columns, naming, uses))
}

fn table(
    read: impl FnOnce(&Naming, &Uses) -> Result<Table, RecordingError>,
) -> Result<Simulation, DiagnosisError> {
    let predicted = |header: &Header| PREDICTED.into_iter().find(|name| header.has(name));
    let uses = |header: &Header| {
        header.require(&["t_s"])?;
        let used = |name: &String| name == "t_s" || predicted(header) == Some(name);
        Ok(header.names.iter().map(|name| if used(name) { Use::Needed } else { Use::Ignored }).collect())
    };
    let mut table = read(&Naming::default(), &uses)?;
    let Some(name) = predicted(&table.header) else {
        let column = PREDICTED.join("` or `");
        return Err(DiagnosisError::Column { found: table.header.listed(), at: table.header.at, column });
    };
    let mut column = |name: &str| -> Result<Vec<f64>, DiagnosisError> {
        let values = table.take(name).unwrap_or_default().into_vec();
        match values.iter().position(|value| value.abs() > LARGEST) {
            None => Ok(values),
            Some(row) => {
                let place = table.header.place(table.lines.of(row), name);
                Err(DiagnosisError::Cell { place, found: values[row] })
            }
        }
    };
    let (t_s, values) = (column("t_s")?, column(name)?);
    Ok(Simulation { header: table.header, t_s, name, values, lines: table.lines })
}

impl Simulation {
    /// The simulation for a recording.
    ///
    /// # Errors
    /// [`DiagnosisError::Rows`] where its rows are others, [`DiagnosisError::Column`] where it predicts another
    /// column.
    pub fn for_recording(&self, recording: &Recording) -> Result<Simulated, DiagnosisError> {
        let wanted = match recording.readings {
            Readings::Pair { .. } => "reference_arcsec",
            Readings::Direct { .. } => "reference",
        };
        Ok(Simulated { reference: self.rows_of(wanted, &recording.time_s)? })
    }

    /// The simulated positions of a dynamic recording whose rows are at these times.
    ///
    /// # Errors
    /// As [`Simulation::for_recording`].
    pub fn positions_for(&self, t_s: &[f64]) -> Result<Vec<f64>, DiagnosisError> {
        self.rows_of("position", t_s)
    }

    fn rows_of(&self, wanted: &str, time_s: &[f64]) -> Result<Vec<f64>, DiagnosisError> {
        if self.name != wanted {
            return Err(DiagnosisError::Column {
                at: self.header.at.clone(),
                column: wanted.into(),
                found: self.header.listed(),
            });
        }
        if self.values.len() != time_s.len() {
            return Err(DiagnosisError::Rows {
                file: self.header.file.clone(),
                found: format!("{} rows", self.values.len()),
                expected: format!("{} rows", time_s.len()),
            });
        }
        // A simulation may print its times with fewer digits: a millisecond is far below a row's distance.
        let apart = (0..time_s.len()).find(|&i| (self.t_s[i] - time_s[i]).abs() > 1e-3);
        if let Some(i) = apart {
            return Err(DiagnosisError::Rows {
                file: self.header.file.clone(),
                found: format!("t_s = {} on line {}", self.t_s[i], self.lines.of(i)),
                expected: format!("t_s = {}", time_s[i]),
            });
        }
        Ok(self.values.clone())
    }
}
