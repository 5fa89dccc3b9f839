//! No answer on a moving mechanism contradicts itself: recordings that are hard on the diagnosis, each checked for what
//! no answer may break, and the written plant run by the code of `simulate`.

use std::path::Path;

use fitter::plant::PlantFile;
use motion::{Begin, Series, simulate};
use serde_json::Value;

use crate::diagnose::moving::{STEP_S, Scatter, Scene, ids, made, moved, several};

const ROWS: usize = 3000;

type Row = (f64, f64);

/// Rows with their time and run, every digit kept.
fn text(rows: &[Row], run_rows: usize, time: impl Fn(usize) -> f64) -> String {
    let line = |(k, (u, x)): (usize, &Row)| format!("{},{},{u:e},{x:e}\n", time(k), 1 + k / run_rows);
    String::from("t_s,run,drive,position\n") + &rows.iter().enumerate().map(line).collect::<String>()
}

fn plain(rows: &[Row]) -> String {
    text(rows, rows.len(), |k| (k as f64 * STEP_S * 1e6).round() / 1e6)
}

fn drives(rows: usize) -> impl Iterator<Item = f64> {
    (0..rows).map(|k| several(2.3 * k as f64 * STEP_S))
}

/// Every sample missing that comes at one of these rows, while the times go on as if none were.
fn dropped(rows: usize, extra: impl Fn(f64, f64) -> f64) -> Vec<Row> {
    let missing = [400, 1100, 1950, 2600];
    let mut all = made(rows + missing.len(), extra);
    for row in missing.iter().rev() {
        all.remove(*row);
    }
    all
}

/// Read at times that jitter by so much of the sampling interval.
fn jittered(rows: usize, by: f64, extra: impl Fn(f64, f64) -> f64) -> Vec<Row> {
    let clean = moved(drives(rows + 1), 0.0, extra);
    let mut scatter = Scatter(11);
    let read = |k: usize, scatter: &mut Scatter| {
        let speed = if k == 0 { 0.0 } else { 0.5 * (clean[k + 1].1 - clean[k - 1].1) };
        clean[k].1 + by * speed * scatter.next() + 0.9 * scatter.next()
    };
    (0..rows).map(|k| (clean[k].0, read(k, &mut scatter))).collect()
}

/// A spring that hardens by a sixth at 600 units.
fn hardening(x: f64, _: f64) -> f64 {
    -0.0167 * x * x * x
}

/// Dry friction that holds the mechanism until the other forces are stronger, in two hundred steps a row; a step in which
/// the velocity would pass zero ends there.
fn stick_slip(rows: usize, friction: f64) -> Vec<Row> {
    let (mut x, mut v, mut scatter) = (0.0_f64, 0.0_f64, Scatter(3));
    let h = STEP_S / 200.0;
    let row = |drive: f64| {
        let row = (drive, x + 0.9 * scatter.next());
        for _ in 0..200 {
            let pull = |x: f64, v: f64| 6e8 * drive - 36_000.0 * x - 40.0 * v;
            if v == 0.0 && pull(x, v).abs() <= friction {
                break;
            }
            let way = if v == 0.0 { pull(x, v).signum() } else { v.signum() };
            let (half_x, half_v) = (x + 0.5 * h * v, v + 0.5 * h * (pull(x, v) - way * friction));
            let next = v + h * (pull(half_x, half_v) - way * friction);
            if next * way < 0.0 {
                x += 0.5 * h * v * v / (v - next);
                v = 0.0;
            } else {
                (x, v) = (x + h * half_v, next);
            }
        }
        row
    };
    drives(rows).map(row).collect()
}

/// Dry friction of another simulator, which rounds the sign of the velocity off and knows no sticking.
fn rounded_friction(rows: usize, force: f64, width: f64) -> Vec<Row> {
    moved(drives(rows), 0.9, |_, v| -force * (v / width).tanh())
}

/// Noise that is alike in samples that follow.
fn correlated(rows: usize) -> Vec<Row> {
    let (mut noise, mut scatter) = (0.0, Scatter(5));
    let clean = moved(drives(rows), 0.0, |_, _| 0.0);
    let mut with = |(u, x): &Row| {
        noise = 0.78 * noise + 0.9 * (1.0 - 0.78f64 * 0.78).sqrt() * scatter.next();
        (*u, x + noise)
    };
    clean.iter().map(&mut with).collect()
}

/// Name, text, and whether a refusal is right.
fn cases() -> Vec<(&'static str, String, bool)> {
    let usual = made(ROWS, |_, _| 0.0);
    let changed = |change: &dyn Fn(usize, Row) -> Row| -> String {
        plain(&usual.iter().enumerate().map(|(k, row)| change(k, *row)).collect::<Vec<Row>>())
    };
    let gap = |k: usize| (k + usize::from(k > 1700)) as f64 * STEP_S;
    let mut random = Scatter(9);
    let unrelated: Vec<Row> = usual.iter().map(|(u, _)| (*u, random.next())).collect();
    // What leaves structure everywhere is searched for long: a third of the rows shows it as well.
    let offset: Vec<Row> = usual[..ROWS / 3].iter().map(|(u, x)| (u + 1e3, *x)).collect();
    vec![
        ("short", plain(&usual[..210]), false),
        ("tiny_units", changed(&|_, (u, x)| (1e-9 * u, 1e-9 * x)), false),
        ("huge_units", changed(&|_, (u, x)| (1e9 * u, 1e9 * x)), false),
        ("huge_offset", changed(&|_, (u, x)| (u, x + 1e6)), true),
        ("offset_of_the_drive", plain(&offset), false),
        ("coarse", changed(&|_, (u, x)| (u, 20.0 * (x / 20.0).round())), false),
        ("noiseless", plain(&moved(drives(ROWS / 3), 0.0, |_, _| 0.0)), false),
        ("dropped", plain(&dropped(ROWS, |_, _| 0.0)), false),
        ("dropped_hardening", plain(&dropped(ROWS, hardening)), false),
        ("jittered", plain(&jittered(ROWS, 0.02, |_, _| 0.0)), false),
        ("jittered_hardening", plain(&jittered(ROWS, 0.1, hardening)), false),
        ("stick_slip_weak", plain(&stick_slip(ROWS, 1.3e6)), false),
        ("stick_slip", plain(&stick_slip(ROWS, 2.7e6)), false),
        ("stick_slip_strong", plain(&stick_slip(ROWS, 5e6)), false),
        ("rounded_friction", plain(&rounded_friction(ROWS, 2.4e6, 2e3)), false),
        ("rounded_friction_strong_and_short", plain(&rounded_friction(700, 1.2e7, 5e3)), false),
        ("correlated", plain(&correlated(2 * ROWS)), false),
        ("four_runs", text(&usual, ROWS / 4, |k| (k % (ROWS / 4)) as f64 * STEP_S), false),
        ("constant_drive", changed(&|_, (_, x)| (0.3, x)), true),
        ("no_drive", changed(&|_, (_, x)| (0.0, x)), true),
        ("saturated", changed(&|_, (u, x)| (u, x.clamp(-300.0, 300.0))), true),
        ("one_run_with_a_gap", text(&usual, ROWS, gap), true),
        ("unrelated", plain(&unrelated), true),
    ]
}

fn numbers(value: &Value, out: &mut Vec<f64>) {
    match value {
        Value::Number(n) => out.push(n.as_f64().unwrap_or(f64::NAN)),
        Value::Array(all) => all.iter().for_each(|v| numbers(v, out)),
        Value::Object(all) => all.values().for_each(|v| numbers(v, out)),
        _ => {}
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// What an answer breaks.
fn broken(d: &Value) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut all = Vec::new();
    numbers(d, &mut all);
    if all.iter().any(|x| !x.is_finite()) {
        wrong.push("a number is not finite".into());
    }
    let effects = d["effects"].as_array().cloned().unwrap_or_default();
    let shares: Vec<f64> = effects.iter().map(|e| number(&e["share"])).collect();
    if shares.iter().any(|s| !(0.0..=1.0).contains(s)) || shares.iter().sum::<f64>() > 1.001 {
        wrong.push(format!("shares {shares:?}"));
    }
    let plant = d["plant"].as_array().cloned().unwrap_or_default();
    let parameters = effects.iter().flat_map(|e| e["parameters"].as_array().cloned().unwrap_or_default());
    for p in parameters.chain(plant) {
        let (value, low, high) = (number(&p["value"]), number(&p["ci95"][0]), number(&p["ci95"][1]));
        if !(low <= value && value <= high) || high - low > 3e3 * value.abs().max(1e-300) {
            wrong.push(format!("{} {value:e} in {low:e} … {high:e}", p["name"]));
        }
    }
    let (before, after) = (&d["fit"]["before"], &d["fit"]["after"]);
    for rows in ["train_rms", "held_out_rms"] {
        if number(&after[rows]) > 1.02 * number(&before[rows]) {
            wrong.push(format!("{rows} {} -> {}", before[rows], after[rows]));
        }
    }
    let floor = number(&d["noise_floor"]["value"]);
    if floor > 1.05 * number(&before["train_rms"]).max(number(&before["held_out_rms"])) {
        wrong.push(format!("floor {floor}"));
    }
    let claimed = ["explained", "consistent"].iter().any(|v| d["verdict"] == *v);
    if claimed && number(&after["held_out_rms"]) > 1.3 * floor {
        wrong.push(format!("{} with {} left at a floor of {floor}", d["verdict"], after["held_out_rms"]));
    }
    wrong
}

/// Root mean square of what the written plant leaves, begun as the diagnosis's own simulation.
fn simulated(scene: &Scene, stem: &str, recording: &str) -> Result<f64, String> {
    let plant = PlantFile::read(Path::new(&scene.path(&format!("out/{stem}.plant.toml"))))
        .map_err(|e| e.to_string())?;
    let mut series = Series::read(Path::new(recording)).map_err(|e| e.to_string())?;
    let recorded = series.positions[0].clone();
    let own = std::fs::read_to_string(scene.path(&format!("out/{stem}.simulated.csv")))
        .map_err(|e| e.to_string())?;
    let after = |line: &str| line.rsplit(',').next().and_then(|v| v.parse().ok()).unwrap_or(f64::NAN);
    series.positions[0] = own.lines().skip(1).map(after).collect();
    let made = simulate("plant.toml", &plant, &series, Begin::Recorded).map_err(|e| e.to_string())?;
    let apart: Vec<f64> = recorded.iter().zip(&made.positions[0]).map(|(y, s)| (y - s).powi(2)).collect();
    let scored: Vec<f64> =
        series.runs().into_iter().flat_map(|run| apart[run.start + 50..run.end].to_vec()).collect();
    Ok((scored.iter().sum::<f64>() / scored.len().max(1) as f64).sqrt())
}

#[test]
fn some_hard_recordings_have_answers_that_hold() {
    hard_recordings_have_answers_that_hold(5);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn all_hard_recordings_have_answers_that_hold() {
    hard_recordings_have_answers_that_hold(1);
}

/// Every so many of them.
fn hard_recordings_have_answers_that_hold(step: usize) {
    let scene = Scene::new();
    let (mut refused, mut wrong) = (Vec::new(), Vec::new());
    let cases = cases();
    for (stem, text, may_be_refused) in cases.iter().step_by(step) {
        let recording = scene.write(&format!("{stem}.csv"), text);
        let output = scene.diagnose(&recording, &[]);
        if output.status.code() == Some(2) {
            refused.push(*stem);
            if !may_be_refused {
                wrong.push(format!("{stem}: refused: {}", String::from_utf8_lossy(&output.stderr)));
            }
            continue;
        }
        assert!(output.status.success(), "{stem}: {}", String::from_utf8_lossy(&output.stderr));
        let d = scene.json(stem);
        wrong.extend(broken(&d).iter().map(|what| format!("{stem}: {what}")));
        let said = [number(&d["fit"]["after"]["train_rms"]), number(&d["fit"]["after"]["held_out_rms"])];
        let (low, high) = (said[0].min(said[1]), said[0].max(said[1]));
        match simulated(&scene, stem, &recording) {
            Ok(got) if got >= 0.97 * low && got <= 1.03 * high => {}
            other => wrong.push(format!("{stem}: simulated {other:?}, said {low} … {high}")),
        }
        eprintln!("{stem}: {} {:?} {said:?} floor {}", d["verdict"], ids(&d), d["noise_floor"]["value"]);
        let place = d["locations"][0]["variable"].as_str().unwrap_or("");
        match *stem {
            "dropped" | "jittered" if d["verdict"] == "consistent" || place != "t_s" => {
                wrong.push(format!("{stem}: {} on {place}", d["verdict"]));
            }
            "correlated" | "four_runs" | "tiny_units" if d["verdict"] != "consistent" => {
                wrong.push(format!("{stem}: {} {:?}", d["verdict"], ids(&d)));
            }
            // It leaves eight times the noise, and five times what its own past does not predict.
            "rounded_friction_strong_and_short" if d["verdict"] != "partly_explained" => {
                wrong.push(format!("{stem}: {} {:?}", d["verdict"], ids(&d)));
            }
            // Faults of the data say nothing against an effect that explains all but what they make.
            "dropped_hardening" | "jittered_hardening"
                if d["verdict"] != "partly_explained" || ids(&d) != ["cubic_stiffness"] =>
            {
                wrong.push(format!("{stem}: {} {:?}", d["verdict"], ids(&d)));
            }
            "stick_slip_weak" | "stick_slip" | "stick_slip_strong"
                if d["verdict"] != "explained" || ids(&d) != ["coulomb_friction"] || low > 1.1 * 0.9 =>
            {
                wrong.push(format!("{stem}: {} {:?}, {low} left", d["verdict"], ids(&d)));
            }
            _ => {}
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Six of them may be refused: five have no drive or no whole position, one stands a million units from zero.
    assert!(refused.len() <= 6, "refused: {refused:?}");
}

#[test]
fn given_optional_parameters_are_kept_and_misspelt_ones_refused() {
    let scene = Scene::new();
    let effect = |stiffness: f64, limit: f64| {
        format!(
            "[[effects]]\nid = \"bouc_wen_hysteresis\"\nstiffness = {stiffness:?}\nyield = {limit:?}\n\
             beta = 0.8\nexponent = 2.0\n"
        )
    };
    let nominal = std::fs::read_to_string(scene.path("plant.toml")).expect("a plant");
    let truth = format!("{nominal}damping = 40.0\nstiffness = 36000.0\ngain = 6e8\nhold = \"zero-order\"\n");
    let truth = PlantFile::parse("truth", &(truth + &effect(9000.0, 400.0))).expect("a plant");
    let clean = Series {
        further: Vec::new(),
        t_s: (0..ROWS).map(|k| k as f64 * STEP_S).collect(),
        drives: vec![drives(ROWS).collect()],
        ..Series::default()
    };
    let clean = simulate("truth", &truth, &clean, Begin::Rest).expect("a simulation").positions;
    let mut scatter = Scatter(2);
    let rows: Vec<Row> = drives(ROWS).zip(&clean[0]).map(|(u, x)| (u, x + 0.9 * scatter.next())).collect();
    let recording = scene.write("hysteresis.csv", &plain(&rows));
    let given = effect(5000.0, 700.0);
    let plant = scene.write("plant.toml", &format!("{nominal}{given}"));
    let output = scene.diagnose(&recording, &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(scene.json("hysteresis")["verdict"], "consistent");
    let written = PlantFile::read(Path::new(&scene.path("out/hysteresis.plant.toml"))).expect("a plant");
    let number = |name: &str| written.effects[0].number(name).unwrap_or(f64::NAN);
    assert_eq!([number("beta"), number("exponent")], [0.8, 2.0]);
    assert!((number("stiffness") / 9000.0 - 1.0).abs() < 0.05, "{written:?}");
    assert!((number("yield") / 400.0 - 1.0).abs() < 0.05, "{written:?}");

    std::fs::write(&plant, format!("{nominal}{}", given.replace("exponent", "exponet"))).expect("a file");
    let output = scene.diagnose(&recording, &[]);
    let told = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!(output.status.code(), Some(2), "{told}");
    for part in ["plant.toml", "`exponet`", "`exponent`"] {
        assert!(told.contains(part), "{told}");
    }
}
