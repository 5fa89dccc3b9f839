//! Tables: the way along even places is a word of which the high bits are the number of a row and the low bits the place
//! in it, so that one multiplication gives both. A row is a straight line.

use super::super::builder::{Tracked, whole};
use super::super::rows::Names;
use super::super::{PhysicsError, Result};
use super::value::Value;
use super::words::{self, Scaled};
use super::{Lowering, Tree};
use crate::exact::Interval;

/// A row is 2^FINEST words at most, so that the place in it is a part of a word.
const FINEST: i64 = 30;
/// Values are words below 2^(VALUES + 1) about their middle, so that a row's line is a word.
const VALUES: i64 = 28;

/// Straight lines through values at the places 0, 1, 2, …
struct Lines {
    values: Vec<Interval>,
}

impl Lines {
    fn steps(&self) -> i64 {
        self.values.len() as i64 - 1
    }

    /// What the value rises by in a row; the last one is flat.
    fn rise(&self, row: i64) -> Interval {
        match self.values.get(row as usize + 1) {
            Some(next) => next - &self.values[row as usize],
            None => Interval::zero(),
        }
    }

    fn steepest(&self) -> Interval {
        let rises = (0..self.steps()).map(|row| self.rise(row).magnitude());
        rises.fold(Interval::zero(), |most, rise| most.hull(&rise).magnitude())
    }

    /// The values of some rows.
    fn range(&self, (first, last): (i64, i64)) -> Interval {
        let of_row = |row: i64| &self.values[row as usize] + &self.rise(row).hull(&Interval::zero());
        (first..=last).map(of_row).reduce(|a, b| a.hull(&b)).unwrap_or_else(Interval::zero)
    }

    /// All that it is along a range that is next to a point.
    fn at(&self, along: &Interval) -> Interval {
        let near = along.to_f64();
        let off = (along - &Interval::from_f64(near)).magnitude();
        let point = near.clamp(0.0, self.steps() as f64);
        let row = point as i64;
        let part = &Interval::from_f64(point) - &Interval::from_int(row);
        &(&self.values[row as usize] + &(&self.rise(row) * &part)) + &(&self.steepest() * &off).symmetric()
    }

    /// The line of every row about its middle, in words about `middle`, and how far they are from exact.
    fn words(
        &self,
        (first, last): (i64, i64),
        (middle, bits): (&Interval, i64),
    ) -> (Vec<Vec<i64>>, Interval) {
        let mut distance = Interval::zero();
        let mut line = |row: i64| {
            let rise = self.rise(row);
            let centre = &(&self.values[row as usize] + &rise.mul_pow2(-1)) - middle;
            let words = [centre, rise].map(|exact| Tracked::constant(&exact.mul_pow2(bits)));
            distance = distance.hull(&(&words[0].error + &words[1].error.mul_pow2(-1))).magnitude();
            words.iter().map(|word| word.range.round_to_i64().unwrap_or(0)).collect()
        };
        ((first..=last).map(&mut line).collect(), distance.upper())
    }
}

impl Lowering<'_, '_> {
    /// Straight lines through constants at even places between two constants; the quantity may be off by `within`.
    pub(super) fn table(&mut self, of: &[Tree], within: f64) -> Result<Value> {
        let from = self.constant(&of[1], "a table's beginning")?;
        let to = self.constant(&of[2], "a table's end")?;
        let length = &to - &from;
        if !Interval::zero().certainly_le(&length.lower()) || length.lower() == Interval::zero() {
            return Err(self.refuse("a table's end must be above its beginning".into()));
        }
        let values = of[3..].iter().map(|value| self.constant(value, "a table's value"));
        let lines = Lines { values: values.collect::<Result<Vec<_>>>()? };
        let per_unit = Interval::from_int(lines.steps()).div(&length);
        let along = self.lower(&of[0], within)?.less(&Value::number(from)).scaled(&per_unit);
        if along.is_constant() {
            return Ok(Value::number(lines.at(&along.constant)));
        }
        let within = &Interval::from_f64(within) * &per_unit;
        let along = self.near(along.narrowed(&self.shared.bases), lines.steps(), within.to_f64())?;
        let (word, by) = self.along(&along, lines.steps(), &within)?;
        let ends = whole(&word.range);
        let rows = (ends.0 >> by, ends.1 >> by);
        let range = lines.range(rows);
        let middle = range.midpoint();
        if (&range - &middle).magnitude() == Interval::zero() {
            return Ok(Value::number(range));
        }
        let bits = VALUES - (&range - &middle).magnitude().log2_floor().unwrap_or(0);
        let (table, distance) = lines.words(rows, (&middle, bits));
        let others = format!("_{}", self.b.program.steps.len());
        let sum = |column: usize| format!("line{column}{others}");
        let names = Names { of_others: &others, coefficient: "c", sum: &sum };
        let mut line = self.b.polynomials(word.operand, &table, (rows.0, by), &names)?;
        let moved = (&lines.steepest() * &word.error).mul_pow2(bits - by);
        line.error = (&(&line.error + &distance) + &moved).upper();
        line.range = line.range.meet(&(&(&range - &middle).mul_pow2(bits) + &line.error.symmetric()));
        let scaled = Scaled { word: line, offset: middle, unit: Interval::pow2(-bits) };
        Ok(Value { range, ..words::value_of(&mut self.shared.bases, scaled) })
    }

    /// The way along a table, limited where it reaches so far beyond that its word would be coarse.
    fn near(&mut self, along: Value, steps: i64, within: f64) -> Result<Value> {
        let (last, mut near) = (Interval::from_int(steps), along);
        if !(-last.clone()).certainly_le(&near.range.lower()) {
            near = self.positive(&near, within)?;
        }
        if !near.range.upper().certainly_le(&last.mul_pow2(1)) {
            let last = Value::number(last);
            near = last.less(&self.positive(&last.less(&near), within)?);
        }
        Ok(near)
    }

    /// The way along a table as a word from 0 to `steps`·2^by, and by.
    fn along(&mut self, along: &Value, steps: i64, within: &Interval) -> Result<(Tracked, i64)> {
        let zero = Interval::zero();
        let by = words::finest(&self.shared.bases, along, &zero).min(FINEST);
        if by < 1 {
            return Err(PhysicsError::TooLarge);
        }
        let word = words::word_at(self.b, &self.shared.bases, along, (&zero, by), (within, "along"))?;
        let all = whole(&word.range);
        let ends = (0, (steps << by).min(i32::MAX.into()));
        if ends.0 <= all.0 && all.1 <= ends.1 {
            return Ok((word, by));
        }
        let name = format!("along_{}", self.b.program.steps.len());
        let mut held = self.b.clamp(&name, &word, ends, &zero, "held beyond the ends")?;
        held.range = Interval::between(all.0.clamp(ends.0, ends.1), all.1.clamp(ends.0, ends.1));
        Ok((held, by))
    }
}
