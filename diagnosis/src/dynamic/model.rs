//! The model of a mechanism: the nominal second-order plant, how its drive runs between the samples, and
//! the effects that were added. Units are those of the recording.

use fitter::plant::Hold;

use super::accurate::Refined;
use super::data::Data;
use super::effects::{DynamicEffect, Part};
use super::estimate::Simulated;
use super::gram::{Grams, grams};
use super::simulate::{Theta, Unstable, simulate};

/// An effect with its parameters.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: &'static DynamicEffect,
    /// Its parameters.
    pub parameters: Vec<f64>,
    /// Which of them an estimate may change.
    pub free: Vec<bool>,
    /// Whether the term is only a probe: its amounts are zero, and all that is wanted is how the position
    /// would follow them.
    pub probe: bool,
}

impl Term {
    /// An effect all of whose parameters are free but those that keep their value.
    pub fn new(effect: &'static DynamicEffect, parameters: Vec<f64>) -> Term {
        let free = (0..parameters.len()).map(|k| k < effect.kept).collect();
        Term { effect, parameters, free, probe: false }
    }
}

/// position″ = −damping position′ − stiffness position + gain drive, and effects.
#[derive(Clone)]
pub struct Model {
    /// Damping per inertia, 1/s; stiffness per inertia, 1/s²; gain per inertia.
    pub nominal: [f64; 3],
    /// Which of the three an estimate may change.
    pub nominal_free: [bool; 3],
    /// How the drive runs between its samples.
    pub hold: Hold,
    /// Steps of the integrator where [`Model::substeps`] would take one.
    pub refinement: usize,
    /// The effects, in the order in which they were found.
    pub terms: Vec<Term>,
}

impl std::fmt::Debug for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} {:?}", self.hold, self.nominal)?;
        self.terms.iter().try_for_each(|t| write!(f, " {}{:?}", t.effect.id, t.parameters))
    }
}

impl Model {
    /// A plant without effects.
    pub fn nominal(nominal: [f64; 3], hold: Hold) -> Model {
        Model { nominal, nominal_free: [true; 3], hold, refinement: 1, terms: Vec::new() }
    }

    /// The model with one more term.
    pub fn with(&self, term: Term) -> Model {
        let mut model = self.clone();
        model.terms.push(term);
        model
    }

    /// The model without its term `k`.
    pub fn without(&self, k: usize) -> Model {
        let mut model = self.clone();
        model.terms.remove(k);
        model
    }

    /// Numbers of the free parameters of term `k` among the packed ones, none for what is kept.
    pub fn packed_of(&self, k: usize) -> Vec<Option<usize>> {
        let free = |all: &[bool]| all.iter().filter(|free| **free).count();
        let before: usize = self.terms[..k].iter().map(|term| free(&term.free)).sum();
        let mut next = free(&self.nominal_free) + before;
        let number = |free: &bool| {
            next += usize::from(*free);
            free.then(|| next - 1)
        };
        self.terms[k].free.iter().map(number).collect()
    }

    /// Number of free parameters.
    pub fn free(&self) -> usize {
        let terms: usize = self.terms.iter().map(|t| t.free.iter().filter(|f| **f).count()).sum();
        terms + self.nominal_free.iter().filter(|f| **f).count()
    }

    /// Steps of the integrator from one sample to the next, so that no motion of the model turns by more
    /// than about a seventh of a radian in one: the fourth-order rule is then right to 10⁻⁴ at a resonance
    /// of 5 % damping. Of an effect that acts within a row it knows nothing: see its `refinement`.
    pub fn substeps(&self, step_s: f64) -> usize {
        let own = self.nominal[1].abs().sqrt().max(0.1 * self.nominal[0].abs());
        let mut substeps = (own * step_s / 0.15).ceil();
        for term in &self.terms {
            substeps = substeps.max(((term.effect.fastest)(&term.parameters) * step_s / 0.3).ceil());
            if term.effect.abrupt && !term.probe {
                substeps = substeps.max(2.0);
            }
        }
        // As a float the cast is saturating.
        (substeps as usize).clamp(1, 32) * self.refinement
    }

    /// Number of states that the effects add to position and velocity, and of those of effects that are only
    /// probed.
    pub fn extra(&self) -> (usize, usize) {
        let of = |probe: bool| self.terms.iter().filter(|t| t.probe == probe).map(|t| t.effect.states).sum();
        (of(false), of(true))
    }

    /// Time after which none of these states depends on where it began, s.
    pub fn memory_s(&self) -> f64 {
        let with = self.terms.iter().filter(|t| t.effect.states > 0);
        with.map(|t| (t.effect.memory_s)(&t.parameters)).fold(0.0, f64::max)
    }

    /// Whether dry friction can hold the mechanism.
    pub fn has_friction(&self) -> bool {
        self.terms.iter().any(|t| !t.probe && t.effect.creep().is_some())
    }

    /// Terms that act on a part.
    pub fn acting(&self, part: Part) -> impl Iterator<Item = usize> + '_ {
        (0..self.terms.len()).filter(move |k| self.terms[*k].effect.part == part)
    }
}

impl Refined for Model {
    fn refinement(&self) -> usize {
        self.refinement
    }

    fn refined(&self, steps: usize) -> Model {
        Model { refinement: steps, ..self.clone() }
    }
}

impl Simulated for Model {
    /// Position and velocity.
    type Start = [f64; 2];

    /// Shapes by their logarithm.
    fn packed(&self) -> Vec<f64> {
        let nominal = (0..3).filter(|k| self.nominal_free[*k]).map(|k| self.nominal[k]);
        let terms = self.terms.iter().flat_map(|term| {
            let parameters = term.effect.parameters;
            (0..parameters.len()).filter(|k| term.free[*k]).map(move |k| match parameters[k].shape {
                true => term.parameters[k].ln(),
                false => term.parameters[k],
            })
        });
        nominal.chain(terms).collect()
    }

    fn unpacked(&self, packed: &[f64]) -> Model {
        let mut model = self.clone();
        let mut values = packed.iter().copied();
        let mut next = |old: f64| values.next().unwrap_or(old);
        for k in 0..3 {
            if self.nominal_free[k] {
                model.nominal[k] = next(model.nominal[k]);
            }
        }
        for term in &mut model.terms {
            for (k, parameter) in term.effect.parameters.iter().enumerate() {
                if term.free[k] {
                    term.parameters[k] = match parameter.shape {
                        true => next(term.parameters[k].ln()).clamp(-80.0, 80.0).exp(),
                        false => next(term.parameters[k]),
                    };
                }
            }
        }
        model
    }

    fn moved(&self, start: &[f64; 2], by: &[f64]) -> [f64; 2] {
        [start[0] + by[0], start[1] + by[1]]
    }

    fn normals<const F: usize>(
        &self,
        starts: &[[f64; 2]],
        data: &Data,
        filters: [&[f64]; F],
    ) -> Result<[Grams; F], Unstable> {
        grams(self, starts, data, filters)
    }

    fn positions(&self, starts: &[[f64; 2]], data: &Data) -> Result<Vec<f64>, Unstable> {
        let theta = Theta::plain(self);
        let mut out = vec![f64::NAN; data.position.len()];
        for (number, (run, start)) in data.runs.iter().zip(starts).enumerate() {
            let out = &mut out[run.clone()];
            simulate(self, &theta, &data.course(number, self), *start, &mut |k, y: f64| out[k] = y)?;
        }
        Ok(out)
    }
}
