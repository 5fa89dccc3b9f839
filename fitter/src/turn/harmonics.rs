//! The harmonics of the turn: their number by cross-validation, their coefficients by least squares.

use std::f64::consts::{SQRT_2, TAU};

use super::Unwound;
use super::arc::hull;
use super::beside::{Beside, Kind};
use super::direction::Motion;
use super::significance::Tested;
use super::solve::{Columns, Solution};
use super::travelled::{middle_of_first_turn, travelled_about};
use crate::fit::{FitError, Options, order_selection};
use crate::mirror::Mirror;
use crate::order::{Candidates, OrderSelection, Scores, select};
use crate::points::Points;
use crate::recording::{Readings, Recording};

/// Most harmonics that are tried.
pub(crate) const MAX_HARMONICS: usize = 32;
/// Most folds of passes, and most cells of folds and points.
const MOST_FOLDS: usize = 10;
const MOST_CELLS: usize = 2048;

/// The problem of one recording.
pub(crate) struct Harmonics<'a> {
    pub(super) recording: &'a Recording,
    pub(super) mirror: &'a Mirror,
    pub(super) options: &'a Options,
    pub(super) unwound: Unwound,
    pub(super) turn: f64,
    pub(super) unit: &'a str,
    pub(super) motion: Motion,
    pub(super) points: Points,
    /// Cosine and sine of the reference's phase, row by row.
    pub(super) phase: Vec<(f64, f64)>,
    /// The columns between the constant and the harmonics.
    pub(super) beside: Vec<Beside>,
}

/// A number of harmonics, how it was chosen, and the solution.
pub(super) struct Choice {
    pub harmonics: usize,
    pub selection: Option<OrderSelection>,
    pub solution: Solution,
}

impl<'a> Harmonics<'a> {
    pub fn of(
        recording: &'a Recording,
        mirror: &'a Mirror,
        options: &'a Options,
        unwound: Unwound,
        turn: f64,
    ) -> Harmonics<'a> {
        let motion = Motion::of(recording, &unwound);
        let points = Points::around(recording, &unwound.reading, turn);
        let phase = (unwound.reference.iter())
            .map(|reference| {
                let turns = reference / turn;
                let angle = TAU * (turns - turns.floor());
                (libm::cos(angle), libm::sin(angle))
            })
            .collect();
        let unit = mirror.sensor.error_unit();
        let velocity = motion.velocity.clone().map(|velocity| Beside::of(Kind::Velocity, velocity));
        let direction = (motion.both.then(|| Beside::direction(&recording.direction)))
            .filter(|direction| velocity.as_ref().is_none_or(|velocity| !direction.like(velocity)));
        let beside = direction.into_iter().chain(velocity).collect();
        Harmonics { recording, mirror, options, unwound, turn, unit, motion, points, phase, beside }
    }

    /// Number of columns before the harmonics, apart from the constant.
    fn beside(&self) -> usize {
        self.beside.len()
    }

    /// The column of this kind among those beside the harmonics.
    pub(super) fn place(&self, kind: Kind) -> Option<usize> {
        self.beside.iter().position(|beside| beside.kind == kind)
    }

    /// Takes the slope over the turn among the columns; where it is counted from.
    pub(super) fn add_slope(&mut self) -> Option<f64> {
        let Readings::Direct { measured, .. } = &self.recording.readings else { return None };
        let middle = middle_of_first_turn(&super::travelled::travelled(measured, self.turn), self.turn);
        let values = travelled_about(measured, self.turn, middle).iter().map(|m| m - middle).collect();
        self.beside.push(Beside::of(Kind::Slope, values));
        Some(middle)
    }

    /// The rate of the reading in place of the reference's: dm/dt = (1 + P′(r))·dr/dt, without the reading's noise, which
    /// is in its error as well.
    pub(super) fn set_rate_of_reading(&mut self, solution: &Solution) {
        let Some(place) = self.place(Kind::Velocity) else { return };
        let Some(velocity) = &self.motion.velocity else { return };
        let waves = &solution.c[1 + self.beside.len()..];
        let scale = SQRT_2 / (self.recording.rows() as f64).sqrt() * TAU / self.turn;
        let values = (velocity.iter().zip(&self.phase))
            .map(|(velocity, (cosine, sine))| {
                let (mut c, mut s, mut slope) = (*cosine, *sine, 0.0);
                for (k, pair) in waves.chunks_exact(2).enumerate() {
                    slope += (k as f64 + 1.0) * (pair[1] * c - pair[0] * s);
                    (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
                }
                velocity * (1.0 + scale * slope)
            })
            .collect();
        self.beside[place] = Beside::of(Kind::Velocity, values);
    }

    /// Columns of length 1 about: constant, those beside, then cos and sin of each harmonic.
    fn fill(&self, row: usize, values: &mut [f64]) {
        let scale = 1.0 / (self.recording.rows() as f64).sqrt();
        values[0] = scale;
        let next = 1 + self.beside.len();
        for (value, beside) in values[1..next].iter_mut().zip(&self.beside) {
            *value = scale * beside.values[row] / beside.length;
        }
        let (cosine, sine) = self.phase[row];
        let (mut c, mut s) = (cosine, sine);
        for pair in values[next..].chunks_exact_mut(2) {
            (pair[0], pair[1]) = (SQRT_2 * scale * c, SQRT_2 * scale * s);
            (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
        }
    }

    /// The most harmonics that the gaps between the readings allow to tell.
    fn most(&self) -> usize {
        let points = self.points.count();
        let gap = self.turn - hull(&self.points.reading, self.turn).length;
        let by_gap = (0.5 * self.turn / gap.max(1e-9 * self.turn)) as usize;
        let by_points = (0.7 * points as f64) as usize;
        MAX_HARMONICS.min(by_gap).min(by_points.saturating_sub(self.beside() + 2) / 2)
    }

    fn scores(&self) -> Option<Scores> {
        let (first, points) = (self.beside(), self.points.count());
        let last = first + 2 * self.most();
        let passes = self.recording.passes();
        let folds = passes.len().min(MOST_FOLDS).min((MOST_CELLS / points).max(1));
        let cell = |row: usize| {
            let rank = passes.partition_point(|pass| *pass < self.recording.pass[row]);
            (rank * folds / passes.len(), self.points.of_row[row] as usize)
        };
        let columns = self.columns(self.most());
        let grams = columns.grams(folds, points, &self.unwound.error, &cell);
        let distinct = if self.points.single_angles { vec![1; points] } else { self.points.rows.clone() };
        let candidates = Candidates { first, last, step: 2 };
        select(&grams, &vec![1.0; points], &distinct, candidates, &self.options.splits)
    }

    pub(super) fn columns(&self, harmonics: usize) -> Columns<'_> {
        let count = 1 + self.beside() + 2 * harmonics;
        Columns { count, rows: self.recording.rows(), fill: Box::new(|row, values| self.fill(row, values)) }
    }

    /// Both curves over the number of harmonics, which stands in the place of the order.
    fn selection(&self, scores: &Scores, chosen: usize) -> OrderSelection {
        let (options, points, sensor) = (self.options, &self.points, &self.mirror.sensor);
        let harmonics = |order: usize| (order - self.beside()) / 2;
        let mut selection =
            order_selection(scores, chosen, options.harmonics.is_some(), options, points, sensor);
        selection.smallest_testing_error = harmonics(selection.smallest_testing_error);
        selection.curve.iter_mut().for_each(|score| score.order = harmonics(score.order));
        selection
    }

    /// Chooses the number of harmonics alone.
    ///
    /// # Errors
    /// [`FitError::TooFewToHoldOut`].
    pub fn choose(mut self) -> Result<OrderSelection, FitError> {
        if self.scores().is_none() {
            self.leave_out_direction();
        }
        let scores = self.scores().ok_or_else(|| self.too_few_to_hold_out())?;
        Ok(self.selection(&scores, (scores.chosen - self.beside()) / 2))
    }

    /// Leaves the direction to the speed, where both are fitted: they may differ only where the axis stood, and are one
    /// wherever that place is held out. Whether there was something to leave out.
    pub(super) fn leave_out_direction(&mut self) -> bool {
        let place = self.place(Kind::Direction).filter(|_| self.place(Kind::Velocity).is_some());
        place.map(|place| self.beside.remove(place)).is_some()
    }

    /// Chooses the number of harmonics, unless it is given, and solves for them.
    ///
    /// # Errors
    /// [`FitError`]: too few angles to choose with, or to determine the number that was given.
    pub(super) fn chosen(&self) -> Result<Choice, FitError> {
        let scores = self.scores();
        let harmonics = match (self.options.harmonics, &scores) {
            (Some(given), _) => given,
            (None, Some(scores)) => (scores.chosen - self.beside()) / 2,
            (None, None) => return Err(self.too_few_to_hold_out()),
        };
        let solution = self.solved(harmonics)?;
        let selection = scores.map(|scores| self.selection(&scores, harmonics));
        Ok(Choice { harmonics, selection, solution })
    }

    /// The solution with a number of harmonics.
    ///
    /// # Errors
    /// [`FitError::TooFewForHarmonics`].
    pub(super) fn solved(&self, harmonics: usize) -> Result<Solution, FitError> {
        let solution = self.columns(harmonics).solve(&self.unwound.error);
        solution.filter(|_| harmonics <= self.most()).ok_or_else(|| FitError::TooFewForHarmonics {
            file: self.recording.file.clone(),
            points: self.points.count(),
            harmonics,
            most: self.most(),
        })
    }

    /// Tests one of the columns beside the harmonics.
    pub(super) fn tested(&self, place: usize, solution: &Solution) -> Option<Tested> {
        let columns = self.columns((solution.c.len() - 1 - self.beside()) / 2);
        let (others, column) = columns.without_column(1 + place);
        let left = others.solve(&column)?.residual;
        let rows = self.recording.rows() as f64;
        // In the column's own unit.
        let scale = rows.sqrt() * self.beside[place].length;
        let left: Vec<f64> = left.iter().map(|x| scale * x).collect();
        Tested::of(self.coefficient(place, solution), &left, &solution.residual)
    }

    /// The coefficient of one of the columns beside the harmonics, in its own unit.
    pub(super) fn coefficient(&self, place: usize, solution: &Solution) -> f64 {
        solution.c[1 + place] / ((self.recording.rows() as f64).sqrt() * self.beside[place].length)
    }

    fn too_few_to_hold_out(&self) -> FitError {
        FitError::TooFewToHoldOut {
            file: self.recording.file.clone(),
            points: self.points.count(),
            grouping: self.points.grouping.name(),
        }
    }
}
