//! Intervals where the likelihood has several maxima: beside a polynomial of order 9 on 18 positions a bump near the end
//! leaves nearly what one of the other sign beside it leaves.

mod common;

use common::{normal, recording, scene};

/// Height (arcsec), centre and width (deg) of the bump.
const BUMP: [f64; 3] = [-7.0, 1.237, 0.165];

/// Name, value and interval of every parameter of the first effect in a coarse recording of the bump: steps of 0.2°,
/// twelve passes, white noise of 0.5″.
fn parameters(seed: u64) -> (String, Vec<(String, f64, [f64; 2])>) {
    let mut draw = normal(seed);
    let noise: Vec<f64> = (0..217).map(|_| 0.5 * draw()).collect();
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", 7, |row, cells| {
        let (pass, k) = (row / 18, row % 18);
        let angle = if pass % 2 == 0 { -1.7 + 0.2 * k as f64 } else { 1.7 - 0.2 * k as f64 };
        let s = 12.0 * f64::to_radians(angle).tan();
        let bump = BUMP[0] * (-0.5 * ((angle - BUMP[1]) / BUMP[2]).powi(2)).exp();
        cells[1] = pass.to_string();
        cells[2] = if pass % 2 == 0 { "1" } else { "-1" }.to_string();
        cells[3] = format!("{:.7}", -0.5 * s);
        cells[4] = format!("{:.7}", 0.5 * s);
        cells[5] = format!("{:.3}", 3600.0 * angle * 0.97 - bump + noise[row]);
    });
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "r");
    let first = &json["effects"][0];
    let number = |v: &serde_json::Value| v.as_f64().expect("a number");
    let of = first["parameters"].as_array().into_iter().flatten();
    let told = of.map(|p| {
        let name = p["name"].as_str().unwrap_or_default().to_string();
        (name, number(&p["value"]), [number(&p["ci95"][0]), number(&p["ci95"][1])])
    });
    (first["id"].as_str().unwrap_or_default().to_string(), told.collect())
}

#[test]
fn an_interval_reaches_every_place_that_does_nearly_as_well() {
    let (mut named, mut held) = (0, [0; 3]);
    for seed in 1..=20 {
        let (id, told) = parameters(seed);
        if id != "local_defect" {
            continue;
        }
        named += 1;
        for ((name, value, [from, to]), (truth, held)) in told.iter().zip(BUMP.iter().zip(&mut held)) {
            assert!(from <= value && value <= to, "{name} {value} in [{from}, {to}]");
            *held += usize::from(from <= truth && truth <= to);
        }
    }
    println!("{named} named, height, centre and width held: {held:?}");
    // Of 20 intervals of 95 % fewer than 17 hold the truth in 1.6 % of such tests.
    assert!(named >= 10, "{named}");
    assert!(held.iter().all(|held| held + 3 >= named), "{held:?} of {named}");
}
