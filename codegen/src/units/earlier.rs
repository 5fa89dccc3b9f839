//! A routine that is in the firmware already: pages for further units, of which every coefficient is held against the
//! ranges that it was proved for.

use std::path::Path;

use fitter::text_safety;
use serde::Deserialize;

use super::structure::{Design, Fitted, Prepared, Shared, overflow, prepare, rounded, structure};
use super::{Unit, UnitsError, Wanted};
use crate::bound;
use crate::design::DesignError;
use crate::options::Options;
use crate::routine::RoutineError;

/// What is read of `units.json`.
#[derive(Debug, Clone, PartialEq)]
pub struct Earlier {
    /// The file, for messages.
    pub file: String,
    summary: Summary,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Summary {
    schema: String,
    version: u32,
    structure: u32,
    degree: usize,
    fraction_bits: i64,
    range: [f64; 2],
    total: f64,
    coefficients: Vec<RangeOfWords>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct RangeOfWords {
    from: i64,
    to: i64,
}

/// Reads the summary of an earlier routine.
///
/// # Errors
/// [`UnitsError::Earlier`].
pub fn read(path: &Path) -> Result<Earlier, UnitsError> {
    let file = text_safety::path(path);
    let wrong = |what: String| UnitsError::Earlier { file: file.clone(), what };
    let text = fitter::input::parsed(path).map_err(|cause| wrong(format!("cannot be read ({cause})")))?;
    let summary: Summary =
        serde_json::from_str(&text).map_err(|cause| wrong(format!("is no summary of units ({cause})")))?;
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

/// The coefficients of further units for an earlier routine.
///
/// # Errors
/// [`UnitsError`]: other options, a coefficient outside its range, or a unit beyond the routine's bound.
pub fn design(
    units: &[Unit],
    options: &Options,
    wanted: &Wanted,
    earlier: &Earlier,
) -> Result<Design, UnitsError> {
    let summary = &earlier.summary;
    let at = (summary.range[0], summary.range[1]);
    let Prepared { plan, routine_options, references, quantity, range, sensor, .. } =
        prepare(units, options, Some(at))?;
    let shared =
        Shared { plan: &plan, options: &routine_options, references: &references, margin: wanted.margin };
    let (degree, bits) = (summary.degree, summary.fraction_bits);
    let ranges: Vec<(i64, i64)> = summary.coefficients.iter().map(|c| (c.from, c.to)).collect();
    let made = shared.program(&ranges, bits);
    let (program, unit) = made.map_err(|error| RoutineError::Design(DesignError::Output(error)))?;
    bound::rounding(&program, &plan).map_err(overflow)?;
    let mut design = Design {
        rounding: shared.rounding(&program, degree, bits)?,
        program,
        plan: plan.clone(),
        options: routine_options.clone(),
        degree,
        bits,
        unit,
        range,
        total: summary.total,
        fitted: Vec::new(),
        quantity,
        structure: 0,
    };
    design.structure = structure(&design, &sensor);
    if design.structure != summary.structure {
        let (found, expected) = (design.structure, summary.structure);
        return Err(UnitsError::OtherStructure { file: earlier.file.clone(), found, expected });
    }
    let words: Vec<Vec<i64>> = shared.best(degree).iter().map(|p| rounded(p, degree, bits)).collect();
    for (unit, words) in units.iter().zip(&words) {
        for (word, range) in words.iter().zip(&design.program.page) {
            if !(range.from..=range.to).contains(word) {
                return Err(UnitsError::Outside {
                    unit: unit.name.clone(),
                    coefficient: range.name.clone(),
                    value: *word,
                    from: range.from,
                    to: range.to,
                });
            }
        }
    }
    design.fitted = shared.bounds(&words, bits)?;
    let far = |fitted: &Fitted| fitted.total > design.total;
    if let Some((unit, fitted)) = units.iter().zip(&design.fitted).find(|(_, fitted)| far(fitted)) {
        return Err(UnitsError::Coarse {
            unit: unit.name.clone(),
            found: design.quantity.in_bound_unit(fitted.total),
            bound: design.quantity.in_bound_unit(design.total),
            bound_unit: design.quantity.bound_unit,
        });
    }
    Ok(design)
}
