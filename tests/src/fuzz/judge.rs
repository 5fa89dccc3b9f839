//! What a run of the program must not have done, whatever it was given.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::case::Case;
use super::process::Outcome;
use super::written::{self, Kind};

/// What stands in the folder of a case.
type Files = BTreeMap<PathBuf, Kind>;

/// Beginnings of the names of temporary files and folders.
const TEMPORARY: [&str; 3] = [".writing-", ".codegen-", ".arcsmith-"];

/// Everything that was wrong with a run, a sentence each.
pub fn wrong(case: &Case, folder: &Path, outcome: &Outcome, before: &Files, after: &Files) -> Vec<String> {
    let mut wrong = Vec::new();
    let stderr = String::from_utf8_lossy(&outcome.stderr);
    if let Some(panic) = stderr.lines().find(|line| line.contains("panicked at")) {
        wrong.push(panic.to_string());
    }
    wrong.extend(ended(case, outcome));
    for (name, printed) in [("standard output", &outcome.stdout), ("standard error", &outcome.stderr)] {
        match std::str::from_utf8(printed) {
            Err(_) => wrong.push(format!("{name} is no UTF-8")),
            Ok(text) => wrong.extend(
                text.chars()
                    .find(written::unsafe_to_show)
                    .map(|c| format!("{name} holds the character {c:?}")),
            ),
        }
    }
    wrong.extend(before.iter().filter(|(path, kind)| is_input(case, path, kind)).filter_map(
        |(path, kind)| {
            (after.get(path) != Some(kind)).then(|| format!("the input {} was changed", path.display()))
        },
    ));
    let names = after.keys().filter_map(|path| path.file_name()).map(|name| name.to_string_lossy());
    wrong.extend(
        names
            .filter(|name| TEMPORARY.iter().any(|start| name.starts_with(start)))
            .map(|n| format!("{n} is left over")),
    );
    let new = after.iter().filter(|(path, kind)| before.get(*path) != Some(*kind));
    match outcome.code {
        Some(0) => {
            wrong.extend(new.filter_map(|(path, kind)| match kind {
                Kind::File(bytes) => {
                    written::wrong(path, bytes).map(|what| format!("{} {what}", path.display()))
                }
                _ => None,
            }));
            wrong.extend(printed_json(case, outcome));
            wrong.extend(
                after.keys().filter(|path| path.extension().is_some_and(|kind| kind == "c")).filter_map(
                    |path| (after.get(path) != before.get(path)).then(|| compiled(&folder.join(path)))?.err(),
                ),
            );
        }
        Some(2) => {
            wrong.extend(
                new.map(|(path, _)| format!("{} was written, and the command refused", path.display())),
            );
            let errors = stderr
                .lines()
                .filter(|line| line.trim_start().starts_with("× ") || line.starts_with("error: "));
            let errors = errors.count();
            // Without a command the help is printed, which is clap's way.
            let helped = errors == 0 && stderr.contains("Usage:");
            wrong.extend((errors != 1 && !helped).then(|| format!("{errors} messages, expected one")));
        }
        _ => {}
    }
    wrong
}

/// What must stay as it is, also where an option names it as the output: files that the undamaged command reads,
/// and devices. What the command itself would have written may be written.
fn is_input(case: &Case, path: &Path, kind: &Kind) -> bool {
    let is_output = case.output.as_ref().is_some_and(|output| path.starts_with(output));
    !is_output && *kind != Kind::Folder
}

/// How the process ended: 0, 2 for bad input, and 1 where a check does not hold.
fn ended(case: &Case, outcome: &Outcome) -> Option<String> {
    let checks = case.arguments.iter().any(|word| word == "check" || word == "--check");
    match (outcome.code, outcome.signal) {
        (Some(0), _) if case.full && !outcome.stdout.is_empty() => Some("printed nothing, and said 0".into()),
        (Some(0 | 2), _) => None,
        (Some(1), _) if checks => None,
        (_, Some(libc::SIGXCPU | libc::SIGKILL)) => Some("took longer than its seconds".into()),
        (_, Some(libc::SIGALRM)) => Some("was stuck".into()),
        (_, Some(libc::SIGXFSZ)) => Some("wrote a file beyond all measure".into()),
        (Some(code), _) => Some(format!("exit code {code}")),
        (None, signal) => Some(format!("signal {}", signal.unwrap_or_default())),
    }
}

/// With `--json`, what was printed.
fn printed_json(case: &Case, outcome: &Outcome) -> Option<String> {
    let wanted = case.arguments.iter().any(|word| word == "--json") && !case.full;
    let text = String::from_utf8_lossy(&outcome.stdout);
    let json = wanted && text.starts_with(['{', '[']);
    json.then(|| written::json(&text).err())?.map(|what| format!("what --json printed {what}"))
}

/// Whether C compiles without a warning.
fn compiled(path: &Path) -> Result<(), String> {
    let mut compiler = Command::new("cc");
    compiler
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"])
        .arg(path)
        .stdin(Stdio::null());
    let said = compiler.output().map_err(|error| format!("cc: {error}"))?;
    let text = String::from_utf8_lossy(&said.stderr).into_owned();
    let first = text.lines().find(|line| line.contains("error")).unwrap_or("cc refuses it").to_string();
    if said.status.success() { Ok(()) } else { Err(first) }
}
