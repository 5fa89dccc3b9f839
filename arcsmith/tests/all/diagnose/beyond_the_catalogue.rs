//! Physics that is in no catalogue is located, described where it has a form, and not given the names of two effects that
//! together imitate it, nor taken for correlated noise.

use crate::diagnose::common::{normal, recording, scene, wandering};
use crate::diagnose::declared::arcsmith;
use serde_json::Value;
use std::fmt::Write;

/// Readings of six passes of 31 rows every 3 s: degrees and degrees Celsius, the temperature at one level in each
/// pass, which it approaches within half a minute.
fn schedule() -> Vec<(f64, f64)> {
    let mut temperature = 15.0;
    (0..186)
        .map(|row| {
            let (pass, k) = (row / 31, row % 31);
            let angle = if pass % 2 == 0 { -1.5 + 0.1 * k as f64 } else { 1.5 - 0.1 * k as f64 };
            let level = [15.0, 27.0, 39.0, 39.0, 27.0, 15.0][pass];
            temperature += 0.15 * (level - temperature);
            (angle, temperature)
        })
        .collect()
}

/// What follows angle and temperature of that schedule, row by row.
fn over_schedule(mut next: impl FnMut(f64, f64) -> f64) -> Vec<f64> {
    schedule().into_iter().map(|(angle, temperature)| next(angle, temperature)).collect()
}

/// The diagnosis of that schedule with `effect` (arcsec, of row, angle and temperature) and `noise` (arcsec).
fn diagnosed(effect: impl Fn(usize, f64, f64) -> f64, noise: &[f64], seed: u64) -> Value {
    let scene = scene();
    let mut blur = normal(seed ^ 0x5555);
    let rows = schedule();
    let blurred: Vec<f64> = rows.iter().map(|(_, t)| t + 0.02 * blur()).collect();
    let path = recording(scene.folder.path(), "r.csv", 6, |row, cells| {
        let (angle, temperature) = rows[row];
        cells[5] = format!("{:.3}", 3600.0 * angle * 0.97 - effect(row, angle, temperature) + noise[row]);
        cells[6] = format!("{:.3}", blurred[row]);
    });
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    scene.json(&out, "r")
}

fn white(seed: u64) -> Vec<f64> {
    let mut normal = normal(seed);
    (0..186).map(|_| 0.5 * normal()).collect()
}

fn said(json: &Value) -> (String, String) {
    let place = &json["locations"][0];
    let names = json["effects"].as_array().expect("effects").iter().filter_map(|e| e["id"].as_str());
    let verdict = json["verdict"].as_str().expect("a verdict");
    (
        format!("{verdict} {:?}", names.collect::<Vec<_>>()),
        place["variable"].as_str().unwrap_or("").to_string(),
    )
}

/// Intervals hold the truth, or miss it by a fifth of their width at most.
fn holds(effect: &Value, truths: &[(&str, f64)]) {
    let parameters = effect["parameters"].as_array().expect("parameters");
    for (name, truth) in truths {
        let found = parameters.iter().find(|p| p["name"] == *name).expect("the parameter");
        let [low, high] = [0, 1].map(|end| found["ci95"][end].as_f64().expect("an end"));
        assert!((low - 0.2 * (high - low)..high + 0.2 * (high - low)).contains(truth), "{found}");
    }
}

/// It holds for no other recording, so that no firmware can undo it.
fn described_as_what_happened_once(json: &Value, formula: &str) {
    let effect = &json["effects"][0];
    assert_eq!(json["verdict"], "described", "{json}");
    assert_eq!(effect["formula"], formula, "{json}");
    assert_eq!(effect["runtime_correctable"], false, "{json}");
}

#[test]
fn creep_that_heat_hastens_is_no_drift_with_temperature_beside_one_with_time() {
    for seed in 1..6 {
        for rate in [0.5, 0.8] {
            let creep = |row: usize, _: f64, t: f64| rate * (t - 27.0) * 3.0 * row as f64 / 3600.0;
            let json = diagnosed(creep, &white(seed), seed);
            described_as_what_happened_once(
                &json,
                "k * (temperature_c - mean(temperature_c)) * t_s + c * t_s",
            );
            holds(&json["effects"][0], &[("k", rate / 3600.0)]);
        }
    }
}

#[test]
fn a_support_that_sways_is_no_physics_of_the_device() {
    for (seed, period) in [(1, 61.0), (2, 95.0), (3, 140.0)] {
        let sways = |row: usize, _: f64, _: f64| {
            1.5 * (std::f64::consts::TAU * 3.0 * row as f64 / period + 0.7).sin()
        };
        let json = diagnosed(sways, &white(seed), seed);
        let wave = "a * sin(360 [deg] * t_s / period) + b * cos(360 [deg] * t_s / period)";
        described_as_what_happened_once(&json, wave);
        holds(&json["effects"][0], &[("period", period)]);
    }
}

#[test]
fn a_sensitivity_that_drifts_is_no_physics_of_the_device() {
    for seed in [1, 2] {
        let drifts = |row: usize, angle: f64, _: f64| 0.008 * row as f64 * angle;
        let json = diagnosed(drifts, &white(seed), seed);
        described_as_what_happened_once(&json, "k * angle * (t_s - mean(t_s)) + c * t_s");
    }
}

#[test]
fn what_lets_go_at_a_temperature_is_no_two_steps() {
    for (seed, at) in [(1, 25.6), (2, 26.2), (3, 26.8), (5, 28.0), (6, 28.6)] {
        let json = diagnosed(|_, _, t| 1.2 * ((t - at) / 0.5_f64).tanh(), &white(seed), seed);
        let effects = json["effects"].as_array().expect("effects");
        assert!(effects.iter().all(|effect| effect["kind"] == "empirical"), "at {at} °C: {effects:?}");
        assert_ne!(json["verdict"], "explained");
        assert_eq!(said(&json).1, "temperature_c", "at {at} °C");
    }
}

#[test]
fn a_threshold_between_two_temperatures_is_put_in_their_middle() {
    for seed in 1..=3 {
        let (scene, mut draw) = (scene(), normal(seed));
        let path = recording(scene.folder.path(), "r.csv", 7, |row, cells| {
            // Up and down from 14 to 38 °C, and quickly from 22 to 30 °C: nothing is read between them.
            let part = ((row as f64 / 41.0) % 2.0 - 1.0).abs();
            let temperature = 14.0 + 16.0 * part + if part < 0.5 { 0.0 } else { 8.0 };
            let angle = if row / 31 % 2 == 0 { row % 31 } else { 30 - row % 31 };
            let angle = 360.0 * angle as f64 - 5400.0;
            let lets_go = 2.5 * ((temperature - 26.0) / 0.6_f64).tanh();
            cells[5] = format!("{:.3}", 0.97 * angle - lets_go + 0.5 * draw());
            cells[6] = format!("{temperature:.3}");
        });
        let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let json = scene.json(&out, "r");
        assert_eq!(json["effects"][0]["formula"], "k * tanh((temperature_c - at) / width)", "{seed}");
        let parameters = json["effects"][0]["parameters"].as_array().expect("parameters");
        let at = parameters.iter().find(|p| p["name"] == "at").and_then(|p| p["value"].as_f64());
        assert!(at.is_some_and(|at| (25.0..27.0).contains(&at)), "seed {seed}: {at:?} °C");
    }
}

#[test]
fn a_leak_of_one_sign_is_handed_on_with_its_square() {
    let (scene, mut draw) = (scene(), normal(3));
    let path = recording(scene.folder.path(), "r.csv", 6, |row, cells| {
        let cross = 1.0 + 0.7 * (0.37 * row as f64).sin();
        let angle = if row / 31 % 2 == 0 { row % 31 } else { 30 - row % 31 };
        let angle = 360.0 * angle as f64 - 5400.0;
        cells[5] = format!("{:.3}", 0.97 * angle - 0.9 * cross + 0.5 * draw());
        cells.push(format!("{cross:.4}"));
    });
    let text = std::fs::read_to_string(&path).expect("a recording");
    std::fs::write(&path, text.replacen("temperature_c", "temperature_c,cross_arcsec", 1)).expect("a file");
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "r");
    assert_eq!(said(&json).0, "explained [\"cross_axis_coupling\"]");
    let sentences = json["unidentifiable"].as_array().expect("sentences");
    let is_mean =
        |s: &Value| s.as_str().is_some_and(|s| s.contains("square_cross_arcsec") && s.contains("their mean"));
    assert!(sentences.iter().any(is_mean), "{sentences:?}");
}

#[test]
fn a_fan_that_a_thermostat_switches_is_described() {
    // On above 30 °C, off below 20 °C; what it cools follows within 10 s.
    let (mut runs, mut cooled) = (false, 0.0);
    let cooled = over_schedule(|_, t| {
        runs = t > 30.0 || runs && t > 20.0;
        cooled += 0.26 * (f64::from(u8::from(runs)) - cooled);
        cooled
    });
    for seed in [1, 2] {
        let json = diagnosed(|row, _, _| 8.0 * cooled[row], &white(seed), seed);
        let formula = json["effects"][0]["formula"].as_str().unwrap_or_default();
        assert!(formula.starts_with("k * lowpass(tanh(20 * (play(temperature_c, r) - at)"), "{json}");
        assert_eq!(json["verdict"], "described", "{seed}");
    }
}

#[test]
fn two_bodies_are_no_lag_beside_a_drift() {
    let (mut fast, mut slow) = (15.0, 15.0);
    let apart = over_schedule(|_, t| {
        fast += (t - fast) * (1.0 - f64::exp(-3.0 / 40.0));
        slow += (fast - slow) * (1.0 - f64::exp(-3.0 / 250.0));
        fast - slow
    });
    for seed in [1, 2] {
        let json = diagnosed(|row, _, _| 0.5 * apart[row], &white(seed), seed);
        let effect = &json["effects"][0];
        let formula = "k * (lowpass(temperature_c, fast) - lowpass(lowpass(temperature_c, fast), slow))";
        assert_eq!(effect["formula"], formula, "{json}");
        assert_eq!(json["verdict"], "described", "{seed}");
        holds(effect, &[("fast", 40.0), ("slow", 250.0)]);
    }
}

#[test]
fn what_the_furthest_excursions_leave_is_described() {
    // 8 arcsec beyond ±1.3°, of the sign of the last such excursion, fading to a third within half a degree from its end.
    let mut end: f64 = 0.0;
    let left = over_schedule(|angle, _| {
        if angle.abs() > 1.3 && (angle.abs() > end.abs() || angle * end < 0.0) {
            end = angle;
        }
        if end == 0.0 { 0.0 } else { end.signum() * (-(angle - end).abs() / 0.45).exp() }
    });
    for seed in [1, 2] {
        let json = diagnosed(|row, _, _| 8.0 * left[row], &white(seed), seed);
        let effect = &json["effects"][0];
        assert!(effect["formula"].as_str().unwrap_or_default().ends_with(" - r) / width)"), "{json}");
        assert_eq!(json["verdict"], "described", "{seed}");
        holds(effect, &[("k", 8.0), ("width", 0.45 * 3600.0)]);
    }
}

#[test]
fn what_is_alike_after_both_turns_is_described() {
    // 8 arcsec at a turn, a third of it a quarter of a degree on.
    let fades = |row: usize| 8.0 * (-0.1 * (row % 31) as f64 / 0.25).exp();
    for seed in [1, 2] {
        let json = diagnosed(|row, _, _| fades(row), &white(seed), seed);
        let formula = "k * exp(-2 * (1 + direction * (angle - play(angle, r)) / r))";
        assert_eq!(json["effects"][0]["formula"], formula, "{json}");
        assert_eq!(json["verdict"], "described", "{seed}");
    }
}

#[test]
fn a_ripple_of_one_direction_is_described() {
    let ripple = |row: usize, angle: f64| {
        if (row / 31).is_multiple_of(2) { 3.0 * (std::f64::consts::TAU * angle / 0.45).sin() } else { 0.0 }
    };
    for seed in [1, 2] {
        let json = diagnosed(|row, angle, _| ripple(row, angle), &white(seed), seed);
        let effect = &json["effects"][0];
        let formula = effect["formula"].as_str().unwrap_or_default();
        assert!(formula.starts_with("(a + c * direction) * sin(360 [deg] * angle / period)"), "{json}");
        assert_eq!(json["verdict"], "described", "{seed}");
        holds(effect, &[("period", 0.45 * 3600.0)]);
    }
}

#[test]
fn what_has_no_form_is_described_by_a_curve() {
    // Two humps, as of a coating that changes its phase at 20 and 33 °C.
    let hump = |t: f64, at: f64, width: f64| (-((t - at) / width).powi(2)).exp();
    let json = diagnosed(|_, _, t| 6.0 * hump(t, 20.0, 3.0) + 9.0 * hump(t, 33.0, 3.5), &white(1), 1);
    let effect = &json["effects"][0];
    assert!(effect["formula"].as_str().unwrap_or_default().starts_with("table(temperature_c, "), "{json}");
    assert_eq!((effect["kind"].as_str(), json["verdict"].as_str()), (Some("empirical"), Some("described")));
    let left = json["fit"]["after"]["held_out_rms"].as_f64().expect("held-out rows");
    assert!(left < 1.3 * json["noise_floor"]["value"].as_f64().expect("a floor"), "{json}");
}

#[test]
fn what_names_leave_is_not_taken_for_memory() {
    // Heat that goes with the square of the angle and dies away in 100 s, in correlated noise for 7 s.
    let mut heat = 0.0;
    let heats = over_schedule(|angle, _| {
        heat += (3.0 / 100.0) * ((angle / 1.5).powi(2) - heat);
        heat
    });
    for seed in [13, 35] {
        let json = diagnosed(|row, _, _| 5.0 * heats[row], &wandering(186, seed), seed);
        // A form or structure without a form, but no name for all of it.
        let verdict = json["verdict"].as_str().expect("a verdict");
        assert!(["described", "partly_explained"].contains(&verdict), "{seed}: {verdict}");
    }
}

#[test]
fn a_defect_between_two_starts_is_no_probe_at_its_end() {
    let defect = |_: usize, angle: f64, _: f64| -5.0 * (-0.5 * ((angle - 1.02) / 0.15_f64).powi(2)).exp();
    let json = diagnosed(defect, &white(8), 8);
    assert_eq!(said(&json), ("explained [\"local_defect\"]".into(), "angle_deg".into()));
}

#[test]
fn a_ripple_whose_phase_moves_with_the_temperature_is_not_taken_for_noise() {
    for (seed, per_degree) in [(1, 0.0), (2, 0.03), (3, 0.06)] {
        let ripple = |_, angle: f64, t: f64| {
            5.0 * (std::f64::consts::TAU * angle / 0.37 + per_degree * (t - 27.0)).sin()
        };
        let json = diagnosed(ripple, &white(seed), seed);
        let floor = json["noise_floor"]["value"].as_f64().expect("a floor");
        assert!(floor < 0.65, "the floor at {per_degree} per K is {floor}");
        if per_degree == 0.0 {
            assert_eq!(said(&json), (r#"explained ["periodic_error"]"#.into(), "angle_deg".into()));
            continue;
        }
        assert_eq!(json["verdict"], "described", "{per_degree} per K");
        let places = json["locations"].as_array().expect("places");
        let moves = |place: &Value| place["variable"] == "temperature_c" && place["times"] == "angle_deg";
        assert!(places.iter().any(moves), "{places:?}");
    }
}

#[test]
fn a_ripple_that_the_temperature_moves_by_more_than_its_period_is_described() {
    // By 0.2 rad a kelvin, over 24 K.
    for seed in [1, 2] {
        let ripple =
            |_, angle: f64, t: f64| 3.0 * (std::f64::consts::TAU * angle / 0.7 + 0.2 * (t - 27.0)).sin();
        let json = diagnosed(ripple, &white(seed), seed);
        assert_eq!(said(&json), (r#"described ["empirical_1"]"#.into(), "temperature_c".into()), "{json}");
        let per_kelvin = 0.2_f64.to_degrees();
        let phase = &json["effects"][0]["parameters"].as_array().expect("parameters")[3];
        let [low, high] = [0, 1].map(|end| phase["ci95"][end].as_f64().expect("an end"));
        assert_eq!(phase["name"], "phase");
        assert!((low..high).contains(&per_kelvin) && high - low < 0.2 * per_kelvin, "{phase}");
    }
}

#[test]
fn what_fades_after_a_turn_is_described_whatever_direction_a_stage_at_rest_claims() {
    // The strain of a seal: dragged over where the stage is on its way back, not before the first turn.
    let strain = |row: usize| -> f64 {
        let turns =
            (1..=row.saturating_sub(1) / 31).map(|pass| (if pass % 2 == 0 { 1.0 } else { -1.0 }, pass));
        turns
            .map(|(heading, pass)| heading * (-(3.0 * row as f64 - 93.0 * pass as f64 - 1.5) / 30.0).exp())
            .sum()
    };
    let scene = scene();
    let noise = white(3);
    let rows = schedule();
    let path = recording(scene.folder.path(), "r.csv", 6, |row, cells| {
        cells[5] = format!("{:.3}", 3600.0 * rows[row].0 * 0.97 - 4.0 * strain(row) + noise[row]);
        // At the first stop of a pass the stage stands still.
        if row % 31 == 0 && row % 2 == 0 {
            cells[2] = if cells[2] == "1" { "-1".into() } else { "1".into() };
        }
    });
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "r");
    assert_eq!(json["effects"][0]["title"], "fades in time after the motion turned", "{json}");
    holds(&json["effects"][0], &[("k", 2.0), ("tau", 30.0)]);
}

/// Without the held-out readings the places of the jumps are found again beside the sensor's curve. Beside a straight line they
/// followed the curve, and 1.02e-4 and 1.05e-4 mm of the held-out readings were left.
#[test]
fn places_are_found_again_beside_the_curve_of_a_sensor() {
    let scene = scene();
    std::fs::write(&scene.mirror, "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n").expect("a file");
    for seed in [3, 9] {
        let (mut noise, mut seat) = (normal(seed), -1.0);
        let mut text = String::from("t_s,pass,direction,measured,reference\n");
        for row in 0..488 {
            let (pass, k) = (row / 61, row % 61);
            let direction = if pass % 2 == 0 { 1.0 } else { -1.0 };
            let x = direction * (f64::from(k) / 30.0 - 1.0);
            if direction * x > if direction > 0.0 { 0.6 } else { 0.4 } {
                seat = direction;
            }
            let curve = 0.02 * x.powi(3) - 0.03 * x.powi(2) + 0.03 * x.powi(4);
            let error = curve + 7e-5 * seat + 1e-4 * noise();
            writeln!(text, "{}.0,{},{direction},{:.7},{x:.7}", 2 * row, pass + 1, x + error).expect("text");
        }
        let path = scene.folder.path().join("stage.csv");
        std::fs::write(&path, text).expect("a file");
        let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let json = scene.json(&out, "stage");
        assert_eq!(
            json["effects"][0]["title"], "jumps between two values at two places, one each way",
            "{json}"
        );
        let after = &json["fit"]["after"]["held_out_rms"];
        assert!(after.as_f64().expect("held out") < 1.015e-4, "{}", json["fit"]);
    }
}

#[test]
fn bits_of_a_converter_are_no_wave() {
    let bits = |angle: f64| {
        let code = ((angle + 1.55) / 0.2).floor() as u32;
        let weigh = |(bit, weight): (u32, f64)| weight * f64::from(code >> bit & 1);
        (0..).zip([2.5, -3.5, 4.5, 1.5]).map(weigh).sum::<f64>()
    };
    let json = diagnosed(|_, angle, _| bits(angle), &white(9), 9);
    let effects = json["effects"].as_array().expect("effects");
    assert_eq!(effects[0]["title"], "jumps where three bits of a number change", "{json}");
    let rms = |model: &str| json["fit"][model]["held_out_rms"].as_f64().expect("held out");
    assert!(rms("before") > 1.2 && rms("after") < 0.7, "{}", json["fit"]);
}

#[test]
fn what_a_coil_heats_is_described_handed_on_and_limited_beyond_what_was_recorded() {
    let scene = scene();
    let mut noise = normal(79);
    // Cold at the first row.
    let (mut heat, mut power) = (0.0, 0.0);
    let rows = schedule();
    let path = recording(scene.folder.path(), "coil.csv", 6, |row, cells| {
        let current = 0.3 * (row as f64 / 17.0).sin() + if row % 62 < 31 { 0.2 } else { -0.1 };
        let before = std::mem::replace(&mut power, current * current);
        if row > 0 {
            heat += (1.0 - f64::exp(-3.0 / 90.0)) * (0.5 * (before + power) - heat);
        }
        cells[5] = format!("{:.3}", 3600.0 * rows[row].0 * 0.97 - 60.0 * heat + 0.5 * noise());
        cells.push(format!("{current:.5}"));
    });
    let text = std::fs::read_to_string(&path).expect("a recording");
    std::fs::write(&path, text.replacen("temperature_c", "temperature_c,coil_a", 1)).expect("a file");
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "coil");
    assert_eq!(json["verdict"], "described", "{json}");
    let effect = &json["effects"][0];
    assert_eq!((&effect["id"], &effect["kind"]), (&"empirical_1".into(), &"empirical".into()));
    assert_eq!(effect["formula"], "k * lowpass(coil_a^2, tau, 0 [A^2])", "it was cold");
    assert!(effect["readings"][0].as_str().expect("a suggestion").contains("power of coil_a"), "{effect}");
    holds(effect, &[("k", 60.0), ("tau", 90.0)]);
    // It goes on for a quarter of the recorded range: the current is between -0.4 and 0.5 A.
    let file = std::fs::read_to_string(out.join("coil.coefficients.json")).expect("coefficients");
    let file: Value = serde_json::from_str(&file).expect("JSON");
    let term = file["terms"].as_array().expect("terms").iter().find(|term| term["scope"] == "device");
    let operator = &term.expect("a term")["operator"];
    assert_eq!(operator["text"], effect["formula"], "others are cold as well");
    let limits = &operator["limits"]["coil_a"];
    for (end, recorded, beyond) in [(0, -0.4, -0.225), (1, 0.5, 0.225)] {
        let limit = limits[end].as_f64().expect("a limit");
        assert!((limit - recorded - beyond).abs() < 0.01, "{limits}");
    }
    // The declaration is what `--effects` reads.
    let declared = scene.folder.path().join("mine.toml");
    std::fs::write(&declared, effect["declaration"].as_str().expect("a declaration")).expect("a file");
    let declared = declared.to_str().expect("a path").to_owned();
    let (output, out) = scene.diagnose(&[&path], &["--no-report", "--effects", &declared]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(scene.json(&out, "coil")["verdict"], "explained");
    let file = std::fs::read_to_string(out.join("coil.coefficients.json")).expect("coefficients");
    assert!(!file.contains("\"limits\""), "a declared effect is not limited");
    // The cheapest routine of a core computes it, within its bound over any sequence.
    let path = |name: &str| scene.folder.path().join(name).to_str().expect("a path").to_owned();
    let (coefficients, firmware) = (path("out/coil.coefficients.json"), path("firmware"));
    let options = ["--further", "coil_a=-0.38..0.48", "--period-s", "0.001", "--target", "cortex-m4f"];
    for command in ["generate", "verify"] {
        let files = [command, "--coefficients", &coefficients, "--out", &firmware];
        let done = arcsmith(&[&files[..], &options[..]].concat());
        let said = String::from_utf8_lossy(&done.stdout) + String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{command}: {said}");
    }
}

#[test]
fn a_form_that_is_not_handed_on_is_said_all_the_same() {
    for seed in [2, 4] {
        let json = diagnosed(|_, _, t| 0.003 * (t - 27.0).powi(2), &white(seed), seed);
        let formula =
            "k * (temperature_c - mean(temperature_c)) + c * (temperature_c - mean(temperature_c))^2";
        assert_eq!(json["effects"][0]["formula"], formula, "{json}");
        assert_eq!(json["verdict"], "described", "{seed}");
        let (before, after) = (&json["fit"]["before"]["train_rms"], &json["fit"]["after"]["train_rms"]);
        assert_eq!(before, after, "the base alone is handed on");
    }
}
