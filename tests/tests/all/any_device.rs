//! The bound must hold for any device, range, format, input and output, not for the default one: whatever is
//! generated is interpreted on many inputs, and a few of them are compiled and must agree to the bit.

use std::cell::RefCell;

use approx::abs_diff_eq;
use arcsmith_tests::devices::{Case, Kind, any_case};
use arcsmith_tests::inputs::{Meaning, Words, for_interpreter};
use arcsmith_tests::judge;
use arcsmith_tests::native::{Given, Native};
use arcsmith_tests::toolchain::{C_COMPILERS, available};
use codegen::certificate::Entry;
use codegen::describe::described;
use codegen::design::DesignError;
use codegen::format::Format;
use codegen::generate::{GenerateError, generate};
use codegen::input::{Arity, Encoding, Input, InputError};
use codegen::interpret::interpret;
use codegen::options::{Method, Options, OutOfRange, RoutineOptions};
use codegen::output::Output;
use codegen::quantity::Quantity;
use codegen::routine::{self, Routine, RoutineError};
use fitter::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use proptest::prelude::*;
use proptest::test_runner::{TestCaseError, TestRunner};

/// Devices of each kind of routine whose bound is tried, and inputs of each.
const DEVICES: u32 = 4;
const INPUTS: usize = 4_000;
/// Devices of each kind that are compiled as well, in Rust and in C.
const COMPILED: u32 = 1;

fn config(cases: u32) -> ProptestConfig {
    // A case takes up to a second: what fails is made simpler for half a minute at most.
    ProptestConfig { cases, failure_persistence: None, max_shrink_iters: 60, ..ProptestConfig::default() }
}

/// A routine and what its certificate will say.
struct Designed {
    routine: Routine,
    entry: Entry,
}

impl Designed {
    fn new(case: &Case, routine: Routine) -> Designed {
        let quantity = Quantity::of(&case.coefficients.error_model());
        let entry = described(&routine, "routine", &quantity, &case.options, &case.coefficients).entry;
        Designed { routine, entry }
    }
}

/// What is refused for a reason that the user is told, and no case: decimal outputs that do not suit a range,
/// and inputs that need their limits.
fn refused(case: &Case, error: RoutineError) -> TestCaseError {
    match error {
        RoutineError::Design(DesignError::Decimal { .. })
            if matches!(case.routine().output, Output::Nano | Output::Micro) =>
        {
            TestCaseError::reject("decimal output")
        }
        RoutineError::Input(InputError::Unlimited) if case.options.out_of_range == OutOfRange::Continue => {
            TestCaseError::reject("needs its limits")
        }
        other => TestCaseError::fail(format!("{case:?}: {other}")),
    }
}

fn designed(case: &Case) -> Result<Designed, TestCaseError> {
    let routine = routine::design(&case.coefficients, &case.options, case.routine());
    routine.map(|routine| Designed::new(case, routine)).map_err(|error| refused(case, error))
}

/// Interprets every input.
fn interpreted(designed: &Designed, inputs: &[Words]) -> Result<Vec<Given>, TestCaseError> {
    let program = &designed.routine.design.program;
    let one = |words: &Words| {
        let outcome = interpret(program, &for_interpreter(program, *words))
            .map_err(|overflow| TestCaseError::fail(format!("{words:x?}: {overflow}")))?;
        Ok(Given { bits: judge::bits(outcome.word), inside: outcome.in_range })
    };
    inputs.iter().map(one).collect()
}

/// Holds every result in the range against the reference and the bound, and the flag against the range.
fn check(case: &Case, designed: &Designed, inputs: &[Words], given: &[Given]) -> Result<f64, TestCaseError> {
    let model = case.coefficients.error_model();
    let Designed { entry, routine: Routine { range, .. } } = designed;
    let (range, routine) = (*range, case.routine());
    let meaning = Meaning::new(routine.input, range);
    // The difference of two floats is rounded: near an end the flag may go either way.
    let rounded = routine.input.arity == Arity::Probes && routine.input.encoding == Encoding::F32;
    let mut largest = 0.0f64;
    for (words, given) in inputs.iter().zip(given) {
        let reading = meaning.reading(*words);
        let in_range = meaning.in_range(*words);
        let at_the_end = (reading - range.0).abs().min((reading - range.1).abs())
            <= 4.0 * f64::EPSILON * range.0.abs().max(range.1.abs())
                + if rounded { f64::from(f32::EPSILON) * reading.abs() } else { 0.0 };
        prop_assert!(
            given.inside == in_range || at_the_end || case.options.out_of_range == OutOfRange::Continue,
            "{:x?}: reading {} in {:?}, the routine says {}",
            words,
            reading,
            range,
            given.inside
        );
        if in_range {
            let (value, reference) =
                (judge::value(entry, &model, given.bits), judge::reference(&model, reading));
            let allowed = entry.bound + judge::slack(&model, reading);
            largest = largest.max((value - reference).abs() / entry.bound);
            prop_assert!(
                abs_diff_eq!(value, reference, epsilon = allowed),
                "{:x?}: reading {}, {} instead of {} {}: off by {:e}, bound {:e}",
                words,
                reading,
                value,
                reference,
                entry.unit,
                (value - reference).abs(),
                entry.bound
            );
        }
    }
    Ok(largest)
}

#[test]
fn the_bound_holds_for_some_devices() {
    the_bound_holds(DEVICES);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn the_bound_holds_for_many_devices() {
    the_bound_holds(4 * DEVICES);
}

fn the_bound_holds(devices: u32) {
    for kind in Kind::ALL {
        let shares = RefCell::new(Vec::new());
        let result = TestRunner::new(config(devices)).run(&any_case(kind), |case| {
            let designed = designed(&case)?;
            let inputs =
                Meaning::new(case.routine().input, designed.routine.range).samples(case.seed, INPUTS);
            let given = interpreted(&designed, &inputs)?;
            shares.borrow_mut().push(check(&case, &designed, &inputs, &given)?);
            Ok(())
        });
        if let Err(failure) = result {
            panic!("{kind:?}: {failure}");
        }
        let mut shares = shares.into_inner();
        shares.sort_by(f64::total_cmp);
        println!(
            "{kind:?}: largest error over bound, {} devices: median {:.2}, largest {:.3}",
            shares.len(),
            shares[shares.len() / 2],
            shares[shares.len() - 1]
        );
        // A bound that no device comes near would prove nothing.
        assert!(shares[shares.len() / 2] > 1.0 / 3.0, "{kind:?}: {shares:?}");
    }
}

/// Whether what is compiled gives what the interpreter gives, to the bit, and keeps the bound.
fn compiled_alike(case: &Case, compilers: &[&str]) -> Result<(), TestCaseError> {
    let generated = match generate(&case.coefficients, "", &case.options) {
        Ok(generated) => generated,
        Err(GenerateError::Routine(error)) => return Err(refused(case, error)),
        Err(other) => return Err(TestCaseError::fail(other.to_string())),
    };
    let designed = Designed::new(case, generated.routines[0].clone());
    let inputs = Meaning::new(case.routine().input, designed.routine.range).samples(case.seed, INPUTS);
    let mut expected = interpreted(&designed, &inputs)?;
    if case.options.out_of_range != OutOfRange::Flag {
        expected.iter_mut().for_each(|given| given.inside = true);
    }
    let mut compiled = Vec::new();
    for entry in &generated.certificate.routines {
        if entry.language == "rust" {
            compiled.push(("rustc", Native::rust(&generated.files, entry)));
            continue;
        }
        for compiler in compilers {
            let c = Native::c(&generated.files, entry, case.options.out_of_range, compiler);
            compiled.push((compiler, c));
        }
    }
    for (compiler, native) in compiled {
        let mut given = native.run(&inputs);
        for ((words, expected), given) in inputs.iter().zip(&expected).zip(&given) {
            prop_assert_eq!(expected, given, "{} at {:x?}", compiler, words);
        }
        if case.options.out_of_range == OutOfRange::Clamp {
            let meaning = Meaning::new(case.routine().input, designed.routine.range);
            given.iter_mut().zip(&inputs).for_each(|(g, words)| g.inside = meaning.in_range(*words));
        }
        check(case, &designed, &inputs, &given)?;
    }
    Ok(())
}

fn c_compilers() -> Vec<&'static str> {
    C_COMPILERS.into_iter().filter(|c| available(c, "generated C of random devices")).collect()
}

#[test]
fn compiled_rust_and_c_give_what_the_interpreter_gives() {
    let compilers = c_compilers();
    for kind in Kind::ALL {
        let result =
            TestRunner::new(config(COMPILED)).run(&any_case(kind), |case| compiled_alike(&case, &compilers));
        if let Err(failure) = result {
            panic!("{kind:?}: {failure}");
        }
    }
}

/// Which of two segments a reading lies in is its sign, 31 bits to the right.
#[test]
fn a_table_of_two_segments_gives_the_same_compiled() {
    let sensor = Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 };
    let model = ErrorModel { sensor, centre: 0.0, coefficients: vec![0.001, 0.14, -0.04] };
    for format in [Format::Q31, Format::Q31Split] {
        let method = Method::Piecewise { degree: 3, segments_log2: 1, padded: false, place: None };
        let case = Case {
            coefficients: Coefficients::of_model(&model, -0.35, 0.35, "made up for a test"),
            options: Options {
                routines: vec![RoutineOptions { method, ..RoutineOptions::of(format) }],
                bound: Some(f64::MAX),
                ..Options::default()
            },
            seed: 1,
        };
        compiled_alike(&case, &c_compilers()).unwrap();
    }
}

/// The search of coefficients moves the leading one of this device beyond a signed word of 32 bits.
#[test]
fn a_constant_that_its_word_does_not_hold_is_not_generated() {
    let model = ErrorModel {
        sensor: Sensor::EddyCurrentPair { probe_distance_mm: 13.173819430897012, initial_gap_mm: 0.3 },
        centre: 0.0,
        coefficients: vec![
            -7.461917074667018e-5,
            0.0014126092114070548,
            0.0012074114044149846,
            0.0005149721352866209,
            -0.025048193344301656,
            0.0662864562700834,
            1.1298122113759634,
            -5.328375617996496,
            13.95806813025347,
        ],
    };
    let input =
        Input { arity: Arity::Reading, encoding: Encoding::Q31 { full_scale: Some(0.9183624698322636) } };
    let case = Case {
        coefficients: Coefficients::of_model(
            &model,
            -0.2527715184988817,
            0.21034367621523217,
            "made up for a test",
        ),
        options: Options {
            routines: vec![RoutineOptions {
                input,
                output: Output::Nano,
                ..RoutineOptions::of(Format::Q31Split)
            }],
            bound: Some(f64::MAX),
            degree: Some(11),
            out_of_range: OutOfRange::Continue,
            ..Options::default()
        },
        seed: 1,
    };
    compiled_alike(&case, &c_compilers()).unwrap();
}

/// Two probes in floats, the range ending nearly a whole unit in the last place beyond a float: readings
/// between that float and the end are limited to it, twice as far as rounding alone would take them.
#[test]
fn the_bound_holds_between_the_last_float_and_the_end_of_the_range() {
    let last = 0.356f32;
    let to = f64::from(last) + 0.9 * (f64::from(last.next_up()) - f64::from(last));
    let model = ErrorModel {
        sensor: Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 },
        centre: 0.0,
        coefficients: vec![0.0, 0.14, -0.04, 0.13],
    };
    let input = Input { arity: Arity::Probes, encoding: Encoding::F32 };
    let case = Case {
        coefficients: Coefficients::of_model(&model, -to, to, "made up for a test"),
        options: Options {
            routines: vec![RoutineOptions { input, ..RoutineOptions::of(Format::Q31) }],
            bound: Some(f64::MAX),
            degree: Some(9),
            ..Options::default()
        },
        seed: 0,
    };
    let designed = designed(&case).unwrap();
    // x₁ in steps that the difference does not hold, x₂ so that it lies in the last gap.
    let inputs: Vec<Words> = (1..2000u16)
        .map(|i| {
            let x1 = -0.1 - f32::from(i) * 3e-6;
            let mut x2 = (f64::from(x1) + to) as f32;
            while f64::from(x2) - f64::from(x1) > to {
                x2 = x2.next_down();
            }
            [x1.to_bits(), x2.to_bits()]
        })
        .collect();
    let meaning = Meaning::new(input, (-to, to));
    let beyond = |words: &&Words| meaning.reading(**words) > f64::from(last) && meaning.in_range(**words);
    assert!(inputs.iter().filter(beyond).count() > 100, "hardly any reading lies in the gap");
    let given = interpreted(&designed, &inputs).unwrap();
    check(&case, &designed, &inputs, &given).unwrap();
}
