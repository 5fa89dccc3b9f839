//! Every form of a dependence without a name: firmware computes it within its bound, alone and beside periodic errors.

use std::borrow::Cow;

use codegen::generate::generate;
use codegen::input::{Arity, Encoding, Input};
use codegen::output::Output;
use fitter::terms::{Expressed, ExpressionFactor, Fixed};
use physics::{Columns, Declared, DeclaredParameter, Role, Time, Unit, Vocabulary, declared};
use rayon::prelude::*;

use super::*;

/// Seconds between two calls.
const PERIOD_S: f64 = 0.05;
/// The longest delay that is tried: 63.4 calls.
const DELAY_S: f64 = 63.4 * PERIOD_S;
/// Every factor by itself makes so much.
const SIZE_ARCSEC: f64 = 10.0;
/// The bound that is asked for.
const BOUND_ARCSEC: f64 = 0.02;
const CALLS: usize = 400;

/// A further input in counts: column, first and last count of its box, value of a count, the count that stands for zero.
struct Given {
    column: &'static str,
    counts: (u16, u16),
    gain: f64,
    zero: f64,
}

const GIVEN: [Given; 5] = [
    Given { column: "temperature_c", counts: (10_000, 50_000), gain: 5e-4, zero: -20_000.0 },
    Given { column: "coil_a", counts: (12_768, 52_768), gain: 1e-4, zero: 32_768.0 },
    Given { column: "humidity_pct", counts: (10_000, 40_000), gain: 2e-3, zero: 0.0 },
    Given { column: "shaft_deg", counts: (0, 36_000), gain: 0.02, zero: 0.0 },
    Given { column: "direction", counts: (0, 2), gain: 1.0, zero: 1.0 },
];

impl Given {
    fn value(&self, count: u16) -> f64 {
        (f64::from(count) - self.zero) * self.gain
    }

    fn ends(&self) -> (f64, f64) {
        (self.value(self.counts.0), self.value(self.counts.1))
    }
}

/// What a recording of ten minutes would hold: of a column its ends, of a figure its value.
struct Recorded;

impl Columns for Recorded {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        let given = GIVEN.iter().find(|given| given.column == name).map(Given::ends);
        let ends = given.or((name == "angle").then_some((-6500.0, 6500.0)));
        let figure = [("stroke", 13_000.0), ("spacing", 430.0), ("interval", 3.0), ("duration", 600.0)]
            .into_iter()
            .find(|(figure, _)| *figure == name);
        ends.map(|(from, to)| vec![from, to]).or(figure.map(|(_, value)| vec![value])).map(Cow::Owned)
    }

    fn time(&self) -> Time<'_> {
        Time { t_s: &[0.0, 600.0], pass: &[0, 0] }
    }
}

/// Every form, for every column, but what happened once and no firmware corrects.
fn forms() -> Vec<Declared> {
    let columns = GIVEN.map(|given| given.column);
    let text = physics::forms(&columns[..4]).concat();
    let arcsec = Unit::named("arcsec");
    let unit = |name: &str| match name {
        "stroke" | "spacing" => Some(Unit::named("arcsec")),
        "interval" | "duration" => Some(Unit::named("s")),
        _ => None,
    };
    let vocabulary = Vocabulary {
        position: &arcsec,
        places: (&Unit::named("deg"), "deg"),
        name: "arcsec",
        column: &|name| Expressed::observable(name, true, "arcsec").ok().map(|(_, unit)| unit),
        known: &[],
        figure: &unit,
        taken: &[],
    };
    let mut forms = declared("forms", &text, &vocabulary).unwrap();
    forms.retain(|form| !form.known.of_one_time);
    forms
}

/// A value in the middle of a parameter's range, by ratios.
fn middle(parameter: &DeclaredParameter) -> f64 {
    let Role::Searched(grid) = &parameter.role else { return 1.0 };
    let end = |formula: &physics::Formula| formula.values(&Recorded, &[]).unwrap()[0];
    let (from, to) = (end(&grid.from), end(&grid.to));
    match (&*parameter.name, from > 0.0) {
        ("after", _) => DELAY_S,
        (_, true) => (from * to).sqrt(),
        (_, false) => 0.5 * (from + to),
    }
}

/// A form as the diagnosis hands it on: with numbers in place of what is of the recording.
fn expressed(form: &Declared, index: usize) -> Expressed {
    let all: Vec<f64> = form.parameters.iter().map(middle).collect();
    let formula = &form.adds[index];
    let text = formula.sentence.settled(&Recorded, &formula.own(&all)).unwrap();
    let (mut factors, mut parameters) = (Vec::new(), Vec::new());
    for at in &formula.of {
        let (name, unit) = (form.parameters[*at].name.clone(), form.parameters[*at].unit.to_string());
        match form.parameters[*at].role {
            Role::Factor(_) => factors.push(ExpressionFactor { name, unit }),
            _ => parameters.push(Fixed { name, unit, value: all[*at] }),
        }
    }
    Expressed::of(text, "arcsec", true, factors, parameters)
}

/// Words of s and counts of all inputs: walks, jumps and holds.
fn words(seed: u64) -> Vec<(i32, [u16; GIVEN.len()])> {
    let mut state = seed;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut places = [0.5; GIVEN.len() + 1];
    let mut call = |index: usize| {
        for place in &mut places {
            let jump = draw() < 0.02;
            let step = 0.1 * (draw() - 0.5);
            *place = if jump { draw() } else { (*place + step).clamp(0.0, 1.0) };
        }
        let count = |k: usize| {
            let (from, to) = (f64::from(GIVEN[k].counts.0), f64::from(GIVEN[k].counts.1));
            // The direction is one of two; at the other ends the count may lie beyond the rounded box.
            let told = k + 1 == GIVEN.len();
            let (place, inside) = if told { (places[k].round(), 0.0) } else { (places[k], 1.0) };
            (from + (to - from) * place).round().clamp(from + inside, to - inside) as u16
        };
        let s = if index % 50 == 49 { places[5].round() } else { places[5] };
        (((s - 0.5) * f64::from(i32::MAX)) as i32, std::array::from_fn(count))
    };
    (0..CALLS).map(&mut call).collect()
}

/// The calls as a recording, so that `fitter` evaluates the terms over it.
fn as_recording(words: &[(i32, [u16; GIVEN.len()])]) -> fitter::Recording {
    let columns = GIVEN[..4].iter().map(|given| given.column).collect::<Vec<_>>().join(",");
    let mut text = format!("t_s,pass,x1_mm,x2_mm,reference_arcsec,direction,{columns}\n");
    for (row, (s, counts)) in words.iter().enumerate() {
        let values: Vec<String> =
            GIVEN.iter().zip(counts).map(|(given, c)| format!("{:?}", given.value(*c))).collect();
        let s = f64::from(*s) * FULL_SCALE_MM / 2f64.powi(31);
        let direction = GIVEN[4].value(counts[4]);
        text += &format!("{:?},1,0,{s:?},0,{direction},{}\n", PERIOD_S * row as f64, values[..4].join(","));
    }
    fitter::Recording::from_bytes("sequence.csv", text.as_bytes()).unwrap()
}

/// Terms of a form whose every factor makes [`SIZE_ARCSEC`].
fn term_of(form: &Declared, index: usize, observables: &Observables) -> Term {
    let expressed = expressed(form, index);
    let alone = |k: usize| {
        let mut one = vec![0.0; expressed.factors.len()];
        one[k] = 1.0;
        let term = term(&form.id, Operator::Expression(expressed.clone()), one);
        let values = fitter::terms::evaluate(&[term], observables, true).inside;
        SIZE_ARCSEC / values.iter().fold(f64::MIN_POSITIVE, |most, value| value.abs().max(most))
    };
    let coefficients = (0..expressed.factors.len()).map(alone).collect();
    term(&form.id, Operator::Expression(expressed), coefficients)
}

/// What a form is generated with: whole numbers in and out, or floats.
fn options_of(term: &Term, floats: bool) -> Options {
    let reads = |given: &&Given| term.operator.observables().contains(&given.column);
    let further = GIVEN.iter().filter(reads).map(|given| {
        let ((from, to), Given { column, gain, zero, .. }) = (given.ends(), given);
        Further::parse(&format!("{column}={from}..{to}:counts:16:{gain}:{zero}")).unwrap()
    });
    let ends = match floats {
        true => Ends {
            input: Some(Input { arity: Arity::Reading, encoding: Encoding::F32 }),
            output: Some(Output::F32),
            full_scale: None,
        },
        false => Ends { full_scale: Some(FULL_SCALE_MM), ..Ends::default() },
    };
    Options {
        routines: vec![ends.routine(Method::Fused, Format::Q31)],
        further: further.collect(),
        period_s: Some(PERIOD_S),
        bound: Some(BOUND_ARCSEC),
        degree: Some(9),
        ..Options::default()
    }
}

/// Holds a routine over calls against `apply`, which rounds as the model of `verify` says; whether it has a table.
fn held(
    coefficients: &Coefficients,
    options: &Options,
    words: &[(i32, [u16; GIVEN.len()])],
) -> Result<bool, String> {
    let generated = generate(coefficients, "0", options).map_err(|error| error.to_string())?;
    let [c, rust] =
        [".c", ".rs"].map(|end| generated.files.keys().any(|file| file.to_string_lossy().ends_with(end)));
    assert!(c && rust, "both languages");
    let routine = &generated.routines[0];
    let (unit, bound) = (routine.design.unit.to_f64(), routine.design.bound.total);
    if bound * ARCSEC_PER_RAD > options.bound.unwrap() {
        return Err(format!("bound {:.3e}", bound * ARCSEC_PER_RAD));
    }
    let recording = as_recording(words);
    let observables = Observables { recording: &recording, sensor: &coefficients.sensor };
    let added = fitter::terms::evaluate(&coefficients.terms, &observables, true);
    let fast_reference = FastReference::of(routine);
    let (program, mut state) = (&routine.design.program, Vec::new());
    let mut model = Model::new(routine, &fast_reference);
    for (row, (s, counts)) in words.iter().enumerate() {
        let reads = |given: &Given| options.further.iter().any(|f| f.observable == given.column);
        let given: Vec<u16> = GIVEN.iter().zip(counts).filter(|(g, _)| reads(g)).map(|(_, c)| *c).collect();
        let reading = f64::from(*s) * FULL_SCALE_MM / 2f64.powi(31);
        let float = matches!(options.routines[0].input.encoding, Encoding::F32);
        let first = if float { Word::Float(reading as f32) } else { Word::Int((*s).into()) };
        let arguments: Vec<Word> =
            std::iter::once(first).chain(given.iter().map(|c| Word::Int((*c).into()))).collect();
        if row == 0 {
            state = start(program, &arguments).unwrap();
        }
        let out = update(program, &mut state, &arguments).unwrap().word;
        let out =
            if float { f64::from(f32::from_bits(out.bits() as u32)) } else { f64::from(out.bits() as i32) };
        let read = if float { f64::from(reading as f32) } else { f64::from(*s) };
        let numbers: Vec<f64> = given.iter().map(|c| f64::from(*c)).collect();
        let modelled = model.call(row == 0, read, &numbers);
        let error = (out - modelled.words).abs() * unit;
        let own = modelled.error * unit;
        if error > bound + own {
            return Err(format!("row {row}: {error:e} exceeds {bound:e}"));
        }
        let observed = paper().error_model().corrected(reading) * ARCSEC_PER_RAD - added.inside[row];
        let apart = (modelled.words * unit - added.solve_periodic(observed) / ARCSEC_PER_RAD).abs();
        // A float has fewer digits than the recording.
        if !float && apart > 4.0 * own {
            return Err(format!("row {row}: the model is {apart:e} off, {own:e} said"));
        }
    }
    Ok(!program.table.is_empty())
}

/// Two periodic errors that do not repeat together.
fn periodic_errors() -> [Term; 2] {
    let of = |effect, period, weights: [f64; 2]| {
        term(effect, Operator::Periodic(Periodic::of(period, 1)), weights.to_vec())
    };
    [of("periodic_error", 7000.0, [2.0, -1.0]), of("screw_error", 11_300.0, [1.0, 3.0])]
}

/// A form over a walk, and the observables of that.
fn with_walk(of: impl FnOnce(&Observables)) {
    let (recording, sensor) = (as_recording(&words(1)), paper().sensor);
    of(&Observables { recording: &recording, sensor: &sensor });
}

#[test]
fn some_forms_are_computed_within_their_bound() {
    forms_are_computed_within_their_bound(19);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn every_form_is_computed_within_its_bound() {
    forms_are_computed_within_their_bound(1);
}

/// Every so many of them.
fn forms_are_computed_within_their_bound(step: usize) {
    let (walks, forms) = ([words(1), words(2)], forms());
    let each: Vec<(&Declared, usize)> = forms
        .iter()
        .flat_map(|form| (0..form.adds.len()).map(move |index| (form, index)))
        .step_by(step)
        .collect();
    let tried = |(form, index): &(&Declared, usize)| {
        let mut coefficients = paper();
        with_walk(|observables| coefficients.terms = vec![term_of(form, *index, observables)]);
        let held = [false, true].map(|floats| {
            let options = options_of(&coefficients.terms[0], floats);
            held(&coefficients, &options, &walks[usize::from(floats)])
        });
        held.into_iter().filter_map(Result::err).map(|why| format!("{}: {why}", form.id)).collect::<Vec<_>>()
    };
    let failed: Vec<String> = each.par_iter().flat_map_iter(tried).collect();
    assert!(failed.is_empty(), "{} of {} forms:\n{}", failed.len(), each.len(), failed.join("\n"));
}

const WITH_A_TABLE: [&str; 5] =
    ["switch_coil_a", "wave_coil_a", "waving_gain_coil_a", "turning_gain_shaft_deg", "ripple_coil_a"];

#[test]
fn a_form_and_periodic_errors_share_a_table() {
    share_a_table(&WITH_A_TABLE[..1], &[Method::Fused]);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn forms_and_periodic_errors_share_a_table() {
    let table = Method::Piecewise { degree: 2, segments_log2: 5, padded: false, place: None };
    share_a_table(&WITH_A_TABLE, &[Method::Fused, table]);
}

/// Forms that have a table of their own, each beside two periodic errors and all of them together.
fn share_a_table(ids: &[&str], methods: &[Method]) {
    let (words, forms, mut all) = (words(2), forms(), paper());
    for id in ids {
        let form = forms.iter().find(|form| form.id == *id).unwrap();
        let mut coefficients = paper();
        with_walk(|observables| coefficients.terms = vec![term_of(form, 0, observables)]);
        let options = options_of(&coefficients.terms[0], false);
        assert_eq!(held(&coefficients, &options, &words), Ok(true), "{id} has no table");
        all.terms.extend(coefficients.terms.clone());
        coefficients.terms.extend(periodic_errors());
        assert_eq!(held(&coefficients, &options, &words), Ok(true), "{id}");
    }
    let mut options = options_of(&all.terms[0], false);
    // The fourth is of the shaft's angle, the others of the coil's current.
    if let Some(other) = all.terms.get(3) {
        options.further.extend(options_of(other, false).further);
    }
    all.terms.extend(periodic_errors());
    for method in methods {
        options.routines[0].method = *method;
        options.bound = Some(3.0 * BOUND_ARCSEC);
        assert_eq!(held(&all, &options, &words), Ok(true));
    }
}
