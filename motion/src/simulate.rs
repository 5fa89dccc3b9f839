//! A plant file on a drive: what `simulate` does.

use fitter::plant::{Hold, Kind, Numbers, PlantFile};
use fitter::table::Values;

use super::effects::Context;
use super::equations::{Course, EquationsError, Input, MotionEffect, Plant, Stopped, System};
use super::error::RunError;
use super::linear::LinearModel;
use super::model::{Model, REST, Start};
use super::series::Series;
use super::signal::{Edge, Signal};
use crate::values::EffectError;

/// How a run begins, where its excitation is not periodic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// At rest at position 0.
    Rest,
    /// As the first rows of the recorded position say: 50 of them, or one period of the mechanism's own vibration.
    Recorded,
}

/// Rows of a run from which its initial state is taken, at least.
pub const INITIAL_ROWS: usize = 50;
/// Part of a run from which it is taken at most, where one period of the mechanism's own vibration has more rows: a
/// shorter stretch tells its position from its velocity badly.
const INITIAL_PART: usize = 8;

/// Rows of a run of so many from which its initial state is taken.
fn initial_rows(model: &Model, sample_s: f64, rows: usize) -> usize {
    let period = std::f64::consts::TAU / (model.stiffness.max(0.0).sqrt() * sample_s);
    // As a float the cast is saturating.
    (period.ceil() as usize).min(rows / INITIAL_PART).max(INITIAL_ROWS)
}

fitter::errors! {
    /// Why a plant cannot be simulated.
    #[derive(Debug, Clone, PartialEq)]
    pub enum SimulateError {
        Missing { file: String, key: &'static str, expected: &'static str } =>
            at(file) says("`{key}` is missing") expected("{expected}")
            mend("identify the plant with `diagnose`, which writes it, or add it");
        Drives { file: String, expected: usize, found: usize } =>
            at(file) says("`plant.gain` has {expected} numbers and the recording {found} drives")
            mend("give one for each");
        Positions { expected: usize, found: usize } =>
            says("the recording has {found} positions and the plant {expected}")
            expected("as many to take the initial state from") mend("start at rest instead");
        LinearState =>
            says("the initial state of a `linear` plant is not taken from a recording")
            mend("start at rest, or give a recording in its periodic steady state");
        Run { file: String, reason: RunError } => of(reason) at(file);
        Stopped { file: String, stopped: Stopped } => of(stopped) at(file);
    }
    from { Equations(EquationsError) }
}

/// Simulates every run of a recording's drives; the answer has its times, runs and periods, no drives, and the
/// simulated positions. `file` is the plant file's name in messages.
///
/// Where the recording says that its excitation is periodic and in steady state, the simulation is so too, and
/// `begin` does not matter.
///
/// # Errors
/// [`SimulateError`].
pub fn simulate(
    file: &str,
    plant: &PlantFile,
    recording: &Series,
    begin: Begin,
) -> Result<Series, SimulateError> {
    let (sample_s, inputs) = (recording.sample_s(), recording.inputs(plant));
    let mut positions: Vec<Vec<f64>> = Vec::new();
    for rows in recording.runs() {
        let drives: Vec<Vec<f64>> = inputs.iter().map(|column| column[rows.clone()].to_vec()).collect();
        let steady = recording.period_of(&rows).map(|period| Start::Steady { period });
        let start = steady.or((begin == Begin::Rest).then_some(REST));
        let own = match plant.plant.kind {
            Kind::SecondOrder => {
                let model = second_order(file, plant, drives.len())?;
                let wrong = |reason| SimulateError::Run { file: file.to_owned(), reason };
                let start = match (start, &recording.positions[..]) {
                    (Some(start), _) => start,
                    (None, [position]) => {
                        let initial = initial_rows(&model, sample_s, rows.len());
                        model.start_of(&drives, sample_s, &position[rows.clone()], initial).map_err(wrong)?
                    }
                    (None, others) => {
                        return Err(SimulateError::Positions { expected: 1, found: others.len() });
                    }
                };
                vec![model.simulate(&drives, sample_s, start).map_err(wrong)?]
            }
            Kind::Equations => vec![in_equations(file, plant, &drives, sample_s, rows.len())?],
            Kind::Linear => linear(file, plant)?
                .simulate(&drives, sample_s, start.ok_or(SimulateError::LinearState)?)
                .map_err(|reason| SimulateError::Run { file: file.to_owned(), reason })?,
        };
        positions.resize(own.len(), Vec::new());
        positions.iter_mut().zip(own).for_each(|(all, own)| all.extend(own));
    }
    let positions = positions.into_iter().map(Values::from).collect();
    Ok(Series { drives: Vec::new(), positions, further: Vec::new(), ..recording.clone() })
}

/// The output of a plant in equations, from where its file says that it begins.
///
/// # Errors
/// [`SimulateError`]: an expression that cannot be read, a parameter or a start without a number, or a motion that has no
/// value.
fn in_equations(
    file: &str,
    plant: &PlantFile,
    drives: &[Vec<f64>],
    sample_s: f64,
    rows: usize,
) -> Result<Vec<f64>, SimulateError> {
    let missing = |key| SimulateError::Missing { file: file.to_owned(), key, expected: "a number for each" };
    let plant = Plant::of(file, plant).ok_or_else(|| missing("plant.equations"))??;
    let wanted = plant.inputs.len();
    if wanted > drives.len() {
        return Err(SimulateError::Drives { file: file.to_owned(), expected: wanted, found: drives.len() });
    }
    let start: Option<Vec<f64>> = plant.starts.iter().copied().collect();
    let start = start.ok_or_else(|| missing("plant.states: start"))?;
    let values: Option<Vec<f64>> = plant.values.iter().copied().collect();
    let mut values = values.ok_or_else(|| missing("plant.parameters: value"))?;
    values.extend(plant.effects.iter().flat_map(|(_, values)| values));
    let effects: Vec<&MotionEffect> = plant.effects.iter().map(|(effect, _)| effect).collect();
    let system = System::new(&plant, &effects)?;
    let hold = plant.sampling.unwrap_or(Hold::ZeroOrder);
    let signal = |drive: &Vec<f64>| Signal::new(drive, 0.0, sample_s, hold, Edge::Reflected);
    let signals: Vec<Signal> = drives[..wanted].iter().map(signal).collect();
    let signals: Vec<&dyn Input> = signals.iter().map(|signal| signal as &dyn Input).collect();
    let course = Course { signals: &signals, sample_s, rows, start_s: 0.0, substeps: 1, observer: None };
    let stopped = |stopped| SimulateError::Stopped { file: file.to_owned(), stopped };
    system.converged(&values, &start, course).map_err(stopped)
}

/// The model of a `second-order` plant file with all its numbers.
///
/// # Errors
/// [`SimulateError::Missing`], [`SimulateError::Drives`], or effects that make no sense.
fn second_order(file: &str, plant: &PlantFile, drives: usize) -> Result<Model, SimulateError> {
    let missing = |key, expected| SimulateError::Missing { file: file.to_owned(), key, expected };
    let number = |value: Option<f64>, key, expected| value.ok_or_else(|| missing(key, expected));
    let gains = match plant.plant.gain.as_ref() {
        None => return Err(missing("plant.gain", "the gain per inertia")),
        Some(Numbers::One(gain)) => vec![*gain; drives],
        Some(Numbers::Each(gains)) if gains.len() == drives => gains.clone(),
        Some(Numbers::Each(gains)) => {
            let file = file.to_owned();
            return Err(SimulateError::Drives { file, expected: gains.len(), found: drives });
        }
    };
    let model = Model {
        damping: number(plant.plant.damping, "plant.damping", "the damping per inertia in 1/s")?,
        stiffness: number(plant.plant.stiffness, "plant.stiffness", "the stiffness per inertia in 1/s²")?,
        gains,
        effects: plant.effects.clone(),
        hold: plant.plant.hold.unwrap_or(Hold::ZeroOrder),
        context: Context { feedback: plant.plant.feedback.is_some() },
    };
    model.check().map_err(|reason: EffectError| SimulateError::Run {
        file: file.to_owned(),
        reason: RunError::Effect(reason),
    })
}

fn linear(file: &str, plant: &PlantFile) -> Result<LinearModel, SimulateError> {
    let space = plant.state_space.clone().ok_or_else(|| SimulateError::Missing {
        file: file.to_owned(),
        key: "state_space",
        expected: "the matrices of a `linear` plant",
    })?;
    let hold = plant.plant.hold.unwrap_or(Hold::ZeroOrder);
    Ok(LinearModel { space, effects: plant.effects.clone(), hold })
}
