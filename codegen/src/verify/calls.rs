//! Programs that run a compiled routine on words from standard input: calls in, results out.

use std::path::PathBuf;

use minijinja::context;

use super::VerifyError;
use super::compile::{How, Place, fed, words};
use crate::program::{Program, Type};
use crate::text::camel_case;

/// Calls, flat: for each 1 where a sequence begins or 0, then the argument words.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Calls {
    /// See the type.
    pub words: Vec<u32>,
    /// Words of a call.
    pub stride: usize,
    /// What is covered, in words.
    pub what: String,
}

impl Calls {
    /// How many.
    pub fn count(&self) -> usize {
        self.words.len() / self.stride
    }

    /// Whether a sequence begins with a call, and its argument words.
    pub fn call(&self, index: usize) -> (bool, &[u32]) {
        let words = &self.words[index * self.stride..(index + 1) * self.stride];
        (words[0] == 1, &words[1..])
    }
}

/// The result of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Given {
    /// The bits of the result.
    pub bits: u32,
    /// Whether the reading was said to lie inside; always, where the routine does not flag.
    pub inside: bool,
}

/// Makes the program of a routine, with a library made by [`Checker::library`](crate::language::Checker::library).
pub fn build(
    (name, program, flag): (&str, &Program, bool),
    how: How,
    place: &Place<'_>,
) -> Result<PathBuf, VerifyError> {
    let language = how.language;
    let argument = |(i, a): (usize, &crate::program::Argument)| {
        context! { index => i + 1, type => language.type_name(a.ty), float => a.ty == Type::F32 }
    };
    let context = context! {
        routine => name,
        type_name => camel_case(name),
        crate_name => place.base,
        state => !program.state.is_empty(),
        arguments => program.arguments.iter().enumerate().map(argument).collect::<Vec<_>>(),
        output_type => language.type_name(program.output_type()),
        wide => matches!(program.output_type(), Type::I32 | Type::U32 | Type::F32),
        flag,
    };
    place.program(how, &format!("calls_{name}"), "calls", context)
}

/// Runs all calls.
///
/// # Errors
/// [`VerifyError::Ended`] where the program ends early, which under the sanitizer means undefined behaviour.
pub fn run(program: &std::path::Path, calls: &Calls) -> Result<Vec<Given>, VerifyError> {
    let output = fed(program, calls.words.iter().flat_map(|w| w.to_le_bytes()).collect())?;
    let all: Vec<u32> = words(&output.stdout).collect();
    let given: Vec<Given> =
        all.chunks_exact(2).map(|pair| Given { bits: pair[0], inside: pair[1] != 0 }).collect();
    if output.status.success() && given.len() == calls.count() {
        return Ok(given);
    }
    let message = String::from_utf8_lossy(&output.stderr).lines().take(6).collect::<Vec<_>>().join("\n");
    let message = format!("{} after {} calls\n{message}", output.status, given.len());
    Err(VerifyError::Ended { program: program.display().to_string(), message })
}
