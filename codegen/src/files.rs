//! Writing what was generated, all or nothing, and comparing it with what is there.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use fitter::text_safety;

/// The output folder cannot be written; nothing was changed.
#[derive(Debug, thiserror::Error)]
#[error("{path} cannot be written: {cause}; choose another folder with --out")]
pub struct WriteError {
    /// Which file or folder.
    pub path: String,
    /// What the system says.
    #[source]
    pub cause: io::Error,
}

/// Writes `files` (paths relative to `folder`): each to a temporary neighbour first, and only when all are
/// on disk are they renamed. A file that is the same already is left alone. Returns how many were changed.
///
/// # Errors
/// [`WriteError`] where a folder or file cannot be written.
pub fn write<T: AsRef<[u8]>>(folder: &Path, files: &BTreeMap<PathBuf, T>) -> Result<usize, WriteError> {
    let failed = |path: &Path, cause| WriteError { path: text_safety::path(path), cause };
    let mut pending = Vec::new();
    for (name, text) in files {
        let path = folder.join(name);
        if fs::read(&path).is_ok_and(|there| there == text.as_ref()) {
            continue;
        }
        let parent = path.parent().unwrap_or(folder);
        fs::create_dir_all(parent).map_err(|cause| failed(parent, cause))?;
        let mut temporary = temporary_in(parent).map_err(|cause| failed(parent, cause))?;
        temporary.write_all(text.as_ref()).map_err(|cause| failed(&path, cause))?;
        pending.push((path, temporary));
    }
    let changed = pending.len();
    for (path, temporary) in pending {
        temporary.persist(&path).map_err(|error| failed(&path, error.error))?;
    }
    Ok(changed)
}

/// A temporary neighbour that everybody may read once it has its final name.
fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".codegen-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: the user's mask takes away what it takes away.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Most characters of a line that is told.
const LONGEST_LINE: usize = 400;

/// How a file on disk differs from what would be generated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Difference {
    /// It is not there.
    Missing,
    /// It has other lines: the first one's number and text, found and expected, and how many differ.
    Lines {
        /// Number of the first line that differs, from 1.
        first: usize,
        /// What stands there.
        found: String,
        /// What should.
        expected: String,
        /// How many lines differ.
        count: usize,
    },
}

/// Compares `files` with the ones in `folder`; empty where all are the same.
pub fn compare<T: AsRef<[u8]>>(folder: &Path, files: &BTreeMap<PathBuf, T>) -> BTreeMap<PathBuf, Difference> {
    let difference = |(name, expected): (&PathBuf, &T)| {
        let expected = expected.as_ref();
        let Ok(found) = fs::read(folder.join(name)) else { return Some((name.clone(), Difference::Missing)) };
        if found == expected {
            return None;
        }
        let found = String::from_utf8_lossy(&found).into_owned();
        let expected = String::from_utf8_lossy(expected).into_owned();
        let (mut a, mut b) = (found.split('\n'), expected.split('\n'));
        let (mut first, mut count, mut number) = (None, 0, 0);
        loop {
            let (left, right) = (a.next(), b.next());
            if left.is_none() && right.is_none() {
                break;
            }
            number += 1;
            if left != right {
                count += 1;
                let line = |text: Option<&str>| {
                    text_safety::excerpt(text.unwrap_or("(end of file)").trim(), LONGEST_LINE)
                };
                first.get_or_insert((number, line(left), line(right)));
            }
        }
        let (first, found, expected) = first.unwrap_or_default();
        Some((name.clone(), Difference::Lines { first, found, expected, count }))
    };
    files.iter().filter_map(difference).collect()
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Difference::Missing => write!(f, "is missing"),
            Difference::Lines { first, found, expected, count } => {
                write!(
                    f,
                    "differs in {count} lines, first in line {first}:\n    found    {found}\n    expected {expected}"
                )
            }
        }
    }
}
