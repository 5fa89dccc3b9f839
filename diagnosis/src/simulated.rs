//! The user's own simulation of a recording: `t_s` and the predicted reference, row for row.

use std::path::Path;

use fitter::limits::LARGEST;
use fitter::recording::{Place, Readings};
use fitter::table::{Header, Lines, Naming, Table, Use};
use fitter::{Recording, RecordingError};
use thiserror::Error;

use crate::observe::Simulated;

/// Why a simulation is refused.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the messages say what the fields are
pub enum SimulatedError {
    /// It is no table of numbers.
    #[error(transparent)]
    Table(#[from] RecordingError),
    /// A column is missing.
    #[error("{at}: column `{column}` is missing, found {found}; add it")]
    Column { at: String, column: String, found: String },
    /// A cell is beyond all measure.
    #[error("{place}: found `{found}`, expected a number from -{LARGEST:e} to {LARGEST:e}; correct the cell")]
    Cell { place: Place, found: f64 },
    /// The rows are not those of the recording.
    #[error("{file}: found {found}, expected {expected}; simulate exactly the rows of the recording")]
    Rows { file: String, found: String, expected: String },
}

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
/// See [`SimulatedError`].
pub fn read(path: &Path) -> Result<Simulation, SimulatedError> {
    let predicted = |header: &Header| PREDICTED.into_iter().find(|name| header.has(name));
    let uses = |header: &Header| {
        header.require(&["t_s"])?;
        let used = |name: &String| name == "t_s" || predicted(header) == Some(name);
        Ok(header.names.iter().map(|name| if used(name) { Use::Needed } else { Use::Ignored }).collect())
    };
    let mut table = Table::read(path, &Naming::default(), &uses, &mut |_| {})?;
    let Some(name) = predicted(&table.header) else {
        let column = PREDICTED.join("` or `");
        return Err(SimulatedError::Column { found: table.header.listed(), at: table.header.at, column });
    };
    let mut column = |name: &str| -> Result<Vec<f64>, SimulatedError> {
        let values = table.take(name).unwrap_or_default();
        match values.iter().position(|value| value.abs() > LARGEST) {
            None => Ok(values),
            Some(row) => {
                let place = table.header.place(table.lines.of(row), name);
                Err(SimulatedError::Cell { place, found: values[row] })
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
    /// [`SimulatedError::Rows`] where its rows are others, [`SimulatedError::Column`] where it predicts another
    /// column.
    pub fn for_recording(&self, recording: &Recording) -> Result<Simulated, SimulatedError> {
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
    pub fn positions_for(&self, t_s: &[f64]) -> Result<Vec<f64>, SimulatedError> {
        self.rows_of("position", t_s)
    }

    fn rows_of(&self, wanted: &str, time_s: &[f64]) -> Result<Vec<f64>, SimulatedError> {
        if self.name != wanted {
            return Err(SimulatedError::Column {
                at: self.header.at.clone(),
                column: wanted.into(),
                found: self.header.listed(),
            });
        }
        if self.values.len() != time_s.len() {
            return Err(SimulatedError::Rows {
                file: self.header.file.clone(),
                found: format!("{} rows", self.values.len()),
                expected: format!("{} rows", time_s.len()),
            });
        }
        // A simulation may print its times with fewer digits: a millisecond is far below a row's distance.
        let apart = (0..time_s.len()).find(|&i| (self.t_s[i] - time_s[i]).abs() > 1e-3);
        if let Some(i) = apart {
            return Err(SimulatedError::Rows {
                file: self.header.file.clone(),
                found: format!("t_s = {} on line {}", self.t_s[i], self.lines.of(i)),
                expected: format!("t_s = {}", time_s[i]),
            });
        }
        Ok(self.values.clone())
    }
}
