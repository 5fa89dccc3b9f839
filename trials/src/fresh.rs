//! What an answer is worth on a fresh recording of the same device, beside a model that knows the effects.
//!
//! The model that knows them is the base model of order 9 and the formulas of the concealed effects, fitted
//! together to the same rows by least squares, nonlinear parameters included; once with equal weights, and
//! once with the true covariance of the noise as well, which no model of a recording can know.

use std::path::Path;

use twin::Reading;
use twin::effects::{Scope, catalogue};

use crate::formulas::{self, Columns, Search, Shaped};
use crate::linear::{Basis, Whitener, deviation, least_squares};

/// Errors of the corrected angle on a fresh recording, each the rms about its mean, in arcseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fresh {
    /// With the coefficients of the answer.
    pub answer_arcsec: f64,
    /// With the base model alone.
    pub base_arcsec: f64,
    /// With the base model alone as `fit` makes it, where that was asked.
    pub fit_arcsec: Option<f64>,
    /// With a model that knows the effects.
    pub informed_arcsec: f64,
    /// With a model that knows the effects and the covariance of the noise, where that is known.
    pub fully_informed_arcsec: Option<f64>,
    /// The first beside the third, on the rows inside the range of the coefficients alone.
    pub inside_ratio: f64,
    /// Rows that lie outside that range, where only a line is used.
    pub extrapolated: usize,
    pub rows: usize,
}

/// A device that was recorded twice.
pub struct Twice<'a> {
    /// The recording that was diagnosed.
    pub seen: &'a [Reading],
    /// The fresh one.
    pub fresh: &'a [Reading],
    /// Ids of what is concealed in the device.
    pub ids: &'a [&'a str],
    /// The true covariance of the noise of the first, row by row, where it is known.
    pub covariance: Option<&'a [f64]>,
    pub distance_mm: f64,
}

/// Compares the corrected angles at `angles`, as `apply` wrote them, with the fresh recording; none where
/// the file does not hold a row for each of its rows.
pub fn compare(twice: &Twice, angles: &Path) -> Option<Fresh> {
    let (error, outside) = errors(angles, twice.fresh)?;
    let distance_mm = twice.distance_mm;
    let seen = Columns::new(twice.seen, distance_mm);
    let fresh = Columns::new(twice.fresh, distance_mm).on_scale_of(&seen);
    let rest = |ids: &[&str], whitener: &Whitener| -> Vec<f64> {
        let predicted = Informed::fit(&seen, ids, whitener, distance_mm).predict(&fresh, distance_mm);
        fresh.error_arcsec.iter().zip(predicted).map(|(e, p)| e - p).collect()
    };
    let inside = |values: &[f64]| -> f64 {
        let kept: Vec<f64> = values.iter().zip(&outside).filter(|(_, out)| !**out).map(|(v, _)| *v).collect();
        deviation(&kept)
    };
    let equal = Whitener::identity(seen.rows());
    let known = twice.covariance.and_then(|covariance| Whitener::new(covariance, seen.rows()));
    let informed = rest(twice.ids, &equal);
    Some(Fresh {
        answer_arcsec: deviation(&error),
        base_arcsec: deviation(&rest(&[], &equal)),
        fit_arcsec: None,
        informed_arcsec: deviation(&informed),
        fully_informed_arcsec: known.map(|known| deviation(&rest(twice.ids, &known))),
        inside_ratio: inside(&error) / inside(&informed),
        extrapolated: outside.iter().filter(|out| **out).count(),
        rows: error.len(),
    })
}

/// Errors of the corrected angles of a recording at `angles`, and which rows are marked as extrapolated; none where the
/// file does not hold a row for each reading.
pub fn errors(angles: &Path, log: &[Reading]) -> Option<(Vec<f64>, Vec<bool>)> {
    let (angle_arcsec, outside) = read_column(angles, "angle_arcsec")?;
    let error = angle_arcsec.iter().zip(log).map(|(a, r)| a - r.reference_arcsec).collect();
    (angle_arcsec.len() == log.len()).then_some((error, outside))
}

/// Corrected readings as `apply` wrote them, and which rows are marked as extrapolated.
pub fn read_column(path: &Path, column: &str) -> Option<(Vec<f64>, Vec<bool>)> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next()?.split(',').collect();
    let at = |name: &str| header.iter().position(|h| *h == name);
    let (angle, outside) = (at(column)?, at("extrapolated")?);
    let mut angles = Vec::new();
    let mut marked = Vec::new();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        angles.push(fields.get(angle)?.parse().ok()?);
        marked.push(*fields.get(outside)? == "1");
    }
    Some((angles, marked))
}

/// A model that knows the effects.
struct Informed {
    half_mm: f64,
    shaped: Vec<Shaped>,
    amplitudes: Vec<f64>,
}

impl Informed {
    fn fit(seen: &Columns, ids: &[&str], whitener: &Whitener, distance_mm: f64) -> Self {
        let half_mm = seen.half_mm();
        let mut basis = Basis::default();
        let base: Vec<Vec<f64>> =
            seen.base(half_mm, distance_mm).iter().map(|c| whitener.whiten(c)).collect();
        base.iter().for_each(|column| basis.push(column));
        let target = whitener.whiten(&seen.error_arcsec);
        let bare = basis.residual(&target);
        let search = Search { columns: seen, whitener };
        // The strongest first, each beside those before it; then all together.
        let mut left: Vec<&'static formulas::Formula> =
            ids.iter().filter_map(|id| formulas::find(id)).collect();
        let mut shaped: Vec<Shaped> = Vec::new();
        let mut wider = basis.clone();
        while !left.is_empty() {
            let rest = wider.residual(&target);
            let tried = left
                .iter()
                .map(|formula| search.best(formula, &wider, &rest, 1))
                .enumerate()
                .max_by(|a, b| a.1.1.total_cmp(&b.1.1));
            let Some((index, (best, _))) = tried else { break };
            search.white(&best).iter().for_each(|column| wider.push(column));
            left.remove(index);
            shaped.push(best);
        }
        let shaped = search.jointly(shaped, &basis, &bare);
        let mut columns = base;
        columns.extend(shaped.iter().flat_map(|s| search.white(s)));
        let amplitudes = least_squares(&columns, &target);
        Self { half_mm, shaped, amplitudes }
    }

    /// The angular error on another recording of the device in arcseconds, without what happened in the time
    /// of the first only.
    fn predict(&self, fresh: &Columns, distance_mm: f64) -> Vec<f64> {
        let mut columns = fresh.base(self.half_mm, distance_mm);
        for shaped in &self.shaped {
            let stays = catalogue::find(shaped.formula.id).is_some_and(|s| s.scope == Scope::Device);
            let own = (shaped.formula.signature)(fresh, &shaped.shape);
            columns.extend(own.into_iter().map(|c| if stays { c } else { vec![0.0; fresh.rows()] }));
        }
        let mut sum = vec![0.0; fresh.rows()];
        for (column, amplitude) in columns.iter().zip(&self.amplitudes) {
            sum.iter_mut().zip(column).for_each(|(s, c)| *s += amplitude * c);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Trial;
    use crate::plan::{Assignment, Counts, assignments};
    use crate::truth::Group;

    /// A model that knows the ids must come down to the noise, or the comparison is worth nothing.
    #[test]
    fn a_model_that_was_told_leaves_noise_on_a_fresh_recording() {
        let mut checked = 0;
        let list = assignments(&Counts { trials: 60, ..Counts::default() }, 9);
        let strong: Vec<&Assignment> = list.iter().filter(|a| a.group == Group::Strong).collect();
        for assignment in strong {
            let trial = Trial::draw(assignment, "r.csv".to_owned()).unwrap();
            // The same noise everywhere and nothing but it makes the figure simple.
            if trial.truth.family != "white" {
                continue;
            }
            let seen = Columns::new(&trial.record(), 12.0);
            let fresh = Columns::new(&trial.record_fresh(), 12.0).on_scale_of(&seen);
            let ids = trial.truth.ids();
            let informed =
                Informed::fit(&seen, &ids, &Whitener::identity(seen.rows()), 12.0).predict(&fresh, 12.0);
            let rest: Vec<f64> = fresh.error_arcsec.iter().zip(informed).map(|(e, p)| e - p).collect();
            let ratio = deviation(&rest) / trial.truth.noise_arcsec;
            // 210 rows know their deviation to 5 %, and the model was fitted to as many.
            assert!((0.8..1.2).contains(&ratio), "{:?}: {ratio}", trial.truth);
            checked += 1;
        }
        assert!(checked >= 2);
    }
}
