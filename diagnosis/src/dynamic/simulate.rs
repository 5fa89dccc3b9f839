//! Free-run simulation of a run: the drive on its way to the mechanism, the mechanism, and its position on
//! the way to the recording. Written over [`Number`], so that with derivative-carrying numbers it integrates
//! the sensitivity equations alongside.

use super::effects::{DynamicEffect, Part, Physics};
use super::lag::Lag;
use super::machine::{Machine, Probe, Span, State};
use super::model::{MOST_EXTRA, Model};
use super::number::Number;
use super::signal::Signal;
use super::turns::Turns;

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
    /// Extremes of the drive before the first row, as far as a hysteresis remembers them.
    pub before: &'a [f64],
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
    let Course { signal, step_s, rows, start_s, bound, .. } = *course;
    let zero = T::from_f64(0.0);
    let mut state = State { p: start[0], v: start[1], z: [zero; MOST_EXTRA] };
    let (mut forces, mut probes) = (Vec::new(), Vec::new());
    let mut extra = 0;
    for k in model.acting(Part::Force) {
        let effect = model.terms[k].effect;
        for (i, rest) in effect.rest(start[0].value()).iter().take(effect.states()).enumerate() {
            // A state that starts with the position shares its derivatives.
            state.z[extra + i] =
                if *rest == start[0].value() && *rest != 0.0 { start[0] } else { T::from_f64(*rest) };
        }
        if model.terms[k].probe {
            let zeroed: Vec<f64> = (effect.parameters().iter().zip(&model.terms[k].parameters))
                .map(|(p, value)| if p.shape { *value } else { 0.0 })
                .collect();
            let unit = |(j, x): (usize, &T)| {
                let mut parameters = zeroed.clone();
                parameters[j] = 1.0;
                x.direction().map(|lane| (lane, parameters))
            };
            let units = theta.terms[k].iter().enumerate().filter_map(unit).collect();
            probes.push(Probe { effect, units, first: extra });
        } else {
            forces.push((k, extra));
        }
        extra += effect.states();
    }
    let friction = model.has_friction();
    let mut machine = Machine { model, theta, forces, probes, extra, friction, time: 0.0 };
    let holds = machine.holds();
    let mut direction = state.v.value().signum() * f64::from(state.v.value() != 0.0);
    let substeps = model.substeps(step_s);
    let part = 1.0 / substeps as f64;
    let h = step_s * part;
    let delays: Vec<usize> = model.acting(Part::Delay).collect();
    // An offset comes before a saturation, whichever was found first.
    let mut shaping: Vec<usize> = model.acting(Part::Drive).collect();
    shaping.sort_by_key(|k| model.terms[*k].effect.id() == "drive_saturation");
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
    let shaped = |u: f64| -> T {
        let mut w = T::from_f64(u);
        for &d in &shaping {
            w = Physics::<T>::drive(model.terms[d].effect, &theta.terms[d], w);
        }
        w
    };
    let mut memory: Option<(T, Turns<T>)> = model.acting(Part::DriveMemory).next().map(|k| {
        let mut turns = Turns::new();
        course.before.iter().for_each(|u| {
            turns.to(shaped(*u));
        });
        (theta.terms[k][0], turns)
    });
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
        let mut unremembered = from;
        if let Some((coefficient, turns)) = &mut memory {
            from = from + *coefficient * turns.to(from);
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
            if let Some((coefficient, turns)) = &mut memory {
                let bare = Span { from: unremembered, middle, to };
                unremembered = to;
                (middle, to) = bare.remembered(*coefficient, turns);
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
