//! The changes of a source that are tried: constants, shifts, limits, the state, rows of a table.

use crate::program::{Op, Operand, Program, Stage};
use crate::text;
use crate::verify::harness::{Language, Subject};

/// A change of one source file.
pub(super) struct Mutation {
    pub(super) what: String,
    pub(super) language: Language,
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
            (false, ..) => text.replacen(&self.from, &self.to, 1),
            _ => text.into(),
        }
    }
}

/// Every change that fits a routine.
pub(super) fn mutations(subject: &Subject<'_>, source_c: &str) -> Vec<Mutation> {
    let program = subject.program();
    let mut found = Vec::new();
    let constants: Vec<Operand> = program
        .steps
        .iter()
        .filter(|s| s.stage == Stage::Evaluation)
        .filter_map(|s| match &s.op {
            Op::MulAddHigh { c, .. }
            | Op::MulAddSplit { c, .. }
            | Op::MulAddShort { c, .. }
            | Op::MulAddF32 { c, .. } => Some(*c),
            _ => None,
        })
        .filter(|c| !matches!(c, Operand::Step(_) | Operand::Int(0)))
        .collect();
    let chosen = [constants.first(), constants.get(constants.len() / 2), constants.last()];
    for (c, units) in chosen.into_iter().flatten().zip([4i64, 2, 1]) {
        let what = format!("a coefficient of {c:?} off by {units} in its last place");
        match c {
            Operand::Int(v) => {
                let other = v + units * if *v < 0 { -1 } else { 1 };
                found.push(Mutation {
                    what: format!("{what}, Rust"),
                    language: Language::Rust,
                    swap: false,
                    from: format!("({})", text::grouped(*v)),
                    to: format!("({})", text::grouped(other)),
                });
                found.push(Mutation {
                    what: format!("{what}, C"),
                    language: Language::C,
                    swap: false,
                    from: format!(" {};", v.abs()),
                    to: format!(" {};", other.abs()),
                });
            }
            Operand::Float(v) => {
                let other = f32::from_bits(v.to_bits() + units as u32);
                found.push(Mutation {
                    what: format!("{what}, Rust"),
                    language: Language::Rust,
                    swap: false,
                    from: format!(" {}", text::float_decimal(v.abs())),
                    to: format!(" {}", text::float_decimal(other.abs())),
                });
                found.push(Mutation {
                    what: format!("{what}, C"),
                    language: Language::C,
                    swap: false,
                    from: format!(" {}f; /*", text::float_hex(v.abs())),
                    to: format!(" {}f; /*", text::float_hex(other.abs())),
                });
            }
            Operand::Step(_) => {}
        }
    }
    found.extend(shifts(program, source_c));
    found.extend(states(program));
    // The middle of a table is always reached.
    if let [_, .., _] = &program.table[..] {
        let middle = program.table.len() / 2;
        let pair = [&program.table[middle - 1], &program.table[middle]];
        let row = |digits: &dyn Fn(i64) -> String| {
            pair.map(|r| r.iter().map(|v| digits(*v)).collect::<Vec<_>>().join(", "))
        };
        let (rust, c) = (row(&text::grouped), row(&|v| v.to_string()));
        for (language, name, [from, to]) in [(Language::Rust, "Rust", rust), (Language::C, "C", c)] {
            let what = format!("a table with two segments swapped, {name}");
            found.push(Mutation { what, language, swap: true, from, to });
        }
    }
    found
}

/// A word of the state that is not kept, and a limit that is too narrow.
fn states(program: &Program) -> Vec<Mutation> {
    let mut found = Vec::new();
    if let Some((name, Operand::Step(next))) = program.state.last().map(|w| (&w.name, w.next)) {
        let next = &program.steps[next].name;
        for (language, text, of) in [(Language::Rust, "Rust", "self."), (Language::C, "C", "state->")] {
            let what = format!("`{name}` not kept, {text}");
            let (from, to) = (format!("{of}{name} = {next};"), format!("{of}{name} = {of}{name};"));
            found.push(Mutation { what, language, from, to, swap: false });
        }
    }
    let limit = program.steps.iter().rev().find_map(|s| match s.op {
        Op::Clamp { lo, hi, .. } if s.stage == Stage::Evaluation => Some((lo, hi)),
        _ => None,
    });
    if let Some((lo, hi)) = limit {
        for (language, name) in [(Language::Rust, "Rust"), (Language::C, "C")] {
            let digits = |v: i64| if language == Language::Rust { text::grouped(v) } else { v.to_string() };
            let ends = |hi: i64| format!("{}, {})", digits(lo), digits(hi));
            let what = format!("a limit of {} instead of {hi}, {name}", hi / 2);
            found.push(Mutation { what, language, from: ends(hi), to: ends(hi / 2), swap: false });
        }
    }
    found
}

/// Shifts of products that are off by one; in strict C a shift is an exact division, or its distance an argument.
fn shifts(program: &Program, source_c: &str) -> Vec<Mutation> {
    let shift = |op: &Op| match op {
        Op::MulAddHigh { .. } => Some((32, ">> 32".to_string(), [">> 32", "/ 4294967296)"])),
        Op::MulAddSplit { .. } => Some((16, ">> 16".to_string(), [") >> 16", ", 16u)"])),
        _ => None,
    };
    let Some((by, rust, in_c)) = program.steps.iter().find_map(|s| shift(&s.op)) else { return Vec::new() };
    let Some(c) = in_c.into_iter().find(|text| source_c.contains(text)) else { return Vec::new() };
    let less =
        |text: &str| text.replace(&by.to_string(), &(by - 1).to_string()).replace("4294967296", "2147483648");
    [(Language::Rust, "Rust", rust.as_str()), (Language::C, "C", c)]
        .into_iter()
        .map(|(language, name, from)| Mutation {
            what: format!("a product shifted by {} instead of {by}, {name}", by - 1),
            language,
            swap: false,
            from: from.into(),
            to: less(from),
        })
        .collect()
}
