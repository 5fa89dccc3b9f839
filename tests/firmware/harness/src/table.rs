//! The committed figures, `tests/firmware/instructions.json`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::machine::Core;
use crate::problem::Problem;
use crate::tools;

/// What one routine costs on one core as one compiler translates it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Figures {
    /// Fewest and most instructions for readings inside the range, without call and return.
    pub inside: [u64; 2],
    /// The same for any readings.
    pub anywhere: [u64; 2],
    /// What the routine adds to the firmware, with all that it calls.
    pub flash_bytes: u64,
    /// What it takes of the stack.
    pub stack_bytes: u64,
    /// What it keeps from call to call.
    #[serde(default, skip_serializing_if = "nothing")]
    pub ram_bytes: u64,
}

fn nothing(bytes: &u64) -> bool {
    *bytes == 0
}

/// Case, core, variant.
type Routines = BTreeMap<String, BTreeMap<Core, BTreeMap<String, Figures>>>;

/// All figures.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Table {
    /// What the figures are, for the reader.
    pub about: String,
    /// The compilers that made them, by program.
    pub compilers: BTreeMap<String, String>,
    /// Case, core, variant.
    pub routines: Routines,
}

const ABOUT: &str = "Counted by tests/firmware under QEMU: instructions of a call, fewest and most, without call and return; flash \
     and stack in bytes. Written by `cargo run --release -p firmware-tests -- record`.";

impl Table {
    /// A table of this machine's compilers, without figures.
    ///
    /// # Errors
    /// [`Problem`] where a compiler does not tell its version.
    pub fn empty() -> Result<Self, Problem> {
        Ok(Table {
            about: ABOUT.split_whitespace().collect::<Vec<_>>().join(" "),
            compilers: tools::versions()?.into_iter().collect(),
            routines: BTreeMap::new(),
        })
    }

    /// Where it is kept.
    pub fn path() -> PathBuf {
        crate::cases::folder().join("instructions.json")
    }

    /// Enters figures.
    pub fn insert(&mut self, case: &str, core: Core, variant: &str, figures: Figures) {
        let cores = self.routines.entry(case.into()).or_default();
        cores.entry(core).or_default().insert(variant.into(), figures);
    }

    /// Figures of a case.
    pub fn get(&self, case: &str, core: Core, variant: &str) -> Option<&Figures> {
        self.routines.get(case)?.get(&core)?.get(variant)
    }

    /// Reads the committed one.
    ///
    /// # Errors
    /// [`Problem`] where it cannot be read.
    pub fn read(path: &Path) -> Result<Self, Problem> {
        let text = std::fs::read_to_string(path).map_err(Problem::file(path))?;
        serde_json::from_str(&text)
            .map_err(|e| Problem::Content { path: path.into(), message: e.to_string() })
    }

    /// Writes it.
    ///
    /// # Errors
    /// [`Problem::File`] where it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Problem> {
        write_json(path, self)
    }

    /// Writes it to `path`; where it holds a part of the cases only, the others there stay as they are.
    ///
    /// # Errors
    /// [`Problem`] where the file cannot be read or written, or was made by other compilers.
    pub fn merge_into(mut self, path: &Path, is_part: bool) -> Result<(), Problem> {
        if is_part {
            let before = Table::read(path)?;
            let other = self.other_compilers(&before);
            if !other.is_empty() {
                return Err(Problem::Figures(format!(
                    "record all cases, the compilers changed: {}",
                    other.join("; ")
                )));
            }
            for (case, cores) in before.routines {
                self.routines.entry(case).or_insert(cores);
            }
        }
        self.write(path)
    }

    /// Holds `found` against this table; `is_part`: only some of the cases were measured. Figures of a compiler
    /// that is another version than the table's are left out. Gives what to say.
    ///
    /// # Errors
    /// [`Problem::Figures`] where the same compilers gave other figures.
    pub fn compare(&self, found: &Table, is_part: bool) -> Result<String, Problem> {
        let differences = self.differences(found, is_part);
        if !differences.is_empty() {
            let again = "where that is meant: cargo run --release -p firmware-tests -- record";
            return Err(Problem::Figures(format!(
                "figures differ from tests/firmware/instructions.json\n{}\n{again}",
                differences.join("\n")
            )));
        }
        let said = format!("{} cases: outputs as on the host, figures as in the table", found.routines.len());
        let other = found.other_compilers(self);
        if other.is_empty() {
            return Ok(said);
        }
        Ok(format!("{said}, except for those of another compiler, NOT COMPARED: {}", other.join("; ")))
    }

    /// What of `found` differs from this table, a line each.
    fn differences(&self, found: &Table, is_part: bool) -> Vec<String> {
        let mut lines = Vec::new();
        // By how a variant's name begins.
        let is_other = |program: &str| found.compilers.get(program) != self.compilers.get(program);
        let by = [("C gcc", "arm-none-eabi-gcc"), ("C clang", "clang"), ("Rust", "rustc")];
        let left_out: Vec<&str> = by.iter().filter(|(_, p)| is_other(p)).map(|(name, _)| *name).collect();
        for (case, cores) in &found.routines {
            for (core, variants) in cores {
                let compared = |(variant, _): &(&String, &Figures)| {
                    !left_out.iter().any(|name| variant.starts_with(name))
                };
                for (variant, now) in variants.iter().filter(compared) {
                    let what = format!("{case}, {}, {variant}", core.name());
                    match self.get(case, *core, variant) {
                        None => lines.push(format!("{what}: not in the table")),
                        Some(before) if before != now => {
                            lines.push(format!("{what}: {}", change(before, now)))
                        }
                        Some(_) => {}
                    }
                }
            }
        }
        let known = |case: &String| is_part || found.routines.contains_key(case);
        let gone = self.routines.keys().filter(|case| !known(case));
        lines.extend(gone.map(|case| format!("{case}: in the table, but no longer among the cases")));
        lines
    }

    /// Compilers that are not those of `other`, a line each.
    pub fn other_compilers(&self, other: &Table) -> Vec<String> {
        let differs = |(program, here): (&String, &String)| {
            let there = other.compilers.get(program);
            (there != Some(here))
                .then(|| format!("{program}: {here}, in the table {}", there.map_or("none", |t| t)))
        };
        self.compilers.iter().filter_map(differs).collect()
    }
}

fn change(before: &Figures, now: &Figures) -> String {
    let range = |[fewest, most]: [u64; 2]| {
        if fewest == most { most.to_string() } else { format!("{fewest} to {most}") }
    };
    let rows = [
        ("instructions inside the range", range(before.inside), range(now.inside)),
        ("instructions anywhere", range(before.anywhere), range(now.anywhere)),
        ("bytes of flash", before.flash_bytes.to_string(), now.flash_bytes.to_string()),
        ("bytes of stack", before.stack_bytes.to_string(), now.stack_bytes.to_string()),
        ("bytes kept", before.ram_bytes.to_string(), now.ram_bytes.to_string()),
    ];
    let changed = rows.iter().filter(|(_, before, now)| before != now);
    changed.map(|(what, before, now)| format!("{now} {what}, were {before}")).collect::<Vec<_>>().join("; ")
}

/// Writes JSON that people read, through a neighbour that is renamed.
///
/// # Errors
/// [`Problem::File`] where it cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Problem> {
    let mut text = serde_json::to_string_pretty(value)
        .map_err(|e| Problem::Content { path: path.into(), message: e.to_string() })?;
    text.push('\n');
    write_text(path, &text)
}

/// Writes text through a neighbour that is renamed.
///
/// # Errors
/// [`Problem::File`] where it cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<(), Problem> {
    let neighbour = path.with_extension("tmp");
    std::fs::write(&neighbour, text).map_err(Problem::file(&neighbour))?;
    std::fs::rename(&neighbour, path).map_err(Problem::file(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(flash_bytes: u64, gcc: &str) -> Table {
        let mut table = Table {
            about: String::new(),
            compilers: BTreeMap::from([("arm-none-eabi-gcc".to_string(), gcc.to_string())]),
            routines: BTreeMap::new(),
        };
        let figures =
            Figures { inside: [28, 28], anywhere: [28, 29], flash_bytes, stack_bytes: 0, ram_bytes: 0 };
        table.insert("case", Core::M4f, "C gcc strict", figures);
        table
    }

    #[test]
    fn a_figure_that_differs_is_named() {
        let problem = table(100, "12").compare(&table(104, "12"), false).unwrap_err().to_string();
        assert!(problem.contains("case, m4f, C gcc strict: 104 bytes of flash, were 100"), "{problem}");
        table(100, "12").compare(&table(100, "12"), false).unwrap();
    }

    #[test]
    fn figures_of_another_compiler_are_left_out_and_that_is_said() {
        let said = table(100, "12").compare(&table(104, "13"), false).unwrap();
        assert!(said.contains("NOT COMPARED: arm-none-eabi-gcc: 13, in the table 12"), "{said}");
    }

    #[test]
    fn a_case_that_is_gone_is_named() {
        let mut found = table(100, "12");
        found.routines.clear();
        let problem = table(100, "12").compare(&found, false).unwrap_err().to_string();
        assert!(problem.contains("no longer among the cases"), "{problem}");
        table(100, "12").compare(&found, true).unwrap();
    }
}
