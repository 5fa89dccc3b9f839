//! `manifest.json` of the results: what was asked, and which parts are finished. It is written together with each part, so
//! that after a kill a part is there whole and listed, or not at all.

use std::path::{Path, PathBuf};

use codegen::refused;
use fitter::text_safety;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::table::PROGRAM;
use crate::terminal::Result;

/// Its name.
pub const FILE: &str = "manifest.json";

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the format.
    pub schema: u32,
    /// Name and version of the program.
    pub program: String,
    /// SHA-256 of everything that was asked.
    pub options: String,
    /// SHA-256 of the names of units and files, with lots and times.
    pub data: String,
    /// Number of units.
    pub units: usize,
    /// Units of a part.
    pub units_of_part: usize,
    /// The parts, in their order; none of one that is not finished.
    pub parts: Vec<Option<Part>>,
}

/// A finished part: the SHA-256 of its files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Of `units/part-….parquet`.
    pub units: String,
    /// Of `parameters/part-….parquet`.
    pub parameters: String,
}

impl Manifest {
    /// That of a run of which no part is finished.
    pub fn new(options: String, data: String, units: usize, units_of_part: usize) -> Manifest {
        let parts = vec![None; units.div_ceil(units_of_part)];
        Manifest { schema: 1, program: PROGRAM.into(), options, data, units, units_of_part, parts }
    }

    /// That of a folder; none where there is none.
    pub fn read(out: &Path) -> Result<Option<Manifest>> {
        let path = out.join(FILE);
        if !path.exists() {
            return Ok(None);
        }
        let text = fitter::input::parsed(&path, "the manifest of a fleet")?;
        let read = serde_json::from_str(&text);
        read.map(Some).map_err(|error| {
            refused!("is no manifest of a fleet ({error})")
                .at(&path)
                .mend("write the results into another folder")
        })
    }

    /// What another run left, to be continued by this one, of which no part is finished yet.
    pub fn continued(self, out: &Path) -> Result<Manifest> {
        let Some(before) = Manifest::read(out)? else { return Ok(self) };
        let mix = "results of another version or other options cannot be mixed";
        let other = |what: &str, found: &str, expected: &str| {
            refused!("{mix}: {what}")
                .at(&out.join(FILE))
                .found(found)
                .expected(expected)
                .mend("give the same as before, or write into another folder")
        };
        if before.program != self.program {
            return Err(other("the program", &before.program, &self.program));
        }
        if before.options != self.options {
            return Err(other("the options", &before.options, &self.options));
        }
        if (&before.data, before.units, before.units_of_part) != (&self.data, self.units, self.units_of_part)
            || before.parts.len() != self.parts.len()
        {
            let [found, expected] = [&before, &self].map(|one| format!("{} units", one.units));
            return Err(other(
                "the data holds other units than when the results were begun",
                &found,
                &expected,
            ));
        }
        before.with_parts_that_are_there(out)
    }

    /// Forgets parts whose files are gone; refuses those that are not what was written.
    pub fn with_parts_that_are_there(mut self, out: &Path) -> Result<Manifest> {
        for (number, part) in self.parts.iter_mut().enumerate() {
            let Some(Part { units, parameters }) = part else { continue };
            let paths = paths(out, number);
            if paths.iter().any(|path| !path.exists()) {
                *part = None;
                continue;
            }
            for (path, expected) in paths.iter().zip([units, parameters]) {
                let found = hash(&std::fs::read(path)?);
                if found != *expected {
                    return Err(refused!("is damaged: its SHA-256")
                        .at(&text_safety::path(path))
                        .found(found)
                        .expected(expected)
                        .mend("delete it, and --resume makes it again"));
                }
            }
        }
        Ok(self)
    }
}

/// The files of a part: of units, of parameters.
pub fn paths(out: &Path, part: usize) -> [PathBuf; 2] {
    ["units", "parameters"].map(|table| out.join(table).join(format!("part-{part:05}.parquet")))
}

/// SHA-256, hexadecimal.
pub fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
