//! How far the model may be from the device: an *estimate*, kept apart from the bound, which says how far the routine
//! is from the model.
//!
//! It is the root of the sum of the squares of
//! - what the fit left beyond the noise: the largest mean error at a point of the recording, of a diagnosed file
//!   1.96·√(after² − noise²);
//! - the 95 % interval of what was fitted (`estimate`);
//! - 95 % of the scatter of one reading, in which are the repeatability of the sensor and the noise of the reference;
//! - what the routine leaves out of the model, at most.
//!
//! So it is never below what the recording itself showed. A systematic error of the reference is in none of them.

use fitter::coefficients::Coefficients;
use serde::{Deserialize, Serialize};

use crate::estimate::NORMAL_95;
use crate::text;

/// The estimate, as the certificate has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// How far the model may be from the device.
    pub distance: f64,
    /// What it is made of: the root of the sum of their squares.
    pub parts: Vec<Share>,
}

/// A part of the estimate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// What it is.
    pub what: String,
    /// How much, in the entry's unit.
    pub value: f64,
}

impl Claim {
    /// The estimate for a file; `interval` is the 95 % band of what was fitted, `left_out` the largest value of each
    /// term that the routine leaves out. None where the file does not say what the recording showed.
    pub fn of(coefficients: &Coefficients, interval: Option<f64>, left_out: &[f64]) -> Option<Claim> {
        let scatter = NORMAL_95 * coefficients.noise()?;
        let mut parts = vec![
            left(coefficients),
            interval.map(|value| Share { what: "95 % interval of what was fitted".into(), value }),
            Some(Share {
                what: "95 % of the scatter of a reading: repeatability, and noise of the reference".into(),
                value: scatter,
            }),
        ];
        let out = left_out.iter().sum::<f64>();
        parts.push(Some(Share { what: "what is left out of the routine, at most".into(), value: out }));
        let parts: Vec<Share> = parts.into_iter().flatten().filter(|part| part.value > 0.0).collect();
        let distance = parts.iter().map(|part| part.value * part.value).sum::<f64>().sqrt();
        distance.is_finite().then_some(Claim { distance, parts })
    }

    /// The estimate as text: the figure, and its parts.
    pub fn in_words(&self, unit: &str) -> (String, Vec<String>) {
        let of = |value: f64| format!("{} {unit}", text::rounded_up(value));
        let part = |part: &Share| format!("{}  {}", of(part.value), part.what);
        (of(self.distance), self.parts.iter().map(part).collect())
    }
}

/// What the fit left beyond the noise: the larger of what the diagnosis and the statistics of the fit say.
fn left(coefficients: &Coefficients) -> Option<Share> {
    let diagnosed = coefficients.diagnosis.as_ref().map(|d| Share {
        what: "95 % of what the model leaves beyond the noise".into(),
        value: NORMAL_95 * d.left(),
    });
    let fitted = coefficients.statistics.as_ref().map(|s| Share {
        what: "largest mean error that the fit left at a point of the recording".into(),
        value: s.after.max_of_point_means,
    });
    match (diagnosed, fitted) {
        (Some(a), Some(b)) => Some(if a.value >= b.value { a } else { b }),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_coefficients;
    use fitter::coefficients::Diagnosed;

    /// Twelve arcseconds are left where the fit knows its coefficients to 0.16: the model is no nearer than twelve.
    #[test]
    fn what_the_recording_showed_is_never_undercut() {
        let mut file = paper_coefficients();
        assert_eq!(Claim::of(&file, Some(0.16), &[]), None);
        let verdict = "unexplained".to_string();
        file.diagnosis = Some(Diagnosed { verdict, before_rms: 12.0, after_rms: 12.0, noise_floor: 0.5 });
        let claim = Claim::of(&file, Some(0.16), &[]).unwrap();
        assert!(claim.distance > 12.0 && claim.distance < 24.0, "{claim:?}");
        assert_eq!(claim.parts.len(), 3);
        // Nothing is left beyond the noise.
        file.diagnosis.as_mut().unwrap().after_rms = 0.49;
        let claim = Claim::of(&file, Some(0.16), &[]).unwrap();
        assert!((claim.distance - (0.16f64.powi(2) + 0.98f64.powi(2)).sqrt()).abs() < 1e-4, "{claim:?}");
        let more = Claim::of(&file, Some(0.16), &[3.0, 4.0]).unwrap();
        assert!(more.distance > 7.0 && more.parts.len() == 3, "{more:?}");
    }

    #[test]
    fn a_fit_that_is_off_at_a_point_is_off() {
        let (recording, mirror) = fitter::default_recording().unwrap();
        let order = Some(1);
        let options = fitter::Options { order, ..fitter::Options::default() };
        let file = fitter::fit(&recording, &mirror, &options).unwrap().coefficients;
        let worst = file.statistics.as_ref().unwrap().after.max_of_point_means;
        let claim = Claim::of(&file, Some(0.1), &[]).unwrap();
        assert!(worst > 5.0 && claim.distance >= worst, "{worst} {claim:?}");
        let (figure, parts) = claim.in_words("arcsec");
        assert!(figure.ends_with(" arcsec") && parts[0].contains("largest mean error"), "{figure} {parts:?}");
    }
}
