//! The equation of motion and one step of it: the classical fourth-order Runge–Kutta rule, divided where dry
//! friction changes its direction.

use super::effects::{DynamicEffect, Flow, MOST_STATES, Physics};
use super::model::{MOST_EXTRA, Model};
use super::number::Number;
use super::simulate::Theta;
use super::turns::Turns;

/// Changes of direction within one step of the integrator that are followed; beyond them the motion is
/// smaller than the step resolves.
const MOST_EVENTS: usize = 4;

/// Position, velocity and the effects' own states.
#[derive(Clone, Copy)]
pub struct State<T> {
    /// Position.
    pub p: T,
    /// Velocity.
    pub v: T,
    /// States of the effects.
    pub z: [T; MOST_EXTRA],
}

/// The drive at the beginning, middle and end of a step.
#[derive(Clone, Copy)]
pub struct Span<T> {
    /// At the beginning.
    pub from: T,
    /// In the middle.
    pub middle: T,
    /// At the end.
    pub to: T,
}

impl<T: Number> Span<T> {
    /// The drive at a part of the step, on the parabola through the three.
    fn at(&self, s: T) -> T {
        let rise = self.to - self.from;
        let bend = (self.from + self.to - self.middle * 2.0) * 2.0;
        self.from + s * rise - s * (T::from_f64(1.0) - s) * bend
    }

    /// The part of it from `s` on.
    fn rest(&self, s: T) -> Span<T> {
        let half = (s + T::from_f64(1.0)) * 0.5;
        Span { from: self.at(s), middle: self.at(half), to: self.to }
    }

    /// Middle and end after a hysteresis, which has to see where the drive turns round in between.
    pub fn remembered(&self, coefficient: T, turns: &mut Turns<T>) -> (T, T) {
        let (from, middle, to) = (self.from.value(), self.middle.value(), self.to.value());
        let (rise, bend) = (to - from, 2.0 * (from + to - 2.0 * middle));
        let vertex = 0.5 * (1.0 - rise / bend);
        let turn = |inside: bool, turns: &mut Turns<T>| {
            if inside {
                turns.to(self.at(T::from_f64(vertex)));
            }
        };
        turn(vertex > 0.0 && vertex < 0.5, turns);
        let middle = self.middle + coefficient * turns.to(self.middle);
        turn(vertex > 0.5 && vertex < 1.0, turns);
        (middle, self.to + coefficient * turns.to(self.to))
    }

    /// The part of it up to `s`.
    fn up_to(&self, s: T) -> Span<T> {
        Span { from: self.from, middle: self.at(s * 0.5), to: self.at(s) }
    }
}

/// A term of which only the sensitivities to its amounts are wanted, these being zero: its forces per unit
/// are plain numbers along the motion.
pub struct Probe {
    /// The effect.
    pub effect: &'static dyn DynamicEffect,
    /// Direction of an amount, and the parameters with that amount one and the others zero.
    pub units: Vec<(usize, Vec<f64>)>,
    /// Place of its states.
    pub first: usize,
}

/// A model prepared for simulation with numbers of one kind.
pub struct Machine<'a, T> {
    /// The model.
    pub model: &'a Model,
    /// Its parameters.
    pub theta: &'a Theta<T>,
    /// Terms that act on the acceleration, with the place of their states.
    pub forces: Vec<(usize, usize)>,
    /// What is only probed.
    pub probes: Vec<Probe>,
    /// Number of states of the effects.
    pub extra: usize,
    /// Whether dry friction acts.
    pub friction: bool,
    /// Time at the start of the present step, s.
    pub time: f64,
}

impl<T: Number> Machine<'_, T>
where
    dyn DynamicEffect: Physics<T>,
{
    /// Acceleration and rates of the further states.
    #[inline]
    fn rates(&self, state: &State<T>, drive: T, direction: f64) -> State<T> {
        let [damping, stiffness, gain] = self.theta.nominal;
        let zero = T::from_f64(0.0);
        let mut rates = State { p: state.v, v: zero, z: [zero; MOST_EXTRA] };
        let mut acceleration = gain * drive - damping * state.v - stiffness * state.p;
        for &(k, first) in &self.forces {
            let effect = self.model.terms[k].effect;
            let last = first + effect.states();
            let mut flow = Flow {
                drive,
                position: state.p,
                velocity: state.v,
                gain,
                direction,
                time: self.time,
                acceleration,
                states: &state.z[first..last],
                rates: &mut rates.z[first..last],
            };
            Physics::<T>::force(effect, &self.theta.terms[k], &mut flow);
            acceleration = flow.acceleration;
        }
        for probe in &self.probes {
            self.probe(probe, state, drive, direction, &mut acceleration, &mut rates.z);
        }
        rates.v = acceleration;
        rates
    }

    /// Adds a probe's forces per unit to the derivatives of the acceleration along its amounts.
    fn probe(
        &self,
        probe: &Probe,
        state: &State<T>,
        drive: T,
        direction: f64,
        acceleration: &mut T,
        z: &mut [T; MOST_EXTRA],
    ) {
        let count = probe.effect.states();
        let (mut own, mut rates) = ([0.0; MOST_STATES], [0.0; MOST_STATES]);
        for (o, z) in own.iter_mut().zip(&state.z[probe.first..probe.first + count]) {
            *o = z.value();
        }
        let velocity = state.v.value();
        for (lane, parameters) in &probe.units {
            let mut flow = Flow {
                drive: drive.value(),
                position: state.p.value(),
                velocity,
                gain: self.theta.nominal[2].value(),
                direction: if self.friction { direction } else { velocity.signum() },
                time: self.time,
                acceleration: 0.0,
                states: &own[..count],
                rates: &mut rates[..count],
            };
            Physics::<f64>::force(probe.effect, parameters, &mut flow);
            acceleration.nudge(*lane, flow.acceleration);
        }
        for (z, rate) in z[probe.first..].iter_mut().zip(&rates[..count]) {
            *z = T::from_f64(*rate);
        }
    }

    fn moved(&self, state: &State<T>, h: T, rates: &State<T>) -> State<T> {
        let mut to = *state;
        to.p = to.p + h * rates.p;
        to.v = to.v + h * rates.v;
        for k in 0..self.extra {
            to.z[k] = to.z[k] + h * rates.z[k];
        }
        to
    }

    /// One Runge–Kutta step of length `h`.
    pub fn step(&self, state: &State<T>, h: T, span: &Span<T>, direction: f64) -> State<T> {
        let half = h * 0.5;
        let k1 = self.rates(state, span.from, direction);
        let k2 = self.rates(&self.moved(state, half, &k1), span.middle, direction);
        let k3 = self.rates(&self.moved(state, half, &k2), span.middle, direction);
        let k4 = self.rates(&self.moved(state, h, &k3), span.to, direction);
        let sixth = h * (1.0 / 6.0);
        let mut to = *state;
        to.p = to.p + sixth * (k1.p + (k2.p + k3.p) * 2.0 + k4.p);
        to.v = to.v + sixth * (k1.v + (k2.v + k3.v) * 2.0 + k4.v);
        for k in 0..self.extra {
            to.z[k] = to.z[k] + sixth * (k1.z[k] + (k2.z[k] + k3.z[k]) * 2.0 + k4.z[k]);
        }
        to
    }

    /// Acceleration without dry friction of a mechanism that stands still.
    fn pull(&self, state: &State<T>, drive: T) -> f64 {
        self.rates(state, drive, 0.0).v.value()
    }

    /// Speed of a mechanism that dry friction holds: v = c artanh(force/holding force).
    fn creep(&self, state: &State<T>, drive: T) -> T {
        let zero = T::from_f64(0.0);
        let friction = self.model.terms.iter().position(|t| !t.probe && t.effect.creep().is_some());
        let Some(k) = friction else { return zero };
        let effect = self.model.terms[k].effect;
        let parameters = &self.theta.terms[k];
        let creep = effect.creep().map_or(zero, |c| parameters[c]);
        let amounts = parameters.iter().zip(effect.parameters()).filter(|(_, p)| !p.shape);
        let holds = amounts.fold(zero, |sum, (p, _)| sum + *p);
        if holds.value() <= 0.0 {
            return zero;
        }
        let still = State { v: zero, ..*state };
        let part = self.rates(&still, drive, 0.0).v / holds;
        // Close to the holding force it breaks loose rather than creeping ever faster.
        if part.value().abs() < 0.999 { creep * part.artanh() } else { creep * (3.8 * part.value().signum()) }
    }

    /// Acceleration up to which dry friction holds the mechanism.
    pub fn holds(&self) -> f64 {
        let one = |(effect, parameters): (&'static dyn DynamicEffect, &Vec<T>)| {
            effect.holds(&parameters.iter().map(|p| p.value()).collect::<Vec<_>>())
        };
        self.model.terms.iter().map(|t| t.effect).zip(&self.theta.terms).map(one).sum()
    }

    /// One step with dry friction: it is divided where the velocity passes zero.
    pub fn step_with_friction(
        &self,
        mut state: State<T>,
        h: f64,
        span: &Span<T>,
        direction: &mut f64,
        holds: f64,
    ) -> State<T> {
        let zero = T::from_f64(0.0);
        let one = T::from_f64(1.0);
        let mut left = T::from_f64(h);
        let mut span = *span;
        for event in 0..=MOST_EVENTS {
            if *direction == 0.0 {
                let pull = self.pull(&state, span.from);
                if pull.abs() <= holds {
                    // It creeps at most, while its further states go on.
                    let mut to = self.step(&state, left, &span, 0.0);
                    to.p = state.p + left * self.creep(&state, span.middle);
                    to.v = zero;
                    return to;
                }
                *direction = pull.signum();
            }
            let to = self.step(&state, left, &span, *direction);
            if to.v.value() * *direction >= 0.0 || event == MOST_EVENTS {
                return to;
            }
            // The velocity passes zero: by the secant, once corrected.
            let mut part = state.v / (state.v - to.v);
            if part.value().is_nan() || part.value() <= 0.0 {
                part = zero;
            }
            let mut there = self.step(&state, left * part, &span.up_to(part), *direction);
            let slope = self.rates(&there, span.at(part), *direction).v;
            if slope.value() * *direction < 0.0 {
                let corrected = part - there.v / (slope * left);
                if corrected.value() > 0.0 && corrected.value() < 1.0 {
                    part = corrected;
                    there = self.step(&state, left * part, &span.up_to(part), *direction);
                }
            }
            there.v = zero;
            state = there;
            span = span.rest(part);
            left = left * (one - part);
            *direction = 0.0;
        }
        state
    }
}
