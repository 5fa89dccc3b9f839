//! The little linear algebra that scoring needs: whitening by a covariance, and projections in the whitened
//! space.

/// Part of a column's norm below which what an orthonormal basis leaves of it is rounding.
const DEPENDENT: f64 = 1e-9;

/// A linear map W with Wᵀ W = Σ⁻¹: in the whitened space the noise is white, of unit standard deviation.
#[derive(Debug, Clone)]
pub enum Whitener {
    /// Independent readings: their standard deviations.
    Diagonal(Vec<f64>),
    /// The lower Cholesky factor of Σ, row by row, each row as long as its diagonal reaches.
    Factor(Vec<Vec<f64>>),
}

impl Whitener {
    /// From the covariance of `rows` readings, row by row; none where it is not positive definite.
    pub fn new(covariance: &[f64], rows: usize) -> Option<Self> {
        let at = |i: usize, j: usize| covariance[i * rows + j];
        let independent = (0..rows).all(|i| (0..i).all(|j| at(i, j) == 0.0));
        if independent {
            let deviations: Vec<f64> = (0..rows).map(|i| at(i, i).sqrt()).collect();
            return deviations.iter().all(|d| *d > 0.0).then_some(Self::Diagonal(deviations));
        }
        let mut factor: Vec<Vec<f64>> = Vec::with_capacity(rows);
        for i in 0..rows {
            let mut row = Vec::with_capacity(i + 1);
            for j in 0..i {
                let earlier: &Vec<f64> = &factor[j];
                let value = (at(i, j) - dot(&row[..j], &earlier[..j])) / earlier[j];
                row.push(value);
            }
            let square = at(i, i) - dot(&row, &row);
            if square <= 0.0 || square.is_nan() {
                return None;
            }
            row.push(square.sqrt());
            factor.push(row);
        }
        Some(Self::Factor(factor))
    }

    /// No weighting at all, for ordinary least squares.
    pub fn identity(rows: usize) -> Self {
        Self::Diagonal(vec![1.0; rows])
    }

    /// W · `values`.
    pub fn whiten(&self, values: &[f64]) -> Vec<f64> {
        match self {
            Self::Diagonal(deviations) => values.iter().zip(deviations).map(|(v, d)| v / d).collect(),
            Self::Factor(factor) => {
                let mut out = Vec::with_capacity(values.len());
                for (row, value) in factor.iter().zip(values) {
                    let before = out.len();
                    out.push((value - dot(&row[..before], &out)) / row[before]);
                }
                out
            }
        }
    }
}

/// An orthonormal basis that grows by columns.
#[derive(Debug, Clone, Default)]
pub struct Basis {
    columns: Vec<Vec<f64>>,
}

impl Basis {
    /// Adds a column, unless it already lies in the space.
    pub fn push(&mut self, column: &[f64]) {
        self.push_beyond(column, DEPENDENT);
    }

    /// Adds a column, unless the space leaves no more than this part of its norm.
    pub fn push_beyond(&mut self, column: &[f64], least: f64) {
        self.keep(self.residual(column), least * norm(column));
    }

    fn keep(&mut self, rest: Vec<f64>, least: f64) {
        let norm = norm(&rest);
        if norm > least {
            self.columns.push(rest.into_iter().map(|r| r / norm).collect());
        }
    }

    /// Number of columns.
    pub fn rank(&self) -> usize {
        self.columns.len()
    }

    /// The squared length of the part of `target` that lies in the space.
    pub fn square_of(&self, target: &[f64]) -> f64 {
        self.columns.iter().map(|unit| dot(unit, target).powi(2)).sum()
    }

    /// What the space does not hold of `column`. Twice is enough (Kahan, Parlett).
    pub fn residual(&self, column: &[f64]) -> Vec<f64> {
        self.projected_off(&self.projected_off(column))
    }

    /// The same but for rounding of the order of the parts that cancel.
    pub fn projected_off(&self, column: &[f64]) -> Vec<f64> {
        let mut rest = column.to_vec();
        for unit in &self.columns {
            let amount = dot(unit, &rest);
            rest.iter_mut().zip(unit).for_each(|(r, u)| *r -= amount * u);
        }
        rest
    }

    /// How much of the squared norm of `target`, itself orthogonal to the space, `columns` explain beside it.
    pub fn explained(&self, columns: &[Vec<f64>], target: &[f64]) -> f64 {
        let mut wider = Self { columns: Vec::with_capacity(columns.len()) };
        for column in columns {
            wider.keep(wider.residual(&self.residual(column)), 1e-6 * norm(column));
        }
        wider.square_of(target)
    }
}

/// Amplitudes of `columns` that fit `target` best in the plain metric, by orthogonalisation; a column that
/// depends on earlier ones has the amplitude zero.
pub fn least_squares(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    // Every orthonormal vector is remembered with its recipe in terms of the columns.
    let mut units: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for (k, column) in columns.iter().enumerate() {
        let mut rest = column.clone();
        let mut recipe = vec![0.0; columns.len()];
        recipe[k] = 1.0;
        for _ in 0..2 {
            for (unit, made_of) in &units {
                let amount = dot(unit, &rest);
                rest.iter_mut().zip(unit).for_each(|(r, u)| *r -= amount * u);
                recipe.iter_mut().zip(made_of).for_each(|(r, m)| *r -= amount * m);
            }
        }
        let left = norm(&rest);
        if left > DEPENDENT * norm(column) {
            rest.iter_mut().for_each(|r| *r /= left);
            recipe.iter_mut().for_each(|r| *r /= left);
            units.push((rest, recipe));
        }
    }
    let mut amplitudes = vec![0.0; columns.len()];
    for (unit, recipe) in &units {
        let amount = dot(unit, target);
        amplitudes.iter_mut().zip(recipe).for_each(|(a, r)| *a += amount * r);
    }
    amplitudes
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Euclidean norm: of a whitened column, ρ.
pub fn norm(column: &[f64]) -> f64 {
    dot(column, column).sqrt()
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Root mean square about the mean.
pub fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    (values.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_inverts_the_covariance() {
        let rows = 5;
        let covariance: Vec<f64> = (0..rows * rows)
            .map(|k| 2.0 * (-((k / rows) as f64 - (k % rows) as f64).abs() / 2.0).exp())
            .collect();
        let whitener = Whitener::new(&covariance, rows).unwrap();
        // For z = Σ u, zᵀ Σ⁻¹ z = uᵀ Σ u.
        let u = [1.0, -2.0, 0.5, 3.0, -1.0];
        let z: Vec<f64> = (0..rows).map(|i| dot(&covariance[i * rows..(i + 1) * rows], &u)).collect();
        let white = whitener.whiten(&z);
        assert!((dot(&white, &white) - dot(&u, &z)).abs() < 1e-10);
    }

    #[test]
    fn a_covariance_that_is_none_is_refused() {
        assert!(Whitener::new(&[1.0, 2.0, 2.0, 1.0], 2).is_none());
        assert!(Whitener::new(&[0.0, 0.0, 0.0, 1.0], 2).is_none());
    }

    #[test]
    fn least_squares_finds_the_amplitudes() {
        let x: Vec<f64> = (0..20).map(|i| f64::from(i) / 10.0).collect();
        let columns = vec![
            vec![1.0; 20],
            x.clone(),
            x.iter().map(|x| x * x).collect(),
            x.iter().map(|x| 2.0 * x).collect(),
        ];
        let target: Vec<f64> = x.iter().map(|x| 3.0 - x + 0.5 * x * x).collect();
        let found = least_squares(&columns, &target);
        for (found, wanted) in found.iter().zip([3.0, -1.0, 0.5, 0.0]) {
            assert!((found - wanted).abs() < 1e-9, "{found} for {wanted}");
        }
    }

    #[test]
    fn what_is_spanned_is_projected_off() {
        let mut basis = Basis::default();
        basis.push(&[1.0, 0.0, 0.0]);
        basis.push(&[1.0, 1.0, 0.0]);
        basis.push(&[3.0, 4.0, 0.0]);
        assert_eq!(basis.rank(), 2);
        assert!((norm(&basis.residual(&[5.0, 6.0, 7.0])) - 7.0).abs() < 1e-12);
    }
}
