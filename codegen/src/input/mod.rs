//! What a routine is given: the two probes' displacements or their difference, as floats, as Q31 words or as
//! counts of an analogue-to-digital converter; and how it becomes the normalised variable v.

mod float;
mod integer;

use fitter::error_model::Sensor;

use crate::exact::Interval;
use crate::format::Format;
use crate::program::{Argument, Op, Operand, Program, Stage, Step, Type};
use crate::reference::ReadingMap;

/// The form in which one number arrives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Encoding {
    /// The reading itself in the sensor's unit (pair: millimetres).
    F32,
    /// A fraction of `full_scale` (in the sensor's unit) with 31 fractional bits.
    Q31 {
        /// What 2³¹ stands for; `None`: the smallest power of two above the range.
        full_scale: Option<f64>,
    },
    /// Counts: number = (count − offset)·gain, in the sensor's unit.
    Counts {
        /// Width of the converter's word.
        bits: u32,
        /// Change of the number by one count; not zero.
        gain: f64,
        /// The count that stands for zero; cancels in a difference of two probes.
        offset: f64,
    },
}

/// Whether both probes or one number are handed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arity {
    /// The reading: s = x₂ − x₁ of a pair, or a direct sensor's reading.
    Reading,
    /// x₁ and x₂ of a pair; the routine takes the difference.
    Probes,
}

/// The input of a routine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// How many numbers.
    pub arity: Arity,
    /// In which form.
    pub encoding: Encoding,
}

/// The first steps of a program, up to the normalised variable, and what the variable means.
#[derive(Debug, Clone)]
pub struct InputPlan {
    /// A program that ends with the variable.
    pub program: Program,
    /// What v means.
    pub map: ReadingMap,
    /// Smallest and largest word of the variable (v·2^exponent), as points.
    pub word_from: Interval,
    /// See `word_from`.
    pub word_to: Interval,
    /// All words that can arrive at the variable, valid or not; the same where the range is clamped.
    pub reach: (Interval, Interval),
    /// The reading step as c₀ + c₁v, before any rounding, in its own words.
    pub reading_word: (Interval, Interval),
    /// The change of the reading (in its unit) by one step of the input, 0 for a float.
    pub resolution: f64,
}

fitter::errors! {
    /// What is wrong with an input for a range.
    #[derive(Debug, Clone, PartialEq)]
    pub enum InputError {
        OneReading => says("a direct sensor has one reading") mend("use an input without x1x2");
        Gain(it: f64) =>
            says("the converter's gain is {it}")
            mend("give the change of the reading by one count, a positive number") by(gain);
        Bits(it: u32) => says("a converter of {it} bits") mend("give 1 to 24") by(bits);
        FullScale(it: f64) =>
            says("the full scale is {it}")
            mend("give the reading that the largest word stands for, a positive number") by(full_scale);
        DoesNotReach { from: f64, to: f64, range_from: f64, range_to: f64, what: &'static str } =>
            says("the input reaches {from}…{to} only, the range is {range_from}…{range_to}")
            mend("narrow the range or change {what}") by(range);
        NoResolution(a: f64, b: f64) => says("the range {a}…{b} holds fewer than two inputs of this form");
        Unlimited =>
            says("this input needs its limits, or some argument would overflow")
            mend("clamp or flag readings outside the range (to continue goes with q31, with counts of 16 bits or less, \
                and with floats in format f32)") by(out_of_range);
        BeyondFloat(a: f64, b: f64) => says("the range {a}…{b} is beyond what a 32-bit float holds");
    }
}

impl InputPlan {
    /// Smallest and largest v of the range, as points.
    pub fn range_in_v(&self) -> (Interval, Interval) {
        self.in_v((&self.word_from, &self.word_to))
    }

    /// Smallest and largest v of any argument, valid or not, as points.
    pub fn reach_in_v(&self) -> (Interval, Interval) {
        self.in_v((&self.reach.0, &self.reach.1))
    }

    fn in_v(&self, (from, to): (&Interval, &Interval)) -> (Interval, Interval) {
        let exponent = -self.program.variable_exponent;
        (from.mul_pow2(exponent), to.mul_pow2(exponent))
    }

    /// The same without a last shift to the left: for a table, whose index and place are shifted anyway. As it
    /// is where there is no such shift, or where the words before it have fewer than `bits` bits.
    #[must_use]
    pub fn unshifted(&self, bits: u32) -> InputPlan {
        let mut plan = self.clone();
        let Some(Step { op: Op::ShiftLeft { a: Operand::Step(before), by }, .. }) = plan.program.steps.last()
        else {
            return plan;
        };
        let (before, by) = (*before, i64::from(*by));
        if before + 2 != plan.program.steps.len()
            || plan.program.steps[before].ty != Type::I32
            || plan.program.variable_exponent - by < i64::from(bits)
        {
            return plan;
        }
        plan.program.steps.pop();
        plan.program.variable_exponent -= by;
        plan.program.name_variable();
        let ends = [&mut plan.word_from, &mut plan.word_to, &mut plan.reach.0, &mut plan.reach.1];
        for word in ends {
            *word = word.mul_pow2(-by);
        }
        plan
    }
}

impl Input {
    /// Plans the steps from the arguments to the variable of a format, for readings `from`…`to` of `sensor`.
    ///
    /// Without `clamped` nothing limits the reading: the range is where the bound will hold, and every input
    /// reaches the variable.
    ///
    /// The plan's range is the set of representable inputs inside `from`…`to`, never wider.
    ///
    /// # Errors
    /// [`InputError`] where the encoding does not fit the sensor or the range.
    pub fn plan(
        &self,
        sensor: &Sensor,
        from: f64,
        to: f64,
        format: Format,
        clamped: bool,
    ) -> Result<InputPlan, InputError> {
        if self.arity == Arity::Probes && matches!(sensor, Sensor::Direct { .. }) {
            return Err(InputError::OneReading);
        }
        let (unit, pair) = match sensor {
            Sensor::EddyCurrentPair { .. } => ("mm", true),
            Sensor::Direct { unit, .. } => (unit.as_str(), false),
        };
        let asked = Asked { arity: self.arity, unit, pair, from, to, format, clamped };
        match self.encoding {
            Encoding::F32 => float::plan(&asked),
            Encoding::Q31 { full_scale } => {
                let largest = from.abs().max(to.abs());
                let full_scale = full_scale.unwrap_or_else(|| power_of_two(exponent_above(largest)));
                if !(full_scale.is_finite() && full_scale > 0.0) {
                    return Err(InputError::FullScale(full_scale));
                }
                let lsb = Interval::from_f64(full_scale).mul_pow2(-31);
                let meaning = format!("2⁻³¹ of {full_scale} {unit}");
                let word = integer::Word {
                    ty: Type::I32,
                    lsb,
                    offset: Interval::zero(),
                    lo: i32::MIN.into(),
                    hi: i32::MAX.into(),
                    meaning,
                    what: "the full scale",
                };
                integer::plan(&asked, &word)
            }
            Encoding::Counts { bits, gain, offset } => {
                if !(gain.is_finite() && gain > 0.0) {
                    return Err(InputError::Gain(gain));
                }
                if !(1..=24).contains(&bits) {
                    return Err(InputError::Bits(bits));
                }
                let ty = if bits <= 16 { Type::U16 } else { Type::U32 };
                let both = self.arity == Arity::Probes;
                let meaning = if both {
                    format!("counts of a {bits}-bit converter, {gain} {unit} each")
                } else {
                    format!("counts of a {bits}-bit converter, {gain} {unit} each, zero at {offset}")
                };
                let word = integer::Word {
                    ty,
                    lsb: Interval::from_f64(gain),
                    offset: if both { Interval::zero() } else { Interval::from_f64(offset) },
                    lo: 0,
                    hi: (1 << bits) - 1,
                    meaning,
                    what: "the converter's bits, gain or offset",
                };
                integer::plan(&asked, &word)
            }
        }
    }
}

/// What a plan is for.
struct Asked<'a> {
    arity: Arity,
    /// The unit of the reading; `pair` where that is the difference of two probes.
    unit: &'a str,
    pair: bool,
    from: f64,
    to: f64,
    /// Of the evaluation: the variable is a float, or a signed word v·2^(bits + 1) with magnitude below 2^bits.
    format: Format,
    clamped: bool,
}

/// The smallest e with 2^e ≥ x, for 0 < x < ∞.
pub(crate) fn exponent_above(x: f64) -> i64 {
    let mut exponent = 0;
    while power_of_two(exponent) < x {
        exponent += 1;
    }
    while exponent > -1000 && power_of_two(exponent - 1) >= x {
        exponent -= 1;
    }
    exponent
}

/// 2^exponent, exactly, for normal numbers.
pub(crate) fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

impl Asked<'_> {
    /// A program of the arguments and, for two probes, their difference; the reading is the last step.
    fn program(&self, suffix: &str, ty: Type, meaning: &str, difference: Type) -> Program {
        let mut p = Program::default();
        let argument = |p: &mut Program, name: String, what: &str| {
            let index = p.arguments.len();
            p.arguments.push(Argument { name: name.clone(), ty, meaning: format!("{what}, {meaning}") });
            p.push(Stage::Input, &name, ty, Op::Input { index }, "")
        };
        match self.arity {
            Arity::Reading => {
                let (name, what) =
                    if self.pair { ("s", "s = x₂ − x₁") } else { ("measured", "the reading") };
                argument(&mut p, format!("{name}{suffix}"), what);
            }
            Arity::Probes => {
                let x1 = argument(&mut p, format!("x1{suffix}"), "x₁, Eq. 2");
                let x2 = argument(&mut p, format!("x2{suffix}"), "x₂, Eq. 3");
                p.push(Stage::Input, "s", difference, Op::Sub { a: x2, b: x1 }, "s = x₂ − x₁");
            }
        }
        p.reading = p.output();
        p.clamped = p.reading;
        p
    }
}
