//! Rust: a `no_std` crate without dependencies, one module for each routine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use minijinja::{Value, context};

use super::{Body, Checker, File, Language, limit};
use crate::program::{Op, Operand, Program, Step, Type};
use crate::render::{RenderError, Renderer};
use crate::text::grouped;
use crate::verify::VerifyError;
use crate::verify::compile::{How, Place, Tool};
use crate::verify::external::{self, Check, Checked, ToolReport};

/// The language.
#[derive(Debug)]
pub(super) struct Rust;

/// The Rust routines of generated files as one module that a firmware includes, where a crate of its own is not wanted:
/// its text, and the other files. A single routine also goes by the base name alone, whatever format was chosen.
///
/// # Errors
/// [`RenderError`] for a defect of the template.
pub fn module(
    name: &str,
    files: &BTreeMap<PathBuf, String>,
) -> Result<(String, BTreeMap<PathBuf, String>), RenderError> {
    let of_the_crate = |path: &Path| path.starts_with("src") || path == Path::new("Cargo.toml");
    let modules: Vec<Value> = (files.iter().filter(|(path, _)| path.starts_with("src")))
        .filter_map(|(path, text)| {
            let name = path.file_stem()?.to_str().filter(|name| *name != "lib")?;
            Some(context! { name, text })
        })
        .collect();
    let text = Renderer::new()?.render("rust/module.rs", context! { name, modules })?;
    let others = files.iter().filter(|(path, _)| !of_the_crate(path));
    Ok((text, others.map(|(path, text)| (path.clone(), text.clone())).collect()))
}

/// c added to an integer.
fn plus(program: &Program, c: &Operand) -> String {
    match c {
        Operand::Int(0) => String::new(),
        other => format!(".wrapping_add({})", Rust.operand(program, other)),
    }
}

/// Behind a constant that is not zero.
fn plus_constant(value: u32) -> String {
    if value == 0 { String::new() } else { format!(".wrapping_add({})", grouped(value.into())) }
}

/// An operand as a `u32`, and whether that takes a conversion.
fn word(body: &Body<'_>, operand: &Operand) -> (String, bool) {
    let name = Rust.operand(body.program, operand);
    let converted = matches!(operand, Operand::Step(_)) && body.type_of(operand) != Type::U32;
    (if converted { format!("{name} as u32") } else { name }, converted)
}

/// The same in brackets where it needs them, shifted left.
fn shifted(body: &Body<'_>, operand: &Operand, by: u32) -> String {
    let (name, converted) = word(body, operand);
    let name = if converted { format!("({name})") } else { name };
    if by > 0 { format!("({name} << {by})") } else { name }
}

impl Language for Rust {
    fn name(&self) -> &'static str {
        "rust"
    }

    fn templates(&self) -> &'static [(&'static str, &'static str)] {
        templates![
            "rust/Cargo.toml",
            "rust/lib.rs",
            "rust/routine.rs",
            "rust/page.rs",
            "rust/helpers.rs",
            "rust/module.rs",
            "verify/sweep.rs",
            "verify/calls.rs",
            "verify/pages.rs",
            "verify/symbols.rs",
        ]
    }

    fn files(&self, base: &str, routines: &[&str]) -> Vec<File> {
        let file = |path: &str, template| File { path: path.into(), template, routine: None };
        let mut files = vec![file("Cargo.toml", "rust/Cargo.toml"), file("src/lib.rs", "rust/lib.rs")];
        files.extend(routines.iter().enumerate().map(|(index, name)| File {
            routine: Some(index),
            ..file(&self.file_of(base, name), "rust/routine.rs")
        }));
        files
    }

    fn file_of(&self, _base: &str, routine: &str) -> String {
        format!("src/{routine}.rs")
    }

    fn type_name(&self, ty: Type) -> &'static str {
        ty.name()
    }

    fn parameter(&self, name: &str, ty: Type, read: bool) -> String {
        format!("{}{name}: {}", if read { "" } else { "_" }, ty.name())
    }

    fn integer(&self, value: i64) -> String {
        grouped(value)
    }

    /// The shortest decimal that reads back as the same float.
    fn float(&self, value: f32) -> String {
        format!("{value:?}")
    }

    fn expression(&self, body: &Body<'_>, step: &Step) -> String {
        if let Some(text) = of_counts(body, step) {
            return text;
        }
        let program = body.program;
        let text = |operand: &Operand| self.operand(program, operand);
        let plus = |c: &Operand| plus(program, c);
        let differs = |a: &Operand| body.type_of(a) != step.ty;
        let ty = step.ty.name();
        match &step.op {
            Op::Input { index } => program.arguments[*index].name.clone(),
            Op::State { index } => format!("self.{}", program.state[*index].name),
            Op::Word { index } => format!("self.c[{index}]"),
            Op::Add { a, b } => text(a) + &plus(b),
            Op::Sub { a, b } if step.ty == Type::F32 => format!("{} - {}", text(a), text(b)),
            Op::Sub { a, b: b @ Operand::Int(_) } if differs(a) => {
                format!("({} as i32).wrapping_sub({})", text(a), text(b))
            }
            Op::Sub { a, b: b @ Operand::Step(_) } if differs(a) => {
                format!("({} as {ty}).wrapping_sub({} as {ty})", text(a), text(b))
            }
            // A number by itself has no type.
            Op::Sub { a: a @ Operand::Int(_), b } => format!("i32::wrapping_sub({}, {})", text(a), text(b)),
            Op::Sub { a, b } => format!("{}.wrapping_sub({})", text(a), text(b)),
            Op::Clamp { a, lo, hi } => {
                let from = body.type_of(a);
                let wide = &limit(from)["limit_".len()..];
                let cast = if from == Type::I32 { String::new() } else { format!(" as {wide}") };
                let narrowed = if wide == "i32" { "" } else { " as i32" };
                let limit = limit_function(body, limit(from));
                format!("{limit}({}{cast}, {}, {}){narrowed}", text(a), grouped(*lo), grouped(*hi))
            }
            Op::ClampF32 { a, lo, hi } => {
                let limit = limit_function(body, "limit_f32");
                format!("{limit}({}, {}, {})", text(a), self.float(*lo), self.float(*hi))
            }
            Op::ShiftLeft { a, by } => format!("{} << {by}", text(a)),
            Op::ShiftRight { a, add: 0, by } => format!("{} >> {by}", text(a)),
            Op::ShiftRight { a, add, by } => {
                format!("{}.wrapping_add({}) >> {by}", text(a), grouped(*add))
            }
            Op::Index { a, add, by } if step.ty == Type::I32 => {
                format!("({} >> {by}).wrapping_add({})", text(a), add >> by)
            }
            Op::Index { a, add, by } => {
                format!("({} as u32).wrapping_add({}) >> {by}", text(a), grouped((*add as u32).into()))
            }
            // Modulo 2³² it is one whether the sum or the product by 2^by comes first.
            Op::Wrap { a, add, by } => match (*add as u32) << by {
                0 => format!("{} << {by}", text(a)),
                add => format!("({} << {by}).wrapping_add({})", text(a), grouped((add as i32).into())),
            },
            Op::Entry { index, column } => format!("{}[{column}]", body.row_name(index)),
            Op::MulAddWide { a, b, c } => {
                format!("({} as i64).wrapping_mul({}){}", text(a), text(b), plus(c))
            }
            Op::High { a, by } => format!("({} >> {by}) as i32", text(a)),
            Op::Phase { a, factor, by } => {
                format!("(({} as i64 * {}) >> {by}) as i32", text(a), grouped(*factor))
            }
            Op::Truncate { a } => format!("{} as i32", text(a)),
            Op::ToF32 { a } => format!("{} as f32", text(a)),
            Op::MulF32 { a, b } => format!("{} * {}", text(a), text(b)),
            Op::MulAddHigh { a, b, shift, c } => product("mul_high", &text(a), &text(b), *shift, &plus(c)),
            Op::MulAddSplit { a, b, shift, c } => product("mul_split", &text(a), &text(b), *shift, &plus(c)),
            Op::MulAddShort { a, b, by, c } => {
                format!("mul_short({}, {}, {by}){}", text(a), text(b), plus(c))
            }
            Op::MulAddF32 { a, b, c, fused: true } => format!("fused({}, {}, {})", text(a), text(b), text(c)),
            Op::MulAddF32 { a, b, c, .. } => {
                format!("{} * {}{}", text(a), text(b), self.plus_float(program, c))
            }
            Op::Bits { .. } | Op::Shifted { .. } | Op::Around { .. } => unreachable!("of counts"),
        }
    }

    fn statements(&self, body: &Body<'_>, which: &[usize], ends: bool) -> Vec<String> {
        let mut lines = Vec::new();
        for (index, step) in body.written(which) {
            if let Some((row, name)) = body.row_before(index, which) {
                let row = self.operand(body.program, row);
                lines.push(format!("let {name} = &TABLE[{row} as usize];"));
            }
            let note = body.note(step, ("//", ""));
            let expression = self.expression(body, step);
            lines.push(if ends && index == body.program.output() {
                expression + &note
            } else {
                format!("let {} = {expression};{note}", step.name)
            });
        }
        lines
    }

    fn inside(&self, raw: &Step, limited: &Step) -> String {
        let wide = if raw.ty == limited.ty { String::new() } else { format!(" as {}", raw.ty.name()) };
        format!("{} == {}{wide}", raw.name, limited.name)
    }

    fn row(&self, numbers: &str) -> String {
        format!("[{numbers}]")
    }

    fn helpers(&self, body: &Body<'_>, which: &[usize]) -> Vec<&'static str> {
        let mut helpers = body.helpers(which);
        helpers.retain(|helper| {
            helper.starts_with("limit_") || helper.starts_with("mul_") || ["around", "fused"].contains(helper)
        });
        helpers.sort_by_key(|helper| *helper != "around");
        helpers
    }

    fn keywords(&self) -> &'static str {
        "abstract as async await become box break const continue crate do dyn else enum extern false final fn for gen if \
         impl in let loop macro match mod move mut override priv pub ref return self Self static struct super trait true \
         try type typeof unsafe unsized use virtual where while yield"
    }

    fn reserved(&self) -> &'static [(&'static str, &'static str)] {
        &[(
            "alloc core std proc_macro test main lib build deps examples incremental",
            "a crate, file or function that Rust and C treat as their own",
        )]
    }

    fn checker(&self) -> Option<&dyn Checker> {
        Some(self)
    }
}

impl Checker for Rust {
    fn extension(&self) -> &'static str {
        "rs"
    }

    fn double(&self, value: f64) -> String {
        format!("f64::from_bits(0x{:016x})", value.to_bits())
    }

    fn argument(&self, ty: Type) -> String {
        if ty == Type::F32 { "f32::from_bits(word)".into() } else { format!("word as {}", ty.name()) }
    }

    fn library(&self, how: How, place: &Place<'_>) -> Result<(), VerifyError> {
        let library = place.generated.join("src/lib.rs").display().to_string();
        let output = place.build.join(format!("lib{}.rlib", place.base)).display().to_string();
        let mut arguments = vec!["--edition=2021", "--crate-type=rlib", "--crate-name", place.base];
        arguments.extend(OPTIONS);
        arguments.extend(how.strict.then_some("-Coverflow-checks=on"));
        arguments.extend(["-o", output.as_str(), library.as_str()]);
        Tool::rustc().run(&arguments, place.build).map(drop)
    }

    fn compiler(&self, place: &Place<'_>, how: How, source: &Path, executable: &Path) -> (Tool, Vec<String>) {
        let mut arguments = vec!["--edition=2024".to_string()];
        arguments.extend(OPTIONS.map(String::from));
        arguments.extend(how.strict.then(|| "-Coverflow-checks=on".into()));
        arguments.extend([format!("-L{}", place.build.display()), "--extern".into(), place.base.into()]);
        arguments.extend(["-o".into(), executable.display().to_string(), source.display().to_string()]);
        (Tool::rustc(), arguments)
    }

    fn check(&self, check: Check, of: &Checked<'_>) -> Result<Vec<ToolReport>, VerifyError> {
        if check == Check::Objects { external::objects(self, of) } else { Ok(Vec::new()) }
    }

    fn shifts(&self, by: u32) -> Vec<String> {
        vec![format!(">> {by}")]
    }
}

const OPTIONS: [&str; 4] = ["-Copt-level=3", "-Ctarget-cpu=native", "-Cpanic=abort", "--cap-lints=warn"];

/// What a function limits by is its name, where several types are limited.
fn limit_function(body: &Body<'_>, of_type: &'static str) -> &'static str {
    let written = body.helpers(&body.program.written_steps());
    let several = written.iter().filter(|helper| helper.starts_with("limit_")).count() > 1;
    if several { of_type } else { "limit" }
}

/// The operations on counts, which are unsigned words; none of others.
fn of_counts(body: &Body<'_>, step: &Step) -> Option<String> {
    let program = body.program;
    let text = |operand: &Operand| Rust.operand(program, operand);
    Some(match &step.op {
        Op::Clamp { a, hi, .. } if step.ty == Type::U32 => {
            let hi = grouped(*hi);
            format!("if {} < {hi} {{ {} }} else {{ {hi} }}", text(a), word(body, a).0)
        }
        Op::Wrap { a, add, by } if body.type_of(a) != Type::I32 => {
            format!("{}{} as i32", shifted(body, a, *by), plus_constant((*add as u32) << by))
        }
        Op::Bits { a, from, bits } => {
            let mask = grouped((1 << bits) - 1);
            let field = match from {
                0 => format!("{} & {mask}", word(body, a).0),
                from => format!("({} >> {from}) & {mask}", shifted(body, a, 0)),
            };
            if step.ty == Type::U32 { field } else { format!("({field}) as {}", step.ty.name()) }
        }
        Op::Shifted { a, by, b, add } => format!(
            "{}.wrapping_add({}){}",
            shifted(body, a, *by),
            word(body, b).0,
            plus_constant(*add as u32)
        ),
        Op::Around { a, turn } => format!("around({}, {})", text(a), grouped((*turn).into())),
        Op::Entry { index, column } if body.counts => {
            let column = if program.table[0].len() > 1 { format!("[{column}]") } else { String::new() };
            let cast = if program.entry_bytes() == 4 { "" } else { " as i32" };
            format!("TABLE[{} as usize]{column}{cast}", text(index))
        }
        Op::MulAddShort { a, b, by, c } if body.counts => {
            format!("({}.wrapping_mul({}) >> {by}){}", text(a), text(b), plus(program, c))
        }
        _ => return None,
    })
}

/// The high part of a product, shifted left, and what is added to it.
fn product(function: &str, a: &str, b: &str, shift: u32, plus: &str) -> String {
    match (shift, plus) {
        (0, _) => format!("{function}({a}, {b}){plus}"),
        (_, "") => format!("{function}({a}, {b}) << {shift}"),
        _ => format!("({function}({a}, {b}) << {shift}){plus}"),
    }
}
