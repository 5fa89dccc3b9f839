//! The language as a whole: operators compose, derivatives are those of the values, and units are checked.

use std::borrow::Cow;

use proptest::prelude::*;

use crate::operator::FUNCTIONS;
use crate::{Columns, Interval, Names, Parameter, Sentence, Time, Unit, Vocabulary, declared, parse};

/// A recording of a few columns.
struct Made {
    t_s: Vec<f64>,
    pass: Vec<i64>,
}

impl Made {
    fn of(rows: usize) -> Made {
        let t_s = (0..rows).map(|row| 3.0 * row as f64 + (row as f64).sin()).collect();
        Made { t_s, pass: (0..rows).map(|row| (row / 20) as i64).collect() }
    }
}

impl Columns for Made {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        let shape = match name {
            "temperature_c" => |t: f64| 22.0 + 3.0 * (t / 41.0).sin() + 0.01 * t,
            "coil_a" => |t: f64| 0.3 * (t / 13.0).cos() + 0.05,
            "angle" => |t: f64| 5000.0 * (t / 60.0).sin(),
            "t_s" => |t: f64| t,
            _ => return None,
        };
        Some(self.t_s.iter().map(|t| shape(*t)).collect())
    }

    fn time(&self) -> Time<'_> {
        Time { t_s: &self.t_s, pass: &self.pass }
    }
}

fn unit(text: &str) -> Unit {
    Unit::parse(text).unwrap()
}

fn column(name: &str) -> Option<Unit> {
    match name {
        "angle" => Some(unit("arcsec")),
        "temperature_c" | "coil_a" | "t_s" => Some(Unit::of_column(name)),
        _ => None,
    }
}

fn parameter(name: &str, of: &str, range: Option<(f64, f64)>) -> Parameter {
    let range = range.map(|(from, to)| Interval { from, to });
    Parameter { name: name.into(), unit: unit(of), range }
}

fn read(text: &str, of: &str, parameters: &[Parameter]) -> Result<Sentence, String> {
    let names = Names { column: &column, known: &["temperature_c", "coil_a", "angle", "t_s"], parameters };
    Sentence::read(text, Some(&unit(of)), &names).map_err(|error| error.to_string())
}

#[test]
fn a_lag_of_a_square_is_an_effect() {
    let parameters = [parameter("k", "arcsec/A^2", None), parameter("tau", "min", Some((0.1, 100.0)))];
    let sentence = read("k * lowpass(coil_a^2, tau)", "arcsec", &parameters).unwrap();
    let recording = Made::of(60);
    let value = sentence.evaluate(&recording, &[40.0, 2.0]).unwrap();
    // The same, one small step of the differential equation after another.
    let square = |t: f64| (0.3 * (t / 13.0).cos() + 0.05).powi(2);
    let mut state = square(recording.t_s[0]);
    let steps = 20_000;
    for row in 1..60 {
        let (from, to) = (recording.t_s[row - 1], recording.t_s[row]);
        let step = (to - from) / f64::from(steps);
        for k in 0..steps {
            let part = (f64::from(k) + 0.5) / f64::from(steps);
            let e = square(from) + part * (square(to) - square(from));
            state += step / 120.0 * (e - state);
        }
        approx::assert_abs_diff_eq!(value.at(row), 40.0 * state, epsilon = 1e-5);
    }
}

#[test]
fn units_are_converted_and_refused() {
    let k = [parameter("k", "arcsec/K", None)];
    assert!(read("k * (temperature_c - 25.1)", "arcsec", &k).is_ok());
    for (text, of, refusal) in [
        ("k * temperature_c + coil_a", "arcsec", "column 1: `+`: arcsec and A do not go together"),
        ("k * (temperature_c - 1 [A])", "arcsec", "column 5: `-`: K and A do not go together"),
        ("k * temperature_c", "mm", "column 1: the expression is in arcsec, expected a value in mm"),
        ("k * exp(temperature_c)", "arcsec", "column 9: `exp`: found K, expected a pure number"),
        ("k * lowpass(temperature_c, coil_a)", "arcsec", "column 28: `lowpass`: found A, expected a time"),
        (
            "k * temprature_c",
            "arcsec",
            "column 5: `temprature_c` is not known, expected perhaps `temperature_c`",
        ),
        ("k * temperature_c^k", "arcsec", "column 19: `^`: the exponent of a power is a whole number"),
        ("k^2 * temperature_c^2", "arcsec^2", "column 1: `k` is no mere factor of the whole here"),
        ("temperature_c * 1 [arcsec/K]", "arcsec", "column 1: the parameter `k` is not in the expression"),
    ] {
        let error = read(text, of, &k).unwrap_err();
        assert!(error.starts_with(refusal), "{text}: {error}");
    }
    let recording = Made::of(5);
    let degrees = read("angle + 1 [deg]", "arcsec", &[]).unwrap().evaluate(&recording, &[]).unwrap();
    let angle = recording.column("angle").unwrap();
    (0..5).for_each(|row| approx::assert_abs_diff_eq!(degrees.at(row), angle[row] + 3600.0, epsilon = 1e-8));
}

#[test]
fn a_table_is_straight_between_even_places_and_held_beyond() {
    let values = [parameter("a", "arcsec", None), parameter("b", "arcmin", None)];
    let sentence =
        read("table(temperature_c, 21 [K], 25000 [mK], a, 2 * a, b, -a)", "arcsec", &values).unwrap();
    let recording = Made::of(60);
    let value = sentence.evaluate(&recording, &[3.0, 0.1]).unwrap();
    let (mut held, mut between) = (0, 0);
    for (row, t) in recording.column("temperature_c").unwrap().iter().enumerate() {
        let along = (0.75 * (t - 21.0)).clamp(0.0, 3.0);
        let near = |k: f64| (1.0 - (along - k).abs()).max(0.0);
        let of_a = near(0.0) + 2.0 * near(1.0) - near(3.0);
        approx::assert_abs_diff_eq!(value.at(row), 3.0 * of_a + 6.0 * near(2.0), epsilon = 1e-12);
        approx::assert_abs_diff_eq!(value.slope(0, row), of_a, epsilon = 1e-13);
        approx::assert_abs_diff_eq!(value.slope(1, row), 60.0 * near(2.0), epsilon = 1e-11);
        if [0.0, 3.0].contains(&along) { held += 1 } else { between += 1 }
    }
    assert!(held > 5 && between > 20, "{held} rows beyond the ends, {between} between them");
}

#[test]
fn a_table_needs_units_that_agree_ends_in_order_and_values_alike() {
    let k = [parameter("k", "arcsec", None)];
    let many = |count: usize| format!("table(coil_a, 0, 1{})", ", k".repeat(count));
    for (text, refusal) in [
        ("table(coil_a, 0 [A], 1 [K], k, k)", "column 1: `table`: A and K do not go together"),
        ("table(coil_a, 0, 1, k, 2 [A])", "column 1: `table`: arcsec and A do not go together"),
        ("table(coil_a, 0, 1, k, 2 [arcsec])", "column 1: `k` is no mere factor of the whole here"),
        ("table(coil_a, k * 1 [A/arcsec], 1, k, k)", "column 1: `k` is no mere factor of the whole here"),
        (&many(1), "column 1: `table` has"),
        (&many(65), "column 1: `table` has"),
    ] {
        let error = read(text, "arcsec", &k).unwrap_err();
        assert!(error.starts_with(refusal), "{text}: {error}");
    }
    assert!(read(&many(64), "arcsec", &k).is_ok());
    let over = |_: &str| Interval { from: -1.0, to: 2.0 };
    let interval = |text: &str| read(text, "arcsec", &[]).unwrap().interval(&over);
    let backward = interval("table(coil_a, 1, 1, 2 [arcsec], 3)").unwrap_err().to_string();
    assert!(backward.contains("from 1 at most to 1 at least, expected an end above"), "{backward}");
    assert!(interval("table(coil_a, lowest(coil_a), 2 * highest(coil_a), 2 [arcsec], 3)").is_ok());
    let values = interval("table(coil_a, 0, 1, 2 [arcsec], -7, coil_a * 1 [arcsec/A])");
    assert_eq!(values.unwrap(), Interval { from: -7.0, to: 2.0 });
}

#[test]
fn what_has_no_value_is_refused_with_its_place() {
    let over = |_: &str| Interval { from: -1.0, to: 2.0 };
    for (text, refusal) in [
        ("1/temperature_c", "column 1: the divisor runs from -1 to 2, and can be zero"),
        ("2 + sqrt(temperature_c)", "column 5: a value down to -1 has no square root"),
        ("log(coil_a / 1 [A])", "column 1: a value down to -1 has no logarithm"),
    ] {
        let of = if text.contains("log") {
            "1"
        } else if text.starts_with('1') {
            "1/K"
        } else {
            "K^0.5"
        };
        let sentence = read(text, of, &[]).unwrap();
        assert_eq!(sentence.interval(&over).unwrap_err().to_string(), refusal);
    }
    assert!(read("sqrt(temperature_c + 1)", "K^0.5", &[]).unwrap().interval(&over).is_ok());
}

#[test]
fn declarations_are_refused_with_the_effect_and_the_place() {
    let file =
        |adds: &str| format!("[[effect]]\nid = \"heat\"\nadds = \"{adds}\"\nk = {{ unit = \"arcsec/K\" }}\n");
    let read = |text: &str, taken: &[&str]| {
        let (position, place) = (unit("arcsec"), unit("deg"));
        let vocabulary = Vocabulary {
            position: &position,
            places: (&place, "deg"),
            name: "arcsec",
            column: &column,
            known: &["temperature_c"],
            figure: &|name| (name == "duration").then(|| unit("s")),
            taken,
        };
        let effects = declared("mine.toml", text, &vocabulary);
        effects.map(|effects| effects.len()).map_err(|error| error.to_string())
    };
    assert_eq!(read(&file("k * temperature_c"), &[]), Ok(1));
    let refused = read(&file("k * temperatur_c"), &[]).unwrap_err();
    let expected = "mine.toml, effect `heat`, `adds`: column 5: `temperatur_c` is not known, expected perhaps `temperature_c`";
    assert_eq!(refused, expected);
    assert!(
        read(&file("k * temperature_c"), &["heat"]).unwrap_err().contains("there is an effect of this id")
    );
    let twice = file("k * temperature_c").repeat(2);
    assert!(read(&twice, &[]).unwrap_err().contains("there is an effect of this id"));
    let no_factor = file("k * temperature_c").replace("arcsec/K\"", "arcsec/K\", from = 1, to = 2");
    assert!(read(&no_factor, &[]).unwrap_err().contains("has no factor"));
    let of_a_range =
        file("k * lowpass(temperature_c, tau)") + "tau = { unit = \"s\", from = 1, to = \"2 * duratio\" }";
    assert!(read(&of_a_range, &[]).unwrap_err().contains("`tau`: column 5: `duratio` is not known"));
    // What an unsettled effect fades with is a time constant, and the names of what is missing are taken.
    let unsettled = |fades: &str, name: &str| {
        let tau = format!("{name} = {{ unit = \"s\", from = 1, to = \"duration\" }}\n");
        let since = format!("unsettled = {{ fades_with = \"{fades}\", since = \"start\" }}\n");
        read(&(file(&format!("k * lowpass(temperature_c, {name})")) + &tau + &since), &[])
    };
    assert_eq!(unsettled("tau", "tau"), Ok(1));
    assert!(
        unsettled("k", "tau").unwrap_err().contains("fades with `k`, expected the name of a time constant")
    );
    assert!(unsettled("missing_s", "missing_s").unwrap_err().contains("give another"));
}

/// An expression of pure numbers, whose parameters are `a` and `b`, made of every function.
fn expressions() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("a".to_string()),
        Just("b".to_string()),
        Just("x".to_string()),
        (-3.0..3.0_f64).prop_map(|number| format!("({number})")),
    ];
    leaf.prop_recursive(4, 24, 3, |inner| {
        let functions = (0..FUNCTIONS.len(), prop::collection::vec(inner.clone(), 4));
        prop_oneof![
            (inner.clone(), inner.clone(), prop::sample::select(vec!["+", "-", "*"]))
                .prop_map(|(a, b, sign)| format!("({a}) {sign} ({b})")),
            (inner.clone(), 2..4).prop_map(|(a, power)| format!("({a})^{power}")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("({a}) / (3 + ({b})^2)")),
            functions.prop_map(|(k, of)| {
                let (name, count) = (FUNCTIONS[k].name(), &FUNCTIONS[k].form().arguments);
                // Arguments that the function has values for.
                let positive = |text: &String| format!("(0.5 + ({text})^2)");
                let arguments: Vec<String> = match name {
                    "sqrt" | "log" => vec![positive(&of[0])],
                    "bump" => vec![of[0].clone(), of[1].clone(), positive(&of[2])],
                    "lowpass" | "delay" => vec![of[0].clone(), "(1 + a^2) * 1 [s]".into()],
                    "play" | "plays" => vec![of[0].clone(), "(1 + a^2)".into()],
                    "exp" => vec![format!("tanh({})", of[0])],
                    "table" => {
                        let ends = [format!("-{}", positive(&of[1])), positive(&of[2])];
                        [&of[..1], &ends, &of[1..], &of[..2]].concat()
                    }
                    _ => of[..*count.start()].to_vec(),
                };
                let call = format!("{name}({})", arguments.join(", "));
                if name == "rate" { format!("({call} * 1 [s])") } else { call }
            }),
        ]
    })
}

/// Recording of one column `x`.
struct Plain(Made);

impl Columns for Plain {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        (name == "x").then(|| self.0.t_s.iter().map(|t| (t / 17.0).sin() + 0.003 * t).collect())
    }

    fn time(&self) -> Time<'_> {
        self.0.time()
    }
}

/// An expression of pure numbers whose parameters run up to `most` either way.
fn plain(text: &str, most: f64) -> Sentence {
    let expression = parse(text).unwrap();
    let names = expression.names();
    let parameters: Vec<Parameter> = (["a", "b"].into_iter())
        .filter(|name| names.contains(name))
        .map(|name| parameter(name, "1", Some((-most, most))))
        .collect();
    let column = |name: &str| (name == "x").then(Unit::one);
    Sentence::read(text, Some(&Unit::one()), &Names { column: &column, known: &[], parameters: &parameters })
        .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// What is printed is read again as the same expression.
    #[test]
    fn text_is_read_as_it_is_printed(text in expressions()) {
        let expression = parse(&text).unwrap();
        prop_assert_eq!(&parse(&expression.to_string()).unwrap(), &expression);
    }

    /// Derivatives are those of the values, but for rows beside a corner, where a small step crosses it.
    #[test]
    fn derivatives_are_those_of_the_values(text in expressions(), a in -2.0..2.0_f64, b in -2.0..2.0_f64) {
        let sentence = plain(&text, 5.0);
        let recording = Plain(Made::of(40));
        let values: Vec<f64> =
            sentence.parameters.iter().map(|parameter| if parameter.name == "a" { a } else { b }).collect();
        let here = sentence.evaluate(&recording, &values).unwrap();
        for index in 0..values.len() {
            let step = 1e-6;
            let moved = |by: f64| {
                let mut values = values.clone();
                values[index] += by;
                sentence.evaluate(&recording, &values).unwrap()
            };
            let (above, below) = (moved(step), moved(-step));
            let wrong = (0..40).filter(|row| {
                let (up, down) = (above.at(*row) - here.at(*row), here.at(*row) - below.at(*row));
                let size = 1.0 + here.at(*row).abs() + here.slope(index, *row).abs();
                let smooth = (up - down).abs() < 1e-8 * size;
                smooth && ((up + down) / (2.0 * step) - here.slope(index, *row)).abs() > 1e-4 * size
            });
            prop_assert_eq!(wrong.count(), 0, "{} by {}", text, sentence.parameters[index].name);
        }
    }

    /// A value lies in the interval that is stated of it.
    #[test]
    fn values_lie_in_their_interval(text in expressions(), a in -2.0..2.0_f64, b in -2.0..2.0_f64) {
        let sentence = plain(&text, 2.0);
        let recording = Plain(Made::of(40));
        let x = Interval::around(recording.column("x").unwrap().iter().copied()).unwrap();
        let interval = sentence.interval(&|_| x).unwrap();
        let values: Vec<f64> =
            sentence.parameters.iter().map(|parameter| if parameter.name == "a" { a } else { b }).collect();
        let value = sentence.evaluate(&recording, &values).unwrap();
        let slack = 1e-9 * (1.0 + interval.from.abs().max(interval.to.abs())).min(1e300);
        for v in &value.rows {
            prop_assert!(interval.from - slack <= *v && *v <= interval.to + slack, "{} in {:?}: {}", v, interval, text);
        }
    }
}

#[test]
fn figures_of_a_recording_become_numbers() {
    let parameters = [parameter("k", "arcsec/K", None)];
    let sentence = read("k * (temperature_c - mean(temperature_c))", "arcsec", &parameters).unwrap();
    let recording = Made::of(60);
    let text = sentence.settled(&recording, &[1.0]).unwrap();
    let settled = read(&text, "arcsec", &parameters).unwrap();
    assert!(!text.contains("mean") && settled.columns == ["temperature_c"], "{text}");
    let (values, expected) = (settled.values(&recording, &[2.0]), sentence.values(&recording, &[2.0]));
    assert_eq!(values, expected);
    // A mean has been taken off: what is left is rounding.
    assert!(expected.unwrap().iter().sum::<f64>().abs() < 1e-11);
    // So does what is computed of figures alone.
    let wide = "k * (temperature_c - (1.25 * lowest(temperature_c) - 0.25 * highest(temperature_c)))";
    let sentence = read(wide, "arcsec", &parameters).unwrap();
    let text = sentence.settled(&recording, &[1.0]).unwrap();
    assert!(!text.contains("1.25"), "{text}");
    let settled = read(&text, "arcsec", &parameters).unwrap();
    assert_eq!(settled.values(&recording, &[2.0]), sentence.values(&recording, &[2.0]));
}

#[test]
fn a_lag_that_keeps_near_its_mean_begins_there_on_other_recordings() {
    let recording = Made::of(2000);
    let settled = |text: &str, tau: f64| {
        let parameters = [parameter("k", "arcsec/A^2", None), parameter("tau", "s", Some((tau, tau)))];
        let text = read(text, "arcsec", &parameters)
            .unwrap()
            .with_first_states(&recording, &[1.0, tau], 3.0)
            .unwrap();
        let first = read(&text, "arcsec", &parameters).unwrap().values(&recording, &[1.0, tau]).unwrap()[0];
        (text, first)
    };
    // The current swings in 80 s.
    let current = recording.column("coil_a").unwrap();
    let mean = current.iter().map(|a| a * a).sum::<f64>() / 2000.0;
    let (text, first) = settled("k * lowpass(coil_a^2, tau)", 100.0);
    approx::assert_relative_eq!(first, mean, max_relative = 1e-12);
    assert_ne!(text, "k * lowpass(coil_a^2, tau)");
    // What follows at once begins at what it follows, and what states its beginning keeps it.
    assert_eq!(settled("k * lowpass(coil_a^2, tau)", 5.0).1, current[0] * current[0]);
    assert_eq!(settled("k * lowpass(coil_a^2, tau, 0 [A^2])", 100.0).1, 0.0);
}

#[test]
fn many_plays_abreast_are_those_one_by_one() {
    let parameters = [parameter("r", "arcsec", Some((100.0, 9000.0)))];
    let sentence = read("plays(angle, r, 100, 17)", "arcsec", &parameters).unwrap();
    let recording = Made::of(80);
    // With derivatives the elements are taken one by one.
    let one_by_one = sentence.evaluate(&recording, &[4000.0]).unwrap().rows;
    for (value, expected) in sentence.values(&recording, &[4000.0]).unwrap().iter().zip(one_by_one) {
        approx::assert_abs_diff_eq!(*value, expected, epsilon = 1e-9);
    }
}

#[test]
fn forms_of_two_columns_are_made_once_where_either_may_be_the_first() {
    let forms = crate::forms(&["shaft_deg", "temperature_c", "flow_l_min"]);
    let of = |start: &str| {
        let begins = format!("id = \"{start}");
        forms.iter().filter(|form| form.contains(&begins)).count()
    };
    assert_eq!((of("product_"), of("lagged_product_"), of("proportional_"), of("two_seats")), (3, 6, 3, 1));
    // A shaft is an angle, and another column is another one.
    assert_eq!((of("turn_shaft"), of("changing_turn_")), (1, 2));
    assert_eq!(of("changing_turn_shaft_deg_shaft_deg"), 0);
}

#[test]
fn a_lag_behind_a_parameter_keeps_its_beginning() {
    let parameters = [parameter("k", "arcsec", None), parameter("tau", "s", Some((100.0, 100.0)))];
    let text = "lowpass(table(coil_a, -1 [A], 1 [A], -k, 0 * k, k), tau)";
    let sentence = read(text, "arcsec", &parameters).unwrap();
    assert_eq!(sentence.with_first_states(&Made::of(2000), &[2.0, 100.0], 0.0).unwrap(), text);
}
