//! The proof: an upper bound of |generated − reference| over every valid input, in exact arithmetic.
//!
//! The range of the normalised variable is cut into pieces. On each piece every step's result is written as
//! an exactly known polynomial of v plus an error no larger than a radius, the radius being the sum of what
//! every rounding so far can have contributed; the distance of the last polynomial from the reference is then
//! certified by branch and bound. A truncation's mean of −½ is part of the polynomial, so only ±½ is left as
//! error. The variable's own rounding (from the argument to v) enters through the slope of the reference.
//!
//! At the same time each integer step is shown to fit its type for *every* argument, valid or not: before the
//! range is clamped by the limits of the types, afterwards by the ranges on the pieces, which cover it.

use crate::exact::{Interval, Polynomial};
use crate::input::InputPlan;
use crate::program::{Op, Operand, Program, Stage, Step, Type};
use crate::reference::Reference;

/// Pieces into which the range is cut.
const PIECES: i64 = 64;
/// The certified supremum may exceed the true one by this part of itself or of an output unit, 2⁻⁷.
const SUPREMUM_SLACK_LOG2: i64 = -7;

/// A routine's bound and what it is made of, on the piece where it is largest; in the output's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// The bound: the sum of the parts.
    pub total: f64,
    /// Supremum of the distance between the polynomial with its rounded coefficients and the reference.
    pub approximation: f64,
    /// What the rounding of the argument to the variable can shift the result.
    pub input: f64,
    /// Rounding of the operations that evaluate the polynomial.
    pub evaluation: f64,
    /// Rounding to the output's format.
    pub output: f64,
    /// The largest `evaluation` + `output` on any piece, in output words.
    pub rounding: f64,
    /// Smallest and largest output word (float: value), over every argument, valid or not.
    pub output_range: (f64, f64),
}

/// A program that cannot be used: some step may leave its type.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("step {step} ({name}) reaches {from}…{to}, beyond its type {ty:?}")]
pub struct Overflows {
    /// Index of the step.
    pub step: usize,
    /// Name of its variable.
    pub name: String,
    /// Which part of the routine it belongs to.
    pub stage: Stage,
    /// What it can reach.
    pub from: f64,
    /// See `from`.
    pub to: f64,
    /// The type.
    pub ty: Type,
}

/// A step's result on a piece: polynomial(v) + error, |error| ≤ evaluation + output.
#[derive(Debug, Clone)]
struct Value {
    polynomial: Polynomial,
    evaluation: Interval,
    output: Interval,
    range: Interval,
}

/// The output as a polynomial of v, with every bias, where the variable's word lies in `from`…`to`: what the
/// coefficient search starts from.
///
/// # Errors
/// [`Overflows`] as for [`bound`].
pub fn output_polynomial(
    program: &Program,
    plan: &InputPlan,
    from: &Interval,
    to: &Interval,
) -> Result<Polynomial, Overflows> {
    Ok(run(program, &Piece::new(program, plan, from, to))?.polynomial)
}

/// Bounds `program` against `reference`; one output word (float: 1) stands for `unit` of the reference's unit.
///
/// # Errors
/// [`Overflows`] where some argument, valid or not, could overflow a step.
pub fn bound(
    program: &Program,
    plan: &InputPlan,
    reference: &Reference,
    unit: &Interval,
) -> Result<Bound, Overflows> {
    let slope = reference.polynomial.derivative();
    let mut worst: Option<(Interval, Bound)> = None;
    let mut output_range: Option<Interval> = None;
    let mut rounding = 0.0f64;
    for (a, b) in pieces(program, words(program, plan)) {
        let piece = Piece::new(program, plan, &a, &b);
        let out = run(program, &piece)?;
        output_range = Some(output_range.map_or(out.range.clone(), |r| r.hull(&out.range)));
        rounding = rounding.max((&out.evaluation + &out.output).to_f64_up());
        let difference = out.polynomial.scale(unit).sub(&reference.polynomial);
        let rough = difference.at(&piece.centre).magnitude().upper();
        let tolerance =
            rough.mul_pow2(SUPREMUM_SLACK_LOG2).hull(&unit.mul_pow2(SUPREMUM_SLACK_LOG2)).magnitude();
        let v = |w: &Interval| w.mul_pow2(-program.variable_exponent);
        let supremum = difference.supremum(&v(&a), &v(&b), &tolerance).upper();
        let input = (&slope.range(&piece.wide_from, &piece.wide_to).magnitude() * &piece.input_error).upper();
        let remainder = &reference.remainder + &reference.remainder;
        let approximation = (&supremum + &remainder).upper();
        let evaluation = (&out.evaluation * unit).upper();
        let output = (&out.output * unit).upper();
        let total = &(&approximation + &input) + &(&evaluation + &output);
        if worst.as_ref().is_none_or(|(w, _)| w.certainly_le(&total)) {
            let parts = [&approximation, &input, &evaluation, &output].map(Interval::to_f64_up);
            let bound = Bound {
                total: total.to_f64_up(),
                approximation: parts[0],
                input: parts[1],
                evaluation: parts[2],
                output: parts[3],
                rounding: 0.0,
                output_range: (0.0, 0.0),
            };
            worst = Some((total, bound));
        }
    }
    if plan.reach != (plan.word_from.clone(), plan.word_to.clone()) {
        // Nothing is limited: no bound beyond the range, but no overflow either.
        for (a, b) in pieces(program, reach(program, plan)) {
            let out = run(program, &Piece::new(program, plan, &a, &b))?;
            output_range = Some(output_range.map_or(out.range.clone(), |r| r.hull(&out.range)));
        }
    }
    let range = output_range.unwrap_or_else(Interval::zero);
    let (_, bound) = worst.unwrap_or_else(|| unreachable!("there is at least one piece"));
    Ok(Bound { rounding, output_range: (range.to_f64_down(), range.to_f64_up()), ..bound })
}

/// The words of the variable for readings in the range: the plan's, widened by its rounding.
pub fn words(program: &Program, plan: &InputPlan) -> (Interval, Interval) {
    widened(program, plan, &plan.word_from, &plan.word_to)
}

/// All words that the variable can take, whatever the arguments.
pub fn reach(program: &Program, plan: &InputPlan) -> (Interval, Interval) {
    widened(program, plan, &plan.reach.0, &plan.reach.1)
}

fn widened(program: &Program, plan: &InputPlan, from: &Interval, to: &Interval) -> (Interval, Interval) {
    let error = input_error(program, plan, &from.hull(to)).mul_pow2(program.variable_exponent);
    (from - &error, to + &error)
}

/// The pieces on which a program is followed: its table's segments, or equal parts.
fn pieces(program: &Program, (from, to): (Interval, Interval)) -> Vec<(Interval, Interval)> {
    if program.index().is_some() {
        return segments(program, (from, to)).into_iter().map(|(_, a, b)| (a, b)).collect();
    }
    let width = &to - &from;
    let cut = |i: i64| match i {
        0 => from.clone(),
        PIECES => to.clone(),
        _ => (&from + &(&width * &Interval::from_ratio(i, PIECES))).midpoint(),
    };
    (0..PIECES).map(|i| (cut(i), cut(i + 1))).collect()
}

/// The rows of the table that words between two ends reach, with the first and last word that reaches each.
pub fn segments(program: &Program, (from, to): (Interval, Interval)) -> Vec<(usize, Interval, Interval)> {
    let Some((add, by)) = program.index() else { return Vec::new() };
    let (first, last) = (from.floor_to_i64().unwrap_or(i64::MIN), to.ceil_to_i64().unwrap_or(i64::MAX));
    let row = |word: i64| (word + add) >> by;
    (row(first)..=row(last))
        .map(|i| {
            let (a, b) = (((i << by) - add).max(first), (((i + 1) << by) - add - 1).min(last));
            (usize::try_from(i).unwrap_or(usize::MAX), Interval::from_int(a), Interval::from_int(b))
        })
        .collect()
}

/// A range of the variable's words, and what is known on it before evaluation begins.
struct Piece {
    words: Interval,
    centre: Interval,
    radius: Interval,
    input_error: Interval,
    /// The piece in v, widened by the input's error.
    wide_from: Interval,
    wide_to: Interval,
}

impl Piece {
    fn new(program: &Program, plan: &InputPlan, from: &Interval, to: &Interval) -> Self {
        let words = from.hull(to);
        let in_v = words.mul_pow2(-program.variable_exponent);
        let centre = in_v.midpoint();
        let radius = (&in_v - &centre).magnitude();
        let input_error = input_error(program, plan, &words);
        let wide_from = (&in_v.lower() - &input_error).lower();
        let wide_to = (&in_v.upper() + &input_error).upper();
        Piece { words, centre, radius, input_error, wide_from, wide_to }
    }
}

/// The largest distance, in v, between the variable and the exact reading, where the variable's word lies in
/// `words`: every step of the input is affine in the reading, so only roundings add up.
fn input_error(program: &Program, plan: &InputPlan, words: &Interval) -> Interval {
    // Magnitudes are taken a little wider, so that the binade of the exact value is never missed.
    let v = words.mul_pow2(-program.variable_exponent);
    let v = &v + &Interval::from_int(1).mul_pow2(-16).symmetric();
    let affine = |word: &(Interval, Interval)| &word.0 + &(&word.1 * &v);
    let mut exact = plan.reading_word.clone();
    let mut error = Interval::zero();
    for step in &program.steps[program.reading..=program.variable] {
        let half_ulp = |value: &Interval| half_ulp(value);
        match &step.op {
            Op::Sub { b: Operand::Step(_), .. } if step.ty == Type::F32 => error = half_ulp(&affine(&exact)),
            Op::Sub { b: Operand::Float(c), .. } => {
                exact.0 = &exact.0 - &Interval::from_f64((*c).into());
                error = (&error + &half_ulp(&affine(&exact))).upper();
            }
            Op::Sub { b: Operand::Int(c), .. } => exact.0 = &exact.0 - &Interval::from_int(*c),
            Op::ShiftLeft { by, .. } => {
                let by = i64::from(*by);
                exact = (exact.0.mul_pow2(by), exact.1.mul_pow2(by));
                error = error.mul_pow2(by);
            }
            Op::MulF32 { b: Operand::Float(c), .. } => {
                let c = Interval::from_f64((*c).into());
                exact = (&exact.0 * &c, &exact.1 * &c);
                error = (&error * &c.magnitude()).upper();
                // By a power of two: exact but for what falls below the smallest float.
                error = (&error + &Interval::from_int(1).mul_pow2(-150)).upper();
            }
            Op::Truncate { .. } => error = (&error + &Interval::from_int(1)).upper(),
            Op::ShiftRight { add, by, .. } => {
                // With half of what is shifted out added, to nearest; otherwise downward.
                let to_nearest = *add == 1 << (by - 1);
                let by = -i64::from(*by);
                exact = (exact.0.mul_pow2(by), exact.1.mul_pow2(by));
                error =
                    (&error.mul_pow2(by) + &Interval::from_int(1).mul_pow2(-i64::from(to_nearest))).upper();
            }
            Op::ToF32 { .. } => {
                let value = affine(&exact);
                if !value.magnitude().certainly_le(&Interval::from_int(1 << 24)) {
                    error = (&error + &half_ulp(&value)).upper();
                }
            }
            // A reading between the end of the range and the last float inside rounds to that float or to the
            // next, which is limited to it: then the error is up to a whole unit in the last place.
            Op::ClampF32 { .. }
                if words.lower().certainly_le(&plan.word_from.upper())
                    || plan.word_to.lower().certainly_le(&words.upper()) =>
            {
                error = (&error + &error).upper();
            }
            Op::Input { .. } | Op::Sub { .. } | Op::Clamp { .. } | Op::ClampF32 { .. } => {}
            other => unreachable!("{other:?} is no step of an input"),
        }
    }
    error.mul_pow2(-program.variable_exponent)
}

/// Half a unit in the last place of a float whose exact value lies in `value`.
fn half_ulp(value: &Interval) -> Interval {
    let exponent = value.log2_floor().map_or(-150, |e| (e - 24).max(-150));
    Interval::from_int(1).mul_pow2(exponent)
}

/// Follows all steps on a piece; gives the last one's value, or the step that could leave its type.
fn run(program: &Program, piece: &Piece) -> Result<Value, Overflows> {
    let mut values: Vec<Value> = Vec::with_capacity(program.steps.len());
    for (index, step) in program.steps.iter().enumerate() {
        let value = if index < program.variable {
            before_variable(step, &values)
        } else if index == program.variable {
            fits(index, step, &before_variable(step, &values).range)?;
            let identity = Polynomial::linear(
                Interval::zero(),
                Interval::from_int(1).mul_pow2(program.variable_exponent),
            );
            Value {
                polynomial: identity,
                evaluation: Interval::zero(),
                output: Interval::zero(),
                range: piece.words.clone(),
            }
        } else {
            after_variable(program, step, &values, piece)
        };
        fits(index, step, &value.range)?;
        values.push(value);
    }
    Ok(values.pop().unwrap_or_else(|| unreachable!("a program has steps")))
}

/// Whether a step's range lies within its type.
fn fits(index: usize, step: &Step, range: &Interval) -> Result<(), Overflows> {
    if step.ty.range().is_none() || range.inside(&of_type(step.ty)) {
        return Ok(());
    }
    let (from, to) = (range.to_f64_down(), range.to_f64_up());
    Err(Overflows { step: index, name: step.name.clone(), stage: step.stage, from, to, ty: step.ty })
}

/// Ranges only, for every argument, valid or not.
fn before_variable(step: &Step, values: &[Value]) -> Value {
    let range = |operand: &Operand| match operand {
        Operand::Step(i) => values[*i].range.clone(),
        Operand::Int(v) => Interval::from_int(*v),
        Operand::Float(v) => Interval::from_f64((*v).into()),
    };
    let range = match &step.op {
        Op::Input { .. } => of_type(step.ty),
        Op::Clamp { lo, hi, .. } => Interval::from_int(*lo).hull(&Interval::from_int(*hi)),
        Op::ClampF32 { lo, hi, .. } => {
            Interval::from_f64((*lo).into()).hull(&Interval::from_f64((*hi).into()))
        }
        Op::Sub { a, b } => &range(a) - &range(b),
        Op::ShiftLeft { a, by } => range(a).mul_pow2((*by).into()),
        // One word wider, for the floor; the sum must fit as well, or it shows here.
        Op::ShiftRight { a, add, by } => {
            let sum = &range(a) + &Interval::from_int(*add);
            let fits = sum.inside(&of_type(Type::I32));
            if fits { &sum.mul_pow2(-i64::from(*by)) + &Interval::from_int(1).symmetric() } else { sum }
        }
        // Floats have no range to leave; a float that becomes an integer is the variable itself.
        _ => Interval::zero(),
    };
    Value {
        polynomial: Polynomial::constant(Interval::zero()),
        evaluation: Interval::zero(),
        output: Interval::zero(),
        range,
    }
}

/// Polynomial, error and range of a step of the evaluation or the output.
fn after_variable(program: &Program, step: &Step, values: &[Value], piece: &Piece) -> Value {
    let value = |operand: &Operand| match operand {
        Operand::Step(i) => values[*i].clone(),
        Operand::Int(v) => exactly(Interval::from_int(*v)),
        Operand::Float(v) => exactly(Interval::from_f64((*v).into())),
    };
    let finish =
        |polynomial: Polynomial, mut evaluation: Interval, mut output: Interval, rounding: Interval| {
            match step.stage {
                Stage::Output => output = (&output + &rounding).upper(),
                _ => evaluation = (&evaluation + &rounding).upper(),
            }
            let error = (&evaluation + &output).upper();
            let range = &range_of(&polynomial, piece) + &error.symmetric();
            Value { polynomial, evaluation, output, range }
        };
    match &step.op {
        Op::MulAddHigh { a, b, shift, c } => {
            mul_add(value(a), value(b), value(c), *shift, 32, 1, piece, &finish)
        }
        Op::MulAddSplit { a, b, shift, c } => {
            mul_add(value(a), value(b), value(c), *shift, 32, 3, piece, &finish)
        }
        Op::MulAddShort { a, b, by, c } => {
            let (a, b) = (value(a), value(b));
            let product = &a.range * &b.range;
            if !product.inside(&of_type(Type::I32)) {
                return exactly(product);
            }
            mul_add(a, b, value(c), 0, i64::from(*by), 1, piece, &finish)
        }
        Op::Index { a, add, by } => {
            let row = |word: Interval| (word.floor_to_i64().unwrap_or(i64::MIN) + add) >> by;
            let (first, last) = (row(value(a).range.lower()), row(value(a).range.upper()));
            // A piece lies within one segment; beyond the table's rows it is out of the type's range.
            let inside = first == last && (0..=(i64::from(u32::MAX) >> by)).contains(&first);
            exactly(if inside { Interval::from_int(first) } else { Interval::from_int(i64::MAX) })
        }
        Op::Wrap { a, add, by } => {
            let (a, add, by) = (value(a), Interval::from_int(*add), i64::from(*by));
            let rows = (&a.range.midpoint() + &add).mul_pow2(by - 32).round_to_i64().unwrap_or(0);
            let start = Polynomial::constant(&Interval::from_int(rows).mul_pow2(32) - &add.mul_pow2(by));
            finish(a.polynomial.mul_pow2(by).sub(&start), a.evaluation, a.output, Interval::zero())
        }
        Op::Entry { index, column } => {
            let row = value(index).range.floor_to_i64().and_then(|i| usize::try_from(i).ok());
            let entry = row.and_then(|i| program.table.get(i)).and_then(|r| r.get(*column));
            exactly(Interval::from_int(entry.copied().unwrap_or(i64::MAX)))
        }
        Op::MulF32 { a, b } => {
            let (product, evaluation, output) = product(&value(a), &value(b));
            let power_of_two = matches!(b, Operand::Float(f) if f.to_bits() << 9 == 0);
            let rounding = if power_of_two {
                Interval::from_int(1).mul_pow2(-150)
            } else {
                half_ulp(&inflated(&product, &(&evaluation + &output), piece))
            };
            finish(product, evaluation, output, rounding)
        }
        Op::MulAddF32 { a, b, c, fused } => {
            let c = value(c);
            let (mut sum, mut evaluation, mut output) = product(&value(a), &value(b));
            let mut rounding = Interval::zero();
            if !fused {
                rounding = half_ulp(&inflated(&sum, &(&evaluation + &output), piece));
            }
            sum = sum.add(&c.polynomial);
            evaluation = (&evaluation + &c.evaluation).upper();
            output = (&output + &c.output).upper();
            let before = &(&evaluation + &output) + &rounding;
            let rounding = (&rounding + &half_ulp(&inflated(&sum, &before, piece))).upper();
            finish(sum, evaluation, output, rounding)
        }
        Op::ToF32 { a } => {
            let a = value(a);
            let rounding = half_ulp(&a.range);
            finish(a.polynomial, a.evaluation, a.output, rounding)
        }
        other => unreachable!("{other:?} is no step of an evaluation"),
    }
}

/// c + a·b·2^(shift − scale), less a truncation of 0…`floors` units before the left shift, whose middle is a
/// bias and whose half width is an error. What is added to c must fit the type as well.
#[allow(clippy::too_many_arguments)]
fn mul_add(
    a: Value,
    b: Value,
    c: Value,
    shift: u32,
    scale: i64,
    floors: i64,
    piece: &Piece,
    finish: &dyn Fn(Polynomial, Interval, Interval, Interval) -> Value,
) -> Value {
    let by = i64::from(shift) - scale;
    let (product, evaluation, output) = product(&a, &b);
    let half = Interval::from_int(floors).mul_pow2(i64::from(shift) - 1);
    let product = product.mul_pow2(by).sub(&Polynomial::constant(half.clone()));
    let (evaluation, output) = (evaluation.mul_pow2(by), output.mul_pow2(by));
    let high = inflated(&product, &(&(&evaluation + &output) + &half), piece);
    if !high.inside(&of_type(Type::I32)) {
        return exactly(high);
    }
    let (evaluation, output) = ((&evaluation + &c.evaluation).upper(), (&output + &c.output).upper());
    finish(product.add(&c.polynomial), evaluation, output, half)
}

/// All values of an integer type.
fn of_type(ty: Type) -> Interval {
    ty.range().map_or_else(Interval::zero, |(lo, hi)| Interval::from_int(lo).hull(&Interval::from_int(hi)))
}

fn exactly(constant: Interval) -> Value {
    Value {
        polynomial: Polynomial::constant(constant.clone()),
        evaluation: Interval::zero(),
        output: Interval::zero(),
        range: constant,
    }
}

/// Product of the polynomials, and of each kind of error what reaches it: |a|·e_b + |b|·e_a, where |a| is the
/// largest computed value, so that e_a·e_b is within.
fn product(a: &Value, b: &Value) -> (Polynomial, Interval, Interval) {
    let (ra, rb) = (a.range.magnitude(), b.range.magnitude());
    let spread = |ea: &Interval, eb: &Interval| (&(&ra * eb) + &(&rb * ea)).upper();
    (a.polynomial.mul(&b.polynomial), spread(&a.evaluation, &b.evaluation), spread(&a.output, &b.output))
}

fn range_of(polynomial: &Polynomial, piece: &Piece) -> Interval {
    polynomial.shift(&piece.centre).range_around_zero(&piece.radius)
}

fn inflated(polynomial: &Polynomial, error: &Interval, piece: &Piece) -> Interval {
    &range_of(polynomial, piece) + &error.symmetric()
}
