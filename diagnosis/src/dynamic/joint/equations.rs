//! A plant in equations that two recordings have in common.

use std::sync::Arc;

use fitter::plant::PlantFile;
use motion::equations::Plant;

use super::free_run::InCommon;
use super::{Group, Of, Reported};
use crate::dynamic::accurate::estimated;
use crate::dynamic::data::{ALL, Data};
use crate::dynamic::equations::model::{Model, Term, is_logarithmic};
use crate::dynamic::equations::{second_order, start, verdict};
use crate::dynamic::estimate::Fitted;
use crate::dynamic::interval::Sort;
use crate::dynamic::recording::DynamicRecording;
use crate::dynamic::verdict::{PLANT, place, reach};
use crate::verdict::{Location, Parameter};

/// What was identified in a recording beside a plant in equations.
#[derive(Clone)]
pub struct InEquations {
    /// The model, and where its runs begin.
    pub fitted: Fitted<Model>,
    /// The names of forms without a name of their own, by their ids.
    pub names: Vec<(String, String)>,
}

impl InEquations {
    /// A second-order plant with its effects, as equations beside those of another recording; none where they have none.
    pub fn of_second_order(
        written: &PlantFile,
        numbers: [f64; 3],
        other: &Model,
        recording: &DynamicRecording,
    ) -> Option<InEquations> {
        let file = second_order::in_equations(&other.plant.file, written, numbers).ok()?;
        let plant = Plant::of(&other.plant.file, &file)?.ok()?;
        let own = Model::new(Arc::new(plant), numbers.to_vec(), other.hold).ok()?;
        let names = |plant: &Plant| plant.parameters.iter().map(|p| p.name.clone()).collect::<Vec<_>>();
        if names(&own.plant) != names(&other.plant) {
            return None;
        }
        let terms = own.terms.clone();
        let model = Model { plant: other.plant.clone(), ..own }.with_terms(terms)?;
        let data = Data::new(recording);
        let states = start::first_states(&model, &data);
        let fitted = estimated(&model, &states, &data, ALL)?;
        Some(InEquations { fitted, names: Vec::new() })
    }
}

/// Two models beside the same plant: where one reads further columns, the other's plant has them, too. None where each reads
/// columns that the other does not.
pub fn of_one_plant(models: [&Model; 2]) -> Option<[Model; 2]> {
    let richer = models.into_iter().max_by_key(|model| model.plant.inputs.len())?;
    let has = |input: &(String, physics::Unit)| richer.plant.inputs.contains(input);
    let with = |model: &Model| {
        let all = model.plant.inputs.iter().all(has) && model.values.len() == richer.values.len();
        let own = model.clone();
        all.then(|| Model { plant: richer.plant.clone(), ..own }.with_terms(model.terms.clone())).flatten()
    };
    Some([with(models[0])?, with(models[1])?])
}

impl InCommon for Model {
    fn with_effects_of_both(models: [&Model; 2], recording: usize) -> Option<Model> {
        let own = models[recording];
        let mut terms: Vec<Term> = Vec::new();
        for term in models.iter().flat_map(|model| &model.terms) {
            let same = |known: &&Term| known.effect.text.id == term.effect.text.id;
            if !terms.iter().any(|known| same(&known)) {
                terms.push(own.terms.iter().find(same).unwrap_or(term).clone());
            }
        }
        own.with_terms(terms)
    }

    fn beside(&self, own: &Model) -> Option<Model> {
        let mut model = Model { values: own.values.clone(), ..self.clone() };
        for term in &mut model.terms {
            if let Some(known) = own.terms.iter().find(|known| known.effect.text.id == term.effect.text.id) {
                term.values.clone_from(&known.values);
                continue;
            }
            let parameters = term.effect.parameters.iter().zip(&mut term.values);
            parameters.filter(|(p, _)| p.range.is_none()).for_each(|(_, value)| *value = 0.0);
        }
        (self.terms.len() > own.terms.len()).then_some(model)
    }

    fn fixed(&self) -> Model {
        Model::fixed(self)
    }

    fn groups(&self) -> Vec<Group> {
        let free = (0..self.values.len()).filter(|k| self.plant.is_free(*k)).enumerate();
        let plant = free.map(|(lane, k)| {
            let id = &self.plant.parameters[k].name;
            Group::of_lanes(id, &format!("the {id} of the plant"), [lane], Of::Plant(k))
        });
        let effects = self.terms.iter().enumerate().flat_map(|(k, term)| {
            let (free, of) = (self.packed_of(k).into_iter().flatten().collect(), Of::Term(k));
            Group::of_effect(&term.effect.text.id, &term.effect.title(), free, self.amounts(of), of)
        });
        plant.chain(effects).collect()
    }

    fn readings(&self, of: Of, _: &fitter::plant::Plant) -> Vec<Reported> {
        let one = |parameter: &physics::Parameter, value: f64, lane: Option<usize>| {
            let slope = if is_logarithmic(parameter) { value } else { 1.0 };
            let unit = parameter.unit.to_string();
            let own = Parameter { name: parameter.name.clone(), value, unit, ci95: [value; 2] };
            (own, lane.map(|lane| (lane, slope)).into_iter().collect(), Sort::Amount)
        };
        match of {
            Of::Plant(k) => {
                let lane = (0..k).filter(|other| self.plant.is_free(*other)).count();
                vec![one(&self.plant.parameters[k], self.values[k], Some(lane))]
            }
            Of::Term(k) => {
                let term = &self.terms[k];
                let parameters = term.effect.parameters.iter().zip(&term.values).zip(self.packed_of(k));
                parameters.map(|((parameter, value), lane)| one(parameter, *value, lane)).collect()
            }
            Of::Inertia | Of::Structure(_) => Vec::new(),
        }
    }

    fn amounts(&self, of: Of) -> Vec<usize> {
        let Of::Term(k) = of else { return Vec::new() };
        let parameters = self.terms[k].effect.parameters.iter().zip(self.packed_of(k));
        parameters.filter(|(p, _)| p.range.is_none()).filter_map(|(_, lane)| lane).collect()
    }

    fn place(&self, group: &Group, recording: &DynamicRecording, p_value: f64) -> Option<Location> {
        match group.of {
            Of::Plant(_) if PLANT.iter().any(|[id, ..]| *id == group.id) => {
                place(&group.id, recording, p_value)
            }
            Of::Plant(_) | Of::Inertia | Of::Structure(_) => None,
            Of::Term(k) => {
                let own = Data::new(recording);
                let reach = |variable: &str| reach(&own, &recording.t_s, variable);
                Some(verdict::location(self, &self.terms[k], &recording.further, [1.0, p_value], reach))
            }
        }
    }
}
