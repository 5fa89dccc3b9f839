//! The check from outside: the files against a new generation, and every word through every compiled language,
//! held against the enclosed function.

use std::path::Path;

use fitter::coefficients::Coefficients;
use serde::Serialize;

use super::choose;
use super::fit::Targets;
use super::proof::distance;
use super::truth::Truth;
use crate::generate::Generated;
use crate::interpret::{Word, interpret};
use crate::options::Options;
use crate::verify::calls::{self, Calls};
use crate::verify::compile::{How, Place, temporary};
use crate::verify::{VerifyError, absolute, belonging, stated};

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
    /// The language.
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

/// Checks the files in `folder`.
///
/// # Errors
/// [`VerifyError`] where a check cannot be made.
pub fn verify(
    folder: &Path,
    generated: &Generated,
    coefficients: &Coefficients,
    options: &Options,
) -> Result<TurnReport, VerifyError> {
    let certificate = belonging::read_certificate(folder)?;
    let mut report = TurnReport {
        certificate: belonging::check(folder, &certificate, &generated.certificate, &generated.files),
        sweeps: Vec::new(),
    };
    let routine = choose::choose(coefficients, options)?;
    let truth = Truth::new(coefficients)?;
    let exact = Targets::new(&truth, routine.words).exact;
    let (folder, build) = (absolute(folder)?, temporary()?);
    let place = Place { generated: &folder, base: &generated.name, build: build.path() };
    // Of 16 bits all there are, otherwise a turn beyond the encoder's.
    let last = if routine.words.input() <= 16 { u16::MAX.into() } else { 2 * routine.words.counts - 1 };
    let calls =
        Calls { words: (0..=last).flat_map(|word| [1, word]).collect(), stride: 2, ..Calls::default() };
    let by_program = |word: u32| {
        interpret(&routine.program, &[Word::Int(word.into())]).map_or(u32::MAX, |out| out.word.bits() as u32)
    };
    let expected: Vec<u32> = (0..=last).map(by_program).collect();
    for how in How::all(false).into_iter().map(How::strictly) {
        let Some(stated) = stated(&certificate, &generated.name, how) else { continue };
        how.checker.library(how, &place)?;
        let program = calls::build((&generated.name, &routine.program, false), how, &place)?;
        let found: Vec<u32> = calls::run(&program, &calls)?.iter().map(|given| given.bits).collect();
        let different = expected.iter().zip(&found).filter(|(a, b)| a != b).count();
        let worst = (found.iter().zip(&exact))
            .map(|(result, exact)| distance(*result, exact, routine.words))
            .fold(0.0, f64::max);
        report.sweeps.push(TurnSweep {
            language: how.language.name().into(),
            words: found.len() as u64,
            different: different as u64,
            worst: (worst * routine.unit_per_count).next_up(),
            bound: stated.bound,
        });
    }
    Ok(report)
}
