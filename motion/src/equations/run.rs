//! A run of a plant in equations: a Runge–Kutta rule ([`rule`](super::rule)), divided where the argument of a sign or a step
//! passes zero ([`events`](super::events)). With numbers that carry derivatives it yields its sensitivities exactly:
//! the derivatives of the rates by states and parameters are computed once for all directions.

use std::ops::Mul;

use physics::number::Number;
use physics::tape::{Places, Routine, Row, Side, Source};
use pulp::{Arch, Simd, WithSimd};

use super::System;
use super::course::{Course, MOST_SUBSTEPS, Stopped};
use super::delays::Delay;
use super::input::Piece;
use super::rule::{MOST_STAGES, Rule};

/// Change by twice as many steps, over the largest output, that nobody sees.
const ACCURATE: f64 = 1e-6;

/// What is computed at an instant.
pub(super) struct Routines {
    /// The rates of all states.
    pub rates: Routine,
    /// Their derivatives by the states.
    pub slopes: Routine,
    /// The rates where the instant itself moves with the parameters, or the rates of values are wanted.
    pub moving: Routine,
    /// The output.
    pub output: Routine,
    /// The output without effects, with all derivatives.
    pub read: Routine,
    /// The arguments of switches, without derivatives.
    pub sides: Routine,
    /// With all derivatives.
    pub arguments: Routine,
    /// Where states that operators bring with them begin.
    pub starts: Routine,
    /// The signals and gaps of plays.
    pub plays: Routine,
}

/// A run under way.
pub(super) struct Run<'a, T> {
    pub system: &'a System,
    pub course: &'a Course<'a>,
    pub parameters: &'a [T],
    pub delays: Vec<Delay<T>>,
    pub routines: Routines,
    pub registers: Vec<f64>,
    /// The inputs in the present step.
    pub pieces: Vec<Piece>,
    pub states: Vec<T>,
    /// The states after a step, and in it.
    pub after: Vec<T>,
    pub there: Vec<T>,
    /// States and sides at the row before.
    pub before: (Vec<T>, Vec<Side>),
    /// What [`Run::speed`] was at the row that was reached.
    pub reached: Option<(f64, usize)>,
    pub powers: [Vec<f64>; 2],
    /// Units in which the states are alike, none until they are known, and the factor of a bound in them.
    pub units: (Vec<f64>, f64),
    pub rule: &'static Rule,
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
            units: (Vec::new(), 1.0),
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

#[cfg(test)]
mod tests;
