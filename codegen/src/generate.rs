//! From coefficients and options to a set of files: the sources in every language and the certificate.

use std::collections::BTreeMap;
use std::path::PathBuf;

use fitter::coefficients::Coefficients;
use minijinja::value::Serde;
use minijinja::{Value, context};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use crate::accepted::{NotAccepted, accepted};
use crate::certificate::Certificate;
use crate::describe::described;
use crate::emit::{Described, Printer};
use crate::gappa;
use crate::language::{self, Language};
use crate::name;
use crate::options::Options;
use crate::quantity::Quantity;
use crate::render::{HEAD_COLUMNS, RenderError};
use crate::routine::{self, Routine, RoutineError};
use crate::text;
use crate::turn::choose::TurnRoutine;
use crate::turn::{self, TurnError};

/// Program and version, as the heads of the files name it.
pub const TOOL: &str = concat!("codegen ", env!("CARGO_PKG_VERSION"));

/// What was generated: nothing is written yet.
#[derive(Debug, Clone)]
pub struct Generated {
    /// Base name of crate, files and functions.
    pub name: String,
    /// Names and units of what the routines compute.
    pub quantity: Quantity,
    /// Contents by path, relative to the output folder.
    pub files: BTreeMap<PathBuf, String>,
    /// The certificate, which is also among the files.
    pub certificate: Certificate,
    /// The routines as designed.
    pub routines: Vec<Routine>,
    /// That of an encoder.
    pub turn: Option<TurnRoutine>,
    /// Why the routines of usual formats are missing that no degree brings within the bound.
    pub unreachable: Vec<RoutineError>,
}

fitter::errors! {
    /// Why nothing was generated.
    #[derive(Debug)]
    pub enum GenerateError {
        Name { what: &'static str, name: String } =>
            says("{what} {name:?} is not an identifier")
            mend("give letters, digits and underscores, a letter first, and no keyword of C or Rust");
        ReservedName { name: String, why: &'static str } =>
            says("the name {name} cannot be taken: this is {why}") mend("give another name") by(name);
        Twice(it: String) => says("{it} is asked for twice: each format and table gives one routine");
    }
    from {
        NotAccepted(NotAccepted),
        Routine(RoutineError),
        Turn(TurnError),
        Render(RenderError),
        Json(serde_json::Error),
    }
}

/// SHA-256 in hexadecimal.
pub fn sha256(contents: impl AsRef<[u8]>) -> String {
    Sha256::digest(contents).iter().map(|byte| format!("{byte:02x}")).collect()
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
    generate_in(&language::ALL, coefficients, coefficients_sha256, options)
}

/// The same in some languages only, or in others.
///
/// # Errors
/// [`GenerateError`], which says what to change.
pub fn generate_in(
    languages: &[&dyn Language],
    coefficients: &Coefficients,
    coefficients_sha256: &str,
    options: &Options,
) -> Result<Generated, GenerateError> {
    let reservation = accepted(coefficients, options)?;
    let printer = Printer::new(languages, options)?;
    let recording = &coefficients.recording;
    let origin = Certificate {
        coefficients_sha256: coefficients_sha256.into(),
        recording: recording.file.clone(),
        recording_sha256: recording.sha256.clone(),
        reservation,
        ..Certificate::default()
    };
    let open = origin.reservation.as_ref();
    let open = open.map(|open| text::wrapped(&format!("UNEXPLAINED: {open}."), HEAD_COLUMNS, ""));
    let provenance = || {
        let recording = Value::from(Serde(recording));
        printer.provenance(context! { sha256 => coefficients_sha256, recording, open })
    };
    let quantity = Quantity::of(&routine::model(coefficients, options));
    if coefficients.whole_turn() {
        let routine = turn::choose::choose(coefficients, options)?;
        let name = name::base(options, turn::describe::NAME)?;
        let described = [turn::describe::described(&routine, &name, coefficients, options)?];
        let title = "corrected counts of an encoder";
        let mut files = printer.sources((&name, title), &provenance()?, &described)?;
        let certificate = printer.certificate(&name, origin, &described, &files);
        files.insert(PathBuf::from("certificate.json"), certificate.to_json()?);
        let (routines, unreachable, turn) = (Vec::new(), Vec::new(), Some(routine));
        return Ok(Generated { name, quantity, files, certificate, routines, turn, unreachable });
    }
    let name = base_name(options, &quantity)?;
    let (routines, unreachable) = designed(coefficients, options)?;
    let provenance = provenance()?;
    let function = |routine: &Routine| format!("{name}_{}", routine.options.suffix());
    let mut described: Vec<Described<'_>> = (routines.iter())
        .map(|routine| described(routine, &function(routine), &quantity, options, coefficients))
        .collect();
    described.sort_by(|a, b| a.entry.routine.cmp(&b.entry.routine));
    let mut files = printer.sources((&name, &quantity.title), &provenance, &described)?;
    let certificate = printer.certificate(&name, origin, &described, &files);
    for routine in &routines {
        let function = function(routine);
        if let Some(script) = gappa::script(&printer.renderer, routine, &function, &provenance)? {
            files.insert(PathBuf::from(format!("gappa/{function}.g")), script);
        }
    }
    files.insert(PathBuf::from("certificate.json"), certificate.to_json()?);
    Ok(Generated { name, quantity, files, certificate, routines, turn: None, unreachable })
}

/// The base name, where unit, formats and tables can stand in generated source.
fn base_name(options: &Options, quantity: &Quantity) -> Result<String, GenerateError> {
    if !name::is_identifier(&quantity.unit) {
        return Err(GenerateError::Name { what: "the sensor's unit", name: quantity.unit.clone() });
    }
    let name = name::base(options, &quantity.default_name)?;
    for (i, r) in options.routines.iter().enumerate() {
        if options.routines[..i].iter().any(|other| other.suffix() == r.suffix()) {
            return Err(GenerateError::Twice(r.suffix()));
        }
    }
    Ok(name)
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
