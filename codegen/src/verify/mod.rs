//! Checks of the generated files from outside: what is proved in exact arithmetic is held against the
//! compiled code, against other provers, and against deliberately damaged copies of itself.
//!
//! [`belonging`] recomputes the certificate; [`sweep`] runs the compiled Rust and C over inputs that
//! [`domain`] numbers, through programs that [`harness`] renders and compiles, against a [`fast_reference`] whose
//! own error is bounded, and compares the outputs by their [`digest`].
//! Routines with terms of further physics are run over sequences of calls instead: [`sequence`].

pub mod belonging;
pub mod compile;
pub mod digest;
pub mod domain;
pub mod eva;
pub mod external;
pub mod fast_reference;
pub mod harness;
pub mod mutants;
pub mod report;
pub mod sequence;
pub mod sweep;

use std::io;
use std::path::{Path, PathBuf};

use fitter::progress::Progress;

use crate::certificate::{Certificate, Entry};
use crate::generate::Generated;
use crate::interpret::Overflow;
use crate::options::Options;
use crate::quantity::Quantity;
use crate::render::RenderError;

use harness::{Language, Subject};
use report::Report;

/// A check could not be made. (A check that fails is no error: it stands in the [`Report`].)
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The certificate cannot be used.
    #[error("{path}: {what}", path = path.display())]
    Certificate {
        /// Its path.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A program is missing.
    #[error("{program} is not installed: {install}")]
    Missing {
        /// Its name.
        program: String,
        /// How to get it.
        install: &'static str,
    },
    /// A program cannot be started.
    #[error("{program} cannot be run: {cause}")]
    Run {
        /// Its name.
        program: String,
        /// What the system says.
        #[source]
        cause: io::Error,
    },
    /// A program ended with an error.
    #[error("{program}: {message}")]
    Refused {
        /// Its name.
        program: String,
        /// Its first lines.
        message: String,
    },
    /// A temporary file cannot be written.
    #[error("{path} cannot be written: {cause}", path = path.display())]
    Write {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        #[source]
        cause: io::Error,
    },
    /// A defect of a template.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A defect of the proof.
    #[error(transparent)]
    Overflow(#[from] Overflow),
    /// A defect of serialisation.
    #[error("the report cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Which checks are made; the certificate and a sweep always are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Checks {
    /// Sweep every representable input instead of a part.
    pub exhaustive: bool,
    /// Watch the C for undefined behaviour during the sweep.
    pub sanitize: bool,
    /// Let Gappa prove the rounding of the operations.
    pub gappa: bool,
    /// Let Frama-C look for undefined behaviour over every input word.
    pub frama_c: bool,
    /// Check the C with cppcheck's MISRA rules and all warnings of gcc and clang.
    pub misra: bool,
    /// Look for panics in the Rust object.
    pub objects: bool,
    /// Damage copies of the files on purpose and see every one caught.
    pub mutants: bool,
}

/// Checks the files in `folder` against what was generated anew.
///
/// # Errors
/// [`VerifyError`] where a check cannot be made.
pub fn verify(
    folder: &Path,
    generated: &Generated,
    quantity: &Quantity,
    options: &Options,
    checks: Checks,
    bar: &dyn Progress,
) -> Result<Report, VerifyError> {
    let certificate = belonging::read_certificate(folder)?;
    let mut report = Report {
        certificate: belonging::check(folder, &certificate, &generated.certificate, &generated.files),
        ..Report::default()
    };
    let folder = absolute(folder)?;
    let build =
        tempfile::tempdir().map_err(|cause| VerifyError::Write { path: "temporary folder".into(), cause })?;
    let base = harness::base_name(&generated.certificate);
    let subjects = Subject::all(generated, options);

    bar.doing("compiling");
    harness::compile_crate(&folder, &base, build.path())?;
    let mut runs = vec![(Language::Rust, false), (Language::C, false)];
    if checks.sanitize {
        runs.push((Language::C, true));
    }
    let coverage = |s: &Subject<'_>| {
        if checks.exhaustive { s.domain.all(s.program()) } else { s.domain.quick(s.program()) }
    };
    let functions = || subjects.iter().filter(|s| !s.has_terms());
    let total: u64 = functions().map(|s| sweep::inputs(&coverage(s))).sum();
    bar.steps(total * runs.len() as u64);
    for subject in subjects.iter().filter(|s| s.has_terms()) {
        bar.doing(&format!("{}: sequences of calls", subject.name));
        let prepared = sequence::prepare(subject, checks.exhaustive)?;
        for &(language, sanitized) in &runs {
            let stated = stated(&certificate, subject, language);
            let Some(stated) = stated else { continue };
            bar.doing(&format!("{} in {}", subject.name, language.name()));
            let built = sequence::runner::build(subject, language, sanitized, &folder, &base, build.path())?;
            let how = (language, sanitized);
            let found = sequence::sweep(subject, how, &built, &prepared, stated.bound, quantity)?;
            report.sweeps.push(found);
        }
    }
    for subject in functions() {
        let coverage = coverage(subject);
        for &(language, sanitized) in &runs {
            let stated = stated(&certificate, subject, language);
            let Some(stated) = stated else { continue };
            bar.doing(&format!("{} in {}", subject.name, language.name()));
            let harness = harness::build(subject, language, sanitized, &folder, &base, build.path())?;
            let found = sweep::sweep(subject, &harness, &coverage, stated.bound, quantity, bar)?;
            report.sweeps.push(found);
        }
    }
    report.compare_digests();
    bar.doing("other tools");
    if checks.gappa {
        report.tools.extend(external::gappa(&subjects, &folder)?);
    }
    if checks.frama_c {
        report.tools.push(eva::frama_c(&subjects, &folder, &base, build.path(), options.c_shift)?);
    }
    if checks.misra {
        report.tools.push(external::misra(&folder, &base)?);
        report.tools.extend(external::warnings(&folder, &base, build.path())?);
    }
    if checks.objects {
        report.tools.extend(external::objects(&subjects, &folder, &base, build.path())?);
    }
    if checks.mutants {
        report.tools.extend(mutants::mutants(&subjects, generated, quantity, &base, bar)?);
    }
    Ok(report)
}

/// What the certificate promises. Without an entry nothing is promised; the certificate's check has said so.
fn stated<'a>(certificate: &'a Certificate, subject: &Subject<'_>, language: Language) -> Option<&'a Entry> {
    certificate.routines.iter().find(|e| e.routine == subject.name && e.language == language.name())
}

fn absolute(folder: &Path) -> Result<PathBuf, VerifyError> {
    std::path::absolute(folder).map_err(|cause| VerifyError::Write { path: folder.into(), cause })
}
