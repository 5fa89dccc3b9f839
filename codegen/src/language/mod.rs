//! The languages that routines are generated in: one file each, with its templates in `templates/<language>`.
//!
//! A language makes the text of expressions, names its files and knows how what it generates is compiled. Templates
//! are frames around that text. No arithmetic is decided here: every operation stands in the
//! [`program`](crate::program). A further language is a file with a [`Language`], its templates, and a place in [`ALL`].

use std::path::Path;

use minijinja::{Value, context};

use crate::options::{CShift, Options};
use crate::program::{Op, Operand, Program, Step, Type};
use crate::verify::VerifyError;
use crate::verify::compile::{How, Place, Tool};
use crate::verify::external::{Check, Checked, ToolReport};

/// Names and texts of templates, compiled in.
macro_rules! templates {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../templates/", $name, ".jinja")))),*]
    };
}
mod c;
mod rust;

pub use rust::module;

/// All languages, in the order of the certificate's entries.
pub static ALL: [&dyn Language; 2] = [&rust::Rust, &c::C];

/// A file that is rendered from a template.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Its path in the output folder.
    pub path: String,
    /// The template.
    pub template: &'static str,
    /// The index of the routine that it holds; none for a file of all routines.
    pub routine: Option<usize>,
}

/// What surrounds the steps of a program, where that changes how they are written.
#[derive(Debug, Clone, Copy)]
pub struct Body<'a> {
    /// The steps.
    pub program: &'a Program,
    /// Whether it corrects the counts of a turn: its table stands by itself, and is read entry by entry.
    pub counts: bool,
    /// How C shifts negative numbers to the right.
    pub shift: CShift,
    /// Whether what a step means stands beside it.
    pub notes: bool,
}

impl<'a> Body<'a> {
    /// The steps of a routine with these options.
    pub fn new(program: &'a Program, counts: bool, options: &Options) -> Self {
        Body { program, counts, shift: options.c_shift, notes: true }
    }

    /// The type of an operand.
    pub fn type_of(&self, operand: &Operand) -> Type {
        match operand {
            Operand::Step(i) => self.program.steps[*i].ty,
            Operand::Int(_) => Type::I32,
            Operand::Float(_) => Type::F32,
        }
    }

    /// The steps of which a statement is made: all that are given, but for the arguments.
    fn written<'b>(&'b self, which: &'b [usize]) -> impl Iterator<Item = (usize, &'a Step)> + 'b {
        let steps = which.iter().map(|i| (*i, &self.program.steps[*i]));
        steps.filter(|(_, step)| !matches!(step.op, Op::Input { .. }))
    }

    /// What a step means, between marks of a comment; nothing where it says so itself.
    fn note(&self, step: &Step, (before, after): (&str, &str)) -> String {
        if step.note.is_empty() || !self.notes {
            String::new()
        } else {
            format!(" {before} {}{after}", step.note)
        }
    }

    /// The table's row that is read by the entries that follow, where step `index` is the first of them in what is
    /// written: the step that says which, and the name of the row.
    fn row_before(&self, index: usize, which: &[usize]) -> Option<(&Operand, String)> {
        let entry = |op: &'a Op| if let Op::Entry { index, .. } = op { Some(index) } else { None };
        let row = entry(&self.program.steps[index].op).filter(|_| !self.counts)?;
        let read = |i: &usize| *i < index && entry(&self.program.steps[*i].op) == Some(row);
        (!which.iter().any(read)).then(|| (row, self.row_name(row)))
    }

    /// The name of the table's row that a step says.
    fn row_name(&self, row: &Operand) -> String {
        let mut rows: Vec<&Operand> = Vec::new();
        for step in &self.program.steps {
            if let Op::Entry { index, .. } = &step.op
                && !rows.contains(&index)
            {
                rows.push(index);
            }
        }
        match rows.iter().position(|other| *other == row) {
            Some(before) if before > 0 => format!("row_{}", before + 1),
            _ => "row".into(),
        }
    }

    /// The operations that no expression of most languages writes, in the order in which they occur.
    fn helpers(&self, which: &[usize]) -> Vec<&'static str> {
        let mut found = Vec::new();
        let mut add = |helper| {
            if !found.contains(&helper) {
                found.push(helper);
            }
        };
        let steps = || which.iter().map(|i| &self.program.steps[*i]);
        if steps().any(|s| s.ty == Type::F32) {
            add("float_guard");
        }
        for step in steps() {
            match &step.op {
                Op::MulAddF32 { fused: true, .. } => add("fused"),
                // Of counts, in place.
                Op::Clamp { .. } if step.ty == Type::U32 => {}
                Op::Clamp { a, .. } => add(limit(self.type_of(a))),
                Op::ClampF32 { .. } => add("limit_f32"),
                Op::Around { .. } => add("around"),
                Op::MulAddHigh { .. } => add("mul_high"),
                Op::MulAddSplit { .. } => add("mul_split"),
                Op::MulAddShort { .. } if !self.counts => add("mul_short"),
                Op::High { .. } => add("high_word"),
                Op::Wrap { .. } => add("to_signed"),
                // It rests on the other, which comes first.
                Op::Phase { .. } => ["to_signed", "phase_of"].into_iter().for_each(&mut add),
                _ => {}
            }
        }
        found
    }
}

/// Whether a high product is added to something as it is, which cores with a DSP extension do in one instruction.
fn is_high_sum(op: &Op) -> bool {
    matches!(op, Op::MulAddHigh { shift: 0, c, .. } if *c != Operand::Int(0))
}

/// The function that limits words of a type.
fn limit(ty: Type) -> &'static str {
    if matches!(ty, Type::I32 | Type::U16) { "limit_i32" } else { "limit_i64" }
}

/// A language.
pub trait Language: std::fmt::Debug + Sync {
    /// As in the certificate.
    fn name(&self) -> &'static str;

    /// Names and texts of its templates.
    fn templates(&self) -> &'static [(&'static str, &'static str)];

    /// The files of a generation called `base` with these routines.
    fn files(&self, base: &str, routines: &[&str]) -> Vec<File>;

    /// The file that holds a routine.
    fn file_of(&self, base: &str, routine: &str) -> String;

    /// A type's name.
    fn type_name(&self, ty: Type) -> &'static str;

    /// A parameter, which the function reads or leaves alone.
    fn parameter(&self, name: &str, ty: Type, read: bool) -> String;

    /// An integer constant of 32 bits.
    fn integer(&self, value: i64) -> String;

    /// A float constant.
    fn float(&self, value: f32) -> String;

    /// The right-hand side of a step; a state's or page's words are read as the frame holds them.
    fn expression(&self, body: &Body<'_>, step: &Step) -> String;

    /// The lines of some steps; `ends` where the value of the last is the function's.
    fn statements(&self, body: &Body<'_>, which: &[usize], ends: bool) -> Vec<String>;

    /// Whether the reading was inside the range: it is what it was limited to.
    fn inside(&self, raw: &Step, limited: &Step) -> String;

    /// A row of a table, of the numbers in it.
    fn row(&self, numbers: &str) -> String;

    /// The helper functions that some steps call, in the order in which they are defined.
    fn helpers(&self, body: &Body<'_>, which: &[usize]) -> Vec<&'static str>;

    /// Words that no name may take.
    fn keywords(&self) -> &'static str;

    /// Names with a meaning of their own, and that meaning.
    fn reserved(&self) -> &'static [(&'static str, &'static str)];

    /// An operand: the name of a step's result, or a constant.
    fn operand(&self, program: &Program, operand: &Operand) -> String {
        match operand {
            Operand::Step(i) => program.steps[*i].name.clone(),
            Operand::Int(value) => self.integer(*value),
            Operand::Float(value) => self.float(*value),
        }
    }

    /// A float that is added to what stands before it: a constant below zero is subtracted.
    fn plus_float(&self, program: &Program, operand: &Operand) -> String {
        match operand {
            Operand::Float(value) if value.is_sign_negative() => format!(" - {}", self.float(value.abs())),
            other => format!(" + {}", self.operand(program, other)),
        }
    }

    /// How its files are checked; none where they cannot be.
    fn checker(&self) -> Option<&dyn Checker> {
        None
    }
}

/// How generated files are compiled and damaged, to be checked, by programs of which the templates are
/// `verify/sweep`, a sweep over inputs by number; `verify/calls`, over calls from standard input; and `verify/pages`, which
/// loads pages from standard input.
pub trait Checker: std::fmt::Debug + Sync {
    /// The ending of a source file, and of these templates.
    fn extension(&self) -> &'static str;

    /// A constant of 64 bits, exactly.
    fn double(&self, value: f64) -> String;

    /// The bits of a word as an argument of this type.
    fn argument(&self, ty: Type) -> String;

    /// Whether the compiler can have undefined behaviour watched for.
    fn watches(&self) -> bool {
        false
    }

    /// Compiles what all programs are linked with, once, where there is such a thing.
    ///
    /// # Errors
    /// [`VerifyError`] where there is no compiler or it refuses.
    fn library(&self, _how: How, _place: &Place<'_>) -> Result<(), VerifyError> {
        Ok(())
    }

    /// The compiler, and the arguments by which it makes `executable` of `source`.
    fn compiler(&self, place: &Place<'_>, how: How, source: &Path, executable: &Path) -> (Tool, Vec<String>);

    /// What other programs say of the files; nothing where a check is none of this language.
    ///
    /// # Errors
    /// [`VerifyError`] where a program is missing.
    fn check(&self, check: Check, of: &Checked<'_>) -> Result<Vec<ToolReport>, VerifyError>;

    /// How sources shift products to the right by so many bits, in one way or another.
    fn shifts(&self, by: u32) -> Vec<String>;
}

/// What the templates of a language write of a routine's program.
pub fn laid_out(language: &dyn Language, body: &Body<'_>, ends: bool) -> Value {
    let program = body.program;
    let (update, start) = (program.update_steps(), program.start_steps());
    let among = |steps: &[usize], index: usize| {
        steps.iter().any(|i| matches!(program.steps[*i].op, Op::Input { index: of } if of == index))
    };
    let parameters = |steps: &[usize]| {
        let written = program.arguments.iter().enumerate();
        let written = written.map(|(index, a)| language.parameter(&a.name, a.ty, among(steps, index)));
        written.collect::<Vec<_>>().join(", ")
    };
    let arguments: Vec<Value> = (program.arguments.iter().enumerate())
        .map(|(index, a)| {
            context! {
                name => &*a.name, meaning => &*a.meaning,
                start => among(&start, index), update => among(&update, index),
            }
        })
        .collect();
    let state: Vec<Value> = (program.state.iter())
        .map(|w| {
            context! {
                name => &*w.name, meaning => &*w.meaning, type => language.type_name(w.ty),
                start => language.operand(program, &w.start), next => language.operand(program, &w.next),
            }
        })
        .collect();
    let ranges: Vec<Value> = (program.page.iter())
        .map(
            |w| context! { name => &*w.name, from => language.integer(w.from), to => language.integer(w.to) },
        )
        .collect();
    let (raw, limited) = (&program.steps[program.reading], &program.steps[program.clamped]);
    let inside = (program.reading != program.clamped).then(|| language.inside(raw, limited));
    let columns = program.table.first().map_or(0, Vec::len);
    context! {
        arguments, state, inside, columns, ranges,
        parameters => parameters(&update),
        start_parameters => parameters(&start),
        steps => language.statements(body, &update, ends),
        start_steps => language.statements(&Body { notes: false, ..*body }, &start, false),
        state_bytes => program.state.iter().map(|w| if w.ty == Type::I64 { 8 } else { 4 }).sum::<usize>(),
        result_name => &*program.steps[program.output()].name,
        output_type => language.type_name(program.output_type()),
        table => table(language, program), rows => program.table.len(),
        start_reads_table => start.iter().any(|i| matches!(program.steps[*i].op, Op::Entry { .. })),
        entry_bits => 8 * program.entry_bytes(),
        helpers => language.helpers(body, &program.written_steps()),
        counts => body.counts,
    }
}

/// Numbers in a line of a table of one column.
const NUMBERS_IN_A_LINE: usize = 16;

/// The table's lines: one for each row, or many numbers of one column in a line.
fn table(language: &dyn Language, program: &Program) -> Vec<String> {
    let joined = |values: &[i64]| values.iter().map(|v| language.integer(*v)).collect::<Vec<_>>().join(", ");
    if program.table.first().is_some_and(|row| row.len() == 1) {
        let all: Vec<i64> = program.table.concat();
        return all.chunks(NUMBERS_IN_A_LINE).map(joined).collect();
    }
    program.table.iter().map(|row| language.row(&joined(row))).collect()
}
