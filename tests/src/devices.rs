//! Devices, ranges, formats, inputs and outputs at random: what the bound must hold for.

use codegen::format::Format;
use codegen::input::{Arity, Encoding, Input};
use codegen::options::{CShift, Method, Options, OutOfRange, RoutineOptions};
use codegen::output::Output;
use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use proptest::prelude::*;

/// A device with what is wanted of its routine.
#[derive(Debug, Clone)]
pub struct Case {
    /// The device.
    pub coefficients: Coefficients,
    /// One routine, of a fixed degree, with any bound.
    pub options: Options,
    /// Seed of the inputs that are tried.
    pub seed: u64,
}

impl Case {
    /// The routine that is wanted.
    pub fn routine(&self) -> &RoutineOptions {
        &self.options.routines[0]
    }
}

/// How a routine is evaluated: what the tests go through one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One polynomial, in this format.
    Fused(Format),
    /// A table of polynomials of this degree.
    Table(Format, usize),
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 10] = [
        Kind::Fused(Format::Q31),
        Kind::Fused(Format::Q31Split),
        Kind::Fused(Format::Q15),
        Kind::Fused(Format::F32),
        Kind::Table(Format::Q31, 1),
        Kind::Table(Format::Q31, 2),
        Kind::Table(Format::Q31, 3),
        Kind::Table(Format::Q31Split, 1),
        Kind::Table(Format::Q31Split, 2),
        Kind::Table(Format::Q31Split, 3),
    ];

    fn format(self) -> Format {
        match self {
            Kind::Fused(format) | Kind::Table(format, _) => format,
        }
    }

    fn method(self, segments_log2: u32) -> Method {
        match self {
            Kind::Fused(_) => Method::Fused,
            Kind::Table(_, degree) => Method::Piecewise { degree, segments_log2, padded: false, place: None },
        }
    }
}

/// Any device, with a routine of this kind.
pub fn any_case(kind: Kind) -> impl Strategy<Value = Case> {
    let outside = prop::sample::select(vec![OutOfRange::Clamp, OutOfRange::Flag, OutOfRange::Continue]);
    let shift = prop::sample::select(vec![CShift::Strict, CShift::Arithmetic]);
    (any_coefficients(), any::<u64>(), 1..=12usize, 1..=8u32, outside, shift).prop_flat_map(
        move |(coefficients, seed, degree, segments_log2, out_of_range, c_shift)| {
            let method = kind.method(segments_log2);
            any_routine(&coefficients, kind.format(), out_of_range).prop_map(move |routine| Case {
                coefficients: coefficients.clone(),
                options: Options {
                    routines: vec![RoutineOptions { method, ..routine }],
                    // Any bound will do: the question is whether it holds.
                    bound: Some(f64::MAX),
                    degree: (method == Method::Fused).then_some(degree),
                    out_of_range,
                    c_shift,
                    ..Options::default()
                },
                seed,
            })
        },
    )
}

/// Sizes over several decades.
fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

/// A sensor with a range and an error polynomial of any order up to 12, whose error is at most some
/// tenths of the range.
fn any_coefficients() -> impl Strategy<Value = Coefficients> {
    let pair = (decades(2.0, 60.0), decades(0.001, 0.35)).prop_map(|(d, share)| {
        let sensor = Sensor::EddyCurrentPair { probe_distance_mm: d, initial_gap_mm: 0.3 };
        (sensor, d * share, 0.0)
    });
    let units = prop::sample::select(vec!["mm", "um", "deg", "V"]);
    let direct = (units, decades(1e-3, 1e3), -20.0..20.0f64).prop_map(|(unit, half, shift)| {
        let sensor = Sensor::Direct { unit: unit.to_string(), revolution: None };
        (sensor, half, half * shift)
    });
    // How far down and up the range goes, in halves: symmetric, lopsided, or away from zero.
    let ends = prop_oneof![
        2 => Just((-1.0, 1.0)),
        2 => (-1.0..-0.01f64, 0.01..1.0f64),
        1 => (0.05..0.5f64, 0.6..1.0f64),
    ];
    let shape = prop::collection::vec(-1.0..1.0f64, 1..=13);
    (prop_oneof![3 => pair, 1 => direct], ends, shape, decades(1e-5, 0.1)).prop_map(
        |((sensor, half, shift), (low, high), shape, share)| {
            let (from, to) = (shift + low * half, shift + high * half);
            let centre = if shift == 0.0 { 0.0 } else { 0.5 * (from + to) };
            // Each term reaches its share of the range at the ends.
            let term = |(k, c): (usize, &f64)| c * share * half * half.powi(-(k as i32));
            let model =
                ErrorModel { sensor, centre, coefficients: shape.iter().enumerate().map(term).collect() };
            Coefficients::of_model(&model, from, to, "made up for a test")
        },
    )
}

/// An input that reaches the range of the device and, where nothing limits it, that overflows nothing; an output
/// that the format has.
fn any_routine(
    coefficients: &Coefficients,
    format: Format,
    out_of_range: OutOfRange,
) -> impl Strategy<Value = RoutineOptions> + use<> {
    let (from, to) = (coefficients.valid_range.from, coefficients.valid_range.to);
    let largest = from.abs().max(to.abs());
    let pair = matches!(coefficients.sensor, Sensor::EddyCurrentPair { .. });
    let unlimited = out_of_range == OutOfRange::Continue;
    // The difference of two full words, or of wide counts, needs its limits.
    let arity =
        prop::sample::select(if pair { vec![Arity::Reading, Arity::Probes] } else { vec![Arity::Reading] });
    let q31 = prop::option::of(1.0..8.0f64)
        .prop_map(move |wider| Encoding::Q31 { full_scale: wider.map(|factor| factor * largest) });
    // The converter's range is that of the readings, up to four times as wide; for probes about zero.
    let counts = (10..=24u32, 1.01..4.0f64).prop_map(move |(bits, wider)| {
        let full = f64::from((1u32 << bits) - 1);
        let width = if pair { 2.0 * largest } else { to - from };
        let gain = wider * width / full;
        let middle = if pair { 0.0 } else { 0.5 * (from + to) };
        Encoding::Counts { bits, gain, offset: (0.5 * full - middle / gain).round() }
    });
    let encoding = prop_oneof![2 => Just(Encoding::F32), 2 => q31, 2 => counts];
    let outputs = if format.is_fixed() {
        vec![Output::PowerOfTwo, Output::Nano, Output::Micro, Output::F32]
    } else {
        vec![Output::F32]
    };
    let output = prop::sample::select(outputs);
    (arity, encoding, output)
        .prop_filter("needs its limits", move |(arity, encoding, _)| {
            !unlimited
                || match encoding {
                    Encoding::F32 => !format.is_fixed(),
                    Encoding::Q31 { .. } => *arity == Arity::Reading || !format.is_fixed(),
                    Encoding::Counts { bits, .. } => *bits <= 16,
                }
        })
        .prop_map(move |(arity, encoding, output)| {
            let input = Input { arity, encoding };
            RoutineOptions { input, output, ..RoutineOptions::of(format) }
        })
}
