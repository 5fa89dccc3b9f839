//! The bound must hold for any device, range, format, input and output, not for the default one: whatever is
//! generated is interpreted on many inputs, and a few of them are compiled and must agree to the bit.

use std::cell::RefCell;

use approx::abs_diff_eq;
use arcsmith_tests::devices::{Case, any_case};
use arcsmith_tests::inputs::{Meaning, Words, for_interpreter};
use arcsmith_tests::judge;
use arcsmith_tests::native::{Given, Native};
use arcsmith_tests::toolchain::{C_COMPILERS, available};
use codegen::design::DesignError;
use codegen::format::Format;
use codegen::generate::{GenerateError, Generated, generate};
use codegen::input::{Arity, Encoding, Input};
use codegen::interpret::interpret;
use codegen::options::{Options, OutOfRange, RoutineOptions};
use codegen::output::{Output, OutputError};
use codegen::routine::RoutineError;
use fitter::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use proptest::prelude::*;
use proptest::test_runner::{TestCaseError, TestRunner};

/// Devices whose bound is tried, and inputs of each.
const DEVICES: u32 = 150;
const INPUTS: usize = 4_000;
/// Devices that are compiled as well, in Rust and in C.
const COMPILED: u32 = 5;

fn config(cases: u32) -> ProptestConfig {
    // A case takes up to a second: what fails is made simpler for half a minute at most.
    ProptestConfig { cases, failure_persistence: None, max_shrink_iters: 60, ..ProptestConfig::default() }
}

/// Generates; a decimal output that does not suit a direct sensor's range is no case.
fn generated(case: &Case) -> Result<Generated, TestCaseError> {
    generate(&case.coefficients, "", &case.options).map_err(|error| match error {
        GenerateError::Routine(RoutineError::Design(DesignError::Output(OutputError::Decimal {
            ..
        }))) if matches!(case.routine().output, Output::Nano | Output::Micro) => {
            TestCaseError::reject("decimal output")
        }
        other => TestCaseError::fail(other.to_string()),
    })
}

/// Interprets every input.
fn interpreted(generated: &Generated, inputs: &[Words]) -> Result<Vec<Given>, TestCaseError> {
    let program = &generated.routines[0].design.program;
    let one = |words: &Words| {
        let outcome = interpret(program, &for_interpreter(program, *words))
            .map_err(|overflow| TestCaseError::fail(format!("{words:x?}: {overflow}")))?;
        Ok(Given { bits: judge::bits(outcome.word), inside: outcome.in_range })
    };
    inputs.iter().map(one).collect()
}

/// Holds every result in the range against the reference and the bound, and the flag against the range.
fn check(
    case: &Case,
    generated: &Generated,
    inputs: &[Words],
    given: &[Given],
) -> Result<f64, TestCaseError> {
    let model = case.coefficients.error_model();
    let entry = &generated.certificate.routines[0];
    let routine = case.routine();
    let range = generated.routines[0].range;
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
            given.inside == in_range || at_the_end,
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
fn the_bound_holds_for_any_device() {
    let mut runner = TestRunner::new(config(DEVICES));
    let shares = RefCell::new(Vec::new());
    let result = runner.run(&any_case(), |case| {
        let generated = generated(&case)?;
        let inputs =
            Meaning::new(case.routine().input, generated.routines[0].range).samples(case.seed, INPUTS);
        let given = interpreted(&generated, &inputs)?;
        shares.borrow_mut().push(check(&case, &generated, &inputs, &given)?);
        Ok(())
    });
    if let Err(failure) = result {
        panic!("{failure}");
    }
    let mut shares = shares.into_inner();
    shares.sort_by(f64::total_cmp);
    println!(
        "largest error over bound, {} devices: median {:.2}, largest {:.3}",
        shares.len(),
        shares[shares.len() / 2],
        shares[shares.len() - 1]
    );
    // A bound that no device comes near would prove nothing.
    assert!(shares[shares.len() / 2] > 1.0 / 3.0, "{shares:?}");
}

#[test]
fn compiled_rust_and_c_give_what_the_interpreter_gives() {
    let compilers: Vec<&str> =
        C_COMPILERS.into_iter().filter(|c| available(c, "generated C of random devices")).collect();
    let mut runner = TestRunner::new(config(COMPILED));
    let result = runner.run(&any_case(), |case| {
        let generated = generated(&case)?;
        let inputs =
            Meaning::new(case.routine().input, generated.routines[0].range).samples(case.seed, INPUTS);
        let mut expected = interpreted(&generated, &inputs)?;
        if case.options.out_of_range == OutOfRange::Clamp {
            expected.iter_mut().for_each(|given| given.inside = true);
        }
        let entry = &generated.certificate.routines[0];
        let mut compiled = vec![("rustc", Native::rust(&generated.files, entry))];
        for compiler in &compilers {
            let c = Native::c(&generated.files, entry, case.options.out_of_range, compiler);
            compiled.push((compiler, c));
        }
        for (compiler, native) in compiled {
            for ((words, expected), given) in inputs.iter().zip(&expected).zip(native.run(&inputs)) {
                prop_assert_eq!(*expected, given, "{} at {:x?}", compiler, words);
            }
        }
        Ok(())
    });
    if let Err(failure) = result {
        panic!("{failure}");
    }
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
    let generated = generated(&case).unwrap();
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
    let given = interpreted(&generated, &inputs).unwrap();
    check(&case, &generated, &inputs, &given).unwrap();
}
