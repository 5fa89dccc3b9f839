//! A declared effect, concealed in many made recordings: how often it is named, its intervals hold the truth, its
//! correction is worth what it can be on a fresh recording of the device, and its firmware keeps its bound.
//!
//! The devices, their noise and the course of the recordings are those of `twin`. The current holds the mirror against a
//! load that changes now and then, and the heat of its square is integrated here, in short steps.
//!
//! `ARCSMITH_DECLARED_DRAWN=100` draws more than the usual number, `ARCSMITH_SEED=358` begins elsewhere.

use std::path::{Path, PathBuf};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use serde_json::Value;
use trials::draw::Trial;
use trials::plan::Assignment;
use trials::truth::Group;
use twin::Reading;

use super::declared::{HEATING, arcsmith, left};

/// Recordings that are drawn where the environment does not say.
const DRAWN: u64 = 6;
/// ρ that is drawn, evenly in the logarithm: what can be seen, and as strong as the strong effects of `trials`.
const RHO: [f64; 2] = [8.0, 40.0];
/// The time constant that is drawn, in parts of the recording's duration, as `twin` draws those of its lags.
const TAU: [f64; 2] = [0.03, 0.15];
/// Levels of the load, in A.
const LOADS: [f64; 5] = [-0.2, -0.1, 0.0, 0.1, 0.2];
/// Rows for which a load stays, on average.
const STAYS: f64 = 15.0;
/// Steps of the integration between two rows.
const SUBSTEPS: usize = 200;
/// Seconds between two calls of the firmware.
const PERIOD_S: &str = "0.1";

/// What is concealed in one device.
struct Concealed {
    trial: Trial,
    /// arcsec/A².
    k: f64,
    tau_s: f64,
    rho: f64,
}

/// The answers to one device.
struct Outcome {
    what: String,
    named: bool,
    /// Whether the intervals hold k and τ.
    held: [bool; 2],
    /// Root mean square on the fresh recording, in arcsec: of the base alone, of the answer, and of a base that was
    /// fitted without the effect to a recording without it.
    fresh: [f64; 3],
    /// Whether firmware with the effect is generated, and whether `verify` holds it.
    firmware: [bool; 2],
    /// What the two said where they failed.
    said: String,
}

fn evenly(random: &mut ChaCha8Rng, [from, to]: [f64; 2]) -> f64 {
    from * (to / from).powf(random.random())
}

/// Adds the load to the current of a recording.
fn loaded(mut readings: Vec<Reading>, random: &mut ChaCha8Rng) -> Vec<Reading> {
    let mut load = 0.0;
    for reading in &mut readings {
        if random.random::<f64>() < 1.0 / STAYS {
            load = LOADS[random.random_range(0..LOADS.len())];
        }
        reading.coil_a += load;
    }
    readings
}

/// The lagged square of the current in A², in equilibrium at the first row; the square changes evenly between rows, as the
/// language has it.
fn heat(readings: &[Reading], tau_s: f64) -> Vec<f64> {
    let power = |reading: &Reading| reading.coil_a.powi(2);
    let mut heat = power(&readings[0]);
    let mut rows = vec![heat];
    for pair in readings.windows(2) {
        let step = (pair[1].t_s - pair[0].t_s) / SUBSTEPS as f64;
        for k in 0..SUBSTEPS {
            let place = (k as f64 + 0.5) / SUBSTEPS as f64;
            let now = power(&pair[0]) + place * (power(&pair[1]) - power(&pair[0]));
            // The midpoint rule of τ dH/dt = i² − H.
            let change = step / tau_s * (now - heat);
            heat += change * (1.0 - 0.5 * step / tau_s);
        }
        rows.push(heat);
    }
    rows
}

/// A recording with the heat added to its calculated angle: the reference is that much less.
fn heated(readings: &[Reading], concealed: &Concealed) -> Vec<Reading> {
    let mut readings = readings.to_vec();
    let heat = heat(&readings, concealed.tau_s);
    for (reading, heat) in readings.iter_mut().zip(heat) {
        reading.reference_arcsec -= concealed.k * heat;
    }
    readings
}

fn write(folder: &Path, name: &str, readings: &[Reading]) -> String {
    let path = folder.join(name);
    twin::write_file(readings, &path).expect("a recording");
    path.display().to_string()
}

/// Runs the program, which must succeed.
fn done(arguments: &[&str]) {
    let output = arcsmith(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// What a coefficients file leaves of a fresh recording, in arcsec.
fn rest(folder: &Path, coefficients: &str, fresh: &str) -> f64 {
    let angles = folder.join("angles.csv");
    done(&["apply", fresh, "--coefficients", coefficients, "--out", &angles.display().to_string()]);
    left(&angles, Path::new(fresh))
}

/// Whether firmware with the effect is generated and `verify` holds it, and what was said where not.
fn firmware(folder: &Path, coefficients: &str) -> ([bool; 2], String) {
    let text = std::fs::read_to_string(coefficients).expect("the coefficients");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let [Some(from), Some(to)] = [0, 1].map(|end| json["observed"]["coil_a"][end].as_f64()) else {
        return ([false; 2], "the effect is not handed on".into());
    };
    let (further, out) = (format!("coil_a={from}..{to}"), folder.join("firmware").display().to_string());
    let run = |command: &str| {
        let output = arcsmith(&[
            command,
            "--coefficients",
            coefficients,
            "--accept-unexplained",
            "--further",
            &further,
            "--period-s",
            PERIOD_S,
            "--out",
            &out,
        ]);
        let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        (output.status.success(), said.into_owned())
    };
    let (generated, said) = run("generate");
    if !generated {
        return ([false; 2], said);
    }
    let (holds, said) = run("verify");
    ([true, holds], if holds { String::new() } else { said })
}

impl Concealed {
    fn draw(random: &mut ChaCha8Rng) -> (Concealed, Vec<Reading>) {
        let assignment = Assignment {
            group: Group::Null,
            number: random.random_range(0..10_000),
            seed: random.random(),
            cell: None,
        };
        let trial = Trial::draw(&assignment, "made.csv".into()).expect("a trial");
        let readings = loaded(trial.record(), random);
        let duration = readings[readings.len() - 1].t_s - readings[0].t_s;
        let (tau_s, rho) = (duration * evenly(random, TAU), evenly(random, RHO));
        let of_one = trial.rho_of(&heat(&readings, tau_s)).expect("the strength of an effect");
        let sign = if random.random() { 1.0 } else { -1.0 };
        (Concealed { trial, k: sign * rho / of_one, tau_s, rho }, readings)
    }

    fn described(&self) -> String {
        let (truth, Concealed { k, tau_s, rho, .. }) = (&self.trial.truth, self);
        let recorded = [&*truth.schedule, &*truth.family, &*truth.temperature].join(" ");
        format!("{recorded}, rho {rho:.1}, k {k:.1}, tau {tau_s:.1}")
    }
}

/// The answer in a line: verdict, effects, their parameters with intervals.
fn said(json: &Value) -> String {
    let all = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let parameter = |p: &Value| format!(" {} {}", p["value"], p["ci95"]);
    let effect = |e: &Value| {
        let parameters: String = all(&e["parameters"]).iter().map(parameter).collect();
        format!(" {}{parameters}", e["id"])
    };
    format!("{}{}", json["verdict"], all(&json["effects"]).iter().map(effect).collect::<String>())
}

fn one(seed: u64) -> Outcome {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (concealed, bare) = Concealed::draw(&mut random);
    let bare_fresh = loaded(concealed.trial.record_fresh(), &mut random);
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let path = |name: &str| folder.join(name).display().to_string();
    let (mirror, effects, out) = (path("mirror.toml"), path("mine.toml"), path("out"));
    let geometry = format!("[geometry]\nprobe_distance_mm = {}\n", concealed.trial.distance_mm());
    std::fs::write(&mirror, geometry + "initial_gap_mm = 0.3\n").expect("a file");
    std::fs::write(&effects, HEATING).expect("a file");
    let first = write(folder, "first.csv", &heated(&bare, &concealed));
    let fresh = write(folder, "fresh.csv", &heated(&bare_fresh, &concealed));
    let without = write(folder, "without.csv", &bare);
    let fresh_without = write(folder, "fresh-without.csv", &bare_fresh);

    done(&["diagnose", &first, "--mirror", &mirror, "--effects", &effects, "--out", &out, "--no-report"]);
    let fitted = |recording: &str, name: &str| {
        let coefficients = path(name);
        done(&["fit", recording, "--mirror", &mirror, "--out", &coefficients]);
        coefficients
    };
    let (base, given) = (fitted(&first, "base.json"), fitted(&without, "given.json"));
    let answer = PathBuf::from(&out).join("first.coefficients.json").display().to_string();
    let text = std::fs::read_to_string(Path::new(&out).join("first.json")).expect("the diagnosis");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let effect = &json["effects"][0];
    let named = effect["id"] == "coil_heating";
    let held = [(0, concealed.k), (1, concealed.tau_s)].map(|(index, truth)| {
        let end = |end: usize| effect["parameters"][index]["ci95"][end].as_f64().unwrap_or(f64::NAN);
        named && end(0) <= truth && truth <= end(1)
    });
    let (firmware, broken) = if named { firmware(folder, &answer) } else { ([false; 2], "not named".into()) };
    Outcome {
        what: format!("seed {seed}: {}: {}", concealed.described(), said(&json)),
        named,
        held,
        fresh: [
            rest(folder, &base, &fresh),
            rest(folder, &answer, &fresh),
            rest(folder, &given, &fresh_without),
        ],
        firmware,
        said: broken,
    }
}

fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn a_declared_effect_is_named_and_corrected_in_many_recordings() {
    let (count, first) = (setting("ARCSMITH_DECLARED_DRAWN", DRAWN), setting("ARCSMITH_SEED", 0));
    let outcomes: Vec<Outcome> = (first..first + count).into_par_iter().map(one).collect();
    let named: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.named).collect();
    let share = |of: &dyn Fn(&Outcome) -> bool| {
        named.iter().filter(|outcome| of(outcome)).count() as f64 / named.len() as f64
    };
    let gained = |outcome: &Outcome| {
        let [base, answer, given] = outcome.fresh.map(|rms| rms * rms);
        (base - answer) / (base - given)
    };
    let mut gains: Vec<f64> = outcomes.iter().map(gained).collect();
    for (outcome, gain) in outcomes.iter().zip(&gains) {
        let [base, answer, given] = outcome.fresh;
        println!(
            "{}; held {:?}, firmware {:?} {}; fresh {base:.4} {answer:.4} {given:.4}, gain {gain:.4}",
            outcome.what, outcome.held, outcome.firmware, outcome.said
        );
    }
    gains.sort_unstable_by(f64::total_cmp);
    let median = gains[gains.len() / 2];
    let sum = |of: &dyn Fn([f64; 3]) -> f64| outcomes.iter().map(|outcome| of(outcome.fresh)).sum::<f64>();
    let pooled = sum(&|[base, answer, _]| base * base - answer * answer)
        / sum(&|[base, _, given]| base * base - given * given);
    let [k, tau] = [0, 1].map(|index| share(&|outcome| outcome.held[index]));
    let generated = share(&|outcome| outcome.firmware[0]);
    let kept = outcomes.iter().all(|outcome| outcome.firmware[0] == outcome.firmware[1]);
    println!(
        "{} of {count} named; of these k in its interval {k:.3}, tau {tau:.3}, generated {generated:.3}; part of the \
         possible gain {pooled:.3} of all together, {median:.3} of the median",
        named.len()
    );
    // Three standard deviations below 95 % of so many.
    let covered = 0.95 - 3.0 * (0.95 * 0.05 / named.len() as f64).sqrt();
    assert!(named.len() as f64 >= 0.95 * count as f64, "{} of {count} named", named.len());
    assert!(k >= covered && tau >= covered, "{k} and {tau} of the intervals hold, {covered} wanted");
    assert!(pooled >= 0.95 && median >= 0.95, "{pooled} of the possible gain, {median} of the median");
    assert!(
        generated >= 0.95 && kept,
        "firmware is generated of {generated}, the bound is kept by all: {kept}"
    );
}
