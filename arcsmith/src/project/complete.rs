//! What is typed in the folder of a project, completed by what the project says: what a command is given stays, and what
//! it lacks comes from the project file.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::parser::ValueSource;
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches};
use codegen::refused;
use fitter::table::Mapping;
use serde_json::json;

use super::file::{Nominal, Project, Target, normal};
use super::options::Given;
use super::steps::{Step, offered, words};
use super::{FILE, perform};
use crate::Cli;
use crate::terminal::{Common, Result, gathered, say_json};

/// What was typed, completed.
pub struct Asked {
    project: Project,
    common: Common,
    lines: Vec<Line>,
}

/// A command line.
struct Line {
    words: Vec<String>,
    /// The options of all commands, where they do not stand in the words.
    common: Common,
    /// The step that it is, where nothing in it differs from what the project does by itself.
    step: Option<Step>,
    /// The steps of the project that write the coefficients which it takes.
    origins: Vec<String>,
}

/// The commands that a project completes.
const COMPLETED: [&str; 10] =
    ["fit", "diagnose", "fleet", "apply", "report", "explore", "budget", "generate", "check", "verify"];
/// Sources of another kind: where one is named, the command is about no project.
const OTHER_SOURCES: [&str; 3] = ["demo", "devices", "recording"];
/// Words that say how much is printed.
const PLAIN: [&str; 5] = ["--json", "-q", "--quiet", "-v", "--verbose"];
/// Options that say how much is printed and read, for all commands.
const COMMON: [&str; 5] = ["json", "quiet", "verbose", "max_bytes", "max_columns"];

/// The typed command line as the project of this folder completes it; none where there is no project, or the command is
/// none of those that it completes.
pub fn asked(typed: impl Iterator<Item = OsString>) -> Result<Option<Asked>> {
    let typed: std::result::Result<Vec<String>, OsString> =
        typed.skip(1).map(OsString::into_string).collect();
    let Ok(typed) = typed else { return Ok(None) };
    if !Project::is_here() {
        return Ok(None);
    }
    let program = Cli::command().ignore_errors(true);
    // Help and version are left to the usual reading.
    let Ok(matches) =
        program.try_get_matches_from(std::iter::once("arcsmith").chain(typed.iter().map(String::as_str)))
    else {
        return Ok(None);
    };
    let Some((name, given)) = matches.subcommand() else {
        let plain =
            typed.iter().all(|word| ["--json", "-q", "--quiet", "-v", "--verbose"].contains(&word.as_str()));
        return plain.then(|| asked_for_the_state(&matches)).transpose();
    };
    if !COMPLETED.contains(&name) {
        return Ok(None);
    }
    let program = Cli::command();
    let Some(definition) = program.find_subcommand(name) else { return Ok(None) };
    let typed =
        Typed { name, words: &typed, definition, given, ids: ids(given, definition), common: common(given) };
    let of_generation = ["generate", "check", "verify", "explore", "budget"].contains(&name);
    if of_generation && typed.ids.iter().any(|id| OTHER_SOURCES.contains(&id.as_str())) {
        return Ok(None);
    }
    let project = Project::read()?;
    let lines = typed.lines(&project)?;
    Ok(Some(Asked { project, common: typed.common, lines }))
}

/// `arcsmith` alone: what is to be done.
fn asked_for_the_state(matches: &ArgMatches) -> Result<Asked> {
    let common = common(matches);
    let line = Line { words: vec!["status".into()], common, step: None, origins: Vec::new() };
    Ok(Asked { project: Project::read()?, common, lines: vec![line] })
}

fn common(matches: &ArgMatches) -> Common {
    Common::from_arg_matches(matches).unwrap_or_default()
}

/// The ids of the arguments that were typed, but for those of all commands.
fn ids(given: &ArgMatches, definition: &Command) -> Vec<String> {
    let typed = |id: &&str| given.value_source(id) == Some(ValueSource::CommandLine) && !COMMON.contains(id);
    let own = definition.get_arguments().map(|arg| arg.get_id().as_str());
    own.filter(|id| given.try_contains_id(id).is_ok()).filter(typed).map(str::to_string).collect()
}

/// A command line as it was typed.
struct Typed<'a> {
    name: &'a str,
    words: &'a [String],
    definition: &'a Command,
    /// What it has.
    given: &'a ArgMatches,
    /// The ids of that.
    ids: Vec<String>,
    common: Common,
}

impl Typed<'_> {
    /// The lines that it comes to: of what is generated one for each target.
    fn lines(&self, project: &Project) -> Result<Vec<Line>> {
        if self.name == "check" && self.is_bare() {
            let words = vec!["status".to_string(), "--strict".into()];
            return Ok(vec![Line { words, common: self.common, step: None, origins: Vec::new() }]);
        }
        if matches!(project.nominal, Nominal::Plant(_)) && self.name != "diagnose" {
            return Err(refused!("`{}` needs a sensor, and the project has a plant", self.name)
                .at(FILE)
                .mend("state the mirror in place of the plant; a plant is diagnosed: `arcsmith diagnose`"));
        }
        if !["generate", "check", "verify"].contains(&self.name) {
            return Ok(vec![self.line(project, None)]);
        }
        if project.targets.is_empty() {
            return Err(refused!("there is no target")
                .at(FILE)
                .expected("a table [[generate]] for each")
                .mend("add one"));
        }
        Ok(self.targets(project)?.into_iter().map(|target| self.line(project, Some(target))).collect())
    }

    /// The targets that are meant: that of the folder which was typed, or all.
    fn targets<'p>(&self, project: &'p Project) -> Result<Vec<&'p Target>> {
        let all: Vec<&Target> = project.targets.iter().collect();
        let Some(out) = self.out().filter(|_| all.len() > 1) else { return Ok(all) };
        match all.iter().find(|target| normal(&target.out) == normal(&out)) {
            Some(target) => Ok(vec![*target]),
            None => {
                let folders: Vec<&str> = all.iter().map(|target| target.out.as_str()).collect();
                Err(refused!("--out {out} is no folder of a target")
                    .expected(format!("one of {}", folders.join(", ")))
                    .mend("name the target by its folder, or add one to arcsmith.toml"))
            }
        }
    }

    /// The folder that was typed.
    fn out(&self) -> Option<String> {
        let typed = self.ids.iter().any(|id| id == "out");
        let mut values = self.given.try_get_raw("out").ok().flatten().filter(|_| typed)?;
        values.next().map(|value| value.to_string_lossy().into_owned())
    }

    /// The line, completed.
    fn line(&self, project: &Project, target: Option<&Target>) -> Line {
        let offered = offered(project, self.name, target);
        let missing: Vec<&Given> = offered.iter().filter(|one| !self.excludes(one)).collect();
        let takes = missing.iter().any(|one| ["coefficients", "devices"].contains(&one.id.as_str()));
        let origins = if takes { project.origins(target) } else { Vec::new() };
        if self.is_bare() {
            let words = words(project, self.name, target);
            let step = project.steps().into_iter().find(|step| step.words == words);
            return Line { words, common: self.common, step, origins };
        }
        let (places, options): (Vec<&Given>, Vec<&Given>) =
            missing.into_iter().partition(|one| one.positional);
        let mut words = self.words.to_vec();
        // Options stand before what was typed, so that a list of values that it ends in takes none of them.
        let at = words.iter().position(|word| word == self.name).map_or(0, |at| at + 1);
        words.splice(at..at, options.into_iter().flat_map(|one| one.words.clone()));
        words.extend(places.into_iter().flat_map(|one| one.words.clone()));
        Line { words, common: Common::default(), step: None, origins }
    }

    /// Whether nothing was typed but the command, and the options of all commands. A word that no command knows counts.
    fn is_bare(&self) -> bool {
        let plain = |word: &String| *word == self.name || PLAIN.contains(&word.as_str());
        self.ids.is_empty() && self.words.iter().all(plain)
    }

    /// Whether an argument was typed, or one that does not go with it; of columns each for itself.
    fn excludes(&self, offered: &Given) -> bool {
        let id = offered.id.as_str();
        if id == "map" {
            let typed = self.given.try_get_many::<Mapping>("map").ok().flatten().into_iter().flatten();
            let own = offered.words.last().and_then(|text| text.parse::<Mapping>().ok());
            return own.is_some_and(|own| {
                typed.into_iter().any(|one| one.target == own.target || one.source == own.source)
            });
        }
        let arg = |id: &str| self.definition.get_arguments().find(|arg| arg.get_id() == id);
        let against = |one: &str, other: &str| {
            arg(one).is_some_and(|arg| {
                self.definition.get_arg_conflicts_with(arg).iter().any(|arg| arg.get_id() == other)
            })
        };
        self.ids.iter().any(|typed| typed == id || against(typed, id) || against(id, typed))
    }
}

impl Asked {
    /// Refuses what the commands do not know.
    pub fn parsed(self) -> std::result::Result<Asked, clap::Error> {
        for line in &self.lines {
            perform::parse(&line.words, line.common)?;
        }
        Ok(self)
    }

    /// Runs the lines; the exit code is the last that is not 0.
    pub fn run(self) -> Result<ExitCode> {
        self.common.limit();
        if self.lines.len() == 1 || !self.common.json {
            return self.each();
        }
        let (code, said) = gathered(|| self.each());
        let code = code?;
        say_json(&format!("{:#}", json!(said)));
        Ok(code)
    }

    fn each(&self) -> Result<ExitCode> {
        let mut ended = ExitCode::SUCCESS;
        for line in &self.lines {
            for origin in &line.origins {
                perform::coefficients_are_new(&self.project, origin)?;
            }
            let code = match &line.step {
                Some(step) => perform::step(&self.project, step, self.common)?,
                None => perform::typed(&self.project, &line.words, line.common)?,
            };
            ended = if code == ExitCode::SUCCESS { ended } else { code };
        }
        Ok(ended)
    }
}
