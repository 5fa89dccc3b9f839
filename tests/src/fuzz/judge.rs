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
    let mut wrong = Vec::from_iter(ended(case, outcome));
    let stderr = String::from_utf8_lossy(&outcome.stderr);
    let runs = case.arguments.first().is_some_and(|word| word == "run");
    wrong.extend(stderr.lines().filter(|line| line.contains("panicked at")).map(str::to_string));
    for (name, printed) in [("standard output", &outcome.stdout), ("standard error", &outcome.stderr)] {
        let what = written::unsafe_to_show(printed);
        wrong.extend(what.map(|what| format!("{name} {what}")));
    }
    for (path, kind) in before.iter().filter(|(path, kind)| is_input(case, path, kind)) {
        if after.get(path) != Some(kind) {
            wrong.push(format!("the input {} was changed", path.display()));
        }
    }
    for (path, kind) in after.iter().filter(|(path, kind)| before.get(*path) != Some(*kind)) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let what = match (outcome.code, kind) {
            _ if TEMPORARY.iter().any(|start| name.starts_with(start)) => Some("is left over".into()),
            // Its files are whole; what could not be said is the summary.
            (Some(2), _) if case.full => None,
            // What a step of a project has done stays where a later one is refused.
            (Some(2), _) if !runs => Some("was written, and the command refused".into()),
            (Some(0 | 2), Kind::File(bytes)) => {
                written::wrong(path, bytes).or_else(|| compiled(&folder.join(path)))
            }
            _ => None,
        };
        wrong.extend(what.map(|what| format!("{} {what}", path.display())));
    }
    let start = |line: &&str| line.starts_with("error: ") || line.starts_with("  \"error\": {");
    match (outcome.code, stderr.lines().filter(start).count()) {
        (Some(0), _) => wrong.extend(json(case, outcome).or_else(|| infinite(case, outcome))),
        // Without a command the help is printed, which is clap's way.
        (Some(2), 1) => {}
        (Some(2), 0) if stderr.contains("Usage:") => {}
        (Some(2), messages) => wrong.push(format!("{messages} messages, expected one")),
        _ => {}
    }
    wrong
}

/// What must stay as it is, also where an option names it as the output: files that the command reads, and devices. What
/// the undamaged command would have written may be written, and what is named as the output alone.
fn is_input(case: &Case, path: &Path, kind: &Kind) -> bool {
    let named = || case.arguments.iter().filter(|word| Path::new(word) == path).count();
    let is_output =
        || case.arguments.windows(2).any(|pair| pair[0] == "--out" && Path::new(&pair[1]) == path);
    let written = || matches!(kind, Kind::File(_)) && is_output() && named() == 1;
    *kind != Kind::Folder
        && !case.output.as_ref().is_some_and(|output| path.starts_with(output))
        && !written()
}

/// How the process ended: 0, 2 for bad input, and 1 where a check does not hold.
fn ended(case: &Case, outcome: &Outcome) -> Option<String> {
    let says = |words: &[&str]| case.arguments.iter().any(|word| words.iter().any(|known| word == known));
    let prints = ["schema", "effects", "completions"]
        .iter()
        .any(|command| case.arguments.first() == Some(&command.into()));
    match (outcome.code, outcome.signal) {
        (Some(0), _) if case.full && prints && !says(&["-q", "--quiet", "-h", "--help"]) => {
            Some("exit code 0, and the standard output was full".into())
        }
        (Some(0 | 2), _) => None,
        (Some(1), _) if says(&["check", "--check"]) => None,
        (_, Some(libc::SIGXCPU | libc::SIGKILL)) => Some("took longer than its seconds".into()),
        (_, Some(libc::SIGALRM)) => Some("was stuck".into()),
        (_, Some(libc::SIGXFSZ)) => Some("wrote a file beyond all measure".into()),
        (Some(code), _) => Some(format!("exit code {code}")),
        (None, signal) => Some(format!("signal {}", signal.unwrap_or_default())),
    }
}

/// What is wrong with the JSON that was asked for.
fn json(case: &Case, outcome: &Outcome) -> Option<String> {
    let wanted = !case.full && case.arguments.iter().any(|word| word == "--json");
    let text = String::from_utf8_lossy(&outcome.stdout);
    let json = wanted && text.starts_with(['{', '[']);
    json.then(|| written::json(&text).err())?.map(|what| format!("what --json printed {what}"))
}

/// A number that is not finite among what was printed, unless it is an argument.
fn infinite(case: &Case, outcome: &Outcome) -> Option<String> {
    let given = case.arguments.iter().any(|word| written::not_finite(word.as_encoded_bytes()).is_some());
    let stated = written::not_finite(&outcome.stdout).filter(|_| !given);
    stated.map(|what| format!("standard output {what}"))
}

/// The first message of the compiler about C that it should take without a warning.
fn compiled(path: &Path) -> Option<String> {
    path.extension().filter(|kind| *kind == "c")?;
    let mut compiler = Command::new("cc");
    compiler
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I"])
        .args([path.parent()?, path]);
    let said = match compiler.stdin(Stdio::null()).output() {
        Ok(said) if said.status.success() => return None,
        Ok(said) => String::from_utf8_lossy(&said.stderr).into_owned(),
        Err(error) => format!("cc: error: {error}"),
    };
    let first = said.lines().find_map(|line| line.split_once("error: ")).map_or("", |(_, what)| what);
    Some(format!("does not compile: {first}"))
}
