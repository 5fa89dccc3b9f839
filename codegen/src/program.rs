//! The routine as an explicit program of typed operations.
//!
//! This one object is interpreted ([`crate::interpret`]), bounded (`bound`) and rendered
//! ([`crate::render`]): what is proved is what is printed. Every word length, shift and rounding stands
//! here; the back-ends take no arithmetic decision.

use serde::{Deserialize, Serialize};

/// A machine type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// Unsigned, 16 bits.
    U16,
    /// Unsigned, 32 bits.
    U32,
    /// Signed, 32 bits.
    I32,
    /// Signed, 64 bits.
    I64,
    /// IEEE 754 binary32.
    F32,
}

impl Type {
    /// Smallest and largest value of an integer type; `None` for a float.
    pub fn range(self) -> Option<(i64, i64)> {
        match self {
            Type::U16 => Some((0, u16::MAX.into())),
            Type::U32 => Some((0, u32::MAX.into())),
            Type::I32 => Some((i32::MIN.into(), i32::MAX.into())),
            Type::I64 => Some((i64::MIN, i64::MAX)),
            Type::F32 => None,
        }
    }

    /// As the certificate names it.
    pub fn name(self) -> &'static str {
        match self {
            Type::U16 => "u16",
            Type::U32 => "u32",
            Type::I32 => "i32",
            Type::I64 => "i64",
            Type::F32 => "f32",
        }
    }
}

/// What an operation works on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Operand {
    /// The result of an earlier step.
    Step(usize),
    /// An integer constant.
    Int(i64),
    /// A float constant.
    Float(f32),
}

/// One operation. Integers never overflow (proved by `bound`); floats round to nearest, ties to even.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // what the variants say of them
pub enum Op {
    /// The routine's argument number `index`.
    Input { index: usize },
    /// The coefficient number `index` of the page that the routine is given.
    Word { index: usize },
    /// The word of the routine's state number `index`, as the call before left it.
    State { index: usize },
    /// a + b of integers, exactly.
    Add { a: Operand, b: Operand },
    /// a − b, exactly: of two floats rounded once.
    Sub { a: Operand, b: Operand },
    /// a limited to lo…hi and narrowed to `i32`.
    Clamp { a: Operand, lo: i64, hi: i64 },
    /// a limited to lo…hi; NaN counts as below.
    ClampF32 { a: Operand, lo: f32, hi: f32 },
    /// a·2^by, exactly.
    ShiftLeft { a: Operand, by: u32 },
    /// ⌊(a + add)·2^−by⌋, of integers.
    ShiftRight { a: Operand, add: i64, by: u32 },
    /// ⌊(a + add)·2^−by⌋, of an unsigned result where 0 ≤ a + add < 2³²: the number of a table's segment.
    Index { a: Operand, add: i64, by: u32 },
    /// ⌊a·factor·2^−by⌋ less the multiple of 2³² that makes it a signed word: a phase, the turn being 2³².
    Phase { a: Operand, factor: i64, by: u32 },
    /// (a + add)·2^by less the multiple of 2³² that makes it a signed word: the place within a segment.
    Wrap { a: Operand, add: i64, by: u32 },
    /// ⌊a·2^−from⌋ modulo 2^bits: a field of bits of a word, of which the type only says how it is taken.
    Bits { a: Operand, from: u32, bits: u32 },
    /// a·2^by + b + add modulo 2³².
    Shifted { a: Operand, by: u32, b: Operand, add: i64 },
    /// A sum modulo 2³², taken as a signed number of −turn to 2·turn, modulo the turn: in 0…turn − 1.
    Around { a: Operand, turn: u32 },
    /// Entry `column` of row `index` of the table.
    Entry { index: Operand, column: usize },
    /// c + a·b in 64 bits, exactly; b a constant.
    MulAddWide { a: Operand, b: Operand, c: Operand },
    /// ⌊a·2^−by⌋ of a word of 64 bits, by ≥ 31.
    High { a: Operand, by: u32 },
    /// A float to an integer, toward zero.
    Truncate { a: Operand },
    /// An integer to a float, to nearest.
    ToF32 { a: Operand },
    /// a·b of two floats, rounded once.
    MulF32 { a: Operand, b: Operand },
    /// c + ⌊a·b·2⁻³²⌋·2^shift: a 32×32→64-bit product of which the high word is kept.
    MulAddHigh { a: Operand, b: Operand, shift: u32, c: Operand },
    /// The same from 16-bit halves, for cores without a long product: with a = a₁2¹⁶ + a₀, b = b₁2¹⁶ + b₀,
    /// c + (a₁b₁ + ⌊(a₁⌊b₀/2⌋ + a₀⌊b₁/2⌋)·2⁻¹⁵⌋)·2^shift; a₀b₀ is left out.
    MulAddSplit { a: Operand, b: Operand, shift: u32, c: Operand },
    /// c + ⌊a·b·2^−by⌋ of two 16-bit numbers, 0 < by: the product fits 32 bits.
    MulAddShort { a: Operand, b: Operand, by: u32, c: Operand },
    /// c + a·b of floats, rounded after the product and after the sum; `fused`, once.
    MulAddF32 { a: Operand, b: Operand, c: Operand, fused: bool },
}

impl Op {
    /// Whether it multiplies floats by a power of two: exactly, but for what falls below the smallest normal number.
    pub fn scales(&self) -> bool {
        let power = |operand: &Operand| matches!(operand, Operand::Float(f) if f.to_bits() << 9 == 0);
        match self {
            Op::MulF32 { a, b } | Op::MulAddF32 { a, b, .. } => power(a) || power(b),
            _ => false,
        }
    }

    /// What the operation reads, in the order of its fields.
    pub fn operands(&self) -> Vec<Operand> {
        self.clone().places().into_iter().map(|place| *place).collect()
    }

    /// The same operation on other operands: every one replaced by what `by` makes of it.
    #[must_use]
    pub fn on(&self, by: impl Fn(Operand) -> Operand) -> Op {
        let mut op = self.clone();
        op.places().into_iter().for_each(|place| *place = by(*place));
        op
    }

    fn places(&mut self) -> Vec<&mut Operand> {
        match self {
            Op::Input { .. } | Op::State { .. } | Op::Word { .. } => vec![],
            Op::Add { a, b } | Op::Sub { a, b } | Op::MulF32 { a, b } | Op::Shifted { a, b, .. } => {
                vec![a, b]
            }
            Op::Clamp { a, .. }
            | Op::ClampF32 { a, .. }
            | Op::ShiftLeft { a, .. }
            | Op::ShiftRight { a, .. }
            | Op::Index { a, .. }
            | Op::Wrap { a, .. }
            | Op::Bits { a, .. }
            | Op::Around { a, .. }
            | Op::Phase { a, .. }
            | Op::High { a, .. }
            | Op::Truncate { a }
            | Op::ToF32 { a } => vec![a],
            Op::Entry { index, .. } => vec![index],
            Op::MulAddHigh { a, b, c, .. }
            | Op::MulAddSplit { a, b, c, .. }
            | Op::MulAddShort { a, b, c, .. }
            | Op::MulAddWide { a, b, c }
            | Op::MulAddF32 { a, b, c, .. } => vec![a, b, c],
        }
    }
}

/// Which part of the routine a step belongs to; its rounding is listed there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// From the arguments to the normalised variable.
    Input,
    /// From the normalised variable to the angle.
    Evaluation,
    /// From the angle to the output's format.
    Output,
}

/// An operation with its result's type and name.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// What is done.
    pub op: Op,
    /// Type of the result.
    pub ty: Type,
    /// Name of the variable that takes the result; a name that repeats is assigned again.
    pub name: String,
    /// What the step means, for the reader of the generated source.
    pub note: String,
    /// Where its rounding is listed.
    pub stage: Stage,
}

/// An argument of the routine.
#[derive(Debug, Clone, PartialEq)]
pub struct Argument {
    /// Its name, an identifier.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Its meaning and unit, for the reader of the generated source.
    pub meaning: String,
}

/// A word that a routine keeps from one call to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct StateWord {
    /// Its name, an identifier.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Its meaning, for the reader of the generated source.
    pub meaning: String,
    /// What it is before the first call, given that call's arguments: a constant, or a step that reads no state.
    pub start: Operand,
    /// What it is after a call.
    pub next: Operand,
    /// The smallest and the largest that it can be, whatever the history.
    pub range: (i64, i64),
}

/// A coefficient that a routine is given, and the range that the proof holds for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PageWord {
    /// Its name, an identifier.
    pub name: String,
    /// Smallest value.
    pub from: i64,
    /// Largest value: that of one unit is a range of one word.
    pub to: i64,
}

/// A whole routine: steps in order, each using earlier ones only.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    /// The arguments.
    pub arguments: Vec<Argument>,
    /// The operations.
    pub steps: Vec<Step>,
    /// The step that holds the reading as it came: the argument, or the difference of the two.
    pub reading: usize,
    /// The step that limits the reading to the valid range.
    pub clamped: usize,
    /// Smallest and largest valid reading in the reading's own words.
    pub valid: (f64, f64),
    /// Rows of coefficients that `Entry` reads; empty without a table.
    pub table: Vec<Vec<i64>>,
    /// Bytes of an entry of the table, where it is not a word of 32 bits.
    pub narrow_entry: Option<usize>,
    /// The step that holds the normalised variable, word = v·2^`variable_exponent`.
    pub variable: usize,
    /// See `variable`.
    pub variable_exponent: i64,
    /// What is kept from call to call; empty for a function.
    pub state: Vec<StateWord>,
    /// Coefficients that arrive in a page ([`crate::devices`]); empty for a routine with its own.
    pub page: Vec<PageWord>,
}

impl Program {
    /// The last step: the routine's result.
    pub fn output(&self) -> usize {
        self.steps.len() - 1
    }

    /// The type of the result.
    pub fn output_type(&self) -> Type {
        self.steps[self.output()].ty
    }

    /// Makes the last step the normalised variable and calls it `x`, unless it is an argument.
    pub fn name_variable(&mut self) {
        self.variable = self.output();
        let step = &mut self.steps[self.variable];
        if !matches!(step.op, Op::Input { .. }) {
            step.name = "x".into();
        }
    }

    /// The steps that the state's start needs, in their order.
    pub fn start_steps(&self) -> Vec<usize> {
        self.needed(self.state.iter().map(|word| word.start))
    }

    /// The steps that a call needs, in their order.
    pub fn update_steps(&self) -> Vec<usize> {
        let results = [self.output(), self.reading, self.clamped].map(Operand::Step);
        self.needed(self.state.iter().map(|word| word.next).chain(results))
    }

    /// The steps of which a source is written: of a term that vanishes there may be others.
    pub fn written_steps(&self) -> Vec<usize> {
        let mut written = [self.start_steps(), self.update_steps()].concat();
        written.sort_unstable();
        written.dedup();
        written
    }

    /// The steps that lead to some operands, in their order.
    pub fn needed(&self, wanted: impl Iterator<Item = Operand>) -> Vec<usize> {
        let mut needed = vec![false; self.steps.len()];
        let mark = |needed: &mut Vec<bool>, operand: Operand| {
            if let Operand::Step(i) = operand {
                needed[i] = true;
            }
        };
        wanted.for_each(|operand| mark(&mut needed, operand));
        for index in (0..self.steps.len()).rev() {
            if needed[index] {
                self.steps[index].op.operands().into_iter().for_each(|o| mark(&mut needed, o));
            }
        }
        (0..self.steps.len()).filter(|i| needed[*i]).collect()
    }

    /// Bytes of flash that the table takes.
    pub fn table_bytes(&self) -> usize {
        self.entry_bytes() * self.table.iter().map(Vec::len).sum::<usize>()
    }

    /// Bytes of an entry of the table.
    pub fn entry_bytes(&self) -> usize {
        self.narrow_entry.unwrap_or(4)
    }

    /// ⌊(word + add)·2^−by⌋ of the table's row, where there is a table: (add, by).
    pub fn index(&self) -> Option<(i64, u32)> {
        self.steps
            .iter()
            .find_map(|s| if let Op::Index { add, by, .. } = s.op { Some((add, by)) } else { None })
    }

    /// Appends a step and gives the operand that stands for it.
    pub fn push(&mut self, stage: Stage, name: &str, ty: Type, op: Op, note: impl Into<String>) -> Operand {
        self.steps.push(Step { op, ty, name: name.into(), note: note.into(), stage });
        Operand::Step(self.output())
    }
}
