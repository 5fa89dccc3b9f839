//! Deliberately damaged copies of the generated files: every one must be caught, or the checks are worth
//! nothing.
//!
//! A coefficient that is off by one in its last bits may well stay within the bound. What must catch it then
//! is the comparison of the outputs with the program that was proved: so damaged sources get a certificate
//! whose hashes fit them, and only what the code computes can give them away. A stated bound that is too small
//! is caught where the certificate is recomputed, and by Gappa where its script claims too little.

mod changes;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fitter::progress::Progress;

use changes::{Mutation, mutations};

use super::VerifyError;
use super::belonging;
use super::compile::{Place, temporary, write};
use super::external::{ToolReport, run_gappa};
use super::harness::{self, Subject};
use super::sequence::{self, Prepared};
use super::sweep;
use crate::certificate::Certificate;
use crate::files;
use crate::generate::{Generated, sha256};
use crate::options::Options;
use crate::text;

/// The part by which a bound is made too small.
const TOO_SMALL: f64 = 0.98;
/// A goal that is too tight makes Gappa split without end: so long it is left to try.
const GAPPA_SECONDS: u64 = 10;

/// Damages the generated files in every way that fits each routine and says what caught it.
pub fn mutants(
    subjects: &[Subject<'_>],
    generated: &Generated,
    options: &Options,
    bar: &dyn Progress,
) -> Result<Vec<ToolReport>, VerifyError> {
    let mut reports = vec![hand_edited(generated)?];
    for subject in subjects {
        let prepared = subject.has_terms().then(|| sequence::prepare(subject, false)).transpose()?;
        for mutation in mutations(subject, generated, options) {
            bar.doing(&format!("{}: {}", subject.name, mutation.what));
            reports.push(damaged_source(subject, generated, &mutation, prepared.as_ref())?);
        }
        reports.push(bound_too_small(subject, generated)?);
        let script = PathBuf::from(format!("gappa/{}.g", subject.name));
        if let Some(text) = generated.files.get(&script) {
            reports.push(goal_too_small(subject, text)?);
        }
    }
    Ok(reports)
}

fn report<'a>(subject: &str, what: &str, caught: impl IntoIterator<Item = &'a str>) -> ToolReport {
    let caught: Vec<&str> = caught.into_iter().collect();
    let finding = if caught.is_empty() {
        format!("{what}: NOT caught")
    } else {
        format!("{what}: caught, {}", caught.join(", and "))
    };
    ToolReport::new("mutant", subject, !caught.is_empty(), finding)
}

/// A source that computes something else, with a certificate whose hashes fit it.
fn damaged_source(
    subject: &Subject<'_>,
    generated: &Generated,
    mutation: &Mutation,
    prepared: Option<&Prepared>,
) -> Result<ToolReport, VerifyError> {
    let how = mutation.how;
    let file = PathBuf::from(how.language.file_of(&generated.name, &subject.name));
    let mut files = generated.files.clone();
    let original = files.get(&file).cloned().unwrap_or_default();
    let edited = mutation.apply(&original);
    if edited == original {
        let finding =
            format!("{}: could not be made, {:?} is not in {}", mutation.what, mutation.from, file.display());
        return Ok(ToolReport::new("mutant", &subject.name, false, finding));
    }
    files.insert(file, edited);
    let folder = folder_of(&files)?;
    let build = temporary()?;
    let place = Place { generated: folder.path(), base: &generated.name, build: build.path() };
    how.checker.library(how, &place)?;
    let bound = subject.quantity.in_bound_unit(subject.routine.design.bound.total);
    let found = if let Some(prepared) = prepared {
        match sequence::sweep(subject, how, &place, prepared, bound) {
            Err(VerifyError::Ended { .. }) => {
                return Ok(report(&subject.name, &mutation.what, Some("it does not run to its end")));
            }
            found => found?,
        }
    } else {
        let built = harness::build(subject, how, &place)?;
        let coverage = subject.domain.interpreted(subject.program());
        sweep::sweep(subject, &built, &coverage, bound, &())?
    };
    let mut caught = Vec::new();
    if !found.as_interpreted {
        caught.push("its outputs are not those of the proved program");
    }
    if found.worst_error > bound {
        caught.push("its error exceeds the bound");
    } else if !found.as_interpreted {
        caught.push("though within the bound on the inputs tried");
    }
    Ok(report(&subject.name, &mutation.what, if found.violations.is_empty() { Vec::new() } else { caught }))
}

/// A file that somebody changed, if only a comment.
fn hand_edited(generated: &Generated) -> Result<ToolReport, VerifyError> {
    let mut files = generated.files.clone();
    let Some(file) = generated.certificate.routines.first().map(|e| PathBuf::from(&e.file)) else {
        return Ok(report("files", "no file to edit", None));
    };
    files.entry(file.clone()).and_modify(|text| text.push('\n'));
    let folder = folder_of(&files)?;
    let wrong = belonging::edited_files(folder.path(), &generated.certificate);
    let named = wrong.iter().any(|w| w.starts_with(&file.display().to_string()));
    let caught = named.then_some("its hash is not the certificate's");
    Ok(report(&file.display().to_string(), "a line added by hand", caught))
}

/// A certificate that promises 2 % more than is proved.
fn bound_too_small(subject: &Subject<'_>, generated: &Generated) -> Result<ToolReport, VerifyError> {
    let mut certificate: Certificate = generated.certificate.clone();
    for entry in certificate.routines.iter_mut().filter(|e| e.routine == subject.name) {
        entry.bound *= TOO_SMALL;
    }
    let folder = folder_of(&generated.files)?;
    let wrong = belonging::check(folder.path(), &certificate, &generated.certificate, &generated.files);
    let refused = wrong.iter().any(|w| w.contains(&subject.name) && w.contains("the bound is stated as"));
    let caught = refused.then_some("the bound computed anew is larger");
    Ok(report(&subject.name, "a bound 2 % too small", caught))
}

/// A Gappa script that claims 2 % less than the largest rounding on any piece.
fn goal_too_small(subject: &Subject<'_>, script: &str) -> Result<ToolReport, VerifyError> {
    let rounding = subject.routine.design.bound.rounding;
    let what = "a Gappa goal 2 % below the certificate's";
    let Some(line) = script.lines().find(|l| l.contains("<= ")) else {
        return Ok(report(&subject.name, what, None));
    };
    let head = line.split("<= ").next().unwrap_or_default();
    let tight = format!("{head}<= {} }}", text::float_hex(rounding * TOO_SMALL));
    let folder = temporary()?;
    let path = folder.path().join("tight.g");
    write(&path, &script.replace(line, &tight))?;
    let caught = match run_gappa(&path, GAPPA_SECONDS)? {
        Some(Ok(())) => None,
        Some(Err(_)) => Some("Gappa refuses it"),
        None => Some("Gappa does not prove it in ten seconds"),
    };
    Ok(report(&subject.name, what, caught))
}

/// The files in a temporary folder, with a certificate whose hashes are theirs.
fn folder_of(files: &BTreeMap<PathBuf, String>) -> Result<tempfile::TempDir, VerifyError> {
    let folder = temporary()?;
    files::write(folder.path(), files)?;
    let path = folder.path().join("certificate.json");
    if let Some(text) = files.get(Path::new("certificate.json")) {
        let mut certificate: Certificate = serde_json::from_str(text)?;
        for entry in &mut certificate.routines {
            entry.file_sha256 = files.get(Path::new(&entry.file)).map(sha256).unwrap_or_default();
        }
        write(&path, &serde_json::to_string_pretty(&certificate)?)?;
    }
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_coefficients;
    use crate::generate::generate;
    use crate::options::{Method, RoutineOptions};
    use crate::verify::{Checks, verify};
    use crate::{format::Format, output::Output};

    fn generated(options: &Options) -> Generated {
        generate(&paper_coefficients(), "0", options).unwrap()
    }

    /// What is generated passes; every damage to it is caught. Needs a C compiler.
    #[test]
    fn only_the_damaged_are_caught() {
        let table = Method::Piecewise { degree: 2, segments_log2: 5, padded: false, place: None };
        let q31 = RoutineOptions::of(Format::Q31);
        let options = Options {
            routines: vec![
                RoutineOptions { output: Output::Nano, ..q31.clone() },
                RoutineOptions { method: table, ..q31 },
                RoutineOptions::of(Format::Q31Split),
                RoutineOptions::of(Format::F32),
                RoutineOptions::of(Format::F32Fma),
            ],
            ..Options::default()
        };
        let anew = generated(&options);
        let folder = folder_of(&anew.files).unwrap();
        let hidden = ();
        let checks = Checks::default();
        let report = verify(folder.path(), &anew, &options, checks, &hidden).unwrap();
        assert!(report.holds(), "{}", report.text());
        assert_eq!(report.sweeps.len(), 10);
        for sweep in &report.sweeps {
            assert!(sweep.inputs >= 10_000_000 && sweep.margin < 1.5, "{sweep:?}");
        }

        let subjects = Subject::all(&anew, &options);
        for subject in &subjects {
            for mutation in mutations(subject, &anew, &options) {
                let found = damaged_source(subject, &anew, &mutation, None).unwrap();
                assert!(found.holds, "{found:?}");
            }
            assert!(bound_too_small(subject, &anew).unwrap().holds);
        }
        assert!(hand_edited(&anew).unwrap().holds);
    }

    /// Files that were generated from other coefficients are refused, and the file is named.
    #[test]
    fn a_certificate_of_another_device_is_refused() {
        let options = Options { routines: vec![RoutineOptions::of(Format::Q31)], ..Options::default() };
        let anew = generated(&options);
        let mut other = paper_coefficients();
        other.base.coefficients[3] += 1e-6;
        let other = generate(&other, "1", &options).unwrap();
        let folder = folder_of(&other.files).unwrap();
        let wrong = belonging::check(folder.path(), &other.certificate, &anew.certificate, &anew.files);
        assert!(wrong.iter().any(|w| w.contains("coefficients_sha256 is 1")), "{wrong:?}");
        assert!(wrong.iter().any(|w| w.contains("src/corrected_angle_q31.rs")), "{wrong:?}");
        // The same device passes.
        let folder = folder_of(&anew.files).unwrap();
        assert_eq!(
            belonging::check(folder.path(), &anew.certificate, &anew.certificate, &anew.files),
            Vec::<String>::new()
        );
    }
}
