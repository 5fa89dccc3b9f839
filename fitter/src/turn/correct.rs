//! What a sensor that turns is corrected for beside the harmonics: a slope over the turn, and a lag. Both only where they
//! are significant; a recording that shows neither gets harmonics alone.

use super::beside::Kind;
use super::description::{Estimate, Left, Slope};
use super::harmonics::{Choice, Harmonics};
use crate::error_model::Sensor;
use crate::figures::plus_minus;
use crate::fit::FitError;
use crate::statistics::readable;
use crate::terms::{Observables, Operator, Rate};

/// The terms beside the harmonics.
#[derive(Debug, Clone, Default)]
pub(super) struct Corrections {
    /// Where the slope is counted from, if there is one.
    pub middle: Option<f64>,
    /// Whether the lag is corrected.
    pub lag: bool,
    pub left: Option<Left>,
}

impl Corrections {
    pub fn any(&self) -> bool {
        self.middle.is_some() || self.lag
    }
}

/// The steps of the rate of the reading, which depends on the harmonics that are fitted with it. An error's slope is a
/// few hundredths, and each step leaves that part of the last.
const STEPS: usize = 3;

/// Finds the columns that belong into the fit, and the number of harmonics.
///
/// # Errors
/// [`FitError`]: too few angles.
pub(super) fn identify(problem: &mut Harmonics) -> Result<(Choice, Corrections), FitError> {
    let mut choice = match problem.chosen() {
        Err(_) if problem.leave_out_direction() => problem.chosen()?,
        other => other?,
    };
    let mut corrections = Corrections::default();
    let middle = problem.add_slope();
    if let (Some(middle), Some(place)) = (middle, problem.place(Kind::Slope)) {
        // Harmonics take a slope for a saw-tooth: without it other numbers of them are the best.
        let with =
            problem.chosen().ok().and_then(|with| Some((problem.tested(place, &with.solution)?, with)));
        match with {
            Some((tested, with)) if tested.significant() => {
                choice = with;
                corrections.middle = Some(middle);
            }
            _ => _ = problem.beside.remove(place),
        }
    }
    if let Some(place) = problem.place(Kind::Velocity)
        && problem.tested(place, &choice.solution).is_some_and(|tested| tested.significant())
    {
        corrections.lag = lag(problem, &mut choice)?;
    }
    if corrections.any() {
        corrections.left = left(problem, &choice)?;
        for place in 0..problem.beside.len() {
            problem.beside[place].tested = problem.tested(place, &choice.solution);
        }
    }
    Ok((choice, corrections))
}

/// Fits the lag to the rate that the correction will see; whether it is corrected.
fn lag(problem: &mut Harmonics, choice: &mut Choice) -> Result<bool, FitError> {
    let (before, harmonics) = (problem.beside.clone(), choice.harmonics);
    for _ in 0..STEPS {
        problem.set_rate_of_reading(&choice.solution);
        choice.solution = problem.solved(harmonics)?;
    }
    // What the directions differ by beyond the lag is not corrected: where it is chance, the lag has to answer for all.
    if let Some(place) = problem.place(Kind::Direction)
        && problem.tested(place, &choice.solution).is_some_and(|tested| !tested.significant())
    {
        problem.beside.remove(place);
        choice.solution = problem.solved(harmonics)?;
    }
    let helps = problem.place(Kind::Velocity).is_some_and(|place| {
        let lag = problem.coefficient(place, &choice.solution);
        let moving = &problem.beside[place].values;
        let rate = rate(problem).unwrap_or_default();
        let without = choice.solution.residual.iter().zip(moving).map(|(e, v)| e + lag * v);
        let with = without.clone().zip(&rate).map(|(e, rate)| e - lag * rate);
        // The rate of a coarse reading is noise, and correcting by it may cost more than the lag.
        rate.len() == moving.len() && scatter(with) < scatter(without)
    });
    if !helps {
        problem.beside = before;
        choice.solution = problem.solved(harmonics)?;
    }
    Ok(helps)
}

/// The rate of the reading as a correction forms it.
fn rate(problem: &Harmonics) -> Option<Vec<f64>> {
    let observables = Observables { recording: problem.recording, sensor: &problem.mirror.sensor };
    Operator::Rate(Rate::of("measured")).columns(&observables).ok()?.pop()
}

/// Root mean square about the mean.
fn scatter(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let (count, sum) = values.clone().fold((0.0, 0.0), |(count, sum), v| (count + 1.0, sum + v));
    let mean = sum / count;
    (values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / count).sqrt()
}

fn left(problem: &mut Harmonics, choice: &Choice) -> Result<Option<Left>, FitError> {
    let beside = |row: usize| {
        let parts = problem.beside.iter().enumerate();
        parts.map(|(k, column)| problem.coefficient(k, &choice.solution) * column.values[row]).sum::<f64>()
    };
    let alone = scatter(choice.solution.residual.iter().enumerate().map(|(row, e)| e + beside(row)));
    let without = match problem.place(Kind::Slope) {
        Some(place) => {
            let slope = problem.beside.remove(place);
            let solution = problem.solved(choice.harmonics);
            problem.beside.insert(place, slope);
            scatter(solution?.residual.into_iter())
        }
        None => scatter(choice.solution.residual.iter().copied()),
    };
    Ok(Some(Left { harmonics_alone_rms: readable(alone), without_slope_rms: readable(without) }))
}

impl Slope {
    pub(super) fn of(per_turn: Estimate, sensor: &Sensor) -> Slope {
        let unit = sensor.error_unit();
        let reach = 0.5 * (per_turn.ci95[1] - per_turn.ci95[0]);
        let statement = format!(
            "slope over the turn: {} per turn, does not repeat: the scale of the reference or a gearing",
            plus_minus(per_turn.value, reach, unit)
        );
        Slope { per_turn, statement }
    }
}
