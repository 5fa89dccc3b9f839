//! Free-run simulation of a run: the drive on its way to the mechanism, the mechanism, and its position on
//! the way to the recording. Written over [`Number`], so that with derivative-carrying numbers it integrates
//! the sensitivity equations alongside.

use physics::number::Number;

use super::drive_path::DrivePath;
use super::effects::Part;
use super::lag::Lag;
use super::machine::{Machine, State};
use super::model::Model;
use super::signal::Signal;
use super::step::Room;
use crate::thresholds::dynamic::model::{MOST_EXTRA, MOST_PROBED};
use crate::thresholds::dynamic::simulate::SLOPE_ROWS;

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

/// What one run is simulated along.
pub struct Course<'a> {
    pub signal: &'a Signal,
    /// Time from row to row, s.
    pub step_s: f64,
    pub rows: usize,
    /// Time at the first row, s.
    pub start_s: f64,
    /// Bound of the position.
    pub bound: f64,
    /// Extremes of the drive before the first row, as far as a hysteresis remembers them.
    pub before: &'a [f64],
    /// Positions in the rows before the first one, as far as they are known.
    pub lead: &'a [f64],
}

impl Course<'_> {
    /// The last positions before the first row, over a time as long as a model remembers or as far as they are known.
    fn lead_for(&self, memory_s: f64) -> &[f64] {
        let known = self.lead.len();
        let wanted = (memory_s / self.step_s).min(known as f64) as usize;
        // Rounded up, so that a parameter that changes a little does not change it.
        let rows = wanted.next_power_of_two().min(known);
        if wanted == 0 || rows <= SLOPE_ROWS { &[] } else { &self.lead[known - rows..] }
    }
}

/// Simulates one run: from the initial position and velocity along the drive; `visit` is given every
/// sample's number and the position that is read out there. The effects' own states begin at rest, or, where
/// rows before the first one are known, as these leave them.
///
/// # Errors
/// [`Unstable`] as soon as the position leaves its bound or is not finite.
pub fn simulate<T: Number>(
    model: &Model,
    theta: &Theta<T>,
    course: &Course,
    start: [T; 2],
    visit: &mut dyn FnMut(usize, T),
) -> Result<(), Unstable> {
    // Places for states that are not there would be copied in every step; every further kind is compiled apart.
    match model.extra() {
        (0, 0) => run::<T, 0, 0>(model, theta, course, start, visit),
        (_, 0) => run::<T, MOST_EXTRA, 0>(model, theta, course, start, visit),
        _ => run::<T, MOST_EXTRA, MOST_PROBED>(model, theta, course, start, visit),
    }
}

fn run<T: Number, const Z: usize, const Q: usize>(
    model: &Model,
    theta: &Theta<T>,
    course: &Course,
    start: [T; 2],
    visit: &mut dyn FnMut(usize, T),
) -> Result<(), Unstable> {
    let lead = course.lead_for(model.memory_s());
    let [p, v] = match lead {
        [] => start,
        y => {
            let slope = (y[SLOPE_ROWS] - y[0]) / (SLOPE_ROWS as f64 * course.step_s);
            [y[0], slope].map(T::from_f64)
        }
    };
    let first = -(lead.len() as isize);
    let (machine, state) = Machine::<T, Z, Q>::new(model, theta, [p, v]);
    let path = DrivePath::new(model, theta, course, first);
    let mut motion = Motion::new(machine, path, course, state);
    for k in first..0 {
        motion.advance(k, |_, _| {})?;
    }
    if first < 0 {
        [motion.state.p, motion.state.v] = start;
        motion.turn();
    }
    let time = motion.step_s;
    let mut reading: Option<Lag<T>> = model
        .acting(Part::SensorLag)
        .next()
        .map(|k| Lag::behind(motion.state.p, motion.state.v, theta.terms[k][0], time));
    let read = |reading: &Option<Lag<T>>, p: T| reading.as_ref().map_or(p, |lag| lag.state);
    let offset = model.acting(Part::SensorOffset).fold(T::from_f64(0.0), |sum, k| sum + theta.terms[k][0]);
    visit(0, read(&reading, motion.state.p) + offset);
    for k in 0..course.rows - 1 {
        motion.advance(k as isize, |from, to| {
            if let Some(lag) = &mut reading {
                lag.advance(between(from, to, time), T::from_f64(time));
            }
        })?;
        visit(k + 1, read(&reading, motion.state.p) + offset);
    }
    Ok(())
}

/// The cubic with the positions and velocities at both ends of a step.
fn between<T: Number, const Z: usize, const Q: usize>(
    from: &State<T, Z, Q>,
    to: &State<T, Z, Q>,
    time: f64,
) -> [T; 4] {
    let (rise, v, w) = (to.p - from.p, from.v * time, to.v * time);
    [from.p, v, rise * 3.0 - v * 2.0 - w, v + w - rise * 2.0]
}

/// The mechanism on its way from sample to sample.
struct Motion<'a, T, const Z: usize, const Q: usize> {
    machine: Machine<'a, T, Z, Q>,
    path: DrivePath<'a, T>,
    course: &'a Course<'a>,
    state: State<T, Z, Q>,
    room: Room<T, Z, Q>,
    /// Direction as dry friction sees it, and the force up to which that holds.
    direction: f64,
    holds: f64,
    /// Steps of the integrator from one sample to the next, and their length in s.
    substeps: usize,
    step_s: f64,
}

impl<'a, T: Number, const Z: usize, const Q: usize> Motion<'a, T, Z, Q> {
    fn new(
        machine: Machine<'a, T, Z, Q>,
        path: DrivePath<'a, T>,
        course: &'a Course<'a>,
        state: State<T, Z, Q>,
    ) -> Self {
        let holds = machine.holds();
        let substeps = machine.model.substeps(course.step_s);
        let step_s = course.step_s / substeps as f64;
        let (room, direction) = (Room::empty(), 0.0);
        let mut motion = Motion { machine, path, course, state, room, direction, holds, substeps, step_s };
        motion.turn();
        motion
    }

    /// Takes the direction from the state.
    fn turn(&mut self) {
        let v = self.state.v.value();
        self.direction = if v == 0.0 { 0.0 } else { v.signum() };
    }

    /// From sample `k` to the next; `along` is given the state before and after every step.
    fn advance(
        &mut self,
        k: isize,
        mut along: impl FnMut(&State<T, Z, Q>, &State<T, Z, Q>),
    ) -> Result<(), Unstable> {
        let part = 1.0 / self.substeps as f64;
        let (state, room) = (&mut self.state, &mut self.room);
        for i in 0..self.substeps {
            let s = i as f64 * part;
            self.machine.time = self.course.start_s + (k as f64 + s) * self.course.step_s;
            let span = self.path.span(k, s, part, self.step_s);
            let friction = self.machine.friction;
            if !friction || self.direction != 0.0 {
                let direction = if friction { self.direction } else { 0.0 };
                self.machine.step_into(room, state, self.step_s, &span, direction);
            }
            // Most steps have no event; those of one are done again, divided where it is.
            if friction && (self.direction == 0.0 || room.to.v.value() * self.direction < 0.0) {
                let (direction, holds) = (&mut self.direction, self.holds);
                room.to = self.machine.step_with_friction(*state, self.step_s, &span, direction, holds);
            }
            along(state, &room.to);
            self.machine.copy(state, &room.to);
        }
        let p = state.p.value();
        if p.is_nan() || p.abs() > self.course.bound {
            Err(Unstable((k + 1).max(0) as usize))
        } else {
            Ok(())
        }
    }
}
