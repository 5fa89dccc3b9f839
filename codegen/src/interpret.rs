//! Runs a [`Program`] on words, operation by operation, exactly as the generated source would.

use crate::program::{Op, Operand, Program, Type};

/// A word in a register.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Word {
    /// Of an integer type.
    Int(i64),
    /// Of type `f32`.
    Float(f32),
}

impl Word {
    /// The same bits as the generated routine would return, widened: floats by their bit pattern.
    pub fn bits(self) -> i64 {
        match self {
            Word::Int(v) => v,
            Word::Float(v) => v.to_bits().into(),
        }
    }
}

/// What a routine returns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The result, which for a reading outside the valid range belongs to the nearest end of the range.
    pub word: Word,
    /// Whether the reading lay inside the valid range.
    pub in_range: bool,
}

/// A step's result left its type: the program is wrong, and its bound would have refused it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("step {step} gives {value}, which its type {ty:?} does not hold")]
pub struct Overflow {
    /// Index of the step.
    pub step: usize,
    /// The value.
    pub value: i128,
    /// The type it should have fitted.
    pub ty: Type,
}

fitter::errors!(plain Overflow);

/// Runs `program` on one word for each argument.
///
/// # Errors
/// [`Overflow`] where an integer leaves its type, which no bounded program does.
pub fn interpret(program: &Program, arguments: &[Word]) -> Result<Outcome, Overflow> {
    update(program, &mut start(program, arguments)?, arguments)
}

/// The state of a routine whose first call will have these arguments.
///
/// # Errors
/// As [`interpret`].
pub fn start(program: &Program, arguments: &[Word]) -> Result<Vec<i64>, Overflow> {
    if program.state.is_empty() {
        return Ok(Vec::new());
    }
    // The steps that are read here do not read the state.
    let results = run(program, &vec![0; program.state.len()], arguments, &program.start_steps())?;
    Ok(program.state.iter().map(|word| value(&word.start, &results)).collect())
}

/// Runs `program` once, from a state to the next.
///
/// # Errors
/// As [`interpret`].
pub fn update(program: &Program, state: &mut [i64], arguments: &[Word]) -> Result<Outcome, Overflow> {
    let all: Vec<usize> = (0..program.steps.len()).collect();
    let results = run(program, state, arguments, &all)?;
    for (word, kept) in program.state.iter().zip(state.iter_mut()) {
        *kept = value(&word.next, &results);
    }
    Ok(Outcome {
        word: results[program.output()],
        in_range: results[program.reading] == results[program.clamped],
    })
}

fn value(operand: &Operand, results: &[Word]) -> i64 {
    match operand {
        Operand::Step(i) => results[*i].bits(),
        Operand::Int(v) => *v,
        Operand::Float(v) => *v as i64,
    }
}

/// The results of the steps of which the indices are given; 0 of the others.
fn run(program: &Program, state: &[i64], arguments: &[Word], which: &[usize]) -> Result<Vec<Word>, Overflow> {
    let mut results = vec![Word::Int(0); program.steps.len()];
    for &index in which {
        results[index] = match &program.steps[index].op {
            Op::Input { index } => arguments[*index],
            Op::State { index } => Word::Int(state[*index]),
            // Of a range of words only the proof knows; what is run has one.
            Op::Word { index: word } => {
                let one = program.page.get(*word).filter(|w| w.from == w.to).map(|w| w.from);
                let ty = program.steps[index].ty;
                Word::Int(one.ok_or(Overflow { step: index, value: *word as i128, ty })?)
            }
            _ => float(program, index, &results).map_or_else(|| integer(program, index, &results), Ok)?,
        };
    }
    Ok(results)
}

/// The result of a step whose result is a float; none of others.
fn float(program: &Program, index: usize, results: &[Word]) -> Option<Word> {
    let step = &program.steps[index];
    let float = |operand: &Operand| match *operand {
        Operand::Step(i) => match results[i] {
            Word::Float(v) => v,
            Word::Int(v) => v as f32,
        },
        Operand::Int(v) => v as f32,
        Operand::Float(v) => v,
    };
    Some(Word::Float(match &step.op {
        Op::ClampF32 { a, lo, hi } => {
            let value = float(a);
            if value >= *lo { if value > *hi { *hi } else { value } } else { *lo }
        }
        Op::ToF32 { a } => float(a),
        Op::MulF32 { a, b } => float(a) * float(b),
        Op::MulAddF32 { a, b, c, fused: true } => float(a).mul_add(float(b), float(c)),
        Op::MulAddF32 { a, b, c, fused: false } => float(a) * float(b) + float(c),
        Op::Sub { a, b } if step.ty == Type::F32 => float(a) - float(b),
        _ => return None,
    }))
}

/// The result of a step of integers.
fn integer(program: &Program, index: usize, results: &[Word]) -> Result<Word, Overflow> {
    let step = &program.steps[index];
    let int = |operand: &Operand| match *operand {
        Operand::Step(i) => match results[i] {
            Word::Int(v) => i128::from(v),
            Word::Float(v) => v as i128,
        },
        Operand::Int(v) => i128::from(v),
        Operand::Float(v) => v as i128,
    };
    let narrowed = |value: i128| narrow(index, step.ty, value);
    let word = |value: i128| narrow(index, Type::I32, value).map(|word| i128::from(word.bits()));
    match &step.op {
        Op::Add { a, b } => narrowed(int(a) + int(b)),
        Op::MulAddWide { a, b, c } => narrowed(int(c) + int(a) * int(b)),
        Op::High { a, by } => narrowed(int(a) >> by),
        Op::Phase { a, factor, by } => {
            Ok(Word::Int(i64::from(((int(a) * i128::from(*factor)) >> by) as i32)))
        }
        Op::Sub { a, b } => narrowed(int(a) - int(b)),
        Op::Clamp { a, lo, hi } => narrowed(int(a).clamp((*lo).into(), (*hi).into())),
        Op::ShiftLeft { a, by } => narrowed(int(a) << by),
        Op::ShiftRight { a, add, by } => narrowed((int(a) + i128::from(*add)) >> by),
        Op::Index { a, add, by } => {
            let sum = int(a) + i128::from(*add);
            let sum = if step.ty == Type::U32 { narrow(index, Type::U32, sum)?.bits().into() } else { sum };
            narrowed(sum >> by)
        }
        Op::Wrap { a, add, by } => Ok(Word::Int(i64::from(((int(a) + i128::from(*add)) << by) as i32))),
        Op::Bits { a, from, bits } => narrowed(i128::from((int(a) as u32) >> from) & ((1i128 << bits) - 1)),
        Op::Shifted { a, by, b, add } => {
            narrowed(i128::from(((int(a) << by) + int(b) + i128::from(*add)) as u32))
        }
        Op::Around { a, turn } => {
            let (sum, turn) = (i64::from(int(a) as u32 as i32), i64::from(*turn));
            if !(-turn..2 * turn).contains(&sum) {
                return Err(Overflow { step: index, value: sum.into(), ty: step.ty });
            }
            Ok(Word::Int(sum.rem_euclid(turn)))
        }
        Op::Entry { index: row, column } => {
            let row = usize::try_from(int(row)).unwrap_or(usize::MAX);
            let entry = program.table.get(row).and_then(|r| r.get(*column));
            entry.map(|v| Word::Int(*v)).ok_or(Overflow { step: index, value: row as i128, ty: step.ty })
        }
        Op::Truncate { a } => narrowed(int(a)),
        Op::MulAddHigh { a, b, shift, c } => narrowed(int(c) + word(((int(a) * int(b)) >> 32) << shift)?),
        Op::MulAddSplit { a, b, shift, c } => {
            let (a, b) = (int(a), int(b));
            let ((a1, a0), (b1, b0)) = ((a >> 16, a & 0xffff), (b >> 16, b & 0xffff));
            let high = a1 * b1 + ((a1 * (b0 >> 1) + a0 * (b1 >> 1)) >> 15);
            narrowed(int(c) + word(high << shift)?)
        }
        Op::MulAddShort { a, b, by, c } => narrowed(int(c) + (word(int(a) * int(b))? >> by)),
        other => unreachable!("{other:?} is no operation of integers"),
    }
}

fn narrow(step: usize, ty: Type, value: i128) -> Result<Word, Overflow> {
    let fits = ty.range().is_some_and(|(lo, hi)| i128::from(lo) <= value && value <= i128::from(hi));
    if fits { Ok(Word::Int(value as i64)) } else { Err(Overflow { step, value, ty }) }
}
