//! An uncertainty budget after the GUM (JCGM 100:2008) of one corrected reading.
//!
//! The measurand is the error of one corrected reading of this device, against the truth on the scale of the reference, in
//! the conditions of the recording: what the 95 % are a statement of. A [`Component`] is one row, [`combine`] makes the
//! combined and the expanded uncertainty of several, [`type_a`] reads out of a coefficients file what the recording
//! showed, and [`mod@reference`] what was stated. A [`Budget`] is the table over the range.

mod combine;
mod component;
pub mod reference;
pub mod type_a;

use serde::{Deserialize, Serialize};

pub use combine::{COVERAGE, Combined, combine};
pub use component::{Component, Distribution, Evaluation};

/// The budget of a corrected reading over its range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// What the uncertainty is of.
    pub measurand: String,
    /// The probability that `expanded` stands for.
    pub coverage: f64,
    /// The model of the measurement, and how its uncertainties are combined.
    pub formula: String,
    /// Unit of contributions and of the combined and expanded uncertainties.
    pub unit: String,
    /// What `at` is.
    pub place: String,
    /// Unit of `at`.
    pub place_unit: String,
    /// The place of `components`: where the expanded uncertainty is largest.
    pub at: f64,
    /// Every contribution there.
    pub components: Vec<Component>,
    /// The table over the range, by ascending place.
    pub range: Vec<Place>,
    /// What the uncertainty does not contain.
    pub not_included: Vec<String>,
    /// What the file does not say and the budget therefore lacks; empty of a whole budget.
    pub missing: Vec<String>,
}

/// The uncertainty at one place of the range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The place: see [`Budget::place`].
    pub at: f64,
    /// The corrected reading there, in the budget's unit.
    pub result: f64,
    /// |cᵢ|·u(xᵢ) of every component, in the order of [`Budget::components`].
    pub contributions: Vec<f64>,
    /// See [`Combined`].
    #[serde(flatten)]
    pub combined: Combined,
}

/// What a place of the table is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct At {
    /// The place.
    pub place: f64,
    /// The corrected reading there, in the budget's unit.
    pub result: f64,
    /// What contributes there.
    pub components: Vec<Component>,
}

impl Budget {
    /// Fills the table: every place with its components, the same ones in the same order at each. What contributes nothing
    /// anywhere is left out. None of no places.
    pub fn over(self, mut places: Vec<At>) -> Option<Budget> {
        let count = places.first()?.components.len();
        let keep: Vec<bool> =
            (0..count).map(|k| places.iter().any(|at| at.components[k].contribution > 0.0)).collect();
        for at in &mut places {
            let mut kept = keep.iter();
            at.components.retain(|_| kept.next().is_some_and(|keep| *keep));
        }
        let range: Vec<Place> = (places.iter())
            .map(|at| Place {
                at: rounded(at.place),
                result: rounded(at.result),
                contributions: at.components.iter().map(|one| one.contribution).collect(),
                combined: combine(&at.components),
            })
            .collect();
        let expanded = |k: &usize| range[*k].combined.expanded;
        let largest = (0..range.len()).max_by(|a, b| expanded(a).total_cmp(&expanded(b)))?;
        let components = places.swap_remove(largest).components;
        Some(Budget { at: range[largest].at, components, range, ..self })
    }

    /// The smallest and the largest expanded uncertainty over the range.
    pub fn expanded(&self) -> [f64; 2] {
        let all = self.range.iter().map(|place| place.combined.expanded);
        all.fold([f64::INFINITY, 0.0], |[low, high], u| [low.min(u), high.max(u)])
    }

    /// The expanded uncertainty at a place, on the straight line between its neighbours in the table.
    pub fn expanded_at(&self, at: f64) -> f64 {
        let upper = self.range.partition_point(|place| place.at < at).clamp(1, self.range.len().max(2) - 1);
        match (self.range.get(upper - 1), self.range.get(upper)) {
            (Some(a), Some(b)) => {
                let part = ((at - a.at) / (b.at - a.at)).clamp(0.0, 1.0);
                a.combined.expanded + part * (b.combined.expanded - a.combined.expanded)
            }
            (Some(only), None) => only.combined.expanded,
            _ => f64::NAN,
        }
    }
}

/// Six significant digits: more than an uncertainty has, and few enough that the last bit of a library's logarithm does not
/// change them.
fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    format!("{value:.5e}").parse().unwrap_or(value)
}
