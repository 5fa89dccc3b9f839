//! The equation of motion and one step of it: the classical fourth-order Runge–Kutta rule, divided where dry
//! friction changes its direction.

use std::ops::Mul;

use physics::number::Number;
use pulp::Arch;

use super::effects::{DynamicEffect, Flow, Part};
use super::model::{Model, Term};
use super::simulate::Theta;
use super::span::Span;
use super::step::{Room, Step};
use crate::thresholds::dynamic::machine::{MOST_EVENTS, MOST_STEPS, TURNED};

/// Position, velocity, and the states of effects, for which there are `Z` places, and `Q` for what is only probed.
#[derive(Clone, Copy)]
pub struct State<T, const Z: usize, const Q: usize> {
    pub p: T,
    pub v: T,
    /// States of the effects.
    pub z: [T; Z],
    /// States of what is probed: they follow the motion, and the motion does not follow them.
    pub q: [f64; Q],
}

impl<T: Number, const Z: usize, const Q: usize> State<T, Z, Q> {
    pub(super) fn zero() -> State<T, Z, Q> {
        let zero = T::from_f64(0.0);
        State { p: zero, v: zero, z: [zero; Z], q: [0.0; Q] }
    }
}

/// A term of which only the sensitivities to its amounts are wanted, these being zero: its forces per unit
/// are plain numbers along the motion.
pub struct Probe {
    pub effect: &'static DynamicEffect,
    /// Direction of an amount, and the parameters with that amount one and the others zero.
    pub units: Vec<(usize, Vec<f64>)>,
    /// Place of its states.
    pub first: usize,
}

/// The amounts of a term that is probed, each with its direction.
fn units<T: Number>(term: &Term, theta: &[T]) -> Vec<(usize, Vec<f64>)> {
    let zeroed = (term.effect.parameters.iter().zip(&term.parameters))
        .map(|(p, value)| if p.shape { *value } else { 0.0 });
    let zeroed: Vec<f64> = zeroed.collect();
    let unit = |(j, x): (usize, &T)| {
        let mut parameters = zeroed.clone();
        parameters[j] = 1.0;
        x.direction().map(|lane| (lane, parameters))
    };
    theta.iter().enumerate().filter_map(unit).collect()
}

/// The sum of an effect's amounts.
fn amounts<T: Number>(effect: &DynamicEffect, parameters: &[T]) -> T {
    let amounts = parameters.iter().zip(effect.parameters).filter(|(_, p)| !p.shape);
    amounts.fold(T::from_f64(0.0), |sum, (p, _)| sum + *p)
}

/// A model prepared for simulation with numbers of one kind.
pub struct Machine<'a, T, const Z: usize, const Q: usize> {
    pub model: &'a Model,
    pub theta: &'a Theta<T>,
    /// Terms that act on the acceleration, with the place of their states.
    pub forces: Vec<(usize, usize)>,
    /// What is only probed.
    pub probes: Vec<Probe>,
    /// Number of states of the effects, and of what is probed.
    pub extra: (usize, usize),
    /// Whether dry friction acts.
    pub friction: bool,
    /// Time at the start of the present step, s.
    pub time: f64,
}

impl<'a, T: Number, const Z: usize, const Q: usize> Machine<'a, T, Z, Q> {
    /// A model at work, and its state with this position and velocity.
    pub fn new(model: &'a Model, theta: &'a Theta<T>, [p, v]: [T; 2]) -> (Self, State<T, Z, Q>) {
        let (mut forces, mut probes, mut extra) = (Vec::new(), Vec::new(), (0, 0));
        let mut state = State { p, v, ..State::zero() };
        for k in model.acting(Part::Force) {
            let effect = model.terms[k].effect;
            let rest = (effect.rest)(p.value());
            let rest = rest.iter().take(effect.states);
            if model.terms[k].probe {
                probes.push(Probe { effect, units: units(&model.terms[k], &theta.terms[k]), first: extra.1 });
                state.q.iter_mut().skip(extra.1).zip(rest).for_each(|(q, rest)| *q = *rest);
                extra.1 += effect.states;
            } else {
                forces.push((k, extra.0));
                for (z, rest) in state.z.iter_mut().skip(extra.0).zip(rest) {
                    // A state that starts with the position shares its derivatives.
                    *z = if *rest == p.value() && *rest != 0.0 { p } else { T::from_f64(*rest) };
                }
                extra.0 += effect.states;
            }
        }
        let friction = model.has_friction();
        (Machine { model, theta, forces, probes, extra, friction, time: 0.0 }, state)
    }

    /// Velocity, acceleration and rates of the further states.
    #[inline(always)]
    pub(super) fn rates(
        &self,
        state: &State<T, Z, Q>,
        drive: &T,
        direction: f64,
        rates: &mut State<T, Z, Q>,
    ) {
        let [damping, stiffness, gain] = &self.theta.nominal;
        rates.p = state.v;
        rates.v = *gain * *drive - *damping * state.v - *stiffness * state.p;
        for &(k, first) in &self.forces {
            let effect = self.model.terms[k].effect;
            let last = first + effect.states;
            let mut flow = Flow {
                drive,
                position: &state.p,
                velocity: &state.v,
                gain,
                direction,
                time: self.time,
                acceleration: &mut rates.v,
                states: &state.z[first..last],
                rates: &mut rates.z[first..last],
            };
            effect.force_widely(&self.theta.terms[k], &mut flow);
        }
        for probe in &self.probes {
            self.probe(probe, state, drive, direction, rates);
        }
    }

    /// Adds a probe's forces per unit to the derivatives of the acceleration along its amounts.
    fn probe(
        &self,
        probe: &Probe,
        state: &State<T, Z, Q>,
        drive: &T,
        direction: f64,
        to: &mut State<T, Z, Q>,
    ) {
        let count = probe.effect.states;
        let own = probe.first..probe.first + count;
        let velocity = state.v.value();
        for (lane, parameters) in &probe.units {
            let mut acceleration = 0.0;
            let mut flow = Flow {
                drive: &drive.value(),
                position: &state.p.value(),
                velocity: &velocity,
                gain: &self.theta.nominal[2].value(),
                direction: if self.friction { direction } else { velocity.signum() },
                time: self.time,
                acceleration: &mut acceleration,
                states: &state.q[own.clone()],
                rates: &mut to.q[own.clone()],
            };
            probe.effect.law.force(parameters, &mut flow);
            to.v.nudge(*lane, acceleration);
        }
    }

    /// Moves a state along rates for a time.
    #[inline(always)]
    pub(super) fn advance<H: Number>(
        &self,
        state: &mut State<T, Z, Q>,
        (time, seconds): (H, f64),
        rates: &State<T, Z, Q>,
    ) where
        T: Mul<H, Output = T>,
    {
        state.p += rates.p * time;
        state.v += rates.v * time;
        for k in 0..self.extra.0.min(Z) {
            state.z[k] += rates.z[k] * time;
        }
        for k in 0..self.extra.1.min(Q) {
            state.q[k] += rates.q[k] * seconds;
        }
    }

    /// Copies what is in use of a state.
    #[inline(always)]
    pub fn copy(&self, to: &mut State<T, Z, Q>, from: &State<T, Z, Q>) {
        (to.p, to.v) = (from.p, from.v);
        for k in 0..self.extra.0.min(Z) {
            to.z[k] = from.z[k];
        }
        for k in 0..self.extra.1.min(Q) {
            to.q[k] = from.q[k];
        }
    }

    /// One Runge–Kutta step of length `h`, which has derivatives only where an event ends it.
    fn step<H: Number>(&self, state: &State<T, Z, Q>, h: H, span: &Span<T>, direction: f64) -> State<T, Z, Q>
    where
        T: Mul<H, Output = T>,
    {
        let mut room = Room::empty();
        self.step_into(&mut room, state, h, span, direction);
        room.to
    }

    /// The same, in room that is used again: the state afterwards is its `to`.
    pub fn step_into<H: Number>(
        &self,
        room: &mut Room<T, Z, Q>,
        state: &State<T, Z, Q>,
        h: H,
        span: &Span<T>,
        direction: f64,
    ) where
        T: Mul<H, Output = T>,
    {
        Arch::new().dispatch(Step { machine: self, room, state, h, span, direction });
    }

    /// Acceleration; in the direction 0 that without dry friction.
    fn acceleration(&self, state: &State<T, Z, Q>, drive: &T, direction: f64) -> T {
        let mut rates = State::zero();
        self.rates(state, drive, direction, &mut rates);
        rates.v
    }

    /// Speed of a mechanism that dry friction holds: v = c artanh(force/holding force).
    fn creep(&self, state: &State<T, Z, Q>, drive: &T) -> T {
        let zero = T::from_f64(0.0);
        let friction = self.model.terms.iter().position(|t| !t.probe && t.effect.creep().is_some());
        let Some(k) = friction else { return zero };
        let effect = self.model.terms[k].effect;
        let parameters = &self.theta.terms[k];
        let creep = effect.creep().map_or(zero, |c| parameters[c]);
        let holds = amounts(effect, parameters);
        if holds.value() <= 0.0 {
            return zero;
        }
        let still = State { v: zero, ..*state };
        let part = self.acceleration(&still, drive, 0.0) / holds;
        // Close to the holding force it breaks loose rather than creeping ever faster.
        if part.value().abs() < 0.999 { creep * part.artanh() } else { creep * (3.8 * part.value().signum()) }
    }

    /// Acceleration up to which dry friction holds the mechanism.
    pub fn holds(&self) -> f64 {
        let creeping = self.model.terms.iter().zip(&self.theta.terms).filter(|(t, _)| t.effect.creeps);
        creeping.map(|(t, parameters)| amounts(t.effect, parameters).value().max(0.0)).sum()
    }

    /// The part of a step after which a mechanism that is held breaks loose, and in which direction; none where it
    /// is still held at the end.
    fn loose(&self, state: &State<T, Z, Q>, span: &Span<T>, pull: T, holds: f64) -> Option<(T, f64)> {
        let end = self.acceleration(state, &span.to, 0.0);
        let way = end.value().signum();
        // What is missing in this direction, at the beginning, at the end and in between.
        let missing = |pull: T| T::from_f64(holds) - pull * way;
        let (first, last) = (missing(pull), missing(end));
        if last.value() >= 0.0 {
            return None;
        }
        let mut part = first / (first - last);
        let there = missing(self.acceleration(state, &span.at(part), 0.0));
        let better = if there.value() > 0.0 {
            part + (T::from_f64(1.0) - part) * (there / (there - last))
        } else {
            part * (first / (first - there))
        };
        if better.value() > 0.0 && better.value() < 1.0 {
            part = better;
        }
        Some((part, way))
    }

    /// Where the velocity passes zero in a step of length `left` that ends at `to`, as a part of that step, and the state there.
    /// Found by the secant, then by Newton's rule, halved where that leaves the bracket.
    fn turned(
        &self,
        state: &State<T, Z, Q>,
        left: T,
        span: &Span<T>,
        direction: f64,
        to: &State<T, Z, Q>,
    ) -> (T, State<T, Z, Q>) {
        let least = TURNED * (state.v.value().abs() + to.v.value().abs());
        let (mut before, mut after) = (0.0, 1.0);
        let mut part = state.v / (state.v - to.v);
        for _ in 0..MOST_STEPS {
            if !(part.value() > before && part.value() < after) {
                part = T::from_f64(0.5 * (before + after));
            }
            let there = self.step(state, left * part, &span.up_to(part), direction);
            if there.v.value().abs() <= least {
                return (part, there);
            }
            let end = if there.v.value() * direction > 0.0 { &mut before } else { &mut after };
            *end = part.value();
            let slope = self.acceleration(&there, &span.at(part), direction);
            part = part - there.v / (slope * left);
        }
        (part, self.step(state, left * part, &span.up_to(part), direction))
    }

    /// One step with dry friction: it is divided where the velocity passes zero.
    pub fn step_with_friction(
        &self,
        mut state: State<T, Z, Q>,
        h: f64,
        span: &Span<T>,
        direction: &mut f64,
        holds: f64,
    ) -> State<T, Z, Q> {
        let zero = T::from_f64(0.0);
        let one = T::from_f64(1.0);
        let mut left = T::from_f64(h);
        let mut span = *span;
        for event in 0..=MOST_EVENTS {
            if *direction == 0.0 {
                let pull = self.acceleration(&state, &span.from, 0.0);
                if pull.value().abs() <= holds {
                    // It creeps at most, while its further states go on.
                    let stuck = |time: T, span: &Span<T>| {
                        let mut to = self.step(&state, time, span, 0.0);
                        to.p = state.p + time * self.creep(&state, &span.middle);
                        to.v = zero;
                        to
                    };
                    let Some((part, loose)) = self.loose(&state, &span, pull, holds) else {
                        return stuck(left, &span);
                    };
                    state = stuck(left * part, &span.up_to(part));
                    span = span.rest(part);
                    left = left * (one - part);
                    *direction = loose;
                } else {
                    *direction = pull.value().signum();
                }
            }
            let to = self.step(&state, left, &span, *direction);
            if to.v.value() * *direction >= 0.0 || event == MOST_EVENTS {
                return to;
            }
            let (part, mut there) = self.turned(&state, left, &span, *direction, &to);
            there.v = zero;
            state = there;
            span = span.rest(part);
            left = left * (one - part);
            *direction = 0.0;
        }
        state
    }
}
