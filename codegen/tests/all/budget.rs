//! The budget of a generated correction: complete where the file says all, and naming what it lacks elsewhere.

use codegen::devices::{Device, Wanted};
use codegen::format::Format;
use codegen::generate::{Generated, generate};
use codegen::input::{Arity, Encoding, Input};
use codegen::options::{Method, Options, RoutineOptions};
use codegen::output::Output;
use codegen::physics::{Further, FurtherEncoding};
use codegen::tables::{self, Asked, Firmware};
use codegen::turn::Encoder;
use fitter::budget::{Budget, Component, Distribution, Evaluation, combine};
use fitter::coefficients::{Coefficients, Correlation, Diagnosed};
use fitter::terms::{Operator, Product, Scope, Term};
use fitter::{Mirror, Recording};

fn calibration() -> &'static str {
    include_str!("../../../fitter/data/calibration.csv")
}

fn fitted(csv: &str) -> Coefficients {
    let recording = Recording::from_bytes("calibration.csv", csv.as_bytes()).unwrap();
    fitter::fit(&recording, &Mirror::paper(), &fitter::Options::default()).unwrap().coefficients
}

fn generated(file: &Coefficients, arity: Arity, encoding: Encoding) -> Generated {
    let (method, format, output) = (Method::Fused, Format::Q31, Output::PowerOfTwo);
    let routine = RoutineOptions { method, format, input: Input { arity, encoding }, output };
    generate(file, "", &Options { routines: vec![routine], ..Options::default() }).unwrap()
}

fn budget(file: &Coefficients) -> Budget {
    let word = Encoding::Q31 { full_scale: None };
    generated(file, Arity::Reading, word).certificate.budgets[0].budget.clone()
}

fn component<'a>(budget: &'a Budget, source: &str) -> Option<&'a Component> {
    budget.components.iter().find(|component| component.source == source)
}

#[test]
fn every_part_stands_in_it_and_they_combine_to_what_it_states() {
    let file = fitted(calibration());
    let budget = budget(&file);
    assert_eq!(budget.missing, Vec::<String>::new());
    let sources: Vec<&str> = budget.components.iter().map(|c| c.source.as_str()).collect();
    for source in ["reference", "repeatability", "model", "lack_of_fit", "arithmetic"] {
        assert!(sources.contains(&source), "{source}: {sources:?}");
    }
    let reference = component(&budget, "reference").unwrap();
    assert_eq!((reference.value, reference.distribution), (1.0, Distribution::Rectangular));
    assert_eq!((reference.evaluation, reference.degrees_of_freedom), (Evaluation::B, None));
    let scatter = file.statistics.as_ref().unwrap().between_passes.as_ref().unwrap();
    let repeatability = component(&budget, "repeatability").unwrap();
    assert!((repeatability.value - scatter.standard_deviation).abs() < 1e-5);
    assert_eq!(repeatability.degrees_of_freedom, Some(scatter.degrees_of_freedom as f64));
    assert_eq!(budget.range.len(), 11);
    for place in &budget.range {
        let squares: f64 = place.contributions.iter().map(|u| u * u).sum();
        assert!((place.combined.standard_uncertainty / squares.sqrt() - 1.0).abs() < 1e-4);
        assert!(place.combined.expanded > place.combined.standard_uncertainty);
    }
    let there = budget.range.iter().find(|place| place.at == budget.at).unwrap();
    assert_eq!(combine(&budget.components), there.combined);
    assert_eq!(budget.expanded()[1], there.combined.expanded);
    // Half way between two places lies half way between their uncertainties.
    let [a, b] = [&budget.range[3], &budget.range[4]];
    let between = budget.expanded_at(0.5 * (a.at + b.at));
    assert!((between - 0.5 * (a.combined.expanded + b.combined.expanded)).abs() < 1e-9);
}

#[test]
fn it_stands_in_certificate_and_head() {
    let file = fitted(calibration());
    let generated = generated(&file, Arity::Reading, Encoding::Q31 { full_scale: None });
    let budget = &generated.certificate.budgets[0].budget;
    let text = &generated.files[std::path::Path::new("certificate.json")];
    let read: codegen::certificate::Certificate = serde_json::from_str(text).unwrap();
    assert_eq!(read.budgets[0].budget, *budget);
    let [low, high] = budget.expanded().map(codegen::text::rounded_up);
    for path in ["c/corrected_angle.h", "src/corrected_angle_q31.rs"] {
        let head = &generated.files[std::path::Path::new(path)];
        assert!(head.contains(&format!("U = {low} … {high} arcsec for 95 %")), "{path}: {head}");
        assert!(head.contains("reference: stated accuracy, rectangular"), "{head}");
    }
}

#[test]
fn what_the_file_does_not_say_is_named() {
    let mut file = fitted(calibration());
    let whole = budget(&file);
    file.recorded.as_mut().unwrap().reference.accuracy = None;
    let without = budget(&file);
    assert!(component(&without, "reference").is_none());
    assert!(without.missing[0].starts_with("the accuracy of the reference: state `accuracy_arcsec`"));
    assert!(without.expanded()[1] < whole.expanded()[1]);
    let word = Encoding::Q31 { full_scale: None };
    let head = &generated(&file, Arity::Reading, word).files[std::path::Path::new("c/corrected_angle.h")];
    assert!(head.contains("MISSING: the accuracy of the reference"), "{head}");
    // A file of an earlier version.
    file.recorded = None;
    assert!(budget(&file).missing[0].contains("of an earlier version"));
    // Of a model that nobody recorded there is no budget.
    let model = file.error_model();
    let by_hand = Coefficients::of_model(&model, file.valid_range.from, file.valid_range.to, "by hand");
    assert!(generated(&by_hand, Arity::Reading, word).certificate.budgets.is_empty());
}

#[test]
fn one_pass_tells_no_repeatability_apart() {
    let mut lines = calibration().lines();
    let header = lines.next().unwrap();
    let pass = header.split(',').position(|name| name == "pass").unwrap();
    let first: Vec<&str> = lines.filter(|line| line.split(',').nth(pass) == Some("1")).collect();
    let file = fitted(&format!("{header}\n{}\n", first.join("\n")));
    let budget = budget(&file);
    assert!(
        budget.missing[0].contains("they need two passes or more, the recording has 1"),
        "{:?}",
        budget.missing
    );
    let repeatability = component(&budget, "repeatability").unwrap();
    assert!(repeatability.what.contains("lack of fit included"), "{repeatability:?}");
    assert!(component(&budget, "lack_of_fit").is_none() && component(&budget, "pass_offset").is_none());
}

#[test]
fn a_stated_noise_of_the_reference_is_taken_off() {
    let mut file = fitted(calibration());
    let scatter = component(&budget(&file), "repeatability").unwrap().clone();
    let noise = 0.6 * scatter.value;
    file.recorded.as_mut().unwrap().reference.repeatability = Some(noise);
    let own = component(&budget(&file), "repeatability").unwrap().clone();
    assert!((own.value - 0.8 * scatter.value).abs() < 1e-5, "{own:?}");
    let freedom = scatter.degrees_of_freedom.unwrap() * 0.8f64.powi(4);
    assert!((own.degrees_of_freedom.unwrap() / freedom - 1.0).abs() < 1e-4, "{own:?}");
}

/// A count of a converter, and what of it the recorded readings had already.
#[test]
fn the_step_of_the_input_counts_once() {
    let mut file = fitted(calibration());
    let gain = 1.2e-5;
    let of = |file: &Coefficients, arity| {
        let encoding = Encoding::Counts { bits: 16, gain, offset: 32768.0 };
        let generated = generated(file, arity, encoding);
        component(&generated.certificate.budgets[0].budget, "input").cloned()
    };
    let one = of(&file, Arity::Reading).unwrap();
    // 0.86/12 rad/mm: about 15″ per µm.
    assert!((one.sensitivity / 14_900.0 - 1.0).abs() < 0.05, "{one:?}");
    let step = gain.hypot(1e-7) * one.sensitivity / 12f64.sqrt();
    assert!((one.contribution / step - 1.0).abs() < 1e-3, "{one:?} {step}");
    let both = of(&file, Arity::Probes).unwrap();
    assert_eq!(both.distribution, Distribution::Triangular);
    assert!((both.standard_uncertainty / one.standard_uncertainty - 2f64.sqrt()).abs() < 1e-4);
    file.recorded.as_mut().unwrap().reading_step = gain;
    assert_eq!(of(&file, Arity::Reading), None);
}

/// Terms of a diagnosis: their intervals enter with their covariance, what the diagnosis left as lack of fit.
#[test]
fn a_diagnosed_file_has_its_figures_in_the_budget() {
    let mut file = fitted(calibration());
    let verdict = "explained".to_string();
    file.diagnosis = Some(Diagnosed { verdict, before_rms: 5.0, after_rms: 0.5, noise_floor: 0.4 });
    let diagnosed = budget(&file);
    assert_eq!(component(&diagnosed, "repeatability").unwrap().value, 0.4);
    assert!((component(&diagnosed, "lack_of_fit").unwrap().value - 0.3).abs() < 1e-6);
    let before = component(&diagnosed, "model").unwrap().contribution;
    let mut joint = file.identification.as_ref().unwrap().covariance.clone();
    joint.iter_mut().flatten().for_each(|value| *value *= 4.0);
    file.joint_covariance = joint;
    let wider = component(&budget(&file), "model").unwrap().contribution;
    // The place where the budget is largest may be the other end.
    assert!((wider / before - 2.0).abs() < 1e-3, "{wider} {before}");
}

/// An encoder with friction, on a reference of ±0.01°.
fn turning() -> Coefficients {
    let mut csv = String::from("t_s,pass,direction,measured,reference\n");
    let counts = 16_384.0;
    for row in 0..720u32 {
        let (pass, place) = (row / 120, f64::from(row % 120));
        let (direction, reference) = match pass % 2 {
            0 => (1.0, 3.0 * place),
            _ => (-1.0, 357.0 - 3.0 * place),
        };
        // Scatter that nothing explains, of some hundredths of a degree.
        let scatter = 0.02 * (f64::from(row * row % 997) / 997.0 - 0.5);
        let error = 0.3 * reference.to_radians().sin() - 0.02 * direction + scatter;
        let measured = ((reference + error) / 360.0 * counts).round() * 360.0 / counts;
        csv += &format!("{row},{pass},{direction},{:.5},{reference}\n", measured.rem_euclid(360.0));
    }
    let toml = "[sensor]\nkind = \"direct\"\nunit = \"deg\"\nrevolution = 360.0\n[reference]\naccuracy_arcsec = 36.0\n";
    let mirror = Mirror::parse("encoder.toml", toml).unwrap();
    let recording = Recording::from_bytes("encoder.csv", csv.as_bytes()).unwrap();
    fitter::fit(&recording, &mirror, &fitter::Options::default()).unwrap().coefficients
}

#[test]
fn an_encoder_has_its_directions_and_its_rounding_in_the_budget() {
    let file = turning();
    let options = Options { encoder: Encoder { bits: Some(14), ..Encoder::default() }, ..Options::default() };
    let budget = generate(&file, "", &options).unwrap().certificate.budgets[0].budget.clone();
    assert_eq!(budget.missing, Vec::<String>::new());
    assert!((component(&budget, "reference").unwrap().value - 0.01).abs() < 1e-9);
    let half = file.turn.as_ref().unwrap().directions.half_distance.as_ref().unwrap().value.abs();
    let direction = component(&budget, "direction").unwrap();
    assert!((direction.value / half - 1.0).abs() < 1e-4 && direction.divisor == 1.0, "{direction:?}");
    let output = component(&budget, "output").unwrap();
    assert!((output.value / (180.0 / 16384.0) - 1.0).abs() < 1e-4, "{output:?}");
}

/// A term that was found beside the polynomial has a row of its own, and rows of what is fitted jointly combine to vᵀCv.
#[test]
fn a_term_has_its_interval_and_its_sensitivity() {
    let mut file = fitted(calibration());
    let base = file.identification.as_ref().unwrap().covariance.clone();
    let drift = Product::of("temperature_c", 22.0);
    file.terms.push(Term {
        effect: "thermal_zero_drift".into(),
        scope: Scope::Device,
        operator: Operator::Product(drift),
        coefficients: vec![0.3],
        covariance: vec![vec![0.01]],
    });
    file.observed.insert("temperature_c".into(), [20.0, 26.0]);
    let further =
        Further { observable: "temperature_c".into(), from: 21.0, to: 26.0, encoding: FurtherEncoding::Q31 };
    let (method, format, output) = (Method::Fused, Format::Q31, Output::PowerOfTwo);
    let input = Input { arity: Arity::Reading, encoding: Encoding::Q31 { full_scale: None } };
    let options = Options {
        routines: vec![RoutineOptions { method, format, input, output }],
        further: vec![further],
        ..Options::default()
    };
    let of =
        |file: &Coefficients| generate(file, "", &options).unwrap().certificate.budgets[0].budget.clone();
    let budget = of(&file);
    let term = component(&budget, "term").unwrap().clone();
    assert_eq!((term.evaluation, &*term.unit), (Evaluation::A, "arcsec per temperature_c"));
    // Independent of the polynomial: 26 °C is 4 K from the mean.
    assert!((term.value - 0.1).abs() < 1e-9 && (term.sensitivity.abs() - 4.0).abs() < 1e-5, "{term:?}");
    assert!(budget.not_included.iter().any(|not| not.contains("further inputs: temperature_c")));
    let whole = |budget: &Budget| {
        let squares = |source: &str| component(budget, source).unwrap().contribution.powi(2);
        squares("model") + squares("term")
    };
    // With a constant that the drift takes along, a₀ and the slope at 22 °C: C of a₀ − 0.05 rad per unit of it.
    let along = 5e-6;
    let mut joint: Vec<Vec<f64>> = base.iter().map(|row| [&row[..], &[0.0]].concat()).collect();
    let last = joint.len();
    joint.push(vec![0.0; last + 1]);
    joint[last][last] = 0.01;
    joint[0][0] += along * along / 0.01;
    (joint[0][last], joint[last][0]) = (along, along);
    file.joint_covariance = joint.clone();
    let together = of(&file);
    let d_mm = 12.0;
    let at = together.at;
    let per = 206_264.806 * d_mm / (at * at + d_mm * d_mm);
    let v: Vec<f64> = (0..last).map(|k| per * at.powi(k as i32)).chain([4.0]).collect();
    let exact: f64 = (0..=last)
        .flat_map(|i| (0..=last).map(move |j| (i, j)))
        .map(|(i, j)| v[i] * joint[i][j] * v[j])
        .sum();
    let found = whole(&together);
    let other: f64 = {
        let v: Vec<f64> = v[..last].iter().copied().chain([-1.0]).collect();
        (0..=last).flat_map(|i| (0..=last).map(move |j| (i, j))).map(|(i, j)| v[i] * joint[i][j] * v[j]).sum()
    };
    assert!((found / exact.max(other) - 1.0).abs() < 1e-3, "{found} {exact} {other}");
}

/// Rows that correlate tell less: fewer degrees of freedom, a wider interval of what was fitted.
#[test]
fn correlated_readings_count_for_fewer() {
    let mut file = fitted(calibration());
    let alone = budget(&file);
    file.recorded.as_mut().unwrap().correlation = Some(Correlation { neighbours: 0.6, of_fitted: 3.0 });
    let correlated = budget(&file);
    let freedom = |budget: &Budget| component(budget, "repeatability").unwrap().degrees_of_freedom.unwrap();
    assert!((freedom(&correlated) / freedom(&alone) - 0.64 / 1.36).abs() < 1e-3);
    assert!(correlated.expanded()[1] > alone.expanded()[1]);
}

/// Each device of a shared routine has the budget that a routine of its own has, but for the arithmetic.
#[test]
fn devices_that_share_a_routine_have_a_budget_each() {
    let file = fitted(calibration());
    let device = |name: &str, coefficients: &Coefficients| Device {
        name: name.into(),
        coefficients: coefficients.clone(),
        sha256: "00".repeat(32),
    };
    let mut silent = file.clone();
    silent.recorded.as_mut().unwrap().reference.accuracy = None;
    let devices = [device("a", &file), device("b", &silent)];
    let generated = codegen::devices::generate(&devices, &Options::default(), &Wanted::default()).unwrap();
    let budgets = &generated.certificate.budgets;
    let names: Vec<_> = budgets.iter().map(|of| of.device.clone().unwrap()).collect();
    assert_eq!(names, ["a", "b"]);
    let [own, shared] = [budget(&file).expanded(), budgets[0].budget.expanded()];
    assert!((shared[1] / own[1] - 1.0).abs() < 1e-3, "{own:?} {shared:?}");
    let head = &generated.files[std::path::Path::new("c/corrected_angle.h")];
    let head = String::from_utf8(head.clone()).unwrap().replace("\n *         ", " ");
    assert!(head.contains("a: U = ") && head.contains("MISSING: the accuracy of the reference"), "{head}");
}

/// A table of other firmware has the uncertainty of what that firmware computes.
#[test]
fn a_table_of_other_firmware_has_a_budget() {
    let file = turning();
    let options = Options { encoder: Encoder { bits: Some(14), ..Encoder::default() }, ..Options::default() };
    let asked =
        Asked { wanted: tables::Wanted { ratio: Some(7.0), ..tables::Wanted::default() }, options: &options };
    for firmware in [Firmware::Moteus, Firmware::Vesc, Firmware::Simplefoc] {
        let certificate = tables::generate(firmware, &file, "", &asked).unwrap().certificate;
        let budget = &certificate.budgets[0].budget;
        let bound = certificate.routines[0].bound;
        assert!((component(budget, "arithmetic").unwrap().value / bound - 1.0).abs() < 1e-4, "{firmware:?}");
        assert!(component(budget, "reference").is_some() && component(budget, "direction").is_some());
        assert!(budget.not_included.iter().any(|not| not.starts_with("the zero")), "{firmware:?}");
    }
    let klipper = Asked { options: &Options::default(), ..asked };
    assert_eq!(
        tables::generate(Firmware::Klipper, &file, "", &klipper).unwrap().certificate.budgets.len(),
        1
    );
}

/// An axis in either direction: its lost motion is in the table, not in the budget.
#[test]
fn the_table_of_an_axis_has_a_budget() {
    let mut csv = String::from("t_s,pass,direction,measured,reference\n");
    for row in 0..240u32 {
        let (pass, place) = (row / 40, f64::from(row % 40));
        let (way, x) = if pass % 2 == 0 { (1, place) } else { (-1, 39.0 - place) };
        let scatter = 1e-3 * (f64::from(row * row % 97) / 97.0 - 0.5);
        csv += &format!("{row},{pass},{way},{:.4},{x}\n", x + 1e-4 * x * x + scatter);
    }
    let toml = "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n[reference]\naccuracy = 0.002\n";
    let recording = Recording::from_bytes("axis.csv", csv.as_bytes()).unwrap();
    let mirror = Mirror::parse("axis.toml", toml).unwrap();
    let file = fitter::fit(&recording, &mirror, &fitter::Options::default()).unwrap().coefficients;
    let (options, wanted) = (Options::default(), tables::Wanted::default());
    let asked = Asked { wanted, options: &options };
    let budget = tables::generate(Firmware::Linuxcnc, &file, "", &asked).unwrap().certificate.budgets[0]
        .budget
        .clone();
    assert!(budget.measurand.contains("where this machine goes to"), "{}", budget.measurand);
    assert!((component(&budget, "reference").unwrap().contribution - 0.002 / 3f64.sqrt()).abs() < 1e-6);
    assert_eq!(
        budget.range.first().map(|place| (place.at, place.result)),
        budget.range.first().map(|p| (p.at, p.at))
    );
}
