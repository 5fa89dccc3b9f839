//! What counts as right, figure by figure.

mod breakdown;
mod coverage;
mod detection;
mod names;
mod outside;
mod worth;

use serde::Serialize;

use crate::answer::Answer;
use crate::curve::Curve;
use crate::fresh::Fresh;
use crate::statistics::{lower_limit, upper_limit};
use crate::truth::Truth;

pub use breakdown::Breakdown;
pub use coverage::{Cell, Covered};
pub use detection::FalseAlarms;
pub use names::Confusion;
pub use outside::OutsideRow;
pub use worth::{Harm, Worth};

/// One trial, unsealed.
pub struct Case {
    /// What was concealed.
    pub truth: Truth,
    /// What was said; none where the recording was refused.
    pub answer: Option<Answer>,
    /// What the answer is worth on a fresh recording.
    pub fresh: Option<Fresh>,
    /// What is said when the effect is left out of the catalogue, where that was asked.
    pub without: Option<Option<Answer>>,
    /// ρ of what the names that are given instead leave of the concealed physics, where it has no name: for what
    /// is outside the table, and for what is left out of it.
    pub left_by_names: [Option<f64>; 2],
    /// Whether a detector that is told the noise and the formulas finds something, where that was asked.
    pub benchmark: Option<bool>,
}

/// A trial, unsealed, whatever stood or moved in it.
pub(crate) trait Unsealed {
    /// What was said; none where the recording was refused.
    fn answer(&self) -> Option<&Answer>;

    /// The recording, what was concealed in it, and in which circumstances.
    fn described(&self) -> (String, Vec<String>, String);

    fn said(&self, right: impl Fn(&Answer) -> bool) -> bool {
        self.answer().is_some_and(right)
    }

    fn sentence(&self) -> String {
        self.answer().map_or_else(|| "refused".to_owned(), Answer::sentence)
    }
}

impl Unsealed for Case {
    fn answer(&self) -> Option<&Answer> {
        self.answer.as_ref()
    }

    fn described(&self) -> (String, Vec<String>, String) {
        let t = &self.truth;
        let effect = |e: &crate::truth::Concealed| {
            let near =
                e.imitation.as_ref().map_or(String::new(), |(id, left)| format!(", {id} leaves {left:.1}"));
            format!("{} (ρ {:.1}{near})", e.id, e.rho)
        };
        let circumstances = format!("{}, {}, {}", t.family, t.schedule, t.temperature);
        (t.recording.clone(), t.effects.iter().map(effect).collect(), circumstances)
    }
}

/// One line of the summary.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// What is measured.
    pub figure: String,
    /// What is wanted.
    pub wanted: String,
    /// What was measured.
    pub measured: String,
    /// Whether it is reached; none where nothing is wanted of it, or there was nothing to measure.
    pub passed: Option<bool>,
}

impl Figure {
    pub(crate) fn new(
        figure: impl Into<String>,
        wanted: impl Into<String>,
        measured: impl Into<String>,
        passed: Option<bool>,
    ) -> Self {
        Self { figure: figure.into(), wanted: wanted.into(), measured: measured.into(), passed }
    }

    /// A share without a wanted value.
    pub(crate) fn reported(figure: impl Into<String>, share: Share) -> Self {
        Self::noted(figure, share.to_string())
    }

    /// What was measured, without a wanted value.
    pub(crate) fn noted(figure: impl Into<String>, measured: String) -> Self {
        Self::new(figure, "–", measured, None)
    }

    /// A share that must reach a least value.
    pub(crate) fn at_least(figure: impl Into<String>, least: f64, share: Share) -> Self {
        let passed = share.value().map(|value| value >= least);
        Self::new(figure, format!("≥ {} %", 100.0 * least), share.to_string(), passed)
    }

    /// A share that must not exceed a largest value.
    pub(crate) fn at_most(figure: impl Into<String>, most: f64, share: Share) -> Self {
        let passed = share.value().map(|value| value <= most);
        Self::new(figure, format!("≤ {} %", 100.0 * most), share.to_string(), passed)
    }
}

/// So many of so many.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Share {
    /// How many.
    pub hits: u64,
    /// Of how many.
    pub of: u64,
}

impl Share {
    pub(crate) fn count(&mut self, hit: bool) {
        self.of += 1;
        self.hits += u64::from(hit);
    }

    /// The share; none of none.
    pub fn value(self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(value) = self.value() else { return write!(f, "none") };
        let limit = |l: f64| 100.0 * l;
        let (low, high) = (lower_limit(self.hits, self.of, 0.975), upper_limit(self.hits, self.of, 0.975));
        write!(f, "{:.2} % ({}/{}; {:.1}–{:.1})", 100.0 * value, self.hits, self.of, limit(low), limit(high))
    }
}

/// One answer that was not right.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Miss {
    /// Which figure it counts against.
    pub figure: &'static str,
    /// The recording.
    pub recording: String,
    /// What was concealed.
    pub concealed: String,
    /// What was said.
    pub said: String,
    /// Circumstances: noise, schedule, temperature.
    pub circumstances: String,
}

/// Figures, and the answers that were not right, as they are collected.
#[derive(Default)]
pub(crate) struct Sheet {
    pub figures: Vec<Figure>,
    pub misses: Vec<Miss>,
}

impl Sheet {
    pub fn miss(&mut self, figure: &'static str, case: &impl Unsealed, said: String) {
        let (recording, effects, circumstances) = case.described();
        let concealed = if effects.is_empty() { "nothing".to_owned() } else { effects.join(" + ") };
        self.misses.push(Miss { figure, recording, concealed, said, circumstances });
    }

    /// The share of the cases that are right; the others become misses.
    pub fn share<'a, C: Unsealed + 'a>(
        &mut self,
        miss: &'static str,
        cases: impl Iterator<Item = &'a C>,
        right: impl Fn(&'a C, &Answer) -> bool,
    ) -> Share {
        let mut share = Share::default();
        for case in cases {
            let hit = case.said(|answer| right(case, answer));
            share.count(hit);
            if !hit {
                self.miss(miss, case, case.sentence());
            }
        }
        share
    }

    /// A figure: the share of the cases that are right must reach a least value. The others become misses.
    pub fn least<'a, C: Unsealed + 'a>(
        &mut self,
        (figure, least): (impl Into<String>, f64),
        miss: &'static str,
        cases: impl Iterator<Item = &'a C>,
        right: impl Fn(&'a C, &Answer) -> bool,
    ) {
        let share = self.share(miss, cases, right);
        self.figures.push(Figure::at_least(figure, least, share));
    }

    /// A figure without a wanted value: the share of the cases that are right.
    pub fn tell<'a, C: Unsealed + 'a>(
        &mut self,
        figure: impl Into<String>,
        cases: impl Iterator<Item = &'a C>,
        right: impl Fn(&'a C, &Answer) -> bool,
    ) {
        self.figures.push(Figure::reported(figure, count(cases, right)));
    }
}

/// The share of the cases that are right.
fn count<'a, C: Unsealed + 'a>(
    cases: impl Iterator<Item = &'a C>,
    right: impl Fn(&'a C, &Answer) -> bool,
) -> Share {
    let mut share = Share::default();
    cases.for_each(|case| share.count(case.said(|answer| right(case, answer))));
    share
}

/// Everything that was measured.
#[derive(Serialize)]
pub struct Score {
    /// The summary.
    pub figures: Vec<Figure>,
    /// False alarms by noise family.
    pub false_alarms: Vec<FalseAlarms>,
    /// Detection against strength.
    pub curve: Option<Curve>,
    /// The same trials seen by a detector that is told the noise and the formulas.
    pub benchmark: Option<Curve>,
    /// Names given to single effects of ρ ≥ 8.
    pub confusion: Confusion,
    /// Answers to physics outside the table.
    pub outside: Vec<OutsideRow>,
    /// Answers with the effect left out of the catalogue.
    pub without: Vec<OutsideRow>,
    /// Coverage by effect and parameter.
    pub coverage: Vec<Covered>,
    /// Coverage by effect, parameter and schedule, of effects that are found for certain.
    pub cells: Vec<Cell>,
    /// Worth on fresh recordings.
    pub worth: Worth,
    /// Devices that were recorded twice: the second beside the base alone.
    pub harm: Harm,
    /// The main shares by circumstance.
    pub breakdown: Vec<Breakdown>,
    /// Every answer that was not right.
    pub misses: Vec<Miss>,
}

/// Scores the cases.
pub fn score(cases: &[Case]) -> Score {
    let mut sheet = Sheet::default();
    let (false_alarms, curve, benchmark) = detection::figures(cases, &mut sheet);
    let confusion = names::figures(cases, &mut sheet);
    let (outside, without) = outside::figures(cases, &mut sheet);
    let coverage = coverage::figures(cases, &mut sheet);
    let cells = coverage::by_schedule(cases, &mut sheet);
    let worth = worth::figures(cases, &mut sheet);
    let harm = worth::harm(cases, &mut sheet);
    let breakdown = breakdown::breakdown(cases);
    let Sheet { figures, misses } = sheet;
    Score {
        figures,
        false_alarms,
        curve,
        benchmark,
        confusion,
        outside,
        without,
        coverage,
        cells,
        worth,
        harm,
        breakdown,
        misses,
    }
}

/// Whether every figure that has a wanted value and could be measured is reached.
pub fn reached(figures: &[Figure]) -> bool {
    figures.iter().all(|f| f.passed != Some(false))
}

#[cfg(test)]
pub(crate) mod tests;
