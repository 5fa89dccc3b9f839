//! The arguments, as `--help` tells them.

use std::path::PathBuf;

use super::Common;
use super::options::InputName;
use crate::cost::Core;
use crate::format::Format;
use crate::options::{CShift, OutOfRange};
use crate::output::Output;
use crate::tables::Firmware;
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};

/// The path of a recording; `-` is standard input.
pub fn recording() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|path| if path.as_os_str() == "-" { "/dev/stdin".into() } else { path })
}

/// What is generated, for every command.
#[derive(Debug, Args)]
pub struct Arguments {
    /// What every command takes.
    #[command(flatten)]
    pub common: Common,
    /// Coefficients file, as `fit` or `diagnose` wrote it [default: the one that lies in this folder].
    #[arg(long, conflicts_with = "recording")]
    pub coefficients: Option<PathBuf>,
    /// Recording, fitted on the way (`-`: standard input).
    #[arg(long, requires = "mirror", value_parser = recording())]
    pub recording: Option<PathBuf>,
    /// Nominal mirror of the recording.
    #[arg(long, requires = "recording")]
    pub mirror: Option<PathBuf>,
    /// The embedded recording of a simulated mirror.
    #[arg(long, conflicts_with_all = ["coefficients", "recording", "devices"])]
    pub demo: bool,
    /// Generate although the diagnosis of the recording left more than it named: the generated files then say so.
    #[arg(long)]
    pub accept_unexplained: bool,
    /// Coefficients files of many devices, `devices/*.json` for example: one routine, and a page of coefficients for each.
    #[arg(long, num_args = 1.., conflicts_with_all = ["coefficients", "recording"])]
    pub devices: Vec<String>,
    /// By how much the devices' coefficients may be exceeded, as a part of the largest [default: 0.25].
    #[arg(long, requires = "devices", allow_negative_numbers = true)]
    pub margin: Option<f64>,
    /// Address of the pages in flash, for the Intel HEX files: 0x0801f800 [default: 0].
    #[arg(long, requires = "devices")]
    pub page_address: Option<String>,
    /// Pages for a routine that is there already: the units.json beside it, and the options that it was made with.
    #[arg(long, requires = "devices", conflicts_with = "margin")]
    pub pages_for: Option<PathBuf>,
    /// A table for firmware that exists, in its own format, in place of a routine.
    #[arg(long = "for", value_enum, conflicts_with = "devices")]
    pub firmware: Option<Firmware>,
    /// Number of the encoder among the sources of the firmware (moteus) [default: 0].
    #[arg(long, requires = "firmware")]
    pub source: Option<u32>,
    /// Entries of the table, where the firmware takes any number; of Klipper full steps of a turn [default: SimpleFOC 200,
    /// LinuxCNC 256, Klipper 200].
    #[arg(long, requires = "firmware")]
    pub entries: Option<usize>,
    /// Electrical turns in one of the encoder (VESC: foc_encoder_ratio), below zero where the encoder is inverted.
    #[arg(long, requires = "firmware", allow_negative_numbers = true)]
    pub ratio: Option<f64>,
    /// Output folder.
    #[arg(long, default_value = "generated")]
    pub out: PathBuf,
    /// Largest acceptable bound in arcseconds [default: 0.01].
    #[arg(long, conflicts_with = "bound")]
    pub bound_arcsec: Option<f64>,
    /// Largest acceptable bound with its unit, for example 0.0001mm [default of a direct sensor: a hundredth of its noise].
    #[arg(long)]
    pub bound: Option<String>,
    /// Degree of the polynomial [default: the lowest that meets the bound].
    #[arg(long)]
    pub degree: Option<usize>,
    /// Smallest reading, in mm (direct sensor: its unit) [default: what the recording covers].
    #[arg(long, requires = "to", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Largest reading.
    #[arg(long, requires = "from", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Let the range exceed what the recording covers.
    #[arg(long)]
    pub extrapolate: bool,
    /// Number formats of the evaluation, one routine each [default: q31,f32; with --target: any].
    #[arg(long, value_enum, value_delimiter = ',')]
    pub format: Vec<Format>,
    /// Products and sums of floats rounded once together, by cores that do so in one instruction: in place of format f32.
    #[arg(long)]
    pub fma: bool,
    /// Choose method and format: what meets the bound at the least cost on this core. With --flash-bytes that is the fewest
    /// instructions; otherwise eleven times the flash counts as much as twice the instructions.
    #[arg(long, value_enum, conflicts_with_all = ["degree", "table"])]
    pub target: Option<Core>,
    /// Bytes of flash that the chosen routine may take [default: any; of an encoder 2048].
    #[arg(long)]
    pub flash_bytes: Option<usize>,
    /// A table of polynomials instead of one, as degree and number of segments: 2x32. Rows of three words are packed;
    /// `2x32-padded` makes them four, so that their address is one shift.
    #[arg(long)]
    pub table: Option<String>,
    /// What the routines are given [default: the reading, q31 for q31 and f32 for f32].
    #[arg(long, value_enum)]
    pub input: Option<InputName>,
    /// What the reading of a Q31 word's 2^31 is [default: the smallest power of two above the range; with --target, of a
    /// range that is symmetric, twice its end]. Of such a range, its end needs no limits, twice its end limits of one
    /// instruction.
    #[arg(long)]
    pub full_scale: Option<f64>,
    /// Width of the converter's word, for counts [default: 16]; of an encoder's word, 10 to 18 [default: the fewest
    /// whose rounding is within a tenth of the noise].
    #[arg(long)]
    pub bits: Option<u32>,
    /// Counts of an encoder's turn, where they are no power of two: 4000 for example.
    #[arg(long, value_name = "N", conflicts_with = "bits")]
    pub counts: Option<u32>,
    /// Bits of an encoder's corrected word [default: as many as its own].
    #[arg(long)]
    pub output_bits: Option<u32>,
    /// Change of a displacement (direct sensor: of the reading) by one count.
    #[arg(long, allow_negative_numbers = true)]
    pub gain: Option<f64>,
    /// The count that stands for zero [default: the middle].
    #[arg(long, allow_negative_numbers = true)]
    pub offset: Option<f64>,
    /// What the routines return [default: pow2 for q31, f32 for f32].
    #[arg(long, value_enum)]
    pub output: Option<Output>,
    /// What happens to readings outside the range.
    #[arg(long, value_enum, default_value = "clamp")]
    pub out_of_range: OutOfRange,
    /// A further input that a term of the coefficients needs: its column, the range in which it is valid, and how
    /// it arrives: `temperature_c=15..35` (a Q31 word) or `temperature_c=15..35:counts:12:0.05:-400`.
    #[arg(long, allow_hyphen_values = true)]
    pub further: Vec<String>,
    /// Seconds between two calls of the routine, for terms that depend on time.
    #[arg(long)]
    pub period_s: Option<f64>,
    /// Leave the terms of this effect out.
    #[arg(long)]
    pub without: Vec<String>,
    /// Generate the terms of this effect although they hold on the recording they were found in only: where the
    /// routine begins as that recording did, a warm-up since switch-on for example.
    #[arg(long)]
    pub keep: Vec<String>,
    /// Right shifts of negative numbers in C: none, or the compiler's.
    #[arg(long, value_enum, default_value = "strict")]
    pub c_shift: CShift,
    /// Name of crate, files and functions (default: corrected_angle; direct sensor: `corrected_<unit>`).
    #[arg(long)]
    pub name: Option<String>,
    /// The same as the command `check`.
    #[arg(long)]
    pub check: bool,
}
