//! Every variant of the generated C compiles without a warning with gcc and clang; the header also as C++.

use std::path::Path;
use std::process::Command;

use arcsmith_tests::native::unpacked;
use arcsmith_tests::programs::root;
use arcsmith_tests::toolchain::{C_COMPILERS, C_FLAGS, available};
use codegen::format::Format;
use codegen::generate::generate;
use codegen::input::{Arity, Encoding, Input};
use codegen::options::{CShift, Options, OutOfRange, RoutineOptions};
use codegen::output::Output;
use codegen::physics::Further;
use codegen::source::Source;
use fitter::terms::{Operator, Product, Scope, Step, Term};

fn compiles(compiler: &str, flags: &[&str], source: &Path) {
    // A compiler removes what it could not write whole: never onto a device.
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(compiler)
        .args(flags)
        .args(["-O2", "-c", "-o"])
        .args([&folder.path().join("object.o"), source])
        .output()
        .unwrap_or_else(|e| panic!("{compiler}: {e}"));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.is_empty(), "{compiler} {}:\n{text}", source.display());
}

#[test]
fn the_committed_c_compiles_without_a_warning() {
    for compiler in C_COMPILERS {
        if available(compiler, "compiling generated/c") {
            compiles(compiler, &C_FLAGS, &root().join("generated/c/corrected_angle.c"));
        }
    }
}

#[test]
fn every_variant_compiles_without_a_warning() {
    let compilers: Vec<&str> = C_COMPILERS
        .into_iter()
        .filter(|c| available(c, "compiling the variants of the generated C"))
        .collect();
    let (coefficients, sha256) = Source::Embedded.load().unwrap();
    let counts = Encoding::Counts { bits: 16, gain: 1.0 / 65536.0, offset: 32768.0 };
    let wide = Encoding::Counts { bits: 24, gain: 1.0 / 16_777_216.0, offset: 8_388_608.0 };
    let (q31, f32) = (Format::Q31, Format::F32);
    let fixed = |arity, encoding, output| RoutineOptions {
        input: Input { arity, encoding },
        output,
        ..RoutineOptions::of(q31)
    };
    let float =
        |arity, encoding| RoutineOptions { input: Input { arity, encoding }, ..RoutineOptions::of(f32) };
    let words = Encoding::Q31 { full_scale: Some(0.5) };
    let mut variants = Vec::new();
    for arity in [Arity::Reading, Arity::Probes] {
        for encoding in [Encoding::F32, words, counts, wide] {
            for output in [Output::PowerOfTwo, Output::Nano, Output::Micro, Output::F32] {
                variants.push(vec![fixed(arity, encoding, output)]);
            }
            variants.push(vec![fixed(arity, encoding, Output::PowerOfTwo), float(arity, encoding)]);
        }
    }
    for (index, routines) in variants.into_iter().enumerate() {
        // Both ways out of range and both shifts, in turn: they do not depend on input and output.
        let options = Options {
            routines,
            bound: Some(1.0),
            degree: Some(5),
            out_of_range: if index % 2 == 0 { OutOfRange::Clamp } else { OutOfRange::Flag },
            c_shift: if index % 4 < 2 { CShift::Strict } else { CShift::Arithmetic },
            ..Options::default()
        };
        let files =
            generate(&coefficients, &sha256, &options).unwrap_or_else(|e| panic!("{options:?}: {e}")).files;
        let folder = unpacked(&files);
        for compiler in &compilers {
            compiles(compiler, &C_FLAGS, &folder.path().join("c/corrected_angle.c"));
        }
    }
}

#[test]
fn the_header_is_also_cpp() {
    if available("g++", "the generated header as C++") {
        let flags = [
            "-std=c++11",
            "-x",
            "c++",
            "-Wall",
            "-Wextra",
            "-pedantic",
            "-Werror",
            "-Wno-pragma-once-outside-header",
        ];
        compiles("g++", &flags[..6], &root().join("generated/c/corrected_angle.h"));
    }
}

/// A term that is nothing over the range leaves its input unread, and steps that are not written. Beside an input of
/// another type a routine limits words of two types, and a column's name may have capitals.
#[test]
fn an_input_that_is_not_read_leaves_no_warning_in_any_variant() {
    let (mut coefficients, sha256) = Source::Embedded.load().unwrap();
    let term = |operator: Operator| Term {
        effect: "further".into(),
        scope: Scope::Device,
        operator,
        coefficients: vec![0.5],
        covariance: Vec::new(),
    };
    let beyond = Operator::Step(Step { observable: "T_amb".into(), at: 100.0 });
    let read = Operator::Product(Product::of("T_amb", 22.0));
    let words = Encoding::Q31 { full_scale: Some(0.5) };
    let inputs = [(Arity::Reading, words), (Arity::Probes, words), (Arity::Reading, Encoding::F32)];
    let mut compiled = 0;
    for (operator, format) in [(beyond.clone(), Format::Q31), (beyond, Format::Q31Split), (read, Format::Q31)]
    {
        coefficients.terms = vec![term(operator)];
        for (arity, encoding) in inputs {
            let input = Input { arity, encoding };
            for out_of_range in [OutOfRange::Clamp, OutOfRange::Flag, OutOfRange::Continue] {
                for c_shift in [CShift::Strict, CShift::Arithmetic] {
                    let options = Options {
                        routines: vec![RoutineOptions { input, ..RoutineOptions::of(format) }],
                        bound: Some(1.0),
                        further: vec![Further::parse("T_amb=15..35").unwrap()],
                        out_of_range,
                        c_shift,
                        ..Options::default()
                    };
                    let Ok(generated) = generate(&coefficients, &sha256, &options) else {
                        // Not every input goes without limits.
                        assert_eq!(out_of_range, OutOfRange::Continue, "{options:?}");
                        continue;
                    };
                    let folder = unpacked(&generated.files);
                    for compiler in C_COMPILERS {
                        if available(compiler, "compiling a routine with an input that is not read") {
                            compiles(compiler, &C_FLAGS, &folder.path().join("c/corrected_angle.c"));
                        }
                    }
                    rust_compiles(folder.path());
                    compiled += 1;
                }
            }
        }
    }
    assert!(compiled >= 36, "{compiled}");
}

fn rust_compiles(folder: &Path) {
    let flags = ["--edition=2021", "--crate-type=lib", "--emit=metadata", "-Dwarnings", "-o"];
    let output = Command::new("rustc")
        .args(flags)
        .arg(folder.join("lib.rmeta"))
        .arg(folder.join("src/lib.rs"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
