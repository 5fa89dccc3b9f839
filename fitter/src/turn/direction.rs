//! Forward and backward, told apart: friction and backlash move the reading by a constant whose sign is the
//! direction's, a lag by the speed. One direction alone shows neither; one speed alone does not tell the two apart.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::Turn;
use super::description::{Directions, Estimate};
use super::solve::Columns;
use super::unwind::Unwound;
use crate::figures::{figure, plus_minus};
use crate::recording::Recording;
use crate::statistics::readable;

impl Estimate {
    pub(super) fn of(value: f64, standard_error: f64, quantile: f64) -> Estimate {
        let reach = quantile * standard_error;
        Estimate {
            value: readable(value),
            standard_error: readable(standard_error),
            ci95: [readable(value - reach), readable(value + reach)],
        }
    }

    fn is_zero(&self) -> bool {
        self.ci95[0] <= 0.0 && self.ci95[1] >= 0.0
    }
}

/// The motion of every row, as far as it can be told.
pub(super) struct Motion {
    /// Whether both directions were recorded.
    pub both: bool,
    /// Speed with its sign, in the sensor's unit per second, where it changes enough to tell a lag.
    pub velocity: Option<Vec<f64>>,
    speed: Option<[f64; 2]>,
    counts: [usize; 2],
}

/// The 90th percentile of the speed has to be so many times the 10th before a lag is looked for.
const SPEEDS: f64 = 1.5;

impl Motion {
    pub fn of(recording: &Recording, unwound: &Unwound) -> Motion {
        let rows = recording.rows();
        let forward = recording.direction.iter().filter(|direction| **direction > 0).count();
        let velocity: Vec<f64> = (0..rows)
            .map(|row| {
                let joined = |other: &usize| {
                    *other < rows
                        && recording.pass[*other] == recording.pass[row]
                        && recording.direction[*other] == recording.direction[row]
                };
                let before = row.checked_sub(1).filter(joined).unwrap_or(row);
                let after = Some(row + 1).filter(joined).unwrap_or(row);
                let time = recording.time_s[after] - recording.time_s[before];
                let way = unwound.reference[after] - unwound.reference[before];
                if time > 0.0 { way / time } else { f64::NAN }
            })
            .collect();
        let mut speeds: Vec<f64> = velocity.iter().map(|v| v.abs()).filter(|v| !v.is_nan()).collect();
        speeds.sort_by(f64::total_cmp);
        let at = |part: f64| speeds[((speeds.len() - 1) as f64 * part) as usize];
        let known = 2 * speeds.len() > rows;
        let speed = known.then(|| [at(0.1), at(0.9)]);
        let varied = speed.is_some_and(|[low, high]| high > SPEEDS * low);
        let typical = if known { at(0.5) } else { 0.0 };
        let counts = [forward, rows - forward];
        let filled = || {
            (velocity.iter().zip(&recording.direction))
                .map(|(v, direction)| if v.is_nan() { typical * f64::from(*direction) } else { *v })
                .collect()
        };
        Motion { both: counts[0] > 0 && counts[1] > 0, velocity: varied.then(filled), speed, counts }
    }
}

/// What is said of a recording that covers a part of the turn: a polynomial was fitted to it.
pub(crate) fn part(recording: &Recording, revolution: f64, unwound: &Unwound) -> Turn {
    Turn {
        from: unwound.from,
        counts_turns: unwound.counts_turns,
        whole: false,
        wraps: unwound.wraps,
        directions: directions_of_part(recording, unwound),
        ..Turn::single(revolution)
    }
}

/// The directions of a recording to which no harmonics were fitted: what a polynomial leaves is tested for
/// them elsewhere.
fn directions_of_part(recording: &Recording, unwound: &Unwound) -> Directions {
    let motion = Motion::of(recording, unwound);
    let mut directions = Directions::default().of(&motion, "");
    if motion.both {
        directions.statement =
            "a part of the turn: forward and backward are compared by what the fit leaves".to_string();
    }
    directions
}

/// Chance below which the distance between directions is said to vary over the turn.
const VARIES: f64 = 0.001;

/// How far half the distance varies over the turn, from what the fit left: its first two harmonics.
pub(super) fn variation(
    recording: &Recording,
    residual: &[f64],
    freedom: usize,
    phase: &dyn Fn(usize) -> (f64, f64),
) -> Option<f64> {
    let scale = 1.0 / (recording.rows() as f64).sqrt();
    let fill = |row: usize, values: &mut [f64]| {
        let ((cosine, sine), direction) = (phase(row), f64::from(recording.direction[row]));
        let second = (cosine * cosine - sine * sine, 2.0 * sine * cosine);
        for (value, wave) in values.iter_mut().zip([cosine, sine, second.0, second.1]) {
            *value = scale * direction * wave;
        }
    };
    let columns = Columns { count: 4, rows: recording.rows(), fill: Box::new(fill) };
    let solution = columns.solve(residual)?;
    let before: f64 = residual.iter().map(|r| r * r).sum();
    let left = freedom.checked_sub(4).filter(|left| *left > 0)? as f64;
    let ratio = (before - solution.squares).max(0.0) / 4.0 / (solution.squares / left);
    let chance = FisherSnedecor::new(4.0, left).ok()?.sf(ratio);
    // A wave of amplitude A has a root mean square of A/√2.
    let squares: f64 = solution.c.iter().map(|c| 0.5 * (c * scale) * (c * scale)).sum();
    (chance < VARIES).then(|| readable(squares.sqrt()))
}

impl Directions {
    /// With what the motion shows, and the statement of both.
    pub(super) fn of(self, motion: &Motion, unit: &str) -> Directions {
        let [forward, backward] = motion.counts;
        let speed_per_s = motion.speed.map(|speed| speed.map(readable));
        let statement = statement(motion, &self, unit);
        Directions { forward, backward, speed_per_s, statement, ..self }
    }
}

fn statement(motion: &Motion, found: &Directions, unit: &str) -> String {
    let Directions { half_distance, lag_s, variation_rms: variation, lag_corrected, .. } = found;
    let half = half_distance.as_ref();
    let lag_found = lag_s.as_ref().map(|lag| {
        let reach = 0.5 * (lag.ci95[1] - lag.ci95[0]);
        if *lag_corrected {
            format!("a lag of {} (corrected)", plus_minus(lag.value, reach, "s"))
        } else if lag.is_zero() {
            format!("no lag beyond {}", figure(lag.ci95[0].abs().max(lag.ci95[1].abs()), "s"))
        } else {
            format!("a lag of {}", plus_minus(lag.value, reach, "s"))
        }
    });
    let Some(half) = half else {
        if let (true, Some(lag)) = (motion.both, &lag_found) {
            return if *lag_corrected {
                format!("forward and backward differ by nothing significant beyond {lag}")
            } else {
                format!("{lag}; the axis stood in one direction, so that friction cannot be told from it")
            };
        }
        let also = lag_found.map_or(String::new(), |lag| format!("; {lag} by the change of speed"));
        let open = if also.is_empty() { "friction, backlash and lag" } else { "friction and backlash" };
        return format!(
            "one direction only: {open} cannot be told from an offset of the zero{also}; record the turn in both directions"
        );
    };
    let reach = 0.5 * (half.ci95[1] - half.ci95[0]);
    let mut text = if half.is_zero() {
        let within = figure(half.ci95[0].abs().max(half.ci95[1].abs()), unit);
        format!("forward and backward agree within ±{within}")
    } else {
        let behind = if half.value < 0.0 { "the reading stays behind" } else { "the reference stays behind" };
        format!("forward and backward lie 2 × {} apart ({behind})", plus_minus(half.value.abs(), reach, unit))
    };
    match (lag_found, motion.speed, half.is_zero()) {
        (Some(lag), _, true) => text += &format!("; {lag}"),
        (Some(lag), _, false) => text += &format!(": friction or backlash; beside it {lag}"),
        (None, Some([_, fast]), false) if half.value < 0.0 && fast > 0.0 => {
            text += &format!(
                ": friction or backlash, or, if the axis moved while it was read, a lag of {}; a second speed would \
                 tell",
                figure(-half.value / fast, "s")
            );
        }
        (None, _, false) => text += ": friction or backlash",
        (None, _, true) => {}
    }
    if let Some(rms) = *variation {
        text += &format!(
            "; the distance varies over the turn by 2 × {} rms (friction or cogging)",
            figure(rms, unit)
        );
    }
    text
}
