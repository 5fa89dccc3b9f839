//! The equations of motion: one inertia on a spring and a damper, driven through its drive elements, with
//! whatever forces act on it, seen through its read-out.

use std::collections::BTreeMap;

use fitter::plant::{Numbers, PlantEffect};

use super::effects::{Action, Context, DriveElement, Force, Motion, ReadOut, Typical, catalogue, find};
use super::signal::{Flow, Signal};
use crate::values::{EffectError, Known, Values};

/// Position and velocity come first among the states.
const X: usize = 0;
const V: usize = 1;

/// A mechanism and everything that acts in it.
#[derive(Debug)]
pub struct Mechanism {
    /// Damping per inertia in 1/s.
    pub damping: f64,
    /// Stiffness per inertia in 1/s².
    pub stiffness: f64,
    /// Gain of each drive per inertia.
    pub gains: Vec<f64>,
    paths: Vec<Vec<Placed<dyn DriveElement>>>,
    forces: Vec<Placed<dyn Force>>,
    read_outs: Vec<Placed<dyn ReadOut>>,
    states: usize,
}

/// Something with its place among the states.
#[derive(Debug)]
struct Placed<A: ?Sized> {
    first: usize,
    count: usize,
    acts: Box<A>,
}

impl<A: ?Sized> Placed<A> {
    fn own<'y>(&self, y: &'y [f64]) -> &'y [f64] {
        &y[self.first..self.first + self.count]
    }

    fn rates<'y>(&self, y: &'y mut [f64]) -> &'y mut [f64] {
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
        Self { damping, stiffness, gains, paths, forces: Vec::new(), read_outs: Vec::new(), states: 2 }
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
                        let (first, count) = self.place(acts.states());
                        self.paths[drive].push(Placed { first, count, acts });
                        continue;
                    }
                    Action::Force(acts) => {
                        let (first, count) = self.place(acts.states());
                        self.forces.push(Placed { first, count, acts });
                    }
                    Action::ReadOut(acts) => {
                        let (first, count) = self.place(acts.states());
                        self.read_outs.push(Placed { first, count, acts });
                    }
                }
                break;
            }
        }
        Ok(self)
    }

    fn place(&mut self, count: usize) -> (usize, usize) {
        let first = self.states;
        self.states += count;
        (first, count)
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
            force.rates(&mut scales).copy_from_slice(&force.acts.scales(typical));
        }
        for read_out in &self.read_outs {
            read_out.rates(&mut scales).fill(typical.position);
        }
        scales
    }

    /// The state at rest at a position, with everything that follows it settled there: lags on their inputs,
    /// attached masses beside it. Hysteresis is at its origin.
    pub fn at(&self, position: f64, velocity: f64, drives: &[f64]) -> Vec<f64> {
        let mut state = vec![0.0; self.states];
        (state[X], state[V]) = (position, velocity);
        for (path, drive) in self.paths.iter().zip(drives) {
            let mut flow = Flow { value: *drive, rate: 0.0 };
            for element in path {
                let mut rates = vec![0.0; element.count];
                element.own_mut(&mut state).fill(flow.value);
                flow = element.acts.pass(0.0, flow, element.own(&state), &mut rates);
            }
        }
        for force in self.forces.iter().filter(|force| force.count == 2) {
            force.own_mut(&mut state).copy_from_slice(&[position, velocity]);
        }
        let mut read = position;
        for read_out in &self.read_outs {
            let mut rates = vec![0.0; read_out.count];
            read_out.own_mut(&mut state).fill(read);
            read = read_out.acts.read(read, read_out.own(&state), &mut rates);
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
                flow = element.acts.pass(instant.t_s, flow, element.own(y), element.rates(rates));
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
            acceleration += force.acts.acceleration(&at, force.own(y), force.rates(rates));
        }
        (rates[X], rates[V]) = match instant.mode {
            Mode::Free => (at.v, acceleration),
            Mode::Sliding(direction) => (at.v, acceleration - direction * self.friction(&at, direction)),
            Mode::Stuck => (0.0, 0.0),
        };
        self.read_rates(y, rates);
        acceleration
    }

    fn read_rates(&self, y: &[f64], rates: &mut [f64]) -> f64 {
        let mut read = y[X];
        for read_out in &self.read_outs {
            read = read_out.acts.read(read, read_out.own(y), read_out.rates(rates));
        }
        read
    }

    /// What reaches the mechanism of its first drive.
    pub(crate) fn reaching(&self, instant: &Instant, y: &[f64], signals: &[Signal]) -> f64 {
        self.drives(instant, y, &mut vec![0.0; self.states], signals, |_, _, _| {})[1]
    }

    /// What is read at the state `y`.
    pub(crate) fn read(&self, y: &[f64]) -> f64 {
        self.read_rates(y, &mut vec![0.0; self.states])
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

impl<A: ?Sized> Placed<A> {
    fn own_mut<'y>(&self, y: &'y mut [f64]) -> &'y mut [f64] {
        self.rates(y)
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
    let known: Vec<Known> = specification
        .parameters
        .iter()
        .map(|p| Known { name: p.name, unit: p.unit, default: p.default, range: p.range })
        .collect();
    let values = Values::check(&effect.id, &known, &given)?;
    let action = (specification.build)(&values, context)
        .map_err(|reason| EffectError::Refused { id: id(), reason })?;
    if several && !matches!(action, Action::Drive(_)) {
        return Err(EffectError::Refused {
            id: id(),
            reason: String::from("it does not act on the drives; give each parameter as a single number"),
        });
    }
    Ok(action)
}
