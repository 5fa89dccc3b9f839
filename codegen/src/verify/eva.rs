//! Frama-C's value analysis of the generated C over every input word: integers of the whole type, floats with
//! the infinities. (A NaN is left to the sweeps, for in this analysis any comparison with one may hold.)
//!
//! It knows variables by their intervals. Where a fully defined shift to the right subtracts from a word its own
//! low bits, an interval that reaches down to −2³¹ seems to leave the type, which no word does: the difference is
//! the multiple of 2ⁿ below, and the row of a table that is found by it seems to lie one further. Where there is an alarm,
//! the analysis is done again with the shift's contract in place of its body, and the body is held against the contract on
//! all 2³² words, undefined behaviour watched for.

use minijinja::context;

use super::VerifyError;
use super::compile::{Place, Tool, messages, write};
use super::external::{Checked, ToolReport, from_halves, laid_out};
use super::harness::Subject;
use crate::language::Language;
use crate::options::CShift;
use crate::program::{Op, Step, Type};
use crate::render::Renderer;

/// How the helper with the contract begins in the generated C.
const SHIFT_RIGHT: &str = "static int32_t shift_right(int32_t value, uint32_t by)";

/// What the analysis said.
enum Outcome {
    Clean,
    Alarm(String),
    Failed(String),
}

/// Runs the analysis.
pub fn frama_c(language: &dyn Language, of: &Checked<'_>) -> Result<ToolReport, VerifyError> {
    let Checked { subjects, place: Place { generated, base, .. }, .. } = *of;
    let report = |holds, finding: String| Ok(ToolReport::new("frama-c", base, holds, finding));
    match analyse(language, of, false)? {
        Outcome::Clean => report(true, covered(subjects).into()),
        Outcome::Failed(message) => report(false, message),
        Outcome::Alarm(alarm) => {
            let file = generated.join(format!("c/{base}.c"));
            let source = std::fs::read_to_string(file).unwrap_or_default();
            if !source.contains(SHIFT_RIGHT) {
                return report(false, alarm);
            }
            match analyse(language, of, true)? {
                Outcome::Clean => {}
                Outcome::Alarm(alarm) | Outcome::Failed(alarm) => return report(false, alarm),
            }
            let distances = distances(&source);
            match hold_shift(&of.place, &distances)? {
                Some(broken) => report(false, format!("shift_right does not keep its contract: {broken}")),
                None => {
                    let by: Vec<String> = distances.iter().map(u32::to_string).collect();
                    report(
                        true,
                        format!(
                            "{}; shift_right by its contract, which it kept on all 2^32 words, by {}",
                            covered(subjects),
                            by.join(", ")
                        ),
                    )
                }
            }
        }
    }
}

fn covered(subjects: &[Subject<'_>]) -> &'static str {
    if takes_floats(subjects) {
        "no alarm for any input word, infinities among them; NaN is left to the sweeps"
    } else if subjects.iter().any(|s| from_halves(s) && !s.program().state.is_empty()) {
        "no alarm for any input word; that a routine begins in a state that can be reached is left to the sweeps"
    } else {
        "no alarm for any input word"
    }
}

fn fuses(step: &Step) -> bool {
    matches!(step.op, Op::MulAddF32 { fused: true, .. })
}

fn takes_floats(subjects: &[Subject<'_>]) -> bool {
    subjects.iter().any(|s| s.program().arguments[0].ty == Type::F32)
}

fn analyse(language: &dyn Language, of: &Checked<'_>, by_contract: bool) -> Result<Outcome, VerifyError> {
    let Checked { subjects, place: Place { generated, base, build }, shift } = *of;
    let source = build.join("eva.c");
    let any_float = takes_floats(subjects);
    let context = context! {
        routines => subjects.iter().map(|s| laid_out(language, s)).collect::<Vec<_>>(),
        source => format!("{base}.c"),
        shift_right_contract => by_contract,
        any_float,
        fused => subjects.iter().any(|s| s.program().steps.iter().any(fuses)),
    };
    write(&source, &Renderer::new()?.render("verify/eva.c", context)?)?;
    let tool = Tool::named("frama-c", "apt-get install frama-c-base");
    let cpp = format!(
        "-cpp-extra-args=-I{} -msse2 -mfpmath=sse -D__FLT_EVAL_METHOD__=0",
        generated.join("c").display()
    );
    // Shifting negative numbers right is what `arithmetic` asks for; the file documents it.
    let shifts =
        if shift == CShift::Strict { "-warn-right-shift-negative" } else { "-no-warn-right-shift-negative" };
    // A segment's number and place are told from sums that wrap on purpose. (Conversions of negative numbers to
    // unsigned ones, by which low bits are taken, are in every fixed-point routine: they are not asked for.)
    let wraps = subjects.iter().any(|s| s.program().steps.iter().any(|s| matches!(s.op, Op::Index { .. })));
    let unsigned = if wraps { "-no-warn-unsigned-overflow" } else { "-warn-unsigned-overflow" };
    // Where an argument may be infinite, so may a difference; that results are not is asserted.
    let special = if any_float { "-warn-special-float=none" } else { "-warn-special-float=non-finite" };
    let mut arguments = vec![
        "-eva",
        "-eva-precision=6",
        "-machdep=gcc_x86_32",
        "-warn-signed-downcast",
        "-warn-signed-overflow",
        shifts,
        unsigned,
        special,
        "-eva-warn-key=alarm=abort",
    ];
    if by_contract {
        arguments.push("-eva-use-spec=shift_right");
    }
    let path = source.display().to_string();
    arguments.extend([cpp.as_str(), path.as_str()]);
    let output = tool.output(&arguments, build)?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() && text.contains("ANALYSIS SUMMARY") {
        return Ok(Outcome::Clean);
    }
    let alarm = text.lines().skip_while(|l| !l.contains("alarm]")).take(6).collect::<Vec<_>>().join(" ");
    Ok(if alarm.is_empty() { Outcome::Failed(messages(&output)) } else { Outcome::Alarm(alarm) })
}

/// The distances by which the source shifts: the last argument of every call.
fn distances(source: &str) -> Vec<u32> {
    let calls = source.split("shift_right(").skip(1).filter_map(|rest| {
        let mut depth = 1;
        let end = rest.find(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        })?;
        rest[..end].rsplit(", ").next()?.strip_suffix('u')?.parse().ok()
    });
    let mut found: Vec<u32> = calls.collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Holds the helper against its contract on every word; gives the first that breaks it.
fn hold_shift(place: &Place<'_>, distances: &[u32]) -> Result<Option<String>, VerifyError> {
    let Place { generated, base, build } = *place;
    let source = build.join("shift_right.c");
    let context = context! { source => format!("{base}.c"), distances => distances.to_vec() };
    write(&source, &Renderer::new()?.render("verify/shift_right.c", context)?)?;
    let executable = build.join("shift_right");
    let (path, out) = (source.display().to_string(), executable.display().to_string());
    let include = format!("-I{}", generated.join("c").display());
    let arguments =
        ["-std=c99", "-O2", "-fsanitize=undefined", "-fno-sanitize-recover=all", &include, "-o", &out, &path];
    Tool::cc().run(&arguments, build)?;
    let output = Tool { program: out, install: "" }.output(&[], build)?;
    Ok((!output.status.success()).then(|| messages(&output)))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::fixtures::paper_coefficients;
    use crate::format::Format;
    use crate::generate::{Generated, generate};
    use crate::input::{Arity, Encoding, Input};
    use crate::language;
    use crate::options::{Method, Options, RoutineOptions};

    fn analysed(generated: &Generated, options: &Options, from: &str, to: &str) -> ToolReport {
        let folder = tempfile::tempdir().unwrap();
        let mut files = generated.files.clone();
        for text in files.values_mut() {
            *text = text.replacen(from, to, 1);
        }
        crate::files::write(folder.path(), &files).unwrap();
        let subjects = Subject::all(generated, options);
        let place = Place { generated: folder.path(), base: &generated.name, build: folder.path() };
        let of = Checked { subjects: &subjects, place, shift: options.c_shift };
        let c = language::ALL.into_iter().find(|language| language.name() == "c").unwrap();
        frama_c(c, &of).unwrap()
    }

    fn here() -> bool {
        let found = Tool::named("frama-c", "").output(&["--version"], Path::new(".")).is_ok();
        assert!(found || std::env::var("CI").as_deref() != Ok("true"), "frama-c is missing");
        if !found {
            println!("skipped: analyses by Frama-C; apt-get install frama-c-base");
        }
        found
    }

    /// A table of split products: words reach −2³¹, so that the shift's contract is needed; without the low bits
    /// being taken off, neither the contract nor the analysis is content.
    #[test]
    #[ignore = "takes long: in .ci/full"]
    fn a_table_of_split_products_is_without_alarm() {
        if !here() {
            return;
        }
        let method = Method::Piecewise { degree: 3, segments_log2: 4, padded: false, place: None };
        let routine = RoutineOptions { method, ..RoutineOptions::of(Format::Q31Split) };
        let options = Options { routines: vec![routine], ..Options::default() };
        let generated = generate(&paper_coefficients(), "0", &options).unwrap();
        let right = analysed(&generated, &options, "", "");
        assert!(right.holds, "{right:?}");
        let wrong = analysed(&generated, &options, "(divisor - 1u)", "(divisor - 2u)");
        assert!(!wrong.holds, "{wrong:?}");
        let wrong = analysed(&generated, &options, "= row[0];", "= row[0] * 2;");
        assert!(!wrong.holds && wrong.finding.contains("overflow"), "{wrong:?}");
    }

    /// Infinities go in; none comes out, unless the limits are taken away.
    #[test]
    fn infinities_do_not_come_out() {
        if !here() {
            return;
        }
        let input = Input { arity: Arity::Probes, encoding: Encoding::F32 };
        let routine = RoutineOptions { input, ..RoutineOptions::of(Format::F32) };
        let options = Options { routines: vec![routine], ..Options::default() };
        let generated = generate(&paper_coefficients(), "0", &options).unwrap();
        let right = analysed(&generated, &options, "", "");
        assert!(right.holds, "{right:?}");
        let wrong = analysed(&generated, &options, "(value > hi) ? hi : value", "value");
        assert!(!wrong.holds, "{wrong:?}");
    }
}
