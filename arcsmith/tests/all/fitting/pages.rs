//! What is written for people: mirror files and their schema, help, completions, manual pages, summaries.

use std::path::Path;
use std::process::{Command, Output};

use crate::fitting::common::Device;
use crate::fitting::common::encoder::Encoder;
use fitter::Mirror;
use serde_json::Value;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn init_writes_a_file_that_is_read_and_never_over_another() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, direct, revolution) in
        [("mirror", false, None), ("direct", true, None), ("encoder", true, Some(360.0))]
    {
        let out = format!("{kind}.toml");
        text(&run(folder.path(), &["init", "--kind", kind, "--out", &out]));
        let mirror = Mirror::read(&folder.path().join(&out)).unwrap();
        match mirror.sensor {
            fitter::Sensor::Direct { revolution: found, .. } => {
                assert_eq!((direct, found), (true, revolution))
            }
            fitter::Sensor::EddyCurrentPair { .. } => assert!(!direct && mirror == Mirror::paper()),
        }
        let written = std::fs::read_to_string(folder.path().join(&out)).unwrap();
        assert!(written.lines().filter(|line| line.starts_with('#')).count() >= 5, "{written}");
        let again = run(folder.path(), &["init", "--kind", kind, "--out", &out]);
        assert_eq!(again.status.code(), Some(2));
        assert!(String::from_utf8(again.stderr).unwrap().contains("is there already"));
        text(&run(folder.path(), &["init", "--kind", kind, "--out", &out, "--force"]));
    }
}

/// The part of JSON Schema that the mirror's schema is written in. An unknown keyword fails the test.
fn accepts(schema: &Value, value: &Value) -> bool {
    let object = schema.as_object().unwrap();
    object.iter().all(|(keyword, content)| match keyword.as_str() {
        "$schema" | "title" | "description" | "then" | "else" => true,
        "type" => match content.as_str().unwrap() {
            "object" => value.is_object(),
            "number" => value.is_number(),
            "string" => value.is_string(),
            other => panic!("type {other}"),
        },
        "properties" => value.as_object().is_none_or(|value| {
            content
                .as_object()
                .unwrap()
                .iter()
                .all(|(key, schema)| value.get(key).is_none_or(|v| accepts(schema, v)))
        }),
        "additionalProperties" => value.as_object().is_none_or(|value| {
            assert_eq!(*content, Value::Bool(false));
            value.keys().all(|key| object["properties"].get(key).is_some())
        }),
        "required" => value.as_object().is_none_or(|value| {
            content.as_array().unwrap().iter().all(|key| value.contains_key(key.as_str().unwrap()))
        }),
        "exclusiveMinimum" => value.as_f64().is_none_or(|v| v > content.as_f64().unwrap()),
        "enum" => content.as_array().unwrap().contains(value),
        "const" => content == value,
        "pattern" => {
            assert_eq!(content, "^[A-Za-z][A-Za-z0-9_]{0,23}$");
            value.as_str().is_none_or(fitter::text_safety::is_identifier)
        }
        "if" => accepts(if accepts(content, value) { &object["then"] } else { &object["else"] }, value),
        other => panic!("keyword {other}"),
    })
}

/// The schema and the reader take and refuse the same files.
#[test]
fn the_schema_says_what_the_reader_does() {
    let folder = tempfile::tempdir().unwrap();
    let schema: Value = serde_json::from_str(&text(&run(folder.path(), &["schema"]))).unwrap();
    let files = [
        fitter::mirror::PAIR_FILE,
        fitter::mirror::DIRECT_FILE,
        fitter::mirror::ENCODER_FILE,
        "",
        "[geometry]\nprobe_distance_mm = 12.0\n",
        "[geometry]\nprobe_distance_mm = 12\ninitial_gap_mm = 0.3\n",
        "[geometry]\nprobe_distance_mm = -12\ninitial_gap_mm = 0.3\n",
        "[geometry]\nprobe_distance_mm = \"12\"\ninitial_gap_mm = 0.3\n",
        "[geometry]\nprobe_distance_mm = 12\ninitial_gap_mm = 0.3\ngap = 1\n",
        "[geometrie]\n",
        "geometry = 3\n",
        "[sensor]\nkind = \"direct\"\n",
        "[sensor]\nkind = \"direct\"\nunit = \"µm\"\n",
        "[sensor]\nkind = \"direct\"\nunit = \"counts\"\nrevolution = 4096\n",
        "[sensor]\nkind = \"direct\"\nunit = \"counts\"\nrevolution = 0\n",
        "[sensor]\nkind = \"direct\"\nunit = \"counts\"\nturn = 4096\n",
        "[sensor]\nkind = \"resolver\"\nunit = \"deg\"\n",
        "[sensor]\nkind = \"eddy-current-pair\"\n",
        "[sensor]\nkind = \"eddy-current-pair\"\n[geometry]\nprobe_distance_mm = 12\ninitial_gap_mm = 0.3\n",
        "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n[reference]\naccuracy_arcsec = 0\n",
        "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n[reference]\naccuracy_arcsec = 1\n",
    ];
    let mut counts = [0, 0];
    for file in files {
        let value = serde_json::to_value(file.parse::<toml::Table>().unwrap()).unwrap();
        let read = Mirror::parse("mirror.toml", file).is_ok();
        assert_eq!(accepts(&schema, &value), read, "{file}");
        counts[usize::from(read)] += 1;
    }
    assert!(counts[0] >= 10 && counts[1] >= 6, "{counts:?}");
}

#[test]
fn help_has_examples_and_completions_and_pages_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let commands = ["fit", "apply", "report", "init", "schema", "completions", "man"];
    let help = text(&run(folder.path(), &["--help"]));
    for command in commands {
        assert!(help.contains(&format!("  {command}")), "{help}");
        if command != "schema" {
            let help = text(&run(folder.path(), &[command, "--help"]));
            assert!(help.contains("Examples:") && help.contains(&format!("arcsmith {command}")), "{help}");
        }
    }
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = text(&run(folder.path(), &["completions", shell]));
        assert!(
            commands.iter().all(|command| script.contains(command)) && script.contains("held-out-percent")
        );
    }
    let page = text(&run(folder.path(), &["man"]));
    assert!(page.contains(".TH") && commands.iter().all(|command| page.contains(command)));
    text(&run(folder.path(), &["man", "--out", "."]));
    for command in commands {
        let page = std::fs::read_to_string(folder.path().join(format!("arcsmith-{command}.1"))).unwrap();
        assert!(page.contains(".TH"), "{command}");
    }
    assert!(folder.path().join("arcsmith.1").is_file());
}

fn folder_with_encoder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let encoder = Encoder { friction: 1e-4, ..Encoder::eccentric(14) };
    std::fs::write(folder.path().join("encoder.csv"), encoder.csv(360.0, 2)).unwrap();
    std::fs::write(folder.path().join("encoder.toml"), fitter::mirror::ENCODER_FILE).unwrap();
    std::fs::write(folder.path().join("recording.csv"), Device::paper().csv(2)).unwrap();
    std::fs::write(folder.path().join("mirror.toml"), fitter::mirror::PAIR_FILE).unwrap();
    folder
}

#[test]
fn one_screen_of_summary_json_and_silence() {
    let folder = folder_with_encoder();
    let fit = ["fit", "encoder.csv", "--mirror", "encoder.toml", "--out", "e.json"];
    let with = |more: &[&'static str]| run(folder.path(), &[&fit[..], more].concat());
    let summary = text(&with(&[]));
    assert!(summary.lines().count() <= 24 && !summary.contains('\u{1b}'), "{summary}");
    for word in [
        "harmonics    2:",
        "wraps unwound: ",
        "harmonic 1",
        "directions   forward and backward lie 2 ×",
        "e.json",
    ] {
        assert!(summary.contains(word), "`{word}` is not in:\n{summary}");
    }
    assert!(text(&with(&["-v"])).lines().count() > summary.lines().count() + 5);
    assert_eq!(text(&with(&["-q"])), "");
    let value: Value = serde_json::from_str(&text(&with(&["--json"]))).unwrap();
    assert_eq!((value["harmonics"].as_u64(), value["written"].as_str()), (Some(2), Some("e.json")));
    assert!(value["after"]["rms"].as_f64().unwrap() < 0.1 * value["before"]["rms"].as_f64().unwrap());
    let half = value["directions"]["half_distance"]["value"].as_f64().unwrap();
    approx::assert_abs_diff_eq!(half, -0.036, epsilon = 0.002);

    let value: Value = serde_json::from_str(&text(&run(
        folder.path(),
        &["--json", "apply", "encoder.csv", "--coefficients", "e.json", "--out", "a.csv"],
    )))
    .unwrap();
    assert_eq!((value["rows"].as_u64(), value["extrapolated"].as_u64()), (Some(802), Some(0)));
    let angles = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert_eq!(angles.lines().next(), Some("t_s,corrected_deg,extrapolated"));
    let value: Value = serde_json::from_str(&text(&run(
        folder.path(),
        &["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json", "--json"],
    )))
    .unwrap();
    assert!(value["harmonics"].is_null() && value["order"].as_u64().unwrap() >= 7);
}

/// Colours only where they are asked for, and never against NO_COLOR.
#[test]
fn colours_honour_the_environment() {
    let folder = folder_with_encoder();
    let coloured = |name: &str, value: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_arcsmith"))
            .current_dir(folder.path())
            .env_remove("NO_COLOR")
            .env_remove("CLICOLOR_FORCE")
            .env(name, value)
            .args(["fit", "recording.csv", "--mirror", "mirror.toml", "--out", "c.json"])
            .output()
            .unwrap();
        text(&output).contains('\u{1b}')
    };
    assert!(coloured("CLICOLOR_FORCE", "1"));
    assert!(!coloured("NO_COLOR", "1"));
}
