//! What an effect refers to, a mean temperature for one, it shares with the base: a gain that drifts with temperature is
//! another gain at another temperature from which it is counted. Nobody knows that temperature. So what it does to the base
//! belongs to a difference of the effect, and does not show one by itself.

use numerics::{add_scaled, centred, dot, least_squares, rms};

use crate::rows::Rows;
use crate::thresholds::compare::OF_THE_BASE;

use super::joined::Joined;
use super::shared::Shared;

/// What the effect adds to the base of the later recording where it counts from other values of the columns that it reads,
/// over both recordings; `columns` are those of the effect, `base` those of the base.
pub fn of(shared: &Shared, columns: &[Vec<f64>], base: &[Vec<f64>], both: &Joined) -> Vec<Vec<f64>> {
    if shared.effect.is_none() {
        return Vec::new();
    }
    let later = |column: &Vec<f64>| column[both.split..].to_vec();
    let span: Vec<Vec<f64>> = base.iter().chain(columns).map(later).collect();
    let of_base = |(column, moved): (&Vec<f64>, &Vec<f64>)| {
        let by: Vec<f64> = later(moved).iter().zip(later(column)).map(|(m, c)| m - c).collect();
        let fit = least_squares(&span, &by);
        let moves = fit.rss < OF_THE_BASE * dot(&by, &by) && rms(&by) > OF_THE_BASE * rms(&later(column));
        moves.then(|| {
            let mut of_base = vec![0.0; column.len()];
            for (coefficient, column) in fit.coefficients.iter().zip(base) {
                add_scaled(&mut of_base, *coefficient, column);
            }
            of_base
        })
    };
    columns.iter().zip(&shared.columns(&both.with_later_columns_moved())).filter_map(of_base).collect()
}

impl Joined {
    /// With every further column of the later recording moved by as much as it scatters over both.
    fn with_later_columns_moved(&self) -> Joined {
        let mut moved = self.clone();
        let n = self.rows.len() - self.split;
        for (rows, later) in [(&mut moved.rows, self.split..self.rows.len()), (&mut moved.swapped, 0..n)] {
            let Rows { temperature_c, common_mode_um, cross_arcsec, coil_a, extra, .. } = rows;
            let known = [temperature_c, common_mode_um, cross_arcsec, coil_a].into_iter().flatten();
            for values in known.chain(extra.iter_mut().map(|column| &mut column.values)) {
                let scatter = rms(&centred(values));
                values[later.clone()].iter_mut().for_each(|value| *value += scatter);
            }
        }
        moved
    }
}
