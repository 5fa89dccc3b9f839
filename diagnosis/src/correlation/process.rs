//! What noise may be: a sum of white readings and of parts that are forgotten with a time constant each. One such part is
//! what a filter makes of noise, or a telegraph that switches; one that outlasts the recording is a reference that wanders;
//! parts over all time constants are flicker.

use super::Correlation;
use crate::thresholds::correlation::{
    FLICKER_PER_DECADE, PARTS_OF_VARIANCE, POINTS, POINTS_BESIDE_WHITE, SHORTEST, UNCORRELATED,
};

/// A stationary process of variance one.
#[derive(Debug, Clone, PartialEq)]
pub struct Process {
    /// The variance of what is new in every reading.
    pub new: f64,
    /// The variance of every other part, and its time constant in typical gaps between rows.
    pub parts: Vec<(f64, f64)>,
}

impl Process {
    /// Readings that do not correlate.
    pub fn white() -> Process {
        Process { new: 1.0, parts: Vec::new() }
    }

    /// Readings of which `part` of the variance is forgotten with the time constant `time` (typical gaps), and the rest at
    /// once.
    pub fn slow(part: f64, time: f64) -> Process {
        Process { new: 1.0 - part, parts: vec![(part, time)] }
    }

    /// The same with a part as strong in every ratio of time constants from a gap to `longest` gaps.
    fn flicker(part: f64, longest: f64) -> Process {
        let steps = (FLICKER_PER_DECADE * longest.log10()).ceil().max(1.0);
        let time = |k: usize| longest.powf(k as f64 / steps);
        let count = steps as usize + 1;
        Process { new: 1.0 - part, parts: (0..count).map(|k| (part / count as f64, time(k))).collect() }
    }

    /// The covariance of readings so many typical gaps apart.
    pub fn after(&self, gaps: f64) -> f64 {
        self.parts.iter().map(|(part, time)| part * (-gaps / time).exp()).sum()
    }

    /// The process of one time constant with the mean correlation a gap apart.
    pub fn mean(posterior: &[(Process, f64)]) -> Process {
        let typical: f64 = posterior.iter().map(|(process, weight)| weight * process.after(1.0)).sum();
        if typical > UNCORRELATED { Process::slow(1.0, -1.0 / typical.ln()) } else { Process::white() }
    }
}

impl Correlation {
    /// Processes that are forgotten with one time constant, in ascending order of it.
    pub fn forgotten(&self) -> Vec<Process> {
        times(POINTS, self.longest()).map(|time| Process::slow(1.0, time)).collect()
    }

    /// Processes that last beside white readings: one part, up to those that outlast the recording, and flicker.
    pub fn lasting(&self) -> Vec<Process> {
        let beside = |part: &f64| {
            times(POINTS_BESIDE_WHITE, 4.0 * self.longest()).map(|time| Process::slow(*part, time)).collect()
        };
        let one: Vec<Vec<Process>> = PARTS_OF_VARIANCE.iter().map(beside).collect();
        let flicker = |part: &f64| Process::flicker(*part, self.duration().max(10.0));
        one.into_iter().flatten().chain(PARTS_OF_VARIANCE.iter().chain(&[1.0]).map(flicker)).collect()
    }

    fn longest(&self) -> f64 {
        (0.25 * self.duration()).max(4.0 * SHORTEST)
    }
}

/// Correlation times from the shortest to `longest` in equal ratios.
fn times(count: usize, longest: f64) -> impl Iterator<Item = f64> {
    let part = move |k: usize| k as f64 / (count - 1) as f64;
    (0..count).map(move |k| SHORTEST * (longest / SHORTEST).powf(part(k)))
}
