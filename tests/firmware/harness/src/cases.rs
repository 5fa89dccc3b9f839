//! The list of what is generated: `tests/firmware/cases.toml`.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::machine::Core;
use crate::problem::Problem;

/// One call of codegen that makes one routine.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name in the table of figures.
    pub name: String,
    /// Which device; none for the default recording's.
    #[serde(default)]
    pub coefficients: Option<Device>,
    /// Further options of codegen.
    pub options: Vec<String>,
    /// The cores that it is for; none: all.
    #[serde(default)]
    cores: Vec<Core>,
}

impl Case {
    /// A case for every core.
    pub fn new(name: &str, coefficients: Option<Device>, options: Vec<String>) -> Case {
        Case { name: name.into(), coefficients, options, cores: Vec::new() }
    }

    /// Whether it is measured on this core.
    pub fn is_for(&self, core: Core) -> bool {
        self.cores.is_empty() || self.cores.contains(&core)
    }
}

/// A device that stands here by its coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Device {
    /// Eq. 12, |s| ≤ 0.38 mm.
    Paper,
    /// The same with a drift of zero and gain by temperature, and hysteresis of three plays.
    #[serde(rename = "paper-with-terms")]
    PaperWithTerms,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    case: Vec<Case>,
}

/// `tests/firmware`.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All cases.
///
/// # Errors
/// [`Problem`] where the file is not as it should be.
pub fn all() -> Result<Vec<Case>, Problem> {
    let path = folder().join("cases.toml");
    let text = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let file: File =
        toml::from_str(&text).map_err(|e| Problem::Content { path: path.clone(), message: e.to_string() })?;
    Ok(file.case)
}
