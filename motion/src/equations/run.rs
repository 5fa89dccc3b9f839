//! A run of a plant in equations: a Runge–Kutta rule ([`rule`](super::rule)), divided where the argument of a sign or a step
//! passes zero ([`events`](super::events)). With numbers that carry derivatives it yields its sensitivities exactly:
//! the derivatives of the rates by states and parameters are computed once for all directions.

use std::ops::Mul;

use physics::number::Number;
use physics::tape::{Places, Routine, Row, Side, Source};
use pulp::{Arch, Simd, WithSimd};

use super::System;
use super::input::{Input, Piece};
use super::rule::{MOST_STAGES, Rule};

/// Times this close, over the time from row to row, are the same.
pub(super) const NEAR: f64 = 1e-9;
/// A state beyond this, in its unit, is no motion any more.
const RUNAWAY: f64 = 1e12;
/// Change by twice as many steps, over the largest output, that nobody sees.
const ACCURATE: f64 = 1e-6;
/// Most steps from row to row: what settles within a hundredth of a row cannot be told from a wall.
const MOST_SUBSTEPS: usize = 64;
/// Most of the fastest time constant that a step goes, to be accurate.
const FASTEST: f64 = 1.0;
/// The same where steps can be no shorter: the rule is stable up to 2.78.
const STABLE: f64 = 2.5;
/// Squarings of a matrix whose spectral radius is estimated: to the sixteenth power, right to some percent.
const SQUARINGS: i32 = 4;

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
    /// Steps of the classical rule from one row to the next where nothing is faster, or what is as accurate with less work.
    pub substeps: usize,
    /// What keeps the run beside a recording, if anything: without it the run is free.
    pub observer: Option<Observer<'a>>,
}

/// A correction of the states that the output reads, at every row, by part of what it is off there. It keeps a simulation
/// beside a recording while the parameters are far from right, so that an estimate does not stop in a local minimum
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
#[error("the state `{state}` {}, {t_s:.4} s after the first row: {}", self.how(), self.why())]
pub struct Stopped {
    /// The state that has no value any more, or one beyond all bounds.
    pub state: String,
    /// When, in s since the first row.
    pub t_s: f64,
    /// Before which row.
    pub row: usize,
    /// Whether it changes too fast to be followed.
    pub stiff: bool,
}

impl Stopped {
    fn how(&self) -> &'static str {
        if self.stiff { "changes too fast to be followed" } else { "has no value, or one beyond all bounds" }
    }

    fn why(&self) -> String {
        match self.stiff {
            true => format!(
                "the equations are stiff with these numbers, with more than {MOST_SUBSTEPS} steps of the integration from row to \
                 row; give a factor less range, or leave out what settles so fast"
            ),
            false => "the equations diverge with these numbers, or take the root or the logarithm of what is negative; check \
                      signs, units and ranges"
                .into(),
        }
    }
}

fitter::errors!(plain Stopped);

/// What is computed at an instant.
pub(super) struct Routines {
    /// The rates of all states.
    rates: Routine,
    /// Their derivatives by the states.
    slopes: Routine,
    /// The rates where the instant itself moves with the parameters, or the rates of values are wanted.
    pub moving: Routine,
    /// The output.
    output: Routine,
    /// The output without effects, with all derivatives.
    read: Routine,
    /// The arguments of switches, without derivatives.
    pub sides: Routine,
    /// With all derivatives.
    pub arguments: Routine,
    /// Where states that operators bring with them begin.
    starts: Routine,
    /// The signals and gaps of plays.
    pub plays: Routine,
}

/// A further input: another one some time ago.
pub(super) struct Delay<T> {
    input: usize,
    by_s: T,
}

/// A run under way.
pub(super) struct Run<'a, T> {
    pub system: &'a System,
    pub course: &'a Course<'a>,
    parameters: &'a [T],
    delays: Vec<Delay<T>>,
    pub routines: Routines,
    pub registers: Vec<f64>,
    /// The inputs in the present step.
    pub pieces: Vec<Piece>,
    pub states: Vec<T>,
    /// The states after a step, and in it.
    pub after: Vec<T>,
    there: Vec<T>,
    /// States and sides at the row before.
    before: (Vec<T>, Vec<Side>),
    /// What [`Run::speed`] was at the row that was reached.
    reached: Option<(f64, usize)>,
    powers: [Vec<f64>; 2],
    rule: &'static Rule,
    pub rates: [Vec<T>; MOST_STAGES],
    pub sides: Vec<Side>,
    /// Of every switch that is held: the derivatives of its argument by the states, and its rate where they stand still.
    pub held: Vec<(Vec<f64>, f64)>,
}

/// Which of a run's states are meant.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum At {
    /// Those before the step.
    Before,
    /// Those in it.
    There,
    /// Those after it.
    After,
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
        let mut run = Run::new(self, parameters, start, course);
        run.begin();
        for row in 0..course.rows {
            if row > 0 {
                run.reach(row)?;
            }
            let output = run.output(row);
            visit(row, output);
            if let Some(observer) = course.observer {
                run.correct(row, output, observer);
            }
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

/// One step of a run from `t_s` on.
struct Step<'r, 'a, T, H> {
    run: &'r mut Run<'a, T>,
    t_s: H,
    h: H,
    moving: bool,
}

impl<T: Number + Mul<H, Output = T>, H: Number> WithSimd for Step<'_, '_, T, H> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.run.runge_kutta(self.t_s, self.h, self.moving);
    }
}

impl<'a, T: Number> Run<'a, T> {
    fn new(system: &'a System, parameters: &'a [T], start: &[T], course: &'a Course<'a>) -> Run<'a, T> {
        let zero = T::from_f64(0.0);
        let mut states = start.to_vec();
        states.resize(system.states(), zero);
        let plain: Vec<f64> = parameters.iter().map(|p| p.value()).collect();
        let bound = system.tape.bound(&plain);
        let with_states = zero.carries();
        let followed = |source: Source| match source {
            Source::State(_) => with_states,
            Source::Parameter(k) => parameters[k].moves(),
            Source::Input(k) => with_states && k >= system.inputs,
            Source::Time => false,
        };
        let all = |source: Source| match source {
            Source::Parameter(_) => followed(source),
            _ => true,
        };
        let of_delays: Vec<Row> = system.delays.iter().map(|(_, row)| row.clone()).collect();
        let of_delays = bound.routine(&of_delays, followed).rows;
        let of_plays: Vec<Row> = system.plays.iter().flat_map(|play| play.rows.clone()).collect();
        let routines = Routines {
            rates: bound.routine(&system.rates, followed),
            slopes: bound.routine(&system.rates, |source| matches!(source, Source::State(_))),
            moving: bound.routine(&system.rates, all),
            output: bound.routine(std::slice::from_ref(&system.output), followed),
            read: bound.routine(std::slice::from_ref(&system.read), all),
            sides: bound.routine(&system.arguments, |_| false),
            arguments: bound.routine(&system.arguments, all),
            starts: bound.routine(&system.starts, followed),
            plays: bound.routine(&of_plays, all),
        };
        let mut run = Run {
            system,
            course,
            parameters,
            delays: Vec::new(),
            routines,
            registers: bound.registers(),
            pieces: vec![Piece::NONE; system.inputs + system.delays.len()],
            after: states.clone(),
            there: states.clone(),
            before: (states.clone(), Vec::new()),
            reached: None,
            powers: [Vec::new(), Vec::new()],
            rule: Rule::for_steps(course.substeps).0,
            rates: std::array::from_fn(|_| states.clone()),
            states,
            sides: vec![Side::Above; system.arguments.len()],
            held: Vec::new(),
        };
        let delay = |((input, _), places): (&(usize, Row), &Places)| {
            // Only parameters are in it.
            Delay { input: *input, by_s: run.value(places, &[], 0.0) }
        };
        run.delays = system.delays.iter().zip(&of_delays).map(delay).collect();
        run
    }

    /// What operators remember begins settled, and every switch on the side to which the motion goes.
    fn begin(&mut self) {
        self.enter(0.25 * self.course.sample_s);
        let first = self.states.len() - self.system.starts.len();
        for memory in 0..self.system.starts.len() {
            self.load(0.0, At::Before);
            self.routines.starts.run(&self.sides, &mut self.registers);
            self.states[first + memory] = self.value(&self.routines.starts.rows[memory], &self.states, 0.0);
        }
        self.choose_sides();
    }

    /// The output at a row.
    fn output(&mut self, row: usize) -> T {
        let routine = &self.routines.output;
        let is_state = routine.length() == 0 && routine.rows[0].value < self.states.len();
        let t_s = row as f64 * self.course.sample_s;
        if !is_state {
            self.enter(t_s + 0.25 * self.course.sample_s);
        }
        self.load(t_s, At::Before);
        self.routines.output.run(&self.sides, &mut self.registers);
        self.value(&self.routines.output.rows[0], &self.states, t_s)
    }

    /// Goes on to a row, in shorter steps where the equations have a faster time constant.
    fn reach(&mut self, row: usize) -> Result<(), Stopped> {
        let sample_s = self.course.sample_s;
        self.before.0.clone_from(&self.states);
        self.before.1.clone_from(&self.sides);
        let before = match self.reached.take() {
            Some(speed) => speed,
            None => self.speed((row - 1) as f64 * sample_s, row),
        };
        let steps = |(speed, _): (f64, usize)| (speed * sample_s / FASTEST).ceil() as usize;
        let most = MOST_SUBSTEPS.max(self.course.substeps);
        let mut substeps = steps(before).clamp(self.course.substeps, most);
        loop {
            let (rule, count) = match substeps == self.course.substeps {
                true => Rule::for_steps(substeps),
                false => (Rule::classical(), substeps),
            };
            self.rule = rule;
            let step_s = sample_s / count as f64;
            for k in 0..count {
                self.advance(((row - 1) * count + k) as f64 * step_s, step_s);
            }
            let stopped = |state: usize, stiff: bool| {
                let state = self.system.names[state].clone();
                Err(Stopped { state, t_s: row as f64 * sample_s, row, stiff })
            };
            let after = self.speed(row as f64 * sample_s, row);
            let fastest = if after.0 > before.0 { after } else { before };
            let lost = self.states.iter().position(|x| x.value().is_nan() || x.value().abs() > RUNAWAY);
            // What ran away in steps too long for it, or needs shorter ones where it has come to.
            let wanted = if lost.is_some() { 4 * substeps } else { steps(after) };
            if substeps < most && wanted > substeps {
                substeps = wanted.min(most);
                self.states.clone_from(&self.before.0);
                self.sides.clone_from(&self.before.1);
                continue;
            }
            if let Some(state) = lost {
                return stopped(state, false);
            }
            if fastest.0 * sample_s > STABLE * substeps as f64 {
                return stopped(fastest.1, true);
            }
            self.states.iter_mut().for_each(T::forget);
            self.reached = self.course.observer.is_none().then_some(after);
            return Ok(());
        }
    }

    /// The spectral radius of the rates' derivatives by the states, 1/s, and the state that is fastest by itself. A motion
    /// that has settled shows no speed, but its derivatives would grow without bound in steps too long for it.
    fn speed(&mut self, t_s: f64, row: usize) -> (f64, usize) {
        self.enter((row as f64 - 0.5) * self.course.sample_s);
        self.load(t_s, At::Before);
        self.routines.slopes.run(&self.sides, &mut self.registers);
        let size = self.states.len();
        let [mut power, mut next] = std::mem::take(&mut self.powers);
        power.clear();
        power.resize(size * size, 0.0);
        for (k, places) in self.routines.slopes.rows.iter().enumerate() {
            places.states.iter().for_each(|(state, place)| power[k * size + state] = self.registers[*place]);
        }
        let by_itself = |k: &usize| power[k * (size + 1)].abs();
        let state = (0..size).max_by(|a, b| by_itself(a).total_cmp(&by_itself(b))).unwrap_or(0);
        // The sixteenth root of the norm of the sixteenth power, whatever the units.
        let mut radius = 1.0;
        for squaring in 0..=SQUARINGS {
            let norm = power.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if norm == 0.0 || !norm.is_finite() {
                radius = if norm == 0.0 { 0.0 } else { f64::MAX };
                break;
            }
            radius *= norm.powf(0.5_f64.powi(squaring));
            power.iter_mut().for_each(|x| *x /= norm);
            next.clear();
            next.extend((0..size * size).map(|k| {
                let (row, column) = (k / size * size, k % size);
                (0..size).map(|j| power[row + j] * power[j * size + column]).sum::<f64>()
            }));
            std::mem::swap(&mut power, &mut next);
        }
        self.powers = [power, next];
        (radius, state)
    }

    /// Corrects the states that the output of the plant reads, and the sides of switches that this takes across zero.
    fn correct(&mut self, row: usize, output: T, observer: Observer) {
        let t_s = row as f64 * self.course.sample_s;
        self.enter(t_s + 0.25 * self.course.sample_s);
        self.load(t_s, At::Before);
        self.routines.read.run(&self.sides, &mut self.registers);
        let slopes = &self.routines.read.rows[0].states;
        let square: f64 = slopes.iter().map(|(_, place)| self.registers[*place].powi(2)).sum();
        if square > 0.0 {
            let off = (T::from_f64(observer.recorded[row]) - output) * observer.part;
            for (state, place) in slopes {
                self.states[*state] = self.states[*state] + off * (self.registers[*place] / square);
            }
            self.turn_sides(t_s);
        }
    }

    /// Takes the pieces of the inputs that `within_s` lies in.
    #[inline(always)]
    pub fn enter(&mut self, within_s: f64) {
        self.enter_ago(within_s);
        for (piece, signal) in self.pieces.iter_mut().zip(self.course.signals) {
            if !piece.holds(within_s) {
                *piece = signal.piece(within_s);
            }
        }
    }

    /// The same of inputs that come later.
    #[inline(always)]
    pub fn enter_ago(&mut self, within_s: f64) {
        for (piece, delay) in self.pieces[self.system.inputs..].iter_mut().zip(&self.delays) {
            if !piece.holds(within_s) {
                let by_s = delay.by_s.value();
                *piece = self.course.signals[delay.input].piece(within_s - by_s);
                piece.from_s += by_s;
            }
        }
    }

    /// When a row reaches the mechanism through a delay from `from_s` on and before `to_s`, in order: an input may jump or
    /// bend there.
    pub fn breaks(&self, from_s: f64, to_s: f64) -> Vec<T> {
        let sample_s = self.course.sample_s;
        let near = NEAR * sample_s;
        let mut all = Vec::new();
        for Delay { input, by_s } in &self.delays {
            let mut row = ((from_s - near - by_s.value()) / sample_s).ceil();
            while row * sample_s + by_s.value() < to_s - near {
                if bends(self.course.signals[*input], row * sample_s, sample_s) {
                    all.push(*by_s + T::from_f64(row * sample_s));
                }
                row += 1.0;
            }
        }
        all.sort_by(|a, b| a.value().total_cmp(&b.value()));
        all
    }

    /// Writes states, inputs and time to the registers.
    #[inline(always)]
    pub fn load(&mut self, t_s: f64, at: At) {
        let states = match at {
            At::Before => &self.states,
            At::There => &self.there,
            At::After => &self.after,
        };
        let (of_states, rest) = self.registers.split_at_mut(states.len());
        for (register, state) in of_states.iter_mut().zip(states) {
            *register = state.value();
        }
        for (register, piece) in rest.iter_mut().zip(&self.pieces) {
            *register = piece.value(t_s);
        }
        rest[self.pieces.len()] = t_s + self.course.start_s;
    }

    /// A value that was computed in some states at a time, with its derivatives.
    #[inline(always)]
    pub fn value(&self, places: &Places, states: &[T], t_s: f64) -> T {
        let mut value = T::from_f64(self.registers[places.value]);
        for (state, place) in &places.states {
            value.follow(&states[*state], self.registers[*place]);
        }
        for (parameter, place) in &places.parameters {
            value.follow(&self.parameters[*parameter], self.registers[*place]);
        }
        for (input, place) in places.inputs.iter().filter(|(input, _)| *input >= self.system.inputs) {
            // The later it comes, the earlier a sample is felt.
            let rate = self.pieces[*input].rate(t_s);
            value.follow(&self.delays[*input - self.system.inputs].by_s, -self.registers[*place] * rate);
        }
        value
    }

    /// The rate of a value by the time and the inputs alone.
    #[inline(always)]
    pub fn pace(&self, places: &Places, t_s: f64) -> f64 {
        let own = places.time.map_or(0.0, |place| self.registers[place]);
        let inputs = places.inputs.iter();
        own + inputs.map(|(k, place)| self.registers[*place] * self.pieces[*k].rate(t_s)).sum::<f64>()
    }

    /// The rates at an instant into `rates[stage]`; `moving` where that instant has derivatives.
    #[inline(always)]
    pub fn rate<H: Number>(&mut self, stage: usize, t_s: H, at: At, moving: bool)
    where
        T: Mul<H, Output = T>,
    {
        self.load(t_s.value(), at);
        let routine = if moving { &self.routines.moving } else { &self.routines.rates };
        routine.run(&self.sides, &mut self.registers);
        let states = if at == At::There { &self.there } else { &self.states };
        for (k, places) in routine.rows.iter().enumerate() {
            let mut rate = self.value(places, states, t_s.value());
            if moving {
                rate.follow(&(T::from_f64(1.0) * t_s), self.pace(places, t_s.value()));
            }
            self.rates[stage][k] = rate;
        }
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
    pub fn step<H: Number>(&mut self, t_s: H, h: H, moving: bool)
    where
        T: Mul<H, Output = T>,
    {
        Arch::new().dispatch(Step { run: self, t_s, h, moving });
    }

    #[inline(always)]
    fn runge_kutta<H: Number>(&mut self, t_s: H, h: H, moving: bool)
    where
        T: Mul<H, Output = T>,
    {
        let rule = self.rule;
        self.rate(0, t_s, At::Before, moving);
        for (stage, (part, of)) in rule.stages.iter().enumerate().skip(1) {
            for (k, there) in self.there.iter_mut().enumerate() {
                *there = self.states[k] + weighted(&self.rates, k, of) * h;
            }
            self.rate(stage, t_s + h * *part, At::There, moving);
        }
        for (k, after) in self.after.iter_mut().enumerate() {
            *after = self.states[k] + weighted(&self.rates, k, &rule.weights) * h;
        }
    }
}

/// The weighted sum of the rates of state `k` in some stages.
#[inline(always)]
fn weighted<T: Number>(rates: &[Vec<T>; MOST_STAGES], k: usize, of: &[(usize, f64)]) -> T {
    of.iter().fold(T::from_f64(0.0), |sum, (stage, weight)| sum + rates[*stage][k] * *weight)
}

/// Whether an input jumps or bends at a row.
fn bends(signal: &dyn Input, t_s: f64, sample_s: f64) -> bool {
    let [before, after] = [-0.05, 0.05].map(|part| signal.piece(t_s + part * sample_s));
    let differ = |a: f64, b: f64| (a - b).abs() > NEAR * (a.abs() + b.abs());
    differ(before.value(t_s), after.value(t_s)) || differ(before.rate(t_s), after.rate(t_s))
}

#[cfg(test)]
mod tests {
    use super::super::{MotionEffect, Plant};
    use super::*;
    use crate::signal::Signal;
    use fitter::plant::PlantFile;
    use fitter::plant::equations::declared;
    use physics::number::Dual;

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

    /// A level that overflows into a wall: filled by a sine, it stops at 1.
    const LEVEL: &str = "[plant]\nkind = \"equations\"\ninputs = { u = \"V\" }\n\
        states = { h = { unit = \"V\", start = 0.5 }, g = { unit = \"V\", start = 0.9 } }\noutput = { y = \"h + g\" }\n\
        [plant.equations]\nh = \"a * u - k * sqrt(h) - c * hinge(h, 1)\"\ng = \"k * sqrt(h) - a * g - c * hinge(g, 1)\"\n\
        [plant.parameters]\na = { unit = \"1/s\", value = 0.4 }\nc = { unit = \"1/s\", value = 40.0 }\n\
        k = { unit = \"V^0.5/s\", value = 0.4 }\n";

    #[test]
    fn a_wall_is_followed_in_shorter_steps_with_its_sensitivities() {
        let file = PlantFile::parse("level.toml", LEVEL).unwrap();
        let plant = Plant::of("level.toml", &file).unwrap().unwrap();
        let system = System::new(&plant, &[]).unwrap();
        let drive: Vec<f64> = (0..200).map(|k| 1.0 + 0.8 * (k as f64 / 9.0).sin()).collect();
        let signal =
            Signal::new(&drive, 0.0, 2.0, fitter::plant::Hold::ZeroOrder, crate::signal::Edge::Reflected);
        let signals: [&dyn Input; 1] = [&signal];
        let course =
            Course { signals: &signals, sample_s: 2.0, rows: 200, start_s: 0.0, substeps: 4, observer: None };
        let at = |c: f64, k: f64| system.outputs(&[0.4, c, k], &[0.5, 0.9], &course).unwrap();
        let numbers = [Dual::<2>::from_f64(0.4), Dual::variable(40.0, 0), Dual::variable(0.4, 1)];
        let start = [0.5, 0.9].map(Dual::<2>::from_f64);
        let mut slopes = Vec::new();
        system.run(&numbers, &start, &course, &mut |_, y: Dual<2>| slopes.push(y.slopes)).unwrap();
        let h = 1e-6;
        let [by_c, by_k] = [[at(40.0 + h, 0.4), at(40.0 - h, 0.4)], [at(40.0, 0.4 + h), at(40.0, 0.4 - h)]];
        for (k, [c, a]) in slopes.iter().enumerate() {
            let along = |both: &[Vec<f64>; 2]| (both[0][k] - both[1][k]) / (2.0 * h);
            let apart = [c - along(&by_c), a - along(&by_k)].map(f64::abs);
            // The largest derivatives are 2e-4 and 3.
            assert!(apart[0] < 1e-6 && apart[1] < 1e-4, "{k}: {apart:?}");
        }
        let fine = system.outputs(&[0.4, 40.0, 0.4], &[0.5, 0.9], &Course { substeps: 400, ..course });
        let coarse = at(40.0, 0.4);
        let apart = fine.unwrap().iter().zip(&coarse).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-4, "{apart:e}");
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

    /// z′ = (x − z)/τ from 0 on is a lag that begins there.
    #[test]
    fn a_state_of_an_effects_own_does_what_a_lag_does() {
        let file = PlantFile::parse("plant.toml", OSCILLATOR).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let own = "equation.v = \"-k * z\"\nstates = { z = \"(x - z) / tau\" }\n";
        let lag = "equation.v = \"-k * lowpass(x, tau, 0)\"\n";
        let outputs = [own, lag].map(|adds| {
            let text = format!(
                "[[effect]]\nid = \"creep\"\n{adds}k = {{ unit = \"1/s^2\" }}\n\
                 tau = {{ unit = \"s\", from = 0.1, to = 9 }}\n"
            );
            let texts = declared("mine.toml", &text).unwrap();
            let effect = plant.effect("mine.toml", &texts[0]).unwrap();
            let system = System::new(&plant, &[&effect]).unwrap();
            assert_eq!(system.states(), 3);
            system.outputs(&[4.0, 1.5, 0.7], &[1.0, 0.0], &course(2)).unwrap()
        });
        assert_eq!(outputs[0], outputs[1]);
        assert!((outputs[0][260] - exact(13.0)).abs() > 0.01, "it does something");
    }

    #[test]
    fn half_the_step_is_more_accurate_by_the_order_of_the_rule() {
        let last = |substeps, rows: usize| {
            let course = Course { sample_s: 4.0 / (rows - 1) as f64, rows, ..course(substeps) };
            let outputs = system().outputs(&[4.0, 0.0], &[1.0, 0.0], &course).unwrap();
            (outputs[rows - 1] - 8.0_f64.cos()).abs()
        };
        for (substeps, order) in [(1, 4), (2, 6), (8, 8)] {
            let [once, twice] = [17, 33].map(|rows| last(substeps, rows));
            // The next order makes it more or less than 2^order.
            let ratio = (once / twice).log2();
            assert!(ratio > f64::from(order) - 0.5, "{substeps}: {once:e} {twice:e}");
        }
    }
}
