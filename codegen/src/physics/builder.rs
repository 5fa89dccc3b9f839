//! Appends integer steps to a program and keeps account of them: the words that a step can give, and how far
//! they can be from what exact arithmetic on exact inputs would give.

use std::collections::BTreeMap;

use super::Result;
use super::sum::Sum;
use crate::bound::{Overflows, of_type};
use crate::exact::Interval;
use crate::format::Format;
use crate::program::{Argument, Op, Operand, Program, Stage, StateWord, Type};

/// A word of the program.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// Where it is.
    pub operand: Operand,
    /// All words that it can be, whatever the arguments and the state.
    pub range: Interval,
    /// Its largest distance from the exact number, as a point.
    pub error: Interval,
}

impl Tracked {
    /// The nearest word to an exact constant.
    pub(super) fn constant(exact: &Interval) -> Tracked {
        let word = exact.round_to_i64().unwrap_or(i64::MAX);
        let range = Interval::from_int(word);
        let error = (&range - exact).magnitude();
        Tracked { operand: Operand::Int(word), range, error }
    }

    /// The same word, taken as exact.
    pub(super) fn exactly(&self) -> Tracked {
        Tracked { error: Interval::zero(), ..self.clone() }
    }
}

/// What the bound rests on in one step. A step may read more of an error than the step that it comes from has: what an
/// approximation is off comes between.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// Its result.
    pub result: Tracked,
    /// What it reads, in the order of its operands; empty where its result is known otherwise: a word of the state,
    /// or one that is limited.
    pub reads: Vec<Tracked>,
}

/// What the bound of the terms rests on: [`crate::gappa`] makes another prover's script of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorAccount {
    /// The steps that the terms add, by number in the program.
    pub steps: BTreeMap<usize, Known>,
    /// The sum, all terms subtracted.
    pub sum: Tracked,
}

/// A word of 64 bits: all that it can be.
#[derive(Debug, Clone)]
pub(super) struct Wide {
    pub operand: Operand,
    pub range: Interval,
}

/// A program under construction.
pub(super) struct Builder {
    /// The steps so far.
    pub program: Program,
    /// The format of its products.
    pub format: Format,
    /// What is known of every step that was appended.
    pub known: BTreeMap<usize, Known>,
    /// The result so far.
    pub sum: Sum,
}

impl Builder {
    /// Appends an argument; it can be any word of its type.
    pub fn argument(&mut self, argument: Argument) -> Tracked {
        let index = self.program.arguments.len();
        let (name, ty) = (argument.name.clone(), argument.ty);
        self.program.arguments.push(argument);
        let operand = self.program.push(Stage::Input, &name, ty, Op::Input { index }, "");
        Tracked { operand, range: of_type(ty), error: Interval::zero() }
    }

    /// Whether words of a type hold a range: constants are not steps, and must fit as well.
    fn fits(&self, name: &str, range: &Interval, ty: Type) -> Result {
        Ok(Overflows::unless_inside(range, ty, (self.program.steps.len(), name, Stage::Evaluation))?)
    }

    /// Appends a step whose words and error are known.
    pub fn push(
        &mut self,
        name: &str,
        op: Op,
        range: Interval,
        error: Interval,
        note: &str,
    ) -> Result<Tracked> {
        self.computed(name, op, (range, error), &[], note)
    }

    /// Appends a step whose words and error follow from what it reads.
    fn computed(
        &mut self,
        name: &str,
        op: Op,
        (range, error): (Interval, Interval),
        reads: &[&Tracked],
        note: &str,
    ) -> Result<Tracked> {
        self.fits(name, &range, Type::I32)?;
        let operand = self.program.push(Stage::Evaluation, name, Type::I32, op, note);
        let result = Tracked { operand, range, error: error.upper() };
        let reads = reads.iter().copied().cloned().collect();
        self.known.insert(self.program.output(), Known { result: result.clone(), reads });
        Ok(result)
    }

    /// Takes what is known of the last step as given, not as following from what it reads.
    pub fn known_otherwise(&mut self) {
        if let Some(known) = self.known.get_mut(&self.program.output()) {
            known.reads.clear();
        }
    }

    /// c + a·b·2^(shift − 32), the product rounded downward before the shift to the left.
    pub fn mul_add(
        &mut self,
        name: &str,
        (a, b): (&Tracked, &Tracked),
        shift: u32,
        c: &Tracked,
        note: &str,
    ) -> Result<Tracked> {
        let by = i64::from(shift);
        let (middle, half) = self.format.lost(&a.range);
        let lost = (&middle + &half.symmetric()).mul_pow2(by);
        let product = &(&a.range * &b.range).mul_pow2(by - 32) - &lost;
        // |a'b' − ab| ≤ |a'|·e_b + (|b'| + e_b)·e_a.
        let spread = &(&a.range.magnitude() * &b.error) + &(&(&b.range.magnitude() + &b.error) * &a.error);
        let error = &(&spread.mul_pow2(by - 32) + &lost.magnitude()) + &c.error;
        for factor in [a, b, c] {
            self.fits(name, &factor.range, Type::I32)?;
        }
        // What is added must fit the word as well.
        let op = self.format.mul_add(a.operand, b.operand, shift, c.operand);
        let range = if product.inside(&of_type(Type::I32)) { &product + &c.range } else { product };
        self.computed(name, op, (range, error), &[a, b, c], note)
    }

    pub fn add(&mut self, name: &str, a: &Tracked, b: &Tracked, note: &str) -> Result<Tracked> {
        let op = Op::Add { a: a.operand, b: b.operand };
        self.computed(name, op, (&a.range + &b.range, &a.error + &b.error), &[a, b], note)
    }

    pub fn sub(&mut self, name: &str, a: &Tracked, b: &Tracked) -> Result<Tracked> {
        let op = Op::Sub { a: a.operand, b: b.operand };
        self.computed(name, op, (&a.range - &b.range, &a.error + &b.error), &[a, b], "")
    }

    pub fn shift_left(&mut self, name: &str, a: &Tracked, by: u32, note: &str) -> Result<Tracked> {
        let up = i64::from(by);
        let op = Op::ShiftLeft { a: a.operand, by };
        self.computed(name, op, (a.range.mul_pow2(up), a.error.mul_pow2(up)), &[a], note)
    }

    /// a limited to lo…hi, where exact arithmetic limits to within `mismatch` of that.
    pub fn clamp(
        &mut self,
        name: &str,
        a: &Tracked,
        (lo, hi): (i64, i64),
        mismatch: &Interval,
        note: &str,
    ) -> Result<Tracked> {
        let range = Interval::between(lo, hi);
        let error = a.error.hull(mismatch).magnitude();
        self.push(name, Op::Clamp { a: a.operand, lo, hi }, range, error, note)
    }

    /// A further word of the state, as the call before left it: what `word` is where it began, within its range and error.
    pub fn state(
        &mut self,
        name: &str,
        meaning: String,
        start: &Tracked,
        word: &Tracked,
    ) -> Result<(usize, Tracked)> {
        let index = self.word_kept(name, Type::I32, meaning, start.operand, &word.range);
        let word = self.push(name, Op::State { index }, word.range.clone(), word.error.clone(), "")?;
        Ok((index, word))
    }

    /// Adds a word to the state, which keeps its start until it is given a next value; its index.
    fn word_kept(
        &mut self,
        name: &str,
        ty: Type,
        meaning: String,
        start: Operand,
        range: &Interval,
    ) -> usize {
        let range = whole(range);
        self.program.state.push(StateWord { name: name.into(), ty, meaning, start, next: start, range });
        self.program.state.len() - 1
    }

    /// A word of 64 bits of the state, within `range`.
    pub fn wide_state(
        &mut self,
        name: &str,
        meaning: String,
        start: Operand,
        range: Interval,
    ) -> Result<(usize, Wide)> {
        let index = self.word_kept(name, Type::I64, meaning, start, &range);
        Ok((index, self.push_wide(name, Op::State { index }, range)?))
    }

    fn push_wide(&mut self, name: &str, op: Op, range: Interval) -> Result<Wide> {
        self.fits(name, &range, Type::I64)?;
        Ok(Wide { operand: self.program.push(Stage::Evaluation, name, Type::I64, op, ""), range })
    }

    /// c + a·b, exactly, in 64 bits.
    pub fn mul_add_wide(&mut self, name: &str, (a, b): (&Tracked, i64), c: Option<&Wide>) -> Result<Wide> {
        let product = &a.range * &Interval::from_int(b);
        let range = c.map_or(product.clone(), |c| &product + &c.range);
        let c = c.map_or(Operand::Int(0), |c| c.operand);
        self.push_wide(name, Op::MulAddWide { a: a.operand, b: Operand::Int(b), c }, range)
    }

    /// ⌊a·2^−by⌋ of a wide word, which is known to be within `range` and `error`.
    pub fn high(
        &mut self,
        name: &str,
        a: &Wide,
        by: u32,
        range: Interval,
        error: &Interval,
    ) -> Result<Tracked> {
        let error = error + &Interval::from_int(1);
        self.push(name, Op::High { a: a.operand, by }, range, error, "")
    }

    /// What a word of the state is after the call.
    pub fn keep(&mut self, index: usize, next: Operand) {
        if let Some(word) = self.program.state.get_mut(index) {
            word.next = next;
        }
    }
}

/// The whole numbers that hold a range.
pub(super) fn whole(range: &Interval) -> (i64, i64) {
    (range.floor_to_i64().unwrap_or(i64::MIN), range.ceil_to_i64().unwrap_or(i64::MAX))
}
