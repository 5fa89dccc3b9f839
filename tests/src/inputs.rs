//! The words that a routine is given, at random and at every edge, and the reading that they stand for: computed
//! from the options alone, in `f64`, independently of how `codegen` plans its inputs.

use codegen::input::{Arity, Encoding, Input};
use codegen::interpret::Word;
use codegen::program::{Program, Type};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The bits of the two arguments; the second is 0 where there is one only.
pub type Words = [u32; 2];

/// What words mean for a routine.
#[derive(Debug, Clone, Copy)]
pub struct Meaning {
    input: Input,
    /// 2³¹ of a Q31 word stands for this.
    full_scale: f64,
    /// Smallest and largest reading of the valid range.
    pub range: (f64, f64),
}

impl Meaning {
    /// Of a routine with this input over this range.
    pub fn new(input: Input, range: (f64, f64)) -> Meaning {
        let largest = range.0.abs().max(range.1.abs());
        let full_scale = match input.encoding {
            Encoding::Q31 { full_scale: Some(value) } => value,
            // As documented: the smallest power of two above the range.
            _ => (-1000..1000).map(|e| 2f64.powi(e)).find(|p| *p >= largest).unwrap_or(f64::INFINITY),
        };
        Meaning { input, full_scale, range }
    }

    /// One number.
    fn number(&self, bits: u32) -> f64 {
        match self.input.encoding {
            Encoding::F32 => f64::from(f32::from_bits(bits)),
            Encoding::Q31 { .. } => f64::from(bits as i32) * (self.full_scale / 2f64.powi(31)),
            Encoding::Counts { gain, offset, .. } => (f64::from(bits) - offset) * gain,
        }
    }

    /// The exact reading, to a few roundings of `f64`.
    pub fn reading(&self, words: Words) -> f64 {
        match (self.input.arity, self.input.encoding) {
            (Arity::Reading, _) => self.number(words[0]),
            // The offsets cancel.
            (Arity::Probes, Encoding::Counts { gain, .. }) => {
                (f64::from(words[1]) - f64::from(words[0])) * gain
            }
            (Arity::Probes, _) => self.number(words[1]) - self.number(words[0]),
        }
    }

    /// Whether the reading lies in the valid range.
    pub fn in_range(&self, words: Words) -> bool {
        (self.range.0..=self.range.1).contains(&self.reading(words))
    }

    /// The word nearest to a number, saturating.
    fn word(&self, number: f64) -> u32 {
        match self.input.encoding {
            Encoding::F32 => (number as f32).to_bits(),
            Encoding::Q31 { .. } => (number / self.full_scale * 2f64.powi(31)).round() as i32 as u32,
            Encoding::Counts { bits, gain, offset } => {
                (number / gain + offset).round().clamp(0.0, f64::from((1u32 << bits) - 1)) as u32
            }
        }
    }

    /// Words for a reading; two probes share it at random about `rest`.
    pub fn words(&self, reading: f64, random: &mut impl Rng) -> Words {
        match self.input.arity {
            Arity::Reading => [self.word(reading), 0],
            Arity::Probes => {
                let zero = match self.input.encoding {
                    Encoding::Counts { .. } => 0.0,
                    _ => 0.1 * random.random_range(-1.0..1.0) * reading,
                };
                let first = self.word(zero - 0.5 * reading * random.random_range(0.8..1.2));
                // The second takes what the first, rounded, leaves.
                let second = self.word(reading + self.number(first));
                [first, second]
            }
        }
    }

    /// The words next to these: one step up or down in either argument.
    fn neighbour(&self, words: Words, random: &mut impl Rng) -> Words {
        let step = random.random_range(-2i32..=2);
        let which = match self.input.arity {
            Arity::Reading => 0,
            Arity::Probes => random.random_range(0..2usize),
        };
        let mut near = words;
        near[which] = match self.input.encoding {
            Encoding::F32 => (0..step.unsigned_abs())
                .fold(f32::from_bits(near[which]), |v, _| if step > 0 { v.next_up() } else { v.next_down() })
                .to_bits(),
            Encoding::Q31 { .. } => (near[which] as i32).saturating_add(step) as u32,
            Encoding::Counts { bits, .. } => {
                (i64::from(near[which]) + i64::from(step)).clamp(0, (1 << bits) - 1) as u32
            }
        };
        near
    }

    /// `count` inputs from a seed: a half spread over the range, a quarter at its ends, around zero and
    /// around its middle, the rest anywhere that the type allows, its extremes among them.
    pub fn samples(&self, seed: u64, count: usize) -> Vec<Words> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (from, to) = self.range;
        let extremes = self.extremes();
        (0..count)
            .map(|i| match i % 8 {
                0..4 => {
                    let reading = random.random_range(from..=to);
                    self.words(reading, &mut random)
                }
                4 | 5 => {
                    let places = [from, to, 0.0, 0.5 * (from + to)];
                    let place = places[random.random_range(0..places.len())];
                    let words = self.words(place, &mut random);
                    self.neighbour(words, &mut random)
                }
                6 => [random.random(), random.random()].map(|bits| self.kept(bits)),
                _ => std::array::from_fn(|_| extremes[random.random_range(0..extremes.len())]),
            })
            .collect()
    }

    /// Bits as the argument's type keeps them.
    fn kept(&self, bits: u32) -> u32 {
        match self.input.encoding {
            Encoding::Counts { bits: width, .. } if width <= 16 => bits & 0xffff,
            _ => bits,
        }
    }

    /// The extreme words of the type: also those that no converter gives.
    fn extremes(&self) -> Vec<u32> {
        match self.input.encoding {
            Encoding::F32 => [
                0.0,
                -0.0,
                f32::MIN_POSITIVE,
                f32::from_bits(1),
                -f32::from_bits(1),
                1.0,
                -1.0,
                f32::MAX,
                f32::MIN,
                f32::INFINITY,
                f32::NEG_INFINITY,
                f32::NAN,
                -f32::NAN,
            ]
            .map(f32::to_bits)
            .to_vec(),
            Encoding::Q31 { .. } => [0, 1, -1, i32::MAX, i32::MIN, i32::MIN + 1].map(|v| v as u32).to_vec(),
            Encoding::Counts { bits, .. } => {
                let full = (1u32 << bits) - 1;
                vec![0, 1, full, full - 1, self.kept(u32::MAX), self.kept(full + 1)]
            }
        }
    }
}

/// The words as the interpreter takes them.
pub fn for_interpreter(program: &Program, words: Words) -> Vec<Word> {
    let word = |(index, argument): (usize, &codegen::program::Argument)| match argument.ty {
        Type::F32 => Word::Float(f32::from_bits(words[index])),
        Type::I32 => Word::Int((words[index] as i32).into()),
        _ => Word::Int(words[index].into()),
    };
    program.arguments.iter().enumerate().map(word).collect()
}
