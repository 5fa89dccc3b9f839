//! The changes of a source that are tried: constants, shifts, limits, the state, rows of a table.

use std::path::Path;

use crate::generate::Generated;
use crate::language::Body;
use crate::options::Options;
use crate::program::{Op, Operand, Stage, Step};
use crate::text::camel_case;
use crate::verify::compile::How;
use crate::verify::harness::Subject;

/// A change of one source file.
pub(super) struct Mutation {
    pub(super) what: String,
    pub(super) how: How,
    pub(super) from: String,
    to: String,
    /// Whether `to` stands in the file as well and both change places.
    swap: bool,
}

impl Mutation {
    pub(super) fn apply(&self, text: &str) -> String {
        match (self.swap, text.find(&self.from), text.find(&self.to)) {
            (true, Some(_), Some(_)) => {
                let parted: Vec<String> =
                    text.split(&self.from).map(|part| part.replacen(&self.to, &self.from, 1)).collect();
                parted.join(&self.to)
            }
            // Everywhere: several helpers shift a product, of which a routine may call any.
            (false, ..) => text.replace(&self.from, &self.to),
            _ => text.into(),
        }
    }
}

/// Every change that fits a routine, in every language.
pub(super) fn mutations(subject: &Subject<'_>, generated: &Generated, options: &Options) -> Vec<Mutation> {
    let body = Body::new(subject.program(), false, options);
    let source = |how: &How| {
        let file = how.language.file_of(&generated.name, &subject.name);
        generated.files.get(Path::new(&file)).map_or("", String::as_str)
    };
    let runs = How::all(false);
    let middle = middle_row(subject);
    let each = runs.iter().map(|how| Changes { how: *how, body, source: source(how), middle });
    let of_each: Vec<Vec<Mutation>> = each.map(|changes| changes.all()).collect();
    // Change by change, in every language.
    let most = of_each.iter().map(Vec::len).max().unwrap_or(0);
    let mut columns: Vec<_> = of_each.into_iter().map(Vec::into_iter).collect();
    (0..most).flat_map(|_| columns.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>()).collect()
}

/// A row in the middle of those that belong together, which is always reached: of the last rows, where terms share a table.
fn middle_row(subject: &Subject<'_>) -> usize {
    let program = subject.program();
    let account = subject.routine.design.account.as_ref();
    let written = program.written_steps();
    let index = |step: &usize| written.contains(step) && matches!(program.steps[*step].op, Op::Index { .. });
    let rows = account.and_then(|account| account.steps.iter().rev().find(|(step, _)| index(step)));
    let middle = rows.and_then(|(_, known)| known.result.range.midpoint().ceil_to_i64());
    middle.map_or(program.table.len() / 2, |row| row as usize)
}

/// The changes of one language's source.
struct Changes<'a> {
    how: How,
    body: Body<'a>,
    source: &'a str,
    /// See [`middle_row`].
    middle: usize,
}

impl Changes<'_> {
    fn all(&self) -> Vec<Mutation> {
        let mut found = self.constants();
        found.extend(self.shift());
        found.extend(self.not_kept());
        found.extend(self.limit());
        found.extend(self.swapped_rows());
        found
    }

    fn change(&self, what: &str, from: String, to: String) -> Mutation {
        let what = format!("{what}, {}", camel_case(self.how.language.name()));
        Mutation { what, how: self.how, from, to, swap: false }
    }

    /// The constants of some steps off in their last places.
    fn constants(&self) -> Vec<Mutation> {
        let constant = |step: &Step| match step.op {
            Op::MulAddHigh { c, .. }
            | Op::MulAddSplit { c, .. }
            | Op::MulAddShort { c, .. }
            | Op::MulAddF32 { c, .. } => Some(c).filter(|c| !matches!(c, Operand::Step(_) | Operand::Int(0))),
            _ => None,
        };
        let steps = self.body.program.steps.iter().enumerate();
        let constants: Vec<(usize, Operand)> = (steps.filter(|(_, s)| s.stage == Stage::Evaluation))
            .filter_map(|(index, step)| Some((index, constant(step)?)))
            .collect();
        let chosen = [constants.first(), constants.get(constants.len() / 2), constants.last()];
        let changed = chosen.into_iter().flatten().zip([4i64, 2, 1]).filter_map(|((index, c), units)| {
            let other = match *c {
                Operand::Int(v) => Operand::Int(v + units * if v < 0 { -1 } else { 1 }),
                Operand::Float(v) => Operand::Float(f32::from_bits(v.to_bits() + units as u32)),
                Operand::Step(i) => Operand::Step(i),
            };
            let what = format!("a coefficient of {c:?} off by {units} in its last place");
            let step = &self.body.program.steps[*index];
            self.damaged(&what, *index, step.op.on(|operand| if operand == *c { other } else { operand }))
        });
        changed.collect()
    }

    /// Another operation in place of a step's: as it stands in the source, or in the one line of constants that it changes.
    fn damaged(&self, what: &str, index: usize, op: Op) -> Option<Mutation> {
        let mut program = self.body.program.clone();
        program.steps[index].op = op;
        let body = Body { program: &program, ..self.body };
        let language = self.how.language;
        let expressions = [&self.body, &body].map(|b| language.expression(b, &b.program.steps[index]));
        let steps = self.body.program.update_steps();
        let [before, after] = [&self.body, &body].map(|b| language.statements(b, &steps, false));
        let mut lines = before.into_iter().zip(after).filter(|(from, to)| from != to);
        let [from, to] = expressions;
        let (from, to) = match (from != to, lines.next(), lines.next()) {
            (true, ..) => (from, to),
            (false, Some(line), None) => line,
            _ => return None,
        };
        Some(self.change(what, from, to))
    }

    /// The shift of a product off by one.
    fn shift(&self) -> Option<Mutation> {
        let shift = |step: &Step| match step.op {
            Op::MulAddHigh { .. } => Some(32),
            Op::MulAddSplit { .. } => Some(15),
            _ => None,
        };
        let by = self.body.program.steps.iter().find_map(shift)?;
        let texts = self.how.checker.shifts(by).into_iter().zip(self.how.checker.shifts(by - 1));
        let (from, to) = texts.into_iter().find(|(from, _)| self.source.contains(from))?;
        Some(self.change(&format!("a product shifted by {} instead of {by}", by - 1), from, to))
    }

    /// A word of the state that is not kept.
    fn not_kept(&self) -> Option<Mutation> {
        let program = self.body.program;
        let word = program.state.last().filter(|word| matches!(word.next, Operand::Step(_)))?;
        let language = self.how.language;
        let kept = Step {
            op: Op::State { index: program.state.len() - 1 },
            ty: word.ty,
            name: word.name.clone(),
            note: String::new(),
            stage: Stage::Evaluation,
        };
        let kept = language.expression(&self.body, &kept);
        let (from, to) =
            (format!("{kept} = {};", language.operand(program, &word.next)), format!("{kept} = {kept};"));
        Some(self.change(&format!("`{}` not kept", word.name), from, to))
    }

    /// A limit that is too narrow.
    fn limit(&self) -> Option<Mutation> {
        let mut steps = self.body.program.steps.iter().enumerate().rev();
        let (index, a, lo, hi) = steps.find_map(|(index, step)| match step.op {
            // Nothing reaches the end of the type.
            Op::Clamp { a, lo, hi } if step.stage == Stage::Evaluation && hi < i32::MAX.into() => {
                Some((index, a, lo, hi))
            }
            _ => None,
        })?;
        let what = format!("a limit of {} instead of {hi}", hi / 2);
        self.damaged(&what, index, Op::Clamp { a, lo, hi: hi / 2 })
    }

    /// Two neighbouring rows.
    fn swapped_rows(&self) -> Option<Mutation> {
        let table = &self.body.program.table;
        let number = |v: &i64| self.how.language.integer(*v);
        let [from, to] = [table.get(self.middle.checked_sub(1)?)?, table.get(self.middle)?]
            .map(|row| row.iter().map(number).collect::<Vec<_>>().join(", "));
        let change = self.change("a table with two segments swapped", from, to);
        Some(Mutation { swap: true, ..change })
    }
}
