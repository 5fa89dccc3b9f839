//! The channels of a recording: differences of columns in which the angle itself cancels, and the columns that stand
//! for themselves.

use super::deviation::{Deviation, Surroundings};
use crate::error_model::Sensor;
use crate::recording::{Readings, Recording};

/// A channel made of columns: its deviations, and by how much each column moves it, in units of the column.
pub struct Channel {
    pub deviation: Deviation,
    /// Column and factor.
    pub parts: Vec<(&'static str, f64)>,
}

/// All channels of a recording.
pub struct Channels<'a> {
    pub recording: &'a Recording,
    /// The angle of every row.
    pub angle: Vec<f64>,
    /// Those of sensor, reference and command, in which a single wrong column is told by which of them it moves.
    pub sensor: Vec<Channel>,
    /// A further column with the deviations of its own.
    pub further: Vec<(&'a str, Deviation)>,
}

impl<'a> Channels<'a> {
    pub fn of(recording: &'a Recording, sensor: &'a Sensor) -> Channels<'a> {
        let rows = recording.rows();
        let reading: Vec<f64> = (0..rows).map(|row| recording.reading(row)).collect();
        let command = recording.command_deg.as_deref();
        let angle: Vec<f64> = match command.filter(|c| c.iter().all(|v| v.is_finite())) {
            Some(command) => command.to_vec(),
            None => reading.iter().map(|reading| sensor.calculated(*reading)).collect(),
        };
        let direction: Vec<f64> = recording.direction.iter().map(|d| f64::from(*d)).collect();
        let surroundings = Surroundings::new(&angle, &recording.time_s, &direction);
        let sensor = made(recording, sensor, &reading)
            .into_iter()
            .map(|(values, parts)| Channel { deviation: surroundings.deviation(&values), parts })
            .collect();
        let further = (recording.further.iter())
            .filter(|column| !is_state(&column.values) && !wraps(&column.values))
            .map(|column| (column.name.as_str(), surroundings.deviation(&column.values)))
            .collect();
        Channels { recording, angle, sensor, further }
    }
}

type Parts = Vec<(&'static str, f64)>;

/// Angular error, common mode, and distance from the command, as far as the recording has them.
fn made(recording: &Recording, sensor: &Sensor, reading: &[f64]) -> Vec<(Vec<f64>, Parts)> {
    let mut channels = Vec::new();
    let per = sensor.per_internal();
    let theta: Vec<f64> = reading.iter().map(|reading| per * sensor.calculated(*reading)).collect();
    match (&recording.readings, sensor) {
        (Readings::Pair { x1_mm, x2_mm, reference_arcsec }, Sensor::EddyCurrentPair { .. }) => {
            // What a probe moves the angle by at the middle of the stroke; it differs little over the stroke.
            let gain = per * sensor.gain(0.0);
            if let Some(reference) = reference_arcsec {
                let error = theta.iter().zip(reference).map(|(t, r)| t - r).collect();
                let parts = vec![("x1_mm", -gain), ("x2_mm", gain), ("reference_arcsec", -1.0)];
                channels.push((error, parts));
            }
            let common = x1_mm.iter().zip(x2_mm).map(|(a, b)| a + b).collect();
            channels.push((common, vec![("x1_mm", 1.0), ("x2_mm", 1.0)]));
            let parts = vec![("x1_mm", -gain), ("x2_mm", gain), ("command_deg", -3600.0)];
            channels.extend(followed(recording, &theta, 3600.0).map(|apart| (apart, parts)));
        }
        (Readings::Direct { measured, reference }, Sensor::Direct { unit, revolution }) => {
            if let Some(reference) = reference {
                let apart: Vec<f64> = measured.iter().zip(reference).map(|(m, r)| m - r).collect();
                let error = match revolution {
                    Some(turn) => wrapped(&apart, *turn),
                    None => apart,
                };
                channels.push((error, vec![("measured", 1.0), ("reference", -1.0)]));
            }
            if unit == "deg" && revolution.is_none() {
                let parts = vec![("measured", 1.0), ("command_deg", -1.0)];
                channels.extend(followed(recording, &theta, 1.0).map(|apart| (apart, parts)));
            }
        }
        _ => {}
    }
    channels
}

/// Angle less command; none where the angle does not follow the command.
fn followed(recording: &Recording, theta: &[f64], per_degree: f64) -> Option<Vec<f64>> {
    let command = recording.command_deg.as_ref()?;
    let apart: Vec<f64> = theta.iter().zip(command).map(|(t, c)| t - per_degree * c).collect();
    let spread = |values: &[f64]| {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        match sorted.len() {
            0 => f64::INFINITY,
            _ => super::scale::quantile(&sorted, 0.9) - super::scale::quantile(&sorted, 0.1),
        }
    };
    (spread(&apart) < 0.5 * spread(theta)).then_some(apart)
}

/// Differences of two readings of a turn, each brought next to their median.
fn wrapped(apart: &[f64], turn: f64) -> Vec<f64> {
    let first = apart[0];
    let near = |from: f64, value: f64| value - turn * ((value - from) / turn).round();
    let mut around: Vec<f64> = apart.iter().map(|value| near(first, *value)).collect();
    let middle = super::scale::median(&mut around);
    apart.iter().map(|value| near(middle, *value)).collect()
}

/// Whether a column is a state (off, on, a range) rather than a quantity.
fn is_state(values: &[f64]) -> bool {
    let mut seen: Vec<f64> = Vec::new();
    for value in values.iter().filter(|v| v.is_finite()) {
        if !seen.contains(value) {
            seen.push(*value);
        }
        if seen.len() > 3 {
            return false;
        }
    }
    true
}

/// Whether a column starts again and again from one end of its range, as a count of turns does, and moves little in
/// between.
fn wraps(values: &[f64]) -> bool {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let range = finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
    let mut steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    steps.retain(|step| step.is_finite());
    let jumps = steps.iter().filter(|step| **step > 0.5 * range).count();
    jumps > 4 && super::scale::median(&mut steps) < 0.15 * range
}
