//! The user's own simulation of a recording: `t_s` and the predicted reference, row for row.

use std::path::Path;

use fitter::Recording;
use fitter::limits::LARGEST;
use fitter::recording::Readings;
use fitter::text_safety;
use thiserror::Error;

use crate::observe::Simulated;

/// Why a simulation is refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SimulatedError {
    /// The file cannot be read.
    #[error("{file}: cannot be read ({reason}); give the path of a CSV with t_s and the predicted reference")]
    Unreadable { file: String, reason: String },
    /// A column is missing.
    #[error("{file}: column `{column}` is missing, found {found}; add it")]
    Column { file: String, column: String, found: String },
    /// A cell is no number.
    #[error(
        "{file}, line {line}, column `{column}`: found `{found}`, expected a number from -{LARGEST:e} to {LARGEST:e}; \
         correct the cell"
    )]
    Cell { file: String, line: u64, column: String, found: String },
    /// The rows are not those of the recording.
    #[error("{file}: found {found}, expected {expected}; simulate exactly the rows of the recording")]
    Rows { file: String, found: String, expected: String },
}

/// A simulation as read.
#[derive(Debug, Clone)]
pub struct Simulation {
    file: String,
    t_s: Vec<f64>,
    name: String,
    values: Vec<f64>,
}

/// Reads a simulation.
///
/// # Errors
/// See [`SimulatedError`].
pub fn read(path: &Path) -> Result<Simulation, SimulatedError> {
    let file = text_safety::path(path);
    let unreadable = |reason: String| SimulatedError::Unreadable { file: file.clone(), reason };
    let text = fitter::input::unpacked(path).map_err(|e| unreadable(e.to_string()))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&text[..]);
    let headers: Vec<String> =
        reader.headers().map_err(|e| unreadable(e.to_string()))?.iter().map(String::from).collect();
    let find = |name: &str| headers.iter().position(|h| h == name);
    let missing = |column: &str| SimulatedError::Column {
        file: file.clone(),
        column: column.into(),
        found: headers.join(", "),
    };
    let time = find("t_s").ok_or_else(|| missing("t_s"))?;
    let predicted = find("reference_arcsec")
        .or_else(|| find("reference"))
        .or_else(|| find("position"))
        .ok_or_else(|| missing("reference_arcsec (or reference, or position)"))?;
    let mut simulation = Simulation {
        file: file.clone(),
        t_s: Vec::new(),
        name: headers[predicted].clone(),
        values: Vec::new(),
    };
    for (k, record) in reader.records().enumerate() {
        let record = record.map_err(|e| unreadable(e.to_string()))?;
        let number = |column: usize| -> Result<f64, SimulatedError> {
            let text = record.get(column).unwrap_or("");
            text.parse::<f64>().ok().filter(|v| v.abs() <= LARGEST).ok_or_else(|| SimulatedError::Cell {
                file: file.clone(),
                line: k as u64 + 2,
                column: headers[column].clone(),
                found: text.into(),
            })
        };
        simulation.t_s.push(number(time)?);
        simulation.values.push(number(predicted)?);
    }
    Ok(simulation)
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
                file: self.file.clone(),
                column: wanted.into(),
                found: self.name.clone(),
            });
        }
        if self.values.len() != time_s.len() {
            return Err(SimulatedError::Rows {
                file: self.file.clone(),
                found: format!("{} rows", self.values.len()),
                expected: format!("{} rows", time_s.len()),
            });
        }
        // A simulation may print its times with fewer digits: a millisecond is far below a row's distance.
        let apart = (0..time_s.len()).find(|&i| (self.t_s[i] - time_s[i]).abs() > 1e-3);
        if let Some(i) = apart {
            return Err(SimulatedError::Rows {
                file: self.file.clone(),
                found: format!("t_s = {} on line {}", self.t_s[i], i + 2),
                expected: format!("t_s = {}", time_s[i]),
            });
        }
        Ok(self.values.clone())
    }
}
