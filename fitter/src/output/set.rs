//! The files of one command, written together.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::stage::{Stage, settle_here, turn};
use super::{OutputError, fill, is_special, write_special};
use crate::text_safety;

/// Files that appear together or not at all; see [the module](super) for what that means. Dropped before
/// [`FileSet::commit`], it leaves everything as it was.
#[derive(Default)]
pub struct FileSet {
    moves: Vec<Move>,
    special: Vec<(PathBuf, Vec<u8>)>,
    // Before the folders in which they are.
    stages: Vec<Stage>,
    made: Made,
    same_stay: bool,
}

/// One rename of the end: of the hidden folder's file to its name, or, of a file that is to vanish, back.
struct Move {
    stage: usize,
    name: OsString,
    from: PathBuf,
    to: PathBuf,
}

impl FileSet {
    /// An empty set.
    pub fn new() -> FileSet {
        FileSet::default()
    }

    /// Leaves a file alone, and its time of change, whose contents are there already.
    #[must_use]
    pub fn same_stay(self) -> FileSet {
        FileSet { same_stay: true, ..self }
    }

    /// Makes `folder` and those above it; they vanish again where the set is not committed.
    ///
    /// # Errors
    /// [`OutputError::Unwritable`].
    pub fn folder(&mut self, folder: &Path) -> Result<(), OutputError> {
        let mut missing: Vec<&Path> = folder.ancestors().collect();
        missing.retain(|path| !path.as_os_str().is_empty() && !path.exists());
        for path in missing.into_iter().rev() {
            match fs::create_dir(path) {
                Ok(()) => self.made.0.push(path.to_owned()),
                Err(_) if path.is_dir() => {}
                Err(error) => return Err(OutputError::unwritable(path, &error)),
            }
        }
        Ok(())
    }

    /// Puts the new contents of `path` together by `write`. Files appear in the order in which they are added: the one
    /// that vouches for the others is added last.
    ///
    /// # Errors
    /// One of [`OutputError`]; nothing was changed.
    pub fn add(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let failed = |error: io::Error| OutputError::unwritable(path, &error);
        if path.is_dir() {
            return Err(OutputError::IsDirectory { file: text_safety::path(path) });
        }
        if is_special(path) {
            let mut bytes = Vec::new();
            write(&mut bytes).map_err(failed)?;
            self.special.push((path.to_owned(), bytes));
            return Ok(());
        }
        let (stage, name, to) = self.place_of(path)?;
        if self.moves.iter().any(|other| other.stage == stage && other.name == name) {
            return Err(OutputError::Twice { file: text_safety::path(path) });
        }
        let from = self.stages[stage].new_file(&name);
        File::create_new(&from)
            .and_then(|mut file| {
                fill(&mut file, write)?;
                match fs::metadata(&to) {
                    Ok(there) => file.set_permissions(there.permissions()),
                    Err(_) => Ok(()),
                }
            })
            .map_err(failed)?;
        self.moves.push(Move { stage, name, from, to });
        Ok(())
    }

    /// As [`FileSet::add`], of contents that are at hand.
    ///
    /// # Errors
    /// As [`FileSet::add`].
    pub fn put(&mut self, path: &Path, contents: impl AsRef<[u8]>) -> Result<(), OutputError> {
        self.add(path, |file| file.write_all(contents.as_ref()))
    }

    /// Removes `path` together with the appearance of the others, where it is a file: one of an earlier run would pass
    /// for one of this.
    ///
    /// # Errors
    /// As [`FileSet::add`].
    pub fn remove(&mut self, path: &Path) -> Result<(), OutputError> {
        if !path.is_file() {
            return Ok(());
        }
        let (stage, name, from) = self.place_of(path)?;
        let to =
            self.stages[stage].gone_file(&name).map_err(|error| OutputError::unwritable(path, &error))?;
        self.moves.push(Move { stage, name, from, to });
        Ok(())
    }

    /// The stage and the name of the file that `path` stands for, a link being followed, and that file.
    fn place_of(&mut self, path: &Path) -> Result<(usize, OsString, PathBuf), OutputError> {
        let failed = |error: io::Error| OutputError::unwritable(path, &error);
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let name = target.file_name().ok_or_else(|| failed(io::ErrorKind::InvalidInput.into()))?.to_owned();
        let folder = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize().map_err(failed)?;
        let known = self.stages.iter().position(|stage| stage.folder == folder);
        let stage = match known {
            Some(stage) => stage,
            None => {
                let begun = Stage::begin(&folder).map_err(|error| error.about(path))?;
                self.stages.push(begun);
                self.stages.len() - 1
            }
        };
        let to = folder.join(&name);
        Ok((stage, name, to))
    }

    /// Gives all files their names; how many there are.
    ///
    /// # Errors
    /// [`OutputError::Unwritable`]: nothing was changed. [`OutputError::Interrupted`]: the next command that writes
    /// there completes the set.
    pub fn commit(mut self) -> Result<usize, OutputError> {
        for (path, bytes) in &self.special {
            write_special(path, |file| file.write_all(bytes))
                .map_err(|error| OutputError::unwritable(path, &error))?;
        }
        let home = self.moves.last().map(|vouching| vouching.stage);
        // A single rename needs no turn and no journal.
        let alone = self.moves.len() == 1 && !self.same_stay;
        let _turn = match home.filter(|_| !alone) {
            Some(home) => {
                let folder = &self.stages[home].folder;
                let turn = turn(folder);
                settle_here(folder)?;
                turn
            }
            None => None,
        };
        if self.same_stay {
            self.moves.retain(|file| !same(&file.from, &file.to));
        }
        let count = self.moves.len() + self.special.len();
        let Some(home) = home else { return Ok(count) };
        if self.moves.len() > 1 {
            self.decide(home)?;
        }
        let renamed = self.rename(self.moves.len());
        match renamed {
            Err((done, path, error)) if done > 0 => {
                let error = OutputError::interrupted(&path, &error);
                self.abandon();
                return Err(error);
            }
            // The journal goes before the new files do: it must never be without them.
            _ => self.stages[home].retire(),
        }
        renamed.map_err(|(_, path, error)| OutputError::unwritable(&path, &error))?;
        self.made.0.clear();
        Ok(count)
    }

    /// From here on the set is complete, or will be completed by the next command.
    fn decide(&self, home: usize) -> Result<(), OutputError> {
        let others = self.stages.iter().enumerate().filter(|(at, _)| *at != home);
        let stage = &self.stages[home];
        let decided = stage.decide(&others.map(|(_, stage)| stage).collect::<Vec<_>>());
        decided.map_err(|error| OutputError::unwritable(&stage.folder, &error))
    }

    /// Gives so many of the files their names; otherwise how many have theirs, and the one that has not.
    fn rename(&self, count: usize) -> Result<(), (usize, PathBuf, io::Error)> {
        for (done, file) in self.moves[..count].iter().enumerate() {
            fs::rename(&file.from, &file.to).map_err(|error| (done, file.to.clone(), error))?;
        }
        Ok(())
    }

    /// Leaves everything as it stands, as a program does that dies.
    fn abandon(mut self) {
        self.stages.drain(..).for_each(Stage::abandon);
        self.made.0.clear();
    }
}

/// Whether both files are there with the same contents.
fn same(a: &Path, b: &Path) -> bool {
    fs::read(a).is_ok_and(|a| fs::read(b).is_ok_and(|b| a == b))
}

/// Folders that were made, in this order; dropped, those that are empty vanish.
#[derive(Default)]
struct Made(Vec<PathBuf>);

impl Drop for Made {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::interrupted;
    use super::*;

    /// A folder with old files, and a set that replaces two of them, removes one and makes one elsewhere.
    fn scene() -> (tempfile::TempDir, FileSet) {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir(root.path().join("c")).unwrap();
        for (name, text) in OLD {
            fs::write(root.path().join(name), text).unwrap();
        }
        let mut set = FileSet::new();
        set.remove(&root.path().join("stale")).unwrap();
        set.put(&root.path().join("c/source"), "new").unwrap();
        set.put(&root.path().join("c/header"), "new").unwrap();
        set.put(&root.path().join("certificate"), "new").unwrap();
        (root, set)
    }

    const OLD: [(&str, &str); 3] = [("certificate", "old"), ("c/source", "old"), ("stale", "old")];
    const NEW: [(&str, &str); 3] = [("certificate", "new"), ("c/header", "new"), ("c/source", "new")];

    /// All files below a folder with their contents.
    fn files(folder: &Path) -> Vec<(String, String)> {
        let mut found = Vec::new();
        let mut pending = vec![folder.to_owned()];
        while let Some(next) = pending.pop() {
            for path in fs::read_dir(&next).unwrap().map(|entry| entry.unwrap().path()) {
                match path.is_dir() {
                    true => pending.push(path),
                    false => {
                        let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                        found.push((name, fs::read_to_string(&path).unwrap()));
                    }
                }
            }
        }
        found.sort();
        found
    }

    fn assert_files(folder: &Path, expected: &[(&str, &str)]) {
        let mut expected: Vec<_> = expected.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
        expected.sort();
        assert_eq!(files(folder), expected);
    }

    #[test]
    fn a_set_appears_when_it_is_committed_and_not_before() {
        let (root, set) = scene();
        drop(set);
        assert_files(root.path(), &OLD);
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 3);
        let (root, set) = scene();
        assert_eq!(set.commit().unwrap(), 4);
        assert_files(root.path(), &NEW);
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);
    }

    /// Death after each of the renames, before and after the decision; completed from the folder of the journal, and
    /// from the other one.
    #[test]
    fn a_program_that_dies_leaves_the_old_set_or_one_that_the_next_completes() {
        let next = |folder: PathBuf| FileSet::new().place_of(&folder.join("x")).map(drop).unwrap();
        for from in ["", "c"] {
            let (root, set) = scene();
            set.abandon();
            assert_eq!(interrupted(root.path()), None);
            [".", "c"].iter().for_each(|folder| next(root.path().join(folder)));
            assert_files(root.path(), &OLD);
            for dead_after in 0..=4 {
                let (root, set) = scene();
                set.decide(set.moves.last().unwrap().stage).unwrap();
                set.rename(dead_after).unwrap();
                set.abandon();
                assert!(interrupted(root.path()).is_some() && interrupted(&root.path().join("c")).is_some());
                next(root.path().join(from));
                assert_files(root.path(), &NEW);
                assert_eq!(interrupted(root.path()), None);
            }
        }
    }

    #[test]
    fn a_program_that_lives_is_left_alone() {
        let (root, set) = scene();
        let mut other = FileSet::new();
        other.put(&root.path().join("other"), "text").unwrap();
        other.commit().unwrap();
        set.commit().unwrap();
        assert_files(root.path(), &[&NEW[..], &[("other", "text")]].concat());
    }

    #[test]
    fn a_set_that_fails_leaves_no_folder_and_changes_nothing() {
        let (root, mut set) = scene();
        set.folder(&root.path().join("a/b")).unwrap();
        set.put(&root.path().join("a/b/file"), "new").unwrap();
        let full = set.add(&root.path().join("last"), |_| Err(io::ErrorKind::StorageFull.into()));
        assert!(matches!(full, Err(OutputError::Unwritable { .. })));
        drop(set);
        assert_files(root.path(), &OLD);
        assert!(!root.path().join("a").exists());
    }

    #[test]
    fn the_same_name_twice_is_refused_and_the_same_contents_stay() {
        let (root, mut set) = scene();
        assert!(matches!(set.put(&root.path().join("certificate"), ""), Err(OutputError::Twice { .. })));
        drop(set);
        let mut set = FileSet::new().same_stay();
        for name in ["certificate", "c/source"] {
            set.put(&root.path().join(name), "old").unwrap();
        }
        set.put(&root.path().join("further"), "new").unwrap();
        assert_eq!(set.commit().unwrap(), 1);
    }

    /// A file that cannot be replaced stops the set; once it can, the next command completes it.
    #[test]
    fn a_rename_that_fails_is_made_up_for_later() {
        let (root, set) = scene();
        let header = root.path().join("c/header");
        fs::create_dir_all(header.join("in the way")).unwrap();
        assert!(matches!(set.commit(), Err(OutputError::Interrupted { .. })));
        assert!(matches!(
            FileSet::new().put(&root.path().join("x"), ""),
            Err(OutputError::Interrupted { .. })
        ));
        fs::remove_dir_all(header).unwrap();
        let mut next = FileSet::new();
        next.put(&root.path().join("x"), "").unwrap();
        assert_files(root.path().join("c").as_path(), &[("header", "new"), ("source", "new")]);
    }
}
