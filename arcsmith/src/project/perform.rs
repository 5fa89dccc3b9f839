//! Runs command lines of a project, and writes down what was done.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use codegen::refused;
use fitter::message::Message;
use fitter::output::FileSet;

use super::file::Project;
use super::stale::{self, Reason, short};
use super::state::{self, Done, State};
use super::steps::Step;
use crate::Cli;
use crate::terminal::{self, Common, Result};

/// Runs a step and writes down that it was done. The state is written last: where the program is killed before, the step
/// counts as not done.
pub fn step(project: &Project, step: &Step, common: Common) -> Result<ExitCode> {
    let mut state = State::read(project)?;
    readable(project, step, &state)?;
    let inputs = state::of_inputs(step)?;
    let mut set = FileSet::new();
    set.folder(Path::new(&project.out))?;
    // `fit` makes no folder; the other commands make their own.
    if let ("fit", Some(folder)) = (step.command, step.outputs.first().and_then(|file| file.parent())) {
        set.folder(folder)?;
    }
    let code = line(&step.words, common)?;
    let (words, outputs) = (step.words.clone(), state::of_outputs(step)?);
    state.steps.insert(step.name.clone(), Done { version: state::version(), words, inputs, outputs });
    let known: Vec<String> = project.steps().into_iter().map(|step| step.name).collect();
    state.steps.retain(|name, _| known.contains(name));
    set.put(&State::path(project), state.to_json()?)?;
    set.commit()?;
    Ok(code)
}

/// Runs a command line that may write into the folder of the results, which is made where it is not there.
pub fn typed(project: &Project, words: &[String], common: Common) -> Result<ExitCode> {
    // It vanishes again where nothing was written into it.
    let mut set = FileSet::new();
    set.folder(Path::new(&project.out))?;
    line(words, common)
}

/// Runs a command line, whose words are those of a project.
pub fn line(words: &[String], common: Common) -> Result<ExitCode> {
    terminal::running(words);
    crate::command(parse(words, common).map_err(|error| Message::of(error.to_string().trim_end()))?)
}

/// Parses a command line of a project.
pub fn parse(words: &[String], common: Common) -> std::result::Result<Cli, clap::Error> {
    let said = said(common);
    let words = words.iter().map(String::as_str).chain(said.iter().map(String::as_str));
    Cli::try_parse_from(std::iter::once("arcsmith").chain(words))
}

/// The words of the options of all commands.
fn said(common: Common) -> Vec<String> {
    let flags = [(common.json, "--json"), (common.quiet, "--quiet"), (common.verbose, "--verbose")];
    let limits = [("--max-bytes", common.max_bytes), ("--max-columns", common.max_columns)];
    let flags = flags.into_iter().filter(|(given, _)| *given).map(|(_, word)| word.to_string());
    flags.chain(limits.into_iter().filter_map(|(word, limit)| Some(format!("{word}={}", limit?)))).collect()
}

/// Refuses a project of which a recording is missing, or another file that is no result of its own.
pub fn all_is_there(project: &Project) -> Result<()> {
    let state = State::read(project)?;
    let first = project.steps().into_iter().filter(|step| step.after.is_empty());
    first.into_iter().try_for_each(|step| readable(project, &step, &state))
}

/// Refuses a step of which a file is missing that it reads.
fn readable(project: &Project, step: &Step, state: &State) -> Result<()> {
    let Some(missing) = step.inputs.iter().find(|input| !Path::new(&input.path).is_file()) else {
        return Ok(());
    };
    if !step.after.is_empty() {
        let made = step.after.iter().all(|after| state.steps.contains_key(after));
        let why = if made {
            "`diagnose` wrote no such file: it withheld its coefficients"
        } else {
            "is not there yet"
        };
        let mend = match (made, project.of_diagnosis) {
            (true, true) => {
                "set coefficients = \"fit\" in arcsmith.toml, or see the page of the diagnosis for the reason"
            }
            _ => "type `arcsmith run`",
        };
        return Err(refused!("{why}").at(&missing.path).mend(mend));
    }
    let before = state.steps.get(&step.name).and_then(|done| done.inputs.get(&missing.name()));
    let expected = match before {
        Some(hash) => format!("the file that `{}` has read, SHA-256 {}", step.command, short(hash)),
        None => "a file that arcsmith.toml names".to_string(),
    };
    Err(refused!("there is no such file")
        .at(&missing.path)
        .expected(expected)
        .mend("put it there, or name another in arcsmith.toml"))
}

/// Refuses coefficients that are not those of what the project now holds; `origin` is the step that writes them.
pub fn coefficients_are_new(project: &Project, origin: &str) -> Result<()> {
    let state = State::read(project)?;
    let steps = project.steps();
    let Some(step) = steps.iter().find(|step| step.name == origin) else { return Ok(()) };
    let Some(reason) = stale::reasons(step, &state)?.into_iter().next() else { return Ok(()) };
    let file = project.coefficients();
    let mend = match origin {
        "fit" | "diagnose" => {
            format!("type `arcsmith run`, or give --coefficients {file} to take them as they are")
        }
        _ => "type `arcsmith run`".to_string(),
    };
    let done = format!("of what `{origin}` has read");
    Err(match reason {
        Reason::New => refused!("`{origin}` was not run yet in this project").at(&file),
        Reason::Input { file, was: Some(was), is } => {
            let found = is.map_or("no file".to_string(), |is| format!("SHA-256 {}", short(&is)));
            refused!("changed since `{origin}`")
                .at(&file)
                .found(found)
                .expected(format!("{} {done}", short(&was)))
        }
        other => refused!("`{origin}` is stale: {other}").at(&file),
    }
    .mend(mend))
}
