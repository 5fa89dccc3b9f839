//! The ways to write the correction of a count, as programs: a table of every count, or polynomials of the place
//! within a segment, the segments being 2ᵏ to the turn.
//!
//! All of them add the correction to the count and keep the result modulo the turn. Where that is a power of two the
//! wrap needs no case of its own; of another number of counts the reading is limited to the last of them, and the sum
//! brought back by a turn where it lies beyond either end. Corrections are words of 2^−fraction of a count of the
//! result.

use crate::program::{Argument, Op, Operand, Program, Stage, Type};

/// Widths of the counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Words {
    /// Counts of a turn, at least [`super::FEWEST_COUNTS`].
    pub counts: u32,
    /// How much finer the result is, as a power of two.
    pub finer: u32,
}

impl Words {
    /// Bits of the encoder's word.
    pub fn input(&self) -> u32 {
        self.counts.next_power_of_two().trailing_zeros()
    }

    /// Bits of the corrected word.
    pub fn output(&self) -> u32 {
        self.input() + self.finer
    }

    /// Counts of a turn of the result.
    pub fn result_counts(&self) -> u32 {
        self.counts << self.finer
    }

    /// Whether every word of so many bits is a count, so that a word wraps round as the turn does.
    pub fn whole(&self) -> bool {
        self.counts.is_power_of_two()
    }

    /// The reading of a count, the turn being 2⁶⁴: below the exact one by less than 1 where the turn is no power of two.
    pub fn reading(&self, count: u32) -> u64 {
        ((u128::from(count) << 64) / u128::from(self.counts)) as u64
    }

    /// What is counted in words of which the turn has 2⁶⁴, in counts of the result.
    pub fn in_counts(&self, words: f64) -> f64 {
        words * f64::from(self.result_counts()) / 2f64.powi(64)
    }

    /// The most fractional bits of a correction: of a turn that is no power of two the sum is a signed word of up to
    /// two turns.
    pub(super) fn most_fraction(&self) -> u32 {
        32 - self.output() - if self.whole() { 0 } else { 2 }
    }

    /// The type of a word of so many bits.
    pub(super) fn ty(bits: u32) -> Type {
        if bits <= 16 { Type::U16 } else { Type::U32 }
    }
}

/// The arithmetic of the polynomials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// Coefficients of 16 bits, products that fit 32; the place counts from the segment's start.
    Short,
    /// Coefficients of 32 bits, high words of 64-bit products; the place is a signed fraction about the middle.
    Long,
}

/// One way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A correction for each count.
    PerCount,
    /// Polynomials.
    Segments {
        /// Their degree.
        degree: usize,
        /// Their number as a power of two.
        segments_log2: u32,
        /// How they are evaluated.
        arithmetic: Arithmetic,
    },
}

/// What stands in a program beside its structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Filling {
    /// Coefficients, constant first, one row for each segment (of a table: for each count).
    pub table: Vec<Vec<i64>>,
    /// Right shift of the product with the coefficient of degree 1, 2 … in short arithmetic.
    pub shifts: Vec<u32>,
    /// Fractional bits of the correction.
    pub fraction: u32,
    /// What is added to every count of the result, modulo its width.
    pub zero: i64,
}

impl Shape {
    /// All that are tried for a width.
    pub fn all(words: Words) -> Vec<Shape> {
        let mut all = vec![Shape::PerCount];
        let mut push = |degree, segments_log2, arithmetic| {
            all.push(Shape::Segments { degree, segments_log2, arithmetic });
        };
        for degree in 3..=LARGEST_DEGREE {
            push(degree, 0, Arithmetic::Long);
        }
        for segments_log2 in 1..words.input() {
            for degree in 1..=3 {
                push(degree, segments_log2, Arithmetic::Long);
                let place = words.input() - segments_log2;
                if place <= MOST_PLACE_BITS {
                    push(degree, segments_log2, Arithmetic::Short);
                }
            }
        }
        all
    }

    /// Number of polynomials; of a table of every count 1. The last one's segment may reach beyond the turn.
    pub fn segments(&self, words: Words) -> usize {
        match self {
            Shape::PerCount => 1,
            Shape::Segments { .. } => words.counts.div_ceil(1 << self.place_bits(words)) as usize,
        }
    }

    /// Bits of the place within a segment.
    pub(super) fn place_bits(&self, words: Words) -> u32 {
        match self {
            Shape::PerCount => 0,
            Shape::Segments { segments_log2, .. } => words.input() - segments_log2,
        }
    }

    /// Bytes of an entry of the table, where fewer than four hold all of them.
    fn narrow_entry(&self, filling: &Filling) -> Option<usize> {
        match self {
            Shape::PerCount => match filling.table.iter().flatten().map(|c| c.unsigned_abs()).max() {
                None | Some(0..=127) => Some(1),
                Some(128..=32767) => Some(2),
                Some(_) => None,
            },
            Shape::Segments { arithmetic: Arithmetic::Short, .. } => Some(2),
            Shape::Segments { arithmetic: Arithmetic::Long, .. } => None,
        }
    }

    /// The program.
    pub fn program(&self, words: Words, filling: &Filling) -> Program {
        let mut p = Program {
            arguments: vec![Argument {
                name: "count".into(),
                ty: Words::ty(words.input()),
                meaning: format!("the encoder's word, {} counts to the turn", words.counts),
            }],
            valid: (0.0, f64::from(words.counts - 1)),
            table: filling.table.clone(),
            narrow_entry: self.narrow_entry(filling),
            ..Program::default()
        };
        let mut count = p.push(Stage::Input, "count", Words::ty(words.input()), Op::Input { index: 0 }, "");
        if !words.whole() {
            let last = Op::Clamp { a: count, lo: 0, hi: i64::from(words.counts - 1) };
            count = p.push(Stage::Input, "limited", Type::U32, last, "to the last count");
        }
        let correction = match *self {
            Shape::PerCount => {
                let index = if words.whole() {
                    let index = Op::Bits { a: count, from: 0, bits: words.input() };
                    p.push(Stage::Evaluation, "index", Type::U32, index, "")
                } else {
                    count
                };
                p.push(Stage::Evaluation, "correction", Type::I32, Op::Entry { index, column: 0 }, "")
            }
            Shape::Segments { degree, segments_log2, arithmetic } => {
                polynomial(&mut p, count, words, filling, degree, segments_log2, arithmetic)
            }
        };
        let by = words.finer + filling.fraction;
        // Half a count of the result, for the rounding to nearest.
        let half = if filling.fraction > 0 { 1i64 << (filling.fraction - 1) } else { 0 };
        let add = (filling.zero << filling.fraction) + half;
        let sum = Op::Shifted { a: count, by, b: correction, add: add.rem_euclid(1 << 32) };
        let mut sum = p.push(Stage::Output, "sum", Type::U32, sum, "modulo 2³²");
        if !words.whole() {
            let turn = Op::Around { a: sum, turn: words.result_counts() << filling.fraction };
            sum = p.push(Stage::Output, "within", Type::U32, turn, "modulo the turn");
        }
        let result = Op::Bits { a: sum, from: filling.fraction, bits: words.output() };
        p.push(Stage::Output, "corrected", Words::ty(words.output()), result, "");
        p
    }
}

/// The highest degree of one polynomial for the whole turn.
const LARGEST_DEGREE: usize = 16;
/// A place of more bits, times a coefficient of 16, leaves 32 bits.
const MOST_PLACE_BITS: u32 = 15;

fn polynomial(
    p: &mut Program,
    count: Operand,
    words: Words,
    filling: &Filling,
    degree: usize,
    segments_log2: u32,
    arithmetic: Arithmetic,
) -> Operand {
    let place_bits = words.input() - segments_log2;
    let stage = Stage::Evaluation;
    let segment = (segments_log2 > 0).then(|| {
        let bits = Op::Bits { a: count, from: place_bits, bits: segments_log2 };
        p.push(stage, "segment", Type::U32, bits, "")
    });
    let place = match arithmetic {
        Arithmetic::Short => {
            let low = Op::Bits { a: count, from: 0, bits: place_bits };
            p.push(stage, "place", Type::I32, low, "within the segment")
        }
        Arithmetic::Long => {
            let wrap = Op::Wrap { a: count, add: 1 << (place_bits - 1), by: 32 - place_bits };
            p.push(stage, "place", Type::I32, wrap, "within the segment, from its middle")
        }
    };
    let coefficient = |p: &mut Program, k: usize| match segment {
        Some(index) => p.push(stage, &format!("c{k}"), Type::I32, Op::Entry { index, column: k }, ""),
        None => Operand::Int(filling.table[0][k]),
    };
    let mut y = coefficient(p, degree);
    for k in (0..degree).rev() {
        let c = coefficient(p, k);
        let op = match arithmetic {
            Arithmetic::Short => Op::MulAddShort { a: y, b: place, by: filling.shifts[k], c },
            Arithmetic::Long => Op::MulAddHigh { a: y, b: place, shift: 0, c },
        };
        let name = if k == 0 { "correction" } else { "y" };
        y = p.push(stage, name, Type::I32, op, "");
    }
    if segment.is_none() {
        p.table.clear();
    }
    y
}
