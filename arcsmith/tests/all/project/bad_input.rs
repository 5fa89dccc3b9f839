//! What is refused: one message with its line, exit code 2, and nothing written.

use super::Folder;

/// The change of a project file, and what the message says of it.
const CASES: [(&str, &str, &[&str]); 17] = [
    ("out = \"results\"", "out = [", &["arcsmith.toml, line ", "is not TOML"]),
    ("recordings =", "recordngs =", &["line 5: unknown key `recordngs`", "did you mean `recordings`?"]),
    ("recordings = [\"calibration.csv\"]", "", &["`recordings` is missing"]),
    (
        "probe_distance_mm = 12.0",
        "probe_distanse_mm = 12.0",
        &["unknown key `geometry.probe_distanse_mm`", "did you mean `probe_distance_mm`?"],
    ),
    ("# order = 9", "oder = 9", &["line 34: unknown key `fit.oder`", "did you mean `order`?"]),
    ("# order = 9", "order = 99", &["line 34: `fit` refuses its options", "'99'", "1..=15"]),
    ("# order = 9", "order = true", &["line 34: `fit.order`, found true, expected a number or a text"]),
    ("# order = 9", "average = 3", &["`fit.average`, found 3, expected true or false"]),
    (
        "# format = \"q31\"",
        "format = \"q32\"",
        &["line 46: `generate` refuses its options", "'q32'", "q31-split"],
    ),
    ("# bits = 16", "bots = 16", &["unknown key `generate.bots`", "did you mean `bits`?"]),
    ("# bits = 16", "demo = true", &["unknown key `generate.demo`"]),
    (
        "coefficients = \"fit\"",
        "coefficients = \"fits\"",
        &["`coefficients`, found \"fits\", expected \"fit\" or \"diagnosis\""],
    ),
    ("coefficients = \"fit\"", "guessed = [\"columns.x9_mm\"]", &["`guessed` names `columns.x9_mm`"]),
    ("coefficients = \"fit\"", "mirror = \"mirror.toml\"", &["are two models"]),
    (
        "[fit]\n",
        "[columns]\nx1_mm = \"x1_mm:parsec\"\n[fit]\n",
        &["`columns.x1_mm`: found the unit `parsec`"],
    ),
    (
        "[fit]\n",
        "[columns]\nx1_mm = { colum = \"x1_mm\" }\n[fit]\n",
        &["unknown key `columns.x1_mm.colum`", "did you mean `column`?"],
    ),
    (
        "out = \"firmware/angle\"",
        "out = \"firmware/angle\"\n[[generate]]\nout = \"firmware/./angle\"",
        &[
            "line 44: `generate.out`: two targets write to firmware/./angle",
            "found it in line 42 too",
            "give one of them another `out`",
        ],
    ),
];

#[test]
fn a_project_file_that_is_wrong_is_refused_with_its_line_and_nothing_is_written() {
    for (before, after, parts) in CASES {
        let folder = Folder::new();
        folder.edit(before, after);
        let files = folder.files();
        for command in ["run", "check"] {
            let said = folder.refused(command);
            assert!(said.starts_with("error: arcsmith.toml"), "{after}: {said}");
            for part in parts {
                assert!(said.contains(part), "{after}, {part}: {said}");
            }
            assert_eq!(said.lines().count(), said.trim_end().lines().count(), "{said}");
        }
        let error: serde_json::Value = serde_json::from_str(&folder.refused("run --json")).unwrap();
        assert_eq!(error["error"]["file"], "arcsmith.toml", "{after}: {error}");
        assert!(error["error"]["mend"].is_string(), "{after}: {error}");
        assert!(folder.files() == files, "{after}");
    }
}

#[test]
fn a_recording_that_is_missing_is_named_with_the_hash_that_it_had() {
    let folder = Folder::new();
    folder.ok("run --quiet");
    std::fs::rename(folder.path().join("calibration.csv"), folder.path().join("elsewhere.csv")).unwrap();
    let files = folder.files();
    for command in ["run", "fit", "diagnose", "check"] {
        let said = folder.refused(command);
        for part in [
            "calibration.csv: there is no such file",
            "SHA-256 85fc0f31b885",
            "name another in arcsmith.toml",
        ] {
            assert!(said.contains(part), "{command}, {part}: {said}");
        }
    }
    assert!(folder.files() == files);
    let state = folder.state("fit");
    assert!(state.contains("calibration.csv is missing, whose SHA-256 was 85fc0f31b885"), "{state}");
    assert!(folder.state("next").contains("put calibration.csv into this folder"));
    // Back again, all is as it was.
    std::fs::rename(folder.path().join("elsewhere.csv"), folder.path().join("calibration.csv")).unwrap();
    folder.ok("check");
}

#[test]
fn a_recording_that_cannot_be_read_leaves_everything_as_it_was() {
    let folder = Folder::new();
    folder.ok("run --quiet");
    folder.write("calibration.csv", folder.read("calibration.csv").replacen(",1,1,", ",1,sideways,", 1));
    let files = folder.files();
    let said = folder.refused("run");
    assert!(said.contains("calibration.csv, line 2, column `direction`"), "{said}");
    assert!(folder.files() == files);
    let fresh = Folder::new();
    fresh.write("calibration.csv", "t_s,pass\n");
    assert_eq!(fresh.run("run").status.code(), Some(2));
    assert!(!fresh.path().join("results").exists());
}

#[test]
fn a_bound_that_is_exceeded_fails_the_check() {
    let folder = Folder::new();
    folder.ok("run --quiet");
    folder.edit("# bound_arcsec = 0.01", "bound_arcsec = 1e-6\nformat = \"f32\"");
    let check = folder.run("check");
    let said = String::from_utf8(check.stdout).unwrap();
    assert_eq!(check.status.code(), Some(1), "{said}");
    let proven =
        said.split_once("is proven within ").and_then(|(_, bound)| bound.split_once(" arcsec, wanted 1e-6"));
    let proven: Option<f64> = proven.and_then(|(bound, _)| bound.parse().ok());
    assert!(proven.is_some_and(|bound| bound > 1e-6 && bound <= 0.01), "{said}");
    let said = folder.refused("run");
    assert!(said.contains("no f32 routine of degree 16 or less is proven within 1e-6"), "{said}");
}

#[test]
fn a_state_that_is_damaged_is_refused_with_its_mend() {
    let folder = Folder::new();
    folder.ok("run --quiet");
    for damage in ["{", "[]", "{\"schema\": \"other\", \"steps\": {}}"] {
        folder.write("results/state.json", damage);
        let said = folder.refused("run");
        assert!(said.contains("is not the state of a project") && said.contains("remove it"), "{said}");
    }
    std::fs::remove_file(folder.path().join("results/state.json")).unwrap();
    folder.ok("run --quiet");
    folder.ok("check");
}
