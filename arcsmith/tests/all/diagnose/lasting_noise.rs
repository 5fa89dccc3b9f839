//! Noise that outlasts a pass: it makes dependences on whatever changed slowly, which no firmware may get.

use crate::diagnose::common::{normal, recording, scene};

/// What is exported to other recordings of twelve passes of 31 rows, read every 3 s in white noise of 0.5″ beside a level that
/// switches between ±2″ every 100 s in the mean, in a room that drifts; the reference reads `per_degree` (″/K) too much.
fn exported(per_degree: f64, seed: u64) -> Vec<String> {
    let (mut noise, mut room, mut level) = (normal(seed), normal(seed + 1000), 2.0);
    let mut switch = normal(seed + 2000);
    let mut temperature = 25.0;
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", 12, |row, cells| {
        let (pass, k) = (row / 31, row % 31);
        let angle = if pass % 2 == 0 { -1.5 + 0.1 * k as f64 } else { 1.5 - 0.1 * k as f64 };
        // Beyond 1.88 deviations lie three of a hundred: a switch every hundred seconds.
        if switch() > 1.88 {
            level = -level;
        }
        temperature += 0.1 * room();
        cells[5] = format!(
            "{:.3}",
            3600.0 * angle * 0.97 + per_degree * (temperature - 25.0) + level + 0.5 * noise()
        );
        cells[6] = format!("{temperature:.4}");
    });
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(out.join("r.coefficients.json")).expect("coefficients");
    let file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let terms = file["terms"].as_array().map_or(&[][..], Vec::as_slice);
    let lasting = terms.iter().filter(|term| term["scope"] == "device");
    lasting.map(|term| term["effect"].as_str().expect("an effect").to_string()).collect()
}

#[test]
fn what_switches_by_itself_reaches_no_firmware() {
    // In the last one a hysteresis stands out of noise of one time constant.
    for seed in [1, 39] {
        assert_eq!(exported(0.0, seed), [""; 0], "seed {seed}");
    }
}

#[test]
fn a_dependence_beyond_such_noise_does() {
    for seed in [1, 2] {
        assert_eq!(exported(4.0, seed), ["thermal_zero_drift"], "seed {seed}");
    }
}
