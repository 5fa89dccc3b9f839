//! `trials beyond` through the program.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The report of a few recordings, as text.
fn report(folder: &Path, jobs: &str) -> String {
    let out = folder.join(jobs);
    let arguments =
        ["--trials", "2", "--nulls", "0", "--kind", "ooc_supply_gain", "--kind", "ooc_cross_square"];
    let output = Command::new(env!("CARGO_BIN_EXE_arcsmith"))
        .args(["trials", "beyond", "--seed", "11", "--jobs", jobs, "--json"])
        .args(arguments)
        .arg("--out")
        .arg(&out)
        .output()
        .expect("the program");
    // Figures of so few recordings may be missed; that is no bad input.
    let code = output.status.code();
    assert!(matches!(code, Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::read_to_string(out.join("report.json")).expect("the report")
}

#[test]
fn a_concealed_dependence_is_located_and_scored_on_a_fresh_recording_the_same_by_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = report(folder.path(), "1");
    assert_eq!(text, report(folder.path(), "2"));
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let rows = json["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 4);
    for row in rows {
        assert!(row["rho"].as_f64().is_some_and(|rho| rho > 7.5), "{row}");
        let fresh = &row["fresh"];
        let [base, oracle] = ["base", "oracle"].map(|key| fresh[key].as_f64().expect("a mean square"));
        assert!(oracle > 0.0 && oracle < base, "{row}");
        assert_eq!(row["found"], true, "{row}");
    }
}
