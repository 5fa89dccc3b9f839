//! Integer inputs: Q31 words and counts. Everything up to the variable is exact.

use super::{Arity, Asked, InputError, InputPlan, power_of_two};
use crate::exact::Interval;
use crate::format::Format;
use crate::program::{Op, Operand, Program, Stage, Type};
use crate::reference::ReadingMap;

/// An integer encoding: number = (word − offset)·lsb, word in lo…hi.
pub(super) struct Word {
    pub(super) ty: Type,
    pub(super) lsb: Interval,
    pub(super) offset: Interval,
    pub(super) lo: i64,
    pub(super) hi: i64,
    pub(super) meaning: String,
    /// The options that set its reach, for messages.
    pub(super) what: &'static str,
}

/// The plan for an integer encoding.
pub(super) fn plan(asked: &Asked<'_>, word: &Word) -> Result<InputPlan, InputError> {
    let Asked { arity, format, clamped, .. } = *asked;
    let (first, last) = word.ends(asked)?;
    let suffix = match word.ty {
        Type::U16 | Type::U32 => "_counts",
        _ => "_q31",
    };
    let difference = if word.ty == Type::U16 { Type::I32 } else { Type::I64 };
    let mut p = asked.program(suffix, word.ty, &word.meaning, difference);
    p.valid = (first as f64, last as f64);
    let mut reading = Operand::Step(p.reading);
    let (least, most) = word.arriving(&mut p, &mut reading, arity, (first, last), clamped)?;

    // Centre where that gains a bit or more, or makes the word signed; then shift as far left as 32 bits allow.
    let middle = least + (most - least + 1) / 2;
    let largest = |centre: i64| (least - centre).abs().max((most - centre).abs());
    let unsigned = !clamped && p.steps[p.reading].ty == Type::U16;
    let centre = if unsigned || largest(middle) * 2 <= largest(0) { middle } else { 0 };
    if centre != 0 {
        let from_middle = Op::Sub { a: reading, b: Operand::Int(centre) };
        reading = p.push(Stage::Input, "offset", Type::I32, from_middle, "from the middle of the range");
    }
    // Negative words reach one further: −2^n fits where 2^n − 1 does.
    let widest = (most - centre).max(-1 - (least - centre));
    let exponent = variable(&mut p, reading, widest, format);
    p.name_variable();
    // word = centre + v·2^exponent, so reading = (centre − offset + v·2^exponent)·lsb.
    let slope = Interval::pow2(exponent);
    let map = ReadingMap {
        offset: &(&Interval::from_int(centre) - &word.offset) * &word.lsb,
        slope: &slope * &word.lsb,
    };
    let shift = p.variable_exponent - exponent;
    let in_variable = |w: i64| Interval::from_int(w - centre).mul_pow2(shift);
    Ok(InputPlan {
        word_from: in_variable(first),
        word_to: in_variable(last),
        reach: (in_variable(least), in_variable(most)),
        reading_word: (Interval::from_int(centre), slope),
        resolution: word.lsb.to_f64_up(),
        program: p,
        map,
    })
}

impl Word {
    /// Smallest and largest reading that its words can be.
    fn reach(&self, arity: Arity) -> (i64, i64) {
        match arity {
            Arity::Reading => (self.lo, self.hi),
            Arity::Probes => (self.lo - self.hi, self.hi - self.lo),
        }
    }

    /// The first and last word of the range.
    fn ends(&self, asked: &Asked<'_>) -> Result<(i64, i64), InputError> {
        let (from, to) = (asked.from, asked.to);
        let (lo, hi) = self.reach(asked.arity);
        let in_words = |reading: f64| &Interval::from_f64(reading).div(&self.lsb) + &self.offset;
        let first = in_words(from).ceil_to_i64().unwrap_or(i64::MIN);
        let last = in_words(to).floor_to_i64().unwrap_or(i64::MAX);
        let reaches = |w: i64| ((&Interval::from_int(w) - &self.offset).to_f64()) * self.lsb.to_f64();
        // One word beyond the end of the range is not missed.
        if first < lo || last > hi + 1 {
            return Err(InputError::DoesNotReach {
                from: reaches(lo),
                to: reaches(hi),
                range_from: from,
                range_to: to,
                what: self.what,
            });
        }
        let last = last.min(hi);
        // −2ⁿ…2ⁿ−1 is what cores saturate to in one instruction; the word at the end itself is not missed either.
        let last = if last > 1 && first == -last && last.count_ones() == 1 { last - 1 } else { last };
        if last <= first { Err(InputError::NoResolution(from, to)) } else { Ok((first, last)) }
    }

    /// What the words can be on arrival: those of the range, where they are `clamped` to it.
    fn arriving(
        &self,
        p: &mut Program,
        reading: &mut Operand,
        arity: Arity,
        (first, last): (i64, i64),
        clamped: bool,
    ) -> Result<(i64, i64), InputError> {
        let (reach, ty) = (self.reach(arity), p.steps[p.reading].ty);
        if (first, last) == reach && ty == Type::I32 {
            Ok(reach)
        } else if clamped {
            let clamp = Op::Clamp { a: *reading, lo: first, hi: last };
            *reading = p.push(Stage::Input, "limited", Type::I32, clamp, "the valid range");
            p.clamped = p.output();
            Ok((first, last))
        } else if self.ty == Type::U16 {
            // Also those beyond a narrower converter.
            let most = i64::from(u16::MAX);
            Ok(if arity == Arity::Probes { (-most, most) } else { (0, most) })
        } else if ty == Type::I32 {
            Ok(reach)
        } else {
            Err(InputError::Unlimited)
        }
    }
}

/// Pushes the steps from a word of at most `widest` to the variable: reading = v·2^exponent.
fn variable(p: &mut Program, reading: Operand, widest: i64, format: Format) -> i64 {
    if !format.is_fixed() {
        let bits = 64 - i64::from(widest.leading_zeros());
        let x = p.push(Stage::Input, "x", Type::F32, Op::ToF32 { a: reading }, "");
        let scale = Operand::Float(power_of_two(-bits) as f32);
        p.push(Stage::Input, "x", Type::F32, Op::MulF32 { a: x, b: scale }, "|x| ≤ 1, exact");
        p.variable_exponent = 0;
        return bits;
    }
    let bits = format.bits();
    let limit = (1 << bits) - 1;
    let note = format!("v·2^{}", bits + 1);
    p.variable_exponent = bits + 1;
    match (0..32).take_while(|shift| widest << shift <= limit).last() {
        Some(0) => bits + 1,
        Some(by) => {
            p.push(Stage::Input, "x", Type::I32, Op::ShiftLeft { a: reading, by }, note);
            bits + 1 - i64::from(by)
        }
        // Too wide for the word: rounded to it.
        None => {
            let by = (1..32).find(|&by| widest >> by <= limit).unwrap_or(31);
            // Rounded to nearest, unless that would leave the word: then downward.
            let half = 1 << (by - 1);
            let add = if (widest + half) >> by <= limit { half } else { 0 };
            let right = Op::ShiftRight { a: reading, add, by: by as u32 };
            p.push(Stage::Input, "x", Type::I32, right, note);
            bits + 1 + by
        }
    }
}
