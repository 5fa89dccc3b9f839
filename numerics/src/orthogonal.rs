//! Orthonormal bases, built one column at a time, and one matrix product for many columns at once.

use crate::DEPENDENT;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Arch, Simd, WithSimd};

/// Partial sums of an inner product: enough for two of the widest registers, and the same on every processor.
const LANES: usize = 16;

/// Inner product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    Arch::new().dispatch(Dot(a, b))
}

/// `y += a x`.
pub fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    Arch::new().dispatch(AddScaled(y, a, x));
}

/// An inner product, to be taken in the widest registers that the processor has. (A closure would not do: it is
/// called, and compiled, apart.)
struct Dot<'a>(&'a [f64], &'a [f64]);

impl WithSimd for Dot<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        dot_here(self.0, self.1)
    }
}

/// `y += a x`, likewise.
struct AddScaled<'a>(&'a mut [f64], f64, &'a [f64]);

impl WithSimd for AddScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        add_scaled_here(self.0, self.1, self.2);
    }
}

/// Takes from a vector its part in orthonormal columns, likewise.
struct ProjectOff<'a>(&'a Columns, &'a mut [f64]);

impl WithSimd for ProjectOff<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let ProjectOff(columns, v) = self;
        for q in columns.data.chunks_exact(columns.rows.max(1)) {
            let a = dot_here(q, v);
            add_scaled_here(v, -a, q);
        }
    }
}

/// The inner product, compiled for the instructions of whoever calls it.
#[inline(always)]
fn dot_here(a: &[f64], b: &[f64]) -> f64 {
    // Partial sums: the compiler may not reorder a floating-point sum by itself.
    let mut sums = [0.0; LANES];
    let (chunks_a, chunks_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = chunks_a.remainder().iter().zip(chunks_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in chunks_a.zip(chunks_b) {
        for k in 0..LANES {
            sums[k] += x[k] * y[k];
        }
    }
    let mut width = LANES / 2;
    while width > 0 {
        for k in 0..width {
            sums[k] += sums[k + width];
        }
        width /= 2;
    }
    sums[0] + rest
}

#[inline(always)]
fn add_scaled_here(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Columns of equal length, stored one after another.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// Length of a column.
    pub rows: usize,
    data: Vec<f64>,
}

impl Columns {
    /// No columns yet, each to be of length `rows`.
    pub fn new(rows: usize) -> Columns {
        Columns { rows, data: Vec::new() }
    }

    /// Number of columns.
    pub fn count(&self) -> usize {
        self.data.len().checked_div(self.rows).unwrap_or(0)
    }

    /// Column `k`.
    pub fn get(&self, k: usize) -> &[f64] {
        &self.data[k * self.rows..(k + 1) * self.rows]
    }

    /// Appends a column.
    pub fn push(&mut self, column: &[f64]) {
        self.data.extend_from_slice(column);
    }

    /// Makes room for so many further columns.
    pub fn reserve(&mut self, further: usize) {
        self.data.reserve_exact(further * self.rows);
    }

    /// So many further columns of zeros, one after another, to be written.
    pub fn further(&mut self, count: usize) -> &mut [f64] {
        let first = self.data.len();
        self.data.resize(first + count * self.rows, 0.0);
        &mut self.data[first..]
    }

    /// The columns before column `k`, one after another, and column `k`, to be changed.
    pub fn split(&mut self, k: usize) -> (&[f64], &mut [f64]) {
        let (earlier, rest) = self.data.split_at_mut(k * self.rows);
        (earlier, &mut rest[..self.rows])
    }

    /// Puts column `from` where column `to` is.
    pub fn move_up(&mut self, from: usize, to: usize) {
        self.data.copy_within(from * self.rows..(from + 1) * self.rows, to * self.rows);
    }

    /// The columns made orthonormal, given the Cholesky factor of their products.
    pub fn orthonormal(mut self, factor: &[f64]) -> Columns {
        let n = self.count();
        for k in 0..n {
            let row = &factor[k * n..=k * n + k];
            let (earlier, column) = self.split(k);
            for (q, l) in earlier.chunks_exact(column.len()).zip(row) {
                add_scaled(column, -l, q);
            }
            column.iter_mut().for_each(|v| *v /= row[k]);
        }
        self
    }

    /// Takes from every column its part in the span of an orthonormal `basis`.
    pub fn project_off(&mut self, basis: &Columns) {
        let components = basis.products(self);
        let (m, n, k) = (basis.count(), self.count(), self.rows);
        matmul(
            MatMut::from_column_major_slice_mut(&mut self.data, k, n),
            Accum::Add,
            MatRef::from_column_major_slice(&basis.data, k, m),
            MatRef::from_column_major_slice(&components, m, n),
            -1.0,
            Par::Seq,
        );
    }

    /// Drops all columns from `count` on.
    pub fn truncate(&mut self, count: usize) {
        self.data.truncate(count * self.rows);
    }

    /// All inner products of these columns with those of `other`: `count × other.count`, by columns.
    pub fn products(&self, other: &Columns) -> Vec<f64> {
        let (m, n, k) = (self.count(), other.count(), self.rows);
        let mut out = vec![0.0; m * n];
        matmul(
            MatMut::from_column_major_slice_mut(&mut out, m, n),
            Accum::Replace,
            MatRef::from_column_major_slice(&self.data, k, m).transpose(),
            MatRef::from_column_major_slice(&other.data, k, n),
            1.0,
            Par::Seq,
        );
        out
    }
}

/// Columns in single precision, for products of which six digits are enough: half the time.
#[derive(Debug, Clone)]
pub struct SingleColumns {
    rows: usize,
    data: Vec<f32>,
}

impl From<&Columns> for SingleColumns {
    fn from(columns: &Columns) -> SingleColumns {
        SingleColumns { rows: columns.rows, data: columns.data.iter().map(|v| *v as f32).collect() }
    }
}

impl SingleColumns {
    /// Number of columns.
    pub fn count(&self) -> usize {
        self.data.len().checked_div(self.rows).unwrap_or(0)
    }

    /// Appends to `out` all inner products of these columns with those of `other`: `count × other.count`, by columns.
    pub fn products_onto(&self, other: &SingleColumns, out: &mut Vec<f32>) {
        let (m, n, k) = (self.count(), other.count(), self.rows);
        let first = out.len();
        out.resize(first + m * n, 0.0);
        matmul(
            MatMut::from_column_major_slice_mut(&mut out[first..], m, n),
            Accum::Replace,
            MatRef::from_column_major_slice(&self.data, k, m).transpose(),
            MatRef::from_column_major_slice(&other.data, k, n),
            1.0,
            Par::Seq,
        );
    }
}

/// An orthonormal basis, grown column by column (modified Gram–Schmidt, twice).
#[derive(Debug, Clone, Default)]
pub struct Basis {
    /// The orthonormal columns.
    pub columns: Columns,
}

impl Basis {
    /// An empty basis for columns of length `rows`.
    pub fn new(rows: usize) -> Basis {
        Basis { columns: Columns::new(rows) }
    }

    /// Number of columns.
    pub fn rank(&self) -> usize {
        self.columns.count()
    }

    /// Takes from `v` its part in the basis.
    pub fn project_off(&self, v: &mut [f64]) {
        Arch::new().dispatch(ProjectOff(&self.columns, v));
    }

    /// Adds a column after projecting off the others; `false` where nothing but rounding is left of it.
    pub fn add(&mut self, v: &[f64]) -> bool {
        let length = dot(v, v).sqrt();
        let mut w = v.to_vec();
        self.project_off(&mut w);
        let once = dot(&w, &w).sqrt();
        if once.is_nan() || once <= DEPENDENT * length {
            return false;
        }
        if once < 0.1 * length {
            self.project_off(&mut w);
        }
        let left = dot(&w, &w).sqrt();
        if left.is_nan() || left <= DEPENDENT * length {
            return false;
        }
        w.iter_mut().for_each(|x| *x /= left);
        self.columns.push(&w);
        true
    }
}
