//! Sweeps a compiled routine in parallel and states what was found.

use fitter::progress::Progress;
use rayon::prelude::*;
use serde::Serialize;

use super::VerifyError;
use super::compile::How;
use super::domain::{Coverage, Sweep, describe};
use super::harness::{Found, Harness, Subject, interpreted_digest};
use crate::exact::Interval;

/// Inputs that one process is given at a time.
const PART: u64 = 1 << 26;

/// What a sweep of one routine in one language found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct SweepReport {
    /// Name of the function.
    pub routine: String,
    /// The language.
    pub language: &'static str,
    /// Whether undefined behaviour was watched for.
    pub sanitized: bool,
    /// How many inputs.
    pub inputs: u64,
    /// Whether these are all that the arguments' types can express.
    pub exhaustive: bool,
    /// What was covered, in words.
    pub covered: String,
    /// The input with the largest error.
    pub worst_input: String,
    /// The largest error, the reference's own error added; in `unit`.
    pub worst_error: f64,
    /// The same in output words (float: ulps of the largest result).
    pub worst_error_lsb: f64,
    /// What of it is the reference's own error.
    pub reference_error: f64,
    /// The proven bound.
    pub bound: f64,
    /// bound / worst error.
    pub margin: f64,
    /// Unit of errors and bound.
    pub unit: String,
    /// Results outside the range that are not those at its ends, or wrong flags.
    pub astray: u64,
    /// The digest of all outputs, hexadecimal.
    pub digest: String,
    /// Whether, on a subset, the digest is that of the interpreted program.
    pub as_interpreted: bool,
    /// What is wrong; empty where nothing is.
    pub violations: Vec<String>,
}

/// Inputs of a coverage.
pub fn inputs(coverage: &Coverage) -> u64 {
    coverage.sweeps.iter().map(|s| s.count).sum()
}

/// Runs `harness` over `coverage` on all cores.
pub fn run(harness: &Harness, coverage: &Coverage, bar: &dyn Progress) -> Result<Found, VerifyError> {
    let parts: Vec<Sweep> = coverage.sweeps.iter().flat_map(|s| cut(*s)).collect();
    let found: Vec<Found> = parts
        .par_iter()
        .map(|part| {
            let found = harness.run(*part);
            bar.advance(part.count);
            found
        })
        .collect::<Result<_, _>>()?;
    let mut found = found.into_iter();
    let first = found.next().unwrap_or_else(|| unreachable!("a coverage has a sweep"));
    Ok(found.fold(first, Found::and))
}

fn cut(sweep: Sweep) -> impl Iterator<Item = Sweep> {
    (0..sweep.count.div_ceil(PART)).map(move |i| Sweep {
        first: sweep.first + i * PART * sweep.stride,
        count: PART.min(sweep.count - i * PART),
        stride: sweep.stride,
    })
}

/// Sweeps, compares with the interpreter on a subset, and holds the result against `bound` (in the quantity's
/// bound unit).
pub fn sweep(
    subject: &Subject<'_>,
    harness: &Harness,
    coverage: &Coverage,
    bound: f64,
    bar: &dyn Progress,
) -> Result<SweepReport, VerifyError> {
    let program = subject.program();
    let found = run(harness, coverage, bar)?;
    let subset = subject.domain.interpreted(program);
    let compiled = run(harness, &subset, &())?.digest;
    let as_interpreted = compiled == interpreted_digest(subject, &subset)?;

    let largest = subject.routine.design.bound.output_range;
    let largest = largest.0.abs().max(largest.1.abs()) as f32;
    let lsb = match program.output_type() {
        crate::program::Type::F32 => f64::from(largest.next_up() - largest),
        _ => 1.0,
    };
    // The difference was rounded once; then what the fast reference may be off.
    let worst = (found.worst.next_up() + subject.fast_reference.error).next_up();
    let report = SweepReport {
        inputs: inputs(coverage),
        exhaustive: coverage.exhaustive,
        covered: coverage.what.clone(),
        worst_input: describe(program, &subject.domain.arguments(program, found.worst_index)),
        worst_error: worst,
        worst_error_lsb: worst / lsb,
        reference_error: subject.fast_reference.error,
        astray: found.astray,
        digest: format!("{:016x}", found.digest),
        as_interpreted,
        ..SweepReport::of(subject, harness.how, bound)
    };
    let wrongly = "results outside the range are not those at its ends, or flagged wrongly";
    Ok(report.held(subject, wrongly))
}

impl SweepReport {
    /// What is known before anything is swept.
    pub(super) fn of(subject: &Subject<'_>, how: How, bound: f64) -> SweepReport {
        SweepReport {
            routine: subject.name.clone(),
            language: how.language.name(),
            sanitized: how.sanitized,
            bound,
            unit: subject.quantity.bound_unit.clone(),
            ..SweepReport::default()
        }
    }

    /// The same held against the bound, its errors, which were in output words, in the bound's unit; `wrongly` says what
    /// those are that are astray.
    pub(super) fn held(mut self, subject: &Subject<'_>, wrongly: &str) -> SweepReport {
        let in_unit = |words: f64| {
            if !words.is_finite() {
                return f64::INFINITY;
            }
            let exact = &Interval::from_f64(words) * &subject.routine.design.unit;
            subject.quantity.in_bound_unit(exact.to_f64_up())
        };
        self.worst_error = in_unit(self.worst_error);
        self.reference_error = in_unit(self.reference_error);
        self.margin = self.bound / self.worst_error;
        // An output that is no number counts as infinitely wrong.
        if self.worst_error > self.bound {
            self.violations.push(format!(
                "the error at {} is {:.4e} {}, more than the bound {:.4e}",
                self.worst_input, self.worst_error, self.unit, self.bound
            ));
        }
        if self.astray > 0 {
            self.violations.push(format!("{} {wrongly}", self.astray));
        }
        if !self.as_interpreted {
            self.violations.push("the outputs differ from those of the program that was proved".into());
        }
        self
    }
}
