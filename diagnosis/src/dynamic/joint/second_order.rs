//! A second-order mechanism that two recordings have in common.

use fitter::plant::Plant;

use super::free_run::InCommon;
use super::{Group, Of, Reported};
use crate::dynamic::data::Data;
use crate::dynamic::effects::{Part, Reading, unit_of};
use crate::dynamic::estimate::Simulated;
use crate::dynamic::interval::Sort;
use crate::dynamic::model::{Model, Term};
use crate::dynamic::recording::DynamicRecording;
use crate::dynamic::verdict::{PLANT, nominal, place, slopes, sort};
use crate::thresholds::compare::joint::BEYOND;
use crate::verdict::{Location, Parameter};

impl InCommon for Model {
    fn with_effects_of_both(models: [&Model; 2], recording: usize) -> Option<Model> {
        let (own, other) = (models[recording], models[1 - recording]);
        let mut union = Model { terms: Vec::new(), ..own.clone() };
        for term in models.iter().flat_map(|model| &model.terms) {
            let of = |model: &Model| model.terms.iter().find(|t| t.effect.id == term.effect.id).cloned();
            if of(&union).is_some() {
                continue;
            }
            let mut known = of(own).unwrap_or_else(|| term.clone());
            if let Some(theirs) = of(other) {
                known.free.iter_mut().zip(&theirs.free).for_each(|(own, theirs)| *own |= theirs);
            }
            union.terms.push(known);
        }
        (own.nominal_free == other.nominal_free).then_some(union)
    }

    fn beside(&self, own: &Model) -> Option<Model> {
        let mut model = Model { nominal: own.nominal, ..self.clone() };
        for term in &mut model.terms {
            if let Some(known) = own.terms.iter().find(|known| known.effect.id == term.effect.id) {
                term.parameters.clone_from(&known.parameters);
                continue;
            }
            let limit = term.effect.is_limit();
            let parameters = term.effect.parameters.iter().zip(&mut term.parameters);
            parameters.for_each(|(p, value)| match p.shape {
                false => *value = 0.0,
                true if limit => *value *= BEYOND,
                true => {}
            });
        }
        (self.terms.len() > own.terms.len()).then_some(model)
    }

    fn fixed(&self) -> Model {
        let mut model = Model { nominal_free: [false; 3], ..self.clone() };
        model.terms.iter_mut().for_each(|term| term.free.fill(false));
        model
    }

    fn groups(&self) -> Vec<Group> {
        let plant = (0..3).filter(|k| self.nominal_free[*k]).enumerate();
        let plant = plant.map(|(lane, k)| Group::of_lanes(PLANT[k][0], PLANT[k][1], [lane], Of::Plant(k)));
        let effects = self.terms.iter().enumerate().flat_map(|(k, term)| {
            let (free, of) = (self.packed_of(k).into_iter().flatten().collect(), Of::Term(k));
            Group::of_effect(term.effect.id, term.effect.title, free, self.amounts(of), of)
        });
        let nominal = 0..self.nominal_free.iter().filter(|free| **free).count();
        let forces = self.terms.iter().enumerate().flat_map(|(k, term)| {
            let lanes = self.packed_of(k).into_iter().enumerate();
            lanes.filter(|(j, _)| is_per_inertia(term, *j)).filter_map(|(_, lane)| lane)
        });
        let inertia = Group::of_inertia(&self.packed(), nominal.chain(forces));
        let strengths = Group::of_strengths(&self.terms, &self.packed(), |k| self.amounts(Of::Term(k)));
        let special_cases = Group::of_special_cases(&self.terms, |k| self.packed_of(k)[0]);
        plant.chain(effects).chain(strengths).chain(special_cases).chain(inertia).collect()
    }

    fn readings(&self, of: Of, plant: &Plant) -> Vec<Reported> {
        match of {
            Of::Plant(k) => {
                let lane = self.nominal_free[..k].iter().filter(|free| **free).count();
                let parameter = nominal(self.nominal, [0.0; 3], plant).swap_remove(k);
                vec![(parameter, vec![(lane, 1.0)], Sort::Amount)]
            }
            Of::Term(k) => readings(&self.terms[k], &self.packed_of(k), slopes, plant),
            Of::Inertia | Of::Structure(_) => Vec::new(),
        }
    }

    fn amounts(&self, of: Of) -> Vec<usize> {
        let Of::Term(k) = of else { return Vec::new() };
        let parameters = self.terms[k].effect.parameters.iter().zip(self.packed_of(k));
        parameters.filter(|(p, _)| !p.shape).filter_map(|(_, lane)| lane).collect()
    }

    fn is_plausible(&self, of: Of, data: &Data) -> bool {
        let Of::Term(k) = of else { return true };
        (self.terms[k].effect.plausible)(&self.terms[k].parameters, &data.scale)
    }

    fn place(&self, group: &Group, recording: &DynamicRecording, p_value: f64) -> Option<Location> {
        place(&group.id, recording, p_value)
    }
}

/// Whether a parameter of a term is a force per inertia.
pub fn is_per_inertia(term: &Term, parameter: usize) -> bool {
    let of = &term.effect.parameters[parameter];
    term.effect.part == Part::Force && !term.effect.by_gain && !of.shape && of.unit != "1"
}

/// The reported parameters of a term whose parameters have these numbers, as yet without intervals; `slopes` are a reading's
/// derivatives by the term's parameters as they are estimated.
pub fn readings(
    term: &Term,
    lanes: &[Option<usize>],
    slopes: impl Fn(&Reading, &Term) -> Vec<f64>,
    plant: &Plant,
) -> Vec<Reported> {
    let one = |reading: &Reading| {
        let parameter = Parameter {
            name: reading.name.into(),
            value: reading.value,
            unit: unit_of(reading.unit, &plant.position_unit, &plant.drive_unit),
            ci95: [reading.value; 2],
        };
        let by = lanes.iter().zip(slopes(reading, term));
        (parameter, by.filter_map(|(lane, slope)| Some(((*lane)?, slope))).collect(), sort(term, reading))
    };
    term.effect.readings(&term.parameters).iter().map(one).collect()
}
