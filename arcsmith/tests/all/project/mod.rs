//! A project: from a recording to firmware without a flag, what is stale and why, and what is refused.

mod bad_input;
mod columns;
mod devices;
mod options;
mod path;

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// A folder with a recording and its project file.
struct Folder(tempfile::TempDir);

impl Folder {
    fn empty() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    /// With a simulated recording, and a project of it.
    fn new() -> Folder {
        let folder = Folder::empty();
        folder.ok("record --protocol calibration --seed 7 --out calibration.csv --quiet");
        folder.ok("init --from calibration.csv --quiet");
        folder
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_arcsmith"));
        command
            .current_dir(self.path())
            .env_remove("ARCSMITH_RECORDINGS")
            .env_remove("ARCSMITH_EXAMPLES")
            .args(line.split_whitespace());
        command
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// What is printed where all is well.
    fn ok(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(0), "{line}: {output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.ok(&format!("{line} --json"))).unwrap()
    }

    /// The message of a command that is refused: nothing else is printed.
    fn refused(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(2), "{line}: {output:?}");
        String::from_utf8(output.stderr).unwrap()
    }

    fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.path().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    }

    fn write(&self, file: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path().join(file), text).unwrap();
    }

    /// Replaces a part of the project file.
    fn edit(&self, before: &str, after: &str) {
        let text = self.read("arcsmith.toml");
        assert!(text.contains(before), "{before}: {text}");
        self.write("arcsmith.toml", text.replacen(before, after, 1));
    }

    /// The lines of `arcsmith` alone that begin with a word.
    fn state(&self, label: &str) -> String {
        let said = self.ok("");
        let lines: Vec<&str> = said.lines().filter(|line| line.starts_with(label)).collect();
        lines.join("\n")
    }

    /// All files below a folder, and what they hold.
    fn files(&self) -> std::collections::BTreeMap<String, Vec<u8>> {
        let mut files = std::collections::BTreeMap::new();
        let mut folders = vec![self.path().to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                let name = path.strip_prefix(self.path()).unwrap().display().to_string();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    files.insert(name, std::fs::read(&path).unwrap());
                }
            }
        }
        files
    }
}
