//! The committed routines, compiled: Rust against C bit for bit, the interpreter against both, and all of
//! them against the `f64` model, over the whole input range and outside it.

use std::sync::OnceLock;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use arcsmith_tests::committed::{c_f32, c_q31};
use arcsmith_tests::{inputs, judge};
use codegen::certificate::Entry;
use codegen::generate::{Generated, generate};
use codegen::interpret::{Outcome, interpret};
use codegen::options::Options;
use codegen::routine::Routine;
use codegen::source::Source;
use corrected_angle::{corrected_angle_f32, corrected_angle_q31};
use fitter::ErrorModel;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What was generated from the embedded recording, and its model.
struct Default {
    generated: Generated,
    model: ErrorModel,
}

impl Default {
    fn get() -> &'static Default {
        static DEFAULT: OnceLock<Default> = OnceLock::new();
        DEFAULT.get_or_init(|| {
            let (coefficients, sha256) = Source::Embedded.load().unwrap();
            let generated = generate(&coefficients, &sha256, &Options::default()).unwrap();
            Default { generated, model: coefficients.error_model() }
        })
    }

    fn entry(&self, format: &str) -> &Entry {
        self.generated.certificate.routines.iter().find(|entry| entry.format == format).unwrap()
    }

    fn routine(&self, format: &str) -> &Routine {
        self.generated.routines.iter().find(|routine| routine.options.format.name() == format).unwrap()
    }

    fn interpret(&self, format: &str, bits: u32) -> Outcome {
        let program = &self.routine(format).design.program;
        interpret(program, &inputs::for_interpreter(program, [bits, 0])).unwrap()
    }

    /// Result and reference in arcsec, and how far apart they may be.
    fn compare(&self, format: &str, bits: u32, reading: f64) -> (f64, f64, f64) {
        let entry = self.entry(format);
        let (from, to) = (entry.range.from, entry.range.to);
        let inside = reading.clamp(from, to);
        // Outside, the input is limited to the last word inside, up to one step away from the range's end.
        let limited = if reading == inside { 0.0 } else { entry.input_resolution.max(F32_STEP_ARCSEC) };
        let allowed = entry.bound + judge::slack(&self.model, inside) + limited;
        (judge::value(entry, &self.model, bits), judge::reference(&self.model, inside), allowed)
    }
}

/// One step of an `f32` near 0.36 mm, 2⁻²⁵ mm, at 86 rad/m less than 20 000 arcsec/mm.
const F32_STEP_ARCSEC: f64 = 20_000.0 / 33_554_432.0;

/// 2³¹ of the default's word stand for 0.5 mm: the smallest power of two above the range.
fn s_mm(s_q31: i32) -> f64 {
    f64::from(s_q31) * 0.5 / 2f64.powi(31)
}

/// Floats over the range, beyond it, and every other kind.
fn any_s_mm() -> impl Strategy<Value = f32> {
    prop_oneof![4 => -0.36f32..0.36, 1 => -0.01f32..0.01, 1 => -2.0f32..2.0, 1 => any::<f32>()]
}

fn config() -> ProptestConfig {
    ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn q31_is_the_model_within_the_bound_everywhere(s_q31 in any::<i32>()) {
        let default = Default::get();
        let rust = corrected_angle_q31(s_q31);
        prop_assert_eq!(rust, c_q31(s_q31));
        prop_assert_eq!(rust as u32, judge::bits(default.interpret("q31", s_q31 as u32).word));
        let (value, reference, allowed) = default.compare("q31", rust as u32, s_mm(s_q31));
        prop_assert!(abs_diff_eq!(value, reference, epsilon = allowed), "{} {} ± {}", value, reference, allowed);
    }

    #[test]
    fn f32_is_the_model_within_the_bound_everywhere(s_mm in any_s_mm()) {
        let default = Default::get();
        let rust = corrected_angle_f32(s_mm);
        prop_assert_eq!(rust.to_bits(), c_f32(s_mm).to_bits());
        prop_assert_eq!(rust.to_bits(), judge::bits(default.interpret("f32", s_mm.to_bits()).word));
        let (value, reference, allowed) = default.compare("f32", rust.to_bits(), s_mm.into());
        prop_assert!(abs_diff_eq!(value, reference, epsilon = allowed), "{} {} ± {}", value, reference, allowed);
    }
}

/// As the heads say: outside, the result is that at the nearest end of the range.
#[test]
fn outside_the_range_q31_keeps_the_value_at_the_end() {
    let default = Default::get();
    let entry = default.entry("q31");
    // The range in words, outermost inside; told from the certificate, not from the program.
    let words = |mm: f64| mm / 0.5 * 2f64.powi(31);
    let (first, last) = (words(entry.range.from).ceil() as i32, words(entry.range.to).floor() as i32);
    for routine in [corrected_angle_q31, c_q31] {
        let (low, high) = (routine(first), routine(last));
        assert!(low < high && routine(first + 1_000_000) > low && routine(last - 1_000_000) < high);
        for below in [first - 1, first - 1_000_000, i32::MIN + 1, i32::MIN] {
            assert_eq!(routine(below), low, "{below}");
        }
        for above in [last + 1, last + 1_000_000, i32::MAX - 1, i32::MAX] {
            assert_eq!(routine(above), high, "{above}");
        }
    }
}

/// As the heads say: outside, the result is that at the nearest end; for NaN, that at the lower end.
#[test]
fn outside_the_range_f32_keeps_the_value_at_the_end() {
    let default = Default::get();
    let entry = default.entry("f32");
    let (from, to) = (entry.range.from, entry.range.to);
    let mut first = from as f32;
    let mut last = to as f32;
    while f64::from(first) < from {
        first = first.next_up();
    }
    while f64::from(last) > to {
        last = last.next_down();
    }
    for routine in [corrected_angle_f32, c_f32] {
        let (low, high) = (routine(first), routine(last));
        assert!(low < high && low.is_finite() && high.is_finite());
        for below in [first.next_down(), -1.0, f32::MIN, f32::NEG_INFINITY, f32::NAN, -f32::NAN] {
            assert_eq!(routine(below).to_bits(), low.to_bits(), "{below}");
        }
        for above in [last.next_up(), 1.0, f32::MAX, f32::INFINITY] {
            assert_eq!(routine(above).to_bits(), high.to_bits(), "{above}");
        }
    }
}

/// Random inputs over the range.
const INPUTS: u64 = 10_000_000;
/// A bound more than so many times the largest error seen is not good enough.
const WIDEST: f64 = 3.0;

/// The largest error among many inputs, in arcsec.
fn largest_error(format: &str, bound: f64, error: impl Fn(&mut ChaCha8Rng) -> f64) {
    let mut random = ChaCha8Rng::seed_from_u64(2019);
    let largest = (0..INPUTS).map(|_| error(&mut random)).fold(0.0, f64::max);
    println!(
        "{format}: largest error of {INPUTS} random inputs {largest:.3e} arcsec, bound {bound:.3e} arcsec"
    );
    assert!(largest <= bound, "{format}: {largest:e} exceeds the bound {bound:e}");
    assert!(largest >= bound / WIDEST, "{format}: {largest:e} is far below the bound {bound:e}");
    assert!(bound <= 0.01);
}

#[test]
fn the_bound_of_q31_is_reached_but_not_exceeded() {
    let default = Default::get();
    let entry = default.entry("q31");
    let words = |mm: f64| (mm / 0.5 * 2f64.powi(31)) as i32;
    let (first, last) = (words(entry.range.from), words(entry.range.to));
    largest_error("q31", entry.bound, |random| {
        let s_q31 = random.random_range(first..=last);
        let value = judge::value(entry, &default.model, corrected_angle_q31(s_q31) as u32);
        (value - judge::reference(&default.model, s_mm(s_q31))).abs()
    });
}

#[test]
fn the_bound_of_f32_is_reached_but_not_exceeded() {
    let default = Default::get();
    let entry = default.entry("f32");
    let (first, last) = ((entry.range.from as f32).next_up(), (entry.range.to as f32).next_down());
    largest_error("f32", entry.bound, |random| {
        let s_mm = random.random_range(first..=last);
        let value = judge::value(entry, &default.model, corrected_angle_f32(s_mm).to_bits());
        (value - judge::reference(&default.model, s_mm.into())).abs()
    });
}

/// The certificate that is committed is the one that was held against the routines here.
#[test]
fn the_committed_certificate_states_these_bounds() {
    let text = include_str!("../../../generated/certificate.json");
    let committed: codegen::certificate::Certificate = serde_json::from_str(text).unwrap();
    for (ours, theirs) in Default::get().generated.certificate.routines.iter().zip(&committed.routines) {
        assert_eq!(ours.routine, theirs.routine);
        assert_abs_diff_eq!(ours.bound, theirs.bound, epsilon = 0.0);
        let sum: f64 = theirs.parts.iter().map(|part| part.value).sum();
        assert!(theirs.bound >= sum * (1.0 - 1e-12), "{}: the parts exceed the bound", theirs.routine);
    }
}
