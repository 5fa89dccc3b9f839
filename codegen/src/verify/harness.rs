//! The programs that sweep a generated routine: rendered from `templates/verify`, compiled around the
//! generated files as they are, and run on parts of a sweep.

use std::path::{Path, PathBuf};

use minijinja::{Value, context, value::Serde};
use serde::Serialize;

use super::VerifyError;
use super::compile::Tool;
use super::domain::{Coverage, Domain, Sweep};
use super::fast_reference::FastReference;
use crate::certificate::{Certificate, rust_type};
use crate::generate::Generated;
use crate::interpret::{Word, interpret};
use crate::options::{Options, OutOfRange};
use crate::program::{Program, Type};
use crate::render::{Renderer, c_type};
use crate::routine::Routine;
use crate::text::double_hex;

/// A language of the generated sources.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// The crate.
    Rust,
    /// Source and header.
    C,
}

impl Language {
    /// As in the certificate.
    pub fn name(self) -> &'static str {
        match self {
            Language::Rust => "rust",
            Language::C => "c",
        }
    }
}

/// Everything about one routine that the checks need.
pub struct Subject<'a> {
    /// Name of the function.
    pub name: String,
    /// The design, recomputed.
    pub routine: &'a Routine,
    /// How its inputs are numbered.
    pub domain: Domain,
    /// What its outputs are held against.
    pub fast_reference: FastReference,
    /// Whether it tells readings outside the range.
    pub flag: bool,
    /// Whether nothing is promised of its results there.
    pub continues: bool,
}

impl<'a> Subject<'a> {
    /// The routines of a generation.
    pub fn all(generated: &'a Generated, options: &Options) -> Vec<Self> {
        let base = base_name(&generated.certificate);
        let named = |routine: &'a Routine| Subject {
            name: format!("{base}_{}", routine.options.suffix()),
            routine,
            domain: Domain::of(&routine.design.program),
            fast_reference: FastReference::of(routine),
            flag: options.out_of_range == OutOfRange::Flag,
            continues: options.out_of_range == OutOfRange::Continue,
        };
        generated.routines.iter().map(named).collect()
    }

    /// Whether it has terms of further physics, so that it is swept by sequences of calls.
    pub fn has_terms(&self) -> bool {
        !self.routine.physics.is_empty()
    }

    /// Its program.
    pub fn program(&self) -> &Program {
        &self.routine.design.program
    }
}

/// Base name of the generated C files and of the crate.
pub fn base_name(certificate: &Certificate) -> String {
    let c = certificate.routines.iter().find(|e| e.language == "c");
    let stem = c.and_then(|e| Path::new(&e.file).file_stem()).map(|s| s.to_string_lossy().into_owned());
    stem.unwrap_or_default()
}

/// A compiled sweep of one routine in one language.
#[derive(Debug)]
pub struct Harness {
    /// What it runs.
    pub language: Language,
    /// Whether it watches for undefined behaviour.
    pub sanitized: bool,
    executable: PathBuf,
    folder: PathBuf,
}

/// What a part of a sweep found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The largest distance from the fast reference, in output words.
    pub worst: f64,
    /// Index of the input where it occurs.
    pub worst_index: u64,
    /// See [`super::digest`].
    pub digest: u64,
    /// Results outside the range that are not those at its ends, or wrong flags.
    pub astray: u64,
}

impl Found {
    /// Both parts together. Where two inputs are equally bad, the first stays.
    pub fn and(self, other: Found) -> Found {
        let worse = (other.worst > self.worst || other.worst.is_nan()) && !self.worst.is_nan();
        let (worst, worst_index) =
            if worse { (other.worst, other.worst_index) } else { (self.worst, self.worst_index) };
        Found {
            worst,
            worst_index,
            digest: self.digest.wrapping_add(other.digest),
            astray: self.astray + other.astray,
        }
    }
}

/// Compiles the generated crate in `generated` (a folder) once; the harnesses link it.
///
/// # Errors
/// [`VerifyError`] where there is no compiler or it refuses.
pub fn compile_crate(generated: &Path, base: &str, build: &Path) -> Result<(), VerifyError> {
    let library = generated.join("src/lib.rs");
    let output = build.join(format!("lib{base}.rlib"));
    let mut arguments = vec!["--edition=2021", "--crate-type=rlib", "--crate-name", base];
    arguments.extend(RUST_OPTIONS);
    let (library, output) = (library.display().to_string(), output.display().to_string());
    arguments.extend(["-o", output.as_str(), library.as_str()]);
    Tool::rustc().run(&arguments, build).map(drop)
}

const RUST_OPTIONS: [&str; 4] = ["-Copt-level=3", "-Ctarget-cpu=native", "-Cpanic=abort", "--cap-lints=warn"];
const C_OPTIONS: [&str; 4] = ["-std=c99", "-O3", "-march=native", "-ffp-contract=off"];
/// Undefined behaviour ends the run; unsigned arithmetic may wrap, that is defined.
const SANITIZE: [&str; 2] = ["-fsanitize=undefined,float-cast-overflow", "-fno-sanitize-recover=all"];

/// Builds the harness of `subject` in `build`, around the files in `generated`.
///
/// # Errors
/// [`VerifyError`] where there is no compiler, or it refuses the generated files.
pub fn build(
    subject: &Subject<'_>,
    language: Language,
    sanitize: bool,
    generated: &Path,
    base: &str,
    build: &Path,
) -> Result<Harness, VerifyError> {
    let text = render(subject, language, base)?;
    let stem = format!("sweep_{}_{}{}", subject.name, language.name(), if sanitize { "_ub" } else { "" });
    let extension = if language == Language::Rust { "rs" } else { "c" };
    let source = build.join(format!("{stem}.{extension}"));
    std::fs::write(&source, text).map_err(|cause| VerifyError::Write { path: source.clone(), cause })?;
    let executable = build.join(&stem);
    executable_of(language, sanitize, generated, base, build, &source, &executable)?;
    Ok(Harness { language, sanitized: sanitize, executable, folder: build.to_path_buf() })
}

/// Compiles a program around the generated files in `generated`, a Rust one with the crate in `build`.
///
/// # Errors
/// [`VerifyError`] where there is no compiler, or it refuses.
pub(super) fn executable_of(
    language: Language,
    sanitize: bool,
    generated: &Path,
    base: &str,
    build: &Path,
    source: &Path,
    executable: &Path,
) -> Result<(), VerifyError> {
    let (source, out) = (source.display().to_string(), executable.display().to_string());
    let include = format!("-I{}", generated.join("c").display());
    let library = format!("-L{}", build.display());
    let mut arguments: Vec<&str> = Vec::new();
    match language {
        Language::Rust => {
            arguments.push("--edition=2024");
            arguments.extend(RUST_OPTIONS);
            arguments.extend([library.as_str(), "--extern", base, "-o", out.as_str(), source.as_str()]);
        }
        Language::C => {
            arguments.extend(C_OPTIONS);
            if sanitize {
                arguments.extend(SANITIZE);
            }
            arguments.extend([include.as_str(), "-o", out.as_str(), source.as_str()]);
        }
    }
    let tool = if language == Language::Rust { Tool::rustc() } else { Tool::cc() };
    tool.run(&arguments, build).map(drop)
}

impl Harness {
    /// Runs one part of a sweep.
    ///
    /// # Errors
    /// [`VerifyError`] where the harness ends early, which under the sanitizer means undefined behaviour.
    pub fn run(&self, part: Sweep) -> Result<Found, VerifyError> {
        let tool = Tool { program: self.executable.display().to_string(), install: "" };
        let numbers = [part.first, part.count, part.stride].map(|n| n.to_string());
        let arguments: Vec<&str> = numbers.iter().map(String::as_str).collect();
        let text = tool.run(&arguments, &self.folder)?;
        parse(&text)
            .ok_or_else(|| VerifyError::Refused { program: tool.program.clone(), message: text.clone() })
    }
}

fn parse(text: &str) -> Option<Found> {
    let mut words = text.split_whitespace();
    Some(Found {
        worst: f64::from_bits(u64::from_str_radix(words.next()?, 16).ok()?),
        worst_index: words.next()?.parse().ok()?,
        digest: u64::from_str_radix(words.next()?, 16).ok()?,
        astray: words.next()?.parse().ok()?,
    })
}

/// The same digest from the program itself, interpreted.
pub fn interpreted_digest(subject: &Subject<'_>, coverage: &Coverage) -> Result<u64, VerifyError> {
    let program = subject.program();
    let mut sum = 0u64;
    for sweep in &coverage.sweeps {
        for i in 0..sweep.count {
            let index = sweep.first.wrapping_add(i * sweep.stride);
            let outcome = interpret(program, &subject.domain.arguments(program, index))?;
            let key = super::digest::key(&subject.domain.words(program, index));
            sum = sum.wrapping_add(u64::from(super::digest::mixed(key, outcome.word.bits() as u32)));
            if subject.flag && !outcome.in_range {
                sum = sum.wrapping_add(super::digest::FLAGGED);
            }
        }
    }
    Ok(sum)
}

fn render(subject: &Subject<'_>, language: Language, base: &str) -> Result<String, VerifyError> {
    let program = subject.program();
    let fast_reference = &subject.fast_reference;
    let argument = program.arguments[0].ty;
    let bits = |v: f64| format!("{:016x}", v.to_bits());
    let (at_lo, at_hi) = results_at_ends(subject)?;
    let spread = match subject.domain {
        Domain::Floats { spread } => spread.to_bits(),
        _ => 0,
    };
    let (from_bits, c_from_bits) = match argument {
        Type::F32 => ("f32::from_bits(word)".into(), "float_of(key)".into()),
        ty => (format!("word as {}", rust_type(ty)), format!("({})key", c_type(ty))),
    };
    let context = context! {
        routine => &*subject.name,
        crate_name => base,
        source => format!("{base}.c"),
        arguments => program.arguments.iter().map(|a| a.name.clone()).collect::<Vec<_>>(),
        argument_type => rust_type(argument),
        c_argument_type => c_type(argument),
        output_type => rust_type(program.output_type()),
        c_output_type => c_type(program.output_type()),
        domain => Value::from(Serde(&subject.domain)),
        size => subject.domain.size(program),
        flag => subject.flag,
        continues => subject.continues,
        from_bits, c_from_bits,
        spread_bits => format!("{spread:08x}"),
        at_lo_bits => format!("{at_lo:08x}"), at_hi_bits => format!("{at_hi:08x}"),
        lo_bits => bits(fast_reference.range.0), hi_bits => bits(fast_reference.range.1),
        centre_bits => bits(fast_reference.centre), scale_bits => bits(fast_reference.scale),
        coefficient_bits => fast_reference.coefficients.iter().rev().map(|c| bits(*c)).collect::<Vec<_>>(),
        lo_hex => double_hex(fast_reference.range.0), hi_hex => double_hex(fast_reference.range.1),
        centre_hex => double_hex(fast_reference.centre), scale_hex => double_hex(fast_reference.scale),
        coefficient_hex => fast_reference.coefficients.iter().rev().map(|c| double_hex(*c)).collect::<Vec<_>>(),
    };
    let template = match language {
        Language::Rust => "verify/sweep.rs",
        Language::C => "verify/sweep.c",
    };
    Ok(Renderer::new()?.render(template, context)?)
}

/// The result words at both ends of the valid range, interpreted.
fn results_at_ends(subject: &Subject<'_>) -> Result<(u32, u32), VerifyError> {
    let program = subject.program();
    let at = |reading: f64| -> Result<u32, VerifyError> {
        let word = |v: f64| match program.arguments[0].ty {
            Type::F32 => Word::Float(v as f32),
            _ => Word::Int(v as i64),
        };
        let arguments = match program.arguments.len() {
            1 => vec![word(reading)],
            // Some pair with this difference that the type holds.
            _ if program.arguments[0].ty == Type::F32 => vec![word(0.0), word(reading)],
            _ if reading < 0.0 && program.arguments[0].ty == Type::I32 => {
                vec![word((-reading / 2.0).floor()), word(reading + (-reading / 2.0).floor())]
            }
            _ if reading < 0.0 => vec![word(-reading), word(0.0)],
            _ if program.arguments[0].ty == Type::I32 => {
                vec![word(-(reading / 2.0).floor()), word(reading - (reading / 2.0).floor())]
            }
            _ => vec![word(0.0), word(reading)],
        };
        Ok(interpret(program, &arguments)?.word.bits() as u32)
    };
    Ok((at(subject.fast_reference.range.0)?, at(subject.fast_reference.range.1)?))
}
