//! The recordings of a diagnosis without the rows that cannot be readings, and checked as a fit checks them.

use std::borrow::Cow;

use fitter::faults::{self, BadRow};
use fitter::{Coefficients, Mirror, Recording};

use crate::error::DiagnosisError;
use crate::observe::Simulated;
use crate::thresholds::screened::{GOLDEN, MOST_ROWS};

/// What a diagnosis goes on with.
pub struct Screened<'a> {
    recording: Own<'a>,
    simulated: Option<Simulated>,
    held_out: Option<Own<'a>>,
}

/// A recording without its bad rows.
struct Own<'a> {
    rest: faults::Screened<'a>,
    /// All rows, as the file has them.
    whole: &'a Recording,
    /// The bad cells among them that show without a model, as `apply` finds them.
    shown: Vec<BadRow>,
    /// Whether there were so many rows that the diagnosed ones are a recording of their own.
    is_thinned: bool,
}

/// A recording as it is diagnosed, and as `apply` will see it: there the bad rows are in the file. A lag or a play
/// remembers what the reading did in them, unless the reading itself is what is bad.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// The rows that are diagnosed.
    pub recording: &'a Recording,
    own: &'a Own<'a>,
}

impl Seen<'_> {
    /// The corrected reading of every diagnosed row, as `apply` corrects it; none where it cannot.
    pub fn corrected(&self, file: &Coefficients) -> Option<Vec<f64>> {
        let Own { rest, whole, shown, is_thinned } = self.own;
        // Without terms no row depends on another.
        if *is_thinned || rest.kept.len() == whole.rows() || file.terms.is_empty() {
            return Some(fitter::apply(self.recording, file).ok()?.corrected);
        }
        let applied = fitter::apply_passing_over(whole, file, shown).ok()?;
        Some(rest.kept.iter().map(|row| applied.corrected[*row]).collect())
    }
}

impl<'a> Own<'a> {
    fn of(whole: &'a Recording, mirror: &Mirror) -> Result<Own<'a>, DiagnosisError> {
        let screened = faults::screen(Cow::Borrowed(whole), &mirror.sensor)?;
        let (shown, is_thinned) = (screened.bad_rows.clone(), screened.kept.len() > MOST_ROWS);
        Ok(Own { rest: thinned(screened), whole, shown, is_thinned })
    }

    fn seen(&self) -> Seen<'_> {
        Seen { recording: &self.rest.recording, own: self }
    }
}

impl<'a> Screened<'a> {
    /// Screens the recording and the one that is held out; the simulation keeps the same rows.
    ///
    /// # Errors
    /// [`DiagnosisError`] where too much of a recording cannot be readings, or it cannot be a calibration at all.
    pub fn of(
        recording: &'a Recording,
        mirror: &Mirror,
        simulated: Option<&Simulated>,
        held_out: Option<&'a Recording>,
    ) -> Result<Screened<'a>, DiagnosisError> {
        let held_out = held_out.map(|recording| Own::of(recording, mirror)).transpose()?;
        let rows = recording.rows();
        let recording = Own::of(recording, mirror)?;
        let simulated = simulated.map(|simulated| match simulated.reference.len() == rows {
            true => {
                Simulated { reference: recording.rest.kept.iter().map(|k| simulated.reference[*k]).collect() }
            }
            false => simulated.clone(),
        });
        Ok(Screened { recording, simulated, held_out })
    }

    /// The same without further rows of the recording.
    pub fn without(self, further: Vec<(usize, BadRow)>) -> Screened<'a> {
        let kept: Vec<usize> = (0..self.recording.rest.kept.len())
            .filter(|row| further.iter().all(|(bad, _)| bad != row))
            .collect();
        let simulated = self.simulated.map(|simulated| Simulated {
            reference: kept.iter().map(|row| simulated.reference[*row]).collect(),
        });
        let recording = Own { rest: self.recording.rest.without(further), ..self.recording };
        Screened { recording, simulated, held_out: self.held_out }
    }

    /// Recording, simulation and held-out recording.
    pub fn parts(&self) -> (Seen<'_>, Option<&Simulated>, Option<Seen<'_>>) {
        (self.recording.seen(), self.simulated.as_ref(), self.held_out.as_ref().map(Own::seen))
    }

    /// The cells that were left out.
    pub fn bad_rows(&self) -> Vec<BadRow> {
        self.recording.rest.bad_rows.clone()
    }

    /// What else was noticed.
    pub fn notes(&self) -> Vec<String> {
        self.recording.rest.notes.clone()
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
