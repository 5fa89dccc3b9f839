//! Small Hermitian systems, one for each spectral line.

use crate::Complex;

/// Lower factor L of S = L Lᴴ, `size × size` by rows; `None` where S is not positive definite to rounding.
pub fn cholesky(s: &[Complex], size: usize) -> Option<Vec<Complex>> {
    let mut l = vec![Complex::ZERO; size * size];
    let scale = (0..size).map(|i| s[i * size + i].re).fold(0.0, f64::max);
    for i in 0..size {
        for j in 0..=i {
            let mut sum = s[i * size + j];
            for k in 0..j {
                sum -= l[i * size + k] * l[j * size + k].conj();
            }
            if i == j {
                if sum.re <= 1e-12 * scale || sum.re.is_nan() {
                    return None;
                }
                l[i * size + i] = Complex::new(sum.re.sqrt(), 0.0);
            } else {
                l[i * size + j] = sum / l[j * size + j].re;
            }
        }
    }
    Some(l)
}

/// X = B S⁻¹ for `rows` rows of B, given the factor L of S.
pub fn divide(b: &[Complex], rows: usize, l: &[Complex], size: usize) -> Vec<Complex> {
    let mut x = b.to_vec();
    for row in x.chunks_exact_mut(size).take(rows) {
        // Row vector x with x L Lᴴ = b: first t Lᴴ = b, then x L = t.
        for j in 0..size {
            let mut sum = row[j];
            for k in 0..j {
                sum -= row[k] * l[j * size + k].conj();
            }
            row[j] = sum / l[j * size + j].re;
        }
        for j in (0..size).rev() {
            let mut sum = row[j];
            for k in j + 1..size {
                sum -= row[k] * l[k * size + j];
            }
            row[j] = sum / l[j * size + j].re;
        }
    }
    x
}
