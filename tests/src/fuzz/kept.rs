//! Failures that were found: a small committed script each, and the folder of one that was found just now.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::Path;
use std::process::{Command, Stdio};

use super::case::Case;
use super::process::Limits;
use super::seeds::Seeds;

/// The committed cases. A line `# …` says what went wrong, lines `$ …` prepare files for `bash`, and the next line
/// is the command; words that name seeds stand for their files.
const CASES: &str = include_str!("../../fuzz/cases.txt");

/// All of them, with what went wrong.
///
/// # Errors
/// Where `bash` cannot read a command.
pub fn cases(seeds: &Seeds) -> Result<Vec<(&'static str, Case)>, String> {
    let (mut cases, mut what, mut prepare) = (Vec::new(), "", Vec::new());
    for line in CASES.lines().filter(|line| !line.is_empty()) {
        match (line.strip_prefix("# "), line.strip_prefix("$ ")) {
            (Some(text), _) => what = text,
            (_, Some(step)) => prepare.push(step),
            _ => {
                let (line, full) =
                    line.strip_suffix(" >/dev/full").map_or((line, false), |line| (line, true));
                let words = bash(Path::new("."), &format!("printf '%s\\0' {line}"))?;
                let words = words.strip_suffix(b"\0").unwrap_or(&words).split(|byte| *byte == 0);
                let words = words.map(|word| OsString::from_vec(word.to_vec())).collect();
                let prepare = std::mem::take(&mut prepare);
                cases.push((what, Case { full, prepare, ..Case::plain(seeds, words) }));
            }
        }
    }
    Ok(cases)
}

/// Runs a script in a folder, and gives what it prints.
///
/// # Errors
/// Its messages where it fails.
pub fn bash(folder: &Path, script: &str) -> Result<Vec<u8>, String> {
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
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(failed)?;
    }
    std::fs::create_dir_all(folder).map_err(failed)?;
    case.lay_out(folder)?;
    let (memory, seconds) = (Limits::CASE.memory / 1024, Limits::CASE.seconds);
    let (program, arguments) = (quoted(&[program.into()]), quoted(&case.arguments));
    let full = if case.full { " >/dev/full" } else { "" };
    let line = format!("(ulimit -v {memory} -t {seconds}; {program} {arguments}) </dev/null{full}\n");
    std::fs::write(folder.join("command"), line).map_err(failed)
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
