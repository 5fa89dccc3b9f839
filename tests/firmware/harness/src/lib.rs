//! Generated routines as firmware: built in C and Rust for Cortex-M0, M3, M4F, M7 and M33, run under QEMU, their outputs
//! held against the host's by a digest, their instructions, flash and stack counted and compared with a
//! committed table.
//!
//! [`cases`] says what is generated, [`subject`] generates it, [`build`] compiles firmware around it,
//! [`machine`] runs that, [`measure`] does all this for every case, [`table`] keeps the figures, and
//! [`comparison`] sets them beside what engineers write otherwise.

use std::path::Path;

use indicatif::ProgressBar;

pub mod build;
pub mod cases;
pub mod comparison;
pub mod machine;
pub mod measure;
pub mod problem;
pub mod run;
pub mod subject;
pub mod table;
pub mod tools;

use machine::Core;
use measure::{Extent, Part};
use problem::Problem;
use table::Table;

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Digests of a part of all inputs, figures and comparison against the committed ones.
    Check,
    /// Digests of all inputs, or of a part of them, on Cortex-M4F.
    Exhaustive(Part),
    /// Writes the table of figures and, where all cases are measured, the comparison.
    Record,
    /// Writes the comparison.
    Compare,
}

/// Does it for the cases that have `only` in their name, or are called so,, in `work` or a temporary folder; gives what to say.
///
/// # Errors
/// The first [`Problem`] that was met.
pub fn perform(task: Task, only: &str, work: Option<&Path>, bar: &ProgressBar) -> Result<String, Problem> {
    let temporary = tempfile::tempdir().map_err(Problem::file(std::env::temp_dir()))?;
    let work = work.unwrap_or(temporary.path());
    std::fs::create_dir_all(work).map_err(Problem::file(work))?;
    let work = &work.canonicalize().map_err(Problem::file(work))?;
    if task == Task::Compare {
        return compare(work);
    }
    let mut cases = cases::all()?;
    let is_name = cases.iter().any(|case| case.name == only);
    cases.retain(|case| if is_name { case.name == only } else { case.name.contains(only) });
    if cases.is_empty() {
        let message = format!("no case has {only:?} in its name");
        return Err(Problem::Content { path: "tests/firmware/cases.toml".into(), message });
    }
    let is_part = !only.is_empty();
    match task {
        Task::Record => {
            let found = measure::all(&cases, &Core::ALL, Extent::None, work, bar)?;
            found.merge_into(&Table::path(), is_part)?;
            let said = format!("tests/firmware/instructions.json: {} cases measured", cases.len());
            if is_part {
                return Ok(said);
            }
            bar.set_message("comparing with what is written otherwise");
            Ok(format!("{said}\n{}", compare(work)?))
        }
        Task::Exhaustive(part) => {
            measure::all(&cases, &[Core::M4f], Extent::Exhaustive(part), work, bar)?;
            let Part { which, of } = part;
            let what = if of == 1 { "all".into() } else { format!("part {which} of {of} of all") };
            Ok(format!("{} cases: {what} 2^32 outputs on Cortex-M4F as on the host", cases.len()))
        }
        Task::Check | Task::Compare => {
            let committed = Table::read(&Table::path())?;
            let found = measure::all(&cases, &Core::ALL, Extent::Quick, work, bar)?;
            let verdict = committed.compare(&found, is_part)?;
            if !is_part {
                bar.set_message("comparing with what is written otherwise");
                let same = found.other_compilers(&committed).is_empty();
                comparison::page::check(&comparison::measure(work)?, same)?;
            }
            Ok(verdict)
        }
    }
}

/// Writes the comparison.
fn compare(work: &Path) -> Result<String, Problem> {
    let rows = comparison::measure(work)?;
    comparison::page::write(&rows)?;
    let lost = comparison::page::unbeaten(&rows);
    Ok(format!("tests/firmware/comparison.json and docs/comparison.md written\n{}", lost.join("\n")))
}
