//! Scores the program on recordings with a concealed, then opened effect, made by another laboratory. They
//! are found through the environment variable ARCSMITH_EXAMPLES; without it the test says what it skipped.

use std::path::{Path, PathBuf};

use diagnosis::verdict::Verdict;
use diagnosis::{Options, diagnose};
use fitter::{Mirror, Recording};
use serde_json::Value;

/// ρ from which a single effect must be found and named first.
const CLEAR: f64 = 8.0;

fn folder() -> Option<PathBuf> {
    std::env::var_os("ARCSMITH_EXAMPLES").map(PathBuf::from)
}

fn read(path: &Path) -> Recording {
    Recording::read(path).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn some_opened_recordings_are_diagnosed() {
    opened_recordings_are_diagnosed(3);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn all_opened_recordings_are_diagnosed() {
    opened_recordings_are_diagnosed(1);
}

/// Every so many of them.
fn opened_recordings_are_diagnosed(step: usize) {
    let Some(folder) = folder() else {
        println!("skipped the opened examples: set ARCSMITH_EXAMPLES to their folder");
        return;
    };
    let text = std::fs::read_to_string(folder.join("truth.json")).expect("truth.json");
    let truth: Value = serde_json::from_str(&text).expect("JSON");
    let mirror = Mirror::read(&folder.join("mirror.toml")).expect("mirror.toml");
    let (mut clear, mut exact, mut missed) = (0, 0, Vec::new());
    for (stem, told) in truth.as_object().expect("an object").iter().step_by(step) {
        let recording = read(&folder.join("recordings").join(format!("{stem}.csv")));
        let outcome =
            diagnose(&recording, &mirror, None, None, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        let d = &outcome.diagnosis;
        let effects = told["effects"].as_array().expect("effects");
        let ids: Vec<&str> = effects.iter().filter_map(|e| e["id"].as_str()).collect();
        if ids.is_empty() {
            assert_eq!(d.verdict, Verdict::Consistent, "{stem}: a false alarm");
            assert!(d.effects.is_empty());
            continue;
        }
        if effects.iter().any(|e| e["rho"].as_f64().unwrap_or(0.0) < CLEAR) {
            continue;
        }
        clear += 1;
        let mut named: Vec<&str> = d.effects.iter().map(|e| e.id.as_str()).collect();
        named.sort_unstable();
        let mut wanted = ids.clone();
        wanted.sort_unstable();
        let outside = ids.iter().any(|id| id.starts_with("ooc_"));
        let ambiguous = told["ambiguous"].as_bool() == Some(true);
        let right = if outside {
            // A formula without a name is right, too; a name alone is not.
            matches!(d.verdict, Verdict::Unexplained | Verdict::PartlyExplained | Verdict::Described)
        } else if ambiguous {
            let all = d
                .effects
                .iter()
                .flat_map(|e| e.alternatives.iter().map(String::as_str).chain([e.id.as_str()]));
            let all: Vec<&str> = all.collect();
            wanted.iter().all(|w| all.contains(w)) && d.next_experiment.is_some()
        } else {
            named == wanted
        };
        if right {
            exact += 1
        } else {
            missed.push(format!("{stem}: {wanted:?} named {named:?}"))
        }
        // What is named must make the recording agree with the model up to its noise.
        if d.verdict == Verdict::Explained {
            assert!(d.fit.after.train_rms < d.fit.before.train_rms, "{stem}: no gain");
        }
    }
    println!("{exact} of {clear} clear recordings right; missed: {missed:?}");
    // One in ten may be missed, one of any number: a dozen recordings cannot measure more than that.
    assert!(clear - exact <= (clear / 10).max(1), "{exact} of {clear}: {missed:?}");
}
