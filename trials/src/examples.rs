//! The opened examples of an independent laboratory, scored alike: a folder with `recordings/`, `fresh/`,
//! `truth.json` and `mirror.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use twin::Reading;

use crate::draw::depends_on;
use crate::error::CampaignError;
use crate::fresh::{self, Twice};
use crate::programs::{Nominal, Programs};
use crate::score::{Case, Score, score as score_cases};
use crate::truth::{Concealed, Group, Truth};
use crate::workspace::{Batches, answer_of, empty_folder, put, unwritable};

#[derive(Deserialize)]
struct Opened {
    effects: Vec<OpenedEffect>,
    noise_arcsec: f64,
    schedule: String,
    temperature: String,
    family: String,
    ambiguous: bool,
    fresh_is_fair: bool,
}

/// What is expected of a file.
pub(crate) const OPENED: &str = "opened examples, as in the folder that ARCSMITH_EXAMPLES names";

/// An effect as the truth of the laboratory states it; in motion its strength is stated elsewhere.
#[derive(Deserialize)]
pub(crate) struct OpenedEffect {
    pub id: String,
    parameters: BTreeMap<String, serde_json::Value>,
    #[serde(default)]
    rho: f64,
}

impl OpenedEffect {
    /// Its parameters that are numbers.
    pub fn numbers(&self) -> BTreeMap<String, f64> {
        self.parameters.iter().filter_map(|(name, value)| Some((name.clone(), value.as_f64()?))).collect()
    }

    /// The variables of which any may rightly be located first: those stated, else those that `known` names.
    pub fn depends_on(&self, known: fn(&str) -> Vec<String>) -> Vec<String> {
        let listed = self.parameters.get("depends_on").and_then(|v| v.as_array());
        let variables = listed.map(|l| l.iter().filter_map(|v| v.as_str()).map(str::to_owned).collect());
        variables.unwrap_or_else(|| known(&self.id))
    }
}

/// The truths in a file of the folder, by recording.
pub(crate) fn opened<T: DeserializeOwned>(path: PathBuf) -> Result<BTreeMap<String, T>, CampaignError> {
    serde_json::from_str(&read(&path)?).map_err(|reason| CampaignError::Form {
        path,
        reason,
        expected: OPENED,
    })
}

/// Has the examples diagnosed into `out` and scores the answers.
///
/// # Errors
/// [`CampaignError`].
pub fn score(programs: &Programs, folder: &Path, out: &Path, jobs: usize) -> Result<Score, CampaignError> {
    let truths: BTreeMap<String, Opened> = opened(folder.join("truth.json"))?;
    let out = std::path::absolute(out).map_err(unwritable(out))?;
    // Copies, so that the program that answers stands in a folder without the truth.
    let (blind, diagnosed) = (out.join("recordings"), out.join("diagnosed"));
    for folder in [&blind, &diagnosed] {
        empty_folder(folder)?;
    }
    put(&blind.join("mirror.toml"), &read(&folder.join("mirror.toml"))?)?;
    let mut files = Vec::new();
    for stem in truths.keys() {
        let file = format!("{stem}.csv");
        put(&blind.join(&file), &read(&folder.join("recordings").join(&file))?)?;
        files.push(file);
    }
    Batches { programs, nominal: Nominal::Mirror, jobs }.diagnose(&blind, &files, &diagnosed, None)?;
    let cases: Result<Vec<Case>, CampaignError> =
        truths.iter().map(|(stem, opened)| case(programs, folder, &diagnosed, stem, opened)).collect();
    Ok(score_cases(&cases?))
}

fn case(
    programs: &Programs,
    folder: &Path,
    diagnosed: &Path,
    stem: &str,
    opened: &Opened,
) -> Result<Case, CampaignError> {
    let file = format!("{stem}.csv");
    let seen = readings(&folder.join("recordings").join(&file))?;
    let truth = truth(&file, opened, &seen);
    let answer = answer_of(diagnosed, stem)?;
    let mut compared = None;
    let known = !matches!(truth.group, Group::Null | Group::Ambiguous | Group::Outside);
    if truth.fresh_is_fair && answer.is_some() && known {
        let path = folder.join("fresh").join(&file);
        let angles = diagnosed.join(format!("{stem}.angles.csv"));
        match programs.apply(&path, &diagnosed.join(format!("{stem}.coefficients.json")), &angles)? {
            Ok(()) => {
                let ids = truth.ids();
                let fresh = readings(&path)?;
                let twice =
                    Twice { seen: &seen, fresh: &fresh, ids: &ids, covariance: None, distance_mm: 12.0 };
                compared = fresh::compare(&twice, &angles);
            }
            Err(reason) => programs.watch.warn(&format!("{stem}: the coefficients were refused: {reason}")),
        }
    }
    Ok(Case { truth, answer, fresh: compared, without: None, left_by_names: [None; 2], benchmark: None })
}

fn truth(file: &str, opened: &Opened, seen: &[Reading]) -> Truth {
    let effects: Vec<Concealed> = opened
        .effects
        .iter()
        .map(|effect| {
            let parameters = effect.numbers();
            let t_s: Vec<f64> = seen.iter().map(|r| r.t_s).collect();
            Concealed {
                id: effect.id.clone(),
                rho: effect.rho,
                depends_on: effect.depends_on(depends_on),
                imitation: None,
                step_window_s: crate::draw::step_window_s(parameters.get("time_s").copied(), &t_s),
                parameters,
            }
        })
        .collect();
    let group = match effects.as_slice() {
        [] => Group::Null,
        _ if opened.ambiguous => Group::Ambiguous,
        [one] if one.id.starts_with("ooc_") => Group::Outside,
        [one] if one.rho < 8.0 => Group::Weak,
        [_] => Group::Strong,
        [_, _] => Group::Pair,
        _ => Group::Triple,
    };
    Truth {
        recording: file.to_owned(),
        group,
        family: opened.family.clone(),
        schedule: opened.schedule.clone(),
        temperature: opened.temperature.clone(),
        noise_arcsec: opened.noise_arcsec,
        effects,
        fresh_is_fair: opened.fresh_is_fair,
    }
}

pub(crate) fn read(path: &Path) -> Result<String, CampaignError> {
    std::fs::read_to_string(path).map_err(|e| CampaignError::Unreadable {
        path: path.to_owned(),
        reason: e.kind(),
        expected: OPENED,
    })
}

/// The readings of a calibration with all the columns that the log of `twin` has.
fn readings(path: &Path) -> Result<Vec<Reading>, CampaignError> {
    let text = read(path)?;
    let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
    let wrong = |line: usize| CampaignError::Reading { path: path.to_owned(), line };
    rows.enumerate().map(|(index, row)| row.map_err(|_| wrong(index + 2))).collect()
}
