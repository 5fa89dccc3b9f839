//! The coefficients file, `coefficients.json`: what `arcsmith fit` writes, `apply` and `generate` read.
//!
//! Versioned; numbers survive a round trip exactly; a newer or damaged file is refused in a sentence.

mod diagnosed;
mod file;
mod joint;
mod recorded;
mod selection;
mod statistics;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error_model::{ErrorModel, Sensor};
use crate::message::Message;
use crate::recording::Recording;
use crate::terms::Term;
use crate::turn::Turn;

pub use file::{CoefficientsError, parse, read, read_with_text};
pub use recorded::{Correlation, PassOffset, Recorded, Reference};
pub use selection::{OrderScore, OrderSelection};
pub use statistics::{PointStatistics, Scatter, Spread, Statistics};

/// The whole file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// Version of the schema, from [`VERSION`] to [`VERSION_RECORDED`] when written by this program.
    pub version: u32,
    /// Program and version that wrote the file.
    pub tool: String,
    /// The command that wrote the file.
    pub command: String,
    /// The recording that was fitted.
    pub recording: Provenance,
    /// The sensor and its geometry.
    pub sensor: Sensor,
    /// Units of what stands below.
    pub units: Units,
    /// The range of readings that the recording covers, inside which the polynomial holds.
    pub valid_range: ValidRange,
    /// The polynomial of the error model.
    pub base: Base,
    /// How the polynomial was identified, and how well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identification: Option<Identification>,
    /// How the order was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_selection: Option<OrderSelection>,
    /// Residual statistics before and after.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub statistics: Option<Statistics>,
    /// What further effects add to the error of the base model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<Term>,
    /// Covariance of [`Base::coefficients`] and, after them, of the coefficients of all `terms` in their order, row by
    /// row: of what was fitted jointly. Empty where it is not known. See [`Coefficients::covariance_of_all`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joint_covariance: Vec<Vec<f64>>,
    /// What the recording covers of every observable that a term reads beside the reading: its smallest and largest
    /// value. A term is not known beyond.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub observed: BTreeMap<String, [f64; 2]>,
    /// Of a sensor that turns round and round: the turn, its harmonics, the directions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn: Option<Turn>,
    /// What an uncertainty budget needs of the recording and its reference; none in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recorded: Option<Recorded>,
    /// What the diagnosis that wrote the file said; none in a file of `fit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Diagnosed>,
    /// SHA-256 of all the rest as [`Coefficients::to_json`] writes it, in hexadecimal: see
    /// [`Coefficients::to_sealed_json`]. Reading checks it and takes it out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}

/// What a diagnosis said of the recording and of the model in the file. Figures are root mean squares of single
/// readings, in [`Units::statistics`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Diagnosed {
    /// `consistent`, `explained`, `described`, `partly_explained` or `unexplained`.
    pub verdict: String,
    /// What the base model alone leaves: on held-out rows where any were held out, else on the fitted ones.
    pub before_rms: f64,
    /// What the model in this file leaves on the same rows.
    pub after_rms: f64,
    /// The noise floor.
    pub noise_floor: f64,
}

/// Always in [`Coefficients::schema`].
pub const SCHEMA: &str = "arcsmith-coefficients";

/// Version of the schema of a file without [`Coefficients::turn`].
pub const VERSION: u32 = 1;

/// Version of the schema of a file with it.
pub const VERSION_TURN: u32 = 2;

/// Version of the schema of a file with a term that is an expression.
pub const VERSION_EXPRESSION: u32 = 3;

/// Version of the schema of a file with [`Coefficients::recorded`], and the newest that this program reads.
pub const VERSION_RECORDED: u32 = 4;

/// Where the coefficients come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// File name without its folder.
    pub file: String,
    /// SHA-256 of the bytes of the file, in hexadecimal.
    pub sha256: String,
    /// Number of readings.
    pub rows: usize,
    /// Number of passes.
    pub passes: usize,
}

impl Provenance {
    /// Of a recording.
    pub fn of(recording: &Recording) -> Provenance {
        Provenance {
            file: recording.file.clone(),
            sha256: recording.sha256.clone(),
            rows: recording.rows(),
            passes: recording.passes().len(),
        }
    }
}

/// Units, spelled out for whoever reads the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Of the reading: `mm`, or the direct sensor's.
    pub reading: String,
    /// Of what the base model returns: `rad`, or the direct sensor's.
    pub error: String,
    /// Of statistics and terms: `arcsec`, or the direct sensor's.
    pub statistics: String,
}

/// The range of readings in which a model holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValidRange {
    /// `s_mm` for an eddy-current pair, `measured` for a direct sensor.
    pub variable: String,
    /// Smallest reading, inclusive.
    pub from: f64,
    /// Largest reading, inclusive.
    pub to: f64,
}

/// How far beyond the recorded range a settled end may land, as a part of the range.
const SETTLING: f64 = 0.001;

impl ValidRange {
    /// Whether the model holds at this reading: inside the range, or beyond its ends by so little that the same
    /// commanded end lands there another time. A closed loop settles within its noise, not on a number.
    pub fn contains(&self, reading: f64) -> bool {
        let settling = SETTLING * (self.to - self.from);
        self.from - settling <= reading && reading <= self.to + settling
    }

    /// A reading of a sensor that turns, on the turn nearest to the range's middle, and how many turns were taken off:
    /// 359.9 and -0.1 degrees are the same place.
    pub fn on_its_turn(&self, reading: f64, turn: f64) -> (f64, f64) {
        let turns = ((reading - 0.5 * (self.from + self.to)) / turn).round();
        if self.contains(reading) { (reading, 0.0) } else { (reading - turns * turn, turns) }
    }
}

/// The polynomial of Eq. 5 as identified (Eq. 11).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// The order n.
    pub order: usize,
    /// The reading about which the polynomial is written; 0 for an eddy-current pair.
    pub centre: f64,
    /// a₀, a₁ − Δd/d, a₂ … aₙ: see [`ErrorModel::coefficients`].
    pub coefficients: Vec<f64>,
    /// The polynomial's straight part, whose slope goes on outside the valid range.
    pub extrapolation: Line,
}

/// A straight line about [`Base::centre`]: as [`Base::extrapolation`] the least-squares line through the polynomial over the
/// valid range. Pair: of Δs in millimetres; direct: of the error in the sensor's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Value at the centre.
    pub constant: f64,
    /// Slope.
    pub slope: f64,
}

/// How the polynomial was identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identification {
    /// `qr` or `trust-region`.
    pub solver: String,
    /// `rows`, `rows weighted by the scatter between passes`, or `averages over passes (Eq. 7)`.
    pub fitted: String,
    /// The reference's reading at calculated angle 0; none for a direct sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero: Option<Zero>,
    /// The parameters with their intervals.
    pub parameters: Vec<Parameter>,
    /// Covariance of [`Base::coefficients`], row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Standard deviation of one residual, in [`Units::statistics`].
    pub residual_standard_deviation: f64,
    /// Degrees of freedom of the intervals.
    pub degrees_of_freedom: usize,
    /// Δd as measured elsewhere; none where it was not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe_distance_error_mm: Option<f64>,
    /// Combinations of parameters that no recording determines.
    pub unidentifiable: Vec<Unidentifiable>,
}

/// α₀ of Eq. 7.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zero {
    /// α₀ in arcseconds.
    pub alpha0_arcsec: f64,
    /// Its standard error in arcseconds, from the readings that it is the mean of; none for a single one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error_arcsec: Option<f64>,
    /// How it was got.
    pub from: String,
}

/// One parameter of Eq. 6.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// `a0`, `a1 - dd/d`, `a2` …; `a1` and `dd` where Δd was given.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Standard error; none where no freedom is left to tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
    /// 95 % interval (Student's t).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
}

/// A direction in the parameters along which no prediction changes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unidentifiable {
    /// In words.
    pub statement: String,
    /// How far each parameter moves along the direction; those left out do not move.
    pub direction: Vec<Movement>,
    /// Smallest singular value of the Jacobian over its largest.
    pub relative_singular_value: f64,
}

impl Unidentifiable {
    /// The statement, with the value that settles it where it is measured otherwise.
    pub fn message(&self) -> Message {
        Message::of(&self.statement).by("probe_distance_error")
    }
}

/// See [`Unidentifiable::direction`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Movement {
    /// The parameter.
    pub parameter: String,
    /// Its change, in its unit.
    pub change: f64,
}

impl Coefficients {
    /// The base error model, without the terms of further effects.
    pub fn error_model(&self) -> ErrorModel {
        ErrorModel {
            sensor: self.sensor.clone(),
            centre: self.base.centre,
            coefficients: self.base.coefficients.clone(),
        }
    }

    /// A file for a model that was not fitted here: identified elsewhere, or invented for a test.
    /// `from..=to` is the valid range of readings.
    pub fn of_model(model: &ErrorModel, from: f64, to: f64, command: &str) -> Coefficients {
        Coefficients {
            schema: SCHEMA.to_string(),
            version: VERSION,
            tool: format!("fitter {}", env!("CARGO_PKG_VERSION")),
            command: command.to_string(),
            recording: Provenance { file: String::new(), sha256: String::new(), rows: 0, passes: 0 },
            sensor: model.sensor.clone(),
            units: Units {
                reading: model.sensor.reading_unit().to_string(),
                error: match &model.sensor {
                    Sensor::EddyCurrentPair { .. } => "rad".to_string(),
                    Sensor::Direct { unit, .. } => unit.clone(),
                },
                statistics: model.sensor.error_unit().to_string(),
            },
            valid_range: ValidRange { variable: model.sensor.reading_name().to_string(), from, to },
            base: Base {
                order: model.coefficients.len().saturating_sub(1),
                centre: model.centre,
                extrapolation: extrapolation(&model.coefficients, model.centre, from, to),
                coefficients: model.coefficients.clone(),
            },
            identification: None,
            order_selection: None,
            statistics: None,
            terms: Vec::new(),
            joint_covariance: Vec::new(),
            observed: BTreeMap::new(),
            turn: None,
            recorded: None,
            diagnosis: None,
            sha256: None,
        }
    }

    /// Puts what a budget needs into the file, which is of the version that has it from then on.
    pub fn set_recorded(&mut self, recorded: Recorded) {
        self.version = VERSION_RECORDED;
        self.recorded = Some(recorded);
    }

    /// Whether the file is of a sensor that turns and holds on the whole turn.
    pub fn whole_turn(&self) -> bool {
        self.turn.as_ref().is_some_and(|turn| turn.whole)
    }

    /// Puts another polynomial in the place of the base, its order and extrapolation with it.
    pub fn set_base(&mut self, coefficients: Vec<f64>) {
        let (from, to) = (self.valid_range.from, self.valid_range.to);
        self.base.order = coefficients.len().saturating_sub(1);
        self.base.extrapolation = extrapolation(&coefficients, self.base.centre, from, to);
        self.base.coefficients = coefficients;
        self.joint_covariance.clear();
    }

    /// The line that goes on from the end of the valid range nearest to a reading, with the slope of the extrapolation: the
    /// correction has no step there.
    pub fn line_beyond(&self, reading: f64) -> Line {
        let base = &self.base;
        let end = reading.clamp(self.valid_range.from, self.valid_range.to) - base.centre;
        let value = base.coefficients.iter().rev().fold(0.0, |sum, a| sum * end + a);
        let slope = base.extrapolation.slope;
        Line { constant: value - slope * end, slope }
    }

    /// The error at a reading as in [`ErrorModel::error`], outside the valid range by [`Coefficients::line_beyond`].
    pub fn error_beyond(&self, reading: f64) -> f64 {
        let line = self.line_beyond(reading);
        self.sensor.gain(reading) * (line.constant + line.slope * (reading - self.base.centre))
    }
}

/// The least-squares line through a polynomial in (x − centre) over from..to, every x counting alike: the
/// first two terms of its Legendre series.
pub fn extrapolation(coefficients: &[f64], centre: f64, from: f64, to: f64) -> Line {
    let (middle, half) = (0.5 * (from + to) - centre, 0.5 * (to - from));
    // Gauss–Legendre nodes integrate exactly up to degree 2·16 − 1: the polynomial times x has at most 16.
    let (mut mean, mut first) = (0.0, 0.0);
    for (node, weight) in gauss_legendre_16() {
        let x = middle + half * node;
        let value = coefficients.iter().rev().fold(0.0, |sum, a| sum * x + a);
        mean += 0.5 * weight * value;
        first += 1.5 * weight * node * value;
    }
    let slope = if half > 0.0 { first / half } else { 0.0 };
    Line { constant: mean - slope * middle, slope }
}

/// Nodes and weights of the 16-point rule, by Newton's method on P₁₆ (Press et al., Numerical Recipes, 4.6).
fn gauss_legendre_16() -> impl Iterator<Item = (f64, f64)> {
    const COUNT: usize = 16;
    (0..COUNT).map(|index| {
        let mut x = libm::cos(std::f64::consts::PI * (index as f64 + 0.75) / (COUNT as f64 + 0.5));
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut now) = (1.0, x);
            for degree in 2..=COUNT {
                let n = degree as f64;
                let next = ((2.0 * n - 1.0) * x * now - (n - 1.0) * before) / n;
                before = std::mem::replace(&mut now, next);
            }
            slope = COUNT as f64 * (x * now - before) / (x * x - 1.0);
            x -= now / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    })
}
