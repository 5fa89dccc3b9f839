//! What an interval must allow for beyond its own model: that an effect which is easily taken for the named one
//! is there as well and was too weak to be named. A drift beside a warm-up changes the warm-up's amplitude and
//! time constant by far more than either interval says as long as there is only one of them.
//!
//! Bayesian model averaging (Hoeting, Madigan, Raftery & Volinsky, Bayesian model averaging: a tutorial,
//! Statistical Science 14 (1999) 382–417): the model with one such effect more has the weight
//! odds · n^(−k/2) · mean over its shapes of exp(S/2), S what it explains beside the model with k columns more
//! (the unit-information prior of the Bayesian information criterion).

use numerics::{Basis, dot};

use crate::dictionary::Kind;
use crate::effects::Effect;
use crate::search::{Search, Term};
use crate::thresholds::averaging::{LEAST, ODDS, OWN};

/// One effect more.
pub struct Rival {
    /// Weight beside the model itself, which has 1.
    pub weight: f64,
    /// Its whitened columns at its best shape.
    pub columns: Vec<Vec<f64>>,
}

/// The effects that `effect` is easily taken for and that are not in the model, as far as they matter. `whole`
/// is the whitened model with its tangents, `residual` the observations less their part in it.
pub fn rivals(
    search: &Search,
    effect: &Effect,
    terms: &[Term],
    whole: &Basis,
    residual: &[f64],
) -> Vec<Rival> {
    let families = search.dictionary.families.iter().enumerate().filter(|(f, family)| match family.kind {
        Kind::Effect(e) => {
            effect.confused_with.contains(&search.catalogue[e].id) && !terms.iter().any(|t| t.family == *f)
        }
        _ => false,
    });
    families
        .filter_map(|(_, family)| {
            let candidates = &search.dictionary.candidates[family.candidates.clone()];
            let mut best: Option<(f64, Vec<Vec<f64>>)> = None;
            let mut sum = 0.0;
            let mut width = 0;
            for candidate in candidates {
                let columns: Vec<Vec<f64>> =
                    candidate.columns.iter().map(|column| search.whitener.whiten(column)).collect();
                width = columns.len();
                let explained = explained(&columns, whole, residual);
                sum += (0.5 * explained).min(600.0).exp();
                if best.as_ref().is_none_or(|b| explained > b.0) {
                    best = Some((explained, columns));
                }
            }
            let mean = sum / candidates.len().max(1) as f64;
            // A rival that clearly belongs would have been named: the search, not the average, decides there.
            let weight = (ODDS * mean * (residual.len() as f64).powf(-0.5 * width as f64)).min(1.0);
            best.filter(|_| weight > LEAST).map(|(_, columns)| Rival { weight, columns })
        })
        .collect()
}

/// What columns explain of the residual of a model.
fn explained(columns: &[Vec<f64>], whole: &Basis, residual: &[f64]) -> f64 {
    let mut own = Basis::new(residual.len());
    for column in columns {
        let length = dot(column, column).sqrt();
        let mut w = column.clone();
        whole.project_off(&mut w);
        if dot(&w, &w).sqrt() > OWN * length {
            own.add(&w);
        }
    }
    (0..own.rank()).map(|k| dot(own.columns.get(k), residual).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::explained;
    use numerics::Basis;

    #[test]
    fn only_what_the_model_leaves_is_explained() {
        let mut whole = Basis::new(3);
        whole.add(&[1.0, 0.0, 0.0]);
        let residual = [0.0, 3.0, 4.0];
        assert_eq!(explained(&[vec![1.0, 0.0, 0.0]], &whole, &residual), 0.0);
        assert!((explained(&[vec![5.0, 2.0, 0.0]], &whole, &residual) - 9.0).abs() < 1e-12);
    }
}
