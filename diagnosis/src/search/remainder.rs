//! The goodness of fit of a model of named effects: whether what it leaves is noise. Once a mismatch is there,
//! the question is no longer whether to raise an alarm but whether the names account for all of it, and a wrong
//! name alone is worse than a right one with a reservation: so the same test of every place, calibrated by the
//! same resamples, is made at a level of its own and without favour to the catalogue.

use super::{Found, Search, Term};

/// Part of the models with all the right names that are said to leave something.
pub const MISFIT: f64 = 0.03;
/// Probability over the whole search below which structure is beyond doubt, whatever the noise remembers: an alarm that
/// noise of a long memory raised must still be able to fall when that memory is measured.
const BEYOND_DOUBT: f64 = 1e-5;

impl Search<'_> {
    /// The strongest generic dependence of what the terms leave, where it is more than noise.
    pub fn remainder(&self, terms: &[Term]) -> Option<Found> {
        let level = self.calibration.remainder.at(-MISFIT.ln());
        self.strongest_generic(terms).filter(|found| found.surprise >= level)
    }

    /// Whether what the terms leave is beyond doubt no noise.
    pub fn leaves_much(&self, terms: &[Term]) -> bool {
        self.strongest_generic(terms).is_some_and(|found| self.family_wise(&found) > -BEYOND_DOUBT.ln())
    }

    fn strongest_generic(&self, terms: &[Term]) -> Option<Found> {
        let beside = self.beside(terms);
        let generic = beside.found.iter().filter(|f| self.is_generic(f.term.family));
        generic.max_by(|a, b| a.surprise.total_cmp(&b.surprise)).cloned()
    }
}
