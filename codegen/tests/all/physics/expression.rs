//! Random expressions of every operator: over random sequences the routine stays within its bound of what `apply`
//! evaluates, and `arcsmith verify`'s own model agrees.

use std::process::Command;

use codegen::generate::generate;
use fitter::terms::{Expressed, ExpressionFactor};
use physics::parse;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use rayon::prelude::*;

use super::*;

/// Seconds between two calls.
const PERIOD_S: f64 = 0.05;
/// The bound that is asked for: a few of 2^16 parts of what the expressions are.
const BOUND_ARCSEC: f64 = 0.5;
/// Expressions that are compiled into one program.
const TOGETHER: usize = 100;
/// Calls of a compiled routine.
const CALLS: usize = 300;

/// The expression of a term in k arcsec.
pub(super) fn expressed(text: &str) -> Operator {
    let mut observables: Vec<String> = Vec::new();
    for name in parse(text).unwrap().names() {
        let observable = if name == "angle" { "angle_arcsec" } else { name };
        if name != "k" && !observables.iter().any(|other| other == observable) {
            observables.push(observable.into());
        }
    }
    if ["lowpass", "rate", "delay", "play"].iter().any(|name| text.contains(name)) {
        observables.push("t_s".into());
    }
    let factors = vec![ExpressionFactor { name: "k".into(), unit: "arcsec".into() }];
    Operator::Expression(Expressed {
        text: text.into(),
        unit: "arcsec".into(),
        observables,
        factors,
        parameters: Vec::new(),
        limits: Default::default(),
    })
}

/// A pure number from about −1 to 1.
fn leaves() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("((temperature_c - 25) / 10 [K])".to_string()),
        Just("(angle / 6600 [arcsec])".to_string()),
        (-3.0..3.0_f64).prop_map(|number| format!("({number:.3})")),
    ]
}

/// Whether it moves although its input does not: a lag that starts elsewhere. In its rate `apply` and firmware differ at
/// the first row, and in whatever remembers that: see docs/own-effects.md.
fn starts_elsewhere(text: &str) -> bool {
    text.contains("[s], 0.3)")
}

/// Expressions of pure numbers, whose values stay small.
fn expressions() -> impl Strategy<Value = String> {
    leaves().prop_recursive(4, 16, 3, |inner| {
        let pair = || (inner.clone(), inner.clone());
        let one = |form: &'static str| inner.clone().prop_map(move |a| form.replace("A", &a)).boxed();
        let two = |form: &'static str| {
            pair().prop_map(move |(a, b)| form.replace("A", &a).replace("B", &b)).boxed()
        };
        let number = 0.05..2.0_f64;
        let with = |form: &'static str| {
            (inner.clone(), number.clone())
                .prop_map(move |(a, n)| form.replace("A", &a).replace("N", &format!("{n:.3}")))
                .boxed()
        };
        let jumps =
            (14.0..36.0_f64, prop::sample::select(vec!["step(temperature_c, N)", "sign(temperature_c - N)"]))
                .prop_map(|(at, form)| format!("({})", form.replace("N", &format!("{at:.4}"))));
        prop_oneof![
            two("((A) + (B))"),
            two("((A) - (B))"),
            two("(0.5 * (A) * (B))"),
            two("((A) / (2 + (B)^2))"),
            one("((A)^2 / 2)"),
            one("(tanh(A)^3)"),
            one("(-(A))"),
            one("abs(A)"),
            two("min(A, B)"),
            two("max(A, B)"),
            one("sqrt(0.3 + (A)^2)"),
            one("exp(tanh(A))"),
            one("log(0.3 + (A)^2)"),
            one("sin(3 * (A))"),
            one("cos(9 * (A))"),
            one("tanh(2 * (A))"),
            with("hinge(A, N)"),
            with("bump(A, 0.2, N)"),
            with("table(A, -0.4, N, 0.3, -0.2, 0.9, N, N, -0.5)"),
            with("table(A, -N, 0.1, 0.3, -N)"),
            jumps,
            with("lowpass(A, N * 1 [s])"),
            inner
                .clone()
                .prop_filter("it moves from the first row", |a| !starts_elsewhere(a))
                .prop_map(|a| format!("(rate({a}) * 0.05 [s])"))
                .boxed(),
            // Of a whole number of calls, or between two.
            (inner.clone(), 0..24_u32)
                .prop_map(|(a, n)| format!("delay({a}, {} [s])", PERIOD_S * 0.25 * f64::from(n))),
            with("play(A, N)"),
            with("plays(A, N)"),
            with("play(A, N, 0.3)"),
            with("lowpass(A, N * 1 [s], 0.3)"),
        ]
    })
}

/// Options for an expression, with the inputs that it reads.
fn options_for(text: &str) -> Options {
    let mut options =
        Options { period_s: Some(PERIOD_S), bound: Some(BOUND_ARCSEC), degree: Some(9), ..options() };
    if !text.contains("temperature_c") {
        options.further.clear();
    }
    options
}

/// Holds the routine of an expression against `apply` and against the model of `verify`; its bound in arcsec.
fn held(text: &str, sequences: &[Vec<(i32, u16)>]) -> Result<f64, String> {
    held_of(text, expressed(&format!("k * {text}")), sequences)
}

/// See [`held`].
fn held_of(text: &str, operator: Operator, sequences: &[Vec<(i32, u16)>]) -> Result<f64, String> {
    let mut coefficients = paper();
    coefficients.terms = vec![term("random", operator, vec![1.0])];
    assert_eq!(coefficients.terms[0].contradiction(), None, "{text}");
    let options = options_for(text);
    let routine =
        routine::design(&coefficients, &options, &options.routines[0]).map_err(|error| error.to_string())?;
    let (unit, bound) = (routine.design.unit.to_f64(), routine.design.bound.total);
    let fast_reference = FastReference::of(&routine);
    for words in sequences {
        // The rate of a first row is that of the second, the rate of a first call is 0.
        let words: Vec<(i32, u16)> = words[..1].iter().chain(words).copied().collect();
        let sequence = readings(&words);
        let recording = recorded(&sequence, PERIOD_S);
        let observables = Observables { recording: &recording, sensor: &coefficients.sensor };
        let added = fitter::terms::evaluate(&coefficients.terms, &observables, true).inside;
        let mut model = Model::new(&routine, &fast_reference);
        let further = !options.further.is_empty();
        let found = if further { interpreted(&routine, &words) } else { alone(&routine, &words) };
        for (row, word) in found.into_iter().enumerate() {
            let inputs = [f64::from(words[row].1)];
            let inputs = if further { &inputs[..] } else { &[] };
            let modelled = model.call(row == 0, f64::from(words[row].0), inputs);
            let expected = paper().error_model().corrected(sequence[row].0) - added[row] / ARCSEC_PER_RAD;
            let (error, own) = ((f64::from(word) * unit - expected).abs(), modelled.error * unit);
            assert!(error <= bound + 4.0 * own, "{text}, row {row}: {error:e} exceeds {bound:e}, {:e}", own);
            let apart = (modelled.words * unit - expected).abs();
            assert!(apart <= 4.0 * own, "{text}, row {row}: the model is {apart:e} off, {own:e} said");
        }
    }
    Ok(bound * ARCSEC_PER_RAD)
}

proptest! {
    #![proptest_config(ProptestConfig { max_shrink_iters: 30, ..ProptestConfig::with_cases(cases(100)) })]
    #[test]
    fn any_expression_holds_its_bound(text in expressions(), sequences in prop::collection::vec(any_sequence(), 3)) {
        let bound = held(&text, &sequences);
        prop_assert!(bound.as_ref().is_ok_and(|bound| *bound <= BOUND_ARCSEC), "{text}: {bound:?}");
    }
}

/// A form is limited to what was recorded of its columns where the box is wider, as `apply` limits it.
#[test]
fn a_column_is_limited_to_what_was_recorded() {
    let (_, words) = walk();
    let inside =
        words[..CALLS].iter().map(|(s, t)| ((*s).clamp(-1 << 30, (1 << 30) - 1), (*t).clamp(1901, 3899)));
    let text = "lowpass(((temperature_c - 25) / 10 [K])^2, 0.4 [s])";
    let Operator::Expression(mut form) = expressed(&format!("k * {text}")) else { panic!("an expression") };
    form.limits.insert("temperature_c".into(), [20.5, 27.0]);
    let bound = held_of(text, Operator::Expression(form), &[inside.collect()]);
    assert!(bound.as_ref().is_ok_and(|bound| *bound <= BOUND_ARCSEC), "{bound:?}");
}

/// A word whose largest value is next to a power of two, and its rounding beyond.
#[test]
fn a_word_that_nearly_fills_its_type_fits() {
    let (_, words) = walk();
    let inside =
        words[..CALLS].iter().map(|(s, t)| ((*s).clamp(-1 << 30, (1 << 30) - 1), (*t).clamp(1901, 3899)));
    let text = "(rate(((((temperature_c - 25) / 10 [K]))^2 / 2)) * 0.05 [s])";
    let bound = held(text, &[inside.collect()]);
    assert!(bound.as_ref().is_ok_and(|bound| *bound <= BOUND_ARCSEC), "{bound:?}");
}

/// Gaps far wider than what is seen, many of them, and starts far away: the words of a play are chosen so that all fit.
#[test]
fn plays_of_any_gap_and_start_hold_their_bound() {
    let (_, words) = walk();
    let inside =
        words[..CALLS].iter().map(|(s, t)| ((*s).clamp(-1 << 30, (1 << 30) - 1), (*t).clamp(1901, 3899)));
    let sequences = [inside.collect()];
    let (t, product) =
        ("((temperature_c - 25) / 10 [K])", "(0.1 * (temperature_c - 25) / 1 [K] * (angle / 6600 [arcsec]))");
    for (seen, other) in [
        (t, "plays(X, 1.5, 0, 12)"),
        (t, "plays(X, 20, 0, 64)"),
        (product, "plays(X, 7, 0.2, 33)"),
        (product, "play(X, 1000, 0)"),
        (t, "play(X, 0.001, -1.4)"),
        (t, "play(X, 3, -40)"),
        ("lowpass(X^2, 2 [s])", "plays(X, 4, 30, 16)"),
    ] {
        let seen = seen.replace('X', t);
        let bound = held(&format!("(({seen}) - {})", other.replace('X', &seen)), &sequences);
        assert!(bound.as_ref().is_ok_and(|bound| *bound <= BOUND_ARCSEC), "{seen}, {other}: {bound:?}");
    }
    let narrow = held(&format!("play({product}, 1e-10)"), &sequences).unwrap_err();
    assert!(narrow.contains("`expression` of random") && narrow.contains("narrow the ranges"), "{narrow}");
}

/// Tables of few and of many places, from end to end of what is seen, next to it and far within it.
#[test]
fn tables_of_any_length_hold_their_bound() {
    let (_, words) = walk();
    let inside =
        words[..CALLS].iter().map(|(s, t)| ((*s).clamp(-1 << 30, (1 << 30) - 1), (*t).clamp(1901, 3899)));
    let sequences = [inside.collect()];
    let (t, product) =
        ("((temperature_c - 25) / 10 [K])", "(2 * (temperature_c - 25) / 10 [K] * (angle / 6600 [arcsec]))");
    let values = |count: i32| (0..count).map(|k| format!(", {:.3}", f64::from(k * k % 17) / 17.0)).collect();
    for (seen, from, to, count) in [
        (t, -1.5, 1.5, 64),
        (t, -0.01, 0.02, 2),
        (t, 0.3, 400.0, 5),
        (t, -1e4, 1e4, 33),
        ("(angle / 6600 [arcsec])", -1.0, 1.0, 49),
        (product, -0.5, 0.5, 7),
        ("lowpass(X^2, 2 [s])", 0.0, 0.9, 12),
    ] {
        let values: String = values(count);
        let text = format!("table({}, {from}, {to}{values})", seen.replace('X', t));
        let bound = held(&text, &sequences);
        assert!(bound.as_ref().is_ok_and(|bound| *bound <= BOUND_ARCSEC), "{text}: {bound:?}");
    }
    for (text, why) in [
        ("table(temperature_c, 20, 30 [K] + (temperature_c - 20) / 2, 0, 1)", "a table's end that changes"),
        ("table(temperature_c, min(temperature_c, 25), 30, 0, 1)", "a table's beginning that changes"),
        ("table(temperature_c, 20, 30, 0, angle / 6600 [arcsec])", "a table's value that changes"),
    ] {
        let refused = held(text, &sequences).unwrap_err();
        assert!(refused.contains("`expression` of random") && refused.contains(why), "{text}: {refused}");
    }
}

/// How many random expressions are tried: `ARCSMITH_EXPRESSIONS`, or `usual`.
fn cases(usual: u32) -> u32 {
    std::env::var("ARCSMITH_EXPRESSIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// Random expressions, many compiled at once: the bits of C and Rust are those of the interpreter.
#[test]
fn compiled_expressions_give_the_interpreters_bits() {
    let mut runner = TestRunner::deterministic();
    let texts: Vec<String> =
        (0..cases(200)).map(|_| expressions().new_tree(&mut runner).unwrap().current()).collect();
    texts.par_chunks(TOGETHER).for_each(compiled);
}

/// Compiles expressions into one program of C and one of Rust, and holds both against the interpreter.
fn compiled(texts: &[String]) {
    let (_, words) = walk();
    let words = &words[..CALLS];
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &str, text: &str| {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let (mut expected, mut rust, mut c) = (Vec::new(), Main::default(), Main::default());
    for (index, text) in texts.iter().enumerate() {
        let (name, text) = (format!("expression{index}"), format!("k * {text}"));
        // The terms are tried, so the function is one that is designed in no time.
        let mut coefficients = paper();
        coefficients.base.coefficients.truncate(2);
        coefficients.base.order = 1;
        coefficients.terms = vec![term("random", expressed(&text), vec![1.0])];
        let options = Options { name: Some(name.clone()), degree: Some(3), ..options_for(&text) };
        let generated = generate(&coefficients, "0", &options).unwrap_or_else(|e| panic!("{text}: {e}"));
        for (path, text) in &generated.files {
            write(&path.display().to_string(), text);
        }
        let routine = &generated.routines[0];
        let (further, state) = (!options.further.is_empty(), !routine.design.program.state.is_empty());
        expected.extend(if further { interpreted(routine, words) } else { alone(routine, words) });
        rust.add_rust(&name, further, state);
        c.add_c(&name, further, state);
    }
    let data: Vec<String> = words.iter().map(|(s, t)| format!("{{ {s}, {t} }}")).collect();
    write("run.c", &c.finished_c(&data.join(", ")));
    let data: Vec<String> = words.iter().map(|(s, t)| format!("({s}, {t})")).collect();
    write("run.rs", &rust.finished_rust(&data.join(", ")));
    let sources: Vec<String> = (0..texts.len()).map(|index| format!("c/expression{index}.c")).collect();
    let of_c =
        ["-O1", "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-Ic", "run.c", "-o", "run-c"];
    let of_rust =
        ["--edition=2021", "-Copt-level=1", "-Coverflow-checks=on", "-Dwarnings", "run.rs", "-o", "run-rust"];
    for (compiler, arguments, more, program) in
        [("gcc", &of_c[..], &sources[..], "run-c"), ("rustc", &of_rust[..], &[], "run-rust")]
    {
        let built = Command::new(compiler).args(arguments).args(more).current_dir(&folder).output();
        let Ok(built) = built else {
            println!("skipped: {compiler} is not installed");
            continue;
        };
        assert!(built.status.success(), "{compiler}: {}", String::from_utf8_lossy(&built.stderr));
        let output = Command::new(folder.path().join(program)).output().unwrap();
        assert!(output.status.success(), "{compiler}");
        let text = String::from_utf8(output.stdout).unwrap();
        let found: Vec<i32> = text.lines().map(|line| line.parse().unwrap()).collect();
        assert_eq!(found.len(), expected.len(), "{compiler}");
        for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert_eq!(found, expected, "{compiler}, call {}: {}", index % CALLS, texts[index / CALLS]);
        }
    }
}

/// A program that runs many routines and prints their results.
#[derive(Default)]
struct Main {
    head: String,
    body: String,
}

impl Main {
    fn add_rust(&mut self, name: &str, further: bool, state: bool) {
        let (first, type_name) =
            (if further { "WORDS[0].0, WORDS[0].1" } else { "WORDS[0].0" }, name.replacen('e', "E", 1));
        let (begin, call) = match state {
            true => {
                (format!("let mut state = {name}::{type_name}Q31::new({first});"), "state.update".to_string())
            }
            false => (String::new(), format!("{name}::{name}_q31")),
        };
        let (given, words) = if further { ("s, t", "s, t") } else { ("s, _", "s") };
        self.head += &format!("#[path = \"src/{name}_q31.rs\"]\nmod {name};\n");
        self.body += &format!("    {{ {begin}\n    run(&mut |{given}| {call}({words})); }}\n");
    }

    fn finished_rust(&self, data: &str) -> String {
        let Main { head, body } = self;
        let run = "fn run(call: &mut dyn FnMut(i32, u16) -> i32) {\n    \
                   for &(s, t) in &WORDS { println!(\"{}\", call(s, t)); }\n}\n";
        format!("{head}static WORDS: [(i32, u16); {CALLS}] = [{data}];\n{run}fn main() {{\n{body}}}\n")
    }

    fn add_c(&mut self, name: &str, further: bool, state: bool) {
        let words = |k: &str| match further {
            true => format!("(int32_t)words[{k}][0], (uint16_t)words[{k}][1]"),
            false => format!("(int32_t)words[{k}][0]"),
        };
        let (begin, call) = match state {
            true => (
                format!("{name}_q31_state state; {name}_q31_init(&state, {});", words("0")),
                format!("{name}_q31_update(&state, {})", words("i")),
            ),
            false => (String::new(), format!("{name}_q31({})", words("i"))),
        };
        self.head += &format!("#include \"{name}.h\"\n");
        self.body += &format!(
            "    {{ {begin}\n    for (int i = 0; i < {CALLS}; i++) (void)printf(\"%ld\\n\", (long){call}); }}\n"
        );
    }

    fn finished_c(&self, data: &str) -> String {
        let Main { head, body } = self;
        let words = format!("static const long words[{CALLS}][2] = {{ {data} }};");
        format!(
            "#include <stdint.h>\n#include <stdio.h>\n{head}\n{words}\n\nint main(void)\n{{\n{body}    return 0;\n}}\n"
        )
    }
}
