//! The goodness of fit of a model of named effects: whether what it leaves is noise. Once a mismatch is there,
//! the question is no longer whether to raise an alarm but whether the names account for all of it, and a wrong
//! name alone is worse than a right one with a reservation: so the same test of every place, calibrated by the
//! same resamples, is made at a level of its own and without favour to the catalogue.

use super::{Found, Search, Term};

/// Part of the models with all the right names that are said to leave something.
pub const MISFIT: f64 = 0.01;

impl Search<'_> {
    /// The strongest generic dependence of what the terms leave, where it is more than noise.
    pub fn remainder(&self, terms: &[Term]) -> Option<Found> {
        let found = self
            .survey(terms)
            .into_iter()
            .filter(|f| self.is_generic(f.term.family))
            .max_by(|a, b| a.surprise.total_cmp(&b.surprise))?;
        (found.surprise >= self.calibration.remainder.at(-MISFIT.ln())).then_some(found)
    }
}
