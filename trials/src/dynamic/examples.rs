//! The opened dynamic examples of an independent laboratory, scored alike: a folder with `dynamic/`,
//! `truth_dynamic.json` and `plant.toml`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::campaign::case;
use super::draw::depends_on;
use super::score::{Score, score as score_cases};
use super::truth::{Concealed, Group, Truth};
use crate::error::CampaignError;
use crate::examples::{OPENED, OpenedEffect, opened, read};
use crate::programs::{Nominal, Programs};
use crate::workspace::{Batches, Folders, put};

#[derive(Deserialize)]
struct Opened {
    effects: Vec<OpenedEffect>,
    noise: f64,
    effect_rms: f64,
    rho: f64,
}

/// Has the examples diagnosed into `out` and scores the answers; none where the folder holds none.
///
/// # Errors
/// [`CampaignError`].
pub fn score(
    programs: &Programs,
    folder: &Path,
    out: &Path,
    jobs: usize,
) -> Result<Option<Score>, CampaignError> {
    let path = folder.join("truth_dynamic.json");
    if !path.is_file() {
        return Ok(None);
    }
    let truths: BTreeMap<String, Opened> = opened(path)?;
    // Copies, so that the program that answers stands in a folder without the truth.
    let folders = Folders::prepare(out, Nominal::Plant, &read(&folder.join("plant.toml"))?)?;
    let mut files = Vec::new();
    for stem in truths.keys() {
        let file = format!("{stem}.csv.gz");
        let from = folder.join("dynamic").join(&file);
        std::fs::copy(&from, folders.blind.join(&file)).map_err(|e| CampaignError::Unreadable {
            path: from,
            reason: e.kind(),
            expected: OPENED,
        })?;
        files.push(file);
    }
    programs.begin("examples", files.len());
    Batches { programs, nominal: Nominal::Plant, jobs }.diagnose(
        &folders.blind,
        &files,
        &folders.diagnosed,
        None,
    )?;
    let cases = truths
        .into_iter()
        .map(|(stem, opened)| {
            case(truth(format!("{stem}.csv.gz"), opened), &folders.blind, &folders.diagnosed)
        })
        .collect::<Result<Vec<_>, CampaignError>>()?;
    let score = score_cases(&cases);
    put(&out.join("examples.json"), &(serde_json::to_string_pretty(&score).unwrap_or_default() + "\n"))?;
    Ok(Some(score))
}

/// The strength is known of all effects of a recording together, and of each only where it is alone.
fn truth(file: String, opened: Opened) -> Truth {
    let effects: Vec<Concealed> = opened
        .effects
        .into_iter()
        .map(|effect| {
            let depends_on = effect.depends_on(depends_on);
            Concealed {
                parameters: effect.numbers(),
                effect_rms: opened.effect_rms,
                rho: opened.rho,
                depends_on,
                imitation: None,
                id: effect.id,
            }
        })
        .collect();
    let group = match &effects[..] {
        [] => Group::Null,
        [one] if one.id.starts_with("ooc_") => Group::Outside,
        [_] => Group::Single,
        _ => Group::Pair,
    };
    let unknown = || String::from("not told");
    Truth {
        recording: file,
        group,
        noise: unknown(),
        excitation: unknown(),
        hold: unknown(),
        noise_rms: opened.noise,
        effects,
    }
}
