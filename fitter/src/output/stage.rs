//! The hidden folder `.arcsmith-…` in which new files stand ready, beside the ones that they are to replace.
//!
//! | in it | is |
//! |---|---|
//! | `lock` | locked for as long as the program lives that writes here |
//! | `new/NAME` | what `NAME` beside the hidden folder is to become |
//! | `gone/NAME` | says that `NAME` is to be removed |
//! | `set` | the journal: the set is decided; the hidden folders of the same set elsewhere, JSON |
//! | `home` | in those: the hidden folder that holds the journal |
//!
//! Names are plain, so that whatever stands in a hidden folder only ever reaches the folder around it.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::OutputError;

const PREFIX: &str = ".arcsmith-";
const LOCK: &str = "lock";
const NEW: &str = "new";
const GONE: &str = "gone";
const SET: &str = "set";
const HOME: &str = "home";

/// A hidden folder of a program that lives; dropped, it vanishes.
pub(super) struct Stage {
    /// Where the files will stand.
    pub folder: PathBuf,
    // Unlocked before the folder is removed.
    _lock: File,
    dir: tempfile::TempDir,
}

impl Stage {
    /// Makes one in `folder`, of which what dead programs left there is settled first.
    pub fn begin(folder: &Path) -> Result<Stage, OutputError> {
        settle(folder)?;
        Stage::make(folder).map_err(|error| OutputError::unwritable(folder, &error))
    }

    fn make(folder: &Path) -> io::Result<Stage> {
        // Until it is locked it looks abandoned. Whoever settles the folder has the turn; where a folder cannot be locked,
        // it may remove what is half made, and a new one is.
        let _turn = turn(folder);
        let mut tries = 0;
        loop {
            let dir = tempfile::Builder::new().prefix(PREFIX).tempdir_in(folder)?;
            let made = File::create_new(dir.path().join(LOCK)).and_then(|lock| {
                hold(&lock)?;
                fs::create_dir(dir.path().join(NEW))?;
                Ok(lock)
            });
            match made {
                Ok(lock) => return Ok(Stage { folder: folder.to_owned(), _lock: lock, dir }),
                Err(error) if tries == 3 => return Err(error),
                Err(_) => tries += 1,
            }
        }
    }

    /// Where the new contents of `name` are put together.
    pub fn new_file(&self, name: &OsStr) -> PathBuf {
        self.dir.path().join(NEW).join(name)
    }

    /// Where `name` goes that is to vanish: a place that says so.
    pub fn gone_file(&self, name: &OsStr) -> io::Result<PathBuf> {
        let gone = self.dir.path().join(GONE);
        fs::create_dir_all(&gone)?;
        let place = gone.join(name);
        File::create(&place)?;
        Ok(place)
    }

    /// Decides a set of which this is the home: from the rename of the journal on it will be completed.
    pub fn decide(&self, others: &[&Stage]) -> io::Result<()> {
        let home = serde_json::to_vec(self.dir.path().as_os_str())?;
        for other in others {
            fs::write(other.dir.path().join(HOME), &home)?;
        }
        let listed: Vec<&OsStr> = others.iter().map(|other| other.dir.path().as_os_str()).collect();
        let journal = self.dir.path().join(SET);
        fs::write(journal.with_extension(NEW), serde_json::to_vec(&listed)?)?;
        fs::rename(journal.with_extension(NEW), journal)
    }

    /// Takes the journal away again: every file has its name, or none.
    pub fn retire(&self) {
        let _ = fs::remove_file(self.dir.path().join(SET));
    }

    /// Leaves everything for the next command to complete.
    pub fn abandon(self) {
        let _ = self.dir.keep();
    }
}

/// Locks a file that shows which programs live. Where locks are unknown nobody is ever taken for dead.
fn hold(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(io::ErrorKind::WouldBlock.into()),
        Err(TryLockError::Error(_)) | Ok(()) => Ok(()),
    }
}

/// The lock of a hidden folder whose program is dead.
fn abandoned(stage: &Path) -> Option<File> {
    let lock = stage.join(LOCK);
    let mut options = OpenOptions::new();
    let opened = options.read(true).write(true).create(true).truncate(false).open(&lock);
    let file = opened.or_else(|_| File::open(&lock)).ok()?;
    file.try_lock().is_ok().then_some(file)
}

/// The hidden folders in a folder.
fn stages_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).map(|entries| entries.flatten().collect::<Vec<_>>());
    let paths = entries.unwrap_or_default().into_iter().map(|entry| entry.path());
    paths.filter(|path| is_stage(path)).collect()
}

/// Whether a path is a hidden folder, and no link to one.
fn is_stage(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX))
        && fs::symlink_metadata(path).is_ok_and(|there| there.is_dir())
}

/// The hidden folder with the journal of the decided set that `stage` belongs to.
fn journal_of(stage: &Path) -> Option<PathBuf> {
    let home = match fs::read(stage.join(HOME)) {
        Ok(text) => PathBuf::from(serde_json::from_slice::<OsString>(&text).ok()?),
        Err(_) => stage.to_owned(),
    };
    home.join(SET).is_file().then_some(home)
}

/// The hidden folder of a decided set that was interrupted while its files were replaced.
pub(super) fn interrupted(folder: &Path) -> Option<PathBuf> {
    stages_in(folder).into_iter().find(|stage| abandoned(stage).is_some() && journal_of(stage).is_some())
}

/// Lets one program after the other replace files in a folder. Where a folder cannot be locked they do not wait; nor for
/// long for whoever else has locked it, as `flock` around the very command does: replacing takes microseconds.
pub(super) fn turn(folder: &Path) -> Option<File> {
    const WAIT: (u32, Duration) = (200, Duration::from_millis(10));
    let opened = File::open(folder).ok()?;
    for _ in 0..WAIT.0 {
        match opened.try_lock() {
            Ok(()) => return Some(opened),
            Err(TryLockError::WouldBlock) => std::thread::sleep(WAIT.1),
            Err(TryLockError::Error(_)) => break,
        }
    }
    None
}

/// Completes the decided sets that dead programs left in a folder, and removes what they did not decide.
pub(super) fn settle(folder: &Path) -> Result<(), OutputError> {
    let left = stages_in(folder);
    for home in left.iter().filter_map(|stage| journal_of(stage)) {
        if let Some(elsewhere) = home.parent().filter(|parent| *parent != folder) {
            let _turn = turn(elsewhere);
            settle_here(elsewhere)?;
        }
    }
    if left.is_empty() {
        return Ok(());
    }
    let _turn = turn(folder);
    settle_here(folder)
}

/// As [`settle`], of the sets whose journal is in the folder, by whoever has the [`turn`] there.
pub(super) fn settle_here(folder: &Path) -> Result<(), OutputError> {
    for stage in stages_in(folder) {
        let Some(lock) = abandoned(&stage) else { continue };
        match journal_of(&stage) {
            Some(home) if home == stage => complete(&stage)?,
            Some(_) => continue,
            None => {}
        }
        drop(lock);
        let _ = fs::remove_dir_all(&stage);
    }
    Ok(())
}

/// Gives the files of a decided set their names.
fn complete(home: &Path) -> Result<(), OutputError> {
    let listed = fs::read(home.join(SET)).ok().and_then(|text| serde_json::from_slice(&text).ok());
    let others: Vec<OsString> = listed.unwrap_or_default();
    let others: Vec<PathBuf> = others.into_iter().map(PathBuf::from).filter(|path| is_stage(path)).collect();
    for stage in others.iter().map(PathBuf::as_path).chain([home]) {
        let Some(folder) = stage.parent() else { continue };
        for (kind, appears) in [(NEW, true), (GONE, false)] {
            let entries = fs::read_dir(stage.join(kind)).map(|entries| entries.flatten().collect::<Vec<_>>());
            for entry in entries.unwrap_or_default() {
                let (here, there) = (entry.path(), folder.join(entry.file_name()));
                let moved = if appears { fs::rename(&here, &there) } else { fs::rename(&there, &here) };
                match moved {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => {
                        return Err(OutputError::interrupted(&there, &error));
                    }
                    _ => {}
                }
            }
        }
    }
    fs::remove_file(home.join(SET)).map_err(|error| OutputError::interrupted(home, &error))?;
    for other in others {
        let _ = fs::remove_dir_all(other);
    }
    Ok(())
}
