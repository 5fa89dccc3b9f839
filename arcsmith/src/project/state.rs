//! What was done in a project, in one file: for every step its command, and the SHA-256 of what it read and wrote.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use codegen::refused;
use fitter::input;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::file::Project;
use super::steps::{Input, Step};
use crate::terminal::Result;

/// The file, in the folder of the results.
const NAME: &str = "state.json";
const SCHEMA: &str = "arcsmith-state";

/// What was done, by the step's name.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    schema: String,
    /// The steps.
    pub steps: BTreeMap<String, Done>,
}

/// How a step was done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Done {
    /// Version of the program.
    pub version: String,
    /// The command line.
    pub words: Vec<String>,
    /// SHA-256 of what it read, by name.
    pub inputs: BTreeMap<String, String>,
    /// SHA-256 of what it wrote, by path.
    pub outputs: BTreeMap<String, String>,
}

impl Default for State {
    fn default() -> State {
        State { schema: SCHEMA.into(), steps: BTreeMap::new() }
    }
}

impl State {
    /// Where the state of a project is kept.
    pub fn path(project: &Project) -> PathBuf {
        Path::new(&project.out).join(NAME)
    }

    /// Reads the state of a project; where there is none, nothing was done.
    pub fn read(project: &Project) -> Result<State> {
        let path = State::path(project);
        if !path.is_file() {
            return Ok(State::default());
        }
        let text = input::parsed(&path, "state of a project (JSON)")?;
        let damaged = |what: &dyn std::fmt::Display| {
            refused!("is not the state of a project ({what})")
                .at(&path)
                .mend("remove it: `arcsmith run` makes it anew")
        };
        let state: State = serde_json::from_str(&text).map_err(|error| damaged(&error))?;
        match state.schema.as_str() {
            SCHEMA => Ok(state),
            other => Err(damaged(&format_args!("its schema is `{other}`"))),
        }
    }

    /// The text of the file.
    pub fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// The version that stands in the state.
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_string()
}

/// SHA-256 of what a step reads, by name; a file that is not there is left out.
pub fn of_inputs(step: &Step) -> Result<BTreeMap<String, String>> {
    let mut hashes = BTreeMap::new();
    for input in &step.inputs {
        if let Some(hash) = of_input(input)? {
            hashes.insert(input.name(), hash);
        }
    }
    Ok(hashes)
}

fn of_input(read: &Input) -> Result<Option<String>> {
    let path = Path::new(&read.path);
    if read.tables.is_empty() {
        return of_file(path);
    }
    // Blank lines and comments of the project file change nothing.
    let text = input::toml(path, "project file (TOML)", read.tables)?;
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    Ok(Some(hex(Sha256::digest(lines.collect::<Vec<_>>().join("\n")))))
}

/// SHA-256 of what a step wrote, by path: of its files those that are there.
pub fn of_outputs(step: &Step) -> Result<BTreeMap<String, String>> {
    let mut hashes = BTreeMap::new();
    for path in step.outputs.iter().chain(&certified(step)) {
        if let Some(hash) = of_file(path)? {
            hashes.insert(path.display().to_string().replace('\\', "/"), hash);
        }
    }
    Ok(hashes)
}

/// The files that the certificate of a target names.
fn certified(step: &Step) -> Vec<PathBuf> {
    let Some(certificate) = certificate(step) else { return Vec::new() };
    let folder = step.outputs.first().and_then(|path| path.parent()).unwrap_or(Path::new(""));
    certificate.routines.iter().map(|entry| folder.join(&entry.file)).collect()
}

/// The certificate of a target that was generated, if it can be read.
pub fn certificate(step: &Step) -> Option<codegen::certificate::Certificate> {
    let path = step.outputs.first().filter(|_| step.command == "generate")?;
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

/// SHA-256 of a file; none where there is no such file.
pub fn of_file(path: &Path) -> Result<Option<String>> {
    let unreadable =
        |error: io::Error| refused!("cannot be read ({error})").at(path.to_string_lossy().as_ref());
    let mut file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(unreadable(error)),
    };
    let (mut hash, mut buffer) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer).map_err(unreadable)? {
            0 => return Ok(Some(hex(hash.finalize()))),
            count => hash.update(&buffer[..count]),
        }
    }
}

fn hex(bytes: impl IntoIterator<Item = u8>) -> String {
    bytes.into_iter().map(|byte| format!("{byte:02x}")).collect()
}
