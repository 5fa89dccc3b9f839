//! The program from outside: what it writes, and how it refuses bad input.

use std::process::Command;

use std::path::Path;

use crate::diagnose::common::{recording, run, scene};

#[test]
fn a_quiet_recording_is_consistent_and_everything_is_written() {
    let scene = scene();
    let path = recording(scene.folder.path(), "quiet.csv", 6, |_, _| {});
    let (output, out) = scene.diagnose(&[&path], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "quiet");
    assert_eq!(json["schema"], 1);
    assert_eq!(json["verdict"], "consistent");
    assert_eq!(json["effects"].as_array().map(Vec::len), Some(0));
    let page = std::fs::read_to_string(out.join("quiet.html")).expect("the report");
    assert!(page.contains("<svg") && page.contains("agrees with its simulation"));
    assert!(!page.contains("could not be rendered"));
    assert!(fitter::coefficients::read(&out.join("quiet.coefficients.json")).is_ok());
}

#[test]
fn the_page_shows_what_each_of_two_steps_adds() {
    let scene = scene();
    let path = recording(scene.folder.path(), "steps.csv", 6, |row, cells| {
        let value: f64 = cells[5].parse().expect("a number");
        let moved = if row < 60 { 0.0 } else { 4.0 } + if row < 130 { 0.0 } else { 3.0 };
        cells[5] = format!("{:.3}", value - moved);
    });
    let (output, out) = scene.diagnose(&[&path], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = std::fs::read_to_string(out.join("steps.html")).expect("the report");
    let (_, adds) = page.split_once("What the effects add").expect("the section");
    let (adds, _) = adds.split_once("Residual before and after").expect("the next section");
    assert_eq!(adds.matches("<svg").count(), 2, "one chart for each step");
}

#[test]
fn a_step_is_named_with_its_time() {
    let scene = scene();
    let path = recording(scene.folder.path(), "step.csv", 6, |row, cells| {
        if row >= 100 {
            let value: f64 = cells[5].parse().expect("a number");
            cells[5] = format!("{:.3}", value - 3.0);
        }
    });
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success());
    let json = scene.json(&out, "step");
    assert_eq!(json["effects"][0]["id"], "mount_step");
    assert_eq!(json["effects"][0]["runtime_correctable"], false);
    let parameter = |k: usize| json["effects"][0]["parameters"][k]["value"].as_f64().unwrap_or(f64::NAN);
    // The reference falls by 3″, the error rises; 93 rows a side at 0.5″ give 0.07″, here four of that.
    assert!((parameter(0) - 3.0).abs() < 0.3, "{}", parameter(0));
    // Row 100 is at 300 s, its predecessor at 297 s.
    assert!((297.0..=300.0).contains(&parameter(1)), "{}", parameter(1));
    assert!(!out.join("step.html").exists());
    let file = fitter::coefficients::read(&out.join("step.coefficients.json")).expect("coefficients");
    assert_eq!(file.terms.len(), 1);
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let scene = scene();
    let drift = |row: usize, cells: &mut Vec<String>| {
        let value: f64 = cells[5].parse().unwrap_or(0.0);
        cells[5] = format!("{:.3}", value + 0.02 * row as f64);
    };
    let path = recording(scene.folder.path(), "drift.csv", 6, drift);
    let mut seen = Vec::new();
    for jobs in ["1", "2"] {
        let (output, out) = scene.diagnose(&[&path], &["--jobs", jobs]);
        assert!(output.status.success());
        let read = |end: &str| std::fs::read(out.join(format!("drift.{end}"))).expect("a file");
        seen.push((read("json"), read("coefficients.json"), read("html")));
    }
    assert_eq!(seen[0], seen[1]);
}

#[test]
fn bad_calls_are_refused_with_one_message_and_nothing_written() {
    let scene = scene();
    let good = recording(scene.folder.path(), "r.csv", 6, |_, _| {});
    let short = scene.folder.path().join("short.csv");
    let text = std::fs::read_to_string(&good).expect("a file");
    let lines: Vec<&str> = text.lines().take(9).collect();
    std::fs::write(&short, lines.join("\n")).expect("a file");
    let simulation = scene.folder.path().join("simulation.csv");
    std::fs::write(&simulation, "t_s,reference_arcsec\n0,1\n").expect("a file");
    let simulation = simulation.display().to_string();
    let cases: [(Vec<&Path>, Vec<&str>, &str); 5] = [
        (vec![&good, &good], vec![], "both would be written"),
        (vec![&short], vec![], "too short"),
        (vec![&good], vec!["--simulated", &simulation], "1 rows"),
        (vec![&good], vec!["--without", "gremlins"], "gremlins"),
        (vec![Path::new("nowhere.csv")], vec![], "nowhere.csv"),
    ];
    for (recordings, more, word) in cases {
        let (output, out) = scene.diagnose(&recordings, &more);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{word}: {message}");
        assert!(message.contains(word), "{word}: {message}");
        assert!(!out.exists(), "{word}: something was written");
    }
    let out = scene.folder.path().join("out").display().to_string();
    let output = run(&[&good.display().to_string(), "--plant", "plant.toml", "--out", &out]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("plant.toml"));
}

#[test]
fn play_of_either_sense_is_named_with_the_side_of_the_sensor() {
    let scene = scene();
    for (name, sense, side) in [("ahead", 1.0, "driving side"), ("behind", -1.0, "on the load")] {
        let path = recording(scene.folder.path(), &format!("{name}.csv"), 6, |row, cells| {
            let direction: f64 = cells[2].parse().expect("a direction");
            let reference: f64 = cells[5].parse().expect("a number");
            // A pass begins where the last one ended: nothing has turned yet.
            let moved = if row > 0 && row % 31 == 0 { -direction } else { direction };
            cells[5] = format!("{:.3}", reference - sense * moved);
        });
        // At one speed and without commands a lag is the same.
        let (output, out) = scene.diagnose(&[&path], &["--no-report", "--without", "read_lag"]);
        assert!(output.status.success());
        let json = scene.json(&out, name);
        let effect = &json["effects"][0];
        assert_eq!(effect["id"], "backlash", "{name}: {json}");
        assert!(effect["title"].as_str().is_some_and(|title| title.contains(side)), "{name}: {json}");
        // Half a distance of 2″ between the directions; 93 rows a side at 0.5″ give 0.04″, here four of that.
        let half_width = effect["parameters"][0]["value"].as_f64().unwrap_or(f64::NAN);
        assert!((half_width - 1.0).abs() < 0.15, "{name}: {half_width}");
    }
}

#[test]
fn the_catalogue_is_printed_without_a_recording() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_arcsmith")).arg("effects").output().expect("the program runs");
    assert!(output.status.success());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(text.matches("\n- adds to the angular error: ").count(), 16);
}
