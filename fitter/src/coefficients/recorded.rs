//! What an uncertainty budget needs to know of the calibration beside the fit itself.

use serde::{Deserialize, Serialize};

/// The reference as its data sheet or its certificate states it, in [`super::Units::statistics`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Its accuracy: the limits ±a of its error, or with `coverage_factor` an expanded uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// The coverage factor k of `accuracy`, where a certificate states it; none: `accuracy` are limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage_factor: Option<f64>,
    /// Standard deviation of one of its readings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeatability: Option<f64>,
}

/// What the recording says of uncertainty beside the statistics of the fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// The reference.
    #[serde(default)]
    pub reference: Reference,
    /// The smallest step between two readings, in [`super::Units::reading`]; 0 where all are alike.
    pub reading_step: f64,
    /// What the passes differ by; none of a single pass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pass_offset: Option<PassOffset>,
    /// How far readings that follow one another have their noise in common; none where that is not seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<Correlation>,
}

/// Noise that lasts from one row to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Correlation {
    /// First-order autocorrelation ρ, from row to row.
    pub neighbours: f64,
    /// By how much it makes the variance of what was fitted larger, on average; 1 where the fit allowed for it.
    pub of_fitted: f64,
}

/// An error that all readings of a pass share and the next pass does not: a drift, or a reference that was set up again.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PassOffset {
    /// Its standard deviation, beyond what the scatter inside the passes makes of their means; in
    /// [`super::Units::statistics`].
    pub standard_deviation: f64,
    /// Number of passes.
    pub passes: usize,
}

impl Recorded {
    /// What contradicts itself; none if it can be used.
    pub(super) fn contradiction(&self) -> Option<String> {
        let Reference { accuracy, coverage_factor, repeatability } = self.reference;
        let positive = [
            ("reference.accuracy", accuracy),
            ("reference.coverage_factor", coverage_factor),
            ("reference.repeatability", repeatability),
        ];
        let not_negative = [
            ("reading_step", Some(self.reading_step)),
            ("pass_offset.standard_deviation", self.pass_offset.map(|offset| offset.standard_deviation)),
        ];
        let wrong = |bad: fn(f64) -> bool, of: &[(&str, Option<f64>)]| {
            let found = of.iter().find_map(|(name, value)| Some((*name, (*value).filter(|v| bad(*v))?)));
            found.map(|(name, value)| format!("`recorded.{name}` is {value}"))
        };
        wrong(|v| !(v.is_finite() && v > 0.0), &positive)
            .or_else(|| wrong(|v| !(v.is_finite() && v >= 0.0), &not_negative))
            .or_else(|| {
                let Correlation { neighbours, of_fitted } = self.correlation?;
                let possible = (0.0..1.0).contains(&neighbours) && of_fitted.is_finite() && of_fitted > 0.0;
                (!possible).then(|| format!("`recorded.correlation` is {neighbours} and {of_fitted}"))
            })
            .or_else(|| {
                let passes = self.pass_offset.map_or(2, |offset| offset.passes);
                (passes < 2).then(|| format!("`recorded.pass_offset` is of {passes} passes"))
            })
    }
}

#[cfg(feature = "fit")]
impl Recorded {
    /// Of a recording; `residual` is what the model leaves of every row, in [`super::Units::statistics`].
    pub fn of(recording: &crate::Recording, reference: Reference, residual: &[f64]) -> Recorded {
        let readings: Vec<f64> = (0..recording.rows()).map(|row| recording.reading(row)).collect();
        Recorded {
            reference,
            reading_step: crate::statistics::readable(crate::faults::resolution(&readings)),
            pass_offset: PassOffset::of(&recording.pass, residual),
            correlation: None,
        }
    }
}

#[cfg(feature = "fit")]
impl PassOffset {
    /// The variance between passes by a one-way analysis of variance with random effects (Searle, Casella & McCulloch,
    /// Variance Components, 1992, 3.6).
    fn of(pass: &[i32], residual: &[f64]) -> Option<PassOffset> {
        let mut passes: std::collections::BTreeMap<i32, (f64, f64, f64)> = std::collections::BTreeMap::new();
        for (pass, residual) in pass.iter().zip(residual) {
            let (rows, sum, squares) = passes.entry(*pass).or_default();
            *rows += 1.0;
            *sum += residual;
            *squares += residual * residual;
        }
        let count = passes.len() as f64;
        let rows = residual.len() as f64;
        if passes.len() < 2 || rows <= count {
            return None;
        }
        let mean = residual.iter().sum::<f64>() / rows;
        let between: f64 = passes.values().map(|(n, sum, _)| n * (sum / n - mean).powi(2)).sum();
        let within: f64 = passes.values().map(|(n, sum, squares)| (squares - sum * sum / n).max(0.0)).sum();
        let rows_of_one = (rows - passes.values().map(|(n, ..)| n * n).sum::<f64>() / rows) / (count - 1.0);
        let variance = (between / (count - 1.0) - within / (rows - count)) / rows_of_one;
        let standard_deviation = crate::statistics::readable(variance.max(0.0).sqrt());
        Some(PassOffset { standard_deviation, passes: passes.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_passes_differ_by_is_beyond_their_scatter() {
        // Two passes of ±1 about ±3: means 6 apart, a variance of 18, of which the scatter explains 4/3/4.
        let pass = [1, 1, 1, 1, 2, 2, 2, 2];
        let residual = [4.0, 2.0, 4.0, 2.0, -4.0, -2.0, -4.0, -2.0];
        let found = PassOffset::of(&pass, &residual).unwrap();
        approx::assert_relative_eq!(found.standard_deviation, (18.0f64 - 1.0 / 3.0).sqrt(), epsilon = 1e-6);
        assert_eq!(found.passes, 2);
        // Passes that are nearer to each other than their scatter makes them.
        let alike = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        assert_eq!(PassOffset::of(&pass, &alike).unwrap().standard_deviation, 0.0);
        assert_eq!(PassOffset::of(&[1; 8], &residual), None);
    }

    #[test]
    fn numbers_that_cannot_be_are_named() {
        let good = Recorded {
            reference: Reference::default(),
            reading_step: 0.0,
            pass_offset: None,
            correlation: None,
        };
        assert_eq!(good.contradiction(), None);
        let accuracy = Reference { accuracy: Some(-1.0), ..Reference::default() };
        let bad = Recorded { reference: accuracy, ..good.clone() };
        assert_eq!(bad.contradiction().unwrap(), "`recorded.reference.accuracy` is -1");
        let one = PassOffset { standard_deviation: 0.1, passes: 1 };
        let bad = Recorded { pass_offset: Some(one), ..good };
        assert!(bad.contradiction().unwrap().contains("of 1 passes"));
        let correlation = Correlation { neighbours: 1.0, of_fitted: 2.0 };
        let bad = Recorded { pass_offset: None, correlation: Some(correlation), ..bad };
        assert_eq!(bad.contradiction().unwrap(), "`recorded.correlation` is 1 and 2");
    }
}
