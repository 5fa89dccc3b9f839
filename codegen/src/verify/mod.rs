//! Checks of the generated files from outside: what is proved in exact arithmetic is held against the
//! compiled code, against other provers, and against deliberately damaged copies of itself.
//!
//! `belonging` recomputes the certificate; `sweep` runs the compiled Rust and C over inputs that
//! `domain` numbers, through programs that `harness` renders and compiles, against a [`fast_reference`] whose
//! own error is bounded, and compares the outputs by their `digest`.
//! Routines with terms of further physics are run over sequences of calls instead: [`sequence`].

pub(crate) mod belonging;
pub(crate) mod calls;
pub mod compile;
mod digest;
pub(crate) mod domain;
pub(crate) mod eva;
pub mod external;
pub mod fast_reference;
mod harness;
mod mutants;
mod report;
pub mod sequence;
mod sweep;

use std::io;
use std::path::{Path, PathBuf};

use fitter::input::FileError;
use fitter::output::OutputError;
use fitter::progress::Progress;

use crate::certificate::{Certificate, Entry};
use crate::devices::DevicesError;
use crate::generate::Generated;
use crate::interpret::Overflow;
use crate::options::Options;
use crate::render::RenderError;
use crate::turn::TurnError;

use compile::{How, Place, temporary};
use external::{Check, Checked};
use harness::Subject;
use report::Report;
use sweep::SweepReport;

fitter::errors! {
    /// A check could not be made. (A check that fails is no error: it stands in the `Report`.)
    #[derive(Debug)]
    pub enum VerifyError {
        Certificate { path: PathBuf, what: String } =>
            at(path) says("{what}");
        Unread(cause: FileError) => of(cause) mend("generate the files first, or name their folder") by(out);
        Missing { program: String, install: &'static str } => says("{program} is not installed: {install}");
        Run { program: String, cause: io::Error, } => says("{program} cannot be run: {cause}");
        Refused { program: String, message: String } => says("{program}: {message}");
        /// A compiled routine that did not run to its end.
        Ended { program: String, message: String } => says("{program}: {message}");
        Write { path: PathBuf, cause: io::Error, } =>
            at(path) says("cannot be written: {cause}");
    }
    from {
        Files(OutputError),
        Render(RenderError),
        Overflow(Overflow),
        Turn(TurnError),
        Devices(DevicesError),
        Json(serde_json::Error),
    }
}

/// Which checks are made; the certificate and a sweep always are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "program", derive(clap::Args))]
pub struct Checks {
    /// Sweep every representable input, not only a part of them.
    #[cfg_attr(feature = "program", arg(long))]
    pub exhaustive: bool,
    /// Sweep the C once more with undefined behaviour watched for.
    #[cfg_attr(feature = "program", arg(long))]
    pub sanitize: bool,
    /// Let Gappa prove the rounding of the operations from the scripts beside the code.
    #[cfg_attr(feature = "program", arg(long))]
    pub gappa: bool,
    /// Let Frama-C look for undefined behaviour in the C over every input word.
    #[cfg_attr(feature = "program", arg(long))]
    pub frama_c: bool,
    /// Check the C with cppcheck's MISRA rules and all warnings of gcc and clang.
    #[cfg_attr(feature = "program", arg(long))]
    pub misra: bool,
    /// Look for panics in the Rust object, overflow checks on; and let rustdoc check the documentation.
    #[cfg_attr(feature = "program", arg(long))]
    pub objects: bool,
    /// Damage copies of the files on purpose, and see that every damage is caught.
    #[cfg_attr(feature = "program", arg(long))]
    pub mutants: bool,
}

/// Checks the files in `folder` against what was generated anew.
///
/// # Errors
/// [`VerifyError`] where a check cannot be made.
pub fn verify(
    folder: &Path,
    generated: &Generated,
    options: &Options,
    checks: Checks,
    bar: &dyn Progress,
) -> Result<Report, VerifyError> {
    let certificate = belonging::read_certificate(folder)?;
    let mut report = Report {
        certificate: belonging::check(folder, &certificate, &generated.certificate, &generated.files),
        ..Report::default()
    };
    let (folder, build) = (absolute(folder)?, temporary()?);
    let place = Place { generated: &folder, base: &generated.name, build: build.path() };
    let subjects = Subject::all(generated, options);
    bar.doing("compiling");
    let runs = How::all(checks.sanitize);
    for how in runs.iter().filter(|how| !how.sanitized) {
        how.checker.library(*how, &place)?;
    }
    report.sweeps = sweeps(&subjects, &certificate, &runs, &place, checks.exhaustive, bar)?;
    report.compare_digests();
    bar.doing("other tools");
    if checks.gappa {
        report.tools.extend(external::gappa(&subjects, &folder)?);
    }
    let checked = Checked { subjects: &subjects, place, shift: options.c_shift };
    for (wanted, check) in
        [(checks.frama_c, Check::Analysis), (checks.misra, Check::Rules), (checks.objects, Check::Objects)]
    {
        for how in runs.iter().filter(|how| wanted && !how.sanitized) {
            report.tools.extend(how.checker.check(check, &checked)?);
        }
    }
    if checks.mutants {
        report.tools.extend(mutants::mutants(&subjects, generated, options, bar)?);
    }
    Ok(report)
}

/// Every routine in every language: those with terms of further physics over sequences of calls, the others over inputs.
fn sweeps(
    subjects: &[Subject<'_>],
    certificate: &Certificate,
    runs: &[How],
    place: &Place<'_>,
    exhaustive: bool,
    bar: &dyn Progress,
) -> Result<Vec<SweepReport>, VerifyError> {
    let coverage = |s: &Subject<'_>| {
        if exhaustive { s.domain.all(s.program()) } else { s.domain.quick(s.program()) }
    };
    let (with_terms, functions): (Vec<_>, Vec<_>) = subjects.iter().partition(|s| s.has_terms());
    let total: u64 = functions.iter().map(|s| sweep::inputs(&coverage(s))).sum();
    bar.steps(total * runs.len() as u64);
    let mut found = Vec::new();
    for subject in with_terms {
        bar.doing(&format!("{}: sequences of calls", subject.name));
        let prepared = sequence::prepare(subject, exhaustive)?;
        for how in runs {
            let Some(stated) = stated(certificate, &subject.name, *how) else { continue };
            bar.doing(&format!("{} in {}", subject.name, how.language.name()));
            found.push(sequence::sweep(subject, *how, place, &prepared, stated.bound)?);
        }
    }
    for subject in functions {
        let coverage = coverage(subject);
        for how in runs {
            let Some(stated) = stated(certificate, &subject.name, *how) else { continue };
            bar.doing(&format!("{} in {}", subject.name, how.language.name()));
            let harness = harness::build(subject, *how, place)?;
            found.push(sweep::sweep(subject, &harness, &coverage, stated.bound, bar)?);
        }
    }
    Ok(found)
}

/// What the certificate promises. Without an entry nothing is promised; the certificate's check has said so.
pub(crate) fn stated<'a>(certificate: &'a Certificate, routine: &str, how: How) -> Option<&'a Entry> {
    certificate.routines.iter().find(|e| e.routine == routine && e.language == how.language.name())
}

pub(crate) fn absolute(folder: &Path) -> Result<PathBuf, VerifyError> {
    std::path::absolute(folder).map_err(|cause| VerifyError::Write { path: folder.into(), cause })
}
