//! A run of a plant in equations: the classical fourth-order Runge–Kutta rule, divided where the argument of a sign or a
//! step passes zero. Where both sides push it back, it is held there (A. F. Filippov, Differential Equations with
//! Discontinuous Righthand Sides, 1988), as dry friction holds a mechanism.
//!
//! With numbers that carry derivatives, the times of these events carry theirs, so that sensitivities are exact.

use physics::number::{Dual, Number};
use physics::tape::{Instant, Side};
use pulp::{Arch, Simd, WithSimd};

use super::System;
use crate::signal::{Flow, Signal};

/// Changes of side in one step that are followed; beyond them the motion is smaller than the step resolves.
const MOST_EVENTS: usize = 6;
/// Steps of the search for the instant of an event.
const MOST_STEPS: usize = 30;
/// A state beyond this, in its unit, is no motion any more.
const RUNAWAY: f64 = 1e12;
/// Change by twice as many steps, over the largest output, that nobody sees.
const ACCURATE: f64 = 1e-6;
/// Most steps from row to row.
const MOST_SUBSTEPS: usize = 256;

/// An input between its samples.
pub trait Input: Sync {
    /// Value and rate at `t_s` since the first row, of the piece that `within_s` lies in.
    fn at(&self, t_s: f64, within_s: f64) -> Flow;
}

impl Input for Signal {
    fn at(&self, t_s: f64, within_s: f64) -> Flow {
        Signal::at(self, t_s, within_s)
    }
}

/// What a run goes along.
pub struct Course<'a> {
    /// The inputs.
    pub signals: &'a [&'a dyn Input],
    /// Time from row to row, s.
    pub sample_s: f64,
    /// Number of rows.
    pub rows: usize,
    /// Time at the first row, s.
    pub start_s: f64,
    /// Steps from one row to the next.
    pub substeps: usize,
    /// What keeps the run beside a recording, if anything: without it the run is free.
    pub observer: Option<Observer<'a>>,
}

/// A correction of the states that the output reads, at every row, by part of what it is off there. It keeps a simulation beside a recording
/// while the parameters are far from right, so that an estimate does not stop in a local minimum
/// (H. D. I. Abarbanel et al., SIAM J. Appl. Dyn. Syst. 8, 2009).
#[derive(Clone, Copy)]
pub struct Observer<'a> {
    /// The recorded output at every row.
    pub recorded: &'a [f64],
    /// The part, 0 to 1.
    pub part: f64,
}

/// A run that ended early.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the state `{state}` has no value, or one beyond all bounds, {t_s:.4} s after the first row: the equations diverge with \
     these numbers, or take the root or the logarithm of what is negative; check signs, units and ranges"
)]
pub struct Stopped {
    /// The state that has no value any more, or one beyond all bounds.
    pub state: String,
    /// When, in s since the first row.
    pub t_s: f64,
    /// Before which row.
    pub row: usize,
}

fitter::errors!(plain Stopped);

/// A run under way.
struct Run<'a, T> {
    system: &'a System,
    course: &'a Course<'a>,
    parameters: &'a [T],
    plain: Vec<f64>,
    states: Vec<T>,
    sides: Vec<Side>,
    registers: Vec<T>,
    inputs: Vec<T>,
    rates: [Vec<T>; 4],
    there: Vec<T>,
    /// Of every switch that is held: the derivatives of its argument by the states, and its rate where they stand still.
    held: Vec<(Vec<f64>, f64)>,
}

impl System {
    /// Runs from the states `start` at the first row; `visit` is given the number of every row and the output there.
    ///
    /// # Errors
    /// [`Stopped`].
    pub fn run<T: Number>(
        &self,
        parameters: &[T],
        start: &[T],
        course: &Course,
        visit: &mut dyn FnMut(usize, T),
    ) -> Result<(), Stopped> {
        let zero = T::from_f64(0.0);
        let mut run = Run {
            system: self,
            course,
            parameters,
            plain: parameters.iter().map(|p| p.value()).collect(),
            states: start.iter().copied().chain(self.lags().iter().map(|_| zero)).collect(),
            sides: vec![Side::Above; self.tape.switches().len()],
            registers: vec![zero; self.tape.registers()],
            inputs: vec![zero; self.inputs],
            rates: std::array::from_fn(|_| vec![zero; self.states()]),
            there: vec![zero; self.states()],
            held: Vec::new(),
        };
        run.begin();
        let mut at_row = |run: &mut Run<T>, row: usize| {
            let output = run.output(row);
            visit(row, output);
            if let Some(observer) = course.observer {
                run.correct(row, output, observer);
            }
        };
        at_row(&mut run, 0);
        let step_s = course.sample_s / course.substeps as f64;
        for row in 1..course.rows {
            for k in 0..course.substeps {
                run.advance(((row - 1) * course.substeps + k) as f64 * step_s, step_s);
            }
            run.alive(row)?;
            at_row(&mut run, row);
        }
        Ok(())
    }

    /// The outputs in so many steps from row to row that twice as many change nothing that can be seen.
    ///
    /// # Errors
    /// [`Stopped`], also where the steps would have to be shorter than can be waited for.
    pub fn converged(&self, parameters: &[f64], start: &[f64], course: Course) -> Result<Vec<f64>, Stopped> {
        let mut course = course;
        let mut coarse = self.outputs(parameters, start, &course);
        while course.substeps < MOST_SUBSTEPS {
            course.substeps *= 2;
            let fine = self.outputs(parameters, start, &course);
            if let (Ok(coarse), Ok(fine)) = (&coarse, &fine) {
                let size = fine.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
                let apart = coarse.iter().zip(fine).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                if apart <= ACCURATE * size {
                    break;
                }
            }
            coarse = fine;
        }
        coarse
    }

    /// What the output is after every row of a run with plain numbers.
    ///
    /// # Errors
    /// [`Stopped`].
    pub fn outputs(&self, parameters: &[f64], start: &[f64], course: &Course) -> Result<Vec<f64>, Stopped> {
        let mut outputs = Vec::with_capacity(course.rows);
        self.run(parameters, start, course, &mut |_, y: f64| outputs.push(y))?;
        Ok(outputs)
    }
}

/// One step of a run.
struct Step<'r, 'a, T> {
    run: &'r mut Run<'a, T>,
    t_s: T,
    h: T,
    within: f64,
}

impl<T: Number> WithSimd for Step<'_, '_, T> {
    type Output = Vec<T>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<T> {
        self.run.runge_kutta(self.t_s, self.h, self.within)
    }
}

impl<T: Number> Run<'_, T> {
    /// Lags begin settled, and every switch on the side to which the motion goes.
    fn begin(&mut self) {
        let within = 0.25 * self.course.sample_s;
        let system = self.system;
        for lag in system.lags() {
            self.compute(T::from_f64(0.0), within, None);
            self.states[lag.state] = self.registers[lag.start];
        }
        self.compute(T::from_f64(0.0), within, None);
        for (k, register) in system.tape.switches().iter().enumerate() {
            let argument = self.registers[*register].value();
            self.sides[k] = if argument < 0.0 { Side::Below } else { Side::Above };
        }
        for (k, register) in system.tape.switches().iter().enumerate() {
            if self.registers[*register].value() == 0.0 {
                self.sides[k] = self.side_after(k, 0.0, within, None);
            }
        }
    }

    /// The output at a row.
    fn output(&mut self, row: usize) -> T {
        let t_s = row as f64 * self.course.sample_s;
        self.compute(T::from_f64(t_s), t_s + 0.25 * self.course.sample_s, None);
        self.registers[self.system.output]
    }

    /// Corrects the states that the output of the plant reads, and the sides of switches that this takes across zero.
    fn correct(&mut self, row: usize, output: T, observer: Observer) {
        let t_s = row as f64 * self.course.sample_s;
        let within = t_s + 0.25 * self.course.sample_s;
        let off = (T::from_f64(observer.recorded[row]) - output) * observer.part;
        let slopes = self.slopes(self.system.read, t_s, within);
        let square: f64 = slopes.iter().map(|slope| slope * slope).sum();
        if square == 0.0 {
            return;
        }
        for (state, slope) in self.states.iter_mut().zip(&slopes) {
            *state = *state + off * (slope / square);
        }
        if self.sides.is_empty() {
            return;
        }
        self.compute(T::from_f64(t_s), within, None);
        for (side, register) in self.sides.iter_mut().zip(self.system.tape.switches()) {
            let argument = self.registers[*register].value();
            *side = match *side {
                Side::Above if argument < 0.0 => Side::Below,
                Side::Below if argument > 0.0 => Side::Above,
                same => same,
            };
        }
    }

    /// Refuses states that are no numbers, or beyond all bounds.
    fn alive(&self, row: usize) -> Result<(), Stopped> {
        let lost = self.states.iter().position(|x| x.value().is_nan() || x.value().abs() > RUNAWAY);
        lost.map_or(Ok(()), |k| {
            let state = self.system.names[k].clone();
            Err(Stopped { state, t_s: row as f64 * self.course.sample_s, row })
        })
    }

    /// All registers at an instant, of the present states or of others; `within` lies in the piece of the inputs that is
    /// meant.
    #[inline(always)]
    fn compute(&mut self, t_s: T, within: f64, states: Option<&[T]>) {
        for (input, signal) in self.inputs.iter_mut().zip(self.course.signals) {
            let flow = signal.at(t_s.value(), within);
            *input = t_s.chain(flow.value, flow.rate);
        }
        let instant = Instant {
            states: states.unwrap_or(&self.states),
            inputs: &self.inputs,
            parameters: self.parameters,
            t_s: t_s + T::from_f64(self.course.start_s),
            sides: &self.sides,
        };
        self.system.tape.run(&instant, &mut self.registers);
    }

    /// The rates at an instant into `rates[stage]`.
    #[inline(always)]
    fn rate(&mut self, stage: usize, t_s: T, within: f64, at: bool) {
        let there = std::mem::take(&mut self.there);
        self.compute(t_s, within, at.then_some(&there));
        let system = self.system;
        for (rate, register) in self.rates[stage].iter_mut().zip(&system.rates) {
            *rate = self.registers[*register];
        }
        for lag in system.lags() {
            let state = if at { there[lag.state] } else { self.states[lag.state] };
            let behind = self.registers[lag.input] - state;
            self.rates[stage][lag.state] = behind / self.registers[lag.tau];
        }
        self.there = there;
        // What is held stays at zero, whatever the parameters.
        for (slopes, alone) in &self.held {
            let square: f64 = slopes.iter().map(|slope| slope * slope).sum();
            let along = |sum: T, (rate, slope): (&T, &f64)| sum + *rate * *slope;
            let drift = self.rates[stage].iter().zip(slopes).fold(T::from_f64(*alone), along);
            for (rate, slope) in self.rates[stage].iter_mut().zip(slopes) {
                *rate = *rate - drift * (slope / square);
            }
        }
    }

    /// The states after `h` seconds from `t_s` on, in the widest registers that the processor has.
    fn step(&mut self, t_s: T, h: T, within: f64) -> Vec<T> {
        Arch::new().dispatch(Step { run: self, t_s, h, within })
    }

    #[inline(always)]
    fn runge_kutta(&mut self, t_s: T, h: T, within: f64) -> Vec<T> {
        self.rate(0, t_s, within, false);
        for (stage, part) in [(1, 0.5), (2, 0.5), (3, 1.0)] {
            let length = h * part;
            for k in 0..self.states.len() {
                self.there[k] = self.states[k] + self.rates[stage - 1][k] * length;
            }
            self.rate(stage, t_s + length, within, true);
        }
        let sixth = h * (1.0 / 6.0);
        let [a, b, c, d] = &self.rates;
        (0..self.states.len()).map(|k| self.states[k] + (a[k] + (b[k] + c[k]) * 2.0 + d[k]) * sixth).collect()
    }

    /// The argument of a switch in some states.
    fn argument(&mut self, switch: usize, t_s: T, within: f64, states: &[T]) -> T {
        self.compute(t_s, within, Some(states));
        self.registers[self.system.tape.switches()[switch]]
    }

    /// One step of `h` seconds from `t_s` on, divided where a switch changes its side.
    fn advance(&mut self, t_s: f64, h: f64) {
        let within = t_s + 0.5 * h;
        let (mut now, mut left) = (T::from_f64(t_s), T::from_f64(h));
        for _ in 0..MOST_EVENTS {
            self.hold(now.value(), within);
            let after = self.step(now, left, within);
            let Some((switch, to)) = self.crossed(now + left, within, &after) else {
                self.states = after;
                return;
            };
            let part = self.event(switch, (now, left), within, to);
            self.states = self.step(now, left * part, within);
            now += left * part;
            left = left * (T::from_f64(1.0) - part);
            let came = self.sides[switch];
            self.sides[switch] = self.side_after(switch, now.value(), within, Some(came));
            if left.value() <= 1e-9 * h {
                return;
            }
        }
        self.states = self.step(now, left, within);
    }

    /// The first switch whose argument has passed zero, and its argument after the step.
    fn crossed(&mut self, t_s: T, within: f64, after: &[T]) -> Option<(usize, f64)> {
        if self.sides.is_empty() {
            return None;
        }
        self.compute(t_s, within, Some(after));
        let system = self.system;
        let passed = |(k, register): (usize, &usize)| {
            let argument = self.registers[*register].value();
            let gone = match self.sides[k] {
                Side::Above => argument < 0.0,
                Side::Below => argument > 0.0,
                Side::Held(_) => false,
            };
            gone.then_some((k, argument))
        };
        system.tape.switches().iter().enumerate().find_map(passed)
    }

    /// The part of a step after which a switch's argument is zero, with its derivatives.
    fn event(&mut self, switch: usize, (now, left): (T, T), within: f64, to: f64) -> T {
        let states = self.states.clone();
        let from = self.argument(switch, now, within, &states).value();
        let mut ends = [(0.0, from), (1.0, to)];
        // It began on the other side already: an event a moment ago left it there.
        if from == 0.0 || (from > 0.0) == (to > 0.0) {
            return T::from_f64(0.0);
        }
        let (mut part, mut last) = (1.0, None);
        for _ in 0..MOST_STEPS {
            let [(a, fa), (b, fb)] = ends;
            part = a + (b - a) * (fa / (fa - fb));
            let there = self.step(now, left * part, within);
            let argument = self.argument(switch, now + left * part, within, &there).value();
            let end = usize::from((argument > 0.0) == (to > 0.0));
            // The Illinois rule: an end that stays counts for half.
            ends[1 - end].1 *= if last == Some(end) { 0.5 } else { 1.0 };
            ends[end] = (part, argument);
            last = Some(end);
            if argument.abs() <= 1e-13 * from.abs().max(to.abs()) || ends[1].0 - ends[0].0 < 1e-13 {
                break;
            }
        }
        let there = self.step(now, left * part, within);
        let argument = self.argument(switch, now + left * part, within, &there);
        let slope = self.drift(switch, (now + left * part).value(), within, &there) * left.value();
        let corrected = T::from_f64(part) - argument * (1.0 / slope);
        let sound = slope.is_finite() && slope != 0.0 && (corrected.value() - part).abs() < 0.02;
        if sound && (0.0..=1.0).contains(&corrected.value()) { corrected } else { T::from_f64(part) }
    }

    /// The rates of some states, without derivatives.
    fn plain_rates(&self, t_s: f64, within: f64, states: &[f64]) -> Vec<f64> {
        let system = self.system;
        let inputs: Vec<f64> =
            self.course.signals.iter().map(|signal| signal.at(t_s, within).value).collect();
        let instant = Instant {
            states,
            inputs: &inputs,
            parameters: &self.plain,
            t_s: t_s + self.course.start_s,
            sides: &self.sides,
        };
        let mut registers = vec![0.0; system.tape.registers()];
        system.tape.run(&instant, &mut registers);
        let own = system.rates.iter().map(|register| registers[*register]);
        let lags =
            system.lags().iter().map(|lag| (registers[lag.input] - states[lag.state]) / registers[lag.tau]);
        own.chain(lags).collect()
    }

    /// The derivative of a register along rates of the states, and of the time with its inputs where `timed`.
    fn along(
        &self,
        register: usize,
        t_s: f64,
        within: f64,
        (states, rates): (&[f64], &[f64]),
        timed: bool,
    ) -> f64 {
        let moving = |value: f64, rate: f64| Dual::<1> { value, slopes: [rate] };
        let pace = if timed { 1.0 } else { 0.0 };
        let states: Vec<Dual<1>> = states.iter().zip(rates).map(|(x, rate)| moving(*x, *rate)).collect();
        let flows = self.course.signals.iter().map(|signal| signal.at(t_s, within));
        let inputs: Vec<Dual<1>> = flows.map(|flow| moving(flow.value, pace * flow.rate)).collect();
        let parameters: Vec<Dual<1>> = self.plain.iter().map(|p| moving(*p, 0.0)).collect();
        let mut registers = vec![moving(0.0, 0.0); self.system.tape.registers()];
        let instant = Instant {
            states: &states,
            inputs: &inputs,
            parameters: &parameters,
            t_s: moving(t_s + self.course.start_s, pace),
            sides: &self.sides,
        };
        self.system.tape.run(&instant, &mut registers);
        registers[register].slopes[0]
    }

    /// The rate of a switch's argument along the motion, in some states.
    fn drift(&self, switch: usize, t_s: f64, within: f64, states: &[T]) -> f64 {
        let plain: Vec<f64> = states.iter().map(|x| x.value()).collect();
        let rates = self.plain_rates(t_s, within, &plain);
        self.along(self.system.tape.switches()[switch], t_s, within, (&plain, &rates), true)
    }

    /// The rates of a switch's argument on either side of zero.
    fn drifts(&mut self, switch: usize, t_s: f64, within: f64) -> [f64; 2] {
        let (states, now) = (self.states.clone(), self.sides[switch]);
        let both = [Side::Below, Side::Above].map(|side| {
            self.sides[switch] = side;
            self.drift(switch, t_s, within, &states)
        });
        self.sides[switch] = now;
        both
    }

    /// On which side a switch is whose argument is zero now, and was on side `came` before, where there is a before.
    fn side_after(&mut self, switch: usize, t_s: f64, within: f64, came: Option<Side>) -> Side {
        let [below, above] = self.drifts(switch, t_s, within);
        match came {
            // Both sides push it back.
            _ if above <= 0.0 && below >= 0.0 => Side::Held(held_part([below, above])),
            Some(Side::Above) if below < 0.0 => Side::Below,
            Some(Side::Below) if above > 0.0 => Side::Above,
            _ if above > 0.0 => Side::Above,
            _ => Side::Below,
        }
    }

    /// What holds each switch that is held, and which is held no longer.
    fn hold(&mut self, t_s: f64, within: f64) {
        self.held.clear();
        for switch in 0..self.sides.len() {
            if matches!(self.sides[switch], Side::Held(_)) {
                let drifts = self.drifts(switch, t_s, within);
                self.sides[switch] = match held_part(drifts) {
                    part if part > 1.0 => Side::Above,
                    part if part < -1.0 => Side::Below,
                    part => Side::Held(part),
                };
            }
            if matches!(self.sides[switch], Side::Held(_)) {
                let register = self.system.tape.switches()[switch];
                let slopes = self.slopes(register, t_s, within);
                let plain: Vec<f64> = self.states.iter().map(|x| x.value()).collect();
                let alone = self.along(register, t_s, within, (&plain, &vec![0.0; plain.len()]), true);
                if slopes.iter().any(|slope| *slope != 0.0) {
                    self.held.push((slopes, alone));
                }
            }
        }
    }

    /// The derivatives of a register by the states.
    fn slopes(&self, register: usize, t_s: f64, within: f64) -> Vec<f64> {
        let plain: Vec<f64> = self.states.iter().map(|x| x.value()).collect();
        let mut rates = vec![0.0; plain.len()];
        let mut by = |k: usize| {
            rates.fill(0.0);
            rates[k] = 1.0;
            self.along(register, t_s, within, (&plain, &rates), false)
        };
        (0..plain.len()).map(&mut by).collect()
    }
}

/// Where between both sides the value of a switch is that keeps its argument at zero, −1 being below and 1 above.
fn held_part([below, above]: [f64; 2]) -> f64 {
    let apart = above - below;
    if apart == 0.0 { 0.0 } else { -(above + below) / apart }
}

#[cfg(test)]
mod tests {
    use super::super::{MotionEffect, Plant};
    use super::*;
    use fitter::plant::PlantFile;
    use fitter::plant::equations::declared;

    const OSCILLATOR: &str = "[plant]\nkind = \"equations\"\n\
        states = { x = { unit = \"rad\", start = 1.0 }, v = { unit = \"rad/s\", start = 0.0 } }\noutput = { y = \"x\" }\n\
        [plant.equations]\nx = \"v\"\nv = \"-a * x\"\n[plant.parameters]\na = { unit = \"1/s^2\", value = 4.0 }\n";
    const FRICTION: &str =
        "[[effect]]\nid = \"dry\"\nequation.v = \"-f * sign(v)\"\nf = { unit = \"rad/s^2\" }\n";

    fn system() -> System {
        let file = PlantFile::parse("plant.toml", OSCILLATOR).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let texts = declared("mine.toml", FRICTION).unwrap();
        let effects: Vec<MotionEffect> =
            texts.iter().map(|text| plant.effect("mine.toml", text).unwrap()).collect();
        System::new(&plant, &effects.iter().collect::<Vec<_>>()).unwrap()
    }

    fn course(substeps: usize) -> Course<'static> {
        Course { signals: &[], sample_s: 0.05, rows: 261, start_s: 0.0, substeps, observer: None }
    }

    /// x″ = −4x − 0.3 sign x′: every half swing about ∓0.075 loses 0.15, until it sticks.
    fn exact(t_s: f64) -> f64 {
        let (offset, half) = (0.075, std::f64::consts::PI / 2.0);
        let (mut from, mut side) = (1.0, 1.0);
        for swing in 0.. {
            let begun = f64::from(swing) * half;
            // It sticks where the spring is too weak.
            if f64::abs(from) <= offset {
                return from;
            }
            if t_s < begun + half {
                return side * offset + (from - side * offset) * (2.0 * (t_s - begun)).cos();
            }
            from = 2.0 * side * offset - from;
            side = -side;
        }
        f64::NAN
    }

    #[test]
    fn dry_friction_takes_the_same_from_every_swing_and_holds_in_the_end() {
        for substeps in [1, 2, 4] {
            let outputs = system().outputs(&[4.0, 0.3], &[1.0, 0.0], &course(substeps)).unwrap();
            let largest = outputs.iter().enumerate().map(|(k, y)| (y - exact(0.05 * k as f64)).abs());
            let largest = largest.fold(0.0, f64::max);
            let expected = 2e-5 / (substeps as f64).powi(4);
            assert!(largest < expected, "{substeps}: {largest:e}, expected {expected:e}");
            assert_eq!(outputs[260], outputs[230], "it is held");
        }
    }

    #[test]
    fn sensitivities_hold_across_events() {
        let system = system();
        let at = |f: f64, x: f64| system.outputs(&[4.0, f], &[x, 0.0], &course(8)).unwrap();
        let numbers = [Dual::<2>::from_f64(4.0), Dual::variable(0.3, 0)];
        let mut slopes = Vec::new();
        let start = [Dual::variable(1.0, 1), Dual::from_f64(0.0)];
        system.run(&numbers, &start, &course(8), &mut |_, y: Dual<2>| slopes.push(y.slopes)).unwrap();
        let h = 1e-6;
        let [by_f, by_x] = [[at(0.3 + h, 1.0), at(0.3 - h, 1.0)], [at(0.3, 1.0 + h), at(0.3, 1.0 - h)]];
        for (k, [f, x]) in slopes.iter().enumerate() {
            let along = |both: &[Vec<f64>; 2]| (both[0][k] - both[1][k]) / (2.0 * h);
            assert!((f - along(&by_f)).abs() < 1e-4, "row {k} by friction: {f} {}", along(&by_f));
            assert!((x - along(&by_x)).abs() < 1e-4, "row {k} by start: {x} {}", along(&by_x));
        }
    }
}
