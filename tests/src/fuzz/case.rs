//! A case: files, a command line, and what is done with them.

use std::collections::BTreeMap;
use std::ffi::{CString, OsString};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use super::draw::Draw;
use super::process::{Limits, Outcome, run};
use super::seeds::{Line, Seeds, commands};
use super::table::Table;
use super::{bytes, document, judge, kept, written};

/// What is run, on what.
#[derive(Debug)]
pub struct Case {
    /// Files by their path in the folder of the case.
    pub files: BTreeMap<String, Vec<u8>>,
    /// The arguments of `arcsmith`.
    pub arguments: Vec<OsString>,
    /// Folder or file that the undamaged command writes, if it is there before.
    pub output: Option<String>,
    /// Whether the standard output is a full device.
    pub full: bool,
    /// Commands of `bash` that damage the files.
    pub prepare: Vec<&'static str>,
}

impl Case {
    /// A command line with the undamaged files that it names.
    pub fn plain(seeds: &Seeds, arguments: Vec<OsString>) -> Case {
        let words: Vec<_> = arguments.iter().map(|word| word.to_string_lossy().into_owned()).collect();
        let files = words.iter().flat_map(|word| seeds.named(word));
        let files = files.map(|(name, bytes)| (name.clone(), bytes.clone())).collect();
        // `check` and `--pages-for` only read what is there.
        let output = words.windows(2).find(|pair| pair[0] == "--out" && words[0] != "check");
        Case {
            files,
            output: output.map(|pair| pair[1].clone()),
            arguments,
            full: false,
            prepare: Vec::new(),
        }
    }

    /// A line of [`commands`] with the undamaged files that it reads.
    pub fn of(seeds: &Seeds, line: Line) -> Case {
        let mut case = Case::plain(seeds, line.words.split(' ').map(Into::into).collect());
        let beside = line.beside.split(' ').flat_map(|name| seeds.named(name));
        case.files.extend(beside.map(|(name, bytes)| (name.clone(), bytes.clone())));
        case
    }

    /// Case `number` of `seed`.
    pub fn draw(seeds: &Seeds, seed: u64, number: u64) -> Case {
        let mut draw = Draw::new(seed, number);
        let weighted: Vec<Line> = commands().flat_map(|line| vec![line; line.weight]).collect();
        let mut case = Case::of(seeds, *draw.pick(&weighted));
        let names: Vec<String> = case.files.keys().cloned().collect();
        let in_options = names.is_empty() || draw.one_in(3);
        if !names.is_empty() && (!in_options || draw.one_in(3)) {
            let name = draw.pick(&names);
            let damaged = damaged(&mut draw, name, &seeds.files);
            case.files.insert(name.clone(), damaged);
        }
        if in_options {
            (0..1 + draw.below(2)).for_each(|_| seeds.options.damage(&mut draw, &mut case.arguments, &names));
        }
        case.full = draw.one_in(50);
        case
    }

    /// Puts its files into an empty folder, and beside them what options may name: a folder and, if this user may
    /// make one, a full device.
    ///
    /// # Errors
    /// Where a file cannot be written, or a command of `bash` fails.
    pub fn lay_out(&self, folder: &Path) -> Result<(), String> {
        let put = |path: PathBuf, bytes: &[u8]| {
            std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
            std::fs::write(path, bytes)
        };
        for (name, bytes) in &self.files {
            put(folder.join(name), bytes).map_err(|error| format!("{name}: {error}"))?;
        }
        std::fs::create_dir(folder.join("folder")).map_err(|error| format!("folder: {error}"))?;
        if let Ok(path) = CString::new(folder.join("full").as_os_str().as_bytes()) {
            // SAFETY: the path ends with a zero. 1, 7 is `/dev/full`: a copy, as one of the machine could be replaced.
            unsafe { libc::mknod(path.as_ptr(), libc::S_IFCHR | 0o666, libc::makedev(1, 7)) };
        }
        self.prepare.iter().try_for_each(|step| kept::bash(folder, step).map(drop))
    }

    /// Runs it in an empty folder; what was wrong is empty where nothing was.
    ///
    /// # Errors
    /// Where it could not be laid out, run or watched.
    pub fn run(&self, program: &Path) -> Result<(Outcome, Vec<String>), String> {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let folder = folder.path();
        self.lay_out(folder)?;
        let before = written::files(folder)?;
        let searches = self.arguments.first().is_some_and(|word| word == "explore");
        let limits = if searches { Limits::SEARCH } else { Limits::CASE };
        let outcome = run(program, folder, &self.arguments, limits, self.full);
        let outcome = outcome.map_err(|error| format!("{}: {error}", program.display()))?;
        let after = written::files(folder)?;
        let wrong = judge::wrong(self, folder, &outcome, &before, &after);
        Ok((outcome, wrong))
    }
}

/// The file of that name, damaged as fits what it holds.
fn damaged(draw: &mut Draw, name: &str, seeds: &BTreeMap<String, Vec<u8>>) -> Vec<u8> {
    let text = &seeds[name];
    let mut damaged = match name.split_once('.').map_or("", |(_, kind)| kind) {
        "csv.gz" if draw.one_in(40) => return bytes::bomb(),
        "csv" | "csv.gz" | "parquet" => {
            let plain = &seeds[&name.replace(".gz", "").replace(".parquet", ".csv")];
            let mut table = Table::parse(plain);
            (0..*draw.pick(&[0, 1, 1, 1, 2, 3])).for_each(|_| table.damage(draw));
            match name.rsplit('.').next() {
                Some("gz") => bytes::gz(&table.csv(draw)),
                Some("parquet") => table.parquet().unwrap_or_default(),
                _ => table.csv(draw),
            }
        }
        "json" => document::json(draw, text, !name.contains('/')),
        kind if kind.ends_with("toml") => document::toml(draw, text),
        _ => text.clone(),
    };
    let packed = name.ends_with(".gz") || name.ends_with(".parquet");
    if damaged == *text || draw.one_in(if packed { 3 } else { 12 }) {
        bytes::damage(draw, &mut damaged);
    }
    damaged
}
