//! Sweeps of compiled routines with terms of further physics: sequences of calls in place of single inputs.
//!
//! `strata` makes the sequences, `calls` runs the compiled routine over them, [`model`] is the fitted model in `f64`
//! with what that may be off; the outputs are held against the bound and against the interpreter's.

mod expression;
pub mod model;
mod strata;

use super::VerifyError;
use super::calls::{self, Calls, Given};
use super::compile::{How, Place};
use super::digest;
use super::domain::{arguments, describe};
use super::harness::Subject;
use super::sweep::SweepReport;
use crate::interpret::{Word, start, update};
use crate::program::Type;

use model::{Expected, Model};

/// Random calls of a sweep.
const CALLS: usize = 400_000;
/// Random calls of a thorough sweep.
const MANY_CALLS: usize = 4_000_000;
/// Calls that are interpreted.
const INTERPRETED: usize = 120_000;

/// Sequences of a routine with what they should give.
pub struct Prepared {
    calls: Calls,
    expected: Vec<Expected>,
    /// Whether each reading lies inside the range.
    inside: Vec<bool>,
    /// What the interpreter gives for the first calls and for some of the last.
    interpreted: Vec<(usize, u32)>,
}

/// Makes the sequences of a routine and what is expected of it.
///
/// # Errors
/// [`VerifyError::Overflow`] for a defect of the proof.
pub fn prepare(subject: &Subject<'_>, thorough: bool) -> Result<Prepared, VerifyError> {
    let routine = subject.routine;
    let calls = strata::of(routine, if thorough { MANY_CALLS } else { CALLS }, !subject.continues);
    let mut model = Model::new(routine, &subject.fast_reference);
    let readings = subject.program().arguments.len() - routine.physics.further.len();
    let (lo, hi) = subject.fast_reference.range;
    let number = |word: &Word| match word {
        Word::Int(v) => *v as f64,
        Word::Float(v) => f64::from(*v),
    };
    let (mut expected, mut inside) = (Vec::new(), Vec::new());
    for index in 0..calls.count() {
        let (begins, words) = calls.call(index);
        let numbers: Vec<f64> = arguments(subject.program(), words).iter().map(number).collect();
        let reading = if readings == 2 { numbers[1] - numbers[0] } else { numbers[0] };
        expected.push(model.call(begins, reading, &numbers[readings..]));
        // Two floats are compared with the range as their rounded difference.
        let float = subject.program().steps[subject.program().reading].ty == Type::F32;
        let compared = if float { f64::from(reading as f32) } else { reading };
        inside.push(lo <= compared && compared <= hi);
    }
    let interpreted = interpreted(subject, &calls)?;
    Ok(Prepared { calls, expected, inside, interpreted })
}

/// The interpreter's results for the first half of what it is given, and from the start of a sequence on for the rest.
fn interpreted(subject: &Subject<'_>, calls: &Calls) -> Result<Vec<(usize, u32)>, VerifyError> {
    let program = subject.program();
    let (count, half) = (calls.count(), INTERPRETED / 2);
    let late = (count.saturating_sub(half)..count).find(|i| calls.call(*i).0).unwrap_or(count);
    let mut state = Vec::new();
    let mut results = Vec::new();
    for index in (0..half.min(count)).chain(late.max(half)..count) {
        let (begins, words) = calls.call(index);
        let arguments = arguments(subject.program(), words);
        if begins {
            state = start(program, &arguments)?;
        }
        results.push((index, update(program, &mut state, &arguments)?.word.bits() as u32));
    }
    Ok(results)
}

/// Compiles a routine, runs it over the sequences and holds it against `bound`, in the quantity's bound unit.
///
/// # Errors
/// [`VerifyError`] where the program does not run to its end.
pub fn sweep(
    subject: &Subject<'_>,
    how: How,
    place: &Place<'_>,
    prepared: &Prepared,
    bound: f64,
) -> Result<SweepReport, VerifyError> {
    let program = calls::build((&subject.name, subject.program(), subject.flag), how, place)?;
    let given = calls::run(&program, &prepared.calls)?;
    let float = subject.program().output_type() == Type::F32;
    let value = |g: &Given| if float { f64::from(f32::from_bits(g.bits)) } else { f64::from(g.bits as i32) };
    let (mut worst, mut at, mut own, mut astray, mut sum) = (0.0f64, 0, 0.0f64, 0, 0u64);
    for (index, (g, e)) in given.iter().zip(&prepared.expected).enumerate() {
        let error = (value(g) - e.words).abs() + e.error;
        own = own.max(e.error);
        // Not a number counts as infinitely wrong.
        if error.is_nan() || error > worst {
            (worst, at) = (if error.is_nan() { f64::INFINITY } else { error }, index);
        }
        astray += u64::from(subject.flag && g.inside != prepared.inside[index]);
        let key = digest::key(&[index as u32, u32::from(g.inside)]);
        sum = sum.wrapping_add(u64::from(digest::mixed(key, g.bits)));
    }
    let as_interpreted = prepared.interpreted.iter().all(|(index, bits)| given[*index].bits == *bits);
    let worst_input = format!(
        "{}, call {} of its sequence",
        describe(subject.program(), &arguments(subject.program(), prepared.calls.call(at).1)),
        (0..=at).rev().take_while(|i| !prepared.calls.call(*i).0).count() + 1
    );
    let report = SweepReport {
        inputs: given.len() as u64,
        covered: prepared.calls.what.clone(),
        worst_input,
        worst_error: worst.next_up(),
        worst_error_lsb: worst,
        reference_error: own,
        astray,
        digest: format!("{sum:016x}"),
        as_interpreted,
        ..SweepReport::of(subject, how, bound)
    };
    Ok(report.held(subject, "readings are flagged wrongly"))
}
