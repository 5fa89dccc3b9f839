//! Which routines there are to choose from: proven bound against instructions and flash, on every core; and the choice
//! of the cheapest that is proven within the bound and fits the flash.

use std::cmp::Ordering;
use std::iter;
use std::sync::atomic::{self, AtomicUsize};

use fitter::coefficients::Coefficients;
use rayon::prelude::*;
use serde::Serialize;

use crate::cost::{Core, Cost};
use crate::format::Format;
use crate::fused::LARGEST_DEGREE;
use crate::input::{Arity, Encoding, Input};
use crate::options::{Ends, Method, Options, OutOfRange, Place, RoutineOptions};
use crate::program::Op;
use crate::quantity::Quantity;
use crate::routine::{self, Routine, RoutineError};

/// Numbers of segments that are tried, as powers of two.
const SEGMENTS_LOG2: std::ops::RangeInclusive<u32> = 2..=9;
/// Degrees of a table's polynomials.
const TABLE_DEGREES: std::ops::RangeInclusive<usize> = 1..=3;

/// Bounds closer than this are not worth an instruction.
const SAME_BOUND: f64 = 1.03;

/// A routine that could be generated.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The routine as designed.
    pub routine: Routine,
    /// Its bound, in the bound's unit.
    pub bound: f64,
}

impl Candidate {
    /// `q31, degree 9`, `f32, degree 9, two floats` or `q31, 3x64`; the last of polynomials of the variable, unless it says
    /// that segments are centred, or that they are of the place in the segment.
    pub fn describe(&self) -> String {
        let RoutineOptions { method, format, .. } = &self.routine.options;
        match method {
            Method::Fused => {
                let two = if self.has_two_floats() { ", two floats" } else { "" };
                format!("{}, degree {}{two}", format.name(), self.routine.design.degree)
            }
            Method::Piecewise { degree, segments_log2, padded, place } => {
                let padded = if *padded { "-padded" } else { "" };
                let place = match place {
                    Some(Place::Centred) => ", centred",
                    Some(Place::Segment) => ", by place",
                    Some(Place::Whole) | None => "",
                };
                format!("{}, {degree}x{}{padded}{place}", format.name(), 1 << segments_log2)
            }
        }
    }

    /// Whether it is of floats, the linear coefficient of two: one product more than the degree has.
    fn has_two_floats(&self) -> bool {
        let design = &self.routine.design;
        let products = design.program.steps.iter().filter(|step| matches!(step.op, Op::MulAddF32 { .. }));
        products.count() > design.degree
    }

    /// What it costs on a core.
    pub fn cost(&self, core: Core) -> Cost {
        core.cost(&self.routine.design.program)
    }
}

/// A row of the exploration: a candidate on a core, none of the others being better in all three.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The core.
    pub core: Core,
    /// The candidate in words.
    pub routine: String,
    /// Proven bound.
    pub bound: f64,
    /// Unit of the bound.
    pub unit: String,
    /// Estimated instructions of the body.
    pub instructions: f64,
    /// Estimated bytes of flash.
    pub flash_bytes: usize,
}

/// Forms that are designed at once. What is chosen may depend on it, and therefore never on the number of threads.
const AT_ONCE: usize = 4;

/// A routine that may be designed, and its degree.
type Form = (RoutineOptions, usize);

/// All that may be designed in some formats with these ends; of one format, input and output one after the other.
fn forms(coefficients: &Coefficients, options: &Options, ends: Ends, formats: &[Format]) -> Vec<Form> {
    let mut forms = Vec::new();
    for &format in formats {
        let mut usual = ends.routine(Method::Fused, format);
        usual.input = free_scale(coefficients, options, usual.input);
        let with = |method| RoutineOptions { method, ..usual.clone() };
        forms.extend((1..=LARGEST_DEGREE).map(|degree| (with(Method::Fused), degree)));
        if format.bits() != 31 {
            continue;
        }
        for (degree, segments_log2) in TABLE_DEGREES.flat_map(|d| SEGMENTS_LOG2.map(move |log2| (d, log2))) {
            for place in Place::ALL.map(Some) {
                // Only three words are fewer than a power of two.
                for padded in [false, true].into_iter().take(if degree == 2 { 2 } else { 1 }) {
                    forms.push((with(Method::Piecewise { degree, segments_log2, padded, place }), degree));
                }
            }
        }
    }
    forms
}

/// The input, where its scale is nobody's: of a range that is symmetric so that one instruction limits it, or nothing has
/// to.
fn free_scale(coefficients: &Coefficients, options: &Options, input: Input) -> Input {
    let covered = &coefficients.valid_range;
    let (from, to) = options.range.unwrap_or((covered.from, covered.to));
    let limited = options.out_of_range != OutOfRange::Continue;
    match input {
        Input { arity: Arity::Reading, encoding: Encoding::Q31 { full_scale: None } } if from == -to => {
            let full_scale = Some(if limited { 2.0 * to } else { to });
            Input { encoding: Encoding::Q31 { full_scale }, ..input }
        }
        other => other,
    }
}

/// Designs a form within `bound`; `None` where it is not good enough or does not fit its words: others may.
///
/// # Errors
/// What concerns every form.
fn designed(
    coefficients: &Coefficients,
    options: &Options,
    (wanted, degree): &Form,
    (bound, terms_bound): (f64, f64),
) -> Result<Option<Candidate>, RoutineError> {
    let quantity = Quantity::of(&coefficients.error_model());
    let (bound, terms_bound) = (Some(bound), Some(terms_bound));
    let options = Options { degree: Some(*degree), bound, terms_bound, ..options.clone() };
    match routine::design(coefficients, &options, wanted) {
        Ok(routine) => {
            let bound = quantity.in_bound_unit(routine.design.bound.total);
            Ok(Some(Candidate { routine, bound }))
        }
        Err(
            RoutineError::Unreachable { .. }
            | RoutineError::CoarseOutput { .. }
            | RoutineError::TableUnreachable { .. }
            | RoutineError::Design(_),
        ) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Designs all candidates whose best polynomials come within `bound`; `done` is told how many are through.
///
/// # Errors
/// The error of the first candidate that could not be designed for a reason that concerns all of them.
pub fn candidates(
    coefficients: &Coefficients,
    options: &Options,
    ends: Ends,
    formats: &[Format],
    bound: f64,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<Candidate>, RoutineError> {
    let forms = forms(coefficients, options, ends, formats);
    let (total, through) = (forms.len(), AtomicUsize::new(0));
    let quantity = Quantity::of(&coefficients.error_model());
    let terms_bound = wanted_bound(coefficients, options, &quantity).min(bound);
    let found: Vec<Result<Option<Candidate>, RoutineError>> = forms
        .par_iter()
        .flat_map_iter(|form| {
            let design = |bound| designed(coefficients, options, form, (bound, terms_bound));
            let candidate = design(bound);
            // Of floats also with a linear coefficient of two, which is what a smaller bound is met by.
            let one = candidate.as_ref().ok().and_then(Option::as_ref).filter(|_| !form.0.format.is_fixed());
            let two = one.map(|one| design(one.bound / SAME_BOUND));
            done(through.fetch_add(1, atomic::Ordering::Relaxed) + 1, total);
            iter::once(candidate).chain(two)
        })
        .collect();
    let (found, unusable): (Vec<_>, Vec<_>) = found.into_iter().partition(Result::is_ok);
    let found: Vec<Candidate> = found.into_iter().flatten().flatten().collect();
    match unusable.into_iter().find_map(Result::err) {
        Some(error) if found.is_empty() => Err(error),
        _ => Ok(found),
    }
}

/// The bound that is asked for, in the bound's unit, or the usual one.
fn wanted_bound(coefficients: &Coefficients, options: &Options, quantity: &Quantity) -> f64 {
    let range = options.range.unwrap_or((coefficients.valid_range.from, coefficients.valid_range.to));
    options.bound.unwrap_or_else(|| quantity.default_bound(range.0, range.1, coefficients.noise()))
}

/// The Pareto-optimal candidates on a core (bound, instructions, flash), best bound last.
pub fn front(candidates: &[Candidate], core: Core) -> Vec<(&Candidate, Cost)> {
    let can = |c: &&Candidate| core.fuses() || c.routine.options.format != Format::F32Fma;
    let costed: Vec<(&Candidate, Cost)> = candidates.iter().filter(can).map(|c| (c, c.cost(core))).collect();
    let beats = |a: &(&Candidate, Cost), b: &(&Candidate, Cost)| {
        let no_worse = a.0.bound <= SAME_BOUND * b.0.bound
            && a.1.instructions <= b.1.instructions
            && a.1.flash_bytes <= b.1.flash_bytes;
        let better =
            a.0.bound < b.0.bound || a.1.instructions < b.1.instructions || a.1.flash_bytes < b.1.flash_bytes;
        no_worse && better
    };
    let mut front: Vec<(&Candidate, Cost)> =
        costed.iter().filter(|b| !costed.iter().any(|a| beats(a, b))).copied().collect();
    front.sort_by(|a, b| b.0.bound.total_cmp(&a.0.bound).then(a.1.instructions.total_cmp(&b.1.instructions)));
    front
}

/// The front of every core as rows, for print, JSON and plot.
pub fn rows(candidates: &[Candidate], cores: &[Core], unit: &str) -> Vec<Row> {
    cores
        .iter()
        .flat_map(|&core| {
            front(candidates, core).into_iter().map(move |(candidate, cost)| Row {
                core,
                routine: candidate.describe(),
                bound: candidate.bound,
                unit: unit.into(),
                instructions: cost.instructions,
                flash_bytes: cost.flash_bytes,
            })
        })
        .collect()
}

/// What a routine is chosen for.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    /// Core whose instructions count.
    pub core: Core,
    /// Formats to choose from; empty: [`Format::ALL`].
    pub formats: &'a [Format],
    /// Input and output as far as the user named them.
    pub ends: Ends,
    /// Bytes of flash, code and table together.
    pub flash_bytes: Option<usize>,
}

/// Puts the chosen routine and its degree into `options`; `done` is told how many candidates of how many are
/// through.
///
/// # Errors
/// [`RoutineError`], which names the nearest that can be had.
pub fn choose(
    coefficients: &Coefficients,
    options: &mut Options,
    wanted: &Wanted,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Result<(), RoutineError> {
    let quantity = Quantity::of(&coefficients.error_model());
    let bound = wanted_bound(coefficients, options, &quantity);
    let formats = if wanted.formats.is_empty() { &Format::ALL } else { wanted.formats };
    let best = match search(coefficients, options, wanted, formats, bound)? {
        Some(best) => best,
        // The message names the nearest.
        None => {
            let all = candidates(coefficients, options, wanted.ends, formats, f64::MAX, done)?;
            cheapest(&all, wanted.core, bound, wanted.flash_bytes, &quantity.bound_unit)?.clone()
        }
    };
    options.degree = Some(best.routine.design.degree);
    options.routines = vec![best.routine.options];
    Ok(())
}

/// The cheapest that is proven within `bound` and fits the flash. Forms are designed in the order of what they will cost, and
/// none that no coefficients bring within the bound, until the rest cannot be cheaper.
fn search(
    coefficients: &Coefficients,
    options: &Options,
    wanted: &Wanted,
    formats: &[Format],
    bound: f64,
) -> Result<Option<Candidate>, RoutineError> {
    let forms = forms(coefficients, options, wanted.ends, formats);
    let outlined = routine::outlines(coefficients, options, &forms);
    let mut open: Vec<(Cost, Form)> = (forms.into_iter().zip(outlined))
        .filter_map(|(form, outline)| outline.filter(|o| o.least <= bound).map(|o| (o, form)))
        .map(|(outline, form)| (wanted.core.cost(&outline.program), form))
        .collect();
    let order = |a: Cost, b: Cost| {
        let key = |c: Cost| c.worth(wanted.flash_bytes.is_some());
        key(a).total_cmp(&key(b)).then(a.flash_bytes.cmp(&b.flash_bytes))
    };
    open.sort_by(|a, b| order(b.0, a.0));
    // What terms add is the same to all of them, about.
    let mut added = Cost { instructions: 0.0, flash_bytes: 0 };
    let mut best: Option<(Cost, Candidate)> = None;
    while !open.is_empty() {
        let next = open.split_off(open.len().saturating_sub(AT_ONCE));
        let least = next.iter().map(|(cost, _)| cost.plus(added)).min_by(|a, b| order(*a, *b));
        if best.iter().zip(least).any(|((cost, _), least)| order(*cost, least).is_le()) {
            break;
        }
        let found: Vec<_> =
            next.par_iter().map(|(_, form)| designed(coefficients, options, form, (bound, bound))).collect();
        for ((outlined, _), candidate) in next.into_iter().zip(found) {
            let Some(candidate) = candidate? else { continue };
            let cost = candidate.cost(wanted.core);
            // A second float of a coefficient is this one's alone.
            if candidate.routine.design.account.is_some() {
                added = cost.less(outlined);
            }
            let fits = wanted.flash_bytes.is_none_or(|most| cost.flash_bytes <= most);
            if fits && best.as_ref().is_none_or(|(so_far, _)| order(cost, *so_far).is_lt()) {
                best = Some((cost, candidate));
            }
        }
    }
    Ok(best.map(|(_, candidate)| candidate))
}

/// The cheapest candidate that is proven within `bound` and fits `flash_bytes` ([`Cost::worth`]); of equal ones the smaller,
/// then the more exact.
///
/// # Errors
/// [`RoutineError`], which names the nearest candidate that can be had.
pub fn cheapest<'a>(
    candidates: &'a [Candidate],
    core: Core,
    bound: f64,
    flash_bytes: Option<usize>,
    unit: &str,
) -> Result<&'a Candidate, RoutineError> {
    let told = |c: &Candidate| {
        let cost = c.cost(core);
        format!(
            "{}, proven within {:.2e} {unit}, about {:.0} instructions and {} bytes",
            c.describe(),
            c.bound,
            cost.instructions,
            cost.flash_bytes
        )
    };
    let (core_name, unit) = (core.name(), unit.to_string());
    let exact: Vec<&Candidate> = candidates.iter().filter(|c| c.bound <= bound).collect();
    if exact.is_empty() {
        let nearest =
            candidates.iter().min_by(|a, b| a.bound.total_cmp(&b.bound)).map(told).unwrap_or_default();
        return Err(RoutineError::NoneWithin { core: core_name, wanted: bound, unit, nearest });
    }
    let small = exact.iter().filter(|c| flash_bytes.is_none_or(|f| c.cost(core).flash_bytes <= f));
    let key = |c: &Candidate| {
        let cost = c.cost(core);
        (cost.worth(flash_bytes.is_some()), cost.flash_bytes, c.bound)
    };
    let order = |a: &&&Candidate, b: &&&Candidate| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal);
    small.min_by(order).copied().ok_or_else(|| {
        let smallest =
            exact.iter().min_by_key(|c| c.cost(core).flash_bytes).map(|c| told(c)).unwrap_or_default();
        RoutineError::NoneFits {
            core: core_name,
            wanted: bound,
            unit,
            flash: flash_bytes.unwrap_or(0),
            nearest: smallest,
        }
    })
}
