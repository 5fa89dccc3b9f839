//! Whether a step has to be done again, and why.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use super::state::{self, Done, State};
use super::steps::Step;
use crate::terminal::Result;

/// Why a step has to be done again.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "what")]
pub enum Reason {
    /// It was not done.
    New,
    /// Another version of the program did it.
    Version {
        /// The version that did it.
        was: String,
        /// This one.
        is: String,
    },
    /// It was given other options.
    Options {
        /// Words that it is given now.
        now: Vec<String>,
        /// Words that it was given before.
        before: Vec<String>,
    },
    /// What it reads is another file, or is not there.
    Input {
        /// The file.
        file: String,
        /// SHA-256 of what was read; none where it was not read before.
        was: Option<String>,
        /// SHA-256 of what is there; none where nothing is.
        is: Option<String>,
    },
    /// What it wrote is another file, or is not there any more.
    Output {
        /// The file.
        file: String,
        /// SHA-256 of what was written.
        was: String,
        /// SHA-256 of what is there; none where nothing is.
        is: Option<String>,
    },
    /// A step is stale whose result it reads.
    After {
        /// That step.
        step: String,
    },
}

/// So many digits of a hash are shown.
const SHOWN: usize = 12;

/// The beginning of a hash, for a message.
pub fn short(hash: &str) -> &str {
    hash.get(..SHOWN).unwrap_or(hash)
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::New => write!(f, "not done yet"),
            Reason::Version { was, is } => write!(f, "done by version {was}, this is {is}"),
            Reason::Options { now, before } => {
                let list =
                    |words: &[String]| if words.is_empty() { "nothing".into() } else { words.join(" ") };
                write!(f, "other options: now {}, before {}", list(now), list(before))
            }
            Reason::Input { file, was: Some(was), is: Some(is) } => {
                write!(f, "{file} changed: its SHA-256 was {}, is {}", short(was), short(is))
            }
            Reason::Input { file, was: Some(was), is: None } => {
                write!(f, "{file} is missing, whose SHA-256 was {}", short(was))
            }
            Reason::Input { file, was: None, is: Some(_) } => write!(f, "{file} is read now"),
            Reason::Input { file, was: None, is: None } => write!(f, "{file} is missing"),
            Reason::Output { file, was, is: Some(is) } => {
                write!(f, "{file} was changed: its SHA-256 was {}, is {}", short(was), short(is))
            }
            Reason::Output { file, is: None, .. } => write!(f, "{file} is missing"),
            Reason::After { step } => write!(f, "waits for {step}"),
        }
    }
}

/// Why a step has to be done again, other steps left aside; empty where all is as it was.
pub fn reasons(step: &Step, state: &State) -> Result<Vec<Reason>> {
    let inputs = state::of_inputs(step)?;
    let missing = step.inputs.iter().map(|input| input.name()).filter(|name| !inputs.contains_key(name));
    let Some(done) = state.steps.get(&step.name) else {
        let missing = missing.map(|file| Reason::Input { file, was: None, is: None });
        return Ok(std::iter::once(Reason::New).chain(missing).collect());
    };
    let mut reasons = Vec::new();
    let version = state::version();
    if done.version != version {
        reasons.push(Reason::Version { was: done.version.clone(), is: version });
    }
    reasons.extend(options(step, done));
    for input in &step.inputs {
        let file = input.name();
        let (was, is) = (done.inputs.get(&file).cloned(), inputs.get(&file).cloned());
        if was != is || is.is_none() {
            reasons.push(Reason::Input { file, was, is });
        }
    }
    let outputs = state::of_outputs(step)?;
    for (file, was) in &done.outputs {
        let is = outputs.get(file).cloned();
        if is.as_ref() != Some(was) {
            reasons.push(Reason::Output { file: file.clone(), was: was.clone(), is });
        }
    }
    Ok(reasons)
}

/// The options that changed, an option and its value being one.
fn options(step: &Step, done: &Done) -> Option<Reason> {
    if step.words == done.words {
        return None;
    }
    let whole = |words: &[String]| {
        let mut whole: Vec<String> = Vec::new();
        for word in words.iter().skip(1) {
            match whole.last_mut() {
                Some(last)
                    if last.starts_with("--") && !word.starts_with("--") && !last.contains([' ', '=']) =>
                {
                    *last += &format!(" {word}");
                }
                _ => whole.push(word.clone()),
            }
        }
        whole
    };
    let (now, before) = (whole(&step.words), whole(&done.words));
    let only = |these: &[String], others: &[String]| -> Vec<String> {
        these.iter().filter(|word| !others.contains(word)).cloned().collect()
    };
    Some(Reason::Options { now: only(&now, &before), before: only(&before, &now) })
}

/// Why every step has to be done again, by its name, those that wait for others included.
pub fn all(steps: &[Step], state: &State) -> Result<BTreeMap<String, Vec<Reason>>> {
    let mut all: BTreeMap<String, Vec<Reason>> = BTreeMap::new();
    for step in steps {
        let mut own = reasons(step, state)?;
        let waits = |after: &&String| all.get(*after).is_some_and(|reasons| !reasons.is_empty());
        if let Some(after) = step.after.iter().find(waits) {
            // What the other step writes is not to be reported as missing.
            own.retain(|reason| !matches!(reason, Reason::Input { .. }));
            own.push(Reason::After { step: after.to_string() });
        }
        all.insert(step.name.clone(), own);
    }
    Ok(all)
}
