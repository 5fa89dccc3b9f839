//! Tables for firmware that exists: the correction in the format that it reads, chosen for what *it* computes from the
//! table, with a proven bound of that.
//!
//! Each firmware is one file that implements [`TableFirmware`]: its arithmetic, written after its source, its format, and
//! the choice of the entries. `ring` says what is wanted at every count, `interpolate` and `chain` find entries between
//! which straight lines lie as close to it as they can.

mod axis;
mod chain;
mod describe;
mod interpolate;
pub mod klipper;
pub mod linuxcnc;
pub mod moteus;
mod ring;
pub mod simplefoc;
pub mod single;
pub mod vesc;

use fitter::budget::Budget;
use fitter::coefficients::Coefficients;

use crate::accepted::{NotAccepted, accepted};
use crate::certificate::Part;
use crate::generate::Generated;
use crate::options::Options;
use crate::render::RenderError;
use crate::text;
use crate::turn::TurnError;

/// Firmware that has a place for a table of corrections.
pub trait TableFirmware: Sync {
    /// Its name, as the command line has it.
    fn name(&self) -> &'static str;
    /// The file of its source in which the table is applied, and the version that was read.
    fn source(&self) -> &'static str;
    /// The options that its table has beside the bound.
    fn takes(&self) -> &'static [&'static str];
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
    /// `calibrate` of an angle sensor of Klipper.
    Klipper,
    /// `COMP_FILE` of a joint of LinuxCNC.
    Linuxcnc,
}

impl Firmware {
    /// What is known of it.
    pub fn firmware(self) -> &'static dyn TableFirmware {
        match self {
            Firmware::Moteus => &moteus::Moteus,
            Firmware::Vesc => &vesc::Vesc,
            Firmware::Simplefoc => &simplefoc::SimpleFoc,
            Firmware::Klipper => &klipper::Klipper,
            Firmware::Linuxcnc => &linuxcnc::LinuxCnc,
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
    /// Whether the head stands below the table: what reads it stops at the first line that is no entry.
    pub head_last: bool,
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
    /// What the table leaves out of the model, with its size.
    pub left_out: Vec<String>,
    /// The uncertainty of what the firmware computes; none where the file does not say what the recording showed.
    pub budget: Option<Budget>,
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
            says("the bound is {wanted:.3e} {unit}, and {what} can reach {} {unit} with this correction", text::rounded_up(*reached))
            mend("ask for no less than that, or generate a routine instead") by(bound);
        Source { source: u32, most: u32 } =>
            says("there is no source {source}") mend("give 0 to {most}") by(source);
        Entries { entries: usize, fewest: usize, most: usize, periods: u32 } =>
            says("{entries} entries for an error of {periods} periods")
            mend("give {fewest} to {most}, four for each period at least") by(entries);
        Steps { steps: usize, fewest: usize, most: usize } =>
            says("{steps} full steps for the 64 entries that Klipper fits to them")
            mend("give full_steps_per_rotation, a multiple of four from {fewest} to {most}") by(entries);
        Falls =>
            says("the corrected angle does not rise by enough from step to step for Klipper to fit a table to it")
            mend("mount the magnet nearer to the axis, or generate a routine instead");
        Wraps =>
            says("linuxcnc corrects a joint between two ends, and its table does not start again at the end of a turn")
            mend("generate a routine for a sensor that turns, or leave the revolution out and fit the axis between its ends");
        NotDirect =>
            says("linuxcnc corrects a position, and these coefficients are of a pair of probes")
            mend("record the axis as a sensor that reports its position");
        Range { range: (f64, f64), covered: (f64, f64) } =>
            says("a table from {} to {}, and the recording covers {} to {}", range.0, range.1, covered.0, covered.1)
            mend("give ends within it, or let the table exceed it") by(range) by(extrapolate);
        Steep { steepest: f64 } =>
            says("the error may change by {steepest:.2} for a change of 1 in position: it cannot be turned round to a \
                correction")
            mend("fit again with a lower order, or over a shorter range");
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
