//! Free-run simulation: the classical fourth-order Runge–Kutta rule with steps that end where dry friction
//! changes its direction, exact first-order lags on the way in and out. Written over [`Number`], so that
//! with derivative-carrying numbers it integrates the sensitivity equations alongside.

use super::effects::{DynamicEffect, Flow, Part, Physics};
use super::model::{MOST_EXTRA, Model};
use super::number::Number;
use super::signal::Signal;

/// Changes of direction within one step of the integrator that are followed; beyond them the motion is
/// smaller than the step resolves.
const MOST_EVENTS: usize = 4;

/// The parameters of a model as numbers of one kind.
pub struct Theta<T> {
    /// Damping, stiffness, gain.
    pub nominal: [T; 3],
    /// Parameters of every term.
    pub terms: Vec<Vec<T>>,
}

impl Theta<f64> {
    /// The plain numbers of a model.
    pub fn plain(model: &Model) -> Theta<f64> {
        Theta { nominal: model.nominal, terms: model.terms.iter().map(|t| t.parameters.clone()).collect() }
    }
}

/// The simulation left every bound: at which sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unstable(pub usize);

/// Position, velocity and the effects' own states.
#[derive(Clone, Copy)]
struct State<T> {
    p: T,
    v: T,
    z: [T; MOST_EXTRA],
}

/// The drive at the beginning, middle and end of a step.
#[derive(Clone, Copy)]
struct Span<T> {
    from: T,
    middle: T,
    to: T,
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

    /// The part of it up to `s`.
    fn up_to(&self, s: T) -> Span<T> {
        Span { from: self.from, middle: self.at(s * 0.5), to: self.at(s) }
    }
}

/// A model prepared for simulation with numbers of one kind.
struct Machine<'a, T> {
    model: &'a Model,
    theta: &'a Theta<T>,
    /// Terms that act on the acceleration, with the place of their states.
    forces: Vec<(usize, usize)>,
    extra: usize,
    friction: bool,
    /// Time at the start of the present step, s.
    time: f64,
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
        rates.v = acceleration;
        rates
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
    fn step(&self, state: &State<T>, h: T, span: &Span<T>, direction: f64) -> State<T> {
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
        let friction = self.model.terms.iter().position(|t| t.effect.creep().is_some());
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

    fn holds(&self) -> f64 {
        let one = |(effect, parameters): (&'static dyn DynamicEffect, &Vec<T>)| {
            effect.holds(&parameters.iter().map(|p| p.value()).collect::<Vec<_>>())
        };
        self.model.terms.iter().map(|t| t.effect).zip(&self.theta.terms).map(one).sum()
    }

    /// One step with dry friction: it is divided where the velocity passes zero.
    fn step_with_friction(
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

/// One first-order lag, exact where its input runs straight.
#[derive(Clone, Copy)]
struct Lag<T> {
    state: T,
    input: T,
}

impl<T: Number> Lag<T> {
    fn at_rest(input: T) -> Lag<T> {
        Lag { state: input, input }
    }

    fn advance(&mut self, input: T, time: f64, tau: T) -> T {
        // Far below the step it is a shift by τ; this keeps the exponent finite.
        let tau = if tau.value() > 1e-9 * time { tau } else { tau.chain(1e-9 * time, 1.0) };
        let ratio = tau * (1.0 / time);
        let decay = (-(T::from_f64(1.0) / ratio)).exp();
        let behind = (input - self.input) * ratio;
        self.state = input - behind + (self.state - self.input + behind) * decay;
        self.input = input;
        self.state
    }
}

/// What one run is simulated along.
pub struct Course<'a> {
    /// The drive.
    pub signal: &'a Signal,
    /// Time from row to row, s.
    pub step_s: f64,
    /// Number of rows.
    pub rows: usize,
    /// Time at the first row, s.
    pub start_s: f64,
    /// Bound of the position.
    pub bound: f64,
}

/// Simulates one run: from the initial position and velocity along the drive; `visit` is given every
/// sample's number and the position that is read out there.
///
/// # Errors
/// [`Unstable`] as soon as the position leaves its bound or is not finite.
pub fn simulate<T: Number>(
    model: &Model,
    theta: &Theta<T>,
    course: &Course,
    start: [T; 2],
    mut visit: impl FnMut(usize, T),
) -> Result<(), Unstable>
where
    dyn DynamicEffect: Physics<T>,
{
    let Course { signal, step_s, rows, start_s, bound } = *course;
    let zero = T::from_f64(0.0);
    let mut state = State { p: start[0], v: start[1], z: [zero; MOST_EXTRA] };
    let mut forces = Vec::new();
    let mut extra = 0;
    for k in model.acting(Part::Force) {
        let effect = model.terms[k].effect;
        for (i, rest) in effect.rest(start[0].value()).iter().take(effect.states()).enumerate() {
            // A state that starts with the position shares its derivatives.
            state.z[extra + i] =
                if *rest == start[0].value() && *rest != 0.0 { start[0] } else { T::from_f64(*rest) };
        }
        forces.push((k, extra));
        extra += effect.states();
    }
    let friction = model.has_friction();
    let mut machine = Machine { model, theta, forces, extra, friction, time: 0.0 };
    let holds = machine.holds();
    let mut direction = state.v.value().signum() * f64::from(state.v.value() != 0.0);
    let substeps = model.substeps(step_s);
    let part = 1.0 / substeps as f64;
    let h = step_s * part;
    let delays: Vec<usize> = model.acting(Part::Delay).collect();
    let shaping: Vec<usize> = model.acting(Part::Drive).collect();
    let raw = |k: usize, s: f64| -> T {
        let mut w = match delays.as_slice() {
            [] => T::from_f64(signal.at(k, s)),
            several => {
                let delay = several.iter().fold(zero, |sum, d| sum + theta.terms[*d][0]);
                signal.delayed(k, s, delay, 0.5 * part)
            }
        };
        for &d in &shaping {
            w = Physics::<T>::drive(model.terms[d].effect, &theta.terms[d], w);
        }
        w
    };
    let first = raw(0, 0.0);
    let mut lags: Vec<(usize, Lag<T>)> =
        model.acting(Part::DriveLag).map(|k| (k, Lag::at_rest(first))).collect();
    let mut reading: Vec<(usize, Lag<T>)> =
        model.acting(Part::SensorLag).map(|k| (k, Lag::at_rest(state.p))).collect();
    let offset = model.acting(Part::SensorOffset).fold(zero, |sum, k| sum + theta.terms[k][0]);
    visit(0, state.p + offset);
    for k in 0..rows - 1 {
        let mut from = raw(k, 0.0);
        if !lags.is_empty() {
            // Where the drive jumps the lag's output does not.
            let mut input = from;
            for (_, lag) in &mut lags {
                lag.input = input;
                input = lag.state;
            }
            from = input;
        }
        for i in 0..substeps {
            let s = i as f64 * part;
            machine.time = start_s + (k as f64 + s) * step_s;
            let (mut middle, mut to) = (raw(k, s + 0.5 * part), raw(k, s + part));
            for (term, lag) in &mut lags {
                let tau = theta.terms[*term][0];
                middle = lag.advance(middle, 0.5 * h, tau);
                to = lag.advance(to, 0.5 * h, tau);
            }
            let span = Span { from, middle, to };
            state = if machine.friction {
                machine.step_with_friction(state, h, &span, &mut direction, holds)
            } else {
                machine.step(&state, T::from_f64(h), &span, 0.0)
            };
            from = to;
            let mut y = state.p;
            for (term, lag) in &mut reading {
                y = lag.advance(y, h, theta.terms[*term][0]);
            }
        }
        let p = state.p.value();
        if p.is_nan() || p.abs() > bound {
            return Err(Unstable(k + 1));
        }
        let y = reading.last().map_or(state.p, |(_, lag)| lag.state);
        visit(k + 1, y + offset);
    }
    Ok(())
}
