//! The arguments, as `--help` tells them.

use std::path::PathBuf;

use clap::Args;
use fitter::cli::Common;

use super::names::{CShiftName, CoreName, FormatName, InputName, OutOfRangeName, OutputName};

/// What is generated, for every command.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    pub(super) common: Common,
    /// Coefficients file, as written by `fitter fit` or `diagnose` [default: the one that lies in this folder].
    #[arg(long, conflicts_with = "recording")]
    pub(super) coefficients: Option<PathBuf>,
    /// Recording, fitted on the way.
    #[arg(long, requires = "mirror")]
    pub(super) recording: Option<PathBuf>,
    /// Nominal mirror of the recording.
    #[arg(long, requires = "recording")]
    pub(super) mirror: Option<PathBuf>,
    /// The embedded recording of a simulated mirror.
    #[arg(long, conflicts_with_all = ["coefficients", "recording", "units"])]
    pub(super) demo: bool,
    /// Generate although the diagnosis of the recording left more than it named: the generated files then say so.
    #[arg(long)]
    pub(super) accept_unexplained: bool,
    /// Coefficients files of many units, `units/*.json` for example: one routine, and a page of coefficients for each.
    #[arg(long, num_args = 1.., conflicts_with_all = ["coefficients", "recording"])]
    pub(super) units: Vec<String>,
    /// By how much the units' coefficients may be exceeded, as a part of the largest [default: 0.25].
    #[arg(long, requires = "units", allow_negative_numbers = true)]
    pub(super) margin: Option<f64>,
    /// Address of the pages in flash, for the Intel HEX files: 0x0801f800 [default: 0].
    #[arg(long, requires = "units")]
    pub(super) page_address: Option<String>,
    /// Pages for a routine that is there already: the units.json beside it, and the options that it was made with.
    #[arg(long, requires = "units", conflicts_with = "margin")]
    pub(super) pages_for: Option<PathBuf>,
    /// Output folder.
    #[arg(long, default_value = "generated")]
    pub(super) out: PathBuf,
    /// Largest acceptable bound in arcseconds [default: 0.01].
    #[arg(long, conflicts_with = "bound")]
    pub(super) bound_arcsec: Option<f64>,
    /// Largest acceptable bound with its unit, for example 0.0001mm [default of a direct sensor: a hundredth of its noise].
    #[arg(long)]
    pub(super) bound: Option<String>,
    /// Degree of the polynomial [default: the lowest that meets the bound].
    #[arg(long)]
    pub(super) degree: Option<usize>,
    /// Smallest reading, in mm (direct sensor: its unit) [default: what the recording covers].
    #[arg(long, requires = "to", allow_negative_numbers = true)]
    pub(super) from: Option<f64>,
    /// Largest reading.
    #[arg(long, requires = "from", allow_negative_numbers = true)]
    pub(super) to: Option<f64>,
    /// Let the range exceed what the recording covers.
    #[arg(long)]
    pub(super) extrapolate: bool,
    /// Number formats of the evaluation, one routine each [default: q31,f32; with --target: any].
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(super) format: Vec<FormatName>,
    /// Choose method and format: the fewest instructions on this core that meet the bound.
    #[arg(long, value_enum, conflicts_with_all = ["degree", "table"])]
    pub(super) target: Option<CoreName>,
    /// Bytes of flash that the chosen routine may take [default: any; of an encoder 2048].
    #[arg(long)]
    pub(super) flash_bytes: Option<usize>,
    /// A table of polynomials instead of one, as degree and number of segments: 2x32.
    #[arg(long)]
    pub(super) table: Option<String>,
    /// What the routines are given [default: the reading, q31 for q31 and f32 for f32].
    #[arg(long, value_enum)]
    pub(super) input: Option<InputName>,
    /// What the reading of a Q31 word's 2^31 is [default: the smallest power of two above the range]. Of a range
    /// that is symmetric, its end needs no limits, twice its end limits of one instruction.
    #[arg(long)]
    pub(super) full_scale: Option<f64>,
    /// Width of the converter's word, for counts [default: 16]; of an encoder's word, 10 to 18 [default: the fewest
    /// whose rounding is within a tenth of the noise].
    #[arg(long)]
    pub(super) bits: Option<u32>,
    /// Counts of an encoder's turn, where they are no power of two: 4000 for example.
    #[arg(long, value_name = "N", conflicts_with = "bits")]
    pub(super) counts: Option<u32>,
    /// Bits of an encoder's corrected word [default: as many as its own].
    #[arg(long)]
    pub(super) output_bits: Option<u32>,
    /// Change of a displacement (direct sensor: of the reading) by one count.
    #[arg(long, allow_negative_numbers = true)]
    pub(super) gain: Option<f64>,
    /// The count that stands for zero [default: the middle].
    #[arg(long, allow_negative_numbers = true)]
    pub(super) offset: Option<f64>,
    /// What the routines return [default: pow2 for q31, f32 for f32].
    #[arg(long, value_enum)]
    pub(super) output: Option<OutputName>,
    /// What happens to readings outside the range.
    #[arg(long, value_enum, default_value = "clamp")]
    pub(super) out_of_range: OutOfRangeName,
    /// A further input that a term of the coefficients needs: its column, the range in which it is valid, and how
    /// it arrives: `temperature_c=15..35` (a Q31 word) or `temperature_c=15..35:counts:12:0.05:-400`.
    #[arg(long, allow_hyphen_values = true)]
    pub(super) further: Vec<String>,
    /// Seconds between two calls of the routine, for terms that depend on time.
    #[arg(long)]
    pub(super) period_s: Option<f64>,
    /// Leave the terms of this effect out.
    #[arg(long)]
    pub(super) without: Vec<String>,
    /// Generate the terms of this effect although they hold on the recording they were found in only: where the
    /// routine begins as that recording did, a warm-up since switch-on for example.
    #[arg(long)]
    pub(super) keep: Vec<String>,
    /// Right shifts of negative numbers in C: none, or the compiler's.
    #[arg(long, value_enum, default_value = "strict")]
    pub(super) c_shift: CShiftName,
    /// Name of crate, files and functions [default: corrected_angle; direct sensor: `corrected_<unit>`].
    #[arg(long)]
    pub(super) name: Option<String>,
    /// The same as the command `check`.
    #[arg(long)]
    pub(super) check: bool,
}

/// Arguments of `codegen explore`.
#[derive(Debug, Args)]
pub struct ExploreArguments {
    #[command(flatten)]
    pub(super) arguments: Arguments,
    /// Also draw the bounds against the instructions, as an SVG picture.
    #[arg(long)]
    pub(super) svg: Option<PathBuf>,
}

/// Arguments of `codegen verify`.
#[derive(Debug, Default, Args)]
pub struct CheckArguments {
    /// Sweep every representable input, not only a part of them.
    #[arg(long)]
    pub(super) exhaustive: bool,
    /// Sweep the C once more with undefined behaviour watched for.
    #[arg(long)]
    pub(super) sanitize: bool,
    /// Let Gappa prove the rounding of the operations from the scripts beside the code.
    #[arg(long)]
    pub(super) gappa: bool,
    /// Let Frama-C look for undefined behaviour in the C over every input word.
    #[arg(long)]
    pub(super) frama_c: bool,
    /// Check the C with cppcheck's MISRA rules and all warnings of gcc and clang.
    #[arg(long)]
    pub(super) misra: bool,
    /// Look for panics in the Rust object, overflow checks on; and let rustdoc check the documentation.
    #[arg(long)]
    pub(super) objects: bool,
    /// Damage copies of the files on purpose, and see that every damage is caught.
    #[arg(long)]
    pub(super) mutants: bool,
}
