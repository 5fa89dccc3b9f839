//! The whole path: what is done, what is stale after a change, and that a run that was killed goes on.

use std::time::{Duration, Instant};

use super::Folder;

#[test]
fn outside_a_project_nothing_is_different() {
    let folder = Folder::empty();
    let help = folder.run("");
    assert_eq!(help.status.code(), Some(2));
    assert!(String::from_utf8(help.stderr).unwrap().contains("Usage: arcsmith"));
    for command in ["run", "status"] {
        assert!(folder.refused(command).contains("no arcsmith.toml in this folder; write one"), "{command}");
    }
    assert!(folder.refused("fit").contains("--mirror"));
}

#[test]
fn from_a_recording_to_firmware_without_a_flag() {
    let folder = Folder::new();
    let before = folder.ok("");
    assert!(before.contains("not done yet") && before.contains("arcsmith run"), "{before}");
    let said = folder.ok("run");
    for what in ["results/coefficients.json", "results/diagnosis", "firmware/angle", "proven within"] {
        assert!(said.contains(what), "{what}: {said}");
    }
    for file in [
        "results/diagnosis/calibration.html",
        "firmware/angle/certificate.json",
        "firmware/angle/c/corrected_angle.c",
    ] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
    assert!(folder.state("fit").contains("up to date"));
    assert!(folder.state("diagnose").contains("calibration.csv consistent"));
    assert!(folder.state("generate").contains("up to date, proven within"));
    assert!(folder.ok("check").contains("all up to date"));
    // Nothing is left to do.
    let files = folder.files();
    assert_eq!(folder.ok("run").matches("── up to date").count(), 3);
    assert!(folder.files() == files);
    // Every command of a project is complete without a flag.
    folder.ok("fit");
    folder.ok("diagnose");
    folder.ok("generate");
    folder.ok("apply");
    folder.ok("report");
    // All formats take a minute.
    folder.ok("explore --format q15");
    folder.ok("budget");
    assert!(folder.read("results/angles.csv").starts_with("t_s,"));
    assert!(folder.path().join("results/report.html").is_file());
    // The same commands give the same files, and the state says so.
    folder.ok("check");
}

#[test]
fn a_change_makes_stale_what_depends_on_it_and_nothing_else() {
    let folder = Folder::new();
    folder.ok("run");
    let stale = |folder: &Folder| -> Vec<String> {
        let steps = folder.json("status")["steps"].as_array().unwrap().clone();
        let stale = steps.iter().filter(|step| step["stale"] == true);
        stale.map(|step| step["name"].as_str().unwrap().to_string()).collect()
    };
    assert!(stale(&folder).is_empty());
    // A comment, and what another table says.
    folder.edit("[geometry]", "# Twelve millimetres, by the drawing.\n[geometry]");
    assert!(stale(&folder).is_empty());
    folder.edit("# bound_arcsec = 0.01", "bound_arcsec = 0.005");
    assert_eq!(stale(&folder), ["generate firmware/angle"]);
    assert!(folder.state("generate").contains("other options: now --bound-arcsec 0.005, before nothing"));
    folder.ok("run");
    folder.edit("probe_distance_mm = 12.0", "probe_distance_mm = 12.1");
    assert_eq!(stale(&folder), ["fit", "diagnose", "generate firmware/angle"]);
    folder.ok("run");
    assert!(stale(&folder).is_empty());
    // The recording: named, with both hashes.
    let recording = folder.read("calibration.csv");
    let shorter = recording.lines().take(200).collect::<Vec<_>>().join("\n") + "\n";
    folder.write("calibration.csv", &shorter);
    let fit = folder.state("fit");
    assert!(fit.contains("calibration.csv changed: its SHA-256 was 85fc0f31b885, is "), "{fit}");
    let failed = folder.run("check");
    assert_eq!(failed.status.code(), Some(1), "{failed:?}");
    folder.ok("run");
    folder.ok("check");
    // What was written, by hand.
    folder.write("firmware/angle/c/corrected_angle.c", "");
    assert_eq!(stale(&folder), ["generate firmware/angle"]);
    assert_eq!(folder.run("check").status.code(), Some(1));
    std::fs::remove_file(folder.path().join("results/coefficients.json")).unwrap();
    assert!(folder.state("fit").contains("results/coefficients.json is missing"));
    folder.ok("run");
    folder.ok("check");
    // A file that no hash is kept of is compared as well.
    folder.write("firmware/angle/Cargo.toml", "");
    let check = folder.run("check --json");
    assert_eq!(check.status.code(), Some(1), "{check:?}");
    let value: serde_json::Value = serde_json::from_slice(&check.stdout).unwrap();
    assert_eq!(value["compared"][0]["stale"][0]["file"], "Cargo.toml", "{value}");
    assert_eq!(value["holds"], false);
}

#[test]
fn a_run_gives_the_same_files_again() {
    let (one, other) = (Folder::new(), Folder::new());
    one.ok("run");
    other.ok("run --quiet");
    assert!(one.files() == other.files());
    one.ok("run --all");
    assert!(one.files() == other.files());
}

#[test]
fn json_tells_all_of_it() {
    let folder = Folder::new();
    let before = folder.json("");
    assert_eq!(before["next"], "arcsmith run");
    assert_eq!(before["steps"][0]["reasons"][0]["what"], "new");
    let run = folder.json("run");
    assert_eq!(run["steps"][0]["result"]["written"], "results/coefficients.json");
    assert_eq!(run["steps"][2]["result"]["out"], "firmware/angle");
    assert_eq!(run["verdicts"]["calibration.csv"], "consistent");
    assert_eq!(folder.json("check")["holds"], true);
    let empty = Folder::empty();
    empty.write("c.csv", folder.read("calibration.csv"));
    assert_eq!(empty.json("init --from c.csv")["rows"], 210);
}

#[test]
fn a_run_that_is_killed_leaves_nothing_half_written_and_the_next_goes_on() {
    let whole = Folder::new();
    let begun = Instant::now();
    whole.ok("run --quiet");
    let took = begun.elapsed();
    const KILLS: u32 = 8;
    for kill in 0..KILLS {
        let folder = Folder::new();
        let mut child = folder.command("run --quiet").spawn().unwrap();
        std::thread::sleep(took * kill / KILLS);
        child.kill().unwrap();
        child.wait().unwrap();
        // What is there is whole: the same as that of the run that was not killed.
        for (name, bytes) in folder.files().iter().filter(|(name, _)| !name.contains(".arcsmith-")) {
            assert!(name.ends_with("state.json") || whole.files()[name] == *bytes, "{name}");
        }
        std::thread::sleep(Duration::from_millis(5));
        folder.ok("run --quiet");
        let left = |name: &&String| !name.contains(".arcsmith-");
        let (now, all) = (folder.files(), whole.files());
        assert_eq!(now.keys().filter(left).collect::<Vec<_>>(), all.keys().collect::<Vec<_>>());
        assert!(all.iter().all(|(name, bytes)| now[name] == *bytes), "killed after {kill} of {KILLS}");
    }
}
