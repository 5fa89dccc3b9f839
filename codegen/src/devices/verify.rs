//! The check from outside: the files against a new generation, every device's page through the compiled loader and
//! routine in Rust and C, held against that device's own function, and damaged pages, which both must refuse.

use std::path::{Path, PathBuf};

use minijinja::{Value, context};
use serde::Serialize;

use super::page::{HEAD_WORDS, Page};
use super::render::page;
use super::structure::{Design, Fitted};
use super::{Device, Generated, Wanted};
use crate::files;
use crate::interpret::{Word, interpret};
use crate::program::Program;
use crate::reference::Reference;
use crate::text::camel_case;
use crate::verify::compile::{How, Place, fed, temporary, words};
use crate::verify::domain::Domain;
use crate::verify::fast_reference::FastReference;
use crate::verify::{VerifyError, absolute, belonging};

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnitsReport {
    /// What is wrong with certificate and files; empty where nothing is.
    pub certificate: Vec<String>,
    /// Every unit in every language.
    pub sweeps: Vec<UnitSweep>,
    /// Damaged pages that a loader took.
    pub taken: Vec<String>,
    /// How many damaged pages were tried in each language.
    pub damaged: u64,
}

/// One unit's page through one language.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnitSweep {
    /// The unit.
    pub unit: String,
    /// The language.
    pub language: String,
    /// Readings that were given, those beyond the range among them.
    pub readings: u64,
    /// Readings of which the result is not the proved program's; all where the loader refuses the page.
    pub different: u64,
    /// The largest distance from the unit's own function, in the bound's unit, what the reference may be off included.
    pub worst: f64,
    /// What was proved for the device.
    pub bound: f64,
}

impl UnitsReport {
    /// Whether everything holds.
    pub fn holds(&self) -> bool {
        let good = |s: &UnitSweep| s.different == 0 && s.worst <= s.bound;
        self.certificate.is_empty() && self.taken.is_empty() && self.sweeps.iter().all(good)
    }

    /// The report as text.
    pub fn text(&self) -> String {
        let mut lines: Vec<String> = self.certificate.iter().map(|what| format!("REFUSED {what}")).collect();
        if lines.is_empty() {
            lines.push("certificate, pages and files: as generated anew".into());
        }
        for s in &self.sweeps {
            lines.push(format!(
                "{:<16} {:<5} {} readings: {} differ from the proved program, {:.3e} from the device's function at most, \
                 proved {:.3e}",
                s.unit, s.language, s.readings, s.different, s.worst, s.bound
            ));
        }
        lines.push(format!("{} damaged pages, {} taken", self.damaged, self.taken.len()));
        lines.extend(self.taken.iter().map(|what| format!("TAKEN {what}")));
        lines.push(if self.holds() { "verified" } else { "DOES NOT HOLD" }.into());
        lines.join("\n") + "\n"
    }
}

/// Checks the files in `folder`; `sanitize` has the C watched for undefined behaviour.
///
/// # Errors
/// [`VerifyError`] where a check cannot be made.
pub fn verify(
    folder: &Path,
    generated: &Generated,
    devices: &[Device],
    wanted: &Wanted,
    sanitize: bool,
) -> Result<UnitsReport, VerifyError> {
    let design = &generated.design;
    let certificate = match &wanted.earlier {
        // The certificate is that of the first devices; only pages are added.
        Some(_) => (files::compare(folder, &generated.files).into_iter())
            .map(|(file, difference)| format!("{} {difference}", file.display()))
            .collect(),
        None => {
            let stated = belonging::read_certificate(folder)?;
            belonging::check(folder, &stated, &generated.certificate, &generated.files)
        }
    };
    let (folder, build) = (absolute(folder)?, temporary()?);
    let place = Place { generated: &folder, base: &generated.name, build: build.path() };
    let programs = compile(&place, design, sanitize)?;
    let mut report = UnitsReport { certificate, sweeps: Vec::new(), taken: Vec::new(), damaged: 0 };
    for ((device, fitted), reference) in devices.iter().zip(&design.fitted).zip(&design.shared.references) {
        let bytes = written(&folder, device, || page(design, device, fitted).bytes());
        report.sweeps.extend(sweeps(design, (device, fitted, reference), &bytes, &programs)?);
    }
    let Some((device, fitted)) = devices.iter().zip(&design.fitted).next() else { return Ok(report) };
    let damaged = damaged(design, &page(design, device, fitted));
    report.damaged = damaged.len() as u64;
    let pages: Vec<Given<'_>> = damaged.iter().map(|(_, bytes)| (&bytes[..], &[][..])).collect();
    for (language, program) in &programs {
        for ((what, _), (status, _)) in damaged.iter().zip(run(program, &pages)?) {
            if status == 0 {
                report.taken.push(format!("{what}, by the loader in {language}"));
            }
        }
    }
    Ok(report)
}

/// A unit's page through every language.
fn sweeps(
    design: &Design,
    (device, fitted, reference): (&Device, &Fitted, &Reference),
    page: &[u8],
    programs: &[(&'static str, PathBuf)],
) -> Result<Vec<UnitSweep>, VerifyError> {
    let Design { shared, unit: lsb, .. } = design;
    // The unit's routine, as if its coefficients were its own.
    let mut program = design.program.clone();
    for (range, word) in program.page.iter_mut().zip(&fitted.words) {
        (range.from, range.to) = (*word, *word);
    }
    let program = &program;
    let fast_reference = FastReference::new(program, &shared.plan, reference, lsb, fitted.total);
    let domain = Domain::of(program);
    let indices: Vec<u64> = domain.interpreted(program).indices().collect();
    let given: Vec<Vec<u32>> = indices.iter().map(|i| domain.words(program, *i)).collect();
    let expected: Vec<Option<i64>> = (indices.iter())
        .map(|i| interpret(program, &domain.arguments(program, *i)).ok().map(|out| out.word.bits()))
        .collect();
    let mut sweeps = Vec::new();
    for (language, executable) in programs {
        let found = run(executable, &[(page, &given)])?;
        let (status, results) = found.into_iter().next().unwrap_or((-1, Vec::new()));
        let refused = status != 0 || results.len() != given.len();
        let (mut different, mut worst) = (if refused { given.len() as u64 } else { 0 }, 0.0f64);
        for ((index, bits), expected) in indices.iter().zip(&results).zip(&expected) {
            different += u64::from(expected.is_none_or(|e| e as u32 != *bits));
            let reading = reading(&domain.arguments(program, *index));
            worst = worst.max((result(program, *bits) - fast_reference.at(reading)).abs());
        }
        let beyond = (worst - fast_reference.error).max(0.0) * lsb.to_f64();
        sweeps.push(UnitSweep {
            unit: device.name.clone(),
            language: (*language).into(),
            readings: given.len() as u64,
            different,
            worst: shared.quantity.in_bound_unit(beyond),
            bound: shared.quantity.in_bound_unit(fitted.total),
        });
    }
    Ok(sweeps)
}

/// The page as it lies in the folder; as it would be generated where it is missing, which the comparison has said.
fn written(folder: &Path, device: &Device, otherwise: impl Fn() -> Vec<u8>) -> Vec<u8> {
    std::fs::read(folder.join(format!("pages/{}.bin", device.name))).unwrap_or_else(|_| otherwise())
}

/// The reading in its own words, as the routine forms it.
fn reading(arguments: &[Word]) -> f64 {
    match arguments {
        [Word::Int(x1), Word::Int(x2)] => (x2 - x1) as f64,
        [Word::Float(x1), Word::Float(x2)] => f64::from(x2 - x1),
        [Word::Int(s), ..] => *s as f64,
        [Word::Float(s), ..] => f64::from(*s),
        [] => 0.0,
    }
}

/// A result as a number of output words.
fn result(program: &Program, bits: u32) -> f64 {
    match program.output_type() {
        crate::program::Type::F32 => f64::from(f32::from_bits(bits)),
        _ => f64::from(bits as i32),
    }
}

/// Pages that no loader may take: every bit turned over, and what a CRC does not tell.
fn damaged(design: &Design, good: &Page) -> Vec<(String, Vec<u8>)> {
    let bytes = good.bytes();
    let mut all: Vec<(String, Vec<u8>)> = (0..8 * bytes.len())
        .map(|bit| {
            let mut turned = bytes.clone();
            turned[bit / 8] ^= 1 << (bit % 8);
            (format!("a page with bit {bit} turned over"), turned)
        })
        .collect();
    all.push(("a page that is cut short".into(), bytes[..bytes.len() - 1].to_vec()));
    all.push(("an erased page".into(), vec![0xff; bytes.len()]));
    let mut other = good.clone();
    other.structure ^= 1;
    all.push(("a page of another routine".into(), other.bytes()));
    let mut coarse = good.clone();
    coarse.proved = u32::MAX;
    all.push(("a page whose bound is above the routine's".into(), coarse.bytes()));
    for (k, range) in design.program.page.iter().enumerate() {
        for (end, word) in [("below", range.from - 1), ("above", range.to + 1)] {
            let Ok(word) = i32::try_from(word) else { continue };
            let mut outside = good.clone();
            outside.coefficients[k] = word;
            let at = 4 * (HEAD_WORDS + k);
            let what =
                format!("a page whose coefficient {} (at byte {at}) is one word {end} its range", range.name);
            all.push((what, outside.bytes()));
        }
    }
    all
}

/// Compiles the programs that read pages and words, in every language; `sanitize` has undefined behaviour watched for.
///
/// # Errors
/// [`VerifyError`] where a compiler is missing or refuses the files.
pub fn compile(
    place: &Place<'_>,
    design: &Design,
    sanitize: bool,
) -> Result<Vec<(&'static str, PathBuf)>, VerifyError> {
    let program = |how: How| {
        let (language, sanitized) = (how.language, sanitize && how.checker.watches());
        let how = How { sanitized, ..how.strictly() };
        let arguments: Vec<Value> = (design.program.arguments.iter())
            .map(|a| {
                let float = a.ty == crate::program::Type::F32;
                context! { name => &*a.name, type => language.type_name(a.ty), float }
            })
            .collect();
        let context = context! {
            name => place.base, arguments, upper => place.base.to_uppercase(), type_name => camel_case(place.base),
            output_type => language.type_name(design.program.output_type()),
        };
        how.checker.library(how, place)?;
        Ok((language.name(), place.program(how, "pages", "pages", context)?))
    };
    How::all(false).into_iter().map(program).collect()
}

/// A page and readings, as words of each argument.
pub type Given<'a> = (&'a [u8], &'a [Vec<u32>]);

/// The loader's status of every page, and the results of its readings.
///
/// # Errors
/// [`VerifyError`] where the program cannot be run, or ends with an error.
pub fn run(program: &Path, pages: &[Given<'_>]) -> Result<Vec<(i32, Vec<u32>)>, VerifyError> {
    let mut input = Vec::new();
    for (page, readings) in pages {
        input.extend((page.len() as u32).to_le_bytes());
        input.extend(*page);
        input.extend((readings.len() as u32).to_le_bytes());
        readings.iter().flatten().for_each(|w| input.extend(w.to_le_bytes()));
    }
    let out = fed(program, input)?;
    if !out.status.success() {
        let message = format!("{}: {}", out.status, String::from_utf8_lossy(&out.stderr).trim());
        return Err(VerifyError::Refused { program: program.display().to_string(), message });
    }
    let mut words = words(&out.stdout);
    let of_page = |(_, readings): &Given<'_>| {
        let status = words.next().map_or(-1, |status| status as i32);
        let count = if status == 0 { readings.len() } else { 0 };
        (status, words.by_ref().take(count).collect())
    };
    Ok(pages.iter().map(of_page).collect())
}
