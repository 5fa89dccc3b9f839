//! What noise may be: a sum of white readings and of parts that are forgotten with a time constant each. One such part is
//! what a filter makes of noise, or a telegraph that switches; one that outlasts the recording is a reference that wanders;
//! parts over all time constants are flicker.

use super::Correlation;
use crate::thresholds::correlation::{
    FLICKER_PER_DECADE, MOST_PARTS, PARTS_OF_VARIANCE, POINTS, POINTS_BESIDE_WHITE, PRIOR_LASTING,
    PRIOR_UNCORRELATED, SHORTEST,
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

    /// How long the process is remembered (typical gaps): the integral of its covariance.
    pub fn slowness(&self) -> f64 {
        self.parts.iter().map(|(part, time)| part * time).sum()
    }

    /// The largest difference of the covariances, over distances of a gap to a hundred.
    pub fn differs(&self, other: &Process) -> f64 {
        let apart = |gaps: &f64| (self.after(*gaps) - other.after(*gaps)).abs();
        [1.0, 10.0, 100.0].iter().map(apart).fold(0.0, f64::max)
    }

    /// The process with the mean covariance, near parts merged.
    pub fn mean(posterior: &[(Process, f64)]) -> Process {
        let mut parts: Vec<(f64, f64)> = posterior
            .iter()
            .flat_map(|(process, weight)| {
                process.parts.iter().map(move |(part, time)| (weight * part, *time))
            })
            .collect();
        parts.sort_by(|a, b| a.1.total_cmp(&b.1));
        while parts.len() > MOST_PARTS {
            // What merging costs: the variance that moves, by how far it moves.
            let cost = |k: usize| {
                let ((a, s), (b, t)) = (parts[k], parts[k + 1]);
                a * b / (a + b).max(f64::MIN_POSITIVE) * (t / s).ln().powi(2)
            };
            let least = (0..parts.len() - 1).min_by(|i, j| cost(*i).total_cmp(&cost(*j))).unwrap_or(0);
            let ((a, s), (b, t)) = (parts[least], parts.remove(least + 1));
            parts[least] = (a + b, ((a * s.ln() + b * t.ln()) / (a + b).max(f64::MIN_POSITIVE)).exp());
        }
        parts.retain(|(part, _)| *part > f64::EPSILON);
        Process { new: 1.0 - parts.iter().map(|(part, _)| part).sum::<f64>(), parts }
    }
}

impl Correlation {
    /// Processes that the readings may be of, each with its prior probability, along families in which neighbours resemble
    /// each other; without white readings alone.
    pub fn families(&self) -> Vec<Vec<(Process, f64)>> {
        let duration = self.duration();
        let longest = (0.25 * duration).max(4.0 * SHORTEST);
        let times = |count: usize, longest: f64| -> Vec<f64> {
            let part = |k: usize| k as f64 / (count - 1) as f64;
            (0..count).map(|k| SHORTEST * (longest / SHORTEST).powf(part(k))).collect()
        };
        let alone: Vec<Process> = times(POINTS, longest).into_iter().map(|t| Process::slow(1.0, t)).collect();
        let mut families: Vec<Vec<Process>> = vec![alone];
        // Beside white readings a part may outlast the recording.
        let beside = times(POINTS_BESIDE_WHITE, 4.0 * longest);
        let of_part = |part: &f64| beside.iter().map(|t| Process::slow(*part, *t)).collect();
        families.extend(PARTS_OF_VARIANCE.iter().map(of_part));
        let flicker =
            PARTS_OF_VARIANCE.iter().chain(&[1.0]).map(|part| Process::flicker(*part, duration.max(10.0)));
        families.push(flicker.collect());
        let alone = 1.0 - PRIOR_UNCORRELATED - 2.0 * PRIOR_LASTING;
        let last = families.len() - 1;
        let sizes =
            [0..1, 1..last, last..last + 1].map(|kind| families[kind].iter().map(Vec::len).sum::<usize>());
        let prior = |family: usize| match family {
            0 => alone / sizes[0] as f64,
            k if k < last => PRIOR_LASTING / sizes[1] as f64,
            _ => PRIOR_LASTING / sizes[2] as f64,
        };
        let with_prior = |(k, family): (usize, Vec<Process>)| {
            family.into_iter().map(|process| (process, prior(k))).collect()
        };
        families.into_iter().enumerate().map(with_prior).collect()
    }
}
