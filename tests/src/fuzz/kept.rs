//! Failures that were found: a small committed script each, and the folder of one that was found just now.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::case::Case;
use super::process::{Limits, Outcome};
use super::seeds::Seeds;

/// The committed cases. A line `# …` says what went wrong, lines `$ …` prepare files for `bash`, and the next line
/// is the command; words that name seeds stand for their files.
const CASES: &str = include_str!("../../fuzz/cases.txt");

/// A committed case.
#[derive(Debug)]
pub struct Kept {
    /// What went wrong.
    pub what: &'static str,
    prepare: Vec<&'static str>,
    command: &'static str,
}

/// All of them.
pub fn cases() -> Vec<Kept> {
    let (mut cases, mut what, mut prepare) = (Vec::new(), "", Vec::new());
    for line in CASES.lines().filter(|line| !line.is_empty()) {
        match (line.strip_prefix("# "), line.strip_prefix("$ ")) {
            (Some(text), _) => what = text,
            (_, Some(step)) => prepare.push(step),
            _ => cases.push(Kept { what, prepare: std::mem::take(&mut prepare), command: line }),
        }
    }
    cases
}

impl Kept {
    /// Runs it in an empty folder.
    ///
    /// # Errors
    /// Where it cannot be prepared, run or watched.
    pub fn run(
        &self,
        seeds: &Seeds,
        program: &Path,
        folder: &Path,
    ) -> Result<(Outcome, Vec<String>), String> {
        let words = bash(folder, &format!("printf '%s\\0' {}", self.command))?;
        let words = words.split(|byte| *byte == 0).map(|word| OsString::from_vec(word.to_vec()));
        let mut arguments: Vec<OsString> = words.collect();
        // After the last zero stands nothing.
        arguments.pop();
        let full = arguments.last().is_some_and(|word| word == ">/dev/full");
        arguments.truncate(arguments.len() - usize::from(full));
        let case = Case { full, ..Case::plain(seeds, arguments) };
        case.lay_out(folder)?;
        for step in &self.prepare {
            bash(folder, step)?;
        }
        case.run(program, folder)
    }
}

fn bash(folder: &Path, script: &str) -> Result<Vec<u8>, String> {
    let mut command = Command::new("bash");
    command.current_dir(folder).args(["-euc", script]).stdin(Stdio::null());
    let output = command.output().map_err(|error| format!("bash: {error}"))?;
    match output.status.success() {
        true => Ok(output.stdout),
        false => Err(format!("{script}: {}", String::from_utf8_lossy(&output.stderr))),
    }
}

/// Keeps the inputs of a failure in `folder`, with a file `command` of one line for `bash`.
///
/// # Errors
/// Where they cannot be written.
pub fn keep(case: &Case, program: &Path, folder: &Path) -> Result<(), String> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    case.lay_out(folder)?;
    let (program, full) = (PathBuf::from(program), if case.full { " >/dev/full" } else { "" });
    let line = format!(
        "(ulimit -v {} -t {}; {} {}) </dev/null{full}\n",
        Limits::CASE.memory / 1024,
        Limits::CASE.seconds,
        quoted(&[program.into()]),
        quoted(&case.arguments)
    );
    std::fs::write(folder.join("command"), line).map_err(|error| format!("{}: {error}", folder.display()))
}

/// Words as `bash` reads them.
pub fn quoted(words: &[OsString]) -> String {
    words.iter().map(|word| quote(word)).collect::<Vec<_>>().join(" ")
}

fn quote(word: &OsStr) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_./=:,+%@".contains(byte);
    if !word.is_empty() && word.as_bytes().iter().all(plain) {
        return word.to_string_lossy().into_owned();
    }
    let bytes = word.as_bytes().iter().map(|byte| match byte {
        b'\'' | b'\\' => format!("\\{}", char::from(*byte)),
        b' '..=b'~' => char::from(*byte).to_string(),
        _ => format!("\\x{byte:02x}"),
    });
    format!("$'{}'", bytes.collect::<String>())
}
