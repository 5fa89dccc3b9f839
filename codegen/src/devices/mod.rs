//! One routine for many mirrors: the structure is shared, each device's coefficients lie in a page of flash.
//!
//! [`structure`] finds the degree and the binary point that serve all devices, and the ranges in which their
//! coefficients lie; [`page`] is the layout of a page, with its version, length and CRC-32; [`render`] prints the
//! routine and a loader that refuses what the proof does not cover.
//!
//! Two things are proved. For *any* coefficients inside the ranges, and any reading, no operation overflows and the
//! result is within the stated rounding of the polynomial that the page holds: the coefficients go through
//! `bound` as intervals. And for *every page* that `codegen` writes, the result is within the stated bound
//! of that device's own model: each page carries what was proved for it, and the loader holds it against the bound.

mod alike;
pub mod earlier;
pub mod page;
pub mod render;
pub mod structure;
pub mod verify;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fitter::coefficients::{Coefficients, CoefficientsError};
use fitter::input::FileError;

use crate::accepted::{NotAccepted, accepted};
use crate::certificate::Certificate;
use crate::design::DesignError;
use crate::generate::{GenerateError, sha256};
use crate::input::InputError;
use crate::options::Options;
use crate::reference::TooSteep;
use crate::render::RenderError;
use crate::routine::RoutineError;
use crate::text::rounded_up;

/// One mirror.
#[derive(Debug, Clone)]
pub struct Device {
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
    /// What is shared, and the devices' coefficients.
    pub design: structure::Design,
}

/// What else can be asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// By how much the ranges of the coefficients exceed those of the devices, as a part of the largest magnitude; and how
    /// much worse than the furthest of the devices a later one may be at least, within the bound that is asked for.
    pub margin: f64,
    /// Address of the page in flash, for the Intel HEX files.
    pub address: u32,
    /// An earlier routine that the devices are to share: then pages are made for it, and nothing else.
    pub earlier: Option<earlier::Earlier>,
}

impl Default for Wanted {
    fn default() -> Self {
        Wanted { margin: 0.25, address: 0, earlier: None }
    }
}

fitter::errors! {
    /// Why there is no routine for the devices; each a sentence that says what to change.
    #[derive(Debug)]
    pub enum DevicesError {
        None { pattern: String } =>
            says("no coefficients file matches {pattern}") mend("name the devices' files")
            by(devices = "'devices/*.json'");
        Twice { name: String, first: String, second: String } =>
            says("{first} and {second} would both be the device `{name}`")
            mend("give every device's file a name of its own");
        Name { name: String } =>
            says("the device's name {name:?} is to stand in generated files")
            mend("name its file with letters, digits, `-`, `_` and `.`");
        Earlier { file: String, what: String } =>
            at(file) says("{what}") mend("give the units.json that was written beside the routine") by(pages_for);
        OtherStructure { file: String, found: u32, expected: u32 } =>
            says("these options make another routine than that of {file} (structure {found}, there {expected})")
            mend("give the options that it was made with");
        Outside { device: String, coefficient: String, value: i64, from: i64, to: i64 } =>
            says("device {device}: its coefficient {coefficient} is {value}, outside the range {from} … {to} that the \
                routine was proved for")
            mend("generate a routine for all devices anew, or with a larger margin") by(margin);
        Coarse { device: String, found: f64, bound: f64, unit: String } =>
            says("device {device} is proven within {found:.3e} {unit} only, the routine's bound is {bound:.3e} {unit}")
            mend("generate a routine for all devices anew");
        NotAccepted { device: String, cause: NotAccepted } => of(cause) about("device {device}");
        Structure { device: String, what: &'static str, found: String, first: String, expected: String } =>
            says("device {device}: its {what} is {found}, that of device {first} {expected}: devices that share a \
                routine share their structure")
            mend("generate a routine of its own");
        /// Terms that a page does not hold.
        Term { device: String, effect: String } =>
            says("device {device}: its coefficients have the term {effect}, and a page holds polynomials of the \
                reading only")
            mend("leave it out, or generate a routine of its own") by(without = effect);
        WholeTurn { device: String } =>
            says("device {device} is an encoder, of a whole turn") mend("generate its routine by itself");
        Range { low: String, from: f64, high: String, to: f64, unit: String } =>
            says("the devices have no range in common: {low} begins at {from} {unit} and {high} ends at {to} {unit}")
            mend("state a range and allow to extrapolate, or leave one of them out") by(range) by(extrapolate);
        BeyondRecording { name: String, from: f64, to: f64, covered_from: f64, covered_to: f64, unit: String } =>
            says("device {name} covers {covered_from}…{covered_to} {unit}, not {from}…{to} {unit}")
            mend("narrow the range, or allow to extrapolate") by(range) by(extrapolate);
        Format(it: &'static str) =>
            says("pages hold 32-bit words") found("format {it}") expected("q31 or q31-split") by(format);
        Margin(it: f64) =>
            says("the margin is {it}") mend("give a part of the coefficients, 0 or more and at most 10") by(margin);
        Unreachable { degree: usize, wanted: f64, reachable: f64, worst: String, unit: String } =>
            says("no routine of degree {degree} or less is proven within {wanted:.3e} {unit} for all devices: the best \
                is {} {unit}, for device {worst}", rounded_up(*reachable))
            mend("ask for that, or for a smaller margin") by(bound) by(margin);
        TooSteep { device: String, cause: TooSteep } => of(cause) about("device {device}");
    }
    from {
        File(FileError),
        Coefficients(CoefficientsError),
        Routine(RoutineError),
        Design(DesignError),
        Input(InputError),
        Generate(GenerateError),
        Render(RenderError),
    }
}

/// Reads the devices' files, in the order of their names.
///
/// # Errors
/// [`DevicesError`]: none at all, two of one name, or a file that cannot be used.
pub fn read(files: &[PathBuf]) -> Result<Vec<Device>, DevicesError> {
    let mut devices: BTreeMap<String, (Device, &Path)> = BTreeMap::new();
    for file in files {
        let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        // `x.coefficients.json` is unit x.
        let name = stem.trim_end_matches(".coefficients").to_string();
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || !name.chars().all(plain) {
            return Err(DevicesError::Name { name });
        }
        if let Some((_, first)) = devices.get(&name) {
            let (first, second) = (first.display().to_string(), file.display().to_string());
            return Err(DevicesError::Twice { name, first, second });
        }
        let (coefficients, text) = fitter::coefficients::read_with_text(file)?;
        let sha256 = sha256(&text);
        devices.insert(name.clone(), (Device { name, coefficients, sha256 }, file));
    }
    Ok(devices.into_values().map(|(unit, _)| unit).collect())
}

/// The files that patterns stand for: a shell has replaced most; in what is left, `*` in the last part of the path
/// stands for anything.
///
/// # Errors
/// [`DevicesError::None`] where a pattern matches nothing.
pub fn expand(patterns: &[String]) -> Result<Vec<PathBuf>, DevicesError> {
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
            return Err(DevicesError::None { pattern: pattern.clone() });
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
/// [`DevicesError`], which says what to change.
pub fn generate(devices: &[Device], options: &Options, wanted: &Wanted) -> Result<Generated, DevicesError> {
    for device in devices {
        let cause = |cause| DevicesError::NotAccepted { device: device.name.clone(), cause };
        accepted(&device.coefficients, options).map_err(cause)?;
    }
    match &wanted.earlier {
        Some(earlier) => {
            let design = earlier::design(devices, options, wanted, earlier)?;
            render::pages(design, devices, options, wanted)
        }
        None => render::files(structure::design(devices, options, wanted)?, devices, options, wanted),
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
