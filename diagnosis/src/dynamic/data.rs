//! One axis of a recording as an estimate reads it: runs, drive, position, which rows fit, which choose and
//! which score.

use std::ops::Range;

use fitter::plant::Hold;

use super::effects::Scale;
use super::recording::DynamicRecording;
use super::signal::Signal;
use super::simulate::Course;
use super::turns::Turns;
use crate::numerics::mean;
use crate::thresholds::dynamic::data::{BLOCKS, BLOCKS_OF_WINDOW, BOUND, LEAST_WINDOW, MOST_LEAD, WINDOWS};

/// Number of kinds of rows.
pub const FOLDS: usize = 3;
/// Rows that fit.
pub const FIT: usize = 0;
/// Rows that choose among the fitted.
pub const CHOOSE: usize = 1;
/// Rows that score what was chosen.
pub const SCORE: usize = 2;
/// All rows.
pub const ALL: [bool; FOLDS] = [true; FOLDS];

/// One axis.
pub struct Data<'a> {
    /// Time from row to row, s.
    pub step_s: f64,
    /// Rows of every run.
    pub runs: Vec<Range<usize>>,
    /// Drive.
    pub drive: &'a [f64],
    /// Position.
    pub position: &'a [f64],
    /// Kind of every row.
    pub fold: Vec<u8>,
    /// Bound of a simulated position.
    pub bound: f64,
    /// Sizes.
    pub scale: Scale,
    /// Time at the start of every run since the start of the one that it is a window of, s.
    pub starts_s: Vec<f64>,
    /// Duration of the longest run, s.
    pub duration_s: f64,
    signals: [Vec<Signal>; 3],
    /// For every run the extremes of the drive before it, in each way of running between the samples.
    before: [Vec<Vec<f64>>; 3],
    /// For every run rows in which the drive ran as it did just before it.
    leads: Vec<Range<usize>>,
}

/// The ways in which a drive may run between its samples.
pub const HOLDS: [Hold; 3] = [Hold::BandLimited, Hold::FirstOrder, Hold::ZeroOrder];

impl<'a> Data<'a> {
    /// The first axis of a recording.
    pub fn new(recording: &'a DynamicRecording) -> Data<'a> {
        let (drive, position) = (recording.drives[0].as_slice(), recording.positions[0].as_slice());
        let rows = position.len();
        let length = rows.div_ceil(BLOCKS).max(1);
        let mut kinds: Vec<usize> = (0..BLOCKS).map(|block| [FIT, CHOOSE, FIT, SCORE][block % 4]).collect();
        // The drive's largest excursion, where a limit acts that acts nowhere else, is on rows that fit, and the block
        // that follows in its place: the drive alone says which they are. The first block fits, since the initial
        // state does not follow from later ones.
        let size = |k: &usize| drive[*k].abs();
        let largest = (0..rows).max_by(|a, b| size(a).total_cmp(&size(b))).map_or(0, |k| k / length);
        if kinds[largest] != FIT {
            let next = if largest + 1 < rows.div_ceil(length) { largest + 1 } else { largest - 1 };
            kinds.swap(largest, next);
        }
        let fold = (0..rows).map(|k| kinds[k / length] as u8).collect();
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let leads: Vec<Range<usize>> = recording.runs.iter().map(|run| lead(recording, run)).collect();
        let signals = HOLDS.map(|hold| {
            let of = |(run, lead): (&Range<usize>, &Range<usize>)| {
                let samples = [&drive[lead.clone()], &drive[run.clone()]].concat();
                Signal::new(&samples, lead.len(), recording.step_s, hold)
            };
            recording.runs.iter().zip(&leads).map(of).collect()
        });
        let before = HOLDS.map(|hold| {
            let of = |run: &Range<usize>| {
                extremes(&Signal::new(&drive[first_period(recording, run)], 0, recording.step_s, hold))
            };
            recording.runs.iter().map(of).collect()
        });
        Data {
            step_s: recording.step_s,
            runs: recording.runs.clone(),
            drive,
            position,
            fold,
            bound: BOUND * largest(position).max(f64::MIN_POSITIVE),
            scale: scale(drive, position, recording.step_s, &recording.runs),
            starts_s: vec![0.0; recording.runs.len()],
            duration_s: recording.runs.iter().map(|r| r.len()).max().unwrap_or(1) as f64 * recording.step_s,
            signals,
            before,
            leads,
        }
    }

    /// The same axis with only the first rows of every run.
    pub fn head(mut self, rows: usize) -> Data<'a> {
        self.runs.iter_mut().for_each(|run| run.end = run.end.min(run.start + rows));
        self
    }

    /// The same axis through windows that together hold about `rows` rows, spread evenly: enough to choose
    /// among effects, and a long recording costs no more than a short one. Every window is a run with an
    /// initial state of its own; the drive between samples stays that of the whole run.
    pub fn windows(&self, rows: usize) -> Data<'a> {
        let total: usize = self.runs.iter().map(|r| r.len()).sum();
        let per_run = (WINDOWS / self.runs.len()).max(1);
        let length = (rows / (per_run * self.runs.len())).max(LEAST_WINDOW);
        let mut data = Data {
            step_s: self.step_s,
            runs: Vec::new(),
            drive: self.drive,
            position: self.position,
            fold: self.fold.clone(),
            bound: self.bound,
            scale: self.scale,
            starts_s: Vec::new(),
            duration_s: self.duration_s,
            signals: [Vec::new(), Vec::new(), Vec::new()],
            before: [Vec::new(), Vec::new(), Vec::new()],
            leads: Vec::new(),
        };
        let whole = rows >= total;
        let mut windows = 0;
        for (k, run) in self.runs.iter().enumerate() {
            let (count, length) =
                if whole { (1, run.len()) } else { (per_run, length.min(run.len() / per_run)) };
            for i in 0..count {
                let free = run.len() - count * length;
                let start = i * length + if count > 1 { free * i / (count - 1) } else { 0 };
                data.runs.push(run.start + start..run.start + start + length);
                data.starts_s.push(self.starts_s[k] + start as f64 * self.step_s);
                for ((own, all), signals) in data.before.iter_mut().zip(&self.before).zip(&self.signals) {
                    let mut turns = Turns::new();
                    all[k].iter().for_each(|u| {
                        turns.to(*u);
                    });
                    signals[k].pass(0..start, &mut turns);
                    own.push(turns.inputs().collect());
                }
                let lead = match start {
                    0 => self.leads[k].clone(),
                    _ => run.start + start.saturating_sub(MOST_LEAD)..run.start + start,
                };
                for (own, all) in data.signals.iter_mut().zip(&self.signals) {
                    own.push(all[k].part(start..start + length, lead.len()));
                }
                data.leads.push(lead);
                if !whole {
                    let block = length.div_ceil(BLOCKS_OF_WINDOW).max(1);
                    for (j, fold) in
                        data.fold[run.start + start..run.start + start + length].iter_mut().enumerate()
                    {
                        *fold = [FIT, CHOOSE, FIT, SCORE][(j / block + windows) % 4] as u8;
                    }
                }
                windows += 1;
            }
        }
        data
    }

    /// What a run is simulated along.
    pub fn course(&self, run: usize, hold: Hold) -> Course<'_> {
        let k = HOLDS.iter().position(|h| *h == hold).unwrap_or(0);
        Course {
            signal: &self.signals[k][run],
            step_s: self.step_s,
            rows: self.runs[run].len(),
            start_s: self.starts_s[run],
            bound: self.bound,
            before: &self.before[k][run],
            lead: &self.position[self.leads[run].clone()],
        }
    }

    /// Number of rows of the wanted kinds.
    pub fn count(&self, folds: [bool; FOLDS]) -> usize {
        let of = |run: &Range<usize>| self.fold[run.clone()].iter().filter(|f| folds[**f as usize]).count();
        self.runs.iter().map(of).sum()
    }

    /// First guess of position and velocity at the start of every run: a parabola through the first rows.
    pub fn first_states(&self) -> Vec<[f64; 2]> {
        self.runs
            .iter()
            .map(|run| {
                let y = &self.position[run.start..run.end.min(run.start + 7)];
                let last = y.len() - 1;
                [y[0], (y[last] - y[0]) / (last as f64 * self.step_s)]
            })
            .collect()
    }
}

/// Rows in which the drive ran as just before a run: the end of the period where the excitation is in its
/// steady state, else none.
fn lead(recording: &DynamicRecording, run: &Range<usize>) -> Range<usize> {
    let period = first_period(recording, run);
    period.start.max(period.end.saturating_sub(MOST_LEAD))..period.end
}

/// Rows of the first period of a run; none where it is not in a steady state.
fn first_period(recording: &DynamicRecording, run: &Range<usize>) -> Range<usize> {
    let same = |period: &Vec<i64>| run.clone().take_while(|k| period[*k] == period[run.start]).count();
    run.start..run.start + recording.period.as_ref().map_or(0, same)
}

/// The extremes that are left of a whole signal.
fn extremes(signal: &Signal) -> Vec<f64> {
    let mut turns = Turns::<f64>::new();
    signal.pass(0..signal.intervals(), &mut turns);
    turns.inputs().collect()
}

fn scale(drive: &[f64], position: &[f64], step_s: f64, runs: &[Range<usize>]) -> Scale {
    let middle = mean(position);
    let stroke = position.iter().fold(0.0_f64, |m, p| m.max((p - middle).abs()));
    // Differences over several rows, so that the reading noise does not make the speed.
    let over = 4;
    let (mut square, mut bend, mut count) = (0.0, 0.0, 0.0);
    for run in runs {
        let y = &position[run.clone()];
        for k in over..y.len() - over {
            square += ((y[k + over] - y[k - over]) / (2 * over) as f64).powi(2);
            bend += (y[k] - middle).powi(2);
            count += 1.0;
        }
    }
    let count: f64 = f64::max(count, 1.0);
    let speed = (square / count).sqrt() / step_s;
    let rms = (bend / count).sqrt().max(f64::MIN_POSITIVE);
    let largest = drive.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    Scale { stroke, speed, drive: largest, step_s, rate: (speed / rms).max(f64::MIN_POSITIVE) }
}
