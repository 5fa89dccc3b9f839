//! Expressions of physics in the routine: every operator of the language is lowered here, and composes with every
//! other.
//!
//! A part of an expression is a [`Value`]: polynomials of words, which cost nothing until an operator needs them as a
//! word of its own. A word has a range and an error; an operator says what it makes of both. What an approximation may
//! be off is handed down from the result, by how strongly each operator depends on its arguments; that only chooses
//! how long polynomials are, and the bound holds whatever is chosen.

mod decay;
mod elementary;
mod memory;
mod table;
mod tree;
mod value;
mod words;

use fitter::terms::Play;
use physics::Operation;

use super::builder::{Builder, Tracked, whole};
use super::further::Given;
use super::shape::{Shape, Variable};
use super::{PhysicsError, Result};
use crate::exact::{Function, Interval, Polynomial};

pub(crate) use tree::Tree;
use value::{Base, READING, Value};
use words::Scaled;

/// Part of what a value may be off that each of its sources is given.
const SHARE: f64 = 0.25;
/// Part of a value's range below which no word resolves it.
const FINEST: f64 = 1.0 / (1u64 << 29) as f64;
/// Largest whole power that is multiplied out.
const LARGEST_POWER: f64 = 16.0;

/// What the terms of a routine have in common: words, and parts of expressions that are there.
#[derive(Default)]
pub(super) struct Shared {
    bases: Vec<Base>,
    parts: Vec<(Tree, Value)>,
    words: Vec<(Value, bool, Interval, Scaled)>,
}

/// Turns the expressions of terms into steps.
pub(super) struct Lowering<'a, 'b> {
    pub b: &'a mut Builder,
    pub shared: &'a mut Shared,
    pub variable: &'a Variable<'b>,
    pub given: &'a [(String, Given)],
    /// Seconds between two calls; 0 where that was not said.
    pub period_s: f64,
    /// Effect and kind of the term, for what is said of it.
    pub term: (&'a str, &'static str),
}

impl Lowering<'_, '_> {
    /// Subtracts an expression, in the unit of the statistics, from the result; `statistic` is one of that unit in the
    /// result's.
    pub fn subtract(&mut self, tree: &Tree, statistic: &Interval) -> Result {
        self.begin();
        tree.observed().into_iter().try_for_each(|name| self.lower(name, 1.0).map(drop))?;
        let within = self.within(statistic);
        let value = self.lower(tree, within)?.scaled(statistic);
        words::subtract(self.b, &self.shared.bases, &value, self.term.0)
    }

    /// Takes note of the words that are there.
    fn begin(&mut self) {
        if self.shared.bases.is_empty() {
            let word = self.variable.word.clone();
            let ends = self.variable.plan.reach_in_v();
            self.shared.bases.push(Base { word, exponent: self.variable.exponent, ends });
            for (_, given) in self.given {
                self.shared.bases.push(Base::of(given.word.clone(), 32));
            }
        }
    }

    /// Subtracts Σ weight·(v − play of v) from the result; the weights are in the unit of the statistics.
    pub fn subtract_plays(&mut self, play: &Play, weights: &[f64], statistic: &Interval) -> Result {
        self.begin();
        let seen = Tree::Observed(play.observable.clone());
        // All elements have a share of it, v a share of that.
        let all = weights.iter().fold(f64::MIN_POSITIVE, |sum, weight| sum + weight.abs());
        let within = SHARE * SHARE * self.within(statistic) / all;
        for (element, weight) in play.elements.iter().zip(weights) {
            let weight = &Interval::from_f64(*weight) * statistic;
            if self.b.leaves_out(&(&weight * &Interval::from_f64(element.half_width))) {
                continue;
            }
            let mut of = vec![seen.clone(), Tree::Number(element.half_width)];
            of.extend(element.initial.map(Tree::Number));
            let gap = self.gaps(&of, 1, within)?.scaled(&weight);
            words::subtract(self.b, &self.shared.bases, &gap, self.term.0)?;
        }
        Ok(())
    }

    /// What an approximation of the terms may be off, in the unit of the statistics.
    fn within(&self, statistic: &Interval) -> f64 {
        self.b.sum.tolerance.mul_pow2(-self.b.sum.bits).div(statistic).to_f64()
    }

    /// A refusal of the term.
    pub fn refuse(&self, why: String) -> PhysicsError {
        let (effect, kind) = self.term;
        PhysicsError::NotGenerated { effect: effect.into(), kind, why: format!(": {why}") }
    }

    fn observed(&self, name: &str) -> Result<Value> {
        let there = self.shared.parts.iter().find(|(tree, _)| matches!(tree, Tree::Observed(n) if n == name));
        if let Some((_, value)) = there {
            return Ok(value.clone());
        }
        if let Some(shape) = self.variable.observable(name)? {
            return Ok(Value::of(&self.shared.bases, READING, shape));
        }
        let (effect, kind) = self.term;
        let needs = || PhysicsError::Needs { effect: effect.into(), kind, observable: name.into() };
        let at = self.given.iter().position(|(input, _)| input == name).ok_or_else(needs)?;
        let Given { offset, slope, .. } = &self.given[at].1;
        let polynomial = Polynomial::linear(offset.clone(), slope.clone());
        Ok(Value::of(&self.shared.bases, at + 1, Shape { polynomial, remainder: Interval::zero() }))
    }

    /// About what a part can be.
    fn rough(&self, tree: &Tree) -> Result<physics::Interval> {
        let observed = |name: &str| {
            let range = self.observed(name).map_or_else(|_| Interval::zero(), |value| value.range);
            physics::Interval { from: range.to_f64_down(), to: range.to_f64_up() }
        };
        tree.interval(&observed, self.period_s).map_err(|why| self.refuse(why))
    }

    /// What each argument may be off where the value may be off by `within`: by its steepest slope.
    fn shares(&self, operation: Operation, of: &[Tree], within: f64) -> Result<Vec<f64>> {
        let ranges = of.iter().map(|tree| self.rough(tree)).collect::<Result<Vec<_>>>()?;
        let steepest = steepest(operation, &ranges);
        let share = |(range, steepest): (&physics::Interval, &f64)| {
            let size = range.from.abs().max(range.to.abs()).max(f64::MIN_POSITIVE);
            let steepest = if operation == Operation::Rate { 2.0 / self.period_s } else { *steepest };
            (SHARE * within / steepest).clamp(size * FINEST, size)
        };
        Ok(ranges.iter().zip(&steepest).map(share).collect())
    }

    /// The value of a part, which may be off by about `within`.
    fn lower(&mut self, tree: &Tree, within: f64) -> Result<Value> {
        if let Some((_, value)) = self.shared.parts.iter().find(|(other, _)| other == tree) {
            return Ok(value.clone());
        }
        let value = match tree {
            Tree::Number(value) => return Ok(Value::number(Interval::from_f64(*value))),
            Tree::Observed(name) => self.observed(name)?,
            Tree::Apply(operation, of) => {
                let shares = self.shares(*operation, of, within)?;
                self.apply(*operation, of, (within, &shares))?
            }
        };
        self.shared.parts.push((tree.clone(), value.clone()));
        Ok(value)
    }

    /// An operator's value.
    fn apply(&mut self, operation: Operation, of: &[Tree], (within, shares): (f64, &[f64])) -> Result<Value> {
        let one = |l: &mut Self, k: usize| l.lower(&of[k], shares[k]);
        match operation {
            Operation::Sum => Ok(one(self, 0)?.plus(&one(self, 1)?)),
            Operation::Difference => Ok(one(self, 0)?.less(&one(self, 1)?).narrowed(&self.shared.bases)),
            Operation::Negative => Ok(one(self, 0)?.scaled(&Interval::from_int(-1))),
            Operation::Product => {
                let (a, b) = (one(self, 0)?, one(self, 1)?);
                self.product(&a, &b, (shares[0], shares[1]))
            }
            Operation::Quotient => {
                let (a, b) = (one(self, 0)?, one(self, 1)?);
                let size = a.range.magnitude().to_f64().max(f64::MIN_POSITIVE);
                let inverse = self.function(Function::Power(-1.0), &b, (SHARE * within / size, shares[1]))?;
                let of_inverse = inverse.range.magnitude().to_f64() * FINEST;
                self.product(&a, &inverse, (shares[0], of_inverse))
            }
            Operation::Power => {
                let (x, exponent) = (one(self, 0)?, self.constant(&of[1], "an exponent")?.to_f64());
                if exponent == exponent.round() && (0.0..=LARGEST_POWER).contains(&exponent) {
                    return self.power(&x, exponent as u32, shares[0]);
                }
                self.function(Function::Power(exponent), &x, (within, shares[0]))
            }
            Operation::Sqrt => self.function_of(Function::Power(0.5), of, (within, shares)),
            Operation::Exp => self.function_of(Function::Exp, of, (within, shares)),
            Operation::Log => self.function_of(Function::Log, of, (within, shares)),
            Operation::Sin => self.function_of(Function::Sin, of, (within, shares)),
            Operation::Cos => self.function_of(Function::Cos, of, (within, shares)),
            Operation::Tanh => self.function_of(Function::Tanh, of, (within, shares)),
            Operation::Bump => {
                let away = Tree::Apply(Operation::Difference, of[..2].to_vec());
                let z = Tree::Apply(Operation::Quotient, vec![away, of[2].clone()]);
                self.function_of(Function::Bump, &[z], (within, &[within]))
            }
            Operation::Abs => {
                let x = one(self, 0)?;
                self.magnitude(&x, shares[0])
            }
            Operation::Min | Operation::Max | Operation::Hinge => self.extreme(operation, of, shares),
            Operation::Sign | Operation::Step => {
                let x = one(self, 0)?;
                let at = if operation == Operation::Step {
                    one(self, 1)?
                } else {
                    Value::number(Interval::zero())
                };
                self.jump(operation, &x.less(&at))
            }
            Operation::Table => self.table(of, shares[0]),
            Operation::LowPass => self.low_pass(of, shares[0]),
            Operation::Rate => self.rate(&of[0], shares[0]),
            Operation::Delay => self.delay(of, shares[0]),
            Operation::Play => self.play(of, 1, shares[0]),
            Operation::Plays => {
                let elements = match of.get(3) {
                    Some(count) => self.constant(count, "a number of plays")?.to_f64().round() as i64,
                    None => physics::ELEMENTS as i64,
                };
                self.play(of, elements, shares[0])
            }
            Operation::Mean
            | Operation::First
            | Operation::Lowest
            | Operation::Highest
            | Operation::Count => {
                Err(self.refuse(format!("`{}` is a figure of a whole recording", operation.name())))
            }
        }
    }

    /// The larger, the smaller, or what the first is above the second.
    fn extreme(&mut self, operation: Operation, of: &[Tree], shares: &[f64]) -> Result<Value> {
        let (a, b) = (self.lower(&of[0], shares[0])?, self.lower(&of[1], shares[1])?);
        let (sign, onto) = match operation {
            Operation::Min => (-1, Some(&b)),
            Operation::Max => (1, Some(&b)),
            _ => (1, None),
        };
        // max(a, b) = b + max(a − b, 0), min(a, b) = b − max(b − a, 0).
        let sign = Interval::from_int(sign);
        let beyond = a.less(&b).narrowed(&self.shared.bases).scaled(&sign);
        if onto.is_some() && Interval::zero().certainly_le(&beyond.range.lower()) {
            // The other has no part in it, nor what it is off.
            return Ok(a);
        }
        let beyond = self.positive(&beyond, shares[0].min(shares[1]))?.scaled(&sign);
        Ok(onto.map_or(beyond.clone(), |b| b.plus(&beyond)))
    }

    /// A part that must be a constant.
    fn constant(&mut self, tree: &Tree, what: &str) -> Result<Interval> {
        let value = self.lower(tree, FINEST)?;
        let changes = || self.refuse(format!("{what} that changes from call to call is not computed"));
        if value.is_constant() { Ok(value.constant) } else { Err(changes()) }
    }

    /// A value as a word; see [`words::word`].
    fn word(&mut self, value: &Value, absolute: bool, within: f64, name: &str) -> Result<Scaled> {
        let within = Interval::from_f64(within);
        let there = self.shared.words.iter().find(|(other, whole, fine, _)| {
            other == value && (*whole || !absolute) && fine.certainly_le(&within.mul_pow2(1))
        });
        if let Some((.., scaled)) = there {
            return Ok(scaled.clone());
        }
        let scaled = words::word(self.b, &self.shared.bases, value, absolute, (&within, name))?;
        self.shared.words.push((value.clone(), absolute, within, scaled.clone()));
        Ok(scaled)
    }

    fn product(&mut self, a: &Value, b: &Value, within: (f64, f64)) -> Result<Value> {
        if let Some(product) = a.times(b, &self.shared.bases) {
            return Ok(product);
        }
        let (of_a, of_b) = (self.word(a, true, within.0, "a")?, self.word(b, true, within.1, "b")?);
        let none = Tracked::constant(&Interval::zero());
        let name = format!("product_{}", self.b.program.steps.len());
        let word = self.b.mul_add(&name, (&of_a.word, &of_b.word), 0, &none, "")?;
        let unit = (&of_a.unit * &of_b.unit).mul_pow2(32);
        let product =
            words::value_of(&mut self.shared.bases, Scaled { word, offset: Interval::zero(), unit });
        Ok(product.within(&mut self.shared.bases, &(&a.range * &b.range)))
    }

    /// x to a whole power, by squares.
    fn power(&mut self, x: &Value, exponent: u32, within: f64) -> Result<Value> {
        if exponent == 0 {
            return Ok(Value::number(Interval::from_int(1)));
        }
        let half = if exponent > 1 { self.power(x, exponent / 2, within)? } else { return Ok(x.clone()) };
        let mut whole = self.product(&half, &half, (within, within))?;
        if exponent % 2 == 1 {
            whole = self.product(&whole, x, (within, within))?;
        } else {
            // A square is not negative.
            let range = whole.range.magnitude().hull(&Interval::zero());
            whole = whole.within(&mut self.shared.bases, &range);
        }
        Ok(whole)
    }

    /// max(x, 0).
    fn positive(&mut self, x: &Value, within: f64) -> Result<Value> {
        let zero = Interval::zero();
        if zero.certainly_le(&x.range.lower()) {
            return Ok(x.clone());
        }
        if x.range.upper().certainly_le(&zero) {
            return Ok(Value::number(zero));
        }
        let Scaled { word, offset, unit } = self.word(x, true, within, "x")?;
        let name = format!("beyond_{}", self.b.program.steps.len());
        let ends = if zero.certainly_le(&unit) { (0, i32::MAX.into()) } else { (i32::MIN.into(), 0) };
        let word_range = word.range.clone();
        let mut word = self.b.clamp(&name, &word, ends, &zero, "0 on the other side")?;
        // No further than the word itself reaches.
        let far = whole(&word_range);
        word.range = Interval::between(far.0.max(ends.0), far.1.min(ends.1));
        let beyond = words::value_of(&mut self.shared.bases, Scaled { word, offset, unit });
        Ok(beyond.within(&mut self.shared.bases, &zero.hull(&x.range.upper())))
    }

    /// |x|.
    fn magnitude(&mut self, x: &Value, within: f64) -> Result<Value> {
        if x.is_constant() {
            return Ok(Value::number(x.constant.magnitude()));
        }
        // |x| = 2·max(x, 0) − x, of one word.
        let scaled = self.word(x, true, within, "x")?;
        let same = words::value_of(&mut self.shared.bases, scaled);
        let same = Value { range: x.range.clone(), ..same };
        let mut size = self.positive(&same, within)?.scaled(&Interval::from_int(2)).less(&same);
        size.range = Interval::zero().hull(&x.range.magnitude());
        Ok(size)
    }

    /// The sign of x, or a step where x reaches 0: of an exact word, where it is right for every word.
    fn jump(&mut self, operation: Operation, x: &Value) -> Result<Value> {
        let zero = Interval::zero();
        let sign = operation == Operation::Sign;
        let exact = x.affine().filter(|(of, ..)| self.shared.bases[*of].word.error == zero);
        let Some((of, offset, slope)) = exact else {
            if x.is_constant() {
                let x = x.constant.midpoint();
                let reached = zero.certainly_le(&x);
                let at = if x == zero { 0 } else { i64::from(reached) * 2 - 1 };
                return Ok(Value::number(Interval::from_int(if sign { at } else { i64::from(reached) })));
            }
            let name = operation.name();
            return Err(self.refuse(format!(
                "at a jump (`{name}`) of a number that is rounded no bound is small; of a column it can be computed"
            )));
        };
        let base = self.shared.bases[of].clone();
        let unit = slope.mul_pow2(-base.exponent);
        let place = (-offset).div(&unit);
        let jumps = Jump { word: &base.word, rises: zero.certainly_le(&unit) };
        // A threshold less than 2⁻²⁰⁰ from a word is that word.
        let near = Interval::pow2(-200);
        let at_least = (&place.midpoint() - &near).ceil_to_i64().unwrap_or(i64::MAX);
        let beyond = (&place.midpoint() + &near).floor_to_i64().map_or(i64::MAX, |word| word + 1);
        let reached = self.reached(&jumps, if jumps.rises { at_least } else { beyond })?;
        if !sign {
            return Ok(reached);
        }
        // sign = [x ≥ 0] + [x > 0] − 1.
        let above = self.reached(&jumps, if jumps.rises { beyond } else { at_least })?;
        Ok(reached.plus(&above).less(&Value::number(Interval::from_int(1))))
    }

    /// 1 where a word is at or beyond `first`, else 0; the other way round where it does not rise.
    fn reached(&mut self, jump: &Jump, first: i64) -> Result<Value> {
        let one = Interval::from_int(1);
        let (least, most) = whole(&jump.word.range);
        let number = |reached: bool| Value::number(Interval::from_int(i64::from(reached == jump.rises)));
        if first > most || first <= least {
            return Ok(number(first <= least));
        }
        let name = format!("step_{}", self.b.program.steps.len());
        let near = self.b.clamp(&name, jump.word, (first - 1, first), &Interval::zero(), "")?;
        let below = self.b.sub(&name, &near.exactly(), &Tracked::constant(&Interval::from_int(first)))?;
        let range = Interval::from_int(-1).hull(&Interval::zero());
        let below = Tracked { range: range.clone(), ..below };
        let mut wide = self.b.shift_left(&name, &below, 30, "-2^30 before the step, 0 from there on")?;
        wide.error = Interval::zero();
        let (offset, unit) = match jump.rises {
            true => (one, Interval::pow2(-30)),
            false => (Interval::zero(), -Interval::pow2(-30)),
        };
        let mut reached = words::value_of(&mut self.shared.bases, Scaled { word: wide, offset, unit });
        reached.range = Interval::between(0, 1);
        Ok(reached)
    }
}

/// The steepest slope of an operator by each argument, which is looked for all over them; of what remembers it is 1.
fn steepest(operation: Operation, ranges: &[physics::Interval]) -> Vec<f64> {
    let mut steepest = vec![if operation.remembers() { 1.0 } else { 0.0f64 }; ranges.len()];
    if operation.remembers() {
        return steepest;
    }
    if operation == Operation::Table {
        // All but the quantity are constants.
        let middles: Vec<f64> = ranges.iter().map(|range| 0.5 * (range.from + range.to)).collect();
        steepest[0] =
            Some(physics::table::steepest(&middles)).filter(|slope| slope.is_finite()).unwrap_or(0.0);
        return steepest;
    }
    let points = if ranges.len() == 1 { 17 } else { 3usize };
    for index in 0..points.pow(ranges.len() as u32) {
        let place = |k: usize| (index / points.pow(k as u32) % points) as f64 / (points - 1) as f64;
        let at = |(k, range): (usize, &physics::Interval)| range.from + (range.to - range.from) * place(k);
        let (_, slopes) = operation.at(&ranges.iter().enumerate().map(at).collect::<Vec<f64>>());
        for (most, slope) in steepest.iter_mut().zip(slopes) {
            *most = if slope.is_finite() { most.max(slope.abs()) } else { *most };
        }
    }
    steepest
}

/// A word that jumps are looked for in.
struct Jump<'a> {
    word: &'a Tracked,
    /// Whether what it stands for rises with it.
    rises: bool,
}
