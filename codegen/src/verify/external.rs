//! Other people's tools on the generated files: Gappa, cppcheck with the MISRA rules, the warnings of
//! two C compilers, and the symbols of the Rust object.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use minijinja::{Value, context};
use serde::Serialize;

use super::VerifyError;
use super::compile::{Place, Tool, messages, write};
use super::harness::Subject;
use crate::language::Language;
use crate::options::CShift;
use crate::program::{Op, StateWord, Type};
use crate::render::Renderer;

/// What one tool said.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ToolReport {
    /// The check.
    pub check: String,
    /// Of what.
    pub subject: String,
    /// Whether it holds.
    pub holds: bool,
    /// What was found, or what exactly holds.
    pub finding: String,
}

impl ToolReport {
    pub(super) fn new(check: &str, subject: &str, holds: bool, finding: impl Into<String>) -> Self {
        ToolReport { check: check.into(), subject: subject.into(), holds, finding: finding.into() }
    }
}

/// A check by another program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Check {
    /// Of undefined behaviour, over every input word.
    Analysis,
    /// Of the rules of MISRA, and all warnings of compilers.
    Rules,
    /// Of panics in the object.
    Objects,
}

/// What is checked.
#[derive(Clone, Copy)]
pub struct Checked<'a> {
    /// The routines.
    pub subjects: &'a [Subject<'a>],
    /// Their files.
    pub place: Place<'a>,
    /// How C shifts negative numbers to the right.
    pub shift: CShift,
}

/// Time that Gappa gets for one script.
const GAPPA_SECONDS: u64 = 60;

/// Runs the Gappa script of every routine.
pub(crate) fn gappa(subjects: &[Subject<'_>], generated: &Path) -> Result<Vec<ToolReport>, VerifyError> {
    subjects
        .iter()
        .map(|subject| {
            let script = generated.join(format!("gappa/{}.g", subject.name));
            if !script.exists() {
                return Ok(ToolReport::new("gappa", &subject.name, false, "there is no script of it"));
            }
            let proved = run_gappa(&script, GAPPA_SECONDS)?;
            let finding = match proved.clone() {
                None => format!("not proved within {GAPPA_SECONDS} s"),
                Some(Ok(())) => "rounding of the operations proved".into(),
                Some(Err(message)) => message,
            };
            Ok(ToolReport::new("gappa", &subject.name, proved == Some(Ok(())), finding))
        })
        .collect()
}

/// What Gappa says of a rewriting that it cannot confirm: it takes it on trust then, and so proves anything.
const UNCONFIRMED: &str = "are not trivially equal";
/// Of what Gappa prints so much is looked at; it speaks of rewritings before it begins to prove.
const HEARD_BYTES: usize = 1 << 16;

/// Runs one script: `None` where the time was not enough, otherwise whether it is proved, every identity that it names
/// confirmed.
pub fn run_gappa(script: &Path, seconds: u64) -> Result<Option<Result<(), String>>, VerifyError> {
    let tool = Tool::named("gappa", "apt-get install gappa");
    let started = std::process::Command::new(&tool.program)
        .arg(script)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    let mut child =
        started.map_err(|_| VerifyError::Missing { program: tool.program.clone(), install: tool.install })?;
    // A goal that is too tight makes Gappa print without end: it is read, and little of it kept.
    let heard = child.stderr.take().map(|stderr| std::thread::spawn(move || first_of(stderr)));
    let heard = move || heard.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let begun = Instant::now();
    loop {
        let failed = |cause| VerifyError::Run { program: "gappa".into(), cause };
        if let Some(status) = child.try_wait().map_err(failed)? {
            let said = heard();
            if let Some(line) = said.lines().find(|line| line.contains(UNCONFIRMED)) {
                return Ok(Some(Err(line.trim_start_matches("Warning: ").chars().take(300).collect())));
            }
            let message = "some properties were not satisfied".to_string();
            return Ok(Some(if status.success() { Ok(()) } else { Err(message) }));
        }
        if begun.elapsed() > Duration::from_secs(seconds) {
            child.kill().and_then(|()| child.wait()).map_err(failed)?;
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// The beginning of what a program prints, all of it read.
fn first_of(mut from: impl Read) -> String {
    let (mut kept, mut buffer) = (Vec::new(), [0; 4096]);
    while let Ok(count @ 1..) = from.read(&mut buffer) {
        let room = HEARD_BYTES.saturating_sub(kept.len());
        kept.extend_from_slice(&buffer[..count.min(room)]);
    }
    String::from_utf8_lossy(&kept).into_owned()
}

/// Runs cppcheck with the MISRA rules. A deviation holds where the file documents its rule.
pub(crate) fn misra(place: &Place<'_>) -> Result<ToolReport, VerifyError> {
    let Place { generated, base, .. } = *place;
    let tool = Tool::named("cppcheck", "apt-get install cppcheck");
    let file = format!("c/{base}.c");
    let arguments = [
        "-q",
        "--addon=misra",
        "--std=c99",
        "--enable=style",
        "--suppress=unusedFunction",
        "--template={file}:{line}: {id}",
        file.as_str(),
    ];
    let output = tool.output(&arguments, generated)?;
    let said = [&output.stdout[..], &output.stderr[..]].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    let text = fs::read_to_string(generated.join(&file)).unwrap_or_default();
    let findings: Vec<&str> = said.lines().filter(|l| l.starts_with(&file)).collect();
    let documented = |line: &&str| {
        let rule = line.rsplit("misra-c2012-").next().unwrap_or(line);
        text.lines().any(|l| l.contains("Deviations from MISRA") && l.contains(&format!("rule {rule} ")))
    };
    let open: Vec<&str> = findings.iter().copied().filter(|l| !documented(l)).collect();
    let holds = output.status.success() && open.is_empty();
    let finding = match (open.is_empty(), findings.is_empty()) {
        (true, true) => "clean".to_string(),
        (true, false) => format!("{} deviations, each documented in the file", findings.len()),
        _ => open.join("; "),
    };
    Ok(ToolReport::new("cppcheck misra", base, holds, finding))
}

const WARNINGS: [&str; 18] = [
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wsign-conversion",
    "-Wshadow",
    "-Wundef",
    "-Wdouble-promotion",
    "-Wstrict-prototypes",
    "-Wmissing-prototypes",
    "-Wcast-qual",
    "-Wcast-align",
    "-Wwrite-strings",
    "-Wbad-function-cast",
    "-Wswitch-default",
    "-Wredundant-decls",
    "-Wvla",
    "-Werror",
];

/// Compiles the C with gcc and clang, all warnings on; clang with every one it knows.
pub(crate) fn warnings(place: &Place<'_>) -> Result<Vec<ToolReport>, VerifyError> {
    let Place { generated, base, build } = *place;
    let file = generated.join(format!("c/{base}.c")).display().to_string();
    let object = build.join("warnings.o").display().to_string();
    ["gcc", "clang"]
        .iter()
        .map(|compiler| {
            let tool = Tool::named(compiler, "apt-get install gcc clang");
            let mut arguments: Vec<&str> = WARNINGS.to_vec();
            arguments.extend(["-std=c99", "-O2", "-c", "-o", &object, &file]);
            if *compiler == "clang" {
                // Declarations after statements are C99; whether a float was limited is asked by exact comparison.
                // A state of 64-bit words and an odd number of 32-bit ones ends with a gap.
                arguments.extend(["-Weverything", "-Wno-declaration-after-statement", "-Wno-float-equal"]);
                arguments.push("-Wno-padded");
            }
            let output = tool.output(&arguments, build)?;
            let finding = if output.status.success() { "no warning".into() } else { messages(&output) };
            Ok(ToolReport::new(compiler, base, output.status.success(), finding))
        })
        .collect()
}

/// Builds the Rust with overflow checks and debug assertions for the host and a Cortex-M4F, and looks for
/// symbols of panics in the objects; then documents the crate.
pub(crate) fn objects(language: &dyn Language, of: &Checked<'_>) -> Result<Vec<ToolReport>, VerifyError> {
    let Checked { subjects, place: Place { generated, base, build }, .. } = *of;
    let source = build.join("symbols.rs");
    let routines: Vec<Value> = subjects.iter().map(|s| laid_out(language, s)).collect();
    let context = context! { routines, crate_name => base };
    write(&source, &Renderer::new()?.render("verify/symbols.rs", context)?)?;
    let library = generated.join("src/lib.rs").display().to_string();
    let rustc = Tool::rustc();
    let nm = Tool::named("nm", "apt-get install binutils");
    let mut reports = Vec::new();
    for target in [None, Some("thumbv7em-none-eabihf")] {
        let name = target.unwrap_or("host");
        let folder = build.join(name);
        fs::create_dir_all(&folder).map_err(|cause| VerifyError::Write { path: folder.clone(), cause })?;
        let mut options = vec![
            "--edition=2024",
            "-Copt-level=2",
            "-Coverflow-checks=on",
            "-Cdebug-assertions=on",
            "-Cpanic=abort",
        ];
        let target = target.map(|t| format!("--target={t}"));
        options.extend(target.as_deref());
        let mut first = options.clone();
        first.extend(["--crate-type=rlib", "--crate-name", base, library.as_str()]);
        let mut second = options;
        let path = source.display().to_string();
        second.extend(["--crate-type=lib", "--emit=obj=symbols.o", "-L.", "--extern", base, path.as_str()]);
        let built = rustc.run(&first, &folder).and_then(|_| rustc.run(&second, &folder));
        if let Err(VerifyError::Refused { message, .. }) = &built {
            reports.push(ToolReport::new("panic-free", name, false, message.clone()));
            continue;
        }
        built?;
        let symbols = nm.run(&["symbols.o"], &folder)?;
        let missing = subjects.iter().find(|s| !symbols.contains(&format!("check_{}", s.name)));
        let panics: Vec<&str> = symbols.lines().filter(|l| l.contains("panic")).map(str::trim).collect();
        let finding = match (missing, panics.is_empty()) {
            (Some(s), _) => format!("{} is not in the object", s.name),
            (None, true) => "no panic in the object, overflow checks and debug assertions on".into(),
            _ => panics.join("; "),
        };
        reports.push(ToolReport::new("panic-free", name, missing.is_none() && panics.is_empty(), finding));
    }
    let rustdoc = Tool::named("rustdoc", "install Rust from https://rustup.rs");
    let out = build.join("doc").display().to_string();
    let arguments =
        ["--edition=2021", "-Dwarnings", "--crate-name", base, "-o", out.as_str(), library.as_str()];
    let output = rustdoc.output(&arguments, build)?;
    let finding = if output.status.success() { "no warning".into() } else { messages(&output) };
    reports.push(ToolReport::new("rustdoc", base, output.status.success(), finding));
    Ok(reports)
}

/// Whether a routine makes products from halves of words: the intervals of two halves do not know that they are of one word,
/// and make a product seem a little larger than it is.
pub(super) fn from_halves(s: &Subject<'_>) -> bool {
    s.program().steps.iter().any(|step| matches!(step.op, Op::MulAddSplit { .. }))
}

/// A routine as the templates of checks see it.
pub(super) fn laid_out(language: &dyn Language, s: &Subject<'_>) -> Value {
    let program = s.program();
    let word = |w: &StateWord| {
        context! { name => &*w.name, wide => w.ty == Type::I64, least => w.range.0, most => w.range.1 }
    };
    context! {
        name => &*s.name,
        flag => s.flag,
        continues => s.continues,
        arguments => program.arguments.iter().map(|a| language.type_name(a.ty)).collect::<Vec<_>>(),
        output => language.type_name(program.output_type()),
        type_name => crate::text::camel_case(&s.name),
        state => program.state.iter().map(word).collect::<Vec<_>>(),
        from_halves => from_halves(s),
    }
}
