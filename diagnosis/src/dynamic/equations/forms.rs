//! What named effects leave is described by forms without a name: a second search, of the forms beside the effects that were
//! named, whose answer is given where it leaves less of the rows that score.

use std::collections::BTreeMap;

use fitter::plant::equations::EffectText;
use fitter::plant::{Kind, PlantFile};
use motion::equations::Plant;
use physics::Unit;

use super::super::diagnose::{Case, DynamicOutcome, Identified};
use super::super::recording::DynamicRecording;
use super::diagnose::attempt;
use super::{catalogue, second_order, verdict};
use crate::diagnosis::Diagnosis;
use crate::thresholds::dynamic::forms::{CLEARLY, MOST_COLUMNS};
use crate::thresholds::{AT_FLOOR, NO_WORSE};
use crate::verdict::{EMPIRICAL, Verdict};

/// The first answer, or one with forms that describe what it leaves.
pub fn described(case: &Case, first: DynamicOutcome) -> DynamicOutcome {
    let structured = matches!(first.diagnosis.verdict, Verdict::PartlyExplained | Verdict::Unexplained);
    let second = (structured && case.simulated.is_none()).then(|| with_forms(case, &first)).flatten();
    second.unwrap_or(first)
}

/// The answer with forms; none where it is no better, or no equations hold the plant.
fn with_forms(case: &Case, first: &DynamicOutcome) -> Option<DynamicOutcome> {
    let plant = in_equations(case, &first.diagnosis)?;
    let bare = Plant::of(case.plant_file, &plant)?.ok()?;
    let named = |id: &String| first.diagnosis.effects.iter().any(|effect| effect.id == *id);
    let mut options = case.options.clone();
    let others = verdict::ids(&catalogue::effects(&bare, case.recording.drives.len()));
    options.skip.extend(others.into_iter().filter(|id| !named(id)));
    let mut columns: Vec<String> = varying(case.recording, &bare);
    let mut outcome = loop {
        let plant = with_columns(&plant, &columns);
        let case = Case { plant: &plant, options: &options, ..*case };
        let outcome = attempt(&case, true).ok()??;
        let used: Vec<String> = columns.iter().filter(|column| reads(&outcome, column)).cloned().collect();
        if used.len() == columns.len() {
            break outcome;
        }
        columns = used;
    };
    let (before, after) = (&first.diagnosis.fit.after, &outcome.diagnosis.fit.after);
    let left = after.held_out_rms?;
    let any = outcome.diagnosis.effects.iter().any(|effect| effect.kind == EMPIRICAL);
    if !any || left > CLEARLY * before.held_out_rms? || after.train_rms > NO_WORSE * before.train_rms {
        return None;
    }
    let floor = first.diagnosis.noise_floor.value;
    if outcome.diagnosis.verdict == Verdict::Explained {
        let at_floor = left <= AT_FLOOR * floor;
        outcome.diagnosis.verdict = if at_floor { Verdict::Described } else { Verdict::PartlyExplained };
    }
    number(&mut outcome, case.plant.plant.kind == Kind::SecondOrder && columns.is_empty());
    Some(outcome)
}

/// The plant in equations; a second-order one from where it was identified.
fn in_equations(case: &Case, first: &Diagnosis) -> Option<PlantFile> {
    if case.plant.plant.kind == Kind::Equations {
        return Some(case.plant.clone());
    }
    let [damping, stiffness, gain] = &first.plant[..] else { return None };
    let numbers = [damping, stiffness, gain].map(|parameter| parameter.value);
    second_order::in_equations(case.plant_file, case.plant, numbers).ok()
}

/// The further columns that change, and are no names of the plant.
fn varying(recording: &DynamicRecording, plant: &Plant) -> Vec<String> {
    let taken = |name: &String| {
        let names = plant.inputs.iter().chain(&plant.states).map(|(name, _)| name);
        names.chain(plant.parameters.iter().map(|parameter| &parameter.name)).any(|own| own == name)
    };
    let varies = |values: &[f64]| values.iter().any(|value| *value != values[0]);
    let all = recording.further.iter().filter(|(name, values)| varies(values) && !taken(name));
    all.map(|(name, _)| name.clone()).take(MOST_COLUMNS).collect()
}

/// A plant with further columns among its inputs.
fn with_columns(plant: &PlantFile, columns: &[String]) -> PlantFile {
    let mut plant = plant.clone();
    if let Some(equations) = &mut plant.equations {
        let unit = |column: &String| (column.clone(), Unit::of_column(column).to_string());
        equations.inputs.0.extend(columns.iter().map(unit));
    }
    plant
}

/// Whether an effect of the plant that is handed on reads a column.
fn reads(outcome: &DynamicOutcome, column: &str) -> bool {
    let effects = outcome.plant.equations.iter().flat_map(|equations| &equations.effects);
    effects.flat_map(catalogue::expressions).any(|expression| expression.names().contains(&column))
}

/// Numbers the forms that were found, the strongest first, wherever they are named; each with its declaration, beside a
/// second-order plant in the words for that.
fn number(outcome: &mut DynamicOutcome, second_order: bool) {
    let mut file: Vec<&mut EffectText> =
        outcome.plant.equations.iter_mut().flat_map(|equations| &mut equations.effects).collect();
    let Diagnosis { effects, unidentifiable, judged, next_experiment, verdict, .. } = &mut outcome.diagnosis;
    let forms = effects.iter_mut().filter(|effect| effect.kind == EMPIRICAL);
    let mut numbered: Vec<(String, String)> = Vec::new();
    for (k, effect) in forms.enumerate() {
        let name = format!("empirical_{}", k + 1);
        let id = std::mem::replace(&mut effect.id, name.clone());
        if let Some(text) = file.iter_mut().find(|text| text.id == id) {
            text.id.clone_from(&name);
            effect.form.declaration = Some(declaration(text, second_order));
            if *verdict == Verdict::Described && next_experiment.is_none() {
                *next_experiment = Some(format!("to confirm {name}: {}", text.experiment));
            }
        }
        numbered.push((id, name));
    }
    if let Identified::Equations(identified) = &mut outcome.identified {
        identified.names.clone_from(&numbered);
    }
    // The name of a form may be the end of another's.
    numbered.sort_by_key(|(id, _)| std::cmp::Reverse(id.len()));
    let texts = unidentifiable.iter_mut().chain(judged).chain(next_experiment);
    texts.for_each(|text| numbered.iter().for_each(|(id, name)| *text = text.replace(id.as_str(), name)));
}

/// How a form would be declared as an effect of the user's own; beside a second-order plant, which has no further columns,
/// in the words for that.
fn declaration(text: &EffectText, second_order: bool) -> String {
    let mut text = EffectText { readings: Vec::new(), ..text.clone() };
    text.parameters.values_mut().for_each(|parameter| parameter.value = None);
    if second_order {
        let said = |of: &mut BTreeMap<String, String>, name: &str| of.remove(name).unwrap_or_default();
        text.acceleration = said(&mut text.equation, "v");
        text.drive = said(&mut text.input, "u");
        text.reading = said(&mut text.output, "y");
    }
    format!("[[effect]]\n{}", text.to_toml())
}
