//! The observables as columns of a regression, with what the angle explains projected off.

use nalgebra::{DMatrix, DVector};

use crate::fit::Fit;
use crate::points::Grouping;
use crate::recording::{Readings, Recording};

/// An observable and the columns that stand for it.
pub(super) struct Candidate {
    pub name: String,
    pub columns: Vec<DVector<f64>>,
}

/// Everything that the tests need.
pub(super) struct Design {
    /// The rows of the recording that are used, ascending.
    pub rows: Vec<usize>,
    /// Weighted residual, the angle projected off.
    pub residual: DVector<f64>,
    /// The observables, likewise.
    pub candidates: Vec<Candidate>,
    /// Number of dimensions that were projected off.
    pub absorbed: usize,
    projection: Projection,
}

/// Rows that are used at most, evenly spaced: enough to see what is worth a diagnosis.
const MOST_ROWS: usize = 100_000;
/// More passes than this are bundled.
const MOST_PASSES: usize = 12;

impl Design {
    /// None if the recording is too short to test anything.
    pub fn of(recording: &Recording, fit: &Fit) -> Option<Design> {
        let stride = recording.rows().div_ceil(MOST_ROWS);
        let rows: Vec<usize> = (0..recording.rows()).step_by(stride).collect();
        let repeated = fit.points.grouping != Grouping::Block && fit.points.single_angles;
        let root = |row: usize| fit.weights[fit.points.of_row[row] as usize].sqrt();
        let half_width = fit.basis.half_width;
        let angle = |row: usize| (fit.calibrated.reading[row] - fit.basis.centre) / half_width;
        let projection =
            if repeated { Projection::points(fit, &rows) } else { Projection::powers(fit, &rows) };
        if rows.len() < projection.dimensions() + 8 {
            return None;
        }
        // Values as a column: centred, scaled, weighted, projected; none if nothing is left.
        let column = |value: &dyn Fn(usize) -> f64| -> Option<DVector<f64>> {
            let known: Vec<f64> = rows.iter().map(|row| value(*row)).filter(|v| !v.is_nan()).collect();
            if known.len() < 8 {
                return None;
            }
            let mean = known.iter().sum::<f64>() / known.len() as f64;
            let entry = |row: usize| if value(row).is_nan() { 0.0 } else { value(row) - mean };
            let mut column =
                DVector::from_iterator(rows.len(), rows.iter().map(|row| entry(*row) * root(*row)));
            let before = column.norm();
            projection.apply(&mut column);
            let after = column.norm();
            // What is left of a function of the angle is rounding, not an observable.
            if after <= 1e-7 * before || after == 0.0 {
                return None;
            }
            column /= after;
            Some(column)
        };
        let mut candidates = Vec::new();
        let mut offer = |name: &str, columns: Vec<Option<DVector<f64>>>| {
            let columns: Vec<DVector<f64>> = columns.into_iter().flatten().collect();
            if !columns.is_empty() {
                candidates.push(Candidate { name: name.to_string(), columns });
            }
        };
        let level_and_gain = |value: &dyn Fn(usize) -> f64| {
            let known: Vec<f64> = rows.iter().map(|row| value(*row)).filter(|v| !v.is_nan()).collect();
            let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
            vec![column(value), column(&|row| (value(row) - mean) * angle(row))]
        };
        offer("t_s", level_and_gain(&|row| recording.time_s[row]));
        let direction = |row: usize| f64::from(recording.direction[row]);
        offer(
            "direction",
            vec![
                column(&direction),
                column(&|row| direction(row) * angle(row)),
                column(&|row| direction(row) * angle(row) * angle(row)),
            ],
        );
        let passes = recording.passes();
        let bundles = passes.len().min(MOST_PASSES);
        let bundle =
            |row: usize| passes.partition_point(|p| *p < recording.pass[row]) * bundles / passes.len();
        offer("pass", (1..bundles).map(|b| column(&|row| f64::from(u8::from(bundle(row) == b)))).collect());
        if let Readings::Pair { x1_mm, x2_mm, .. } = &recording.readings {
            offer("common_mode_um", level_and_gain(&|row| 500.0 * (x1_mm[row] + x2_mm[row])));
        }
        for further in &recording.further {
            offer(&further.name, level_and_gain(&|row| further.values[row]));
        }
        let mut residual =
            DVector::from_iterator(rows.len(), rows.iter().map(|row| fit.residual[*row] * root(*row)));
        projection.apply(&mut residual);
        let absorbed = projection.dimensions();
        Some(Design { rows, residual, candidates, absorbed, projection })
    }

    /// aᵀ Σ b with Σᵢⱼ = correlation^|i−j|, in one sweep.
    pub fn correlated(&self, a: &DVector<f64>, b: &DVector<f64>, correlation: f64) -> f64 {
        let (mut sum, mut past_a, mut past_b) = (0.0, 0.0, 0.0);
        for row in 0..a.len() {
            if row > 0 {
                past_a = correlation * (past_a + a[row - 1]);
                past_b = correlation * (past_b + b[row - 1]);
            }
            sum += a[row] * b[row] + a[row] * past_b + b[row] * past_a;
        }
        sum
    }

    /// What is left of a projected vector after a regression on the columns, `inverse` being the inverse of
    /// their products.
    pub fn without(
        &self,
        columns: &[&DVector<f64>],
        inverse: &DMatrix<f64>,
        mut vector: DVector<f64>,
    ) -> DVector<f64> {
        let products = DVector::from_fn(columns.len(), |i, _| columns[i].dot(&vector));
        let joint = inverse * products;
        columns.iter().zip(joint.iter()).for_each(|(column, c)| vector.axpy(-c, column, 1.0));
        vector
    }

    /// Projects off what the angle explains.
    pub fn project(&self, vector: &mut DVector<f64>) {
        self.projection.apply(vector);
    }
}

/// What a function of the angle alone explains.
enum Projection {
    /// Any function: the mean of each point.
    Points { of_row: Vec<u32>, count: usize },
    /// A polynomial a few orders above that of the fit: orthonormal columns.
    Powers(Vec<DVector<f64>>),
}

impl Projection {
    fn points(fit: &Fit, rows: &[usize]) -> Projection {
        let of_row = rows.iter().map(|row| fit.points.of_row[*row]).collect();
        Projection::Points { of_row, count: fit.points.count() }
    }

    fn powers(fit: &Fit, rows: &[usize]) -> Projection {
        let order = (fit.coefficients.base.order + super::BEYOND).min(fit.basis.order());
        let mut values = vec![0.0; order + 1];
        let mut columns = vec![DVector::zeros(rows.len()); order + 1];
        for (index, row) in rows.iter().enumerate() {
            let reading = fit.calibrated.reading[*row];
            fit.basis.evaluate(reading, &mut values);
            let gain = fit.coefficients.sensor.gain(reading);
            columns.iter_mut().zip(&values).for_each(|(column, p)| column[index] = gain * p);
        }
        // Gram–Schmidt, twice: the columns are nearly orthogonal to begin with.
        for k in 0..columns.len() {
            let (before, from) = columns.split_at_mut(k);
            for _ in 0..2 {
                for earlier in before.iter() {
                    let product = earlier.dot(&from[0]);
                    from[0].axpy(-product, earlier, 1.0);
                }
            }
            let norm = from[0].norm();
            from[0] /= norm.max(f64::MIN_POSITIVE);
        }
        Projection::Powers(columns)
    }

    fn dimensions(&self) -> usize {
        match self {
            Projection::Points { count, .. } => *count,
            Projection::Powers(columns) => columns.len(),
        }
    }

    fn apply(&self, column: &mut DVector<f64>) {
        match self {
            Projection::Points { of_row, count } => {
                let (mut sum, mut rows) = (vec![0.0; *count], vec![0.0; *count]);
                for (value, point) in column.iter().zip(of_row) {
                    sum[*point as usize] += value;
                    rows[*point as usize] += 1.0;
                }
                for (value, point) in column.iter_mut().zip(of_row) {
                    *value -= sum[*point as usize] / rows[*point as usize];
                }
            }
            Projection::Powers(columns) => {
                for basis in columns {
                    let product = basis.dot(column);
                    column.axpy(-product, basis, 1.0);
                }
            }
        }
    }
}
