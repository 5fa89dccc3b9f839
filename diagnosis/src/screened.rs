//! The recordings of a diagnosis without the rows that cannot be readings, and checked as a fit checks them.

use std::borrow::Cow;

use fitter::faults::{self, BadRow};
use fitter::{Mirror, Recording};

use crate::observe::{ObserveError, Simulated};
use crate::thresholds::screened::{GOLDEN, MOST_ROWS};

/// What a diagnosis goes on with.
pub struct Screened<'a> {
    recording: faults::Screened<'a>,
    simulated: Option<Simulated>,
    held_out: Option<Cow<'a, Recording>>,
}

impl<'a> Screened<'a> {
    /// Screens the recording and the one that is held out; the simulation keeps the same rows.
    ///
    /// # Errors
    /// [`ObserveError`] where too much of a recording cannot be readings, or it cannot be a calibration at all.
    pub fn of(
        recording: &'a Recording,
        mirror: &Mirror,
        simulated: Option<&Simulated>,
        held_out: Option<&'a Recording>,
    ) -> Result<Screened<'a>, ObserveError> {
        let one = |recording: &'a Recording| -> Result<faults::Screened<'a>, ObserveError> {
            let screened = faults::screen(Cow::Borrowed(recording), &mirror.sensor).map_err(Box::new)?;
            Ok(thinned(screened))
        };
        let held_out = held_out.map(one).transpose()?.map(|screened| screened.recording);
        let screened = one(recording)?;
        let simulated = simulated.map(|simulated| match simulated.reference.len() == recording.rows() {
            true => Simulated { reference: screened.kept.iter().map(|k| simulated.reference[*k]).collect() },
            false => simulated.clone(),
        });
        Ok(Screened { recording: screened, simulated, held_out })
    }

    /// The same without further rows of the recording.
    pub fn without(self, further: Vec<(usize, BadRow)>) -> Screened<'a> {
        let kept: Vec<usize> =
            (0..self.recording.kept.len()).filter(|row| further.iter().all(|(bad, _)| bad != row)).collect();
        let simulated = self.simulated.map(|simulated| Simulated {
            reference: kept.iter().map(|row| simulated.reference[*row]).collect(),
        });
        Screened { recording: self.recording.without(further), simulated, held_out: self.held_out }
    }

    /// Recording, simulation and held-out recording.
    pub fn parts(&self) -> (&Recording, Option<&Simulated>, Option<&Recording>) {
        (&self.recording.recording, self.simulated.as_ref(), self.held_out.as_deref())
    }

    /// The cells that were left out.
    pub fn bad_rows(&self) -> Vec<BadRow> {
        self.recording.bad_rows.clone()
    }

    /// What else was noticed.
    pub fn notes(&self) -> Vec<String> {
        self.recording.notes.clone()
    }
}

/// Of too many rows some, spread evenly over every pass.
fn thinned(screened: faults::Screened) -> faults::Screened {
    let rows = screened.kept.len();
    let every = rows.div_ceil(MOST_ROWS);
    if every <= 1 {
        return screened;
    }
    let offset = |pass: i32| ((f64::from(pass) * GOLDEN).rem_euclid(1.0) * every as f64) as usize;
    let chosen: Vec<usize> =
        (0..rows).filter(|row| (row + offset(screened.recording.pass[*row])) % every == 0).collect();
    let mut notes = screened.notes;
    notes.push(format!(
        "{rows} rows are more than are diagnosed: one in {every} took part, spread evenly over every pass; bad readings \
         were looked for in all"
    ));
    faults::Screened {
        recording: Cow::Owned(screened.recording.select(&chosen)),
        kept: chosen.iter().map(|row| screened.kept[*row]).collect(),
        bad_rows: screened.bad_rows,
        notes,
    }
}
