//! Tables for firmware that exists: the correction in the format that it reads, chosen for what *it* computes from the
//! table, with a proven bound of that.
//!
//! Each firmware is one file that implements [`TableFirmware`]: its arithmetic, written after its source, its format, and
//! the choice of the entries. `ring` says what is wanted at every count, `interpolate` and `chain` find entries between
//! which straight lines lie as close to it as they can.

mod chain;
mod describe;
mod interpolate;
pub mod moteus;
mod ring;
pub mod simplefoc;
pub mod single;
pub mod vesc;

use fitter::coefficients::Coefficients;

use crate::accepted::{NotAccepted, accepted};
use crate::certificate::Part;
use crate::generate::Generated;
use crate::options::Options;
use crate::render::RenderError;
use crate::turn::TurnError;

/// Firmware that has a place for a table of corrections.
pub trait TableFirmware: Sync {
    /// Its name, as the command line has it.
    fn name(&self) -> &'static str;
    /// The file of its source in which the table is applied, and the version that was read.
    fn source(&self) -> &'static str;
    /// The best table that it can hold.
    ///
    /// # Errors
    /// [`TableError`] where it has no place for such a correction, or for so large a one.
    fn design(&self, coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Table, TableError>;
}

/// The firmware that a table can be made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Firmware {
    /// `motor_position.sources.N.compensation_table` of a moteus controller.
    Moteus,
    /// `enc_corr` of a VESC.
    Vesc,
    /// The table of SimpleFOC's `CalibratedSensor`.
    Simplefoc,
}

impl Firmware {
    /// What is known of it.
    pub fn firmware(self) -> &'static dyn TableFirmware {
        match self {
            Firmware::Moteus => &moteus::Moteus,
            Firmware::Vesc => &vesc::Vesc,
            Firmware::Simplefoc => &simplefoc::SimpleFoc,
        }
    }
}

/// What the user says of the firmware's configuration.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wanted {
    /// Number of the encoder among the firmware's sources; none: 0.
    pub source: Option<u32>,
    /// Number of entries, where the firmware takes any; none: its usual one.
    pub entries: Option<usize>,
    /// Electrical turns in one of the encoder, below zero where the firmware inverts it.
    pub ratio: Option<f64>,
}

/// What is asked for, with the rest of the options.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a> {
    /// Of the firmware.
    pub wanted: Wanted,
    /// Counts, bound and name.
    pub options: &'a Options,
}

/// A table as designed, with what was proved of it. Lengths are in the sensor's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of the file.
    pub file: &'static str,
    /// How a line of its comments begins.
    pub comment: &'static str,
    /// The file below its head.
    pub text: String,
    /// Number of entries.
    pub entries: usize,
    /// Number format of an entry.
    pub format: &'static str,
    /// Degree of the interpolation: 0 where there is none.
    pub degree: usize,
    /// What the table is given, in words.
    pub input: String,
    /// The type of the firmware's result, and what one unit of it is.
    pub output: (&'static str, f64),
    /// First and last input, and their unit.
    pub range: (f64, f64, String),
    /// |what the firmware computes − the model| is at most this for every input.
    pub bound: f64,
    /// What it is made of.
    pub parts: Vec<Part>,
    /// The same of the best entries of this interpolation, were they of unlimited precision.
    pub minimax: f64,
    /// By how much what the firmware computes is above the reference everywhere: the zero of the mount, which the
    /// firmware sets elsewhere.
    pub zero: f64,
    /// How it is loaded, a line each.
    pub load: Vec<String>,
}

fitter::errors! {
    /// Why there is no table.
    #[derive(Debug)]
    pub enum TableError {
        NotATurn { firmware: &'static str } =>
            says("{firmware} corrects an encoder over its turn, and these coefficients are not of a whole turn")
            mend("record a whole turn of a sensor with a revolution, or generate a routine instead");
        Bound { wanted: f64, reached: f64, unit: String, what: String } =>
            says("the bound is {wanted:.3e} {unit}, and {what} can reach {reached:.3e} {unit} with this correction")
            mend("ask for no less than that, or generate a routine instead") by(bound);
        Source { source: u32, most: u32 } =>
            says("there is no source {source}") mend("give 0 to {most}") by(source);
        Entries { entries: usize, fewest: usize, most: usize, harmonics: u32 } =>
            says("{entries} entries for an error of {harmonics} periods in a turn")
            mend("give {fewest} to {most}, four for each period at least") by(entries);
        NoRatio =>
            says("the table is in electrical degrees, and how many electrical turns the encoder's turn has is not known")
            mend("give foc_encoder_ratio, below zero where foc_encoder_inverted is set") by(ratio = 7);
        Ratio { ratio: f64 } =>
            says("a ratio of {ratio}") mend("give foc_encoder_ratio, 1 or more, below zero where it is inverted") by(ratio);
        Large { half: f64, largest: f64, unit: &'static str } =>
            says("the correction reaches {half:.1} {unit} either way, and an entry {largest} at most")
            mend("mount the encoder nearer to the axis, or generate a routine instead");
    }
    from {
        NotAccepted(NotAccepted),
        Turn(TurnError),
        Render(RenderError),
        Json(serde_json::Error),
    }
}

/// Makes the table of a firmware, with its certificate.
///
/// # Errors
/// [`TableError`], which says what to change.
pub fn generate(
    firmware: Firmware,
    coefficients: &Coefficients,
    coefficients_sha256: &str,
    asked: &Asked<'_>,
) -> Result<Generated, TableError> {
    let reservation = accepted(coefficients, asked.options)?;
    let firmware = firmware.firmware();
    let table = firmware.design(coefficients, asked)?;
    if let Some(wanted) = asked.options.bound.filter(|wanted| table.bound > *wanted) {
        let unit = coefficients.sensor.error_unit().to_string();
        let what = format!("the table of {} ({} entries, {})", firmware.name(), table.entries, table.format);
        return Err(TableError::Bound { wanted, reached: table.bound, unit, what });
    }
    describe::files(firmware, &table, coefficients, coefficients_sha256, reservation, asked.options)
}
