//! The catalogue of physical effects that can stand between a recording and its simulation: a file
//! each or one of a kind, one line in [`catalogue`]. An effect's contribution is linear in its amplitudes and may depend on
//! a few shape parameters (time constants, periods, thresholds, …) that the search finds.

mod backlash;
pub mod declared;
mod dependence;
mod hysteresis;
mod local_defect;
mod mount_step;
mod operators;
pub mod page;
mod periodic_error;
mod read_lag;
mod sensor_clipping;
mod thermal_gain_drift;
mod thermal_lag;
mod time_drift;
mod turn_slope;
mod warmup_drift;

pub use operators::{low_pass, play_from, plays_apart};

use fitter::terms::Operator;
use fitter::turn::Turn;

pub use crate::experiment::Experiment;
use crate::rows::Rows;

/// Where a mismatch lives: an observable, or an observable times another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name of the observable as in `locations`.
    pub variable: String,
    /// The observable that multiplies it, where it is a product.
    pub times: Option<String>,
}

impl Place {
    /// The place of a plain dependence.
    pub fn on(variable: &str) -> Place {
        Place { variable: variable.into(), times: None }
    }

    /// The place of a product.
    pub fn product(variable: &str, times: &str) -> Place {
        Place { variable: variable.into(), times: Some(times.into()) }
    }
}

/// A shape parameter's range.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Whether it is searched on a logarithmic scale.
    pub logarithmic: bool,
    /// Whether it only takes whole values (a row, a number of harmonics).
    pub whole: bool,
}

/// What a reader is told of one parameter.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Its name in the diagnosis, with its unit.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// A physical effect.
pub trait Effect: Sync + Send {
    /// What is known of it beside its formula.
    fn facts(&self) -> &Facts;
    /// Whether a shape says how things stood before the first row, which the first rows alone can tell.
    fn begins_before(&self, _shape: &[f64]) -> bool {
        false
    }
    /// Indices of the rows at which the recording does not determine the signature; they take no part in fitting the
    /// amplitude. `noise` is the standard deviation of a reading in the unit of the rows.
    fn undetermined_rows(&self, _rows: &Rows, _noise: f64) -> Vec<usize> {
        Vec::new()
    }
    /// Why this recording cannot show it.
    ///
    /// # Errors
    /// A sentence naming what is missing.
    fn testable(&self, rows: &Rows) -> Result<(), String>;
    /// Shapes from which the search starts; one empty shape where there is no shape parameter.
    fn starts(&self, _rows: &Rows) -> Vec<Vec<f64>> {
        vec![Vec::new()]
    }
    /// Ranges of the shape parameters.
    fn ranges(&self, _rows: &Rows) -> Vec<Range> {
        Vec::new()
    }
    /// The columns that the amplitudes multiply, in the recording's unit per unit amplitude.
    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>>;
    /// Whether a shape within the ranges can be this effect.
    fn possible_shape(&self, _rows: &Rows, _shape: &[f64]) -> bool {
        true
    }
    /// Over what distance of shape parameter `k` (of its logarithm, where it is sought on that scale) the signature stays
    /// much the same; none where a hundredth of the range is little enough.
    fn spacing(&self, _k: usize, _shape: &[f64]) -> Option<f64> {
        None
    }
    /// Whether these amplitudes can be this effect.
    fn plausible(&self, _amplitudes: &[f64]) -> bool {
        true
    }
    /// Whether amplitudes at a shape can be this effect; asked where the amplitudes are known.
    fn plausible_at(&self, _shape: &[f64], amplitudes: &[f64]) -> bool {
        self.plausible(amplitudes)
    }
    /// A shape that follows from the amplitudes found (play whose width is its own amplitude).
    fn consistent_shape(&self, _shape: &[f64], _amplitudes: &[f64], _rows: &Rows) -> Option<Vec<f64>> {
        None
    }
    /// What a shape must explain beyond others of the effect to be preferred.
    fn reluctance(&self, _shape: &[f64]) -> f64 {
        0.0
    }
    /// The title, with what the sign of the amplitudes says.
    fn found_as(&self, _amplitudes: &[f64]) -> &'static str {
        self.facts().title
    }
    /// A richer form of the same effect to be tried once this one is found (a further harmonic).
    fn richer(&self, _rows: &Rows, _shape: &[f64]) -> Option<Vec<f64>> {
        None
    }
    /// The effect as a term of the coefficients file, with the factor by which the operator's coefficients
    /// differ from the amplitudes here, one per column.
    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed;
    /// The parameters as they are reported.
    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading>;
}

/// What is known of an effect beside its formula in code.
pub struct Facts {
    /// Identifier in the diagnosis and the coefficients file.
    pub id: &'static str,
    /// Name for a reader.
    pub title: &'static str,
    /// What it adds to the angular error, with units.
    pub formula: &'static str,
    /// Where the physics is described.
    pub source: &'static str,
    /// Sign and magnitude that are plausible.
    pub size: &'static str,
    /// Ids of the effects that it is most easily taken for.
    pub confused_with: &'static [&'static str],
    /// The observable that it depends on.
    pub variable: &'static str,
    /// The observable that multiplies it, where it is a product.
    pub times: Option<&'static str>,
    /// Whether it belongs to the recording in which it happened: no correction can undo it at run time.
    pub of_one_time: bool,
    /// Whether the column is a measurement of its own: whatever is left of it beside a model is then real, and
    /// not the rounding or the noise of another column that it was computed from.
    pub measured: bool,
    /// Whether it is a step, its one shape parameter the row from which on it is there: every row is then tried.
    pub begins_at_a_row: bool,
    /// Whether it can occur more than once in a recording (a second step, a second defect).
    pub repeatable: bool,
    /// Whether the shape follows from the amplitudes, so that it is not searched.
    pub shape_follows: bool,
    /// Which of its readings is a place on the angle at which something of one probe stands. It moves along the angle with
    /// the common mode.
    pub place_of_a_probe: Option<usize>,
    /// Whether its one amplitude multiplies the common mode, which holds the noise of the probes.
    pub of_common_mode: bool,
    /// Whether the user declared it.
    pub declared: bool,
    /// Whether `fit` found it already in a sensor that turns.
    pub found_by_fit: fn(&Turn) -> bool,
    /// The experiments that tell it from others, each with what it does there.
    pub told_by: &'static [(Experiment, &'static str)],
}

impl Facts {
    /// What holds of an effect unless it says otherwise.
    const USUAL: Facts = Facts {
        id: "",
        title: "",
        formula: "",
        source: "",
        size: "",
        confused_with: &[],
        variable: "",
        times: None,
        of_one_time: false,
        measured: false,
        begins_at_a_row: false,
        repeatable: false,
        shape_follows: false,
        place_of_a_probe: None,
        of_common_mode: false,
        declared: false,
        found_by_fit: |_| false,
        told_by: &[],
    };

    /// Identifier in the diagnosis and in files.
    pub fn id(&self) -> &'static str {
        self.id
    }

    /// Where the mismatch that it makes lives.
    pub fn place(&self) -> Place {
        Place { variable: self.variable.into(), times: self.times.map(Into::into) }
    }
}

/// An effect is known by its facts.
impl std::ops::Deref for dyn Effect + '_ {
    type Target = Facts;

    fn deref(&self) -> &Facts {
        self.facts()
    }
}

/// An effect as the coefficients file knows it.
#[derive(Debug, Clone)]
pub struct Handed {
    /// The operator.
    pub operator: Operator,
    /// The operator's coefficients as a linear map of the amplitudes: one row per coefficient.
    pub map: Vec<Vec<f64>>,
}

impl Handed {
    /// One column, one coefficient, `factor` times the amplitude.
    fn scaled(operator: Operator, factor: f64) -> Handed {
        Handed { operator, map: vec![vec![factor]] }
    }

    /// One column whose coefficient is the amplitude.
    fn plain(operator: Operator) -> Handed {
        Handed::scaled(operator, 1.0)
    }
}

/// The name under which the terms know the angle: in arcseconds for a pair, else the reading itself.
fn angle_observable(rows: &Rows) -> &'static str {
    if rows.pair { "angle_arcsec" } else { "measured" }
}

/// Mean of an optional column.
fn mean_of(column: &Option<Vec<f64>>) -> f64 {
    column.as_ref().map_or(0.0, |c| crate::numerics::mean(c))
}

/// Id of the error that repeats with the angle: what `fit` calls the harmonics of a turn.
pub const PERIODIC_ERROR: &str = "periodic_error";

/// All effects, in the order in which ties are broken: the simpler explanation first.
pub fn catalogue() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(&dependence::THERMAL_ZERO_DRIFT),
        Box::new(thermal_gain_drift::ThermalGainDrift),
        Box::new(time_drift::TimeDrift),
        Box::new(warmup_drift::WarmupDrift),
        Box::new(thermal_lag::ThermalLag),
        Box::new(mount_step::MountStep),
        Box::new(backlash::Backlash),
        Box::new(hysteresis::Hysteresis),
        Box::new(periodic_error::PeriodicError),
        Box::new(&dependence::COMMON_MODE_LEAKAGE),
        Box::new(&dependence::CROSS_AXIS_COUPLING),
        Box::new(&dependence::COIL_CROSSTALK),
        Box::new(sensor_clipping::SensorClipping),
        Box::new(local_defect::LocalDefect),
        Box::new(read_lag::ReadLag),
        Box::new(turn_slope::TurnSlope),
    ]
}

/// `needed` or a sentence that says which column is missing.
fn present<'a>(column: &'a Option<Vec<f64>>, name: &str) -> Result<&'a Vec<f64>, String> {
    let values = column.as_ref().ok_or_else(|| format!("the recording has no usable column {name}"))?;
    let (low, high) = crate::numerics::range(values);
    if high > low { Ok(values) } else { Err(format!("the column {name} is constant")) }
}

/// In a single move time runs with the angle, and the reference may be a function of time itself: nothing
/// that goes by time can be told from it.
fn time_apart(rows: &Rows) -> Result<(), String> {
    if rows.single_move() { Err("a single move: time runs with the angle".into()) } else { Ok(()) }
}

/// The range in which a time constant can be told from nothing: faster than a few rows it is over before it
/// is seen; beyond `longest` recordings it is a ramp.
fn time_constants(rows: &Rows, longest: f64) -> Range {
    let row_s = rows.duration_s() / rows.len().max(2) as f64;
    Range { low: 3.0 * row_s, high: longest * rows.duration_s(), logarithmic: true, whole: false }
}

/// Starts over a logarithmic range of one parameter.
fn starts_over(range: Range, count: usize) -> Vec<Vec<f64>> {
    logarithmic(range.low, range.high, count).into_iter().map(|value| vec![value]).collect()
}

/// Whether time passes at all and is tied neither to the angle nor to the direction.
fn time_passes(rows: &Rows) -> Result<(), String> {
    time_apart(rows)?;
    if rows.direction.windows(2).filter(|pair| pair[0] != pair[1]).count() == 1 {
        return Err("one move each way: time runs with the direction".into());
    }
    if rows.t_s.last() > rows.t_s.first() { Ok(()) } else { Err("time stands still".into()) }
}

/// The coefficient of a plain dependence, in the recording's unit per that of the observable.
fn coefficient(rows: &Rows, amplitude: f64, name: &str, unit: &str) -> Reading {
    reading(format!("coefficient_{}_per_{name}", rows.unit), amplitude, format!("{}/{unit}", rows.unit))
}

/// A logarithmic grid of `count` values.
fn logarithmic(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| low * (high / low).powf(k as f64 / (count.max(2) - 1) as f64)).collect()
}

/// The unit at which angles are printed, and how many of the recording's units it is: degrees for arcsec,
/// otherwise the sensor's own.
fn edge_unit(rows: &Rows) -> (&str, f64) {
    if rows.unit == "arcsec" { ("deg", 3600.0) } else { (&rows.unit, 1.0) }
}

/// dθ/dt by the difference to the row before in the same pass, as a controller forms it and `rate` of the coefficients
/// file is applied, in the recording's unit per second; the first row of a pass has that of the second.
pub fn velocity(rows: &Rows) -> Vec<f64> {
    let n = rows.len();
    let same = |a: usize, b: usize| b < n && rows.pass[a] == rows.pass[b];
    let between = |a: usize, b: usize| {
        let dt = rows.t_s[b] - rows.t_s[a];
        if dt > 0.0 { (rows.theta[b] - rows.theta[a]) / dt } else { 0.0 }
    };
    (0..n)
        .map(|i| match i {
            _ if i > 0 && same(i - 1, i) => between(i - 1, i),
            _ if same(i, i + 1) => between(i, i + 1),
            _ => 0.0,
        })
        .collect()
}

/// One reading.
fn reading(name: impl Into<String>, value: f64, unit: impl Into<String>) -> Reading {
    Reading { name: name.into(), value, unit: unit.into() }
}

#[cfg(test)]
mod tests {
    use super::catalogue;

    #[test]
    fn every_confusion_names_an_effect_of_the_catalogue() {
        let effects = catalogue();
        for effect in &effects {
            for other in effect.confused_with {
                assert!(effects.iter().any(|e| e.id == *other), "{}: {other}", effect.id);
                assert_ne!(*other, effect.id);
            }
        }
    }
}
