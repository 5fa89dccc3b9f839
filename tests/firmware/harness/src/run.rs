//! Starts programs and keeps what they print for the message where they refuse.

use std::process::{Command, Output};

use crate::problem::Problem;

/// Lines of a refusal that are shown.
const SHOWN: usize = 15;

/// Runs `command` and gives its standard output; `what` was being done.
///
/// # Errors
/// [`Problem::Refused`] where it cannot be started or its exit code is not 0.
pub fn run(what: &str, command: &mut Command) -> Result<String, Problem> {
    let program = command.get_program().to_string_lossy().into_owned();
    let refused = |outcome: String, output: String| Problem::Refused {
        what: what.into(),
        program: program.clone(),
        outcome,
        output,
    };
    let output = command.output().map_err(|cause| refused(cause.to_string(), String::new()))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(refused(output.status.to_string(), last_lines(&output)))
}

fn last_lines(output: &Output) -> String {
    let text = [&output.stdout[..], &output.stderr[..]].concat();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
    lines[lines.len().saturating_sub(SHOWN)..].join("\n")
}
