//! Undamaged inputs, which the program under test writes itself, and what is run on them.

use std::collections::BTreeMap;
use std::path::Path;

use super::kept::{bash, quoted};
use super::options::Options;
use super::table::Table;
use super::written;

/// Files by name, and the options of every command.
#[derive(Debug)]
pub struct Seeds {
    /// The files.
    pub files: BTreeMap<String, Vec<u8>>,
    /// The options.
    pub options: Options,
}

/// A script that writes the files with `arcsmith`.
const SCRIPT: &str = include_str!("../../fuzz/seeds.sh");

/// What is run on them: a weight, how often it is drawn, and the command line; before a colon the files that it reads and
/// does not name, those of a project. Words that name seeds stand for their files. `verify` and `trials` are left out: they take minutes by design, and read nothing that the others do not.
const COMMANDS: &str = include_str!("../../fuzz/commands.txt");

/// A line of them.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// How often it is drawn.
    pub weight: usize,
    /// The files that it reads and does not name.
    pub beside: &'static str,
    /// The command line.
    pub words: &'static str,
}

/// The command lines.
pub fn commands() -> impl Iterator<Item = Line> {
    let lines = COMMANDS.lines().filter_map(|line| line.split_once(' '));
    lines.map(|(weight, line)| {
        let (beside, words) = line.split_once(": ").unwrap_or(("", line));
        Line { weight: weight.parse().unwrap_or(1), beside, words }
    })
}

impl Seeds {
    /// Makes them with `program`.
    ///
    /// # Errors
    /// The script's messages where it fails; or that a file could not be read.
    pub fn make(program: &Path) -> Result<Seeds, String> {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let program = quoted(&[program.into()]);
        bash(folder.path(), &format!("arcsmith() {{ {program} \"$@\"; }}\n{SCRIPT}"))?;
        let files = written::files(folder.path())?.into_iter();
        let files = files.filter_map(|(path, kind)| Some((path.to_str()?.to_string(), kind.bytes()?)));
        let mut files: BTreeMap<String, Vec<u8>> = files.collect();
        let recording = files.get("cal.csv").map(|text| Table::parse(text));
        let parquet = recording.and_then(|recording| recording.parquet()).ok_or("cal.csv: no Parquet")?;
        files.insert("cal.parquet".into(), parquet);
        let mut options = Options::default();
        for line in commands() {
            let command = line.words.split(' ').next().unwrap_or_default();
            let help = bash(folder.path(), &format!("{program} {command} -h"))?;
            options.learn(command, &String::from_utf8_lossy(&help));
        }
        Ok(Seeds { files, options })
    }

    /// The files that a word of a command line names: the one of that name, or all in the folder of that name.
    pub fn named<'a>(&'a self, word: &str) -> impl Iterator<Item = (&'a String, &'a Vec<u8>)> {
        let (name, folder) = (word.to_string(), format!("{word}/"));
        self.files.iter().filter(move |(path, _)| **path == name || path.starts_with(&folder))
    }
}
