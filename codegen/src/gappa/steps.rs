//! The operations of a program as the script has them: what each reads, and what that is without rounding.

use std::collections::BTreeMap;

use minijinja::{Value, context};

use crate::exact::Interval;
use crate::physics::{ErrorAccount, Tracked};
use crate::program::{Op, Operand, Program};
use crate::text;

/// The parts of a script.
#[derive(Default)]
pub(super) struct Steps {
    /// Words and distances of which only the range is known.
    pub variables: Vec<Value>,
    /// Operations in their order.
    pub computed: Vec<Value>,
    /// Numbers that stand between a step and one that reads it: by how much what is read is further from exact.
    pub bridges: Vec<Value>,
    /// Words known to lie in a narrower range than intervals show.
    pub narrower: Vec<Value>,
    /// The last result.
    pub result: Value,
}

/// A number as the routine has it and as it would be without rounding.
struct Number {
    r: String,
    e: String,
    /// How far the second can be from the first, as the error account counts it.
    error: Interval,
    known: Option<Interval>,
}

impl Number {
    fn exactly(r: String) -> Number {
        Number { e: r.clone(), r, error: Interval::zero(), known: None }
    }
}

/// Name of a table's word: the place in a segment, a coefficient.
pub(super) fn of_segment(program: &Program, i: usize) -> String {
    format!("{}_", program.steps[i].name)
}

/// The steps that lead to the result; `None` where one has no counterpart.
pub(super) fn of(program: &Program, account: Option<&ErrorAccount>) -> Option<Steps> {
    let mut writer = Writer { program, account, numbers: BTreeMap::new(), steps: Steps::default() };
    let result = Operand::Step(program.output());
    let first = program.variable + 1;
    for i in needed(program, account, result).into_iter().filter(|i| *i >= first) {
        writer.append(i)?;
    }
    let goal = writer.read(program.steps.len(), 0, result)?;
    writer.steps.result = goal;
    Some(writer.steps)
}

/// The steps that lead to the result, where what is known of a word otherwise needs none.
fn needed(program: &Program, account: Option<&ErrorAccount>, result: Operand) -> Vec<usize> {
    let Some(account) = account else { return program.needed([result].into_iter()) };
    let mut cut = program.clone();
    for (i, known) in &account.steps {
        if known.reads.is_empty() {
            // Stands for any operation without operands.
            cut.steps[*i].op = Op::Input { index: 0 };
        }
    }
    cut.needed([result].into_iter())
}

struct Writer<'a> {
    program: &'a Program,
    account: Option<&'a ErrorAccount>,
    numbers: BTreeMap<usize, Number>,
    steps: Steps,
}

impl Writer<'_> {
    /// What the error account says of operand `k` of a step: of the result's own steps only what the whole sum is off.
    fn taken(&self, i: usize, k: usize, operand: Operand) -> Option<Tracked> {
        let account = self.account?;
        match account.steps.get(&i) {
            Some(known) => known.reads.get(k).cloned(),
            // Only where a term was added to it.
            None if operand == account.sum.operand => match operand {
                Operand::Step(sum) if account.steps.contains_key(&sum) => Some(account.sum.clone()),
                _ => None,
            },
            None => None,
        }
    }

    /// Operand `k` of step `i`.
    fn read(&mut self, i: usize, k: usize, operand: Operand) -> Option<Value> {
        let number = match operand {
            Operand::Step(s) if s == self.program.variable => &Number::exactly("x_".into()),
            Operand::Step(s) => self.numbers.get(&s)?,
            Operand::Int(v) => &Number::exactly(v.to_string()),
            Operand::Float(v) => &Number::exactly(text::float_hex(v.into())),
        };
        let (r, mut e) = (number.r.clone(), number.e.clone());
        if let Some(taken) = self.taken(i, k, operand) {
            let further = if number.error.certainly_le(&taken.error) {
                &taken.error - &number.error
            } else {
                e.clone_from(&r);
                taken.error.clone()
            };
            let narrower = number.known.as_ref().is_some_and(|k| taken.range.inside(k) && taken.range != *k);
            if narrower {
                self.steps.narrower.push(in_range(&r, &taken.range));
            }
            if further != Interval::zero() {
                let (name, gap) = (format!("u_{i}_{k}"), format!("g_{i}_{k}"));
                self.steps.variables.push(in_range(&gap, &further.symmetric()));
                let off = if e == r { Value::from(()) } else { Value::from(e.as_str()) };
                self.steps.bridges.push(context! { i, name => &*name, r => &*r, e => &*e, off, gap });
                e = name;
            }
        }
        Some(context! { exact => r == e, r, e })
    }

    fn append(&mut self, i: usize) -> Option<()> {
        let known = self.account.and_then(|account| account.steps.get(&i));
        if let Some(known) = known.filter(|k| k.reads.is_empty()) {
            let r = format!("f_{i}");
            // The integers inside.
            let known = known.result.range.clone();
            let ends = (known.lower().ceil_to_i64()?, known.upper().floor_to_i64()?);
            self.steps.variables.push(context! {
                name => &*r, from => ends.0.to_string(), to => ends.1.to_string(), integer => true,
            });
            let known = Some(known);
            self.numbers.insert(i, Number { known, ..Number::exactly(r) });
            return Some(());
        }
        let (error, range) = known
            .map_or((Interval::zero(), None), |k| (k.result.error.clone(), Some(k.result.range.clone())));
        let op = &self.program.steps[i].op;
        let number = match op {
            Op::Index { .. } => return Some(()),
            Op::Wrap { .. } | Op::Entry { .. } => Number::exactly(of_segment(self.program, i)),
            _ => {
                // A truncation's mean is part of the polynomial, and not of the terms.
                let (step, rounds) = self.one(i, op, if known.is_some() { 0.0 } else { 0.5 })?;
                self.steps.computed.push(step);
                let r = format!("r_{i}");
                let e = if rounds { format!("e_{i}") } else { r.clone() };
                Number { r, e, error, known: range }
            }
        };
        self.numbers.insert(i, number);
        Some(())
    }

    /// The operation for the template, and whether its result is off.
    fn one(&mut self, i: usize, op: &Op, mean: f64) -> Option<(Value, bool)> {
        let mut read = Vec::new();
        for (k, operand) in op.operands().into_iter().enumerate() {
            read.push(self.read(i, k, operand)?);
        }
        let exact = read.iter().all(|o| o.get_attr("exact").is_ok_and(|v| v.is_true()));
        let (kind, exact, factor, by, sign) = match op {
            Op::MulAddHigh { shift, .. } => ("mul_add_high", false, 1u64 << shift, 32, ""),
            Op::MulAddSplit { shift, .. } => ("mul_add_split", false, 1 << shift, 32, ""),
            Op::MulAddShort { by, .. } => ("mul_add_high", false, 1, *by, ""),
            Op::MulAddF32 { fused: true, .. } => ("fused_f32", false, 1, 0, ""),
            Op::MulAddF32 { .. } => ("mul_add_f32", false, 1, 0, ""),
            Op::MulF32 { .. } => ("mul_f32", false, 1, 0, ""),
            Op::ToF32 { .. } => ("to_f32", false, 1, 0, ""),
            Op::Add { .. } => ("sum", exact, 1, 0, "+"),
            Op::Sub { .. } => ("sum", exact, 1, 0, "-"),
            Op::ShiftLeft { by, .. } => ("shift_left", exact, 1 << by, 0, ""),
            _ => return None,
        };
        let scale = if by > 0 { format!(" * 1b-{}", by - factor.trailing_zeros()) } else { String::new() };
        // Strict templates want every name: what an operation has not is nothing.
        let [a, b, c] = [0, 1, 2].map(|k| read.get(k).cloned().unwrap_or(Value::from(())));
        let split = 3.0 * mean;
        let scales = op.scales();
        Some((context! { i, kind, a, b, c, mean, split, exact, factor, by, scale, sign, scales }, !exact))
    }
}

/// A name and the floats around a range.
fn in_range(name: &str, range: &Interval) -> Value {
    let (from, to) = (text::float_hex(range.to_f64_down()), text::float_hex(range.to_f64_up()));
    context! { name, from, to, integer => false }
}
