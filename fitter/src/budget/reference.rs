//! The part of the reference: type B, as it was stated.

use super::{Component, Distribution};
use crate::coefficients::Coefficients;

/// The stated accuracy of the reference: limits of its error anywhere on its scale, or a certificate's expanded
/// uncertainty. None where nothing was stated.
pub fn reference(file: &Coefficients) -> Option<Component> {
    let stated = file.recorded.as_ref()?.reference;
    let (accuracy, unit) = (stated.accuracy?, &file.units.statistics);
    Some(match stated.coverage_factor {
        Some(factor) => {
            let what = "reference: stated expanded uncertainty";
            Component::of("reference", what, unit, accuracy, Distribution::Normal, factor)
        }
        None => Component::within("reference", "reference: stated accuracy", unit, accuracy),
    })
}

/// What of the reference a file does not say; none where it says it.
pub fn missing(file: &Coefficients) -> Option<String> {
    let key = match file.units.statistics.as_str() {
        "arcsec" => "accuracy_arcsec",
        _ => "accuracy",
    };
    match &file.recorded {
        None => Some(format!(
            "the file is of an earlier version and says nothing of the reference, the step of its readings and its \
             passes: state `{key}` under [reference] in mirror.toml and fit again"
        )),
        Some(recorded) if recorded.reference.accuracy.is_none() => Some(format!(
            "the accuracy of the reference: state `{key}` in {} under [reference] in mirror.toml and fit again",
            file.units.statistics
        )),
        Some(_) => None,
    }
}
