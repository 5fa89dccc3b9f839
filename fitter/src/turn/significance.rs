//! Whether a column belongs into the fit, where what is left over is correlated from row to row.
//!
//! By Frisch, Waugh and Lovell the coefficient is the mean of u = x·e over that of x², x being what the other columns leave
//! of the column and e the errors. Its variance is that of the sum of u, and this is told by sums over blocks of rows
//! (batch means): within a block the rows may be as correlated as they like. Blocks of several lengths are tried, and the
//! largest variance counts.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::description::Estimate;

/// A column belongs into the fit where chance would show it less often than this: one clean recording in a thousand gets a
/// term that it does not need, and that term is then as small as the noise.
pub(super) const CHANCE: f64 = 1e-3;
/// Blocks become longer by this factor from one trial to the next.
const GROWTH: usize = 4;
/// Fewest blocks: of fewer the variance is known too badly to be of use.
const BLOCKS: usize = 16;

/// A coefficient with an honest uncertainty.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tested {
    standard_error: f64,
    freedom: f64,
    /// The chance of one so far from zero.
    pub p_value: f64,
}

impl Tested {
    /// Of a coefficient, `column` being what the other columns leave of its column, and `residual` what all of them leave of
    /// the errors. None where too little was recorded to tell.
    pub fn of(coefficient: f64, column: &[f64], residual: &[f64]) -> Option<Tested> {
        let rows = column.len();
        let squares: f64 = column.iter().map(|x| x * x).sum();
        let mut length = 1;
        let mut widest: Option<(f64, f64)> = None;
        while rows / length >= BLOCKS {
            let blocks = rows.div_ceil(length);
            let sums = column.chunks(length).zip(residual.chunks(length));
            let variance: f64 = sums
                .map(|(x, e)| x.iter().zip(e).map(|(x, e)| x * e).sum::<f64>())
                .map(|sum| sum * sum)
                .sum::<f64>()
                * (blocks as f64 / (blocks - 1) as f64);
            if widest.is_none_or(|(largest, _)| variance > largest) {
                widest = Some((variance, (blocks - 1) as f64));
            }
            length *= GROWTH;
        }
        let (variance, freedom) = widest?;
        if squares <= 0.0 {
            return None;
        }
        let standard_error = variance.sqrt() / squares;
        let t = StudentsT::new(0.0, 1.0, freedom).ok()?;
        let p_value = 2.0 * t.sf((coefficient / standard_error.max(f64::MIN_POSITIVE)).abs());
        Some(Tested { standard_error, freedom, p_value })
    }

    /// Whether the column belongs into the fit.
    pub fn significant(&self) -> bool {
        self.p_value < CHANCE
    }

    /// `factor` times the coefficient, with its interval.
    pub fn estimate(&self, coefficient: f64, factor: f64) -> Estimate {
        let quantile = StudentsT::new(0.0, 1.0, self.freedom).map_or(2.0, |t| t.inverse_cdf(0.975));
        Estimate::of(factor * coefficient, factor.abs() * self.standard_error, quantile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slow wave that both the column and the errors hold by chance is no proof; white noise of that size is.
    #[test]
    fn correlated_noise_is_no_proof() {
        let column: Vec<f64> = (0..1600).map(|i| f64::from(i) / 800.0 - 1.0).collect();
        let slow: Vec<f64> = (0..1600).map(|i| (f64::from(i) / 120.0).sin()).collect();
        let fast: Vec<f64> = (0..1600).map(|i| (f64::from(i * i % 97) / 5.0).sin()).collect();
        let (slow, fast) = (Tested::of(0.2, &column, &slow), Tested::of(0.2, &column, &fast));
        assert!(!slow.unwrap().significant() && fast.unwrap().significant());
        assert!(Tested::of(1.0, &[1.0; 8], &[0.1; 8]).is_none());
    }
}
