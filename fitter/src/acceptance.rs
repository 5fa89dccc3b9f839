//! Whether a coefficients file may be used: asked by `apply`, by the generator, and by the fit and the diagnosis
//! before they write one, so that what is written is never refused.
//!
//! Two questions. *Can it be evaluated?* ([`to_apply`]) And *is it a correction of the device?* ([`to_generate`]):
//! a model that leaves more structure than it names corrects the reading in part only, and firmware should not
//! carry it unless someone who knows has said so.

use thiserror::Error;

use crate::coefficients::{Coefficients, Diagnosed};
use crate::limits;

/// The verdicts, as [`Diagnosed::verdict`] holds them.
pub const VERDICTS: [&str; 5] = ["consistent", "explained", "described", "partly_explained", "unexplained"];

/// Why a coefficients file is not accepted.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Refusal {
    /// It cannot be evaluated, or not be read again once it is written.
    #[error("the coefficients are damaged ({0})")]
    Damaged(String),
    /// A number of it is beyond what can be computed with.
    #[error("the coefficients cannot be computed with ({0})")]
    Limits(String),
    /// It can be evaluated, but corrects the device in part only.
    #[error("{0}")]
    Unexplained(Reservation),
}

/// What a diagnosis left open, with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Reservation {
    /// What the diagnosis said.
    pub diagnosed: Diagnosed,
    /// Root mean square of what is left beyond the noise.
    pub left: f64,
    /// Root mean square of what was found.
    pub named: f64,
    /// Unit of the figures.
    pub unit: String,
}

impl std::fmt::Display for Reservation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Reservation { diagnosed, left, named, unit } = self;
        let Diagnosed { verdict, before_rms, after_rms, noise_floor } = diagnosed;
        let [left, named, before, after, floor] = [left, named, before_rms, after_rms, noise_floor]
            .map(|value| format!("{} {unit}", figure(*value)));
        let found = match self.named > 0.0 {
            true => format!("what was found makes up {named} of the {before} before"),
            false => "nothing was found that makes it less".to_string(),
        };
        write!(
            f,
            "the diagnosis of the recording ended `{verdict}`: this model leaves {after} rms at a noise of {floor}, that \
             is {left} of structure that it does not explain; {found}"
        )
    }
}

/// Three digits: a figure of noise has no more.
fn figure(value: f64) -> String {
    const DIGITS: i32 = 3;
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = DIGITS - 1 - value.abs().log10().floor() as i32;
    format!("{value:.*}", decimals.clamp(0, 15) as usize)
}

/// Whether the model can be evaluated, now and once it is written and read again.
///
/// # Errors
/// [`Refusal::Damaged`], with what contradicts itself; [`Refusal::Limits`], with the field.
pub fn to_apply(coefficients: &Coefficients) -> Result<(), Refusal> {
    coefficients.usable().map_err(Refusal::Damaged)?;
    limits::of_model(coefficients).map_err(Refusal::Limits)
}

/// Whether firmware may be generated from the model: it can be evaluated, and its diagnosis, where it had one, left
/// no more structure than it named. `accept_unexplained` lets the latter pass: what is left open is given back then,
/// for the files to say so.
///
/// # Errors
/// [`Refusal`], with the reason and the figures.
pub fn to_generate(
    coefficients: &Coefficients,
    accept_unexplained: bool,
) -> Result<Option<Reservation>, Refusal> {
    to_apply(coefficients)?;
    match reservation(coefficients) {
        Some(reservation) if !accept_unexplained => Err(Refusal::Unexplained(reservation)),
        reservation => Ok(reservation),
    }
}

/// What the diagnosis left open, where that is more than it named; none for a file of `fit`.
pub fn reservation(coefficients: &Coefficients) -> Option<Reservation> {
    let diagnosed = coefficients.diagnosis.as_ref()?;
    let (left, named) = (diagnosed.left(), diagnosed.named());
    let open = match diagnosed.verdict.as_str() {
        "unexplained" => true,
        "partly_explained" => left > named,
        _ => false,
    };
    let unit = coefficients.units.statistics.clone();
    open.then(|| Reservation { diagnosed: diagnosed.clone(), left, named, unit })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_model::{ErrorModel, Sensor};

    /// A file of which a diagnosis said this.
    fn file(verdict: &str, before_rms: f64, after_rms: f64, noise_floor: f64) -> Coefficients {
        let sensor = Sensor::Direct { unit: "mm".into(), revolution: None };
        let model = ErrorModel { sensor, centre: 0.0, coefficients: vec![0.1, 0.2] };
        let diagnosis = Diagnosed { verdict: verdict.into(), before_rms, after_rms, noise_floor };
        Coefficients { diagnosis: Some(diagnosis), ..Coefficients::of_model(&model, -1.0, 1.0, "by hand") }
    }

    #[test]
    fn more_left_than_named_needs_a_word() {
        for (file, accepted) in [
            (file("consistent", 1.0, 1.0, 1.0), true),
            (file("explained", 5.0, 1.0, 1.0), true),
            (file("described", 5.0, 1.1, 1.0), true),
            // 4.8 named, 1.1 left.
            (file("partly_explained", 5.0, 1.5, 1.0), true),
            // 3.0 named, 3.9 left.
            (file("partly_explained", 5.0, 4.0, 1.0), false),
            (file("unexplained", 12.0, 12.0, 0.16), false),
        ] {
            let verdict = &file.diagnosis.as_ref().unwrap().verdict;
            assert_eq!(to_generate(&file, false).is_ok(), accepted, "{verdict}");
            assert_eq!(to_generate(&file, true).unwrap().is_none(), accepted, "{verdict}");
            assert!(to_apply(&file).is_ok());
        }
        let said = to_generate(&file("partly_explained", 5.0, 4.0, 1.0), false).unwrap_err().to_string();
        assert!(said.contains("`partly_explained`") && said.contains("leaves 4.00 mm rms"), "{said}");
        let small = to_generate(&file("unexplained", 4e-4, 4e-4, 5e-5), false).unwrap_err().to_string();
        assert!(small.contains("leaves 0.000400 mm rms at a noise of 0.0000500 mm"), "{small}");
        assert!(said.contains("3.87 mm of structure") && said.contains("3.00 mm of the 5.00"), "{said}");
    }

    #[test]
    fn what_could_not_be_read_again_is_refused_before_it_is_written() {
        let sound = file("explained", 5.0, 1.0, 1.0);
        type Damage = fn(&mut Coefficients);
        let damaged: [(&str, Damage); 7] = [
            ("`base.coefficients`", |f| f.base.coefficients[1] = f64::NAN),
            ("order 30", |f| f.set_base(vec![1e-9; 31])),
            ("`valid_range` runs", |f| f.valid_range.to = f.valid_range.from),
            ("verdict", |f| f.diagnosis.as_mut().unwrap().verdict = "perhaps".into()),
            ("`diagnosis`", |f| f.diagnosis.as_mut().unwrap().after_rms = f64::INFINITY),
            ("`diagnosis`", |f| f.diagnosis.as_mut().unwrap().noise_floor = -1.0),
            ("observed", |f| f.observed = [("temperature_c".to_string(), [f64::NAN, 1.0])].into()),
        ];
        for (reason, damage) in damaged {
            let mut file = sound.clone();
            damage(&mut file);
            let refusal = to_apply(&file).unwrap_err();
            assert!(
                matches!(&refusal, Refusal::Damaged(said) if said.contains(reason)),
                "{reason}: {refusal}"
            );
            assert_eq!(to_generate(&file, true), Err(refusal), "{reason}");
            assert!(crate::coefficients::parse("a.json", &file.to_sealed_json()).is_err(), "{reason}");
        }
    }
}
