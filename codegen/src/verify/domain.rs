//! Which inputs a routine can be given, numbered, and the sets of them that are swept.

use serde::Serialize;

use crate::interpret::Word;
use crate::program::{Program, Type};

/// Inputs are numbered by `index`; how an index becomes argument words.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum Domain {
    /// One argument: the index is its bit pattern.
    Single,
    /// Two 16-bit arguments: the index is x₁·2¹⁶ + x₂.
    Halves,
    /// Two wider integers, each `lo`…`hi`: the index is x₂ − x₁ + (`hi` − `lo`), x₁ is scattered.
    Differences {
        /// Smallest value of an argument.
        lo: i64,
        /// Largest value of an argument.
        hi: i64,
    },
    /// Two floats: the index is the bit pattern of a difference s, x₁ is scattered in ±`spread`, x₂ = x₁ + s.
    Floats {
        /// Largest magnitude of x₁.
        spread: f32,
    },
}

/// Inputs `first`, `first` + `stride`, …: `count` of them, modulo the number of inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sweep {
    /// Index of the first input.
    pub first: u64,
    /// How many.
    pub count: u64,
    /// From one to the next.
    pub stride: u64,
}

/// A set of inputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage {
    /// The sweeps that make it up.
    pub sweeps: Vec<Sweep>,
    /// Whether these are all inputs that the arguments' types can express.
    pub exhaustive: bool,
    /// What is covered, in words.
    pub what: String,
}

/// Inputs on each side of every end that a quick sweep looks at.
const NEAR_AN_END: u64 = 4096;
/// Stride of a quick sweep: a prime, so that all low bits occur; 1.07·10⁷ of 2³².
const QUICK_STRIDE: u64 = 401;
/// Stride of the inputs that are interpreted; a prime as well.
const INTERPRETED_STRIDE: u64 = 65_537;

impl Domain {
    /// The inputs of `program`.
    pub fn of(program: &Program) -> Self {
        let types: Vec<Type> = program.arguments.iter().map(|a| a.ty).collect();
        match types[..] {
            [_] => Domain::Single,
            [Type::U16, ..] => Domain::Halves,
            [Type::F32, ..] => {
                let (lo, hi) = program.valid;
                Domain::Floats { spread: lo.abs().max(hi.abs()) as f32 }
            }
            // A converter has 24 bits at most; a fixed-point word has all of its own.
            [Type::U32, ..] => Domain::Differences { lo: 0, hi: (1 << 24) - 1 },
            _ => Domain::Differences { lo: i32::MIN.into(), hi: i32::MAX.into() },
        }
    }

    /// The number of indices.
    pub fn size(&self, program: &Program) -> u64 {
        match self {
            Domain::Single if program.arguments[0].ty == Type::U16 => 1 << 16,
            Domain::Single | Domain::Halves | Domain::Floats { .. } => 1 << 32,
            Domain::Differences { lo, hi } => 2 * (hi - lo) as u64 + 1,
        }
    }

    /// Every index.
    pub fn all(&self, program: &Program) -> Coverage {
        let size = self.size(program);
        let what = match self {
            Domain::Single => format!("all {size} words of the argument, valid or not"),
            Domain::Halves => format!("all {size} pairs of arguments, valid or not"),
            Domain::Differences { .. } => {
                format!("all {size} differences x2 - x1, one pair of arguments for each; not all pairs")
            }
            Domain::Floats { .. } => {
                format!(
                    "all {size} bit patterns of s as a float, one pair x1, x1 + s for each; not all pairs"
                )
            }
        };
        let exhaustive = matches!(self, Domain::Single | Domain::Halves);
        Coverage { sweeps: vec![Sweep { first: 0, count: size, stride: 1 }], exhaustive, what }
    }

    /// Every 401st index, and all near the ends of the range and of the arguments' types; everything where
    /// there are few.
    pub fn quick(&self, program: &Program) -> Coverage {
        let near = format!("inputs, and all within {NEAR_AN_END} of an end; not all");
        self.part(program, 1 << 25, (QUICK_STRIDE, "st"), 2 * NEAR_AN_END, &near)
    }

    /// A set small enough for the interpreter, spread over everything.
    pub fn interpreted(&self, program: &Program) -> Coverage {
        self.part(program, 1 << 17, (INTERPRETED_STRIDE, "th"), NEAR_AN_END, "inputs, and the ends")
    }

    /// Everything up to `few`; of more every so many, and so many at every end.
    fn part(
        &self,
        program: &Program,
        few: u64,
        (stride, th): (u64, &str),
        near: u64,
        what: &str,
    ) -> Coverage {
        let size = self.size(program);
        if size <= few {
            return self.all(program);
        }
        let mut sweeps = vec![Sweep { first: 0, count: size.div_ceil(stride), stride }];
        sweeps.extend(self.near_ends(program).map(|first| Sweep { first, count: near, stride: 1 }));
        Coverage { sweeps, exhaustive: false, what: format!("every {stride}{th} of {size} {what}") }
    }

    /// The first index near each end of the range and of the arguments' types.
    fn near_ends(&self, program: &Program) -> impl Iterator<Item = u64> {
        let size = self.size(program);
        let index = |word: i64| match self {
            Domain::Differences { lo, hi } => (word + (hi - lo)).rem_euclid(size as i64) as u64,
            Domain::Halves => ((word.max(0) as u64) & 0xffff) + (((-word).max(0) as u64 & 0xffff) << 16),
            Domain::Single | Domain::Floats { .. } => u64::from(word as u32) % size,
        };
        let (lo, hi) = match program.steps[program.reading].ty {
            Type::F32 => (
                (program.valid.0 as f32).to_bits() as i32 as i64,
                (program.valid.1 as f32).to_bits() as i32 as i64,
            ),
            _ => (program.valid.0 as i64, program.valid.1 as i64),
        };
        // For floats the bit patterns of 0 and −0, of the infinities and of NaN are ends as well.
        let floats = [0x7f80_0000u32, 0xff80_0000].map(|bits| i64::from(bits as i32));
        let float = program.arguments[0].ty == Type::F32;
        let ends =
            [lo, hi, 0, i64::from(i32::MIN)].into_iter().chain(floats.into_iter().filter(move |_| float));
        ends.map(index).map(move |i| (i + size - NEAR_AN_END) % size).collect::<Vec<_>>().into_iter()
    }

    /// The argument words of an index, as bit patterns.
    pub fn words(&self, program: &Program, index: u64) -> Vec<u32> {
        let index = index % self.size(program);
        match self {
            Domain::Single => vec![index as u32],
            Domain::Halves => vec![(index >> 16) as u32, (index & 0xffff) as u32],
            Domain::Differences { lo, hi } => {
                let difference = index as i64 - (hi - lo);
                let (first, last) = ((lo - difference).max(*lo), (hi - difference).min(*hi));
                let scattered = ((last - first + 1) as u64).wrapping_mul(u64::from(scatter(index))) >> 32;
                let x1 = first + scattered as i64;
                vec![x1 as u32, (x1 + difference) as u32]
            }
            Domain::Floats { spread } => {
                let s = f32::from_bits(index as u32);
                let x1 = scatter(index) as i32 as f32 * (1.0 / 2_147_483_648.0) * spread;
                vec![x1.to_bits(), (x1 + s).to_bits()]
            }
        }
    }

    /// The arguments of an index.
    pub fn arguments(&self, program: &Program, index: u64) -> Vec<Word> {
        arguments(program, &self.words(program, index))
    }
}

impl Coverage {
    /// The indices of its inputs, sweep by sweep.
    pub fn indices(&self) -> impl Iterator<Item = u64> + '_ {
        let of = |s: &Sweep| {
            let Sweep { first, count, stride } = *s;
            (0..count).map(move |i| first.wrapping_add(i * stride))
        };
        self.sweeps.iter().flat_map(of)
    }
}

/// Bit patterns as arguments of a program.
pub fn arguments(program: &Program, words: &[u32]) -> Vec<Word> {
    let word = |(argument, bits): (&crate::program::Argument, &u32)| match argument.ty {
        Type::F32 => Word::Float(f32::from_bits(*bits)),
        Type::I32 => Word::Int((*bits as i32).into()),
        Type::U16 => Word::Int((*bits as u16).into()),
        _ => Word::Int((*bits).into()),
    };
    program.arguments.iter().zip(words).map(word).collect()
}

/// The arguments of a reading in its own words, as numbers: itself, or some pair of this difference.
pub(super) fn numbers_of(ty: Type, readings: usize, reading: f64) -> Vec<f64> {
    match ty.range() {
        _ if readings == 1 => vec![reading],
        None => vec![-0.5 * reading, 0.5 * reading],
        Some((lo, hi)) => {
            let (lo, hi) = (lo as f64, hi as f64);
            let first = ((lo + hi - reading) * 0.5).floor().clamp(lo, hi);
            vec![first, (first + reading).clamp(lo, hi)]
        }
    }
}

/// A fixed scattering of the lower 32 bits of an index.
pub fn scatter(index: u64) -> u32 {
    let h = (index as u32).wrapping_mul(0x9e37_79b1);
    (h ^ (h >> 15)).wrapping_mul(0x85eb_ca77)
}

/// An index's arguments for people: integers as they are, floats with their exact hexadecimal form.
pub fn describe(program: &Program, arguments: &[Word]) -> String {
    let one = |(argument, word): (&crate::program::Argument, &Word)| match word {
        Word::Int(v) => format!("{} = {v}", argument.name),
        Word::Float(v) => format!("{} = {v:?} (0x{:08x})", argument.name, v.to_bits()),
    };
    program.arguments.iter().zip(arguments).map(one).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Every index of differences gives a pair with that difference, both inside.
        #[test]
        fn differences_are_pairs(index in 0..(1u64 << 25) - 1) {
            let (lo, hi) = (0i64, (1i64 << 24) - 1);
            let words = Domain::Differences { lo, hi }.words(&Program::default(), index);
            let [x1, x2] = [words[0], words[1]].map(i64::from);
            prop_assert!(x1 >= lo && x1 <= hi && x2 >= lo && x2 <= hi);
            prop_assert_eq!(x2 - x1, index as i64 - (hi - lo));
        }

        /// The same of full words, where sums leave 32 bits.
        #[test]
        fn differences_of_full_words(index in 0..(1u64 << 33) - 1) {
            let (lo, hi) = (i64::from(i32::MIN), i64::from(i32::MAX));
            let words = Domain::Differences { lo, hi }.words(&Program::default(), index);
            let [x1, x2] = [words[0], words[1]].map(|w| i64::from(w as i32));
            prop_assert_eq!(x2 - x1, index as i64 - (hi - lo));
        }
    }
}
