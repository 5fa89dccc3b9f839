//! The programs that sweep a generated routine: rendered from `templates/verify`, compiled around the
//! generated files as they are, and run on parts of a sweep.

use std::path::{Path, PathBuf};

use super::VerifyError;
use super::compile::{How, Place, Tool};
use super::domain::{Coverage, Domain, Sweep, numbers_of};
use super::fast_reference::FastReference;
use crate::generate::Generated;
use crate::interpret::{Word, interpret};
use crate::options::{Options, OutOfRange};
use crate::program::{Program, Type};
use crate::quantity::Quantity;
use crate::routine::Routine;
use minijinja::{Value, context, value::Serde};

/// Everything about one routine that the checks need.
pub struct Subject<'a> {
    /// Name of the function.
    pub name: String,
    /// Names and units of what it computes.
    pub quantity: &'a Quantity,
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
        let base = &generated.name;
        let named = |routine: &'a Routine| Subject {
            name: format!("{base}_{}", routine.options.suffix()),
            quantity: &generated.quantity,
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

/// A compiled sweep of one routine in one language.
#[derive(Debug)]
pub struct Harness {
    /// What it runs.
    pub how: How,
    executable: PathBuf,
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

/// Builds the harness of `subject`.
pub fn build(subject: &Subject<'_>, how: How, place: &Place<'_>) -> Result<Harness, VerifyError> {
    let context = context(subject, how, place)?;
    let executable = place.program(how, &format!("sweep_{}", subject.name), "sweep", context)?;
    Ok(Harness { how, executable })
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
        let folder = self.executable.parent().unwrap_or(Path::new("."));
        let text = tool.run(&arguments, folder)?;
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
    for index in coverage.indices() {
        let outcome = interpret(program, &subject.domain.arguments(program, index))?;
        let key = super::digest::key(&subject.domain.words(program, index));
        sum = sum.wrapping_add(u64::from(super::digest::mixed(key, outcome.word.bits() as u32)));
        if subject.flag && !outcome.in_range {
            sum = sum.wrapping_add(super::digest::FLAGGED);
        }
    }
    Ok(sum)
}

fn context(subject: &Subject<'_>, how: How, place: &Place<'_>) -> Result<Value, VerifyError> {
    let (program, reference) = (subject.program(), &subject.fast_reference);
    let (language, checker) = (how.language, how.checker);
    let (argument, output) = (program.arguments[0].ty, program.output_type());
    let (at_lo, at_hi) = results_at_ends(subject)?;
    let spread = match subject.domain {
        Domain::Floats { spread } => spread.to_bits(),
        _ => 0,
    };
    Ok(context! {
        routine => &*subject.name,
        crate_name => place.base,
        arguments => program.arguments.len(),
        argument_type => language.type_name(argument),
        output_type => language.type_name(output),
        float_output => output == Type::F32,
        domain => Value::from(Serde(&subject.domain)),
        size => subject.domain.size(program),
        flag => subject.flag,
        continues => subject.continues,
        from_bits => checker.argument(argument),
        spread_bits => format!("{spread:08x}"),
        at_lo_bits => format!("{at_lo:08x}"), at_hi_bits => format!("{at_hi:08x}"),
        lo => checker.double(reference.range.0), hi => checker.double(reference.range.1),
        centre => checker.double(reference.centre), scale => checker.double(reference.scale),
        coefficients => reference.coefficients.iter().rev().map(|c| checker.double(*c)).collect::<Vec<_>>(),
    })
}

/// The result words at both ends of the valid range, interpreted.
fn results_at_ends(subject: &Subject<'_>) -> Result<(u32, u32), VerifyError> {
    let program = subject.program();
    let at = |reading: f64| -> Result<u32, VerifyError> {
        let word = |v: f64| match program.arguments[0].ty {
            Type::F32 => Word::Float(v as f32),
            _ => Word::Int(v as i64),
        };
        let arguments = numbers_of(program.arguments[0].ty, program.arguments.len(), reading);
        let arguments: Vec<Word> = arguments.into_iter().map(word).collect();
        Ok(interpret(program, &arguments)?.word.bits() as u32)
    };
    Ok((at(subject.fast_reference.range.0)?, at(subject.fast_reference.range.1)?))
}
