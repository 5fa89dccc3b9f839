//! The command line: arguments, and what is printed.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};
use fitter::coefficients::Coefficients;
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result, miette};

use crate::cost::Core;
use crate::explore::{self, Candidate};
use crate::files;
use crate::format::Format;
use crate::generate::{Generated, generate};
use crate::input::{Arity, Encoding, Input};
use crate::options::{CShift, Ends, Method, Options, OutOfRange, RoutineOptions};
use crate::output::Output;
use crate::plot;
use crate::quantity::Quantity;
use crate::source::Source;
use crate::text;
use crate::verify::Checks;

/// Generates the firmware correction of a scanning mirror, in Rust and C, with a proven error bound.
///
/// Without arguments, the embedded recording is fitted and `generated/` written.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    arguments: Arguments,
}

const EXAMPLES: &str = "Examples:
  codegen
  codegen --coefficients coefficients.json --out firmware/angle --format q31 --input x1x2-counts \\
          --bits 16 --gain 1.2207e-5 --output nano
  codegen --recording slit.csv.gz --mirror slit.toml --bound 0.0001mm --out slit
  codegen check --coefficients coefficients.json --out firmware/angle";

#[derive(Debug, Subcommand)]
enum Command {
    /// Compares what is in the output folder with what would be generated; exit code 1 where it is stale.
    Check(Arguments),
    /// Lists the routines that no other beats in bound, instructions and flash, for every core.
    Explore(ExploreArguments),
    /// Checks the generated files from outside: recomputes the certificate and sweeps the compiled Rust and C
    /// against a bounded reference; exit code 1 where anything does not hold.
    Verify {
        #[command(flatten)]
        arguments: Arguments,
        #[command(flatten)]
        checks: CheckArguments,
    },
}

#[derive(Debug, Args)]
struct ExploreArguments {
    #[command(flatten)]
    arguments: Arguments,
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Also draw the bounds against the instructions, as an SVG picture.
    #[arg(long)]
    svg: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct CheckArguments {
    /// Sweep every representable input, not only a part of them.
    #[arg(long)]
    exhaustive: bool,
    /// Sweep the C once more with undefined behaviour watched for.
    #[arg(long)]
    sanitize: bool,
    /// Let Gappa prove the rounding of the operations from the scripts beside the code.
    #[arg(long)]
    gappa: bool,
    /// Let Frama-C look for undefined behaviour in the C over every input word.
    #[arg(long)]
    frama_c: bool,
    /// Check the C with cppcheck's MISRA rules and all warnings of gcc and clang.
    #[arg(long)]
    misra: bool,
    /// Look for panics in the Rust object, overflow checks on; and let rustdoc check the documentation.
    #[arg(long)]
    objects: bool,
    /// Damage copies of the files on purpose, and see that every damage is caught.
    #[arg(long)]
    mutants: bool,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct Arguments {
    /// Coefficients file, as written by `fitter fit`.
    #[arg(long, conflicts_with = "recording")]
    coefficients: Option<PathBuf>,
    /// Recording, fitted on the way.
    #[arg(long, requires = "mirror")]
    recording: Option<PathBuf>,
    /// Nominal mirror of the recording.
    #[arg(long, requires = "recording")]
    mirror: Option<PathBuf>,
    /// Output folder.
    #[arg(long, default_value = "generated")]
    out: PathBuf,
    /// Largest acceptable bound in arcseconds [default: 0.01].
    #[arg(long, conflicts_with = "bound")]
    bound_arcsec: Option<f64>,
    /// Largest acceptable bound with its unit, for example 0.0001mm [default: a millionth of the range].
    #[arg(long)]
    bound: Option<String>,
    /// Degree of the polynomial [default: the lowest that meets the bound].
    #[arg(long)]
    degree: Option<usize>,
    /// Smallest reading, in mm (direct sensor: its unit) [default: what the recording covers].
    #[arg(long, requires = "to", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Largest reading.
    #[arg(long, requires = "from", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Let the range exceed what the recording covers.
    #[arg(long)]
    extrapolate: bool,
    /// Number formats of the evaluation, one routine each [default: q31,f32; with --target: any].
    #[arg(long, value_enum, value_delimiter = ',')]
    format: Vec<FormatName>,
    /// Choose method and format: the fewest instructions on this core that meet the bound.
    #[arg(long, value_enum, conflicts_with_all = ["degree", "table"])]
    target: Option<CoreName>,
    /// Bytes of flash that the chosen routine may take.
    #[arg(long, requires = "target")]
    flash_bytes: Option<usize>,
    /// A table of polynomials instead of one, as degree and number of segments: 2x32.
    #[arg(long)]
    table: Option<String>,
    /// What the routines are given [default: the reading, q31 for q31 and f32 for f32].
    #[arg(long, value_enum)]
    input: Option<InputName>,
    /// What the reading of a Q31 word's 2^31 is [default: the smallest power of two above the range].
    #[arg(long)]
    full_scale: Option<f64>,
    /// Width of the converter's word, for counts.
    #[arg(long, default_value_t = 16)]
    bits: u32,
    /// Change of a displacement (direct sensor: of the reading) by one count.
    #[arg(long, allow_negative_numbers = true)]
    gain: Option<f64>,
    /// The count that stands for zero [default: the middle].
    #[arg(long, allow_negative_numbers = true)]
    offset: Option<f64>,
    /// What the routines return [default: pow2 for q31, f32 for f32].
    #[arg(long, value_enum)]
    output: Option<OutputName>,
    /// What happens to readings outside the range.
    #[arg(long, value_enum, default_value = "clamp")]
    out_of_range: OutOfRangeName,
    /// Right shifts of negative numbers in C: none, or the compiler's.
    #[arg(long, value_enum, default_value = "strict")]
    c_shift: CShiftName,
    /// Name of crate, files and functions [default: corrected_angle; direct sensor: corrected_<unit>].
    #[arg(long)]
    name: Option<String>,
    /// The same as the command `check`.
    #[arg(long)]
    check: bool,
    /// Print nothing but errors.
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormatName {
    /// 32-bit integers, high words of products.
    Q31,
    /// The same from 16-bit halves, for cores without a long multiplication.
    Q31Split,
    /// 16-bit integers, 32-bit products.
    Q15,
    /// IEEE binary32.
    F32,
}

impl FormatName {
    fn format(self) -> Format {
        match self {
            FormatName::Q31 => Format::Q31,
            FormatName::Q31Split => Format::Q31Split,
            FormatName::Q15 => Format::Q15,
            FormatName::F32 => Format::F32 { fused: false },
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum CoreName {
    /// ARMv6-M.
    CortexM0,
    /// ARMv7-M.
    CortexM3,
    /// ARMv7E-M with single-precision floats.
    CortexM4f,
}

impl CoreName {
    fn core(self) -> Core {
        match self {
            CoreName::CortexM0 => Core::CortexM0,
            CoreName::CortexM3 => Core::CortexM3,
            CoreName::CortexM4f => Core::CortexM4f,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum InputName {
    /// The reading (s = x₂ − x₁ of a pair) as a float.
    F32,
    /// The reading as a Q31 word.
    Q31,
    /// The reading in counts.
    Counts,
    /// x₁ and x₂ as floats in millimetres.
    X1x2F32,
    /// x₁ and x₂ as Q31 words.
    X1x2Q31,
    /// x₁ and x₂ in counts.
    X1x2Counts,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum OutputName {
    /// An integer, a power-of-two fraction of the unit.
    Pow2,
    /// An integer, 10⁻⁹ of the unit: nanoradians.
    Nano,
    /// An integer, 10⁻⁶ of the unit.
    Micro,
    /// A float in the unit.
    F32,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum OutOfRangeName {
    /// The value at the nearest end.
    Clamp,
    /// The same, and the caller is told.
    Flag,
    /// Nothing: the formula continues there, without a bound but without overflow; saves instructions.
    Continue,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum CShiftName {
    /// Fully defined by C99.
    Strict,
    /// Arithmetic right shift, checked at compile time.
    Arithmetic,
}

/// Runs the program; the exit code is 0, or 1 where `check` found something stale.
///
/// # Errors
/// Anything that is wrong with the input, in a sentence; nothing is written then.
pub fn run(cli: Cli) -> Result<ExitCode> {
    match cli.command {
        Some(Command::Check(arguments)) => check(&arguments),
        Some(Command::Explore(arguments)) => explore(&arguments),
        Some(Command::Verify { arguments, checks }) => verify(&arguments, &checks),
        None if cli.arguments.check => check(&cli.arguments),
        None => write(&cli.arguments),
    }
}

fn write(arguments: &Arguments) -> Result<ExitCode> {
    let generated = prepare(arguments)?;
    let changed = files::write(&arguments.out, &generated.files).into_diagnostic()?;
    if !arguments.quiet {
        print!("{}", summary(&generated));
        println!("{}: {} files, {changed} changed", arguments.out.display(), generated.files.len());
    }
    Ok(ExitCode::SUCCESS)
}

fn check(arguments: &Arguments) -> Result<ExitCode> {
    let generated = prepare(arguments)?;
    let differences = files::compare(&arguments.out, &generated.files);
    if differences.is_empty() {
        if !arguments.quiet {
            println!("{}: {} files, all up to date", arguments.out.display(), generated.files.len());
        }
        return Ok(ExitCode::SUCCESS);
    }
    for (file, difference) in &differences {
        println!("{} {difference}", arguments.out.join(file).display());
    }
    println!("{} of {} files are stale: run codegen again", differences.len(), generated.files.len());
    Ok(ExitCode::from(1))
}

fn verify(arguments: &Arguments, checks: &CheckArguments) -> Result<ExitCode> {
    let (generated, quantity, options) = prepare_all(arguments)?;
    let bar = progress(arguments);
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent}% {per_sec} {eta}") {
        bar.set_style(style);
    }
    let wanted = Checks {
        exhaustive: checks.exhaustive,
        sanitize: checks.sanitize,
        gappa: checks.gappa,
        frama_c: checks.frama_c,
        misra: checks.misra,
        objects: checks.objects,
        mutants: checks.mutants,
    };
    let report = crate::verify::verify(&arguments.out, &generated, &quantity, &options, wanted, &bar)
        .map_err(|e| miette!("{e}"))?;
    bar.finish_and_clear();
    if checks.json {
        println!("{}", serde_json::to_string_pretty(&report).into_diagnostic()?);
    } else if !arguments.quiet || !report.holds() {
        print!("{}", report.text());
    }
    Ok(if report.holds() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn prepare(arguments: &Arguments) -> Result<Generated> {
    Ok(prepare_all(arguments)?.0)
}

fn prepare_all(arguments: &Arguments) -> Result<(Generated, Quantity, Options)> {
    let bar = progress(arguments);
    let (coefficients, sha256) = load(arguments)?;
    let quantity = Quantity::of(&coefficients.error_model());
    let mut options = options(arguments, &quantity.bound_unit)?;
    if let Some(target) = arguments.target {
        options.routines = vec![chosen(arguments, target.core(), &coefficients, &mut options, &bar)?];
    }
    bar.set_message("approximating and bounding");
    let generated = generate(&coefficients, &sha256, &options).map_err(|e| miette!("{e}"))?;
    bar.finish_and_clear();
    Ok((generated, quantity, options))
}

/// Progress on standard error, where that is a terminal.
fn progress(arguments: &Arguments) -> ProgressBar {
    let bar = ProgressBar::hidden();
    if !arguments.quiet && std::io::stderr().is_terminal() {
        bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar.set_message("reading");
    bar
}

fn load(arguments: &Arguments) -> Result<(Coefficients, String)> {
    let source = match (&arguments.coefficients, &arguments.recording, &arguments.mirror) {
        (Some(path), _, _) => Source::Coefficients(path.clone()),
        (None, Some(recording), Some(mirror)) => {
            Source::Recording { recording: recording.clone(), mirror: mirror.clone() }
        }
        _ => Source::Embedded,
    };
    source.load().map_err(|e| miette!("{e}"))
}

/// All candidates of the formats that the user named, or of all formats that both languages have.
fn candidates(
    arguments: &Arguments,
    coefficients: &Coefficients,
    options: &Options,
    bar: &ProgressBar,
) -> Result<Vec<Candidate>> {
    let formats = match &arguments.format[..] {
        [] => vec![Format::Q31, Format::Q31Split, Format::Q15, Format::F32 { fused: false }],
        named => named.iter().map(|name| name.format()).collect(),
    };
    bar.set_message("designing");
    let done = |through: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(through as u64);
    };
    explore::candidates(coefficients, options, ends(arguments)?, &formats, f64::MAX, &done)
        .map_err(|e| miette!("{e}"))
}

/// The routine that `--target` asks for; its degree is set in the options.
fn chosen(
    arguments: &Arguments,
    core: Core,
    coefficients: &Coefficients,
    options: &mut Options,
    bar: &ProgressBar,
) -> Result<RoutineOptions> {
    let quantity = Quantity::of(&coefficients.error_model());
    let range = options.range.unwrap_or((coefficients.valid_range.from, coefficients.valid_range.to));
    let bound = options.bound.unwrap_or_else(|| quantity.default_bound(range.0, range.1));
    let candidates = candidates(arguments, coefficients, options, bar)?;
    let best = explore::cheapest(&candidates, core, bound, arguments.flash_bytes, &quantity.bound_unit)
        .map_err(|e| miette!("{e}"))?;
    options.degree = Some(best.routine.design.degree);
    Ok(best.options.clone())
}

fn explore(arguments: &ExploreArguments) -> Result<ExitCode> {
    let common = &arguments.arguments;
    let bar = progress(common);
    let (coefficients, _) = load(common)?;
    let unit = Quantity::of(&coefficients.error_model()).bound_unit;
    let options = options(common, &unit)?;
    let candidates = candidates(common, &coefficients, &options, &bar)?;
    bar.finish_and_clear();
    let cores = common.target.map_or(Core::ALL.to_vec(), |target| vec![target.core()]);
    let rows = explore::rows(&candidates, &cores, &unit);
    if let Some(path) = &arguments.svg {
        let picture = plot::svg(&rows, &cores).into_diagnostic()?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = PathBuf::from(path.file_name().unwrap_or_default());
        files::write(folder, &[(name, picture)].into()).into_diagnostic()?;
    }
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&rows).into_diagnostic()?);
        return Ok(ExitCode::SUCCESS);
    }
    println!("{:<11} {:<22} {:>14} {:>13} {:>7}", "core", "routine", "bound", "instructions", "flash");
    for row in &rows {
        let bound = format!("{} {}", text::rounded_up(row.bound), row.unit);
        let (core, routine) = (row.core.name(), &row.routine);
        println!("{core:<11} {routine:<22} {bound:>14} {:>13.0} {:>7}", row.instructions, row.flash_bytes);
    }
    println!("\nBounds are proven; instructions and flash (bytes) are estimates.");
    Ok(ExitCode::SUCCESS)
}

fn options(arguments: &Arguments, unit: &str) -> Result<Options> {
    let bound = match (&arguments.bound_arcsec, &arguments.bound) {
        (Some(bound), _) if unit == "arcsec" => Some(*bound),
        (Some(_), _) => {
            return Err(miette!(
                "this sensor's bound is in {unit}: give --bound with its unit, 0.0001{unit}"
            ));
        }
        (None, Some(text)) => Some(bound_with_unit(text, unit)?),
        (None, None) => None,
    };
    let ends = ends(arguments)?;
    let method = arguments.table.as_deref().map_or(Ok(Method::Fused), table)?;
    let formats = match &arguments.format[..] {
        [] => Options::default().routines.iter().map(|r| r.format).collect(),
        named => named.iter().map(|name| name.format()).collect::<Vec<_>>(),
    };
    Ok(Options {
        routines: formats.into_iter().map(|format| ends.routine(method, format)).collect(),
        bound,
        degree: arguments.degree,
        range: arguments.from.zip(arguments.to),
        extrapolate: arguments.extrapolate,
        out_of_range: match arguments.out_of_range {
            OutOfRangeName::Clamp => OutOfRange::Clamp,
            OutOfRangeName::Flag => OutOfRange::Flag,
            OutOfRangeName::Continue => OutOfRange::Continue,
        },
        c_shift: match arguments.c_shift {
            CShiftName::Strict => CShift::Strict,
            CShiftName::Arithmetic => CShift::Arithmetic,
        },
        name: arguments.name.clone(),
        command: recorded_command(std::env::args().skip(1)),
    })
}

/// The input and output that the user named.
fn ends(arguments: &Arguments) -> Result<Ends> {
    let encoding = |probes: bool, name: InputName| -> Result<Encoding> {
        Ok(match name {
            InputName::F32 | InputName::X1x2F32 => Encoding::F32,
            InputName::Q31 | InputName::X1x2Q31 => Encoding::Q31 { full_scale: arguments.full_scale },
            InputName::Counts | InputName::X1x2Counts => {
                let Some(gain) = arguments.gain else {
                    return Err(miette!(
                        "counts need --gain, the change of the {} by one count",
                        if probes { "displacement" } else { "reading" }
                    ));
                };
                let middle = f64::from(1u32 << arguments.bits.clamp(1, 31).saturating_sub(1));
                Encoding::Counts { bits: arguments.bits, gain, offset: arguments.offset.unwrap_or(middle) }
            }
        })
    };
    let input = match arguments.input {
        None => None,
        Some(name) => {
            let probes = matches!(name, InputName::X1x2F32 | InputName::X1x2Q31 | InputName::X1x2Counts);
            let arity = if probes { Arity::Probes } else { Arity::Reading };
            Some(Input { arity, encoding: encoding(probes, name)? })
        }
    };
    let output = arguments.output.map(|name| match name {
        OutputName::Pow2 => Output::PowerOfTwo,
        OutputName::Nano => Output::Nano,
        OutputName::Micro => Output::Micro,
        OutputName::F32 => Output::F32,
    });
    let counts = matches!(input, Some(Input { encoding: Encoding::Counts { .. }, .. }));
    if !counts && (arguments.gain.is_some() || arguments.offset.is_some()) {
        return Err(miette!(
            "--gain and --offset belong to a converter's counts: add --input counts or x1x2-counts, or leave them out"
        ));
    }
    Ok(Ends { input, output, full_scale: arguments.full_scale })
}

/// `2x32`: the degree and the number of segments, a power of two.
fn table(text: &str) -> Result<Method> {
    let parts = text.split_once('x').and_then(|(d, n)| Some((d.parse().ok()?, n.parse::<u32>().ok()?)));
    match parts {
        Some((degree, segments)) if segments.is_power_of_two() => {
            Ok(Method::Piecewise { degree, segments_log2: segments.trailing_zeros() })
        }
        _ => Err(miette!(
            "--table {text}: give degree and number of segments, a power of two: for example 2x32"
        )),
    }
}

/// `0.01mm`: a number and the unit that the sensor has.
fn bound_with_unit(text: &str, unit: &str) -> Result<f64> {
    let digits = text.trim_end_matches(|c: char| c.is_alphabetic() || c == 'µ');
    let found = text[digits.len()..].trim();
    // An exponent's `e` belongs to the number.
    let value = digits.trim().parse::<f64>();
    match value {
        Ok(value) if found == unit => Ok(value),
        Ok(_) => Err(miette!(
            "--bound {text}: the unit is {found:?}, this sensor's is {unit:?}: give for example {digits}{unit}"
        )),
        Err(_) => Err(miette!("--bound {text}: not a number with a unit: give for example 0.01{unit}")),
    }
}

/// The command as it stands in the heads: without what does not change the files.
fn recorded_command(arguments: impl Iterator<Item = String>) -> String {
    let mut words = vec!["codegen".to_string()];
    let mut arguments = arguments.peekable();
    while let Some(word) = arguments.next() {
        match word.as_str() {
            "check" | "--check" | "verify" | "--exhaustive" | "--sanitize" | "--gappa" | "--frama-c"
            | "--misra" | "--objects" | "--mutants" | "--json" | "-q" | "--quiet" => {}
            "--out" => {
                arguments.next();
            }
            other if other.starts_with("--out=") => {}
            other if other.contains(char::is_whitespace) => words.push(format!("'{other}'")),
            _ => words.push(word),
        }
    }
    words.join(" ")
}

/// What was chosen and why, on one screen.
fn summary(generated: &Generated) -> String {
    let mut lines = String::new();
    for (routine, entry) in generated.routines.iter().zip(generated.certificate.routines.iter().step_by(2)) {
        let degree = routine.design.degree;
        let line = format!(
            "{:<24} degree {degree:>2}   proven within {} {}   best of this degree {:.2e}\n",
            entry.routine,
            text::rounded_up(entry.bound),
            entry.unit,
            entry.minimax,
        );
        lines.push_str(&line);
    }
    lines
}
