//! What is left out of a routine, and what no routine is made of: each with its reason.

use std::path::Path;

use codegen::generate::generate;

use super::expression::expressed;
use super::*;

fn refused(terms: Vec<Term>, options: &Options) -> String {
    let mut coefficients = paper();
    coefficients.terms = terms;
    coefficients.observed.insert("temperature_c".into(), [16.0, 34.0]);
    routine::design(&coefficients, options, &options.routines[0]).unwrap_err().to_string()
}

#[test]
fn what_is_left_out_is_named_with_its_reason() {
    let bump = Gaussian::of("angle_arcsec", 100.0, 60.0);
    let step = Operator::Step(Step { observable: "t_s".into(), at: 5.0 });
    let own = Operator::Product(Product::of("reference_arcsec", 0.0));
    let warm = Operator::Exponential(Exponential { observable: "t_s".into(), start: 0.0, scale: 600.0 });
    let of_recording =
        |effect, operator| Term { scope: Scope::Recording, ..term(effect, operator, vec![3.0]) };
    let mut coefficients = paper();
    coefficients.terms = vec![
        term("local_defect", Operator::Gaussian(bump), vec![1.0]),
        of_recording("mount_step", step),
        of_recording("warmup_drift", warm),
        term("autocollimator_scale", own, vec![1e-4]),
    ];
    let mut options = Options { further: Vec::new(), ..options() };
    options.without = vec!["local_defect".into()];
    let head = |options: &Options| {
        let generated = generate(&coefficients, "0", options).unwrap();
        generated.files[Path::new("c/corrected_angle.h")].replace("\n * ", " ").replace("        ", "")
    };
    let text = head(&options);
    for part in [
        "local_defect: as asked for",
        "mount_step: a step at a past date",
        "warmup_drift: it holds on the recording that it was found in only",
        "at switch-on, warmup_drift can be kept",
        "autocollimator_scale: it is the reference instrument's own error",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    options.keep = vec!["warmup_drift".into()];
    options.period_s = Some(0.001);
    let text = head(&options);
    assert!(text.contains("warmup_drift: 3.0·(1 − exp(−v/600.0)), v = time since the start"), "{text}");
    let told = |keep: &str, without: &str| {
        let list = |name: &str| if name.is_empty() { Vec::new() } else { vec![name.to_string()] };
        let options = Options { keep: list(keep), without: list(without), ..options.clone() };
        routine::design(&coefficients, &options, &options.routines[0]).unwrap_err().to_string()
    };
    assert!(told("mount_step", "").contains("mount_step cannot be kept: a step at a past date"));
    assert!(told("local_defect", "").contains("generated in any case"));
    assert!(told("warmup_drift", "warmup_drift").contains("contradicts"));
    assert!(told("", "hysteresis").contains("only of local_defect, mount_step"));
}

#[test]
fn what_cannot_be_generated_is_told() {
    let t = "temperature_c";
    let drift = |mean| term("thermal_zero_drift", Operator::Product(Product::of(t, mean)), vec![0.3]);
    let narrow = |text: &str| Options { further: vec![Further::parse(text).unwrap()], ..options() };
    let options = narrow("temperature_c=17..33:counts:12:0.01:400");
    let none = Options { further: Vec::new(), ..self::options() };
    assert!(
        refused(vec![drift(22.0)], &none).contains("needs `temperature_c` at run time; describe that input")
    );
    let wide = refused(vec![drift(22.0)], &narrow("temperature_c=15..33:counts:12:0.01:400"));
    assert!(wide.contains("covers 16…34") && wide.contains("allow to extrapolate"), "{wide}");
    let lag = |mean| term("thermal_lag", Operator::Lag(Lag::of(t, 60.0, mean)), vec![1.0]);
    assert!(refused(vec![lag(22.0)], &options).contains("needs the time between two calls"));
    let slow = term("slow", expressed("k * lowpass(temperature_c, 60 [s]) / 1 [K]"), vec![1.0]);
    assert!(refused(vec![slow], &options).contains("slow needs the time between two calls"));
    let timed = Options { period_s: Some(0.1), ..options.clone() };
    let apart = refused(vec![drift(22.0), lag(23.0)], &timed);
    assert!(
        apart.contains("contradict each other") && apart.contains("from 22, thermal_lag from 23"),
        "{apart}"
    );
    let twice = refused(vec![drift(22.0), drift(22.0)], &options);
    assert!(twice.contains("correct the same error twice"), "{twice}");
    let mut given_twice = options.clone();
    given_twice.further.push(given_twice.further[0].clone());
    assert!(refused(vec![drift(22.0)], &given_twice).contains("given twice"));
    let column_s = term("leak", Operator::Product(Product::of("s", 0.0)), vec![0.3]);
    assert!(refused(vec![column_s], &narrow("s=-1..1")).contains("would have the name of another argument"));
    let step = Operator::Step(Step { observable: "angle_arcsec".into(), at: 5.0 });
    assert!(refused(vec![term("jump", step, vec![1.0])], &none).contains("no bound is small"));
    let late = Operator::Exponential(exponential("t_s", 5.0, 60.0));
    assert!(refused(vec![term("late", late, vec![1.0])], &timed).contains("begins later"));
    let delayed = super::expression::expressed("k * delay(temperature_c, 7 [s]) / 1 [K]");
    let long = refused(vec![term("transport", delayed, vec![1.0])], &timed);
    assert!(long.contains("a delay of 70.0 calls: a routine keeps what it read 64 calls ago"), "{long}");
}
