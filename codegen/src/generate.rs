//! From coefficients and options to a set of files: the Rust crate, the C pair and the certificate.

use std::collections::BTreeMap;
use std::path::PathBuf;

use fitter::coefficients::Coefficients;
use minijinja::value::Serde;
use minijinja::{Value, context};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use crate::accepted::{NotAccepted, accepted};
use crate::certificate::{self, Certificate, Entry};
use crate::gappa;
use crate::name;
use crate::options::{CShift, Options};
use crate::quantity::Quantity;
use crate::render::{RenderError, Renderer, View};
use crate::routine::{self, Routine, RoutineError};
use crate::turn::{self, TurnError};

/// Program and version, as the heads of the files name it.
pub const TOOL: &str = concat!("codegen ", env!("CARGO_PKG_VERSION"));

/// What was generated: nothing is written yet.
#[derive(Debug, Clone)]
pub struct Generated {
    /// Base name of crate, files and functions.
    pub name: String,
    /// Contents by path, relative to the output folder.
    pub files: BTreeMap<PathBuf, String>,
    /// The certificate, which is also among the files.
    pub certificate: Certificate,
    /// The routines as designed.
    pub routines: Vec<Routine>,
    /// Why the routines of usual formats are missing that no degree brings within the bound.
    pub unreachable: Vec<RoutineError>,
}

impl Generated {
    /// The Rust routines as one module that a firmware includes, where a crate of its own is not wanted. A single
    /// routine also goes by the base name alone, whatever format was chosen.
    ///
    /// # Errors
    /// [`GenerateError::Render`] for a defect of the template.
    pub fn module(&self) -> Result<String, GenerateError> {
        let sources = self.files.iter().filter(|(path, _)| path.starts_with("src"));
        let modules: Vec<Value> = sources
            .filter_map(|(path, text)| {
                let name = path.file_stem()?.to_str().filter(|name| *name != "lib")?;
                Some(context! { name, text })
            })
            .collect();
        Ok(Renderer::new()?.render("rust/module.rs", context! { name => &*self.name, modules })?)
    }
}

/// Why nothing was generated.
#[derive(Debug, thiserror::Error)]
pub enum GenerateError {
    /// The coefficients.
    #[error(transparent)]
    NotAccepted(#[from] NotAccepted),
    /// A routine could not be designed.
    #[error(transparent)]
    Routine(#[from] RoutineError),
    /// A name that no source can carry.
    #[error(
        "{what} {name:?} is not an identifier: give letters, digits and underscores, a letter first, and no keyword of C or Rust"
    )]
    Name {
        /// What the name is for.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A name that already means something.
    #[error("--name {name}: this is {why}; give another name")]
    ReservedName {
        /// The name.
        name: String,
        /// What it means.
        why: &'static str,
    },
    /// The routine of a sensor that turns round and round.
    #[error(transparent)]
    Turn(#[from] TurnError),
    /// Two routines would have one name.
    #[error("{0} is asked for twice: each format and table gives one routine")]
    Twice(String),
    /// Fused multiply–add has no portable name in `no_std` Rust.
    #[error("f32-fma cannot be generated: `core` has no fused multiply-add; use f32")]
    NoFusedInRust,
    /// A defect of a template.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A defect of serialisation.
    #[error("the certificate cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// SHA-256 in hexadecimal.
pub fn sha256(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Generates all files for `coefficients`; `coefficients_sha256` is that of their file.
///
/// # Errors
/// [`GenerateError`], which says what to change.
pub fn generate(
    coefficients: &Coefficients,
    coefficients_sha256: &str,
    options: &Options,
) -> Result<Generated, GenerateError> {
    let reservation = accepted(coefficients, options)?;
    if coefficients.whole_turn() {
        return turn::generate(coefficients, coefficients_sha256, options);
    }
    let quantity = Quantity::of(&routine::model(coefficients, options));
    if !name::is_identifier(&quantity.unit) {
        return Err(GenerateError::Name { what: "the sensor's unit", name: quantity.unit.clone() });
    }
    let name = name::base(options, &quantity.default_name)?;
    for (i, r) in options.routines.iter().enumerate() {
        if options.routines[..i].iter().any(|other| other.suffix() == r.suffix()) {
            return Err(GenerateError::Twice(r.suffix()));
        }
        if r.format == (crate::format::Format::F32 { fused: true }) {
            return Err(GenerateError::NoFusedInRust);
        }
    }
    let (routines, unreachable) = designed(coefficients, options)?;

    let renderer = Renderer::new()?;
    let provenance = renderer.provenance(coefficients, coefficients_sha256, options)?;
    let mut files = BTreeMap::new();
    let mut described: Vec<(Entry, View)> = Vec::new();
    for routine in &routines {
        let function = format!("{name}_{}", routine.options.suffix());
        let entry = certificate::entry(routine, &function, &quantity, options, coefficients);
        let view = renderer.view(routine, &entry, &quantity, options)?;
        if let Some(script) = gappa::script(&renderer, routine, &function, &provenance)? {
            files.insert(PathBuf::from(format!("gappa/{function}.g")), script);
        }
        described.push((entry, view));
    }
    described.sort_by(|(_, a), (_, b)| a.name().cmp(b.name()));
    let views: Vec<&View> = described.iter().map(|(_, view)| view).collect();
    let all = Value::from(Serde(&views));
    let common = || context! { tool => TOOL, name => &*name, description => &*quantity.title, provenance => &*provenance, routines => all.clone() };
    files.insert(PathBuf::from("Cargo.toml"), renderer.render("rust/Cargo.toml", common())?);
    files.insert(PathBuf::from("src/lib.rs"), renderer.render("rust/lib.rs", common())?);
    for view in &views {
        let context = context! { provenance => &*provenance, contract => view.contract(), routine => Value::from(Serde(view)) };
        let path = PathBuf::from(format!("src/{}.rs", view.name()));
        files.insert(path, renderer.render("rust/routine.rs", context)?);
    }
    let mut helpers: Vec<&str> = Vec::new();
    for helper in views.iter().flat_map(|view| view.helpers()) {
        if !helpers.contains(helper) {
            helpers.push(helper);
        }
    }
    // What others rest on comes first.
    helpers.sort_by_key(|helper| !matches!(*helper, "float_guard" | "shift_right"));
    let (header, guard) = (format!("{name}.h"), format!("{}_H", name.to_uppercase()));
    let c = || {
        context! {
            provenance => &*provenance, routines => all.clone(), header => &*header, guard => &*guard,
            helpers => helpers.clone(), uses_fmaf => false,
        arithmetic_shift => options.c_shift == CShift::Arithmetic,
        }
    };
    files.insert(PathBuf::from(format!("c/{name}.h")), renderer.render("c/header.h", c())?);
    files.insert(PathBuf::from(format!("c/{name}.c")), renderer.render("c/source.c", c())?);

    let mut entries = Vec::new();
    for (entry, view) in &described {
        for (language, file) in [("rust", format!("src/{}.rs", view.name())), ("c", format!("c/{name}.c"))] {
            let file_sha256 = files.get(&PathBuf::from(&file)).map(|text| sha256(text)).unwrap_or_default();
            entries.push(Entry { language: language.into(), file, file_sha256, ..entry.clone() });
        }
    }
    let certificate = Certificate {
        schema: "arcsmith-certificate".into(),
        version: 1,
        tool: TOOL.into(),
        command: options.command.clone(),
        coefficients_sha256: coefficients_sha256.into(),
        recording: coefficients.recording.file.clone(),
        recording_sha256: coefficients.recording.sha256.clone(),
        reservation,
        routines: entries,
    };
    files.insert(PathBuf::from("certificate.json"), serde_json::to_string_pretty(&certificate)? + "\n");
    Ok(Generated { name, files, certificate, routines, unreachable })
}

/// The routines that are wanted, and why those are missing that may be left out.
fn designed(
    coefficients: &Coefficients,
    options: &Options,
) -> Result<(Vec<Routine>, Vec<RoutineError>), RoutineError> {
    let designed: Vec<Result<Routine, RoutineError>> =
        options.routines.par_iter().map(|wanted| routine::design(coefficients, options, wanted)).collect();
    let some = designed.iter().any(Result::is_ok);
    let (mut routines, mut unreachable) = (Vec::new(), Vec::new());
    for design in designed {
        match design {
            Ok(routine) => routines.push(routine),
            Err(error @ RoutineError::Unreachable { .. }) if some && options.leave_out_unreachable => {
                unreachable.push(error);
            }
            Err(error) => return Err(error),
        }
    }
    Ok((routines, unreachable))
}
