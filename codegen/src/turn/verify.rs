//! The check from outside: the files against a new generation, and every word through the compiled Rust and C,
//! held against the enclosed function.

use std::path::Path;

use minijinja::context;
use serde::Serialize;

use fitter::coefficients::Coefficients;

use super::TurnError;
use super::choose::{self, TurnRoutine};
use super::fit::Targets;
use super::proof::distance;
use super::truth::Truth;
use crate::certificate::rust_type;
use crate::generate::Generated;
use crate::interpret::{Word, interpret};
use crate::options::Options;
use crate::render::{Renderer, c_type};
use crate::verify::compile::Tool;
use crate::verify::{VerifyError, belonging};

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TurnReport {
    /// What is wrong with certificate and files; empty where nothing is.
    pub certificate: Vec<String>,
    /// The languages that were swept.
    pub sweeps: Vec<TurnSweep>,
}

/// Every word through one language.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TurnSweep {
    /// `rust` or `c`.
    pub language: String,
    /// Words that were given, those with bits above the encoder's among them.
    pub words: u64,
    /// Words of which the result is not the interpreter's.
    pub different: u64,
    /// The largest distance from the exact position, in the certificate's unit.
    pub worst: f64,
    /// The bound that the certificate states.
    pub bound: f64,
}

impl TurnReport {
    /// Whether everything holds.
    pub fn holds(&self) -> bool {
        self.certificate.is_empty() && self.sweeps.iter().all(|s| s.different == 0 && s.worst <= s.bound)
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for wrong in &self.certificate {
            text += &format!("{wrong}\n");
        }
        for s in &self.sweeps {
            text += &format!(
                "{:<5} {} words: {} differ from the program, {:.3e} from the exact position at most, bound {:.3e}\n",
                s.language, s.words, s.different, s.worst, s.bound
            );
        }
        text += if self.holds() { "verified\n" } else { "DOES NOT HOLD\n" };
        text
    }
}

/// A check could not be made.
#[derive(Debug, thiserror::Error)]
pub enum TurnVerifyError {
    /// The routine.
    #[error(transparent)]
    Turn(#[from] TurnError),
    /// Files or compilers.
    #[error(transparent)]
    Verify(#[from] VerifyError),
}

/// Checks the files in `folder`.
///
/// # Errors
/// [`TurnVerifyError`] where a check cannot be made.
pub fn verify(
    folder: &Path,
    generated: &Generated,
    coefficients: &Coefficients,
    options: &Options,
) -> Result<TurnReport, TurnVerifyError> {
    let certificate = belonging::read_certificate(folder)?;
    let mut report = TurnReport {
        certificate: belonging::check(folder, &certificate, &generated.certificate, &generated.files),
        sweeps: Vec::new(),
    };
    let routine = choose::choose(coefficients, options)?;
    let truth = Truth::new(coefficients)?;
    let exact = Targets::new(&truth, routine.words).exact;
    let name = &generated.name;
    let folder = std::path::absolute(folder)
        .map_err(|cause| VerifyError::Write { path: folder.to_path_buf(), cause })?;
    let expected: Vec<u32> = (0..=last(&routine)).map(|word| by_program(&routine, word)).collect();
    for language in ["rust", "c"] {
        let stated = certificate.routines.iter().find(|e| &e.routine == name && e.language == language);
        let Some(stated) = stated else { continue };
        let found = run(&folder, name, &routine, language)?;
        let different = expected.iter().zip(&found).filter(|(a, b)| a != b).count()
            + expected.len().abs_diff(found.len());
        let worst = (found.iter().zip(&exact))
            .map(|(result, exact)| distance(*result, exact, routine.words))
            .fold(0.0, f64::max);
        report.sweeps.push(TurnSweep {
            language: language.into(),
            words: found.len() as u64,
            different: different as u64,
            worst: (worst * routine.unit_per_count).next_up(),
            bound: stated.bound,
        });
    }
    Ok(report)
}

/// The last word that is swept: of 16 bits all there are, otherwise a turn beyond the encoder's.
fn last(routine: &TurnRoutine) -> u32 {
    if routine.words.input() <= 16 { u16::MAX.into() } else { 2 * routine.words.counts - 1 }
}

fn by_program(routine: &TurnRoutine, word: u32) -> u32 {
    interpret(&routine.program, &[Word::Int(word.into())]).map_or(u32::MAX, |out| out.word.bits() as u32)
}

/// The results of the compiled routine for all words.
fn run(folder: &Path, name: &str, routine: &TurnRoutine, language: &str) -> Result<Vec<u32>, VerifyError> {
    let write = |path: &Path, cause| VerifyError::Write { path: path.to_path_buf(), cause };
    let build = tempfile::tempdir().map_err(|cause| write(Path::new("temporary folder"), cause))?;
    let renderer = Renderer::new()?;
    let module = folder.join(format!("src/{name}.rs"));
    let ty = routine.program.steps[0].ty;
    let context = context! {
        name, last => last(routine), input_type => rust_type(ty), c_input_type => c_type(ty),
        module => module.display().to_string(),
    };
    let (template, file) = match language {
        "rust" => ("turn/sweep.rs", "sweep.rs"),
        _ => ("turn/sweep.c", "sweep.c"),
    };
    let path = build.path().join(file);
    std::fs::write(&path, renderer.render(template, context)?).map_err(|cause| write(&path, cause))?;
    let program = build.path().join("sweep").display().to_string();
    if language == "rust" {
        let arguments = ["--edition", "2021", "-O", "-C", "overflow-checks=on", file, "-o", &program];
        Tool::rustc().run(&arguments, build.path())?;
    } else {
        let c = folder.join("c");
        let source = c.join(format!("{name}.c"));
        let include = format!("-I{}", c.display());
        let source = source.display().to_string();
        let arguments =
            ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", &include, file, &source, "-o", &program];
        Tool::cc().run(&arguments, build.path())?;
    }
    let output = Tool::named(&program, "").output(&[], build.path())?;
    let word = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    Ok(output.stdout.chunks_exact(4).map(word).collect())
}
