//! Follows a program on a piece, step by step.

use super::Overflows;
use super::piece::Piece;
use super::value::{Inexact, Value, exactly, half_ulp, of_type};
use crate::exact::{Interval, Polynomial};
use crate::format::Format;
use crate::program::{Op, Operand, Program, Step, Type};

/// Follows all steps on a piece; gives the last one's value, or the step that could leave its type. Polynomials are those of the
/// distance from the piece's centre, so that a step's range needs no shift.
pub(super) fn run(program: &Program, piece: &Piece) -> Result<Value, Overflows> {
    let mut values: Vec<Value> = Vec::with_capacity(program.steps.len());
    for (index, step) in program.steps.iter().enumerate() {
        let value = if index < program.variable {
            before_variable(step, &values)
        } else if index == program.variable {
            fits(index, step, &before_variable(step, &values).range)?;
            let identity = Polynomial::linear(piece.centre.clone(), Interval::from_int(1));
            let identity = identity.mul_pow2(program.variable_exponent);
            Value { sum: Inexact::exact(identity), range: piece.words.clone() }
        } else {
            after_variable(program, step, &values, piece)
        };
        fits(index, step, &value.range)?;
        constants_fit(index, step)?;
        values.push(value);
    }
    Ok(values.pop().unwrap_or_else(|| unreachable!("a program has steps")))
}

/// Whether a step's range lies within its type.
fn fits(index: usize, step: &Step, range: &Interval) -> Result<(), Overflows> {
    Overflows::unless_inside(range, step.ty, (index, &step.name, step.stage))
}

/// Whether the constants of a step of signed words are such words, as the source writes them.
fn constants_fit(index: usize, step: &Step) -> Result<(), Overflows> {
    let operands = if step.ty == Type::I32 { step.op.operands() } else { Vec::new() };
    operands.iter().try_for_each(|operand| match operand {
        Operand::Int(value) => fits(index, step, &Interval::from_int(*value)),
        Operand::Step(_) | Operand::Float(_) => Ok(()),
    })
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
        Op::Clamp { lo, hi, .. } => Interval::between(*lo, *hi),
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
    Value { sum: Inexact::exact(Polynomial::constant(Interval::zero())), range }
}

/// Polynomial, error and range of a step of the evaluation or the output.
fn after_variable(program: &Program, step: &Step, values: &[Value], piece: &Piece) -> Value {
    let value = |operand: &Operand| match operand {
        Operand::Step(i) => values[*i].clone(),
        Operand::Int(v) => exactly(Interval::from_int(*v)),
        Operand::Float(v) => exactly(Interval::from_f64((*v).into())),
    };
    match &step.op {
        Op::MulAddHigh { a, b, shift, c } => {
            mul_add([value(a), value(b), value(c)], (*shift, 32), Format::Q31, step, piece)
        }
        Op::MulAddSplit { a, b, shift, c } => {
            mul_add([value(a), value(b), value(c)], (*shift, 32), Format::Q31Split, step, piece)
        }
        Op::MulAddShort { a, b, by, c } => {
            let (a, b) = (value(a), value(b));
            let product = &a.range * &b.range;
            if !product.inside(&of_type(Type::I32)) {
                return exactly(product);
            }
            mul_add([a, b, value(c)], (0, (*by).into()), Format::Q15, step, piece)
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
            let place = Inexact { polynomial: a.sum.polynomial.mul_pow2(by).sub(&start), ..a.sum };
            place.rounded(step, &Interval::zero(), piece)
        }
        Op::Entry { index, column } => {
            let row = value(index).range.floor_to_i64().and_then(|i| usize::try_from(i).ok());
            let entry = row.and_then(|i| program.table.get(i)).and_then(|r| r.get(*column));
            exactly(Interval::from_int(entry.copied().unwrap_or(i64::MAX)))
        }
        Op::Word { index } => {
            let range = program.page.get(*index).map_or((i64::MAX, i64::MAX), |word| (word.from, word.to));
            exactly(Interval::between(range.0, range.1))
        }
        Op::MulF32 { a, b } => {
            let product = value(a).times(&value(b));
            let rounding = of_product(step, &product, piece);
            product.rounded(step, &rounding, piece)
        }
        Op::MulAddF32 { a, b, c, fused } => {
            let product = value(a).times(&value(b));
            let first = if *fused { Interval::zero() } else { of_product(step, &product, piece) };
            let sum = product.plus(&value(c).sum);
            let range = sum.range(&first, piece);
            let exact = !*fused && is_exact(&product.range(&Interval::zero(), piece), c, &range);
            let second = if exact { Interval::zero() } else { half_ulp(&range) };
            sum.rounded(step, &(&first + &second).upper(), piece)
        }
        Op::ToF32 { a } => {
            let a = value(a);
            let rounding = half_ulp(&a.range);
            a.sum.rounded(step, &rounding, piece)
        }
        other => unreachable!("{other:?} is no step of an evaluation"),
    }
}

/// What a product of floats is rounded by: of a power of two only what falls below the smallest float.
fn of_product(step: &Step, product: &Inexact, piece: &Piece) -> Interval {
    if step.op.scales() { Interval::pow2(-150) } else { half_ulp(&product.range(&Interval::zero(), piece)) }
}

/// Whether a rounded product and a constant add up to a float: both are multiples of a power of two, of which the sum is at
/// most 2²⁴ times as large.
fn is_exact(product: &Interval, c: &Operand, sum: &Interval) -> bool {
    let Operand::Float(c) = c else { return false };
    let Some(of_product) = product.magnitude_lower().log2_floor().filter(|e| *e > -126) else { return false };
    let significand = i64::from(c.to_bits() & 0x7f_ffff | 0x80_0000);
    let of_constant = i64::from(c.to_bits() >> 23 & 0xff) - 150 + i64::from(significand.trailing_zeros());
    let grid = (of_product - 23).min(of_constant);
    sum.magnitude().certainly_le(&Interval::pow2(grid + 24))
}

/// c + a·b·2^(shift − scale), less what the product of a format loses before the left shift, whose middle is a bias and whose
/// half width is an error. What is added to c must fit the type as well.
fn mul_add(
    [a, b, c]: [Value; 3],
    (shift, scale): (u32, i64),
    format: Format,
    step: &Step,
    piece: &Piece,
) -> Value {
    let shift = i64::from(shift);
    let (middle, half) = format.lost(&a.range);
    let half = half.mul_pow2(shift);
    let product = a.times(&b).mul_pow2(shift - scale).less(&middle.mul_pow2(shift));
    let high = product.range(&half, piece);
    if !high.inside(&of_type(Type::I32)) {
        return exactly(high);
    }
    product.plus(&c.sum).rounded(step, &half, piece)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A sum that is said to be exact is one, for every product between two ends; and some are.
        #[test]
        fn exact_sums_are_exact(
            ends in (0x3c00_0000u32..0x3f80_0000, 0..1u32 << 22),
            c in 0x3c00_0000u32..0x3f80_0000,
            coarse in 0..24u32,
            negative in any::<(bool, bool)>(),
            between in prop::collection::vec(0.0..1.0f64, 20),
        ) {
            let signed = |value: f32, negative| if negative { -value } else { value };
            let c = signed(f32::from_bits(c >> coarse << coarse), negative.0);
            let [first, last] =
                [ends.0, ends.0 + ends.1].map(|bits| f64::from(signed(f32::from_bits(bits), negative.1)));
            let product = Interval::from_f64(first).hull(&Interval::from_f64(last));
            let sum = &product + &Interval::from_f64(c.into());
            if is_exact(&product, &Operand::Float(c), &sum) {
                for at in between {
                    let product = (first + at * (last - first)) as f32;
                    prop_assert_eq!(f64::from(product + c), f64::from(product) + f64::from(c));
                }
            }
        }
    }

    #[test]
    fn a_coarse_constant_makes_a_sum_exact() {
        let product = Interval::from_f64(0.5).hull(&Interval::from_f64(0.7));
        let exact =
            |c: f32| is_exact(&product, &Operand::Float(c), &(&product + &Interval::from_f64(c.into())));
        assert!(exact(0.125) && exact(0.25 + 0.5f32.powi(24)) && exact(0.0625 - 0.5f32.powi(24)));
        assert!(!exact(0.125 + 0.5f32.powi(25)) && !exact(0.5) && !exact(f32::EPSILON / 8.0));
    }
}
