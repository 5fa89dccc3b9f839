//! From values to words: Horner's scheme in the word that a polynomial is of, every partial sum as fine as it can be.

use super::super::builder::{Builder, Tracked};
use super::super::shape::{Shape, best_within};
use super::super::{PhysicsError, Result};
use super::value::{Base, Value};
use crate::exact::{Interval, Polynomial};

/// A partial sum is a word below 2^MOST in magnitude.
const MOST: i64 = 29;
/// Words of less than so many bits are not shifted by a constant: its rounding would be too coarse.
const FINE: i64 = 24;
/// A word's own variable is v = word·2^−OWN.
pub(super) const OWN: i64 = 31;

/// value = offset + unit·word.
#[derive(Debug, Clone)]
pub(super) struct Scaled {
    pub word: Tracked,
    pub offset: Interval,
    pub unit: Interval,
}

/// Polynomials that take the place of a value's, and how far they are from it in all.
struct Short {
    constant: Interval,
    parts: Vec<(usize, Polynomial)>,
    distance: Interval,
}

/// The shortest polynomials that are within `tolerance` of a value.
fn short(bases: &[Base], value: &Value, tolerance: &Interval) -> Short {
    let each = tolerance.div(&Interval::from_int(value.parts.len().max(1) as i64)).lower();
    let mut short = Short { constant: value.constant.clone(), parts: Vec::new(), distance: Interval::zero() };
    for (of, shape) in &value.parts {
        let (best, distance) = best_within(shape, &bases[*of].ends, &each);
        short.constant = &short.constant + &best.coefficients()[0];
        short.distance = (&short.distance + &distance).upper();
        if best.coefficients().len() > 1 {
            short.parts.push((*of, best));
        }
    }
    short
}

/// The bits with which a magnitude is a word below 2^`most`.
fn bits_of(magnitude: &Interval, most: i64) -> i64 {
    most - 1 - magnitude.log2_floor().unwrap_or(-300)
}

/// Appends the steps to `onto` + (polynomial less its constant)·2^bits.
fn horner(
    b: &mut Builder,
    base: &Base,
    polynomial: &Polynomial,
    bits: i64,
    onto: &Tracked,
    (name, note): (&str, &str),
) -> Result<Tracked> {
    let c = polynomial.coefficients();
    let word = base.word.exactly();
    let v = base.ends.0.hull(&base.ends.1);
    // What each step makes, with its scale: from the constant on upward, so that each can be as fine as the one below
    // leaves room for.
    let mut partial = vec![c[c.len() - 1].clone(); c.len()];
    for k in (1..c.len() - 1).rev() {
        partial[k] = &c[k] + &(&partial[k + 1] * &v);
    }
    let mut scale = vec![bits; c.len()];
    for k in 1..c.len() {
        let product = (&partial[k] - &c[k]).magnitude();
        let largest = partial[k].magnitude().hull(&c[k].magnitude()).hull(&product).magnitude();
        // A trace more, for rounding may go up to the next power of two.
        let largest = &largest + &largest.mul_pow2(-MOST);
        scale[k] = bits_of(&largest, MOST + 2).min(scale[k - 1] + 32 - base.exponent);
    }
    let own = format!("p_{}", b.program.steps.len());
    let mut sum = Tracked::constant(&c[c.len() - 1].mul_pow2(scale[c.len() - 1]));
    for k in (0..c.len() - 1).rev() {
        let shift = scale[k] - scale[k + 1] + 32 - base.exponent;
        let shift = u32::try_from(shift).ok().filter(|s| *s < 31).ok_or(PhysicsError::TooLarge)?;
        let constant = Tracked::constant(&c[k].mul_pow2(scale[k]));
        let (name, next, said) = if k == 0 { (name, onto, note) } else { (&*own, &constant, "") };
        sum = b.mul_add(name, (&sum, &word), shift, next, said)?;
    }
    // What the word is off moves the value by its slope.
    let slope = polynomial.derivative().range(&base.ends.0, &base.ends.1).magnitude();
    let moved = (&slope * &base.error()).mul_pow2(bits);
    sum.error = (&sum.error + &moved).upper();
    Ok(sum)
}

/// The bits with which a value less `offset` is a word; partial sums must fit as well.
pub(super) fn finest(bases: &[Base], value: &Value, offset: &Interval) -> i64 {
    let away = (&value.constant - offset).magnitude();
    let each = value.parts.iter().map(|(of, shape)| {
        let (from, to) = &bases[*of].ends;
        (&shape.polynomial.range(from, to) + &shape.remainder.symmetric()).magnitude()
    });
    let largest = each.fold(away, |sum, part| &sum + &part);
    // And what the operations round.
    bits_of(&(&largest + &largest.mul_pow2(3 - MOST)), MOST + 1).min(200)
}

/// A value as a word of (value − from)·2^bits, within about `tolerance` of it; polynomials that are next to nothing
/// are left out.
pub(super) fn word_at(
    b: &mut Builder,
    bases: &[Base],
    value: &Value,
    (from, bits): (&Interval, i64),
    (tolerance, name): (&Interval, &str),
) -> Result<Tracked> {
    let short = short(bases, value, tolerance);
    let mut sum = Tracked::constant(&(&short.constant - from).mul_pow2(bits));
    let name = &format!("{name}_{}", b.program.steps.len());
    for (of, polynomial) in &short.parts {
        sum = horner(b, &bases[*of], polynomial, bits, &sum, (name, ""))?;
    }
    sum.error = (&sum.error + &short.distance.mul_pow2(bits)).upper();
    let known = &(&value.range - from).mul_pow2(bits) + &sum.error.symmetric();
    sum.range = sum.range.meet(&known);
    Ok(sum)
}

/// A value as a word that is as fine as 32 bits allow; `absolute` where it must be a multiple of the word, without an
/// offset.
pub(super) fn word(
    b: &mut Builder,
    bases: &[Base],
    value: &Value,
    absolute: bool,
    (tolerance, name): (&Interval, &str),
) -> Result<Scaled> {
    if let Some((of, offset, slope)) = value.affine() {
        let base = &bases[of];
        let unit = slope.mul_pow2(-base.exponent);
        if !absolute || offset == Interval::zero() {
            return Ok(Scaled { word: base.word.clone(), offset, unit });
        }
        let fine = base.word.range.log2_floor().is_some_and(|bits| bits >= FINE);
        let away = Tracked::constant(&offset.div(&unit));
        if fine && (&away.range + &base.word.range).log2_floor().is_some_and(|bits| bits <= MOST) {
            let name = format!("{name}_{}", b.program.steps.len());
            let word = b.add(&name, &base.word.clone(), &away, "")?;
            return Ok(Scaled { word, offset: Interval::zero(), unit });
        }
    }
    // Without a constant to add, where that may be.
    let offset = if absolute { Interval::zero() } else { value.constant.midpoint() };
    let bits = finest(bases, value, &offset);
    let word = word_at(b, bases, value, (&offset, bits), (tolerance, name))?;
    Ok(Scaled { word, offset, unit: Interval::pow2(-bits) })
}

/// Subtracts a value in the result's unit from the result.
pub(super) fn subtract(b: &mut Builder, bases: &[Base], value: &Value, note: &str) -> Result {
    let bits = b.sum.bits;
    let less = value.scaled(&Interval::from_int(-1));
    let short = short(bases, &less, &b.sum.tolerance.mul_pow2(-bits));
    b.add_constant(&short.constant.mul_pow2(bits))?;
    b.add_error(&short.distance.mul_pow2(bits));
    for (of, polynomial) in &short.parts {
        let (from, to) = &bases[*of].ends;
        if !b.leaves_out(&polynomial.range(from, to)) {
            b.sum.word = horner(b, &bases[*of], polynomial, bits, &b.sum.word.clone(), ("y", note))?;
        }
    }
    Ok(())
}

/// The value that a word stands for; the word is a new one among `bases`.
pub(super) fn value_of(bases: &mut Vec<Base>, scaled: Scaled) -> Value {
    let Scaled { word, offset, unit } = scaled;
    bases.push(Base::of(word, OWN));
    let polynomial = Polynomial::linear(offset, unit.mul_pow2(OWN));
    Value::of(bases, bases.len() - 1, Shape { polynomial, remainder: Interval::zero() })
}
