//! The recorded motion as the inverse model needs it: smoothed position, velocity and acceleration, and the
//! accelerations that the catalogue's effects add along it.

use numerics::range;

use super::filter::{derivative, low_pass, second_derivative};
use crate::dynamic::effects::{DynamicEffect, Flow, Part};
use crate::dynamic::recording::DynamicRecording;
use crate::thresholds::dynamic::effects::MOST_STATES;
use crate::thresholds::dynamic::feedback::motion::{STANDING, SUBSTEPS};

/// A smoothed motion, all runs one after another.
pub struct Motion {
    /// Time from row to row, s.
    pub step_s: f64,
    /// Rows of every run.
    pub runs: Vec<std::ops::Range<usize>>,
    /// Cut-off of the smoothing, Hz.
    pub cutoff_hz: f64,
    /// Position, velocity, acceleration.
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
    /// The smoothed drive.
    pub drive: Vec<f64>,
    /// Speed that counts as standing still.
    pub slow: f64,
    /// Whether the mechanism moves in each row. Where it stands still for longer than the smoothing takes, dry friction holds any
    /// drive that is smaller, and the drive says nothing.
    pub moving: Vec<bool>,
}

impl Motion {
    /// The range of an observable.
    pub fn reach(&self, variable: &str) -> (f64, f64) {
        match variable {
            "position" | "history" => range(&self.position),
            "drive" => range(&self.drive),
            "frequency_hz" => (0.0, self.cutoff_hz),
            _ => range(&self.velocity),
        }
    }

    /// Smooths the motion of a recording; `slow` is the speed that counts as standing still, by default a
    /// part of the recording's own.
    pub fn new(recording: &DynamicRecording, cutoff_hz: f64, slow: Option<f64>) -> Motion {
        let h = recording.step_s;
        let (mut position, mut velocity, mut acceleration, mut drive) = (vec![], vec![], vec![], vec![]);
        for run in &recording.runs {
            let x = low_pass(&recording.positions[0][run.clone()], cutoff_hz, h);
            let v = derivative(&x, h);
            acceleration.extend(second_derivative(&x, h));
            velocity.extend(v);
            position.extend(x);
            drive.extend(low_pass(&recording.drives[0][run.clone()], cutoff_hz, h));
        }
        let slow = slow.unwrap_or_else(|| STANDING * numerics::rms(&velocity)).max(f64::MIN_POSITIVE);
        let smoothed = (1.0 / (cutoff_hz * h)).ceil() as usize;
        let moving =
            recording.runs.iter().flat_map(|run| moves(&velocity[run.clone()], slow, smoothed)).collect();
        Motion {
            step_s: h,
            runs: recording.runs.clone(),
            cutoff_hz,
            position,
            velocity,
            acceleration,
            drive,
            slow,
            moving,
        }
    }

    /// All rows in which the mechanism moves.
    pub fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.runs.iter().cloned().flatten().filter(|row| self.moving[*row])
    }

    /// Root mean square of what a model leaves of these rows.
    pub fn rms(&self, residual: &[f64]) -> f64 {
        numerics::rms(&self.rows().map(|row| residual[row]).collect::<Vec<f64>>())
    }

    /// Independent readings per row of what has passed the smoothing.
    pub fn independent_per_row(&self) -> f64 {
        (2.0 * self.cutoff_hz * self.step_s).min(1.0)
    }

    /// `x` smoothed as the motion is.
    pub fn smooth(&self, x: &[f64]) -> Vec<f64> {
        self.runs.iter().flat_map(|r| low_pass(&x[r.clone()], self.cutoff_hz, self.step_s)).collect()
    }

    /// Time derivative of a smoothed column.
    pub fn rate(&self, x: &[f64]) -> Vec<f64> {
        self.runs.iter().flat_map(|r| derivative(&x[r.clone()], self.step_s)).collect()
    }

    /// What an effect adds to the acceleration along the motion.
    pub fn force(&self, effect: &DynamicEffect, parameters: &[f64], gain: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.position.len()];
        if effect.part != Part::Force {
            return out;
        }
        let count = effect.states;
        for run in &self.runs {
            let mut states = (effect.rest)(self.position[run.start]);
            for k in run.clone() {
                let next = (k + 1).min(run.end - 1);
                let at = |part: f64, states: &[f64; MOST_STATES]| -> (f64, [f64; MOST_STATES]) {
                    let between = |x: &[f64]| x[k] + part * (x[next] - x[k]);
                    let velocity = between(&self.velocity);
                    let (mut acceleration, mut rates) = (0.0, [0.0; MOST_STATES]);
                    let mut flow = Flow {
                        drive: &between(&self.drive),
                        position: &between(&self.position),
                        velocity: &velocity,
                        gain: &gain,
                        direction: (velocity / self.slow).clamp(-1.0, 1.0),
                        time: (k - run.start) as f64 * self.step_s,
                        acceleration: &mut acceleration,
                        states: &states[..count],
                        rates: &mut rates[..count],
                    };
                    effect.law.force(parameters, &mut flow);
                    (acceleration, rates)
                };
                out[k] = at(0.0, &states).0;
                if count > 0 {
                    // Midpoint rule in a few steps.
                    let h = self.step_s / SUBSTEPS as f64;
                    for i in 0..SUBSTEPS {
                        let part = i as f64 / SUBSTEPS as f64;
                        let first = at(part, &states).1;
                        let mut middle = states;
                        (0..count).for_each(|j| middle[j] += 0.5 * h * first[j]);
                        let rates = at(part + 0.5 / SUBSTEPS as f64, &middle).1;
                        (0..count).for_each(|j| states[j] += h * rates[j]);
                    }
                }
            }
        }
        out
    }
}

/// Which rows of a run are none of those in which it is slow for more than `smoothed` rows. A smoothed motion begins before the
/// mechanism does, so that the stretch needs no margin.
fn moves(velocity: &[f64], slow: f64, smoothed: usize) -> Vec<bool> {
    let mut moving = vec![true; velocity.len()];
    let mut from = 0;
    for stretch in velocity.chunk_by(|a, b| (a.abs() < slow) == (b.abs() < slow)) {
        let to = from + stretch.len();
        if stretch[0].abs() < slow && stretch.len() > smoothed {
            moving[from..to].fill(false);
        }
        from = to;
    }
    moving
}

#[cfg(test)]
mod tests {
    use super::moves;

    #[test]
    fn a_mechanism_that_stands_still_tells_nothing_and_one_that_turns_round_does() {
        let velocity: Vec<f64> =
            [vec![1.0; 5], vec![0.0; 8], vec![-1.0; 5], vec![0.0; 2], vec![1.0; 3]].concat();
        let left: Vec<usize> = (0..velocity.len()).filter(|k| !moves(&velocity, 0.1, 4)[*k]).collect();
        assert_eq!(left, (5..13).collect::<Vec<usize>>());
    }
}
