//! What a term can read of a recording, by name.

use std::borrow::Cow;

use thiserror::Error;

use crate::error_model::Sensor;
use crate::recording::{Readings, Recording};
use crate::turn::{nearest, travelled, travelled_about};
use crate::units::arcsec_from_rad;

/// A recording has not the observable that a term needs.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("column `{observable}` is missing")]
pub struct Missing {
    /// Its name.
    pub observable: String,
}

/// A recording and its sensor, as terms see them.
#[derive(Clone, Copy)]
pub struct Observables<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// The sensor.
    pub sensor: &'a Sensor,
}

/// Names of observables that are the angle (or position) in some form.
const ANGLES: [&str; 7] = ["s_mm", "x1_mm", "x2_mm", "angle_deg", "angle_arcsec", "measured", "command_deg"];

/// Whether an observable is the angle in some form.
pub fn depends_on_angle(observable: &str) -> bool {
    ANGLES.contains(&observable)
}

impl<'a> Observables<'a> {
    /// One value per row, NaN where the cell is blank. Names: `t_s`, `pass`, `direction`, `command_deg`; of an
    /// eddy-current pair `x1_mm`, `x2_mm`, `s_mm` = x₂ − x₁, `common_mode_um` = 1000 (x₁ + x₂)/2,
    /// `angle_deg` and `angle_arcsec` (the calculated angle); of a direct sensor `measured`, of one that turns as the
    /// way that it travelled, without the jumps at the end of the turn; and every further column of the recording.
    ///
    /// # Errors
    /// [`Missing`] if there is none of that name.
    pub fn get(&self, name: &str) -> Result<Cow<'a, [f64]>, Missing> {
        let recording = self.recording;
        let rows = 0..recording.rows();
        let missing = || Missing { observable: name.to_string() };
        match (name, &recording.readings) {
            ("pass", _) => Ok(recording.pass.iter().map(|pass| f64::from(*pass)).collect()),
            ("direction", _) => Ok(recording.direction.iter().map(|d| f64::from(*d)).collect()),
            ("t_s" | "command_deg" | "x1_mm" | "x2_mm", _) => {
                recording.values(name).map(Cow::Borrowed).ok_or_else(missing)
            }
            ("s_mm", Readings::Pair { .. }) => Ok(rows.map(|row| recording.reading(row)).collect()),
            ("common_mode_um", Readings::Pair { x1_mm, x2_mm, .. }) => {
                Ok(x1_mm.iter().zip(x2_mm).map(|(x1, x2)| 500.0 * (x1 + x2)).collect())
            }
            ("angle_deg", Readings::Pair { .. }) => {
                Ok(rows.map(|row| self.sensor.calculated(recording.reading(row)).to_degrees()).collect())
            }
            ("angle_arcsec", Readings::Pair { .. }) => {
                Ok(rows.map(|row| arcsec_from_rad(self.sensor.calculated(recording.reading(row)))).collect())
            }
            ("measured", Readings::Direct { measured, .. }) => Ok(match self.sensor.revolution() {
                Some(turn) => travelled(measured, turn),
                None => Cow::Borrowed(measured),
            }),
            _ => recording.column(name).map(Cow::Borrowed).ok_or_else(missing),
        }
    }

    /// [`Observables::get`], the reading of a sensor that turns being counted on the turn about `place`: a slope over
    /// the turn has its zero there, whichever turn the recording began on.
    ///
    /// # Errors
    /// [`Missing`] if there is none of that name.
    pub fn about(&self, name: &str, place: f64) -> Result<Cow<'a, [f64]>, Missing> {
        match (name, &self.recording.readings, self.sensor.revolution()) {
            ("measured", Readings::Direct { measured, .. }, Some(turn)) => {
                Ok(travelled_about(measured, turn, place))
            }
            _ => self.get(name),
        }
    }

    /// [`Observables::get`], every reading of a sensor that turns being on the turn nearest to `place`: a defect at one
    /// place of the turn is there in every turn.
    ///
    /// # Errors
    /// [`Missing`] if there is none of that name.
    pub fn nearest(&self, name: &str, place: f64) -> Result<Cow<'a, [f64]>, Missing> {
        let values = self.get(name)?;
        Ok(match self.sensor.revolution() {
            Some(turn) if name == "measured" => nearest(&values, turn, place).into(),
            _ => values,
        })
    }
}
