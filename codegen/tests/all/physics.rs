//! Routines with terms of further physics: over random sequences of inputs the interpreter stays within the bound
//! of a reference in `f64` that knows nothing of words, and the compiled C and Rust give the interpreter's bits.

mod compiled;
mod expression;
mod forms;
mod refused;

use codegen::format::Format;
use codegen::interpret::{Word, start, update};
use codegen::options::{Ends, Method, Options};
use codegen::physics::Further;
use codegen::program::Op;
use codegen::routine::{self, Routine};
use codegen::verify::fast_reference::FastReference;
use codegen::verify::sequence::model::Model;
use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::recording::Purpose;
use fitter::terms::{
    Element, Exponential, Gaussian, Hinge, Lag, Observables, Operator, Periodic, Play, Product, Rate, Scope,
    Side, Step, Term,
};
use fitter::units::ARCSEC_PER_RAD;
use proptest::prelude::*;

const HALF_RANGE_MM: f64 = 0.38;
const FULL_SCALE_MM: f64 = 0.76;
const PROBE_DISTANCE_MM: f64 = 12.0;
/// °C of a count, and the count that stands for zero.
const GAIN: f64 = 0.01;
const ZERO: f64 = 400.0;

fn paper() -> Coefficients {
    let model = ErrorModel {
        sensor: Sensor::EddyCurrentPair { probe_distance_mm: PROBE_DISTANCE_MM, initial_gap_mm: 0.3 },
        centre: 0.0,
        coefficients: vec![-6.15e-5, 0.1439, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4],
    };
    Coefficients::of_model(&model, -HALF_RANGE_MM, HALF_RANGE_MM, "by hand")
}

fn term(effect: &str, operator: Operator, coefficients: Vec<f64>) -> Term {
    Term { effect: effect.into(), scope: Scope::Device, operator, coefficients, covariance: Vec::new() }
}

/// What a random device has beyond the paper's.
#[derive(Debug, Clone)]
struct Device {
    mean_c: f64,
    zero_drift: f64,
    gain_drift: f64,
    curved_drift: f64,
    plays: Vec<(f64, f64)>,
}

fn any_device() -> impl Strategy<Value = Device> {
    let plays = prop::collection::vec((1.0..4000.0f64, -0.05..0.05f64), 1..=3);
    (16.0..34.0f64, -2.0..2.0f64, -5e-4..5e-4f64, -0.05..0.05f64, plays).prop_map(
        |(mean_c, zero_drift, gain_drift, curved_drift, plays)| Device {
            mean_c,
            zero_drift,
            gain_drift,
            curved_drift,
            plays,
        },
    )
}

impl Device {
    fn coefficients(&self) -> Coefficients {
        let t = || Product::of("temperature_c", self.mean_c);
        let radii: Vec<f64> = self.plays.iter().map(|(r, _)| *r).collect();
        let weights = self.plays.iter().map(|(_, w)| *w).collect();
        let mut coefficients = paper();
        coefficients.terms = vec![
            term("thermal_zero_drift", Operator::Product(t()), vec![self.zero_drift]),
            term(
                "thermal_gain_drift",
                Operator::Product(t().times("angle_arcsec", 0.0, 1)),
                vec![self.gain_drift],
            ),
            term(
                "curved",
                Operator::Product(t().times("temperature_c", self.mean_c, 1)),
                vec![self.curved_drift],
            ),
            term("hysteresis", Operator::Play(Play::of("angle_arcsec", &radii)), weights),
        ];
        coefficients
    }

    /// The corrected angle in radians over a sequence of s and temperature.
    fn corrected_rad(&self, sequence: &[(f64, f64)]) -> Vec<f64> {
        let model = paper().error_model();
        let angles: Vec<f64> =
            sequence.iter().map(|(s, _)| (s / PROBE_DISTANCE_MM).atan() * ARCSEC_PER_RAD).collect();
        let plays: Vec<Vec<f64>> = (self.plays.iter())
            .map(|(r, _)| Element { half_width: *r, initial: None }.column(&angles))
            .collect();
        let at = |row: usize| {
            let (s, t) = sequence[row];
            let t = t - self.mean_c;
            let drift = self.zero_drift * t + self.gain_drift * t * angles[row] + self.curved_drift * t * t;
            let play: f64 = self.plays.iter().zip(&plays).map(|((_, w), column)| w * column[row]).sum();
            model.corrected(s) - (drift + play) / ARCSEC_PER_RAD
        };
        (0..sequence.len()).map(at).collect()
    }
}

fn options() -> Options {
    let further = Further::parse(&format!("temperature_c=15..35:counts:12:{GAIN}:{ZERO}")).unwrap();
    let ends = Ends { full_scale: Some(FULL_SCALE_MM), ..Ends::default() };
    Options {
        routines: vec![ends.routine(Method::Fused, Format::Q31)],
        further: vec![further],
        ..Options::default()
    }
}

/// Words of s and counts of the temperature: steps, reversals, ends.
fn any_sequence() -> impl Strategy<Value = Vec<(i32, u16)>> {
    let s = prop_oneof![
        -0x4000_0000..0x4000_0000i32,
        Just(-0x4000_0000),
        Just(0x3fff_ffff),
        -100_000..100_000i32
    ];
    prop::collection::vec((s, 1900..3900u16), 1..40)
}

fn readings(words: &[(i32, u16)]) -> Vec<(f64, f64)> {
    let s = |word: i32| f64::from(word) * FULL_SCALE_MM / 2f64.powi(31);
    words.iter().map(|(w, count)| (s(*w), (f64::from(*count) - ZERO) * GAIN)).collect()
}

fn interpreted(routine: &Routine, words: &[(i32, u16)]) -> Vec<i32> {
    let program = &routine.design.program;
    let arguments = |(w, count): (i32, u16)| [Word::Int(w.into()), Word::Int(count.into())];
    let mut state = start(program, &arguments(words[0])).unwrap();
    let mut next =
        |pair: &(i32, u16)| update(program, &mut state, &arguments(*pair)).unwrap().word.bits() as i32;
    words.iter().map(&mut next).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn the_bound_holds_over_any_sequence(device in any_device(), sequences in prop::collection::vec(any_sequence(), 8)) {
        let options = options();
        let routine = routine::design(&device.coefficients(), &options, &options.routines[0]).unwrap();
        let (unit, bound) = (routine.design.unit.to_f64(), routine.design.bound.total);
        prop_assert!(bound * ARCSEC_PER_RAD <= 0.01);
        for words in sequences {
            let expected = device.corrected_rad(&readings(&words));
            for (word, expected) in interpreted(&routine, &words).into_iter().zip(expected) {
                let error = (f64::from(word) * unit - expected).abs();
                prop_assert!(error <= bound * (1.0 + 1e-9), "{error:e} exceeds {bound:e}");
            }
        }
    }

}

proptest! {
    // Its table is proved anew for every device, which takes seconds.
    #![proptest_config(ProptestConfig::with_cases(6))]
    /// The implicit equation is solved within the bound, on a sensor of which the reading is the position.
    #[test]
    fn periodic_errors_are_solved_within_the_bound(
        period in 0.2..3.0f64,
        share in prop::collection::vec(-1.0..1.0f64, 6),
        steep in 0.01..0.8f64,
        at in prop::collection::vec(0.0..1.0f64, 50),
    ) {
        let mut periodic = Periodic::of(period, 3);
        periodic.harmonics = vec![1, 2, 5];
        let scale = steep / periodic.steepest(&share);
        let weights: Vec<f64> = share.iter().map(|c| c * scale).collect();
        let model = ErrorModel {
            sensor: Sensor::Direct { unit: "mm".into(), revolution: None },
            centre: 1.0,
            coefficients: vec![0.2, 1e-3, -2e-4],
        };
        let mut coefficients = Coefficients::of_model(&model, -2.0, 5.0, "by hand");
        coefficients.terms =
            vec![term("periodic_error", Operator::Periodic(periodic.clone()), weights.clone())];
        let options = Options { bound: Some(1e-4), ..Options::default() };
        let wanted = Ends::default().routine(Method::Fused, Format::Q31);
        let routine = routine::design(&coefficients, &options, &wanted).unwrap();
        let Op::Clamp { lo, hi, .. } = routine.design.program.steps[routine.design.program.clamped].op else {
            panic!("the range is limited")
        };
        for at in at {
            let word = lo + ((hi - lo) as f64 * at) as i64;
            let observed = model.corrected(word as f64 * 8.0 / 2f64.powi(31));
            let mut truth = observed;
            for _ in 0..100 {
                let (value, slope) = periodic.value_and_slope(&weights, truth);
                truth -= (truth + value - observed) / (1.0 + slope);
            }
            let out = codegen::interpret::interpret(&routine.design.program, &[Word::Int(word)]).unwrap();
            let error = (out.word.bits() as f64 * routine.design.unit.to_f64() - truth).abs();
            let bound = routine.design.bound.total;
            prop_assert!(error <= bound * (1.0 + 1e-9), "{error:e} exceeds {bound:e} at {word}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// A lag, the rate of a moving reading and a slope beyond a threshold, however slow the lag.
    #[test]
    fn lags_rates_and_hinges_hold_the_bound(
        time_constant_s in 0.05..5000.0f64,
        period_s in 0.001..1.0f64,
        weights in (-3.0..3.0f64, -1e-4..1e-4f64, -0.01..0.01f64),
        threshold in -6000.0..6000.0f64,
        above in any::<bool>(),
        sequences in prop::collection::vec(any_sequence(), 8),
    ) {
        let lag = Lag::of("temperature_c", time_constant_s, 22.5);
        let side = if above { Side::Above } else { Side::Below };
        let mut coefficients = paper();
        coefficients.terms = vec![
            term("thermal_lag", Operator::Lag(lag.clone()), vec![weights.0]),
            term("read_lag", Operator::Rate(Rate::of("angle_arcsec")), vec![weights.1]),
            term(
                "sensor_clipping",
                Operator::Hinge(Hinge::of("angle_arcsec", threshold, side)),
                vec![weights.2],
            ),
        ];
        let options = Options { period_s: Some(period_s), bound: Some(1e3), degree: Some(9), ..options() };
        let routine = routine::design(&coefficients, &options, &options.routines[0]).unwrap();
        let (unit, bound) = (routine.design.unit.to_f64(), routine.design.bound.total);
        let model = coefficients.error_model();
        for words in sequences {
            let sequence = readings(&words);
            let time_s: Vec<f64> = (0..sequence.len()).map(|i| period_s * i as f64).collect();
            let temperatures: Vec<f64> = sequence.iter().map(|(_, t)| *t).collect();
            let lagged = lag.lagged(&time_s, &temperatures);
            let angle = |row: usize| (sequence[row].0 / PROBE_DISTANCE_MM).atan() * ARCSEC_PER_RAD;
            for (row, word) in interpreted(&routine, &words).into_iter().enumerate() {
                let rate = if row == 0 { 0.0 } else { (angle(row) - angle(row - 1)) / period_s };
                let beyond = if above { angle(row) - threshold } else { threshold - angle(row) }.max(0.0);
                let terms = weights.0 * (lagged[row] - 22.5) + weights.1 * rate + weights.2 * beyond;
                let expected = model.corrected(sequence[row].0) - terms / ARCSEC_PER_RAD;
                let error = (f64::from(word) * unit - expected).abs();
                // The reference's own rounding: a rate is a difference of like numbers, over a short time.
                let own = 1e-15 * (1.0 + weights.1.abs() / period_s);
                prop_assert!(error <= bound * (1.0 + 1e-9) + own, "row {row}: {error:e} exceeds {bound:e}");
            }
        }
    }
}

fn exponential(observable: &str, start: f64, scale: f64) -> Exponential {
    Exponential { observable: observable.into(), start, scale }
}

/// Terms of every kind, of the reading and of the further input, each with parameters of its own.
fn any_terms() -> impl Strategy<Value = Vec<Term>> {
    let angle = -6500.0..6500.0f64;
    let warm = 14.0..36.0f64;
    let weight = -5.0..5.0f64;
    let of = |kind: &'static str, operator: BoxedStrategy<Operator>, weight: BoxedStrategy<f64>| {
        (operator, weight).prop_map(move |(operator, w)| term(kind, operator, vec![w])).boxed()
    };
    let t = "temperature_c";
    let gaussian = |observable: &'static str, centre: std::ops::Range<f64>, width: std::ops::Range<f64>| {
        let bump = move |(c, w)| Operator::Gaussian(Gaussian::of(observable, c, w));
        (centre, width).prop_map(bump).boxed()
    };
    let rises = |observable: &'static str, start: std::ops::Range<f64>, scale: std::ops::Range<f64>| {
        let saturates = move |(at, tau)| Operator::Exponential(exponential(observable, at, tau));
        (start, scale).prop_map(saturates).boxed()
    };
    let step = warm.clone().prop_map(move |at| Operator::Step(Step { observable: t.into(), at }));
    let hinge = warm.clone().prop_map(move |at| Operator::Hinge(Hinge::of(t, at, Side::Below)));
    let play = (0.05..8.0f64).prop_map(move |r| Operator::Play(Play::of(t, &[r])));
    let lag = (0.5..400.0f64).prop_map(|tau| Operator::Lag(Lag::of("angle_arcsec", tau, 0.0)));
    let rate = Just(Operator::Rate(Rate::of(t)));
    let product = Just(Operator::Product(Product::of(t, 22.0).times(t, 22.0, 1)));
    (
        of("local_defect", gaussian("angle_arcsec", angle, 20.0..3000.0), weight.clone().boxed()),
        of("warm_bump", gaussian(t, warm.clone(), 0.3..9.0), weight.clone().boxed()),
        of("knee", rises(t, warm, 0.2..30.0), weight.clone().boxed()),
        of("warmup_drift", rises("t_s", -30.0..0.0, 0.3..9000.0), weight.clone().boxed()),
        of("click", step.boxed(), weight.clone().boxed()),
        of("bend", hinge.boxed(), weight.clone().boxed()),
        of("thermal_play", play.boxed(), weight.boxed()),
        of("angle_lag", lag.boxed(), (-0.01..0.01f64).boxed()),
        of("heating", rate.boxed(), (-0.05..0.05f64).boxed()),
        of("curved", product.boxed(), (-0.05..0.05f64).boxed()),
    )
        .prop_map(|(a, b, c, d, e, f, g, h, i, j)| vec![a, b, c, d, e, f, g, h, i, j])
        .prop_flat_map(|all| prop::sample::subsequence(all, 1..=4))
}

/// A sequence as a recording, so that `fitter` evaluates the terms over it.
fn recorded(sequence: &[(f64, f64)], period_s: f64) -> fitter::Recording {
    let mut text = "t_s,pass,direction,x1_mm,x2_mm,reference_arcsec,temperature_c\n".to_string();
    for (row, (s, t)) in sequence.iter().enumerate() {
        text += &format!("{:?},1,1,0,{s:?},0,{t:?}\n", period_s * row as f64);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sequence.csv");
    std::fs::write(&path, text).unwrap();
    fitter::Recording::read_for(&path, Purpose::Apply, &mut |_| {}).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Every kind of term, as `fitter` evaluates it; and the model that `arcsmith verify` sweeps against agrees.
    #[test]
    fn every_kind_of_term_holds_the_bound(
        terms in any_terms(),
        period_s in 0.01..2.0f64,
        sequences in prop::collection::vec(any_sequence(), 4),
    ) {
        let mut coefficients = paper();
        coefficients.terms = terms.clone();
        let reads = |name: &str| terms.iter().any(|t| t.operator.observables().contains(&name));
        let mut options = Options { period_s: Some(period_s), bound: Some(1e3), degree: Some(9), ..options() };
        if !reads("temperature_c") {
            options.further.clear();
        }
        let routine = routine::design(&coefficients, &options, &options.routines[0]).unwrap();
        let (unit, bound) = (routine.design.unit.to_f64(), routine.design.bound.total);
        let fast_reference = FastReference::of(&routine);
        let rated = terms.iter().any(|t| matches!(t.operator, Operator::Rate(_)));
        for words in sequences {
            let sequence = readings(&words);
            let recording = recorded(&sequence, period_s);
            let observables = Observables { recording: &recording, sensor: &coefficients.sensor };
            let added = fitter::terms::evaluate(&terms, &observables, true).inside;
            let mut model = Model::new(&routine, &fast_reference);
            let found = if reads("temperature_c") {
                interpreted(&routine, &words)
            } else {
                alone(&routine, &words)
            };
            for (row, word) in found.into_iter().enumerate() {
                let further: &[f64] = if reads("temperature_c") { &[f64::from(words[row].1)] } else { &[] };
                let modelled = model.call(row == 0, f64::from(words[row].0), further);
                // The first row of a recording has the rate to the row after it, the first call none.
                if row == 0 && rated {
                    continue;
                }
                let expected = paper().error_model().corrected(sequence[row].0) - added[row] / ARCSEC_PER_RAD;
                let error = (f64::from(word) * unit - expected).abs();
                // The reference's own rounding, that of a difference over a short time.
                let own = 1e-15 * (1.0 + 1.0 / period_s);
                prop_assert!(error <= bound * (1.0 + 1e-9) + own, "row {row}: {error:e} exceeds {bound:e}");
                let apart = (modelled.words * unit - expected).abs();
                prop_assert!(apart <= modelled.error * unit + own, "row {row}: the model is {apart:e} off");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// The range that every word of the state is proved to keep, 64 bits or 32, is kept: from any state in it, its corners
    /// before all, whatever comes. The beginning reads only what its signature names.
    #[test]
    fn a_state_in_its_range_stays_there(
        terms in any_terms(),
        period_s in 0.01..2.0f64,
        places in prop::collection::vec(prop::collection::vec(prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64], 12), 40),
        words in prop::collection::vec((prop_oneof![Just(i32::MIN), Just(i32::MAX), any::<i32>()], prop_oneof![Just(0u16), Just(u16::MAX), any::<u16>()]), 40),
    ) {
        let mut coefficients = paper();
        coefficients.terms = terms.clone();
        let further = terms.iter().any(|t| t.operator.observables().contains(&"temperature_c"));
        let mut options = Options { period_s: Some(period_s), bound: Some(1e3), degree: Some(9), ..options() };
        if !further {
            options.further.clear();
        }
        let routine = routine::design(&coefficients, &options, &options.routines[0]).unwrap();
        let program = &routine.design.program;
        let arguments = |(s, t): (i32, u16)| {
            let mut all = vec![Word::Int(s.into())];
            all.extend(further.then_some(Word::Int(t.into())));
            all
        };
        let inside = |state: &[i64]| {
            program.state.iter().zip(state).all(|(w, v)| (w.range.0..=w.range.1).contains(v))
        };
        for (place, word) in places.iter().zip(&words) {
            let mut state: Vec<i64> = (program.state.iter().zip(place))
                .map(|(w, at)| {
                    let (from, to) = (i128::from(w.range.0), i128::from(w.range.1));
                    (from + ((to - from) as f64 * at) as i128).clamp(from, to) as i64
                })
                .collect();
            for _ in 0..3 {
                update(program, &mut state, &arguments(*word)).unwrap();
                prop_assert!(inside(&state), "{word:?} leads to {state:?}");
            }
            prop_assert!(inside(&start(program, &arguments(*word)).unwrap()));
            let reads_further = program.start_steps().iter().any(|i| {
                matches!(program.steps[*i].op, Op::Input { index: 1 })
            });
            if further && !reads_further {
                let other = start(program, &arguments((word.0, !word.1))).unwrap();
                prop_assert_eq!(start(program, &arguments(*word)).unwrap(), other);
            }
        }
    }
}

/// Whatever part of the reading's word the range fills: the whole of it, a little less, a tenth.
#[test]
fn the_bound_holds_at_any_full_scale() {
    let (device, walked) = walk();
    for full_scale in [0.38, 0.4, 0.5, 0.7, 1.0, 4.0] {
        let ends = Ends { full_scale: Some(full_scale), ..Ends::default() };
        let options = Options { routines: vec![ends.routine(Method::Fused, Format::Q31)], ..options() };
        let routine = routine::design(&device.coefficients(), &options, &options.routines[0])
            .unwrap_or_else(|e| panic!("{full_scale}: {e}"));
        let (unit, bound) = (routine.design.unit.to_f64(), routine.design.bound.total);
        assert!(bound * ARCSEC_PER_RAD <= 0.01, "{full_scale}: {bound:e}");
        let (from, to) = routine.design.program.valid;
        let words: Vec<(i32, u16)> = (walked.iter().take(4000))
            .map(|(word, count)| {
                let word = (f64::from(*word) * FULL_SCALE_MM / full_scale).clamp(from, to);
                (word as i32, (*count).clamp(1900, 3899))
            })
            .collect();
        let mm = |word: i32| f64::from(word) * full_scale / 2f64.powi(31);
        let sequence: Vec<(f64, f64)> =
            words.iter().map(|(word, count)| (mm(*word), (f64::from(*count) - ZERO) * GAIN)).collect();
        let expected = device.corrected_rad(&sequence);
        for (word, expected) in interpreted(&routine, &words).into_iter().zip(expected) {
            let error = (f64::from(word) * unit - expected).abs();
            assert!(error <= bound * (1.0 + 1e-9), "{full_scale}: {error:e} exceeds {bound:e}");
        }
    }
}

/// The results of a routine that has no further input.
fn alone(routine: &Routine, words: &[(i32, u16)]) -> Vec<i32> {
    let program = &routine.design.program;
    let mut state = start(program, &[Word::Int(words[0].0.into())]).unwrap();
    let mut next =
        |w: &(i32, u16)| update(program, &mut state, &[Word::Int(w.0.into())]).unwrap().word.bits() as i32;
    words.iter().map(&mut next).collect()
}

/// A device, and 20 000 steps of a random walk.
fn walk() -> (Device, Vec<(i32, u16)>) {
    let device = Device {
        mean_c: 22.37,
        zero_drift: 0.35,
        gain_drift: 2.1e-5,
        curved_drift: -0.004,
        plays: vec![(300.0, 0.004), (900.0, 0.003), (2100.0, -0.002)],
    };
    let (mut seed, mut word, mut count) = (1u64, 0i64, 2600i64);
    let mut random = |width: i64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as i64 % (2 * width + 1) - width
    };
    let step = |_| {
        // Now and then beyond the range and the box.
        word = (word + random(90_000_000)).clamp(-0x5000_0000, 0x5000_0000);
        count = (count + random(20)).clamp(1700, 4095);
        (word as i32, count as u16)
    };
    (device, (0..20_000).map(step).collect())
}

/// A drift of three times the angle: the sum that the function leaves has no room for it, until it is coarser.
#[test]
fn a_term_that_overflows_is_given_more_headroom() {
    let (device, words) = walk();
    let (device, words) = (Device { zero_drift: 2000.0, ..device }, &words[..2000]);
    let small = Device { zero_drift: 0.35, ..device.clone() };
    let options = Options { bound: Some(1.0), degree: Some(9), ..options() };
    let [routine, usual] = [&device, &small].map(|device| {
        routine::design(&device.coefficients(), &options, &options.routines[0]).expect("a routine")
    });
    assert!(routine.design.sum_bits < usual.design.sum_bits, "there is room at once: nothing is tested");
    let (unit, bound) = (routine.design.unit.to_f64(), routine.design.bound.total);
    let (from, to) = routine.design.program.valid;
    let inside: Vec<(i32, u16)> =
        words.iter().map(|(s, t)| (f64::from(*s).clamp(from, to) as i32, (*t).clamp(1900, 3900))).collect();
    let expected = device.corrected_rad(&readings(&inside));
    for (word, expected) in interpreted(&routine, &inside).into_iter().zip(expected) {
        let error = (f64::from(word) * unit - expected).abs();
        assert!(error <= bound * (1.0 + 1e-9), "{error:e} exceeds {bound:e}");
    }
}

/// The counted figures of the routine with temperature and three plays, as committed: in C on a Cortex-M4F.
#[test]
fn temperature_and_three_plays_stay_within_their_budget() {
    let text = std::fs::read_to_string("../tests/firmware/instructions.json").unwrap();
    let counted: serde_json::Value = serde_json::from_str(&text).unwrap();
    let variants = counted["routines"]["q31-temperature-three-plays"]["m4f"].as_object().unwrap();
    assert_eq!(variants.len(), 6);
    for (name, figures) in variants {
        let most = figures["anywhere"][1].as_u64().unwrap();
        assert!(most <= 90 && figures["ram_bytes"].as_u64().unwrap() <= 32, "{name}: {figures}");
    }
}
