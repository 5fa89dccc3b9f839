//! What a user chooses for a fleet, and the hash by which results of another choice are told from these.

use std::path::{Path, PathBuf};

use diagnosis::Options;
use diagnosis::observe::Wanted;
use fitter::Mirror;
use fitter::recording::Mapping;

use super::answer::Asked;
use super::manifest::hash;
use crate::diagnose::declared;
use crate::terminal::Result;

/// See the module.
#[derive(Default)]
pub struct Choice {
    /// The file of the nominal mirror.
    pub mirror: PathBuf,
    /// The file of effects of the user's own.
    pub effects: Option<PathBuf>,
    /// Columns under other names.
    pub mappings: Vec<Mapping>,
    /// Effects that are left out.
    pub without: Vec<String>,
    /// Most harmonics of a periodic error.
    pub harmonics: Option<usize>,
    /// Order of the base.
    pub order: Option<usize>,
    /// Harmonics of a whole turn in the base.
    pub turn_harmonics: Option<usize>,
    /// The columns of a dataset that hold unit, lot and time.
    pub columns: [Option<String>; 3],
}

impl Choice {
    /// Reads the files.
    ///
    /// # Errors
    /// Of a file that cannot be read, or effects that are not known.
    pub fn asked(&self) -> Result<Asked> {
        let mirror = Mirror::read(&self.mirror)?;
        let options = Options {
            declared: declared(&mirror.sensor, self.effects.as_deref(), &self.without)?,
            skip: self.without.clone(),
            base: Wanted { order: self.order, turn_harmonics: self.turn_harmonics },
            harmonics: self.harmonics,
            forced: true,
            command: "fleet".into(),
        };
        Ok(Asked { mirror, mappings: self.mappings.clone(), options })
    }

    /// The SHA-256 of everything that an answer depends on beside the recording and the program.
    ///
    /// # Errors
    /// Of a file that cannot be read.
    pub fn hashed(&self) -> Result<String> {
        let file = |path: &Path| std::fs::read(path).map(|bytes| hash(&bytes));
        let said = serde_json::json!({
            "mirror": file(&self.mirror)?,
            "effects": self.effects.as_deref().map(file).transpose()?,
            "map": self.mappings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "without": self.without,
            "harmonics": self.harmonics,
            "order": self.order,
            "turn_harmonics": self.turn_harmonics,
            "columns": self.columns,
        });
        Ok(hash(said.to_string().as_bytes()))
    }
}
