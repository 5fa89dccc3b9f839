//! One campaign: draw, write the recordings, seal, have them diagnosed blind, unseal, try on fresh recordings.

use std::collections::BTreeMap;
use std::path::Path;

use fitter::plant::PlantFile;
use fitter::recording::Recording;
use fitter::terms::Scope;
use fitter::{apply, coefficients};
use twin::dynamic::{Begin, Series, simulate};

use super::draw::{Drawn, Truth};
use super::plan::{self, Counts, Device};
use super::score::{Fresh, Row};
use crate::error::CampaignError;
use crate::linear::{deviation, norm};
use crate::programs::{Nominal, Programs};
use crate::truth::seal;
use crate::workspace::{Batches, Campaign, Folders, Outcome, afresh, answer_of, draw_all, put, threads};

/// What is stated to the programs of each device, and the folder of its recordings.
const STATED: [(Device, Nominal, &str, &str); 3] = [
    (Device::Mirror, Nominal::Mirror, "mirror", include_str!("../mirror.toml")),
    (Device::Sensor, Nominal::Mirror, "sensor", "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n"),
    (Device::Motion, Nominal::Plant, "motion", include_str!("../dynamic/plant.toml")),
];

impl Campaign<Counts> {
    /// Runs it; `sealed` is called with the hash of the truth before anything is diagnosed.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn run(
        &self,
        programs: &Programs,
        sealed: impl FnOnce(&str, usize),
    ) -> Result<Outcome<Row>, CampaignError> {
        let mut places = Vec::new();
        for (device, nominal, name, stated) in STATED {
            places.push((device, Folders::prepare(&self.out.join(name), nominal, stated)?));
        }
        let pool = threads(self.jobs)?;
        let drawn = pool.install(|| self.draw(programs, &places))?;
        let mut truths: Vec<&Truth> = drawn.iter().map(|d| &d.truth).collect();
        truths.sort_by(|a, b| a.recording.cmp(&b.recording));
        let (text, hash) = seal(&truths);
        sealed(&hash, truths.len());
        programs.begin("diagnosing", truths.len());
        let mut together: BTreeMap<(Device, Option<&str>), Vec<String>> = BTreeMap::new();
        for truth in &truths {
            let left_out = truth.kind.as_deref().filter(|_| truth.left_out);
            together.entry((truth.device, left_out)).or_default().push(truth.recording.clone());
        }
        for ((device, left_out), files) in together {
            let folders = folders(&places, device);
            let nominal = if device == Device::Motion { Nominal::Plant } else { Nominal::Mirror };
            let batches = Batches { programs, nominal, jobs: self.jobs };
            batches.diagnose(&folders.blind, &files, &folders.diagnosed, left_out)?;
        }
        put(&self.out.join("truth.jsonl"), &text)?;
        let cases = afresh(programs, &pool, drawn, |d| row(programs, folders(&places, d.truth.device), d))?;
        Ok(Outcome { cases, sealed: hash })
    }

    /// Draws every recording and writes it under a name that says nothing, and the fresh one elsewhere.
    fn draw(&self, programs: &Programs, places: &[(Device, Folders)]) -> Result<Vec<Drawn>, CampaignError> {
        draw_all(programs, self.seed, &plan::assignments(&self.counts, self.seed), |assignment, number| {
            let drawn = Drawn::draw(assignment, format!("r{number:06}.csv"))?;
            let folders = folders(places, assignment.device);
            let [seen, fresh] = drawn.csv();
            put(&folders.blind.join(&drawn.truth.recording), &seen)?;
            put(&folders.fresh.join(&drawn.truth.recording), &fresh)?;
            put(&folders.fresh.join(format!("r{number:06}.clean.csv")), &drawn.clean_csv())?;
            Ok(drawn)
        })
    }
}

/// The folders of a device.
fn folders(places: &[(Device, Folders)], device: Device) -> &Folders {
    let place = places.iter().find(|(other, _)| *other == device);
    // There is a place for either device.
    &place.unwrap_or(&places[0]).1
}

/// Reads the answer to a recording and tries it on the fresh one.
fn row(programs: &Programs, folders: &Folders, drawn: Drawn) -> Result<Row, CampaignError> {
    let file = &drawn.truth.recording;
    let stem = file.trim_end_matches(".csv");
    let answer = answer_of(&folders.diagnosed, stem)?;
    if let Some(base) = drawn.base {
        let fresh = folders.fresh.join(file);
        let (handed_on, terms) =
            match free_run(&folders.diagnosed.join(format!("{stem}.plant.toml")), &fresh, &drawn) {
                Ok((left, effects)) => (Some(left), effects),
                Err(reason) => {
                    programs.watch.warn(&format!("{stem}: {reason}"));
                    (None, 0)
                }
            };
        let fresh = handed_on.map(|handed_on| Fresh { base, handed_on, oracle: drawn.oracle });
        return Ok(Row::new(drawn.truth, answer.as_ref(), terms, fresh));
    }
    let handed_on = folders.diagnosed.join(format!("{stem}.coefficients.json"));
    let base = folders.fresh.join(format!("{stem}.base.json"));
    let fitted = programs.fit(&folders.blind, file, &base)?;
    let recording = Recording::read(&folders.fresh.join(file))?;
    let error = |coefficients: &Path| {
        let left = left(&recording, coefficients, &drawn);
        left.map_err(|reason| programs.watch.warn(&format!("{stem}: {reason}"))).ok()
    };
    let base = match fitted {
        Ok(()) => error(&base),
        Err(reason) => {
            programs.watch.warn(&format!("{stem}: the base alone was refused: {reason}"));
            None
        }
    };
    // Where nothing is handed on, the base is what there is.
    let by_answer = if handed_on.is_file() { error(&handed_on) } else { base };
    let fresh = base.zip(by_answer).map(|(base, handed_on)| Fresh { base, handed_on, oracle: drawn.oracle });
    let terms = coefficients::read(&handed_on).map_or(0, |coefficients| {
        coefficients.terms.iter().filter(|term| term.scope == Scope::Device).count()
    });
    Ok(Row::new(drawn.truth, answer.as_ref(), terms, fresh))
}

/// Mean square of what coefficients leave of a fresh recording about its mean, in the square of the result's unit,
/// beside the reference without its noise, in the range that the first recording covers.
fn left(recording: &Recording, path: &Path, drawn: &Drawn) -> Result<f64, String> {
    let coefficients = coefficients::read(path).map_err(|e| e.to_string())?;
    let applied = apply::apply_screened(recording, &coefficients).map_err(|e| e.to_string())?;
    let scale = coefficients.sensor.per_internal();
    let error: Vec<f64> = applied
        .corrected
        .iter()
        .zip(&drawn.fresh.clean)
        .map(|(corrected, clean)| scale * corrected - clean)
        .collect();
    Ok(deviation(&drawn.fresh.covered(&drawn.seen, &error)).powi(2))
}

/// Mean square of what a plant's free run from rest leaves of a fresh drive's position without its noise, and how many
/// effects the plant has.
fn free_run(plant: &Path, fresh: &Path, drawn: &Drawn) -> Result<(f64, usize), String> {
    let file = PlantFile::read(plant).map_err(|e| e.to_string())?;
    let driven = Series::read(fresh).map_err(|e| e.to_string())?;
    let simulated =
        simulate(&plant.display().to_string(), &file, &driven, Begin::Rest).map_err(|e| e.to_string())?;
    let left: Vec<f64> =
        simulated.positions.iter().flatten().zip(&drawn.fresh.clean).map(|(s, clean)| s - clean).collect();
    let in_equations = file.equations.as_ref().map_or(0, |equations| equations.effects.len());
    Ok((norm(&left).powi(2) / left.len().max(1) as f64, file.effects.len() + in_equations))
}
