//! From coefficients and options to a routine that is designed and bounded.

use fitter::coefficients::Coefficients;
use fitter::error_model::ErrorModel;

use crate::design::{Design, DesignError};
use crate::exact::Interval;
use crate::fused::{self, LARGEST_DEGREE};
use crate::input::{InputError, InputPlan};
use crate::options::{Method, Options, OutOfRange, Place, RoutineOptions};
use crate::physics::{Physics, PhysicsError};
use crate::piecewise::{self, Shape};
use crate::program::Program;
use crate::quantity::Quantity;
use crate::reference::{Reference, TooSteep};
use crate::text::rounded_up;

/// A designed routine with everything that is known about it.
#[derive(Debug, Clone)]
pub struct Routine {
    /// What was asked for.
    pub options: RoutineOptions,
    /// The program and its bound, in the result's unit.
    pub design: Design,
    /// The input's steps and range.
    pub plan: InputPlan,
    /// The enclosed function.
    pub reference: Reference,
    /// Smallest and largest reading for which it is valid.
    pub range: (f64, f64),
    /// What is added to the function of the reading, and what is left out.
    pub physics: Physics,
    /// Whether the range lies wholly outside the recording, so that only what extrapolates is kept.
    pub line: bool,
}

/// Tables that are tried where no polynomial for the whole range meets the bound: degree, and numbers of segments as
/// powers of two.
const TABLE_DEGREE: usize = 3;
/// See [`TABLE_DEGREE`].
const TABLES_LOG2: std::ops::RangeInclusive<u32> = 4..=9;

/// Part of a table's bound above which that of one with twice the segments shows that no further one is much better: of
/// polynomials alone it would be a sixteenth.
const STILL_BETTER: f64 = 0.8;

/// Bits that a table's polynomials give up at most for an instruction less.
const WORTH_A_SHIFT: i64 = 1;
/// A cheaper table is kept unless its bound is so many times that of the next.
const HARDLY_BETTER: f64 = 1.005;

/// Bits of the last sum that terms of further physics may take at most.
const MOST_HEADROOM: i64 = 6;
/// Part of the bound that is wanted below which the distance of the polynomial does not matter.
const NO_MATTER: f64 = 1e-3;

fitter::errors! {
    /// Why there is no routine.
    #[derive(Debug, Clone, PartialEq)]
    pub enum RoutineError {
        BeyondRecording { from: f64, to: f64, covered_from: f64, covered_to: f64, unit: String } =>
            says("the range {from}…{to} {unit} is wider than the recording, which covers \
                {covered_from}…{covered_to} {unit}: nothing is known of the error beyond")
            mend("narrow it, or allow to extrapolate and read what the generated head says")
            by(range) by(extrapolate);
        EmptyRange(a: f64, b: f64) =>
            says("the range {a}…{b} is empty") mend("give its lower end first, both as finite numbers") by(range);
        Unreachable { format: &'static str, wanted: f64, reachable: f64, by: String, unit: String } =>
            says("no {format} routine of degree {LARGEST_DEGREE} or less is proven within {wanted:e} {unit}: \
                the best is {} {unit} {by}", rounded_up(*reachable))
            mend("ask for that, or for another format, input or output");
        Table { degree: usize, segments: usize } =>
            says("a table of {segments} polynomials of degree {degree}")
            mend("give degree 1 to 3 and 2 to 4096 segments, 2x32 for example") by(table);
        TableFormat(it: &'static str) =>
            says("a table needs 32-bit words") found("format {it}") expected("q31 or q31-split") by(format);
        TableUnreachable { suffix: String, wanted: f64, reachable: f64, unit: String } =>
            says("{suffix} is proven within {} {unit} only, not {wanted:e}", rounded_up(*reachable))
            mend("ask for more segments or a higher degree");
        CoarseOutput { digits: u32, step: f64, wanted: f64, unit: String } =>
            says("the output counts in 10^-{digits} of the unit, that is {step:.3e} {unit}, of which half \
                may be rounded away: nothing is proven within {wanted:e} {unit}")
            mend("ask for a finer output or a larger bound");
        Bound(it: f64) => says("the bound is {it}") mend("give a positive number") by(bound);
        Degree(it: usize) => says("the degree is {it}") mend("give 1 to {LARGEST_DEGREE}") by(degree);
        /// No candidate for a core meets the bound.
        NoneWithin { core: &'static str, wanted: f64, unit: String, nearest: String } =>
            says("no routine for {core} is proven within {wanted:e} {unit}: the nearest that can be had is {nearest}");
        /// None that meets it is small enough.
        NoneFits { core: &'static str, wanted: f64, unit: String, flash: usize, nearest: String } =>
            says("no routine for {core} within {wanted:e} {unit} fits {flash} bytes of flash: the nearest that can be \
                had is {nearest}") by(flash_bytes);
    }
    from { Input(InputError), Physics(PhysicsError), TooSteep(TooSteep), Design(DesignError) }
}

/// Designs the routine `wanted` for `coefficients`: of the lowest degree whose proven bound is small enough.
///
/// # Errors
/// [`RoutineError`], which says what to change.
pub fn design(
    coefficients: &Coefficients,
    options: &Options,
    wanted: &RoutineOptions,
) -> Result<Routine, RoutineError> {
    let task = Task::new(coefficients, options, wanted)?;
    match wanted.method {
        Method::Piecewise { degree, segments_log2, padded, place } => {
            let shape = Shape { degree, segments_log2, padded, place: Place::Whole };
            task.table(&shape, place)
        }
        Method::Fused => task.polynomial(),
    }
}

/// What is known of a routine before its coefficients are: what it will cost, and what no coefficients can better.
#[derive(Debug, Clone)]
pub struct Outline {
    /// Its steps, of coefficients that are of no account, without terms of further physics.
    pub program: Program,
    /// No polynomials of these degrees come closer, as far as floats tell, in the bound's unit.
    pub least: f64,
}

/// The outlines of some routines and their degrees; none where an input, a format or a table does not do.
pub fn outlines(
    coefficients: &Coefficients,
    options: &Options,
    wanted: &[(RoutineOptions, usize)],
) -> Vec<Option<Outline>> {
    let mut shared: Option<Task> = None;
    let mut outlined = Vec::new();
    for (wanted, degree) in wanted {
        let same = |task: &Task| RoutineOptions { method: wanted.method, ..task.wanted.clone() } == *wanted;
        // Only the method is another: the function is the same.
        let task = match shared.filter(|task| same(task)) {
            Some(task) => Some(Task { wanted, ..task }),
            None => Task::new(coefficients, options, wanted).ok(),
        };
        outlined.push(task.as_ref().and_then(|task| task.outline(*degree)));
        shared = task;
    }
    outlined
}

/// What is known of a routine before a degree is chosen.
struct Task<'a> {
    coefficients: &'a Coefficients,
    options: &'a Options,
    wanted: &'a RoutineOptions,
    model: ErrorModel,
    quantity: Quantity,
    range: (f64, f64),
    /// The bound that is wanted, in the bound's unit.
    target: f64,
    plan: InputPlan,
    reference: Reference,
    physics: Physics,
}

impl<'a> Task<'a> {
    fn new(
        coefficients: &'a Coefficients,
        options: &'a Options,
        wanted: &'a RoutineOptions,
    ) -> Result<Self, RoutineError> {
        let model = model(coefficients, options);
        let quantity = Quantity::of(&model);
        let range = range(coefficients, options, &quantity)?;
        let usual = || quantity.default_bound(range.0, range.1, coefficients.noise());
        let target = options.bound.unwrap_or_else(usual);
        if !(target.is_finite() && target > 0.0) {
            return Err(RoutineError::Bound(target));
        }
        if let Some(digits) = wanted.output.decimal_digits() {
            let step = quantity.in_bound_unit(10f64.powi(-(digits as i32)));
            if 0.5 * step > target {
                let unit = quantity.bound_unit;
                return Err(RoutineError::CoarseOutput { digits, step, wanted: target, unit });
            }
        }
        let limited = options.out_of_range != OutOfRange::Continue;
        let plan = wanted.input.plan(&model.sensor, range.0, range.1, wanted.format, limited)?;
        let reference = reference(&model, &plan)?;
        let physics = Physics::of(coefficients, options, beyond(coefficients, options))?;
        Ok(Task { coefficients, options, wanted, model, quantity, range, target, plan, reference, physics })
    }

    /// A design with the terms of further physics, which may need room in the last sum.
    fn extended(
        &self,
        plan: &InputPlan,
        design: &dyn Fn(i64) -> Result<Design, DesignError>,
    ) -> Result<Design, DesignError> {
        let words = (self.wanted.format, self.wanted.output);
        let wanted = self.options.terms_bound.unwrap_or(self.target);
        let fine = wanted / self.quantity.bound_units_per_unit;
        let mut headroom = 0;
        loop {
            let extend = |d| self.physics.extend(d, &self.model, plan, words, fine);
            match design(headroom).and_then(extend) {
                Err(DesignError::Overflows(_) | DesignError::Physics(PhysicsError::Leaves { .. }))
                    if !self.physics.is_empty() && headroom < MOST_HEADROOM =>
                {
                    headroom += 1;
                }
                whole => return whole.map_err(|e| e.for_output(self.wanted.output)),
            }
        }
    }

    fn outline(&self, degree: usize) -> Option<Outline> {
        let words = (self.wanted.format, self.wanted.output);
        let (program, least) = match self.wanted.method {
            Method::Fused => {
                let least = fused::least_error(&self.plan, &self.reference, self.wanted.format, degree);
                (fused::outline(&self.plan, words, degree).ok()?, least)
            }
            Method::Piecewise { segments_log2, padded, place, .. } => {
                let shape = Shape { degree, segments_log2, padded, place: place.unwrap_or(Place::Whole) };
                let plan = self.plan_of(&shape);
                let least = piecewise::least_error(&plan, &self.reference, &shape);
                (piecewise::outline(&plan, words, &shape).ok()?, least)
            }
        };
        Some(Outline { program, least: self.quantity.in_bound_unit(least) })
    }

    fn finish(self, design: Design) -> Routine {
        let line = beyond(self.coefficients, self.options);
        let Task { plan, reference, range, physics, .. } = self;
        Routine { options: self.wanted.clone(), design, plan, reference, range, physics, line }
    }

    fn table(mut self, shape: &Shape, place: Option<Place>) -> Result<Routine, RoutineError> {
        let (wanted, Shape { degree, segments_log2, .. }) = (self.wanted, *shape);
        if !((1..=3).contains(&degree) && (1..=12).contains(&segments_log2)) {
            return Err(RoutineError::Table { degree, segments: 1 << segments_log2.min(31) });
        }
        if wanted.format.bits() != 31 {
            return Err(RoutineError::TableFormat(wanted.format.name()));
        }
        let places = place.map_or(Place::ALL.to_vec(), |place| vec![place]);
        let designed = places.into_iter().map(|place| self.tabulated(&Shape { place, ..*shape }));
        let chosen = designed.reduce(|cheap, fine| match (cheap, fine) {
            (Ok(cheap), Ok(fine)) if cheap.1.bound.total > HARDLY_BETTER * fine.1.bound.total => Ok(fine),
            (Ok(cheap), _) => Ok(cheap),
            (Err(_), fine) => fine,
        });
        let (plan, design) = chosen.unwrap_or_else(|| unreachable!("there is a place"))?;
        self.plan = plan;
        let reachable = self.quantity.in_bound_unit(design.bound.total);
        if reachable <= self.target {
            return Ok(self.finish(design));
        }
        let (suffix, unit) = (wanted.suffix(), self.quantity.bound_unit);
        Err(RoutineError::TableUnreachable { suffix, wanted: self.target, reachable, unit })
    }

    /// The plan for a table of this shape: a shift that is left out costs polynomials of the whole variable as many bits.
    fn plan_of(&self, shape: &Shape) -> InputPlan {
        let unshifted = self.plan.unshifted(shape.segments_log2 + 1);
        let bits = self.plan.program.variable_exponent - unshifted.program.variable_exponent;
        if shape.place == Place::Segment || bits <= WORTH_A_SHIFT { unshifted } else { self.plan.clone() }
    }

    /// A table of this shape, and its plan.
    fn tabulated(&self, shape: &Shape) -> Result<(InputPlan, Design), DesignError> {
        let (plan, words) = (self.plan_of(shape), (self.wanted.format, self.wanted.output));
        let made = |headroom| piecewise::design(&plan, &self.reference, words, shape, headroom);
        let design = self.extended(&plan, &made)?;
        Ok((plan, design))
    }

    fn polynomial(self) -> Result<Routine, RoutineError> {
        let words = (self.wanted.format, self.wanted.output);
        let degrees = match self.options.degree {
            Some(degree) if !(1..=LARGEST_DEGREE).contains(&degree) => {
                return Err(RoutineError::Degree(degree));
            }
            Some(degree) => degree..=degree,
            None => 1..=LARGEST_DEGREE,
        };
        let enough = self.target / self.quantity.bound_units_per_unit;
        let mut best: Option<(f64, usize, Design)> = None;
        for degree in degrees {
            let approximation = fused::best_error(&self.plan, &self.reference, degree).to_f64_down();
            let approximation = self.quantity.in_bound_unit(approximation);
            // Where the best polynomial is too far away already, only the best reachable bound is of interest.
            if approximation > self.target && degree < LARGEST_DEGREE && self.options.degree.is_none() {
                continue;
            }
            let made = |headroom| fused::design(&self.plan, &self.reference, words, degree, headroom, enough);
            let design = self.extended(&self.plan, &made)?;
            let bound = self.quantity.in_bound_unit(design.bound.total);
            if bound <= self.target {
                return Ok(self.finish(design));
            }
            if best.as_ref().is_none_or(|(b, ..)| bound < *b) {
                best = Some((bound, degree, design));
            }
            // What keeps the bound above the target then is not the polynomial, and a longer one has more roundings.
            if approximation < NO_MATTER * self.target {
                break;
            }
        }
        let noise = self.coefficients.noise();
        let usual = || self.quantity.largest_default_bound(self.range.0, self.range.1, noise);
        let largest = self.options.bound.unwrap_or_else(usual);
        let polynomial = match best {
            Some((bound, _, design)) if bound <= largest => return Ok(self.finish(design)),
            Some((reachable, degree, _)) => Nearest { reachable, by: format!("at degree {degree}") },
            None => unreachable!("the named or the largest degree is tried"),
        };
        self.table_instead().map_err(|table| {
            let (format, unit) = (self.wanted.format.name(), self.quantity.bound_unit.clone());
            let nearer = table.filter(|table| table.reachable < polynomial.reachable);
            let Nearest { reachable, by } = nearer.unwrap_or(polynomial);
            RoutineError::Unreachable { format, wanted: self.target, reachable, by, unit }
        })
    }

    /// A table, where no polynomial meets the bound: powers of a high order cancel each other in fixed point, those of short
    /// polynomials do not. Where no table does, the error is the nearest one, if any was designed.
    fn table_instead(&self) -> Result<Routine, Option<Nearest>> {
        if self.options.degree.is_some() || self.wanted.format.bits() != 31 {
            return Err(None);
        }
        let mut nearest: Option<Nearest> = None;
        for segments_log2 in TABLES_LOG2 {
            let method =
                Method::Piecewise { degree: TABLE_DEGREE, segments_log2, padded: false, place: None };
            let bounded = Options { bound: Some(self.target), ..self.options.clone() };
            match design(self.coefficients, &bounded, &RoutineOptions { method, ..self.wanted.clone() }) {
                Ok(routine) => return Ok(routine),
                Err(RoutineError::TableUnreachable { suffix, reachable, .. }) => {
                    let before = nearest.as_ref().map_or(f64::INFINITY, |nearest| nearest.reachable);
                    if reachable < before {
                        nearest = Some(Nearest { reachable, by: format!("with the table {suffix}") });
                    }
                    if reachable > STILL_BETTER * before {
                        break;
                    }
                }
                Err(_) => (),
            }
        }
        Err(nearest)
    }
}

/// The smallest proven bound, where it is not small enough.
struct Nearest {
    /// In the bound's unit.
    reachable: f64,
    /// The routine that has it, as the end of a sentence.
    by: String,
}

/// The function of a model over a plan's range, and a little beyond, where the variable's rounding may reach.
pub(crate) fn reference(model: &ErrorModel, plan: &InputPlan) -> Result<Reference, TooSteep> {
    let one = Interval::from_int(1);
    let reach = &one + &one.mul_pow2(-20);
    let (from, to) = plan.range_in_v();
    let from = (&from * &reach).hull(&(&from - &one.mul_pow2(-20))).lower();
    let to = (&to * &reach).hull(&(&to + &one.mul_pow2(-20))).upper();
    Reference::new(model, &plan.map, &from, &to)
}

/// The error model for the range that is wanted: beyond the recording, where nothing of the range was recorded, the
/// straight line that takes the polynomial's place there.
pub fn model(coefficients: &Coefficients, options: &Options) -> ErrorModel {
    let mut model = coefficients.error_model();
    if let Some((from, _)) = options.range.filter(|_| beyond(coefficients, options)) {
        let line = coefficients.line_beyond(from);
        model.coefficients = vec![line.constant, line.slope];
    }
    model
}

/// Whether the range lies wholly outside what was recorded.
fn beyond(coefficients: &Coefficients, options: &Options) -> bool {
    let covered = &coefficients.valid_range;
    options.range.is_some_and(|(from, to)| to < covered.from || from > covered.to)
}

/// The range that is wanted, held against what was recorded.
fn range(
    coefficients: &Coefficients,
    options: &Options,
    quantity: &Quantity,
) -> Result<(f64, f64), RoutineError> {
    let covered = (coefficients.valid_range.from, coefficients.valid_range.to);
    let (from, to) = options.range.unwrap_or(covered);
    if !(from.is_finite() && to.is_finite() && from < to) {
        return Err(RoutineError::EmptyRange(from, to));
    }
    if !options.extrapolate && (from < covered.0 || to > covered.1) {
        return Err(RoutineError::BeyondRecording {
            from,
            to,
            covered_from: covered.0,
            covered_to: covered.1,
            unit: quantity.reading_unit.clone(),
        });
    }
    Ok((from, to))
}

impl Routine {
    /// An upper estimate of the result's change by one unit of the reading, for telling the input's resolution.
    pub fn slope(&self) -> f64 {
        let slope = self.reference.polynomial.derivative();
        let (from, to) = self.plan.range_in_v();
        let largest = slope.range(&from, &to).magnitude();
        largest.div(&self.plan.map.slope.magnitude()).to_f64_up()
    }

    /// Whether, and if so what, the recording covers where the range goes beyond it.
    pub fn extrapolated(&self, coefficients: &Coefficients) -> Option<(f64, f64)> {
        let covered = (coefficients.valid_range.from, coefficients.valid_range.to);
        (self.range.0 < covered.0 || self.range.1 > covered.1).then_some(covered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_coefficients;
    use crate::format::Format;
    use crate::input::{Arity, Encoding, Input};
    use crate::interpret::{Word, interpret};
    use crate::output::Output;
    use proptest::prelude::*;

    /// Words of an integer input that lie closest to where something could go wrong, and one in between.
    fn words(routine: &Routine, at: f64) -> Vec<i64> {
        let step = &routine.design.program.steps[routine.design.program.clamped];
        let crate::program::Op::Clamp { lo, hi, .. } = step.op else { return Vec::new() };
        let inside = lo + ((hi - lo) as f64 * at) as i64;
        vec![lo, lo + 1, hi - 1, hi, inside, inside ^ 0xffff, (inside >> 16) << 16, 0]
            .into_iter()
            .filter(|w| (lo..=hi).contains(w))
            .collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        /// Every method and fixed-point format holds its bound on devices around the paper's.
        #[test]
        fn bounds_hold(
            scale in prop::collection::vec(-2.0..2.0f64, 10),
            method in prop_oneof![
                Just(Method::Fused),
                (1..=3usize, 1..=6u32, any::<bool>(), prop::sample::select(Place::ALL.to_vec())).prop_map(
                    |(degree, segments_log2, padded, place)| Method::Piecewise {
                        degree, segments_log2, padded, place: Some(place),
                    }
                ),
            ],
            format in prop::sample::select(vec![Format::Q31, Format::Q31Split, Format::Q15]),
            degree in 1..=10usize,
            full_scale in prop::option::of(0.37..2.0f64),
            at in prop::collection::vec(0.0..1.0f64, 40),
        ) {
            let mut coefficients = paper_coefficients();
            coefficients.base.coefficients.iter_mut().zip(&scale).for_each(|(a, s)| *a *= s);
            (coefficients.valid_range.from, coefficients.valid_range.to) = (-0.33, 0.36);
            let format = if method == Method::Fused { format } else { Format::Q31 };
            let input = Input { arity: Arity::Reading, encoding: Encoding::Q31 { full_scale } };
            let wanted = RoutineOptions { method, format, input, output: Output::PowerOfTwo };
            let options = Options { degree: Some(degree), bound: Some(1e9), ..Options::default() };
            let routine = design(&coefficients, &options, &wanted).unwrap();
            let model = coefficients.error_model();
            let unit = routine.design.unit.to_f64();
            let full_scale = full_scale.unwrap_or(0.5);
            for at in at {
                for word in words(&routine, at) {
                    let out = interpret(&routine.design.program, &[Word::Int(word)]).unwrap();
                    let expected = model.corrected(word as f64 * full_scale / 2f64.powi(31));
                    let error = (out.word.bits() as f64 * unit - expected).abs();
                    prop_assert!(out.in_range);
                    prop_assert!(
                        error <= routine.design.bound.total * (1.0 + 1e-9),
                        "{wanted:?} at {word}: {error:e} exceeds {:?}", routine.design.bound
                    );
                }
            }
        }
    }
}
