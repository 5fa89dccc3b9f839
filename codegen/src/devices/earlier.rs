//! A routine that is in the firmware already: pages for further devices, of which every coefficient is held against the
//! ranges that it was proved for.

use std::path::Path;

use fitter::text_safety;

use super::render::Summary;
use super::structure::{Design, Fitted, Shared, rounded};
use super::{Device, DevicesError, Wanted};
use crate::bound;
use crate::design::DesignError;
use crate::options::Options;

/// What is read of `units.json`.
#[derive(Debug, Clone, PartialEq)]
pub struct Earlier {
    /// The file, for messages.
    pub file: String,
    summary: Summary,
}

/// Reads the summary of an earlier routine.
///
/// # Errors
/// [`DevicesError::Earlier`].
pub fn read(path: &Path) -> Result<Earlier, DevicesError> {
    let file = text_safety::path(path);
    let wrong = |what: String| DevicesError::Earlier { file: file.clone(), what };
    let text = fitter::input::parsed(path, "units.json")?;
    let summary: Summary =
        serde_json::from_str(&text).map_err(|cause| wrong(format!("is no summary of devices ({cause})")))?;
    if summary.schema != "arcsmith-units" || summary.version != 1 {
        return Err(wrong(format!(
            "is {} version {}, expected arcsmith-units version 1",
            summary.schema, summary.version
        )));
    }
    if summary.coefficients.len() != summary.degree + 1 {
        return Err(wrong(format!(
            "has {} coefficients for degree {}",
            summary.coefficients.len(),
            summary.degree
        )));
    }
    let words = summary.coefficients.iter().flat_map(|c| [c.from, c.to]);
    if !(0..=62).contains(&summary.fraction_bits) || words.clone().any(|w| i32::try_from(w).is_err()) {
        return Err(wrong("holds words that no page holds".into()));
    }
    Ok(Earlier { file, summary })
}

/// The coefficients of further devices for an earlier routine.
///
/// # Errors
/// [`DevicesError`]: other options, a coefficient outside its range, or a unit beyond the routine's bound.
pub fn design(
    devices: &[Device],
    options: &Options,
    wanted: &Wanted,
    earlier: &Earlier,
) -> Result<Design, DevicesError> {
    let Summary { degree, fraction_bits: bits, range: [from, to], total, .. } = earlier.summary;
    let shared = Shared::new(devices, options, wanted, Some((from, to)))?;
    let (program, unit) = shared.program(earlier.summary.coefficients.clone(), bits)?;
    bound::rounding(&program, &shared.plan).map_err(DesignError::from)?;
    let words: Vec<Vec<i64>> = shared.best(degree).iter().map(|p| rounded(p, degree, bits)).collect();
    let mut design = Design { shared, program, degree, bits, unit, total, rounding: 0.0, fitted: Vec::new() };
    design.rounding = design.any_rounding()?;
    let (found, expected) = (design.structure(), earlier.summary.structure);
    if found != expected {
        return Err(DevicesError::OtherStructure { file: earlier.file.clone(), found, expected });
    }
    for (device, words) in devices.iter().zip(&words) {
        for (word, range) in words.iter().zip(&design.program.page) {
            if !(range.from..=range.to).contains(word) {
                let (device, coefficient) = (device.name.clone(), range.name.clone());
                let (value, from, to) = (*word, range.from, range.to);
                return Err(DevicesError::Outside { device, coefficient, value, from, to });
            }
        }
    }
    design.fitted = design.shared.bounds(&words, bits)?;
    let far = |fitted: &Fitted| fitted.total > design.total;
    if let Some((device, fitted)) = devices.iter().zip(&design.fitted).find(|(_, fitted)| far(fitted)) {
        let quantity = &design.shared.quantity;
        return Err(DevicesError::Coarse {
            device: device.name.clone(),
            found: quantity.in_bound_unit(fitted.total),
            bound: quantity.in_bound_unit(design.total),
            unit: quantity.bound_unit.clone(),
        });
    }
    Ok(design)
}
