//! A step in correlated noise: it is told by the one reading at which it begins, so every row must be tried.

use crate::diagnose::common::{recording, scene, wandering};

/// Six passes of 31 rows, read every 3 s, with noise of 0.5″ and a correlation time of 7 s, and a step from
/// `first` on.
fn step_in_wandering_noise(first: usize, height: f64, seed: u64) -> (Vec<String>, f64) {
    let noise = wandering(186, seed);
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", 6, |row, cells| {
        let (pass, k) = (row / 31, row % 31);
        let angle = if pass % 2 == 0 { -1.5 + 0.1 * k as f64 } else { 1.5 - 0.1 * k as f64 };
        let step = if row >= first { height } else { 0.0 };
        cells[5] = format!("{:.3}", 3600.0 * angle * 0.97 - step + noise[row]);
    });
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "r");
    let effects = json["effects"].as_array().expect("effects");
    let ids = effects.iter().filter_map(|e| e["id"].as_str()).map(str::to_string).collect();
    let time = effects
        .iter()
        .flat_map(|e| e["parameters"].as_array().expect("parameters"))
        .find(|p| p["name"] == "time_s")
        .and_then(|p| p["value"].as_f64());
    (ids, time.unwrap_or(f64::NAN))
}

#[test]
fn a_step_is_named_at_whichever_row_it_begins() {
    for (first, seed) in [(93, 1), (101, 2), (62, 3), (127, 4), (64, 5), (155, 6), (45, 7), (109, 8)] {
        let (ids, time) = step_in_wandering_noise(first, 3.0, seed);
        let begins = 3.0 * (first as f64 - 0.5);
        assert_eq!(ids, ["mount_step"], "from row {first}");
        assert!((time - begins).abs() < 3.1, "from row {first}: {time} s for {begins} s");
    }
}
