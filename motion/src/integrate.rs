//! Integration of the equations of motion from sample to sample: adaptive steps of Dormand and Prince's
//! method of order 5(4), paused wherever the drive jumps or bends, dry friction stops or frees the mechanism, or
//! hysteresis turns round.

use differential_equations::error::Error;
use differential_equations::interpolate::Interpolation;
use differential_equations::methods::{DormandPrince, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};

use super::effects::Typical;
use super::error::RunError;
use super::mechanism::{Instant, Mechanism, Mode};
use super::signal::Signal;

/// Accuracy of a step, relative to the state and to its typical size.
const TOLERANCE: f64 = 1e-9;
/// A position or velocity this many times its typical size is no motion of a mechanism any more.
const RUNAWAY: f64 = 1e6;
/// Steps that a simulation may take, at first and with every row more: some seconds of computing for a recording of any
/// length. Between two rows that follow a motion there are ten or twenty.
const STEPS: (u64, u64) = (1_000_000, 1_000);
/// Largest step that the method takes stably, times the fastest rate of the mechanism: the end of Dormand and Prince's
/// region of stability on the real axis.
const STABLE: f64 = 3.3;
/// Pauses between two samples beyond which something rattles without end.
const PAUSES: usize = 2000;

/// Refuses a motion whose rates, at most `fastest` per second, need far more steps than there are rows.
///
/// # Errors
/// [`RunError::TooManySteps`].
pub(crate) fn check_steps(fastest: f64, rows: usize, sample_s: f64) -> Result<(), RunError> {
    let (duration_s, most) = (rows as f64 * sample_s, STEPS.0 as f64 + STEPS.1 as f64 * rows as f64);
    let steps = fastest * duration_s / STABLE;
    if steps > most {
        return Err(RunError::TooManySteps { steps, most, duration_s, sample_s });
    }
    Ok(())
}

/// Most states of a mechanism.
pub const MOST_STATES: usize = 32;

/// The state of a mechanism under way.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Time in seconds.
    pub t_s: f64,
    /// Position and velocity first.
    pub state: Vec<f64>,
}

/// Integrates a mechanism from time to time; the number of states is fixed when it is compiled.
pub trait Integrator {
    /// Integrates to `t_s` under the drives.
    ///
    /// # Errors
    /// [`RunError`].
    fn advance(&mut self, mechanism: &mut Mechanism, signals: &[Signal], t_s: f64) -> Result<(), RunError>;

    /// Where it is.
    fn progress(&self) -> Progress;

    /// Puts it elsewhere.
    fn place(&mut self, progress: &Progress);
}

/// An integrator for the mechanism, started at `start`.
///
/// # Errors
/// [`RunError::TooLarge`].
pub fn integrator(
    mechanism: &Mechanism,
    typical: &Typical,
    start: &Progress,
) -> Result<Box<dyn Integrator>, RunError> {
    let states = mechanism.states();
    Ok(match states {
        0..=2 => Box::new(Stepper::<2>::new(mechanism, typical, start)),
        3..=4 => Box::new(Stepper::<4>::new(mechanism, typical, start)),
        5..=8 => Box::new(Stepper::<8>::new(mechanism, typical, start)),
        9..=16 => Box::new(Stepper::<16>::new(mechanism, typical, start)),
        17..=MOST_STATES => Box::new(Stepper::<MOST_STATES>::new(mechanism, typical, start)),
        _ => return Err(RunError::TooLarge { states, most: MOST_STATES }),
    })
}

type Method<const N: usize> = ExplicitRungeKutta<Ordinary, DormandPrince, f64, [f64; N], 5, 7, 7>;

struct Stepper<const N: usize> {
    method: Method<N>,
    scales: [f64; N],
    states: usize,
    t_s: f64,
    y: [f64; N],
    mode: Option<Mode>,
    step_s: f64,
    /// Steps taken, and as many as may be until the next row.
    steps: u64,
    most: u64,
    /// The length of what was integrated, and of what is to be, and the time from row to row.
    covered_s: f64,
    duration_s: f64,
    sample_s: f64,
}

struct Equations<'a> {
    mechanism: &'a Mechanism,
    signals: &'a [Signal],
    within_s: f64,
    mode: Mode,
}

impl Equations<'_> {
    fn instant(&self, t_s: f64) -> Instant {
        Instant { t_s, within_s: self.within_s, mode: self.mode }
    }

    /// Functions of which none changes its sign within a step.
    fn watched(&self, t_s: f64, y: &[f64]) -> Vec<f64> {
        let instant = self.instant(t_s);
        let mut watched = match self.mode {
            Mode::Free => Vec::new(),
            Mode::Sliding(direction) => vec![direction * y[1]],
            Mode::Stuck => {
                let mut rates = vec![0.0; y.len()];
                let force = self.mechanism.rates(&instant, y, &mut rates, self.signals);
                vec![self.mechanism.holding(t_s, y, force.signum()) - force.abs()]
            }
        };
        if self.mechanism.remembers_turns() {
            watched.extend(self.mechanism.turning(&instant, y, self.signals));
        }
        watched
    }
}

impl<const N: usize> ODE<f64, [f64; N]> for Equations<'_> {
    fn diff(&self, t: f64, y: &[f64; N], dydt: &mut [f64; N]) {
        self.mechanism.rates(&self.instant(t), y, dydt, self.signals);
    }
}

impl<const N: usize> Stepper<N> {
    fn new(mechanism: &Mechanism, typical: &Typical, start: &Progress) -> Self {
        let mut scales = [1.0; N];
        let own = mechanism.scales(typical);
        scales[..own.len()].copy_from_slice(&own);
        let absolute: Vec<f64> =
            scales.iter().map(|scale| TOLERANCE * scale.max(f64::MIN_POSITIVE)).collect();
        // The first step of every stretch is set by hand; the method only refuses one that is longer than it.
        let method = Method::<N>::dopri5().rtol(TOLERANCE).atol(absolute).h0(1e-30).max_steps(usize::MAX);
        let mut y = [0.0; N];
        y[..start.state.len()].copy_from_slice(&start.state);
        let states = mechanism.states();
        Self {
            method,
            scales,
            states,
            t_s: start.t_s,
            y,
            mode: None,
            step_s: typical.sample_s,
            steps: 0,
            most: STEPS.0,
            covered_s: 0.0,
            duration_s: typical.duration_s,
            sample_s: typical.sample_s,
        }
    }

    /// Counts a step that begins at `t_s`.
    fn count(&mut self, t_s: f64) -> Result<(), RunError> {
        self.steps += 1;
        if self.steps <= self.most {
            return Ok(());
        }
        let covered_s = self.covered_s + (t_s - self.t_s);
        let (steps, most) = (self.steps as f64, self.most as f64);
        Err(RunError::TooManySteps {
            // More than were taken, however short the stretch that they led over.
            steps: steps * (self.duration_s / covered_s.max(f64::MIN_POSITIVE)).max(1.0),
            most,
            duration_s: self.duration_s,
            sample_s: self.sample_s,
        })
    }

    /// The mode in which a mechanism at rest goes on.
    fn from_rest(mechanism: &Mechanism, signals: &[Signal], t_s: f64, within_s: f64, y: &[f64; N]) -> Mode {
        let instant = Instant { t_s, within_s, mode: Mode::Stuck };
        let mut rates = [0.0; N];
        let force = mechanism.rates(&instant, y, &mut rates, signals);
        let direction = force.signum();
        if force.abs() > mechanism.holding(t_s, y, direction) {
            Mode::Sliding(direction)
        } else {
            Mode::Stuck
        }
    }

    /// The mode at the start of a stretch.
    fn mode_at(&self, mechanism: &Mechanism, signals: &[Signal], within_s: f64) -> Mode {
        match self.mode {
            _ if !mechanism.is_dry() => Mode::Free,
            _ if self.y[1] != 0.0 => Mode::Sliding(self.y[1].signum()),
            _ => Self::from_rest(mechanism, signals, self.t_s, within_s, &self.y),
        }
    }

    /// Integrates over a stretch in which no drive jumps or bends.
    fn stretch(&mut self, mechanism: &mut Mechanism, signals: &[Signal], end_s: f64) -> Result<(), RunError> {
        let within_s = 0.5 * (self.t_s + end_s);
        let mut mode = self.mode_at(mechanism, signals, within_s);
        // What the drives jumped to.
        mechanism.remember(&Instant { t_s: self.t_s, within_s, mode }, &self.y, signals);
        for _ in 0..PAUSES {
            let equations = Equations { mechanism, signals, within_s, mode };
            let paused = self.go(&equations, end_s)?;
            mechanism.remember(&Instant { t_s: self.t_s, within_s, mode }, &self.y, signals);
            mode = match mode {
                // It has come to rest: it is held, turns back, or goes on where it only slowed down.
                Mode::Sliding(direction) if direction * self.y[1] < 0.0 => {
                    self.y[1] = 0.0;
                    Self::from_rest(mechanism, signals, self.t_s, within_s, &self.y)
                }
                Mode::Stuck if paused => Self::from_rest(mechanism, signals, self.t_s, within_s, &self.y),
                mode => mode,
            };
            self.mode = Some(mode);
            if !paused {
                return Ok(());
            }
        }
        Err(RunError::Stalls { t_s: self.t_s, reason: String::from("it rattles without end") })
    }

    /// Steps to `end_s`, or to just behind the first change of sign of a watched function; whether it paused
    /// there.
    fn go(&mut self, equations: &Equations, end_s: f64) -> Result<bool, RunError> {
        let watches = equations.mode != Mode::Free || equations.mechanism.remembers_turns();
        let mut signs: Vec<f64> = Vec::new();
        if watches {
            signs = equations.watched(self.t_s, &self.y).iter().map(|w| sign(*w)).collect();
            if equations.mode != Mode::Free {
                signs[0] = 1.0;
            }
        }
        let least_s = 1e-12 * end_s.abs().max(end_s - self.t_s);
        if end_s - self.t_s <= least_s {
            self.t_s = end_s;
            return Ok(false);
        }
        let refused = |t_s: f64, error| RunError::Stalls { t_s, reason: reason(&error) };
        self.method.init(equations, self.t_s, end_s, &self.y).map_err(|e| refused(self.t_s, e))?;
        // While friction holds nothing moves, and a step of any length is accurate: a drive that swings between its samples would
        // free it unseen.
        let longest_s = match equations.mode {
            Mode::Stuck => equations.signals.iter().map(Signal::piece_s).fold(f64::INFINITY, f64::min),
            Mode::Free | Mode::Sliding(_) => f64::INFINITY,
        };
        self.method.set_h(self.step_s.min(end_s - self.t_s));
        while end_s - self.method.t() > least_s {
            let (before_s, wanted) = (self.method.t(), self.method.h().min(longest_s));
            self.count(before_s)?;
            let left_s = end_s - before_s;
            // Two even steps rather than a whole and a tiny one.
            let step_s = match wanted {
                wanted if wanted >= left_s => left_s,
                wanted if wanted > 0.5 * left_s => 0.5 * left_s,
                wanted => wanted,
            };
            self.method.set_h(step_s);
            self.method.step(equations).map_err(|e| refused(before_s, e))?;
            if self.method.t() == before_s {
                continue;
            }
            let next = self.method.h();
            // A step that was cut short says little about how long one may be.
            self.step_s = if step_s < wanted { wanted.max(next) } else { next };
            let y = *self.method.y();
            let runs = |i: usize| !y[i].is_finite() || y[i].abs() > RUNAWAY * self.scales[i];
            if (0..self.states).any(runs) {
                return Err(RunError::RunsAway { t_s: self.method.t() });
            }
            if watches && changed(&equations.watched(self.method.t(), &y), &mut signs) {
                (self.t_s, self.y) = self.behind(equations, before_s, &mut signs)?;
                return Ok(true);
            }
        }
        (self.t_s, self.y) = (end_s, *self.method.y());
        Ok(false)
    }

    /// The time and the state just behind the first change of sign in the last step, by bisection on the
    /// method's own interpolation.
    fn behind(
        &mut self,
        equations: &Equations,
        before_s: f64,
        signs: &mut [f64],
    ) -> Result<(f64, [f64; N]), RunError> {
        let (mut low, mut high) = (before_s, self.method.t());
        let mut found = *self.method.y();
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            let y = self
                .method
                .interpolate(middle)
                .map_err(|error| RunError::Stalls { t_s: before_s, reason: reason(&error) })?;
            if changed(&equations.watched(middle, &y), signs) {
                (high, found) = (middle, y);
            } else {
                low = middle;
            }
        }
        Ok((high, found))
    }
}

impl<const N: usize> Integrator for Stepper<N> {
    fn advance(&mut self, mechanism: &mut Mechanism, signals: &[Signal], t_s: f64) -> Result<(), RunError> {
        // Drives that are delayed bend between the samples.
        let length_s = t_s - self.t_s;
        let start_s = self.t_s;
        let mut pauses: Vec<f64> = mechanism
            .delays_s()
            .iter()
            .zip(signals)
            .filter(|(delay, signal)| **delay > 0.0 && signal.breaks())
            .map(|(delay, _)| delay.rem_euclid(length_s))
            .filter(|part| *part > 1e-9 * length_s && *part < (1.0 - 1e-9) * length_s)
            .map(|part| start_s + part)
            .collect();
        pauses.sort_by(f64::total_cmp);
        pauses.dedup();
        pauses.push(t_s);
        self.most += STEPS.1;
        pauses.into_iter().try_for_each(|pause| self.stretch(mechanism, signals, pause))?;
        self.covered_s += length_s;
        Ok(())
    }

    fn progress(&self) -> Progress {
        Progress { t_s: self.t_s, state: self.y[..self.states].to_vec() }
    }

    fn place(&mut self, progress: &Progress) {
        self.t_s = progress.t_s;
        self.y = [0.0; N];
        self.y[..progress.state.len()].copy_from_slice(&progress.state);
        self.mode = None;
    }
}

/// −1, 0 or 1.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Whether any value has another sign than it had; one that was 0 takes its sign now.
fn changed(values: &[f64], signs: &mut [f64]) -> bool {
    let mut any = false;
    for (value, expected) in values.iter().zip(signs) {
        if *expected == 0.0 {
            *expected = sign(*value);
        }
        any |= *expected * value < 0.0;
    }
    any
}

fn reason<const N: usize>(error: &Error<f64, [f64; N]>) -> String {
    String::from(match error {
        Error::StepSize { .. } => "its steps shrink to nothing",
        Error::Stiffness { .. } => "it is stiff",
        _ => "the integrator refuses it",
    })
}
