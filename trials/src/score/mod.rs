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
pub use outside::{OutsideRow, WithoutRow};
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

impl Case {
    fn said(&self, right: impl Fn(&Answer) -> bool) -> bool {
        self.answer.as_ref().is_some_and(right)
    }

    fn sentence(&self) -> String {
        self.answer.as_ref().map_or_else(|| "refused".to_owned(), Answer::sentence)
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
    /// A share that must reach a least value.
    pub(crate) fn at_least(figure: &str, least: f64, share: Share) -> Self {
        Self {
            figure: figure.to_owned(),
            wanted: format!("≥ {} %", 100.0 * least),
            measured: share.to_string(),
            passed: share.value().map(|value| value >= least),
        }
    }

    /// A share that is told, without a wanted value.
    pub(crate) fn reported(figure: &str, share: Share) -> Self {
        Self {
            figure: figure.to_owned(), wanted: "–".to_owned(), measured: share.to_string(), passed: None
        }
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

/// Collects the misses of all figures.
#[derive(Default)]
struct Misses(Vec<Miss>);

impl Misses {
    fn add(&mut self, figure: &'static str, case: &Case, said: String) {
        let t = &case.truth;
        let effect = |e: &crate::truth::Concealed| {
            let near =
                e.imitation.as_ref().map_or(String::new(), |(id, left)| format!(", {id} leaves {left:.1}"));
            format!("{} (ρ {:.1}{near})", e.id, e.rho)
        };
        let concealed = match t.effects.len() {
            0 => "nothing".to_owned(),
            _ => t.effects.iter().map(effect).collect::<Vec<_>>().join(" + "),
        };
        self.0.push(Miss {
            figure,
            recording: t.recording.clone(),
            concealed,
            said,
            circumstances: format!("{}, {}, {}", t.family, t.schedule, t.temperature),
        });
    }

    /// The share of the cases that are right; the others become misses.
    fn share<'a>(
        &mut self,
        figure: &'static str,
        cases: impl Iterator<Item = &'a Case>,
        right: impl Fn(&'a Case, &Answer) -> bool,
    ) -> Share {
        let mut share = Share::default();
        for case in cases {
            let hit = case.said(|answer| right(case, answer));
            share.count(hit);
            if !hit {
                self.add(figure, case, case.sentence());
            }
        }
        share
    }
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
    pub without: Vec<WithoutRow>,
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
    let mut misses = Misses::default();
    let mut figures = Vec::new();
    let (false_alarms, curve, benchmark) = detection::figures(cases, &mut figures, &mut misses);
    let confusion = names::figures(cases, &mut figures, &mut misses);
    let (outside, without) = outside::figures(cases, &mut figures, &mut misses);
    let coverage = coverage::figures(cases, &mut figures);
    let cells = coverage::by_schedule(cases, &mut figures, &mut misses);
    let worth = worth::figures(cases, &mut figures, &mut misses);
    let harm = worth::harm(cases, &mut figures, &mut misses);
    let misses = misses.0;
    let breakdown = breakdown::breakdown(cases);
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
