//! Writing what was generated, all or nothing, and comparing it with what is there.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use fitter::output::{FileSet, OutputError, interrupted};
use fitter::text_safety;

/// The file that vouches for the others: it appears last.
const CERTIFICATE: &str = "certificate.json";

/// Writes `files` (paths relative to `folder`) as a set; folders are made. A file that is the same already is left
/// alone. Returns how many were changed.
///
/// # Errors
/// [`OutputError`] where a folder or file cannot be written.
pub fn write<T: AsRef<[u8]>>(folder: &Path, files: &BTreeMap<PathBuf, T>) -> Result<usize, OutputError> {
    let mut set = FileSet::new().same_stay();
    let (last, first): (Vec<_>, Vec<_>) = files.iter().partition(|(name, _)| *name == Path::new(CERTIFICATE));
    for (name, contents) in first.into_iter().chain(last) {
        let path = folder.join(name);
        set.folder(path.parent().unwrap_or(folder))?;
        set.put(&path, contents)?;
    }
    set.commit()
}

/// Most characters of a line that is shown.
const LONGEST_LINE: usize = 400;

/// How a file on disk differs from what would be generated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Difference {
    /// It is not there.
    #[error("is missing")]
    Missing,
    /// A program was interrupted here while it replaced the files: the folder that it left, with the rest of them.
    #[error("holds files that an interrupted run had yet to put in their places")]
    Interrupted,
    /// It has other lines: the first one's number and text, found and expected, and how many differ.
    #[error(
        "differs in {count} lines, first in line {first}:\n    found    {found}\n    expected {expected}"
    )]
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
                    text_safety::line(text.unwrap_or("(end of file)").trim(), LONGEST_LINE)
                };
                first.get_or_insert((number, line(left), line(right)));
            }
        }
        let (first, found, expected) = first.unwrap_or_default();
        Some((name.clone(), Difference::Lines { first, found, expected, count }))
    };
    let left = interrupted(folder).map(|left| (left.file_name().map(PathBuf::from), Difference::Interrupted));
    let left = left.map(|(name, difference)| (name.unwrap_or_default(), difference));
    files.iter().filter_map(difference).chain(left).collect()
}
