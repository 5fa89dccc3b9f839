//! `status`: what is done in a project, what is stale and why, and what to do next.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use clap::Args;
use codegen::{refused, text};
use serde_json::{Value, json};

use super::file::Project;
use super::stale::{self, Reason};
use super::state::{self, State};
use super::steps::{Step, words};
use super::{FILE, perform};
use crate::terminal::{Common, FIGURE, Result, WARNING, gathered, line, summarise};

/// Arguments of `status`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith status
  arcsmith status --strict        what `arcsmith check` does in a project: the line for your CI
  arcsmith status --json | jq .next")]
pub struct StatusArgs {
    /// Compare what is generated as well, and end with exit code 1 where something is stale, exceeds its bound, or
    /// was guessed and not confirmed
    #[arg(long)]
    strict: bool,
}

/// What is known of a project.
pub struct Status {
    /// The steps, and why each is stale.
    pub steps: Vec<(Step, Vec<Reason>)>,
    /// What was guessed and not confirmed.
    pub guessed: Vec<String>,
    /// Routines whose proven bound is larger than wanted.
    pub exceeded: Vec<String>,
    /// The verdict of the diagnosis, by recording.
    pub verdicts: BTreeMap<String, String>,
    /// What to type next.
    pub next: String,
}

/// The project of the current folder; refused where there is none.
pub fn project() -> Result<Project> {
    match Project::is_here() {
        true => Project::read(),
        false => Err(refused!("there is no {FILE} in this folder")
            .mend("write one: `arcsmith init --from calibration.csv`")),
    }
}

pub fn run(args: &StatusArgs, common: Common) -> Result<ExitCode> {
    let project = project()?;
    if args.strict {
        perform::all_is_there(&project)?;
    }
    let status = Status::of(&project)?;
    let (differ, compared) =
        if args.strict { compare(&project, &status, common)? } else { (false, Vec::new()) };
    let fails = args.strict && (differ || !status.holds());
    summarise(
        common,
        || {
            let mut value = status.json();
            if args.strict {
                value["holds"] = json!(!fails);
                value["compared"] = json!(compared);
            }
            value
        },
        || status.text(),
    );
    Ok(if fails { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

/// Compares every target that is not stale with a new generation: whether one differs, and what was said of it as JSON.
fn compare(project: &Project, status: &Status, common: Common) -> Result<(bool, Vec<Value>)> {
    let stale = |folder: &str| {
        let name = format!("generate {folder}");
        status.steps.iter().any(|(step, reasons)| step.name == name && !reasons.is_empty())
    };
    let mut differ = false;
    let (compared, said) = gathered(|| -> Result<()> {
        for target in project.targets.iter().filter(|target| !stale(&target.out)) {
            let code =
                perform::line(&words(project, "check", Some(target)), Common { verbose: false, ..common })?;
            differ |= code != ExitCode::SUCCESS;
        }
        Ok(())
    });
    compared?;
    Ok((differ, said))
}

impl Status {
    /// Looks at a project.
    pub fn of(project: &Project) -> Result<Status> {
        let state = State::read(project)?;
        let steps = project.steps();
        let mut reasons = stale::all(&steps, &state)?;
        let steps: Vec<(Step, Vec<Reason>)> = (steps.into_iter())
            .map(|step| {
                let reasons = reasons.remove(&step.name).unwrap_or_default();
                (step, reasons)
            })
            .collect();
        let verdicts = verdicts(project);
        let exceeded = steps.iter().filter_map(|(step, _)| exceeded(step)).collect();
        let guessed = project.guessed.iter().map(|(_, key)| key.clone()).collect();
        let mut status = Status { steps, guessed, exceeded, verdicts, next: String::new() };
        status.next = status.next_step(project);
        Ok(status)
    }

    /// Whether nothing is stale, exceeded or guessed.
    pub fn holds(&self) -> bool {
        self.guessed.is_empty()
            && self.exceeded.is_empty()
            && self.steps.iter().all(|(_, reasons)| reasons.is_empty())
    }

    fn next_step(&self, project: &Project) -> String {
        let reasons = || self.steps.iter().flat_map(|(_, reasons)| reasons);
        let missing = reasons().find_map(|reason| match reason {
            Reason::Input { file, is: None, .. } if !file.starts_with(&format!("{}/", project.out)) => {
                Some(file)
            }
            _ => None,
        });
        if let Some(file) = missing {
            format!("put {file} into this folder, or name the right file in {FILE}")
        } else if reasons().next().is_some() {
            "arcsmith run".into()
        } else if !self.exceeded.is_empty() {
            format!("choose another format, degree or bound in {FILE}, then arcsmith run")
        } else if !self.guessed.is_empty() {
            format!("confirm what was guessed: look at it in {FILE}, then take it off the list `guessed`")
        } else if project.targets.is_empty() || self.verdicts.values().any(|verdict| is_open(verdict)) {
            format!("read the page of the diagnosis in {}", project.diagnosed())
        } else {
            "arcsmith verify checks the firmware from outside; arcsmith check is the line for your CI".into()
        }
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let steps = self.steps.iter().map(|(step, reasons)| {
            let why: Vec<String> = reasons.iter().map(ToString::to_string).collect();
            json!({"name": step.name, "stale": !reasons.is_empty(), "reasons": reasons, "why": why})
        });
        json!({
            "steps": steps.collect::<Vec<_>>(),
            "verdicts": self.verdicts,
            "guessed": self.guessed,
            "exceeded": self.exceeded,
            "next": self.next,
        })
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut all = String::new();
        for (step, reasons) in &self.steps {
            let place = step.name.split_once(' ').map_or(String::new(), |(_, place)| format!("{place}: "));
            all += &line(step.command, &format!("{place}{}", self.of_step(step, reasons)));
        }
        for what in &self.exceeded {
            all += &line("bound", &format!("{WARNING}{what}{WARNING:#}"));
        }
        if !self.guessed.is_empty() {
            all +=
                &line("guessed", &format!("{WARNING}{}{WARNING:#}: not confirmed", self.guessed.join(", ")));
        }
        all + &line("next", &format!("{FIGURE}{}{FIGURE:#}", self.next))
    }

    fn of_step(&self, step: &Step, reasons: &[Reason]) -> String {
        if !reasons.is_empty() {
            let why: Vec<String> = reasons.iter().map(ToString::to_string).collect();
            let why = why.join("; ");
            return match reasons.contains(&Reason::New) {
                true => format!("{WARNING}{why}{WARNING:#}"),
                false => format!("{WARNING}stale{WARNING:#}: {why}"),
            };
        }
        match step.command {
            "diagnose" => {
                let verdicts =
                    self.verdicts.iter().map(|(recording, verdict)| format!("{recording} {verdict}"));
                format!("up to date: {}", verdicts.collect::<Vec<_>>().join(", ").replace('_', " "))
            }
            "generate" => format!("up to date, {}", proven(step)),
            _ => step
                .outputs
                .first()
                .map_or("up to date".into(), |file| format!("up to date: {}", file.display())),
        }
    }
}

/// Whether a verdict leaves something to be explained.
fn is_open(verdict: &str) -> bool {
    ["unexplained", "partly_explained"].contains(&verdict)
}

/// The largest bound of a target's routines and its unit.
fn largest(step: &Step) -> Option<(f64, String, String)> {
    let certificate = state::certificate(step)?;
    let worst = certificate.routines.into_iter().max_by(|a, b| a.bound.total_cmp(&b.bound))?;
    Some((worst.bound, worst.unit, worst.routine))
}

fn proven(step: &Step) -> String {
    largest(step).map_or_else(String::new, |(bound, unit, _)| {
        format!("proven within {} {unit}", text::rounded_up(bound))
    })
}

/// Where the proven bound is larger than the project wants it.
fn exceeded(step: &Step) -> Option<String> {
    let wanted = step.bound.as_ref()?;
    let number = wanted.trim_end_matches(|sign: char| sign.is_alphabetic() || sign == 'µ').trim();
    let (bound, unit, routine) = largest(step)?;
    let most: f64 = number.parse().ok()?;
    let folder = step.name.strip_prefix("generate ")?;
    (bound > most).then(|| {
        format!("{folder}: {routine} is proven within {} {unit}, wanted {number}", text::rounded_up(bound))
    })
}

/// The verdicts of the diagnosis that are there, by recording.
fn verdicts(project: &Project) -> BTreeMap<String, String> {
    let verdict = |path: &Path| -> Option<String> {
        let value: Value = serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()?;
        Some(value["verdict"].as_str()?.to_string())
    };
    let files = project.diagnoses();
    let found = project.recordings.iter().zip(&files);
    found.filter_map(|(recording, file)| Some((recording.clone(), verdict(file)?))).collect()
}
