//! ρ, the strength of a concealed effect as a matched filter sees it.
//!
//! ρ² = zᵀ Σ⁻¹ z, z the effect's noiseless contribution after projecting off, in the metric Σ⁻¹, the base
//! model (a constant and Eq. 6 of order 9, the order of the devices' own error) and the other effects.

use crate::formulas::{self, Columns, FORMULAS, Formula, Search};
use crate::linear::{Basis, Whitener, dot, norm};

/// The whitened space of one recording, and the base model in it.
pub struct Metric {
    whitener: Whitener,
    base: Basis,
}

/// A catalogued effect that comes close to a concealed one.
#[derive(Debug, Clone, PartialEq)]
pub struct Imitation {
    /// Its id; `the others` where the other concealed effects, with other parameters, do without this one.
    pub id: String,
    /// ρ of what it leaves of the concealed effect.
    pub rho_left: f64,
}

impl Metric {
    /// From the columns of a recording of probes `distance_mm` apart and the true covariance of its noise;
    /// none where that is not positive definite.
    pub fn new(columns: &Columns, covariance: &[f64], distance_mm: f64) -> Option<Self> {
        let whitener = Whitener::new(covariance, columns.rows())?;
        let mut base = Basis::default();
        for column in columns.base(columns.half_mm(), distance_mm) {
            base.push(&whitener.whiten(&column));
        }
        Some(Self { whitener, base })
    }

    /// The base model and all contributions but that at `index`.
    fn beside(&self, contributions: &[Vec<f64>], index: usize) -> Basis {
        let mut basis = self.base.clone();
        for (other, contribution) in contributions.iter().enumerate() {
            if other != index {
                basis.push(&self.whitener.whiten(contribution));
            }
        }
        basis
    }

    /// ρ of every contribution (arcsec, one value per row).
    pub fn rho(&self, contributions: &[Vec<f64>]) -> Vec<f64> {
        (0..contributions.len())
            .map(|index| {
                let z =
                    self.beside(contributions, index).residual(&self.whitener.whiten(&contributions[index]));
                norm(&z)
            })
            .collect()
    }

    /// ρ of every contribution with only the base model projected off.
    pub fn rho_alone(&self, contributions: &[Vec<f64>]) -> Vec<f64> {
        contributions.iter().flat_map(|c| self.rho(std::slice::from_ref(c))).collect()
    }

    /// The catalogued effect, none of `concealed`, that comes closest to the contribution at `index`; effects
    /// that contain it as a limiting case are passed over, for the simpler name is then the right one.
    pub fn closest_imitation(
        &self,
        columns: &Columns,
        contributions: &[Vec<f64>],
        concealed: &[&str],
        index: usize,
    ) -> Option<Imitation> {
        let basis = self.beside(contributions, index);
        let z = basis.residual(&self.whitener.whiten(&contributions[index]));
        let whole = dot(&z, &z);
        let limit_of = formulas::find(concealed[index]).and_then(|f| f.limit_of);
        let search = Search { columns, whitener: &self.whitener };
        let rivals = FORMULAS.iter().filter(|f| !concealed.contains(&f.id) && Some(f.id) != limit_of);
        rivals
            .map(|rival| {
                let (_, explained) = search.best(rival, &basis, &z, 1);
                Imitation { id: rival.id.to_owned(), rho_left: (whole - explained).max(0.0).sqrt() }
            })
            .min_by(|a, b| a.rho_left.total_cmp(&b.rho_left))
    }

    /// What the other concealed effects leave of all contributions together where theirs may take any
    /// parameters: a drift beside a warm-up may be a slower warm-up. None where there is no other.
    pub fn without(
        &self,
        columns: &Columns,
        contributions: &[Vec<f64>],
        concealed: &[&str],
        index: usize,
    ) -> Option<Imitation> {
        let target = self.all(columns, contributions);
        let mut left: Vec<_> = (0..concealed.len()).filter(|other| *other != index).collect();
        left.retain(|other| formulas::find(concealed[*other]).is_some());
        if left.is_empty() {
            return None;
        }
        let left = left.iter().filter_map(|other| formulas::find(concealed[*other]));
        let explained = self.explained_by(left, columns, &target, 1);
        let rho_left = (dot(&target, &target) - explained).max(0.0).sqrt();
        Some(Imitation { id: "the others".to_owned(), rho_left })
    }

    /// All contributions together, whitened, beside the base model.
    fn all(&self, columns: &Columns, contributions: &[Vec<f64>]) -> Vec<f64> {
        let mut sum = vec![0.0; columns.rows()];
        for contribution in contributions {
            sum.iter_mut().zip(contribution).for_each(|(s, c)| *s += c);
        }
        self.base.residual(&self.whitener.whiten(&sum))
    }

    /// How much of the squared norm of `target` formulas explain, their shapes sought from so many `starts`: one after
    /// the other, each to what those before it left, then all together.
    fn explained_by(
        &self,
        formulas: impl Iterator<Item = &'static Formula>,
        columns: &Columns,
        target: &[f64],
        starts: usize,
    ) -> f64 {
        let mut basis = self.base.clone();
        let mut shaped = Vec::new();
        let search = Search { columns, whitener: &self.whitener };
        for formula in formulas {
            let (best, _) = search.best(formula, &basis, &basis.residual(target), starts);
            search.white(&best).iter().for_each(|column| basis.push(column));
            shaped.push(best);
        }
        let shaped = search.jointly(shaped, &self.base, target);
        let wide: Vec<Vec<f64>> = shaped.iter().flat_map(|s| search.white(s)).collect();
        self.base.explained(&wide, target)
    }

    /// ρ of what effects of the table, whatever their parameters, leave of all contributions together: the better of two
    /// orders.
    pub fn left_by(&self, columns: &Columns, contributions: &[Vec<f64>], ids: &[&str]) -> f64 {
        let target = self.all(columns, contributions);
        let explained = |ids: &mut dyn Iterator<Item = &&str>| {
            let formulas = ids.filter_map(|id| formulas::find(id));
            self.explained_by(formulas, columns, &target, formulas::SEVERAL)
        };
        let explained = explained(&mut ids.iter()).max(explained(&mut ids.iter().rev()));
        (dot(&target, &target) - explained).max(0.0).sqrt()
    }
}
