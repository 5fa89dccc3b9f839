//! One routine for many mirrors: the structure is shared, each unit's coefficients lie in a page of flash.
//!
//! [`structure`] finds the degree and the binary point that serve all units, and the ranges in which their
//! coefficients lie; [`page`] is the layout of a page, with its version, length and CRC-32; [`render`] prints the
//! routine and a loader that refuses what the proof does not cover.
//!
//! Two things are proved. For *any* coefficients inside the ranges, and any reading, no operation overflows and the
//! result is within the stated rounding of the polynomial that the page holds: the coefficients go through
//! `bound` as intervals. And for *every page* that `codegen` writes, the result is within the stated bound
//! of that unit's own model: each page carries what was proved for it, and the loader holds it against the bound.

mod alike;
pub mod earlier;
pub mod page;
pub mod render;
pub mod structure;
pub mod verify;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fitter::coefficients::{Coefficients, CoefficientsError};

use crate::accepted::{NotAccepted, accepted};
use crate::certificate::Certificate;
use crate::design::DesignError;
use crate::generate::{GenerateError, sha256};
use crate::input::InputError;
use crate::options::Options;
use crate::reference::TooSteep;
use crate::render::RenderError;
use crate::routine::RoutineError;

/// One mirror.
#[derive(Debug, Clone)]
pub struct Unit {
    /// The stem of its file: what its page is called.
    pub name: String,
    /// Its coefficients.
    pub coefficients: Coefficients,
    /// SHA-256 of their file.
    pub sha256: String,
}

/// Everything that was generated; nothing is written yet.
#[derive(Debug, Clone)]
pub struct Generated {
    /// Base name of crate, files and functions.
    pub name: String,
    /// Contents by path, relative to the output folder.
    pub files: BTreeMap<PathBuf, Vec<u8>>,
    /// The certificate, which is also among the files.
    pub certificate: Certificate,
    /// What is shared, and the units' coefficients.
    pub design: structure::Design,
}

/// What else can be asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// By how much the ranges of the coefficients exceed those of the units, as a part of the largest magnitude; and how
    /// much worse than the furthest of the units a later one may be at least, within the bound that is asked for.
    pub margin: f64,
    /// Address of the page in flash, for the Intel HEX files.
    pub address: u32,
    /// An earlier routine that the units are to share: then pages are made for it, and nothing else.
    pub earlier: Option<earlier::Earlier>,
}

impl Default for Wanted {
    fn default() -> Self {
        Wanted { margin: 0.25, address: 0, earlier: None }
    }
}

/// Why there is no routine for the units; each a sentence that says what to change.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the messages say what the fields are
pub enum UnitsError {
    /// No unit.
    #[error(
        "no coefficients file matches {pattern}: give the units' files, for example --devices 'units/*.json'"
    )]
    None { pattern: String },
    /// Two units of one name.
    #[error("{first} and {second} would both be the unit `{name}`: give every unit's file a name of its own")]
    Twice { name: String, first: String, second: String },
    /// A name that neither a file nor a comment should carry.
    #[error(
        "the unit's name {name:?} is to stand in generated files: name its file with letters, digits, `-`, `_` and `.`"
    )]
    Name { name: String },
    /// The summary of an earlier routine.
    #[error("{file}: {what}; give the units.json that `codegen --devices` wrote beside the routine")]
    Earlier { file: String, what: String },
    /// Options that make another routine.
    #[error(
        "these options make another routine than that of {file} (structure {found}, there {expected}): give the options \
         that it was made with"
    )]
    OtherStructure { file: String, found: u32, expected: u32 },
    /// A coefficient that the loader would refuse.
    #[error(
        "unit {unit}: its coefficient {coefficient} is {value}, outside the range {from} … {to} that the routine was proved \
         for: generate a routine for all units anew, or with a larger --margin"
    )]
    Outside { unit: String, coefficient: String, value: i64, from: i64, to: i64 },
    /// A unit that the routine does not serve well enough.
    #[error(
        "unit {unit} is proven within {found:.3e} {bound_unit} only, the routine's bound is {bound:.3e} {bound_unit}: generate a \
         routine for all units anew"
    )]
    Coarse { unit: String, found: f64, bound: f64, bound_unit: String },
    /// A unit of which the diagnosis left more than it named.
    #[error("unit {unit}: {cause}")]
    NotAccepted { unit: String, cause: NotAccepted },
    #[error(transparent)]
    Coefficients(#[from] CoefficientsError),
    /// Units of different kinds.
    #[error(
        "unit {unit}: its {what} is {found}, that of unit {first} {expected}: units that share a routine share their \
         structure; generate a routine of its own"
    )]
    Structure { unit: String, what: &'static str, found: String, first: String, expected: String },
    /// Terms that a page does not hold.
    #[error(
        "unit {unit}: its coefficients have the term {effect}, and a page holds polynomials of the reading only: leave \
         it out with --without {effect}, or generate a routine of its own"
    )]
    Term { unit: String, effect: String },
    /// A whole turn.
    #[error("unit {unit} is an encoder, of a whole turn: generate its routine by itself, without --devices")]
    WholeTurn { unit: String },
    /// No range in common.
    #[error(
        "the units have no range in common: {low} begins at {from} {unit} and {high} ends at {to} {unit}; give --from and \
         --to with --extrapolate, or leave one of them out"
    )]
    Range { low: String, from: f64, high: String, to: f64, unit: String },
    /// A range beyond a unit's recording.
    #[error(
        "unit {name} covers {covered_from}…{covered_to} {unit}, not {from}…{to} {unit}: narrow --from and --to, or give \
         --extrapolate"
    )]
    BeyondRecording { name: String, from: f64, to: f64, covered_from: f64, covered_to: f64, unit: String },
    /// Not the format.
    #[error("pages hold 32-bit words: format q31 or q31-split, not {0}")]
    Format(&'static str),
    /// An unusable margin.
    #[error("the margin is {0}: give a part of the coefficients, 0 or more and at most 10")]
    Margin(f64),
    /// The bound cannot be met.
    #[error(
        "no routine of degree {degree} or less is proven within {wanted:.3e} {unit} for all units: the best is {reachable:.3e} \
         {unit}, for unit {worst}; ask for that, or for a smaller --margin"
    )]
    Unreachable { degree: usize, wanted: f64, reachable: f64, worst: String, unit: String },
    /// Options of other routines.
    #[error("{option} does not go with --devices: leave it out")]
    Option { option: &'static str },
    #[error(transparent)]
    Routine(#[from] RoutineError),
    /// No program of this format.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The input does not fit.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The range is too wide for the geometry.
    #[error("unit {unit}: {cause}")]
    TooSteep { unit: String, cause: TooSteep },
    /// A name that no source can carry.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Reads the units' files, in the order of their names.
///
/// # Errors
/// [`UnitsError`]: none at all, two of one name, or a file that cannot be used.
pub fn read(files: &[PathBuf]) -> Result<Vec<Unit>, UnitsError> {
    let mut units: BTreeMap<String, (Unit, &Path)> = BTreeMap::new();
    for file in files {
        let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        // `x.coefficients.json` is unit x.
        let name = stem.trim_end_matches(".coefficients").to_string();
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || !name.chars().all(plain) {
            return Err(UnitsError::Name { name });
        }
        if let Some((_, first)) = units.get(&name) {
            let (first, second) = (first.display().to_string(), file.display().to_string());
            return Err(UnitsError::Twice { name, first, second });
        }
        let (coefficients, text) = fitter::coefficients::read_with_text(file)?;
        let sha256 = sha256(&text);
        units.insert(name.clone(), (Unit { name, coefficients, sha256 }, file));
    }
    Ok(units.into_values().map(|(unit, _)| unit).collect())
}

/// The files that patterns stand for: a shell has replaced most; in what is left, `*` in the last part of the path
/// stands for anything.
///
/// # Errors
/// [`UnitsError::None`] where a pattern matches nothing.
pub fn expand(patterns: &[String]) -> Result<Vec<PathBuf>, UnitsError> {
    let mut files = Vec::new();
    for pattern in patterns {
        let path = Path::new(pattern);
        let last = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if !last.contains('*') {
            files.push(path.to_path_buf());
            continue;
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let entries = std::fs::read_dir(folder).map(|entries| entries.flatten().collect::<Vec<_>>());
        let mut found: Vec<PathBuf> = (entries.unwrap_or_default().into_iter())
            .filter(|entry| matches(&last, &entry.file_name().to_string_lossy()))
            .map(|entry| entry.path())
            .collect();
        if found.is_empty() {
            return Err(UnitsError::None { pattern: pattern.clone() });
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}

/// Whether a name is what a pattern with `*` stands for.
fn matches(pattern: &str, name: &str) -> bool {
    let parts: Vec<&str> = pattern.split('*').collect();
    let (first, last) = (parts[0], parts[parts.len() - 1]);
    if name.len() < first.len() + last.len() || !name.starts_with(first) || !name.ends_with(last) {
        return false;
    }
    let mut rest = &name[first.len()..name.len() - last.len()];
    parts[1..parts.len() - 1].iter().all(|part| match rest.find(part) {
        Some(at) => {
            rest = &rest[at + part.len()..];
            true
        }
        None => false,
    })
}

/// Generates the routine, the loader, the pages and the certificate.
///
/// # Errors
/// [`UnitsError`], which says what to change.
pub fn generate(units: &[Unit], options: &Options, wanted: &Wanted) -> Result<Generated, UnitsError> {
    for unit in units {
        let cause = |cause| UnitsError::NotAccepted { unit: unit.name.clone(), cause };
        accepted(&unit.coefficients, options).map_err(cause)?;
    }
    match &wanted.earlier {
        Some(earlier) => {
            let design = earlier::design(units, options, wanted, earlier)?;
            render::pages(design, units, options, wanted)
        }
        None => render::files(structure::design(units, options, wanted)?, units, options, wanted),
    }
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn stars_stand_for_anything() {
        assert!(
            matches("*.json", "a.json") && matches("u*.json", "unit-7.json") && matches("a*b*c", "a1b2c")
        );
        assert!(!matches("*.json", "a.json.bak") && !matches("ab*b", "ab") && !matches("u*.json", "v.json"));
    }
}
