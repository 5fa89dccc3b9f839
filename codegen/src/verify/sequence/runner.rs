//! Programs that run a compiled routine with terms over sequences of calls: words in, results out.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use minijinja::context;

use super::strata::Calls;
use crate::certificate::rust_type;
use crate::program::Type;
use crate::render::{Renderer, c_type};
use crate::verify::VerifyError;
use crate::verify::external::write;
use crate::verify::harness::{Language, Subject, executable_of};

/// A compiled program of one routine.
#[derive(Debug)]
pub struct Runner {
    executable: PathBuf,
}

/// The result of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Given {
    /// The bits of the result.
    pub bits: u32,
    /// Whether the reading was said to lie inside; always, where the routine does not flag.
    pub inside: bool,
}

/// Builds it in `build`, around the files in `generated`.
///
/// # Errors
/// [`VerifyError`] where there is no compiler, or it refuses the generated files.
pub fn build(
    subject: &Subject<'_>,
    language: Language,
    sanitize: bool,
    generated: &Path,
    base: &str,
    build: &Path,
) -> Result<Runner, VerifyError> {
    let program = subject.program();
    let argument = |(i, a): (usize, &crate::program::Argument)| {
        let float = a.ty == Type::F32;
        context! { index => i + 1, type => rust_type(a.ty), c_type => c_type(a.ty), float }
    };
    let context = context! {
        routine => &*subject.name,
        type_name => crate::text::camel_case(&subject.name),
        crate_name => base,
        source => format!("{base}.c"),
        state => !program.state.is_empty(),
        flag => subject.flag,
        arguments => program.arguments.iter().enumerate().map(argument).collect::<Vec<_>>(),
        output_type => rust_type(program.output_type()),
        c_output_type => c_type(program.output_type()),
    };
    let template = if language == Language::Rust { "verify/sequence.rs" } else { "verify/sequence.c" };
    let text = Renderer::new()?.render(template, context)?;
    let stem = format!("calls_{}_{}{}", subject.name, language.name(), if sanitize { "_ub" } else { "" });
    let source = build.join(format!("{stem}.{}", if language == Language::Rust { "rs" } else { "c" }));
    write(&source, &text)?;
    let executable = build.join(&stem);
    executable_of(language, sanitize, generated, base, build, &source, &executable)?;
    Ok(Runner { executable })
}

impl Runner {
    /// Runs all calls.
    ///
    /// # Errors
    /// [`VerifyError`] where the program ends early, which under the sanitizer means undefined behaviour.
    pub fn run(&self, calls: &Calls) -> Result<Vec<Given>, VerifyError> {
        let program = self.executable.display().to_string();
        let failed = |cause| VerifyError::Run { program: program.clone(), cause };
        let mut child = Command::new(&self.executable)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let mut pipe = child.stdin.take();
        let bytes: Vec<u8> = calls.words.iter().flat_map(|w| w.to_le_bytes()).collect();
        // A program that ends early closes the pipe; its exit code says so.
        let feeder = std::thread::spawn(move || pipe.take().map(|mut pipe| pipe.write_all(&bytes)));
        let output = child.wait_with_output().map_err(failed)?;
        let _ = feeder.join();
        let given: Vec<Given> = (output.stdout.chunks_exact(8))
            .map(|b| Given { bits: u32::from_le_bytes([b[0], b[1], b[2], b[3]]), inside: b[4..8] != [0; 4] })
            .collect();
        if output.status.success() && given.len() == calls.count() {
            return Ok(given);
        }
        let message = String::from_utf8_lossy(&output.stderr).lines().take(6).collect::<Vec<_>>().join("\n");
        let message = format!("{} after {} calls\n{message}", output.status, given.len());
        Err(VerifyError::Refused { program, message })
    }
}
