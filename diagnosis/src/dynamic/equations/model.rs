//! A plant in equations with effects, as an estimate has it.

use std::sync::Arc;

use fitter::plant::Hold;
use motion::equations::{Course, EquationsError, MotionEffect, Observer, Plant, Stopped, System};
use physics::Parameter;
use physics::number::{Dual, Number};

use super::super::accurate::Refined;
use super::super::data::Data;
use super::super::estimate::Simulated;
use super::super::gram::{Grams, through};
use super::super::simulate::Unstable;
use crate::thresholds::dynamic::equations::LOGARITHMIC;

/// An effect with its parameters.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: Arc<MotionEffect>,
    /// Its parameters.
    pub values: Vec<f64>,
    /// Whether those with a range are kept as they are.
    pub kept: bool,
}

/// See the module.
#[derive(Clone)]
pub struct Model {
    /// The plant.
    pub plant: Arc<Plant>,
    /// Its equations with the effects.
    pub system: Arc<System>,
    /// The plant's parameters.
    pub values: Vec<f64>,
    /// The effects; those of the plant's own file first.
    pub terms: Vec<Term>,
    /// How the inputs run between their samples.
    pub hold: Hold,
    /// Steps of the classical rule from row to row, or what is as accurate.
    pub substeps: usize,
    /// Which states begin where a fit says.
    pub free_starts: Vec<bool>,
    /// Part of what the output is off by that an observer corrects at every row; 0 in free run.
    pub observed: f64,
}

/// A parameter as an estimate sees it: by its logarithm where its range spans decades.
pub fn is_logarithmic(parameter: &Parameter) -> bool {
    parameter.range.is_some_and(|range| range.from > 0.0 && range.to > LOGARITHMIC * range.from)
}

impl Model {
    /// A plant with the effects of its file, its parameters at these values.
    ///
    /// # Errors
    /// [`EquationsError`].
    pub fn new(plant: Arc<Plant>, values: Vec<f64>, hold: Hold) -> Result<Model, EquationsError> {
        let held = plant.effects.iter();
        let terms: Vec<Term> = held
            .map(|(effect, values)| Term {
                effect: Arc::new(effect.clone()),
                values: values.clone(),
                kept: false,
            })
            .collect();
        let effects: Vec<&MotionEffect> = terms.iter().map(|term| &*term.effect).collect();
        let system = Arc::new(System::new(&plant, &effects)?);
        let free_starts = plant.starts.iter().map(Option::is_none).collect();
        Ok(Model { plant, system, values, terms, hold, substeps: 1, free_starts, observed: 0.0 })
    }

    /// The model with other terms; none where no equation can hold one of them.
    pub fn with_terms(&self, terms: Vec<Term>) -> Option<Model> {
        let effects: Vec<&MotionEffect> = terms.iter().map(|term| &*term.effect).collect();
        let system = Arc::new(System::new(&self.plant, &effects).ok()?);
        Some(Model { system, terms, ..self.clone() })
    }

    /// The model with nothing but its initial states free.
    pub fn fixed(&self) -> Model {
        let mut plant = (*self.plant).clone();
        let held = |value: &f64| Some(physics::Interval { from: *value, to: *value });
        plant.parameters.iter_mut().zip(&self.values).for_each(|(p, value)| p.range = held(value));
        let mut model = Model { plant: Arc::new(plant), ..self.clone() };
        for term in &mut model.terms {
            let mut effect = (*term.effect).clone();
            effect.parameters.iter_mut().zip(&term.values).for_each(|(p, value)| p.range = held(value));
            (term.effect, term.kept) = (Arc::new(effect), true);
        }
        model
    }

    /// Every parameter with its value, and whether an estimate may change it.
    fn parameters(&self) -> impl Iterator<Item = (&Parameter, f64, bool)> {
        let own = self.plant.parameters.iter().zip(&self.values);
        let own = own.enumerate().map(|(k, (parameter, value))| (parameter, *value, self.plant.is_free(k)));
        let of_terms = self.terms.iter().flat_map(|term| {
            let free = |parameter: &Parameter| parameter.range.is_none() || !term.kept;
            term.effect.parameters.iter().zip(&term.values).map(move |(p, value)| (p, *value, free(p)))
        });
        own.chain(of_terms)
    }

    /// Numbers of the free parameters of term `k` among the packed ones, none for what is kept.
    pub fn packed_of(&self, term: usize) -> Vec<Option<usize>> {
        let before: usize =
            self.values.len() + self.terms[..term].iter().map(|t| t.values.len()).sum::<usize>();
        let mut number = 0;
        let numbered: Vec<Option<usize>> = self
            .parameters()
            .map(|(.., free)| {
                number += usize::from(free);
                free.then(|| number - 1)
            })
            .collect();
        numbered[before..before + self.terms[term].values.len()].to_vec()
    }

    /// Derivative of the value of every free parameter by what is estimated in its place.
    pub fn slopes(&self) -> Vec<f64> {
        let free = self.parameters().filter(|(.., free)| *free);
        free.map(|(p, value, _)| if is_logarithmic(p) { value } else { 1.0 }).collect()
    }

    /// All values, the plant's first.
    pub fn all_values(&self) -> Vec<f64> {
        self.parameters().map(|(_, value, _)| value).collect()
    }

    /// What run `number` goes along.
    fn along<T>(
        &self,
        data: &Data,
        number: usize,
        run: impl FnOnce(&Course) -> Result<T, Stopped>,
    ) -> Result<T, Unstable> {
        let mut signals = data.inputs(number, self.hold);
        signals.truncate(self.plant.inputs.len());
        let course = Course {
            signals: &signals,
            sample_s: data.step_s,
            rows: data.runs[number].len(),
            start_s: data.starts_s[number],
            substeps: self.substeps,
            observer: (self.observed > 0.0).then(|| Observer {
                recorded: &data.position[data.runs[number].clone()],
                part: self.observed,
            }),
        };
        run(&course).map_err(|stopped| Unstable(stopped.row))
    }

    fn grams<const N: usize, const F: usize>(
        &self,
        starts: &[Vec<f64>],
        data: &Data,
        filters: [&[f64]; F],
    ) -> Result<[Grams; F], Unstable> {
        let states = self.free_starts.iter().filter(|free| **free).count();
        let mut lane = states;
        let mut variable = |value: f64, slope: f64| {
            lane += 1;
            Dual::<N>::variable(value, lane - 1).chain(value, slope)
        };
        let numbers = self.parameters().map(|(p, value, free)| match free {
            true => variable(value, if is_logarithmic(p) { value } else { 1.0 }),
            false => Dual::from_f64(value),
        });
        let numbers: Vec<Dual<N>> = numbers.collect();
        let lanes = states + self.packed().len();
        through::<N, F>(states, lanes, data, filters, |number, visit| {
            let mut lane = 0;
            let start = starts[number].iter().zip(&self.free_starts).map(|(value, free)| {
                lane += usize::from(*free);
                if *free { Dual::variable(*value, lane - 1) } else { Dual::from_f64(*value) }
            });
            let start: Vec<Dual<N>> = start.collect();
            self.along(data, number, |course| self.system.run(&numbers, &start, course, visit))
        })
    }
}

impl Refined for Model {
    fn refinement(&self) -> usize {
        self.substeps
    }

    fn refined(&self, steps: usize) -> Model {
        Model { substeps: steps, ..self.clone() }
    }
}

impl Simulated for Model {
    /// Every state of the plant.
    type Start = Vec<f64>;

    fn packed(&self) -> Vec<f64> {
        let free = self.parameters().filter(|(.., free)| *free);
        free.map(|(p, value, _)| if is_logarithmic(p) { value.ln() } else { value }).collect()
    }

    fn unpacked(&self, packed: &[f64]) -> Model {
        let mut next = packed.iter().copied();
        let values: Vec<f64> = self
            .parameters()
            .map(|(p, old, free)| {
                let Some(estimated) = free.then(|| next.next()).flatten() else { return old };
                let value = if is_logarithmic(p) { estimated.exp() } else { estimated };
                p.range.map_or(value, |range| value.clamp(range.from, range.to))
            })
            .collect();
        let (own, mut rest) = values.split_at(self.values.len());
        let mut model = Model { values: own.to_vec(), ..self.clone() };
        for term in &mut model.terms {
            let (of_term, others) = rest.split_at(term.values.len());
            (term.values, rest) = (of_term.to_vec(), others);
        }
        model
    }

    fn moved(&self, start: &Vec<f64>, by: &[f64]) -> Vec<f64> {
        let mut by = by.iter();
        let moved =
            |(value, free): (&f64, &bool)| value + if *free { *by.next().unwrap_or(&0.0) } else { 0.0 };
        start.iter().zip(&self.free_starts).map(moved).collect()
    }

    fn normals<const F: usize>(
        &self,
        starts: &[Vec<f64>],
        data: &Data,
        filters: [&[f64]; F],
    ) -> Result<[Grams; F], Unstable> {
        match self.packed().len() + self.free_starts.iter().filter(|free| **free).count() {
            0..=8 => self.grams::<8, F>(starts, data, filters),
            9..=12 => self.grams::<12, F>(starts, data, filters),
            13..=16 => self.grams::<16, F>(starts, data, filters),
            _ => self.grams::<24, F>(starts, data, filters),
        }
    }

    fn positions(&self, starts: &[Vec<f64>], data: &Data) -> Result<Vec<f64>, Unstable> {
        let mut out = vec![f64::NAN; data.position.len()];
        let values = self.all_values();
        for (number, (run, start)) in data.runs.iter().zip(starts).enumerate() {
            let outputs = self.along(data, number, |course| self.system.outputs(&values, start, course))?;
            out[run.clone()].copy_from_slice(&outputs);
        }
        Ok(out)
    }
}
