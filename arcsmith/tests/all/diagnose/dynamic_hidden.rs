//! What a search finds late or not at all: physics that is in no catalogue and that named effects imitate, a limit
//! that is reached once, an effect that another holds as a special case.

use std::cell::Cell;

use crate::diagnose::moving::{STEP_S, Scatter, Scene, csv, ids, made, moved, several};

const ROWS: usize = 8000;

/// Drives that all sines of [`several`] take part in, with no period in the recording.
fn drives() -> impl Iterator<Item = f64> {
    (0..ROWS).map(|k| several(2.3 * k as f64 * STEP_S))
}

/// A hum is a tone that the drive does not hold: no mode, and never explained.
#[test]
fn a_hum_is_unexplained_at_its_frequency() {
    let scene = Scene::new();
    let hum = |k: usize| 0.006 * (std::f64::consts::TAU * 49.97 * k as f64 * STEP_S + 1.0).sin();
    let rows = moved(drives().enumerate().map(|(k, u)| u + hum(k)), 0.9, |_, _| 0.0);
    let rows: Vec<(f64, f64)> = drives().zip(rows).map(|(u, (_, x))| (u, x)).collect();
    let recording = scene.write("hum.csv", &csv(&rows));
    assert!(scene.diagnose(&recording, &[]).status.success());
    let diagnosis = scene.json("hum");
    assert_eq!(diagnosis["verdict"], "unexplained", "{diagnosis}");
    let place = &diagnosis["locations"][0];
    assert_eq!(place["variable"], "frequency_hz", "{diagnosis}");
    let at = |end: &str| place[end].as_f64().expect("a frequency");
    assert!(at("from") < 49.97 && at("to") > 49.97 && at("to") - at("from") < 1.0, "{place}");
}

/// A stop that holds what has touched it is no stiffness, however many powers of the position imitate it.
#[test]
fn a_sticking_stop_is_given_no_name_without_periods() {
    let scene = Scene::new();
    let touched = Cell::new(false);
    // A second of it: what it holds is left in every stretch, and longer ones are searched for longer.
    let rows = moved(drives().take(2000), 0.9, |x, _| {
        let beyond = x - 600.0;
        touched.set(beyond > 0.0 || (touched.get() && beyond > -200.0));
        let pull = if touched.get() { 6e6 * (-beyond / 200.0).clamp(0.0, 1.0) } else { 0.0 };
        pull - 14_000.0 * beyond.max(0.0)
    });
    let recording = scene.write("stop.csv", &csv(&rows));
    assert!(scene.diagnose(&recording, &[]).status.success());
    let diagnosis = scene.json("stop");
    // Forms without a name may follow its contact, but not what it holds.
    let verdict = diagnosis["verdict"].as_str();
    assert!(matches!(verdict, Some("unexplained" | "partly_explained")), "{diagnosis}");
    let effects = diagnosis["effects"].as_array().expect("effects");
    assert!(effects.iter().all(|effect| effect["kind"] == "empirical"), "{diagnosis}");
    let place = diagnosis["locations"][0]["variable"].as_str();
    assert!(matches!(place, Some("position" | "history")), "{diagnosis}");
}

/// A limit that the drive reaches in one place alone, wherever that lies in the recording.
#[test]
fn a_limit_that_is_reached_once_is_named() {
    for place in [1, 3] {
        let scene = Scene::new();
        // At the beginning of a block of rows that, counted from the beginning, would not fit.
        let rows = 16_000;
        let middle = (rows / 64) as f64 * (place as f64 + 0.1);
        let pulse = |k: usize| (1.0 - ((k as f64 - middle) / 4.0).powi(2)).max(0.0);
        let drives = (0..rows).map(|k| several(2.3 * k as f64 * STEP_S));
        let asked: Vec<f64> = drives.enumerate().map(|(k, u)| u + 0.15 * pulse(k)).collect();
        let largest = asked.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        let limit = 0.985 * largest;
        let rows = moved(asked.iter().map(|u| u.clamp(-limit, limit)), 0.9, |_, _| 0.0);
        let rows: Vec<(f64, f64)> = asked.iter().zip(rows).map(|(u, (_, x))| (*u, x)).collect();
        let recording = scene.write("limit.csv", &csv(&rows));
        assert!(scene.diagnose(&recording, &[]).status.success());
        let diagnosis = scene.json("limit");
        assert_eq!(ids(&diagnosis), ["drive_saturation"], "{place}: {diagnosis}");
        let found = diagnosis["effects"][0]["parameters"][0]["value"].as_f64().expect("a limit");
        assert!((found / limit - 1.0).abs() < 0.01, "{found} {limit}");
    }
}

/// Coulomb's friction is Stribeck's where that falls nowhere; what was taken first gives way.
#[test]
fn stribeck_friction_under_steps_is_not_coulombs_with_others() {
    let scene = Scene::new();
    let mut scatter = Scatter(11);
    let (mut x, mut v, mut drive) = (0.0, 0.0_f64, 0.0);
    let rows: Vec<(f64, f64)> = (0..ROWS)
        .map(|k| {
            if k % 100 == 0 {
                drive = 0.09 * scatter.next();
            }
            let row = (drive, x + 0.9 * scatter.next());
            let h = STEP_S / 400.0;
            for _ in 0..400 {
                let pull: f64 = 6e8 * drive - 36_000.0 * x - 40.0 * v;
                if v == 0.0 && pull.abs() <= 6e6 {
                    break;
                }
                let way = if v == 0.0 { pull.signum() } else { v.signum() };
                let next = v + h * (pull - way * 3e6 * (1.0 + (-(v / 60_000.0).powi(2)).exp()));
                // Where the velocity passes zero it stays there, until the pull is too strong.
                v = if next * way < 0.0 { 0.0 } else { next };
                x += h * v;
            }
            row
        })
        .collect();
    let recording = scene.write("steps.csv", &csv(&rows));
    assert!(scene.diagnose(&recording, &[]).status.success());
    assert_eq!(ids(&scene.json("steps")), ["stribeck_friction"], "{}", scene.json("steps"));
}

/// The past of a residual that is nearly one tone predicts it: beside that, frequencies where there is nothing promise more.
#[test]
fn a_mode_close_to_the_resonance_is_named_in_correlated_noise() {
    let scene = Scene::new();
    let of = "--device-seed 7 --seed 2 --excitation sweep --samples 8192 --noise autocorrelated";
    let mode = "--effect flexible_mode:frequency_hz=20,mass_ratio=0.0003";
    let recording = scene.excited("mode.csv", &format!("{of} {mode}"));
    assert!(scene.diagnose(&recording, &[]).status.success());
    let diagnosis = scene.json("mode");
    assert_eq!((&diagnosis["verdict"], ids(&diagnosis)), (&"explained".into(), vec!["flexible_mode".into()]));
    let ci95 = &diagnosis["effects"][0]["parameters"][0]["ci95"];
    assert!(ci95[0].as_f64() < Some(20.0) && Some(20.0) < ci95[1].as_f64(), "{ci95}");
}

/// A weaker name does not fall with a stronger remedy: what is explained stays explained.
#[test]
fn a_true_effect_stays_explained_in_noise_that_is_alike() {
    let scene = Scene::new();
    let mut noise = Scatter(5);
    let mut last = 0.0;
    let rows: Vec<(f64, f64)> = made(ROWS, |x, _| -3e-5 * x * x * x)
        .into_iter()
        .map(|(u, x)| {
            last = 0.85 * last + 0.5 * noise.next();
            (u, x + last)
        })
        .collect();
    let recording = scene.write("alike.csv", &csv(&rows));
    assert!(scene.diagnose(&recording, &[]).status.success());
    assert_eq!(scene.json("alike")["verdict"], "explained", "{}", scene.json("alike"));
    assert_eq!(ids(&scene.json("alike")), ["cubic_stiffness"]);
}
