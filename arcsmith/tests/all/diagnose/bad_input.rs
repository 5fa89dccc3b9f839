//! Recordings that cannot show everything: each is diagnosed all the same, and says what can and what cannot
//! be concluded from it.

use crate::diagnose::common::{recording, scene};
use serde_json::Value;

/// Diagnoses a recording whose cells were edited.
fn diagnosed(passes: usize, edit: impl Fn(usize, &mut Vec<String>)) -> Value {
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", passes, edit);
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    scene.json(&out, "r")
}

/// The sentence among what is not determined that holds all of `words`.
fn sentence(json: &Value, words: &[&str]) -> String {
    let all = json["unidentifiable"].as_array().expect("sentences");
    let found = all.iter().filter_map(Value::as_str).find(|s| words.iter().all(|w| s.contains(w)));
    found.unwrap_or_else(|| panic!("no sentence with {words:?} in {all:?}")).to_string()
}

/// A step of 3″ in the reference from row 100 on, which must be named whatever the temperature's column is.
fn with_step(row: usize, cells: &mut [String]) {
    if row >= 100 {
        let value: f64 = cells[5].parse().expect("a number");
        cells[5] = format!("{:.3}", value - 3.0);
    }
}

fn names(json: &Value) -> Vec<&str> {
    json["effects"].as_array().expect("effects").iter().filter_map(|e| e["id"].as_str()).collect()
}

#[test]
fn blanks_leave_out_what_needs_the_column_and_nothing_else() {
    let json = diagnosed(6, |row, cells| {
        with_step(row, cells);
        if row == 20 || row == 41 {
            cells[6] = String::new();
        }
    });
    let said = sentence(&json, &["temperature_c", "blank"]);
    assert!(said.contains("2 of 186 rows"), "{said}");
    sentence(&json, &["not testable: thermal_zero_drift, thermal_gain_drift, thermal_lag"]);
    assert_eq!(names(&json), ["mount_step"]);
}

#[test]
fn a_constant_column_is_no_evidence() {
    let json = diagnosed(6, |row, cells| {
        with_step(row, cells);
        cells[6] = "25.0".into();
    });
    sentence(&json, &["temperature_c", "constant at 25"]);
    assert_eq!(names(&json), ["mount_step"]);
}

#[test]
fn a_temperature_of_all_zeros_is_no_temperature() {
    let json = diagnosed(6, |row, cells| {
        with_step(row, cells);
        cells[6] = "0".into();
    });
    sentence(&json, &["temperature_c", "all zero"]);
    assert_eq!(names(&json), ["mount_step"]);
}

#[test]
fn a_thermometer_of_noise_alone_is_no_alternative_to_anything() {
    let json = diagnosed(6, |row, cells| {
        with_step(row, cells);
        // Scattered evenly over ±0.05 K from row to row.
        cells[6] = format!(
            "{:.3}",
            25.0 + 0.1
                * (((row * row * row * 7919 + row * row * 13 + row * 31) % 1009) as f64 / 1009.0 - 0.5)
        );
    });
    sentence(&json, &["temperature_c", "noise alone"]);
    sentence(&json, &["not testable: thermal_zero_drift, thermal_gain_drift, thermal_lag"]);
    assert_eq!(names(&json), ["mount_step"]);
    let alternatives = json["effects"][0]["alternatives"].as_array().expect("alternatives");
    assert!(alternatives.iter().all(|a| !a.as_str().is_some_and(|a| a.starts_with("thermal"))));
}

/// One wrong cell of any column: its row is named and left out, and nothing else changes.
#[test]
fn one_wrong_cell_is_listed_and_the_rest_diagnosed_as_without_it() {
    let wrong = |column: usize, value: &'static str| {
        let json = diagnosed(6, move |row, cells| {
            with_step(row, cells);
            if row == 50 {
                cells[column] = value.into();
            }
        });
        assert_eq!(names(&json), ["mount_step"], "{value}");
        let listed = json["bad_rows"].as_array().expect("bad rows");
        assert_eq!(listed.len(), 1, "{listed:?}");
        assert_eq!(listed[0]["line"], 52);
        listed[0]["column"].as_str().expect("a column").to_string()
    };
    assert_eq!(wrong(0, "12"), "t_s");
    assert_eq!(wrong(3, "-9999"), "x1_mm");
    assert_eq!(wrong(4, "99999"), "x2_mm");
    assert_eq!(wrong(5, "1e200"), "reference_arcsec");
    assert_eq!(wrong(6, "85"), "temperature_c");
}

#[test]
fn time_that_runs_backward_is_replaced_by_the_order_of_the_rows() {
    let json = diagnosed(6, |row, cells| {
        with_step(row, cells);
        if (50..60).contains(&row) {
            cells[0] = (3 * (110 - row)).to_string();
        }
    });
    sentence(&json, &["backward", "per row"]);
    // The step is still there, at its row.
    assert_eq!(names(&json), ["mount_step"]);
    let at = json["effects"][0]["parameters"][1]["value"].as_f64().expect("a time");
    assert!((at - 99.5).abs() < 1.5, "{at}");
}

#[test]
fn a_gap_in_time_is_said_with_its_length() {
    let json = diagnosed(6, |row, cells| {
        if row >= 90 {
            cells[0] = format!("{}", 3 * row + 4000);
        }
    });
    sentence(&json, &["gap of 4003 s"]);
    assert_eq!(json["verdict"], "consistent");
}

#[test]
fn passes_of_one_direction_cannot_separate_lag_gain_and_backlash() {
    // Only the forward passes of twelve.
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", 12, |_, _| {});
    let text = std::fs::read_to_string(&path).expect("a file");
    let forward: Vec<&str> =
        text.lines().filter(|l| l.split(',').nth(2).is_some_and(|d| d != "-1")).collect();
    std::fs::write(&path, forward.join("\n")).expect("a file");
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "r");
    sentence(&json, &["lag, gain and backlash"]);
    assert_eq!(json["noise_floor"]["from"], "repeated passes");
    assert_eq!(json["verdict"], "consistent");
    assert!(json["fit"]["after"]["held_out_rms"].is_f64());
}

#[test]
fn a_single_move_says_that_time_runs_with_the_angle() {
    let json = diagnosed(1, |_, _| {});
    sentence(&json, &["lag, gain and backlash"]);
    sentence(&json, &["one move only", "drift, warm-up and steps"]);
    assert_eq!(json["noise_floor"]["from"], "blocks");
}

#[test]
fn a_recording_too_short_to_hold_anything_out_says_so() {
    let scene = scene();
    let path = recording(scene.folder.path(), "r.csv", 1, |_, _| {});
    let text = std::fs::read_to_string(&path).expect("a file");
    let lines: Vec<&str> = text.lines().take(19).collect();
    std::fs::write(&path, lines.join("\n")).expect("a file");
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "r");
    sentence(&json, &["too short to hold anything out", "18 readings"]);
    assert!(json["fit"]["after"]["held_out_rms"].is_null());
}

#[test]
fn a_column_of_text_is_left_out_and_named() {
    let json = diagnosed(6, |_, cells| cells[6] = "warm".into());
    sentence(&json, &["temperature_c", "no numbers"]);
}
