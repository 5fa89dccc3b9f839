//! The recordings of a diagnosis without the rows that cannot be readings, and checked as a fit checks them.

use fitter::faults::{self, BadRow};
use fitter::{Mirror, Recording};

use crate::observe::{ObserveError, Simulated};

/// What a diagnosis goes on with.
pub struct Screened {
    recording: faults::Screened,
    simulated: Option<Simulated>,
    held_out: Option<Recording>,
}

impl Screened {
    /// Screens the recording and the one that is held out; the simulation keeps the same rows.
    ///
    /// # Errors
    /// [`ObserveError`] where too much of a recording cannot be readings, or it cannot be a calibration at all.
    pub fn of(
        recording: &Recording,
        mirror: &Mirror,
        simulated: Option<&Simulated>,
        held_out: Option<&Recording>,
    ) -> Result<Screened, ObserveError> {
        let one = |recording: &Recording| -> Result<faults::Screened, ObserveError> {
            let screened = faults::screen(recording, &mirror.sensor).map_err(Box::new)?;
            Ok(screened)
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
    pub fn without(self, further: Vec<(usize, BadRow)>) -> Screened {
        let kept: Vec<usize> =
            (0..self.recording.kept.len()).filter(|row| further.iter().all(|(bad, _)| bad != row)).collect();
        let simulated = self.simulated.map(|simulated| Simulated {
            reference: kept.iter().map(|row| simulated.reference[*row]).collect(),
        });
        Screened { recording: self.recording.without(further), simulated, held_out: self.held_out }
    }

    /// Recording, simulation and held-out recording.
    pub fn parts(&self) -> (&Recording, Option<&Simulated>, Option<&Recording>) {
        (&self.recording.recording, self.simulated.as_ref(), self.held_out.as_ref())
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
