//! Holding a result against the `f64` reference and the certificate.

use codegen::certificate::Entry;
use codegen::interpret::Word;
use fitter::ErrorModel;

/// The value of a result in the bound's unit (arcsec; a direct sensor's own).
pub fn value(entry: &Entry, model: &ErrorModel, bits: u32) -> f64 {
    let number = match entry.output.ty.as_str() {
        "f32" => f64::from(f32::from_bits(bits)),
        _ => f64::from(bits as i32),
    };
    number * entry.output.lsb * model.sensor.per_internal()
}

/// The reference in the same unit: [`ErrorModel::corrected`], nothing else.
pub fn reference(model: &ErrorModel, reading: f64) -> f64 {
    model.corrected(reading) * model.sensor.per_internal()
}

/// What `f64` itself can have rounded in [`reference()`] and [`value()`], in the same unit: sixteen roundings of
/// every quantity that is added up, far below any bound.
pub fn slack(model: &ErrorModel, reading: f64) -> f64 {
    let x = (reading - model.centre).abs();
    let mut size = model.uncorrected(reading).abs();
    let gain = model.sensor.gain(reading);
    for (k, a) in model.coefficients.iter().enumerate() {
        let power = x.powi(k as i32);
        // The value, and what a rounding of the reading becomes.
        let steep = if k == 0 { 0.0 } else { k as f64 * x.powi(k as i32 - 1) * reading.abs() };
        size += gain * a.abs() * ((k + 1) as f64 * power + steep);
    }
    16.0 * f64::EPSILON * size * model.sensor.per_internal()
}

/// The bits of an interpreted result as a compiled routine returns them.
pub fn bits(word: Word) -> u32 {
    match word {
        Word::Int(value) => value as u32,
        Word::Float(value) => value.to_bits(),
    }
}
