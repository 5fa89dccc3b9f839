//! Campaigns whose program answers nothing: that must cost every figure, not pass for silence.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // how a test fails
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use trials::CampaignError;
use trials::plan::Counts;
use trials::programs::Programs;
use trials::report::{Page, Report};
use trials::workspace::Campaign;
use trials::{beyond, score};

/// A program that accepts all and writes nothing.
fn silent() -> Programs<'static> {
    Programs { path: PathBuf::from("/bin/true"), watch: &() }
}

fn still(trials: usize, nulls: usize, out: &Path) -> Campaign<Counts> {
    let counts = Counts { trials, nulls, intervals: 0, only: Vec::new(), twice: 0, without: false };
    Campaign { counts, seed: 1, jobs: 1, out: out.to_owned() }
}

/// The recordings stand alone: no truth, and names that say nothing.
fn only(folder: &Path, stated: &str, end: &str) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(name == stated || (name.starts_with('r') && name.ends_with(end)), "{name}");
    }
}

#[test]
fn a_folder_with_other_files_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("precious.txt"), "mine").unwrap();
    let refused = still(7, 1, folder.path()).run(&silent(), |_, _| {}).map(|_| ()).unwrap_err();
    assert!(matches!(refused, CampaignError::Occupied { .. }), "{refused}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn no_answer_is_no_right_answer_and_the_seal_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = still(7, 3, folder.path());
    let seal = Mutex::new(String::new());
    let outcome = campaign
        .run(&silent(), |hash, _| {
            assert!(!folder.path().join("truth.jsonl").exists());
            *seal.lock().unwrap() = hash.to_string();
        })
        .unwrap();
    let truth = std::fs::read(folder.path().join("truth.jsonl")).unwrap();
    let hash: String = {
        use sha2::{Digest, Sha256};
        Sha256::digest(&truth).iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!(*seal.lock().unwrap(), hash);
    let report = Report::of_static(&campaign, &outcome);
    assert!(!score::reached(&report.score.figures));
    let written = serde_json::to_string(&report.score).unwrap();
    assert!(written.contains("100.00 % (3/3)"), "{written}");
    only(&folder.path().join("recordings"), "mirror.toml", ".csv");
}

#[test]
fn no_answer_is_no_right_answer_in_motion_either() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = Campaign { counts: 5, seed: 1, jobs: 1, out: folder.path().to_owned() };
    let outcome = campaign.run(&silent(), |_, _| {}).unwrap();
    let report = Report::of_dynamic(&campaign, &outcome);
    assert!(!score::reached(&report.score.figures));
    let written = serde_json::to_string(&report.score).unwrap();
    assert!(written.contains("100.00 % (1/1") && written.contains("refused"), "{written}");
    let truth = std::fs::read_to_string(folder.path().join("truth.jsonl")).unwrap();
    assert_eq!(truth.lines().count(), 5);
    only(&folder.path().join("recordings"), "plant.toml", ".csv.gz");
}

#[test]
fn no_answer_gains_nothing_beyond_the_catalogue_either() {
    let folder = tempfile::tempdir().unwrap();
    let counts =
        beyond::plan::Counts { trials: 1, nulls: 1, motion: 0, left_out: 0, kinds: vec!["ooc_abbe".into()] };
    let campaign = Campaign { counts, seed: 1, jobs: 1, out: folder.path().to_owned() };
    let outcome = campaign.run(&silent(), |_, count| assert_eq!(count, 9)).unwrap();
    assert!(outcome.cases.iter().all(|row| row.said == "refused" && row.gain.is_none() && !row.found));
    let report = Report::of_beyond(&campaign, &outcome);
    assert_eq!(report.score.nulls.len(), 8);
    assert!(report.page().contains("| ooc_abbe | 1 | 0 | 0 |"), "{}", report.page());
    only(&folder.path().join("sensor/recordings"), "mirror.toml", ".csv");
    only(&folder.path().join("mirror/recordings"), "mirror.toml", ".csv");
}
