//! Fourier coefficients of real records.

use realfft::RealFftPlanner;

use crate::Complex;

/// Coefficients X_k = (1/N) Σ x_n e^(−2πi k n/N) of a real record, k = 0 … N/2; units of the record.
///
/// A sine of amplitude a on line k has |X_k| = a/2. An empty record has no coefficients.
pub fn coefficients(record: &[f64]) -> Vec<Complex> {
    if record.is_empty() {
        return Vec::new();
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(record.len());
    let mut input = record.to_vec();
    let mut output = transform.make_output_vec();
    // Fails only where the lengths do not fit, and the plan made both.
    if transform.process(&mut input, &mut output).is_err() {
        output.fill(Complex::ZERO);
    }
    let scale = 1.0 / record.len() as f64;
    output.iter().map(|x| x * scale).collect()
}

/// Hann's window of `length` points, scaled to a mean square of one.
pub fn hann(length: usize) -> Vec<f64> {
    let step = std::f64::consts::TAU / length.max(1) as f64;
    let scale = (8.0f64 / 3.0).sqrt();
    (0..length).map(|n| scale * 0.5 * (1.0 - (step * n as f64).cos())).collect()
}
