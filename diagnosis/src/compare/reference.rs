//! What an effect refers to, a mean temperature for one, it shares with the base: a gain that drifts with temperature is
//! another gain at another temperature from which it is counted. Nobody knows that temperature, so what it does to the base
//! belongs to a difference of the effect, and shows none by itself.

use crate::numerics::{add_scaled, dot, least_squares, mean, rms};
use crate::rows::Column;
use crate::thresholds::compare::OF_THE_BASE;

use super::joined::Joined;
use super::shared::Shared;

/// What the effect adds to the base of the later recording where it counts from another value of a column, over both
/// recordings; `columns` are those of the effect, `base` those of the base.
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
    let counted = both.recorded().into_iter().map(|name| shared.columns(&both.counted_from_another(&name)));
    counted.flat_map(|moved| columns.iter().zip(&moved).filter_map(of_base).collect::<Vec<_>>()).collect()
}

impl Joined {
    /// The names of the columns from whose values an effect may count.
    fn recorded(&self) -> Vec<String> {
        let known = ["temperature_c", "common_mode_um", "cross_arcsec", "coil_a"];
        let known = known.iter().map(|name| (*name).to_string());
        known.chain(self.rows.extra.iter().map(|column| column.name.clone())).collect()
    }

    /// With a column of the later recording moved by as much as it scatters.
    fn counted_from_another(&self, name: &str) -> Joined {
        let mut moved = self.clone();
        let n = self.rows.len() - self.split;
        for (rows, later) in [(&mut moved.rows, self.split..self.rows.len()), (&mut moved.swapped, 0..n)] {
            let known = match name {
                "temperature_c" => rows.temperature_c.as_mut(),
                "common_mode_um" => rows.common_mode_um.as_mut(),
                "cross_arcsec" => rows.cross_arcsec.as_mut(),
                "coil_a" => rows.coil_a.as_mut(),
                _ => None,
            };
            let extra = rows.extra.iter_mut().find(|column| column.name == name);
            if let Some(values) = known.or(extra.map(|Column { values, .. }| values)) {
                let centre = mean(values);
                let scatter = rms(&values.iter().map(|v| v - centre).collect::<Vec<f64>>());
                values[later].iter_mut().for_each(|v| *v += scatter);
            }
        }
        moved
    }
}
