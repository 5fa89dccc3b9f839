//! The goodness of fit of a model of named effects: whether what it leaves is noise. Once a mismatch is there,
//! the question is no longer whether to raise an alarm but whether the names account for all of it, and a wrong
//! name alone is worse than a right one with a reservation: so the same test of every place, calibrated by the
//! same resamples, is made at a level of its own and without favour to the catalogue.

use numerics::dot;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::{Found, Search, Term};
use crate::dictionary::Kind;
use crate::effects::Place;
use crate::generic::{observables, own_part, scaled, times};
use crate::thresholds::search::remainder::{BEYOND_DOUBT, MISFIT};

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

    /// The strongest dependence of a named effect's size on an observable or the time (of a ripple: of its phase, too),
    /// where that is beyond doubt. The scatter about the terms themselves is the measure, since noise that was
    /// estimated without it holds it.
    pub fn modulation(&self, terms: &[Term]) -> Option<Term> {
        if self.rows.single_move() {
            return None;
        }
        let x = self.rows.scaled_reading();
        let mut moving: Vec<(String, Vec<f64>)> =
            observables(self.rows).into_iter().map(|o| (o.name, own_part(&o.z, &x))).collect();
        moving.push(("t_s".into(), scaled(&self.rows.t_s)));
        let of_the_angle = |term: &&Term| {
            let place = self.effect(term.family).map(|e| self.catalogue[e].place.clone());
            place.is_some_and(|place| place == Place::on("angle_deg"))
        };
        let named: Vec<&Term> = terms.iter().filter(of_the_angle).collect();
        let level = BEYOND_DOUBT / (named.len() * moving.len()) as f64;
        let mut best: Option<(f64, Term)> = None;
        for (name, z) in &moving {
            let Some(family) = self.family_of(&Place::product(name, "angle_deg")) else { continue };
            for term in &named {
                let columns: Vec<Vec<f64>> = term.columns.iter().map(|column| times(column, z)).collect();
                let (explained, probability) = self.explained_beside(terms, &columns);
                if probability < level && best.as_ref().is_none_or(|(most, _)| explained > *most) {
                    best = Some((explained, Term::new(family, Vec::new(), columns.into())));
                }
            }
        }
        best.map(|(_, term)| term)
    }

    fn family_of(&self, place: &Place) -> Option<usize> {
        let is = |kind: &Kind| matches!(kind, Kind::Generic(other) if other == place);
        self.dictionary.families.iter().position(|family| is(&family.kind))
    }

    /// What further columns explain beside the terms, in units of the noise's variance, and the probability that columns of
    /// noise explain as much (F-test).
    pub fn explained_beside(&self, terms: &[Term], columns: &[Vec<f64>]) -> (f64, f64) {
        let beside = self.beside(terms);
        let mut basis = beside.basis.clone();
        let before = basis.rank();
        for column in columns {
            basis.add(&self.whitener.whiten(column));
        }
        let whole = dot(&beside.residual, &beside.residual);
        let explained: f64 =
            (before..basis.rank()).map(|k| dot(basis.columns.get(k), &beside.residual).powi(2)).sum();
        let (rank, free) = ((basis.rank() - before) as f64, self.rows.len() as f64 - basis.rank() as f64);
        let ratio = explained / rank / ((whole - explained).max(f64::MIN_POSITIVE) / free);
        let probability = FisherSnedecor::new(rank, free).map_or(1.0, |f| f.sf(ratio));
        (explained, probability)
    }
}
