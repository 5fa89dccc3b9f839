//! The equations of motion: one inertia on a spring and a damper, driven through its drive elements, with
//! whatever forces act on it, seen through its read-out.

use std::collections::BTreeMap;

use fitter::plant::{Numbers, PlantEffect};

use super::effects::{Action, Context, Element, Force, Motion, Typical, catalogue, find};
use super::signal::{Flow, Signal};
use crate::values::{EffectError, Values};

/// Position and velocity come first among the states.
const X: usize = 0;
const V: usize = 1;

/// A mechanism and everything that acts in it.
pub struct Mechanism {
    /// Damping per inertia in 1/s.
    pub damping: f64,
    /// Stiffness per inertia in 1/s².
    pub stiffness: f64,
    /// Gain of each drive per inertia.
    pub gains: Vec<f64>,
    paths: Vec<Vec<Placed<dyn Element>>>,
    forces: Vec<Placed<dyn Force>>,
    read_out: Vec<Placed<dyn Element>>,
    states: usize,
}

/// Something with its place among the states.
struct Placed<A: ?Sized> {
    first: usize,
    count: usize,
    acts: Box<A>,
}

impl<A: ?Sized> Placed<A> {
    /// Its part of the states or of their rates.
    fn own<'y>(&self, y: &'y [f64]) -> &'y [f64] {
        &y[self.first..self.first + self.count]
    }

    fn own_mut<'y>(&self, y: &'y mut [f64]) -> &'y mut [f64] {
        &mut y[self.first..self.first + self.count]
    }
}

/// Whether dry friction lets the mechanism move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// There is no dry friction.
    Free,
    /// It moves in this direction (±1).
    Sliding(f64),
    /// It is held.
    Stuck,
}

/// The state at which the equations are evaluated: the time, a time inside the piece of the drives that is
/// meant, and the mode.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Instant {
    pub t_s: f64,
    pub within_s: f64,
    pub mode: Mode,
}

impl Mechanism {
    /// A mechanism without effects.
    pub fn new(damping: f64, stiffness: f64, gains: Vec<f64>) -> Self {
        let paths = gains.iter().map(|_| Vec::new()).collect();
        Self { damping, stiffness, gains, paths, forces: Vec::new(), read_out: Vec::new(), states: 2 }
    }

    /// Lets effects act in it.
    ///
    /// # Errors
    /// An id or a parameter that is not known, missing, or makes no sense.
    pub fn with(mut self, effects: &[PlantEffect], context: &Context) -> Result<Self, EffectError> {
        let mut ordered: Vec<&PlantEffect> = effects.iter().collect();
        ordered.sort_by_key(|effect| catalogue::place(&effect.id));
        for effect in ordered {
            for drive in 0..self.gains.len() {
                match build(effect, drive, context)? {
                    Action::Drive(acts) => {
                        let placed = self.placed(acts.states(), acts);
                        self.paths[drive].push(placed);
                        continue;
                    }
                    Action::Force(acts) => {
                        let placed = self.placed(acts.states(), acts);
                        self.forces.push(placed);
                    }
                    Action::ReadOut(acts) => {
                        let placed = self.placed(acts.states(), acts);
                        self.read_out.push(placed);
                    }
                }
                break;
            }
        }
        Ok(self)
    }

    fn placed<A: ?Sized>(&mut self, count: usize, acts: Box<A>) -> Placed<A> {
        let first = self.states;
        self.states += count;
        Placed { first, count, acts }
    }

    /// How many states it has.
    pub fn states(&self) -> usize {
        self.states
    }

    /// The delay of each drive in seconds.
    pub(crate) fn delays_s(&self) -> Vec<f64> {
        self.paths.iter().map(|path| path.iter().map(|element| element.acts.delay_s()).sum()).collect()
    }

    /// The size that each state typically has.
    pub(crate) fn scales(&self, typical: &Typical) -> Vec<f64> {
        let mut scales = vec![typical.drive; self.states];
        (scales[X], scales[V]) = (typical.position, typical.velocity);
        for force in &self.forces {
            force.own_mut(&mut scales).copy_from_slice(&force.acts.scales(typical));
        }
        for element in &self.read_out {
            element.own_mut(&mut scales).fill(typical.position);
        }
        scales
    }

    /// The state at rest at a position, with everything that follows it settled there: lags on their inputs,
    /// attached masses beside it. Hysteresis is at its origin.
    pub fn at(&self, position: f64, velocity: f64, drives: &[f64]) -> Vec<f64> {
        let mut state = vec![0.0; self.states];
        (state[X], state[V]) = (position, velocity);
        let inputs = self.paths.iter().zip(drives.iter().copied());
        for (path, value) in inputs.chain(std::iter::once((&self.read_out, position))) {
            let mut flow = Flow { value, rate: 0.0 };
            for element in path {
                element.own_mut(&mut state).fill(flow.value);
                flow = element.acts.pass(0.0, flow, element.own(&state), &mut vec![0.0; element.count]);
            }
        }
        for force in self.forces.iter().filter(|force| force.count == 2) {
            force.own_mut(&mut state).copy_from_slice(&[position, velocity]);
        }
        state
    }

    /// Whether dry friction acts.
    pub(crate) fn is_dry(&self) -> bool {
        self.forces.iter().any(|force| force.acts.is_dry())
    }

    /// Whether the integration has to pause where an input turns round.
    pub(crate) fn remembers_turns(&self) -> bool {
        self.paths.iter().flatten().any(|element| element.acts.remembers_turns())
    }

    /// What passes each drive's path at `y`, the rates of the path's own states going into `rates`; `input` is
    /// called with what enters each element.
    fn drives(
        &self,
        instant: &Instant,
        y: &[f64],
        rates: &mut [f64],
        signals: &[Signal],
        mut input: impl FnMut(usize, usize, Flow),
    ) -> [f64; 2] {
        let (mut force, mut first) = (0.0, 0.0);
        for (drive, (path, signal)) in self.paths.iter().zip(signals).enumerate() {
            let delay: f64 = path.iter().map(|element| element.acts.delay_s()).sum();
            let mut flow = signal.at(instant.t_s - delay, instant.within_s - delay);
            for (index, element) in path.iter().enumerate() {
                input(drive, index, flow);
                flow = element.acts.pass(instant.t_s, flow, element.own(y), element.own_mut(rates));
            }
            force += self.gains[drive] * flow.value;
            if drive == 0 {
                first = flow.value;
            }
        }
        [force, first]
    }

    /// The rates of all states, and the acceleration without dry friction.
    pub(crate) fn rates(&self, instant: &Instant, y: &[f64], rates: &mut [f64], signals: &[Signal]) -> f64 {
        let [mut push, drive] = self.drives(instant, y, rates, signals, |_, _, _| {});
        let held = instant.mode == Mode::Stuck;
        let at = Motion { t_s: instant.t_s, x: y[X], v: if held { 0.0 } else { y[V] }, drive };
        for force in &self.forces {
            push *= force.acts.drive_factor(&at);
        }
        let mut acceleration = push - self.damping * at.v - self.stiffness * at.x;
        for force in &self.forces {
            acceleration += force.acts.acceleration(&at, force.own(y), force.own_mut(rates));
        }
        (rates[X], rates[V]) = match instant.mode {
            Mode::Free => (at.v, acceleration),
            Mode::Sliding(direction) => (at.v, acceleration - direction * self.friction(&at, direction)),
            Mode::Stuck => (0.0, 0.0),
        };
        self.read_rates(instant.t_s, y, rates);
        acceleration
    }

    fn read_rates(&self, t_s: f64, y: &[f64], rates: &mut [f64]) -> f64 {
        let position = Flow { value: y[X], rate: y[V] };
        let passed = |flow, element: &Placed<dyn Element>| {
            element.acts.pass(t_s, flow, element.own(y), element.own_mut(rates))
        };
        self.read_out.iter().fold(position, passed).value
    }

    /// What reaches the mechanism of its first drive.
    pub(crate) fn reaching(&self, instant: &Instant, y: &[f64], signals: &[Signal]) -> f64 {
        self.drives(instant, y, &mut vec![0.0; self.states], signals, |_, _, _| {})[1]
    }

    /// What is read at the state `y`.
    pub(crate) fn read(&self, t_s: f64, y: &[f64]) -> f64 {
        self.read_rates(t_s, y, &mut vec![0.0; self.states])
    }

    /// Dry friction against `direction`.
    pub(crate) fn friction(&self, at: &Motion, direction: f64) -> f64 {
        self.forces.iter().map(|force| force.acts.friction(at, direction)).sum()
    }

    /// Dry friction that holds the mechanism at the state `y`, at rest, against a force in `direction`.
    pub(crate) fn holding(&self, t_s: f64, y: &[f64], direction: f64) -> f64 {
        self.friction(&Motion { t_s, x: y[X], v: 0.0, drive: 0.0 }, direction)
    }

    /// The rate of what enters each element that remembers turns.
    pub(crate) fn turning(&self, instant: &Instant, y: &[f64], signals: &[Signal]) -> Vec<f64> {
        let mut turning = Vec::new();
        let mut rates = vec![0.0; self.states];
        self.drives(instant, y, &mut rates, signals, |drive, index, flow| {
            if self.paths[drive][index].acts.remembers_turns() {
                turning.push(flow.rate);
            }
        });
        turning
    }

    /// Tells everything that remembers where the mechanism has come.
    pub(crate) fn remember(&mut self, instant: &Instant, y: &[f64], signals: &[Signal]) {
        if self.remembers_turns() {
            let mut inputs = Vec::new();
            let mut rates = vec![0.0; self.states];
            self.drives(instant, y, &mut rates, signals, |drive, index, flow| {
                inputs.push((drive, index, flow.value));
            });
            for (drive, index, value) in inputs {
                self.paths[drive][index].acts.remember(value);
            }
        }
        let at = Motion { t_s: instant.t_s, x: y[X], v: y[V], drive: 0.0 };
        self.forces.iter_mut().for_each(|force| force.acts.remember(&at));
    }
}

/// The part of an effect that acts on drive `index` or on the mechanism.
fn build(effect: &PlantEffect, index: usize, context: &Context) -> Result<Action, EffectError> {
    let id = || effect.id.clone();
    let specification = find(&effect.id).ok_or_else(|| EffectError::Id {
        id: id(),
        expected: catalogue::ALL.iter().map(|s| s.id).collect::<Vec<_>>().join(", "),
    })?;
    let mut given = BTreeMap::new();
    let mut several = false;
    for (name, numbers) in &effect.parameters {
        several |= matches!(numbers, Numbers::Each(_));
        let value = numbers.get(index).ok_or_else(|| EffectError::Refused {
            id: id(),
            reason: format!("`{name}` has no number for drive {}; give one for each drive", index + 1),
        })?;
        given.insert(name.clone(), value);
    }
    let values = Values::check(&effect.id, specification.parameters, &given)?;
    let action = (specification.build)(&values, context);
    if several && !matches!(action, Action::Drive(_)) {
        return Err(EffectError::Refused {
            id: id(),
            reason: String::from("it does not act on the drives; give each parameter as a single number"),
        });
    }
    Ok(action)
}
