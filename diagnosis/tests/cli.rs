//! The program from outside: what it writes, and how it refuses bad input.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const MIRROR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diagnose")).args(arguments).output().expect("the program runs")
}

/// Two passes and more over ±1.5° with a deterministic scatter; `edit` may change a row's cells.
fn recording(folder: &Path, name: &str, passes: usize, edit: impl Fn(usize, &mut Vec<String>)) -> PathBuf {
    let mut text = String::from("t_s,pass,direction,x1_mm,x2_mm,reference_arcsec,temperature_c\n");
    let mut state: u64 = 7;
    let mut scatter = || {
        // A linear congruential generator is random enough for a scatter (Knuth's constants).
        let mut sum = 0.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum - 6.0
    };
    let mut row = 0;
    for pass in 0..passes {
        for k in 0..31 {
            let forward = pass % 2 == 0;
            let angle = if forward { -1.5 + 0.1 * k as f64 } else { 1.5 - 0.1 * k as f64 };
            let s = 12.0 * f64::to_radians(angle).tan();
            let reference = 3600.0 * angle * 0.97 + 0.5 * scatter();
            let mut cells = vec![
                format!("{:.2}", 3.0 * row as f64),
                pass.to_string(),
                if forward { "1" } else { "-1" }.to_string(),
                format!("{:.7}", -0.5 * s),
                format!("{:.7}", 0.5 * s),
                format!("{reference:.3}"),
                format!("{:.3}", 25.0 + 0.2 * scatter()),
            ];
            edit(row, &mut cells);
            text += &(cells.join(",") + "\n");
            row += 1;
        }
    }
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

struct Scene {
    folder: tempfile::TempDir,
    mirror: String,
}

fn scene() -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    let mirror = folder.path().join("mirror.toml");
    std::fs::write(&mirror, MIRROR).expect("a file");
    Scene { mirror: mirror.display().to_string(), folder }
}

impl Scene {
    fn diagnose(&self, recordings: &[&Path], more: &[&str]) -> (Output, PathBuf) {
        let out = self.folder.path().join("out");
        let paths: Vec<String> = recordings.iter().map(|p| p.display().to_string()).collect();
        let out_text = out.display().to_string();
        let mut arguments: Vec<&str> = paths.iter().map(String::as_str).collect();
        arguments.extend(["--mirror", &self.mirror, "--out", &out_text]);
        arguments.extend(more);
        (run(&arguments), out)
    }

    fn json(&self, out: &Path, stem: &str) -> serde_json::Value {
        let text = std::fs::read_to_string(out.join(format!("{stem}.json"))).expect("the diagnosis");
        serde_json::from_str(&text).expect("JSON")
    }
}

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
fn what_cannot_be_concluded_is_said() {
    let blank = |row: usize, cells: &mut Vec<String>| {
        if row == 20 {
            cells[6] = String::new();
        }
    };
    let constant = |_: usize, cells: &mut Vec<String>| cells[6] = "25.0".into();
    let zero = |_: usize, cells: &mut Vec<String>| cells[6] = "0".into();
    let backward = |row: usize, cells: &mut Vec<String>| {
        if row == 50 {
            cells[0] = "12".into();
        }
    };
    let gap = |row: usize, cells: &mut Vec<String>| {
        if row >= 90 {
            cells[0] = format!("{}", 3 * row + 4000);
        }
    };
    type Edit<'a> = &'a dyn Fn(usize, &mut Vec<String>);
    let cases: [(Edit, &str); 5] = [
        (&blank, "blank"),
        (&constant, "constant"),
        (&zero, "all zero"),
        (&backward, "backward"),
        (&gap, "gap"),
    ];
    for (edit, word) in cases {
        let scene = scene();
        let path = recording(scene.folder.path(), "r.csv", 6, edit);
        let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
        assert!(output.status.success(), "{word}: {}", String::from_utf8_lossy(&output.stderr));
        let said = scene.json(&out, "r")["unidentifiable"].to_string();
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn one_direction_and_one_pass_are_said() {
    let scene = scene();
    let path = recording(scene.folder.path(), "one.csv", 1, |_, _| {});
    let (output, out) = scene.diagnose(&[&path], &["--no-report"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = scene.json(&out, "one");
    assert!(json["unidentifiable"].to_string().contains("lag, gain and backlash"));
    assert_eq!(json["noise_floor"]["from"], "blocks");
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
    assert!(String::from_utf8_lossy(&output.stderr).contains("dynamic"));
}
