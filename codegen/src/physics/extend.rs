//! Appends the terms to a routine that is designed, and adds what they are off to its bound.

use std::collections::BTreeMap;

use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::Operator;

use super::builder::{Builder, ErrorAccount, Tracked, whole};
use super::expression::{Lowering, Shared, Tree};
use super::further::Given;
use super::selection::by_time;
use super::shape::Variable;
use super::sum::Sum;
use super::{Physics, PhysicsError, Result, periodic, product, warm_up};
use crate::bound::{self, Overflows};
use crate::design::{Design, DesignError};
use crate::exact::{Interval, arcsec_per_rad};
use crate::format::Format;
use crate::input::InputPlan;
use crate::output::Output;
use crate::program::{Op, Operand, Program, Stage, Step, Type};

impl Physics {
    /// `design` with the terms; `target` is the bound that is wanted, in the result's unit.
    ///
    /// # Errors
    /// [`DesignError`] where a word could overflow, or the format has no long products.
    pub fn extend(
        &self,
        design: Design,
        model: &ErrorModel,
        plan: &InputPlan,
        (format, output): (Format, Output),
        target: f64,
    ) -> Result<Design, DesignError> {
        if self.is_empty() {
            return Ok(design);
        }
        if !matches!(format, Format::Q31 | Format::Q31Split) {
            return Err(PhysicsError::Format(format.name()).into());
        }
        let at = design.program.steps.iter().position(|s| s.stage == Stage::Output);
        let at = at.unwrap_or(design.program.steps.len());
        let unit = Interval::pow2(-design.sum_bits);
        let range = Interval::from_f64(design.bound.output_range.0)
            .hull(&Interval::from_f64(design.bound.output_range.1));
        // The result's words as words of the sum, wider for the roundings in between.
        let one = if output == Output::F32 { Interval::zero() } else { design.unit.mul_pow2(1).div(&unit) };
        let range = (&range * &design.unit).div(&unit);
        let wider = &(&range.magnitude().mul_pow2(-20) + &one) + &Interval::from_int(8);
        let range = &range + &wider.symmetric();
        let word = Tracked { operand: Operand::Step(at - 1), range, error: Interval::zero() };
        let quarter = Interval::pow2(-2);
        let wanted = Interval::from_f64(target).mul_pow2(design.sum_bits - 5);
        let sum = Sum {
            word,
            bits: design.sum_bits,
            tolerance: quarter.hull(&wanted).upper(),
            negligible: quarter,
            gain: Interval::from_int(1),
        };
        let mut b = Builder { program: design.program.clone(), format, known: BTreeMap::new(), sum };
        b.program.steps.truncate(at);
        self.subtract(&mut b, model, plan)?;
        wide_first(&mut b.program);
        let last = Operand::Step(b.program.output());
        if design.program.steps.len() == at && b.sum.word.operand != last {
            // The result is the last step, also where the last term was too small to be evaluated.
            let nothing = Tracked::constant(&Interval::zero());
            b.sum.word = b.add("angle", &b.sum.word.clone(), &nothing, "")?;
        }
        let Builder { mut program, known, sum, .. } = b;
        let gain = sum.gain.to_f64_up();
        finish(&mut program, &design.program, at, &sum.word)?;
        let mut account = ErrorAccount { steps: known, sum: sum.word.clone() };
        drop_unread_rows(&mut program, &mut account);
        let mut bound = design.bound.clone();
        // Where the terms enlarge what the function is off, that is listed with them.
        let before = bound.approximation + bound.input + bound.evaluation;
        bound.terms = ((&sum.word.error * &unit).to_f64_up() + (gain - 1.0).next_up() * before).next_up();
        if output == Output::F32 {
            // A larger result has larger roundings.
            let largest = (&sum.word.range.magnitude() * &unit).log2_floor().unwrap_or(-100);
            bound.output = bound.output.max(Interval::pow2(largest - 24).to_f64_up());
        }
        let further = &Interval::from_f64(bound.output - design.bound.output) + &(&sum.word.error * &unit);
        bound.rounding =
            (&Interval::from_f64(bound.rounding) + &further.magnitude().div(&design.unit)).to_f64_up();
        let sum_of = [bound.approximation, bound.input, bound.evaluation, bound.output, bound.terms];
        bound.total = sum_of.iter().fold(0.0, |sum: f64, part| (sum + part).next_up());
        let words = (&sum.word.range * &unit).div(&design.unit);
        bound.output_range = (words.to_f64_down(), words.to_f64_up());
        Ok(Design { program, bound, account: Some(account), ..design })
    }

    /// Appends the steps of all terms.
    fn subtract(&self, b: &mut Builder, model: &ErrorModel, plan: &InputPlan) -> Result {
        // What one unit of the file's statistics is in the result's unit.
        let statistic = match model.sensor {
            Sensor::EddyCurrentPair { .. } => Interval::from_int(1).div(&arcsec_per_rad()),
            Sensor::Direct { .. } => Interval::from_int(1),
        };
        let (from, to) = bound::reach(&b.program, plan);
        let exponent = b.program.variable_exponent;
        let error = bound::variable_error(&b.program, plan).mul_pow2(exponent).upper();
        let word = Tracked { operand: Operand::Step(b.program.variable), range: from.hull(&to), error };
        let variable = Variable { model, plan, word, exponent };
        let mut given: Vec<(String, Given)> = Vec::new();
        for input in &self.further {
            let centre = self.mean(&input.observable).unwrap_or(0.5 * (input.from + input.to));
            given.push((input.observable.clone(), input.push(b, centre)?));
        }
        let mut expanded = product::Expanded::new();
        let mut shared = Shared::default();
        for term in &self.terms {
            // Coefficients are in the statistics' unit per unit of the observable.
            let weight = &Interval::from_f64(term.coefficients.first().copied().unwrap_or(0.0)) * &statistic;
            let kind = (&*term.effect, term.operator.kind());
            let (variable, given, period_s) = (&variable, &given[..], self.period_s);
            let mut lowering = Lowering { b, shared: &mut shared, variable, given, period_s, term: kind };
            let appended = match &term.operator {
                Operator::Product(p) => product::expand(&mut expanded, p, &weight, variable, given),
                Operator::Play(p) => lowering.subtract_plays(p, &term.coefficients, &statistic),
                Operator::Gaussian(g) => lowering.subtract_gaussian(g, &weight),
                Operator::Exponential(e) if by_time(e, &self.further) => {
                    warm_up::subtract(b, e, &weight, period_s)
                }
                Operator::Exponential(e) => lowering.subtract_exponential(e, &weight),
                // Of the result itself: solved in the end.
                Operator::Periodic(_) => Ok(()),
                Operator::Lag(_)
                | Operator::Rate(_)
                | Operator::Hinge(_)
                | Operator::Step(_)
                | Operator::Expression(_) => {
                    let pair = matches!(model.sensor, Sensor::EddyCurrentPair { .. });
                    let tree = Tree::of_term(term, pair).map_err(|why| lowering.refuse(why))?;
                    lowering.subtract(&tree, &statistic)
                }
            };
            appended.map_err(|error| error.of(kind))?;
        }
        let first = |of: &dyn Fn(&Operator) -> bool| {
            let term = self.terms.iter().find(|term| of(&term.operator));
            term.map_or(("", ""), |term| (&term.effect, term.operator.kind()))
        };
        let of_product = first(&|operator| matches!(operator, Operator::Product(_)));
        product::subtract(b, &expanded, &variable, &given).map_err(|error| error.of(of_product))?;
        let of_periodic = first(&|operator| matches!(operator, Operator::Periodic(_)));
        periodic::solve(b, &self.terms, &statistic).map_err(|error| error.of(of_periodic))
    }
}

/// Sorts the state so that words of 64 bits come first and none leaves a gap.
fn wide_first(program: &mut Program) {
    let mut order: Vec<usize> = (0..program.state.len()).collect();
    order.sort_by_key(|i| program.state[*i].ty != Type::I64);
    for step in &mut program.steps {
        if let Op::State { index } = &mut step.op {
            *index = order.iter().position(|i| i == index).unwrap_or(*index);
        }
    }
    program.state = order.into_iter().map(|i| program.state[i].clone()).collect();
}

/// Takes out the rows of the table that no written step reads, of parts that came to nothing in the end; a step that was to
/// read one holds its number.
fn drop_unread_rows(program: &mut Program, account: &mut ErrorAccount) {
    let written = program.written_steps();
    let (mut gone, mut unread) = (0, Vec::new());
    for step in 0..program.steps.len() {
        let kept = written.binary_search(&step).is_ok();
        match (&mut program.steps[step].op, account.steps.get_mut(&step)) {
            (Op::Index { add, by, .. }, Some(known)) if kept => {
                *add -= gone << *by;
                known.result.range = &known.result.range - &Interval::from_int(gone);
            }
            (Op::Index { .. }, Some(known)) => {
                let (first, last) = whole(&known.result.range);
                let mut rows = program.table.drain((first - gone) as usize..=(last - gone) as usize);
                unread.push((Operand::Step(step), rows.next().unwrap_or_default()));
                gone += last + 1 - first;
            }
            (op @ Op::Entry { .. }, _) => {
                if let Op::Entry { index, column } = op
                    && let Some((_, row)) = unread.iter().find(|(of, _)| of == index)
                {
                    *op = Op::Add { a: Operand::Int(row[*column]), b: Operand::Int(0) };
                }
            }
            _ => {}
        }
    }
}

/// Appends the steps of `before` from `at` on, which make the output of the sum, so that they read `sum` instead.
fn finish(program: &mut Program, before: &Program, at: usize, sum: &Tracked) -> Result<(), Overflows> {
    let begin = program.steps.len();
    let moved = |operand: Operand| match operand {
        Operand::Step(i) if i + 1 == at => sum.operand,
        Operand::Step(i) if i >= at => Operand::Step(i - at + begin),
        other => other,
    };
    for step in &before.steps[at..] {
        // An integer output is the sum times a constant.
        if let Op::MulAddHigh { b: Operand::Int(m), shift, .. }
        | Op::MulAddSplit { b: Operand::Int(m), shift, .. } = &step.op
        {
            let scaled = (&sum.range * &Interval::from_int(*m)).mul_pow2(i64::from(*shift) - 32);
            let range = &scaled + &Interval::from_int(4).mul_pow2((*shift).into()).symmetric();
            Overflows::unless_inside(&range, Type::I32, (program.steps.len(), &step.name, Stage::Output))?;
        }
        program.steps.push(Step { op: step.op.on(moved), ..step.clone() });
    }
    Ok(())
}
