//! `run`: does what is stale in a project, in order, and says where the files are.

use clap::Args;
use serde_json::{Value, json};

use super::file::Project;
use super::stale::{self, Reason};
use super::state::State;
use super::status::{self, Status};
use super::steps::Step;
use super::{FILE, perform};
use crate::terminal::{Common, LABEL, Result, gathered, line, say, summarise, warn};

/// Arguments of `run`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith run              fit, diagnose and generate what is stale
  arcsmith run --all        all of it, stale or not")]
pub struct RunArgs {
    /// Do every step, also what is up to date
    #[arg(long)]
    all: bool,
}

/// A step as it went.
struct Went {
    name: String,
    reasons: Vec<Reason>,
    done: bool,
    said: Vec<Value>,
}

pub fn run(args: &RunArgs, common: Common) -> Result<()> {
    let project = status::project()?;
    perform::all_is_there(&project)?;
    if let Some((number, _)) = project.guessed.first() {
        let keys: Vec<&str> = project.guessed.iter().map(|(_, key)| key.as_str()).collect();
        let what = match &keys[..] {
            [one] => format!("{one} was guessed: look at it, then take it off the list `guessed`"),
            several => {
                format!(
                    "{} were guessed: look at them, then take them off the list `guessed`",
                    several.join(", ")
                )
            }
        };
        let what = format!("{FILE}, line {number}: {what}");
        warn(&what, common);
    }
    let mut steps = Vec::new();
    for step in project.steps() {
        // Looked at only now: a step before it may have written what it reads.
        let reasons = stale::reasons(&step, &State::read(&project)?)?;
        let done = args.all || !reasons.is_empty();
        announce(&step, &reasons, done, common);
        let said = if done { perform_one(&project, &step, common)? } else { Vec::new() };
        steps.push(Went { name: step.name, reasons, done, said });
    }
    let status = Status::of(&project)?;
    remind(&project, &status, common);
    summarise(
        common,
        || {
            let mut value = status.json();
            let went = |went: &Went| {
                let why: Vec<String> = went.reasons.iter().map(ToString::to_string).collect();
                json!({"name": went.name, "done": went.done, "why": why, "result": went.said.first()})
            };
            value["steps"] = steps.iter().map(went).collect();
            value["files"] = json!(files(&project));
            value
        },
        || {
            let files = files(&project);
            let mut text = files.iter().map(|(what, file)| line(what, file)).collect::<String>();
            text += &line("next", &status.next);
            text
        },
    );
    Ok(())
}

fn perform_one(project: &Project, step: &Step, common: Common) -> Result<Vec<Value>> {
    if !common.json {
        perform::step(project, step, common)?;
        return Ok(Vec::new());
    }
    let (code, said) = gathered(|| perform::step(project, step, common));
    code.map(|_| said)
}

/// Says which step comes and why, or that it needs not.
fn announce(step: &Step, reasons: &[Reason], done: bool, common: Common) {
    if common.quiet || common.json {
        return;
    }
    let why: Vec<String> = reasons.iter().map(ToString::to_string).collect();
    let why = match (done, reasons.is_empty()) {
        (false, _) => "up to date".to_string(),
        (true, true) => "up to date, done again".to_string(),
        (true, false) => why.join("; "),
    };
    say(&format!("{LABEL}── {} ──{LABEL:#} {why}", step.name));
}

/// What firmware of the fit alone does not have.
fn remind(project: &Project, status: &Status, common: Common) {
    if project.of_diagnosis || project.targets.is_empty() {
        return;
    }
    for (recording, verdict) in status.verdicts.iter().filter(|(_, verdict)| *verdict != "consistent") {
        let verdict = verdict.replace('_', " ");
        warn(
            &format!(
                "{recording} is {verdict}: the firmware is that of the fit, without what the diagnosis found; set \
                 coefficients = \"diagnosis\" in {FILE} to put it in"
            ),
            common,
        );
    }
}

/// Where the results are.
fn files(project: &Project) -> Vec<(String, String)> {
    let mut files = Vec::new();
    for step in project.steps() {
        match step.command {
            "fit" if step.name != "fit" => {}
            "fit" => files
                .extend(step.outputs.first().map(|file| ("model".to_string(), file.display().to_string()))),
            "diagnose" => files.push(("diagnosis".into(), project.diagnosed())),
            _ => files.extend(
                step.name.strip_prefix("generate ").map(|out| ("firmware".to_string(), out.to_string())),
            ),
        }
    }
    files
}
