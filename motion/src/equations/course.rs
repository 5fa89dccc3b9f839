//! What a run of a plant in equations goes along, and why it may end early.

use super::input::Input;
use super::observer::Observer;

/// Most steps from row to row: what settles within a hundredth of a row cannot be told from a wall.
pub const MOST_SUBSTEPS: usize = 64;

/// What a run goes along.
pub struct Course<'a> {
    /// The inputs.
    pub signals: &'a [&'a dyn Input],
    /// Time from row to row, s.
    pub sample_s: f64,
    /// Number of rows.
    pub rows: usize,
    /// Time at the first row, s.
    pub start_s: f64,
    /// Steps of the classical rule from one row to the next where nothing is faster, or what is as accurate with less work.
    pub substeps: usize,
    /// What keeps the run beside a recording, if anything: without it the run is free.
    pub observer: Option<Observer<'a>>,
}

/// A run that ended early.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the state `{state}` {}, {t_s:.4} s after the first row: {}", self.how(), self.why())]
pub struct Stopped {
    /// The state that has no value any more, or one beyond all bounds.
    pub state: String,
    /// When, in s since the first row.
    pub t_s: f64,
    /// Before which row.
    pub row: usize,
    /// Whether it changes too fast to be followed.
    pub stiff: bool,
}

impl Stopped {
    fn how(&self) -> &'static str {
        if self.stiff { "changes too fast to be followed" } else { "has no value, or one beyond all bounds" }
    }

    fn why(&self) -> String {
        match self.stiff {
            true => format!(
                "the equations are stiff with these numbers, with more than {MOST_SUBSTEPS} steps of the integration from row to \
                 row; give a factor less range, or leave out what settles so fast"
            ),
            false => "the equations diverge with these numbers, or take the root or the logarithm of what is negative; check \
                      signs, units and ranges"
                .into(),
        }
    }
}

fitter::errors!(plain Stopped);
