//! One axis of a recording as an estimate reads it: runs, drive, position, which rows fit, which choose and
//! which score.

use std::iter::Sum;
use std::ops::Range;

use fitter::plant::Hold;
use fitter::table::Values;
use motion::equations::Input;
use numerics::mean;

use super::effects::{Part, Scale};
use super::model::{Model, Term};
use super::recording::DynamicRecording;
use super::signal::Signal;
use super::simulate::Course;
use super::turns::Turns;
use crate::thresholds::dynamic::data::{
    BLOCKS, BLOCKS_OF_WINDOW, BOUND, LEAST_WINDOW, MOST_LEAD, PERIODS, WINDOWS,
};

/// Number of kinds of rows.
pub const FOLDS: usize = 3;
/// Rows that fit.
pub const FIT: usize = 0;
/// Rows that choose among the fitted.
pub const CHOOSE: usize = 1;
/// Rows that score what was chosen.
pub const SCORE: usize = 2;
/// Which kinds of rows are wanted.
pub type Folds = [bool; FOLDS];
/// All rows.
pub const ALL: Folds = [true; FOLDS];
/// Those that fit.
pub const FIT_ROWS: Folds = [true, false, false];
/// Those that choose.
pub const CHOOSE_ROWS: Folds = [false, true, false];
/// Those that score.
pub const SCORE_ROWS: Folds = [false, false, true];
/// All but those that score.
pub const UNSCORED: Folds = [true, true, false];

/// Sum of what there is of every kind of row over the wanted ones.
pub fn over<T: Copy + Sum>(folds: Folds, each: &[T; FOLDS]) -> T {
    each.iter().zip(folds).filter(|(_, wanted)| *wanted).map(|(x, _)| *x).sum()
}

/// One axis.
#[derive(Clone)]
pub struct Data<'a> {
    /// Time from row to row, s.
    pub step_s: f64,
    /// Rows of every run.
    pub runs: Vec<Range<usize>>,
    pub drive: &'a [f64],
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
    lanes: Vec<Lane>,
}

/// What a run is simulated along.
#[derive(Clone)]
struct Lane {
    /// Rows in which the drive ran as it did just before the run.
    lead: Range<usize>,
    /// The drive, in each way of running between the samples.
    signals: [Signal; 3],
    /// The same, where it is band-limited, as a hysteresis or a limit sees it: both respond to how far it goes between the samples.
    fine: Signal,
    /// The extremes of the drive before the run, likewise.
    before: [Vec<f64>; 3],
    /// Further drives, likewise.
    further: Vec<[Signal; 3]>,
}

impl Lane {
    fn new(recording: &DynamicRecording, run: &Range<usize>) -> Lane {
        let (drive, step_s) = (&recording.drives[0], recording.step_s);
        // Rows of the first period, where the excitation is in its steady state: its end comes before the run.
        let period = run.start..run.start + recording.period_of(run).unwrap_or(0);
        let lead = period.start.max(period.end.saturating_sub(MOST_LEAD))..period.end;
        let samples = [&drive[lead.clone()], &drive[run.clone()]].concat();
        let signals = HOLDS.map(|hold| Signal::new(&samples, lead.len(), step_s, hold));
        let fine = Signal::fine(&samples, lead.len(), step_s);
        let before = HOLDS.map(|hold| {
            let whole = match hold {
                Hold::BandLimited => Signal::fine(&drive[period.clone()], 0, step_s),
                _ => Signal::new(&drive[period.clone()], 0, step_s, hold),
            };
            extremes(&[], &whole, whole.intervals())
        });
        let own = |drive: &Values| HOLDS.map(|hold| Signal::new(&drive[run.clone()], 0, step_s, hold));
        let further = recording.drives[1..].iter().map(own).collect();
        Lane { lead, signals, fine, before, further }
    }

    /// The drive as a hysteresis or a limit sees it.
    fn seen(&self, hold: usize) -> &Signal {
        if HOLDS[hold] == Hold::BandLimited { &self.fine } else { &self.signals[hold] }
    }

    /// That of some rows of the run, which begins at row `first`.
    fn part(&self, first: usize, rows: Range<usize>) -> Lane {
        let lead = match rows.start {
            0 => self.lead.clone(),
            start => first + start.saturating_sub(MOST_LEAD)..first + start,
        };
        let signals = self.signals.each_ref().map(|signal| signal.part(rows.clone(), lead.len()));
        let before = std::array::from_fn(|hold| extremes(&self.before[hold], self.seen(hold), rows.start));
        let fine = self.fine.part(rows.clone(), lead.len());
        let cut = |drive: &[Signal; 3]| drive.each_ref().map(|signal| signal.part(rows.clone(), 0));
        let further = self.further.iter().map(cut).collect();
        Lane { lead, signals, fine, before, further }
    }
}

/// The extremes that are left of those before a signal and of its first intervals.
fn extremes(before: &[f64], signal: &Signal, intervals: usize) -> Vec<f64> {
    let mut turns = Turns::<f64>::new();
    before.iter().for_each(|u| _ = turns.to(*u));
    signal.pass(0..intervals, &mut turns);
    turns.inputs().collect()
}

/// The ways in which a drive may run between its samples.
pub const HOLDS: [Hold; 3] = [Hold::BandLimited, Hold::FirstOrder, Hold::ZeroOrder];

impl<'a> Data<'a> {
    /// The first axis of a recording.
    pub fn new(recording: &'a DynamicRecording) -> Data<'a> {
        let (drive, position) = (&*recording.drives[0], &*recording.positions[0]);
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
            lanes: recording.runs.iter().map(|run| Lane::new(recording, run)).collect(),
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
        let fold = self.fold.clone();
        let mut data = Data { runs: Vec::new(), starts_s: Vec::new(), lanes: Vec::new(), fold, ..*self };
        let whole = rows >= total;
        for (k, run) in self.runs.iter().enumerate() {
            let (count, length) =
                if whole { (1, run.len()) } else { (per_run, length.min(run.len() / per_run)) };
            for i in 0..count {
                let free = run.len() - count * length;
                let start = i * length + if count > 1 { free * i / (count - 1) } else { 0 };
                let rows = run.start + start..run.start + start + length;
                if !whole {
                    let block = length.div_ceil(BLOCKS_OF_WINDOW).max(1);
                    for (j, fold) in data.fold[rows.clone()].iter_mut().enumerate() {
                        *fold = [FIT, CHOOSE, FIT, SCORE][(j / block + data.runs.len()) % 4] as u8;
                    }
                }
                data.runs.push(rows);
                data.starts_s.push(self.starts_s[k] + start as f64 * self.step_s);
                data.lanes.push(self.lanes[k].part(run.start, start..start + length));
            }
        }
        data.scale.slowest_hz = slowest_hz(&data.runs, data.step_s);
        data
    }

    /// What a run of a model is simulated along.
    pub fn course(&self, run: usize, model: &Model) -> Course<'_> {
        let (k, lane) = (HOLDS.iter().position(|h| *h == model.hold).unwrap_or(0), &self.lanes[run]);
        let bends = |term: &Term| term.effect.part == Part::DriveMemory || term.effect.is_limit();
        Course {
            signal: if model.terms.iter().any(bends) { lane.seen(k) } else { &lane.signals[k] },
            step_s: self.step_s,
            rows: self.runs[run].len(),
            start_s: self.starts_s[run],
            bound: self.bound,
            before: &lane.before[k],
            lead: &self.position[lane.lead.clone()],
        }
    }

    /// All drives of a run.
    pub fn inputs(&self, run: usize, hold: Hold) -> Vec<&dyn Input> {
        let (k, lane) = (HOLDS.iter().position(|h| *h == hold).unwrap_or(0), &self.lanes[run]);
        let further = lane.further.iter().map(|drive| &drive[k] as &dyn Input);
        std::iter::once(&lane.signals[k] as &dyn Input).chain(further).collect()
    }

    /// Number of rows of the wanted kinds.
    pub fn count(&self, folds: Folds) -> usize {
        self.runs.iter().flat_map(|run| &self.fold[run.clone()]).filter(|f| folds[**f as usize]).count()
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

/// Lowest frequency of which several periods are in the longest run.
fn slowest_hz(runs: &[Range<usize>], step_s: f64) -> f64 {
    let longest = runs.iter().map(|run| run.len()).max().unwrap_or(1);
    PERIODS / (longest.max(1) as f64 * step_s)
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
    let rate = (speed / rms).max(f64::MIN_POSITIVE);
    Scale { middle, stroke, speed, drive: largest, step_s, rate, slowest_hz: slowest_hz(runs, step_s) }
}
