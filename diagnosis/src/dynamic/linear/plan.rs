//! Which rows are fitted and which are held out.

use std::ops::Range;

use fitter::table::Values;

use super::looped::Stretch;
use crate::dynamic::DynamicRecording;
use crate::dynamic::spectrum::Experiments;
use crate::dynamic::spectrum::experiments::{mean_period, periodic, segment_length, segments};
use crate::thresholds::dynamic::linear::plan::{LAST, LEAD, SAME, STRETCH};

/// Runs of one amplitude.
#[derive(Debug, Clone)]
pub struct Group {
    /// The amplitude, from its column or the rms of the drives.
    pub amplitude: f64,
    /// Ranges of rows that are fitted.
    pub fitted: Vec<Range<usize>>,
    /// Ranges of rows that are held out.
    pub held: Vec<Range<usize>>,
}

impl Group {
    /// All its rows.
    pub fn rows(&self) -> Vec<Range<usize>> {
        self.fitted.iter().chain(&self.held).cloned().collect()
    }
}

/// The recording taken apart.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Samples of a period, where the excitation is periodic.
    pub period: Option<usize>,
    /// Groups by increasing amplitude.
    pub groups: Vec<Group>,
    /// Samples of a segment, where it is not.
    pub segment: usize,
    /// What is held out: `run` or `block`.
    pub held_out_by: &'static str,
}

impl Plan {
    /// Takes a recording apart: of every amplitude the last run is held out, where there are more runs
    /// than drives; otherwise the last quarter of every run, unless it is periodic.
    pub fn new(recording: &DynamicRecording) -> Plan {
        let period = period(recording);
        let mut groups: Vec<Group> = Vec::new();
        let mut runs: Vec<(f64, Range<usize>)> =
            recording.runs.iter().map(|r| (amplitude(recording, r), r.clone())).collect();
        runs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.start.cmp(&b.1.start)));
        for (amplitude, run) in runs {
            match groups.last_mut() {
                Some(group) if (amplitude / group.amplitude - 1.0).abs() < SAME => group.fitted.push(run),
                _ => groups.push(Group { amplitude, fitted: vec![run], held: vec![] }),
            }
        }
        // What is left must span the drives.
        let by_run = groups.iter().all(|g| g.fitted.len() > recording.drives.len());
        for group in &mut groups {
            if by_run {
                group.held.extend(group.fitted.pop());
            } else if period.is_none() {
                for run in &mut group.fitted {
                    let cut = run.end - (run.len() as f64 * LAST) as usize;
                    group.held.push(cut..run.end);
                    *run = run.start..cut;
                }
            }
        }
        // One length for all rows, fitted or held out, so that their lines are the same.
        let shortest = groups.iter().flat_map(|g| g.fitted.iter().chain(&g.held)).map(|r| r.len()).min();
        let segment = segment_length(shortest.unwrap_or(0));
        Plan { period, groups, segment, held_out_by: if by_run { "run" } else { "block" } }
    }

    /// Rows that are fitted, of all groups.
    pub fn fitted(&self) -> Vec<Range<usize>> {
        self.groups.iter().flat_map(|g| g.fitted.clone()).collect()
    }

    /// Rows that are held out, of all groups; empty where nothing can be.
    pub fn held(&self) -> Vec<Range<usize>> {
        self.groups.iter().flat_map(|g| g.held.clone()).collect()
    }

    /// Experiments of the given rows, weighted to equal parts of the position's power.
    pub fn experiments(&self, recording: &DynamicRecording, rows: &[Range<usize>]) -> Experiments {
        let (drives, positions) = (&recording.drives, &recording.positions);
        let mut data = match self.period {
            Some(length) => periodic(drives, positions, rows, length, recording.step_s),
            None => segments(drives, positions, rows, self.segment, recording.step_s),
        };
        for e in &mut data.each {
            let power: f64 = e.position.iter().map(|y| y.norm_sqr()).sum();
            e.weight = 1.0 / power.sqrt().max(f64::MIN_POSITIVE);
        }
        data
    }

    /// Stretches of the given rows, all of them.
    pub fn stretches(&self, recording: &DynamicRecording, rows: &[Range<usize>]) -> Vec<Stretch> {
        let mut all = Vec::new();
        for run in rows {
            match self.period {
                Some(_) => all.push(stretch(recording, run.clone(), self.period)),
                None => {
                    let starts = (run.start..run.end.saturating_sub(4 * LEAD)).step_by(STRETCH);
                    let rows = starts.map(|start| start..(start + STRETCH).min(run.end));
                    all.extend(rows.map(|rows| stretch(recording, rows, None)));
                }
            }
        }
        all
    }

    /// Stretches for a fit that together have about so many rows, evenly chosen from every group.
    pub fn chosen(&self, recording: &DynamicRecording, rows: usize) -> Vec<Stretch> {
        let mut all = Vec::new();
        let share = rows / self.groups.len().max(1);
        for group in &self.groups {
            let whole = self.stretches(recording, &group.fitted);
            let size = whole.first().map_or(1, |s| s.rows(recording.drives.len())).max(1);
            let count = (share / size).clamp(1, whole.len().max(1));
            all.extend((0..count).filter_map(|k| whole.get(k * whole.len() / count).cloned()));
        }
        all
    }
}

/// Length of a period, where every run holds whole periods of one length.
pub fn period(recording: &DynamicRecording) -> Option<usize> {
    let numbers = recording.period.as_ref()?;
    let length = recording.period_of(recording.runs.first()?)?;
    let whole = recording.runs.iter().all(|run| {
        run.len() % length == 0
            && numbers[run.clone()].chunks_exact(length).all(|period| period.iter().all(|n| *n == period[0]))
    });
    (whole && length >= 16).then_some(length)
}

fn amplitude(recording: &DynamicRecording, run: &Range<usize>) -> f64 {
    if let Some(column) = &recording.amplitude {
        return column[run.start];
    }
    let sum: f64 = recording
        .drives
        .iter()
        .map(|d| numerics::centred(&d[run.clone()]).iter().map(|v| v.powi(2)).sum::<f64>())
        .sum();
    (sum / (run.len() * recording.drives.len().max(1)).max(1) as f64).sqrt()
}

/// Some rows to be simulated together: their mean period, where there is one of so many rows, or all of them.
pub fn stretch(recording: &DynamicRecording, rows: Range<usize>, period: Option<usize>) -> Stretch {
    let interleaved = |channels: &[Values], rows: Range<usize>| -> Vec<f64> {
        rows.flat_map(|t| channels.iter().map(move |c| c[t])).collect()
    };
    let [drive, position] = [&recording.drives, &recording.positions].map(|channels| match period {
        Some(length) => {
            let means: Vec<Values> = channels.iter().map(|c| mean_period(c, &rows, length).into()).collect();
            interleaved(&means, 0..length)
        }
        None => interleaved(channels, rows.clone()),
    });
    let weight = 1.0 / position.iter().map(|v| v * v).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    Stretch {
        drive,
        position,
        periodic: period.is_some(),
        skip: if period.is_some() { 0 } else { LEAD },
        weight,
    }
}
