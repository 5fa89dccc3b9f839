//! Elementary functions of one word: a polynomial where a short one is near enough, else a table of cubic ones.

use super::super::builder::whole;
use super::super::rows::{self, DEGREE, Names};
use super::super::shape::{Shape, best_within};
use super::super::{PhysicsError, Result};
use super::value::{Base, Value};
use super::words::{self, Scaled};
use super::{Lowering, SHARE, Tree};
use crate::approximate::interpolate;
use crate::exact::{Function, Interval, Polynomial};

/// The longest polynomial that is cheaper than a row of a table.
const LONGEST: usize = 6;
/// Terms of a Taylor series at most.
const MOST_TERMS: usize = 24;
/// Rows that are tried, as powers of two.
const ROWS_LOG2: std::ops::RangeInclusive<i64> = 2..=10;
/// A power of e above this is no correction.
const LARGEST_EXPONENT: i64 = 60;
/// Least part of a row over which its polynomial is fitted.
const PART: f64 = 0.25;

/// A function of a word: f(offset + slope·v).
struct Inner {
    function: Function,
    base: Base,
    offset: Interval,
    slope: Interval,
}

impl Inner {
    /// All that its argument can be.
    fn range(&self) -> Interval {
        &self.offset + &(&self.slope * &self.base.ends.0.hull(&self.base.ends.1))
    }
}

impl Lowering<'_, '_> {
    pub(super) fn function_of(
        &mut self,
        function: Function,
        of: &[Tree],
        (within, shares): (f64, &[f64]),
    ) -> Result<Value> {
        let x = self.lower(&of[0], shares[0])?;
        self.function(function, &x, (within, shares[0]))
    }

    /// A function of a value, within about `within`; its argument may be off by `of_argument`.
    pub(super) fn function(
        &mut self,
        function: Function,
        x: &Value,
        (within, of_argument): (f64, f64),
    ) -> Result<Value> {
        let nowhere = |l: &Self, range: &Interval| {
            let (from, to) = (range.to_f64_down(), range.to_f64_up());
            l.refuse(format!(
                "an argument from {from:.3e} to {to:.3e} comes to where `{function:?}` has no slope"
            ))
        };
        if !function.exists(&x.range) {
            return Err(nowhere(self, &x.range));
        }
        let largest = Interval::from_int(LARGEST_EXPONENT);
        if function == Function::Exp && !x.range.certainly_le(&largest) {
            return Err(PhysicsError::TooLarge);
        }
        let whole = function.value(&x.range);
        let width = (&whole.upper() - &whole.lower()).to_f64_up();
        if x.is_constant() || width <= 0.5 * within {
            return Ok(Value::number(whole));
        }
        let (of, offset, slope) = match x.affine() {
            Some(affine) => affine,
            None => {
                // It stays away from 0 where there is no value.
                let away = x.range.to_f64_down().abs().min(x.range.to_f64_up().abs());
                let most = if function.exists(&Interval::zero()) { f64::INFINITY } else { SHARE * away };
                let scaled = self.word(x, false, of_argument.min(most), "of")?;
                let value = words::value_of(&mut self.shared.bases, scaled);
                value.affine().ok_or(PhysicsError::TooLarge)?
            }
        };
        let inner = Inner { function, base: self.shared.bases[of].clone(), offset, slope };
        let (inner, of, tail) = self.limited(inner, of, within)?;
        if !function.exists(&inner.range()) {
            return Err(nowhere(self, &inner.range()));
        }
        let half = Interval::from_f64(0.5 * within);
        if let Some(shape) = series(&inner, &inner.base.ends, &half) {
            let (polynomial, distance) = best_within(&shape, &inner.base.ends, &half.mul_pow2(-1));
            if polynomial.coefficients().len() <= LONGEST + 1 {
                let remainder = (&distance + &tail).upper();
                let mut value = Value::of(&self.shared.bases, of, Shape { polynomial, remainder });
                value.range = value.range.meet(&whole);
                return Ok(value);
            }
        }
        self.table_of(&inner, &whole, &half, &tail)
    }

    /// The argument, limited to where the function still moves by more than a part of `within`, and what lies beyond.
    fn limited(&mut self, inner: Inner, of: usize, within: f64) -> Result<(Inner, usize, Interval)> {
        let part = 0.125 * within.min(0.5);
        let (below, above) = match inner.function {
            Function::Exp => (Some(part.ln()), None),
            Function::Tanh => (Some(0.5 * (0.5 * part).ln()), Some(-0.5 * (0.5 * part).ln())),
            Function::Bump => (Some(-(-2.0 * part.ln()).sqrt()), Some((-2.0 * part.ln()).sqrt())),
            _ => (None, None),
        };
        let range = inner.range();
        let beyond = |end: Option<f64>, sign: i64| {
            let end = Interval::from_f64(end?);
            let sign = Interval::from_int(sign);
            let out = if sign == Interval::from_int(1) { range.upper() } else { range.lower() };
            let further = &(&out - &end) * &sign;
            (Interval::zero().certainly_le(&further) && further != Interval::zero()).then_some(end)
        };
        let (below, above) = (beyond(below, -1), beyond(above, 1));
        if below.is_none() && above.is_none() {
            return Ok((inner, of, Interval::zero()));
        }
        let word = |x: &Interval| {
            let v = (x - &inner.offset).div(&inner.slope);
            v.mul_pow2(inner.base.exponent)
        };
        let rises = Interval::zero().certainly_le(&inner.slope);
        let (low, high) = if rises { (&below, &above) } else { (&above, &below) };
        let low = low.as_ref().and_then(|x| word(x).floor_to_i64()).unwrap_or(i32::MIN.into());
        let high = high.as_ref().and_then(|x| word(x).ceil_to_i64()).unwrap_or(i32::MAX.into());
        let tail = [&below, &above].into_iter().flatten().fold(Interval::zero(), |most, x| {
            let flat =
                if inner.function == Function::Tanh { Interval::from_int(1) } else { Interval::zero() };
            let left = (&inner.function.value(x).magnitude() - &flat).magnitude();
            most.hull(&left).magnitude()
        });
        let name = format!("limited_{}", self.b.program.steps.len());
        let (least, most) = whole(&inner.base.word.range);
        let ends = (low.max(least), high.min(most));
        let one = Interval::from_int(1);
        let word = self.b.clamp(&name, &inner.base.word, ends, &one, "flat beyond")?;
        self.shared.bases.push(Base::of(word, inner.base.exponent));
        let of = self.shared.bases.len() - 1;
        Ok((Inner { base: self.shared.bases[of].clone(), ..inner }, of, tail))
    }

    /// Appends a table of the function and what reads it.
    fn table_of(
        &mut self,
        inner: &Inner,
        values: &Interval,
        within: &Interval,
        tail: &Interval,
    ) -> Result<Value> {
        let middle = values.midpoint();
        let bits = 28 - (values - &middle).magnitude().log2_floor().unwrap_or(0);
        let (least, most) = whole(&inner.base.word.range);
        let span = 64 - i64::from((most - least).leading_zeros());
        let plans = ROWS_LOG2.map(|log2| Rows { inner, by: (span - log2).clamp(1, 31), least, most });
        let wanted = &within.mul_pow2(bits) + &Interval::from_ratio(5, 4);
        let mut found = None;
        for rows in plans {
            let Some(table) = rows.coefficients(&middle, bits) else { continue };
            if rows.tried(&table, &middle, bits) > wanted.to_f64_up() && span - rows.by < *ROWS_LOG2.end() {
                continue;
            }
            let Some(distance) = rows.distance(&table, &middle, bits) else { continue };
            let enough = distance.certainly_le(&wanted);
            found = Some((rows, table, distance));
            if enough {
                break;
            }
        }
        let (rows, table, distance) =
            found.ok_or_else(|| self.refuse(format!("`{:?}` is too steep for a table", inner.function)))?;
        let others = format!("_{}", self.b.program.steps.len());
        let sum = |column: usize| format!("q{column}{others}");
        let names = Names { of_others: &others, coefficient: "c", sum: &sum };
        let of = inner.base.word.operand;
        let mut q = self.b.polynomials(of, &table, (least >> rows.by, rows.by), &names)?;
        let moved = (&rows.steepest() * &(&inner.slope.magnitude() * &inner.base.error())).mul_pow2(bits);
        q.error = (&(&q.error + &distance) + &(&moved + &tail.mul_pow2(bits))).upper();
        let known = &(values - &middle).mul_pow2(bits) + &q.error.symmetric();
        q.range = q.range.meet(&known);
        let scaled = Scaled { word: q, offset: middle, unit: Interval::pow2(-bits) };
        let mut value = words::value_of(&mut self.shared.bases, scaled);
        value.range = values.clone();
        Ok(value)
    }
}

/// The Taylor series about the middle of `ends`, with what it leaves out far below `within`; none where that takes too
/// many terms.
fn series(inner: &Inner, (from, to): &(Interval, Interval), within: &Interval) -> Option<Shape> {
    let v = from.hull(to);
    let middle = v.midpoint();
    let all = &inner.offset + &(&inner.slope * &v);
    let reach = (&inner.slope * &(&v - &middle)).magnitude();
    if !inner.function.exists(&all) {
        return None;
    }
    let bounds = inner.function.taylor(&all, MOST_TERMS + 1);
    let mut power = Interval::from_int(1);
    let small = within.mul_pow2(-6);
    let mut enough = None;
    for (n, c) in bounds.iter().enumerate() {
        let left = (&c.magnitude() * &power).upper();
        if n > 1 && left.certainly_le(&small) {
            enough = Some((n, left));
            break;
        }
        power = (&power * &reach).upper();
    }
    let (terms, remainder) = enough?;
    let mut slope = Interval::from_int(1);
    let mut coefficients = inner.function.taylor(&(&inner.offset + &(&inner.slope * &middle)), terms);
    for c in &mut coefficients {
        *c = &*c * &slope;
        slope = &slope * &inner.slope;
    }
    Some(Shape { polynomial: Polynomial::new(coefficients).shift(&-middle), remainder })
}

/// A table of a function: rows of 2^`by` words.
struct Rows<'a> {
    inner: &'a Inner,
    by: i64,
    least: i64,
    most: i64,
}

impl Rows<'_> {
    /// The rows with the middle of each, as a word, and the part of it that can be reached, in parts of a row.
    fn each(&self) -> impl Iterator<Item = (i64, (Interval, Interval))> + '_ {
        let by = self.by;
        ((self.least >> by)..=(self.most >> by)).map(move |row| {
            let middle = (row << by) + (1 << (by - 1));
            let part = |word: i64| Interval::from_int(word - middle).mul_pow2(-by);
            let ends = ((row << by).max(self.least), ((row + 1) << by).min(self.most + 1));
            (middle, (part(ends.0), part(ends.1)))
        })
    }

    /// The function in a row, as one of the place in it.
    fn local(&self, middle: i64) -> Inner {
        let Inner { function, base, offset, slope } = self.inner;
        let per_word = slope.mul_pow2(-base.exponent);
        Inner {
            function: *function,
            base: base.clone(),
            offset: offset + &(&per_word * &Interval::from_int(middle)),
            slope: per_word.mul_pow2(self.by),
        }
    }

    /// The cubic of every row in words about `middle`; none where one has a coefficient that is no word.
    fn coefficients(&self, centre: &Interval, bits: i64) -> Option<Vec<Vec<i64>>> {
        let (centre, scale) = (centre.to_f64(), 2f64.powi(bits as i32));
        let row = |(middle, (from, to)): (i64, (Interval, Interval))| {
            let local = self.local(middle);
            let (offset, slope) = (local.offset.to_f64(), local.slope.to_f64());
            let value = |w: f64| scale * (local.function.near(offset + slope * w) - centre);
            let (from, to) = (from.to_f64(), to.to_f64());
            // Of a row of a few words the beginning of the next one is fitted as well.
            let (from, to) =
                if from > -0.5 { (from, to.max(from + PART)) } else { (from.min(to - PART), to) };
            let c = interpolate(DEGREE, from, to, &value);
            let largest = f64::from(1 << 30);
            c.iter().all(|c| c.abs() < largest).then(|| c.iter().map(|c| c.round() as i64).collect())
        };
        self.each().map(row).collect()
    }

    /// The largest distance that f64 finds at some points, in words.
    fn tried(&self, table: &[Vec<i64>], centre: &Interval, bits: i64) -> f64 {
        let (centre, scale) = (centre.to_f64(), 2f64.powi(bits as i32));
        let of_row = |((middle, (from, to)), c): ((i64, (Interval, Interval)), &Vec<i64>)| {
            let local = self.local(middle);
            let (offset, slope) = (local.offset.to_f64(), local.slope.to_f64());
            rows::tried(c, (from.to_f64(), to.to_f64()), |w, there| {
                (scale * (local.function.near(offset + slope * w) - centre) - there).abs()
            })
        };
        self.each().zip(table).map(of_row).fold(0.0, f64::max)
    }

    /// A bound of the distance, in words; none where a series has too many terms.
    fn distance(&self, table: &[Vec<i64>], centre: &Interval, bits: i64) -> Option<Interval> {
        let fine = Interval::pow2(-3);
        let mut largest = Interval::zero();
        for ((middle, ends), c) in self.each().zip(table) {
            let shape = series(&self.local(middle), &ends, &fine.mul_pow2(-bits))?;
            let exact = shape.polynomial.sub(&Polynomial::constant(centre.clone())).mul_pow2(bits);
            let table = Polynomial::new(c.iter().map(|c| Interval::from_int(*c)).collect());
            let off = shape.remainder.mul_pow2(bits);
            let least = (&largest - &off).lower().hull(&Interval::zero()).upper();
            let here = exact.sub(&table).supremum_beside(&ends.0, &ends.1, &fine, &least);
            largest = (&here.upper() + &off).upper();
        }
        Some(largest)
    }

    /// The steepest slope of the function in its argument, on all words and what they may be off.
    fn steepest(&self) -> Interval {
        let error = self.inner.base.error();
        let slopes = self.each().map(|(middle, (from, to))| {
            let local = self.local(middle);
            let x = &local.offset + &(&local.slope * &from.hull(&to));
            let wider = &x + &(&self.inner.slope * &error).symmetric();
            if local.function.exists(&wider) {
                local.function.taylor(&wider, 2)[1].magnitude()
            } else {
                Interval::pow2(200)
            }
        });
        slopes.fold(Interval::zero(), |most, slope| most.hull(&slope).magnitude())
    }
}
