//! Generated routines beside what engineers write otherwise, counted on Cortex-M4F in one run.
//!
//! The alternatives are the C files of `tests/firmware/comparison`; their numbers are computed here from the
//! model of Eq. 12. Worst errors are measured on the host, all in the same way; instructions under QEMU.

use std::path::{Path, PathBuf};
use std::process::Command;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::build;
use crate::cases::{self, Case, Device};
use crate::machine::{self, Core, Sweep};
use crate::problem::Problem;
use crate::run::run;
use crate::subject::{self, NAME, PAPER_RANGE_MM, Shift, Subject};

pub mod numbers;
pub mod page;

/// What a Q31 word's 2³¹ stands for in this comparison, in millimetres, where an entry does not say otherwise.
pub const FULL_SCALE_MM: f64 = 0.5;

/// Instructions of a call, without call and return.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Count {
    /// Fewest.
    pub fewest: u64,
    /// On average over even readings, rounded.
    pub average: u64,
    /// Most.
    pub most: u64,
}

/// One way to compute the corrected angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What it is.
    pub what: String,
    /// Whether it was generated.
    pub ours: bool,
    /// As gcc translates it.
    pub gcc: Count,
    /// As clang does.
    pub clang: Count,
    /// What it adds to a firmware that gcc translates, with all that it calls.
    pub flash_bytes: u64,
    /// What it takes of the stack, translated by gcc.
    pub stack_bytes: u64,
    /// Largest error seen over 2²⁰ even readings, to three digits.
    pub worst_arcsec: f64,
    /// The proven bound; none for what was not generated.
    pub bound_arcsec: Option<f64>,
}

/// How something is compiled and called.
struct Contender {
    what: String,
    ours: bool,
    settings: Vec<(&'static str, String)>,
    source: PathBuf,
    include: PathBuf,
    routine: String,
    /// What an integer argument's 2³¹ stands for, in millimetres; none for a float.
    full_scale_mm: Option<f64>,
    lsb_rad: f64,
    bound_arcsec: Option<f64>,
}

/// Function, what it is, type in C, radians of one unit, and what an integer argument's 2³¹ stands for in millimetres.
type Alternative = (&'static str, &'static str, &'static str, f64, Option<f64>);
const ALTERNATIVES: [Alternative; 7] = [
    ("eq13_double", "Eq. 13 in double precision, atan", "double", 1.0, None),
    ("eq13_float", "Eq. 13 in single precision, atanf", "float", 1.0, None),
    ("table_linear", "table of 1024 floats, linear", "float", 1.0, None),
    ("table_quadratic", "table of 64 parabolas, float", "float", 1.0, None),
    (
        "linear_interp_q31",
        "table of 1025 words, as CMSIS-DSP's linear_interp_q31",
        "int32_t",
        1.0 / 8_589_934_592.0,
        Some(FULL_SCALE_MM),
    ),
    ("horner_smmla", "polynomial of degree 9, smmla by hand", "int32_t", 1.0 / 8_589_934_592.0, Some(0.4)),
    (
        "parabolas_smmla",
        "table of 32 parabolas, smmla by hand",
        "int32_t",
        1.0 / 4_294_967_296.0,
        Some(2.0 * PAPER_RANGE_MM),
    ),
];

/// What we set beside them.
const OURS: [(&str, &[&str]); 13] = [
    ("chosen for cortex-m4f within 1e-2″", &["--target", "cortex-m4f", "--bound-arcsec", "1e-2"]),
    ("chosen for cortex-m4f within 1e-3″", &["--target", "cortex-m4f", "--bound-arcsec", "1e-3"]),
    ("chosen for cortex-m4f within 1e-4″", &["--target", "cortex-m4f", "--bound-arcsec", "1e-4"]),
    ("one polynomial, q31", &["--format", "q31", "--degree", "9"]),
    ("one polynomial, f32", &["--format", "f32", "--degree", "9"]),
    ("table 3x16, q31", &["--format", "q31", "--table", "3x16", "--full-scale", "0.76"]),
    ("table 3x32, q31", &["--format", "q31", "--table", "3x32"]),
    ("table 2x32, q31", &["--format", "q31", "--table", "2x32", "--full-scale", "0.76"]),
    ("table 2x128, q31", &["--format", "q31", "--table", "2x128", "--full-scale", "0.76"]),
    (
        "one polynomial, q31, without limits",
        &["--format", "q31", "--full-scale", "0.4", "--out-of-range", "continue"],
    ),
    (
        "table 2x128, q31, without limits",
        &["--format", "q31", "--table", "2x128", "--out-of-range", "continue"],
    ),
    (
        "table 1x1024, q31, without limits",
        &["--format", "q31", "--table", "1x1024", "--out-of-range", "continue"],
    ),
    ("table 1x256, q31", &["--format", "q31", "--table", "1x256", "--full-scale", "0.76"]),
];

/// Measures all of them.
///
/// # Errors
/// The first [`Problem`] that was met.
pub fn measure(work: &Path) -> Result<Vec<Row>, Problem> {
    let numbers = work.join("numbers");
    numbers::write(&numbers)?;
    let plugin = build::plugin(work)?;
    let mut contenders: Vec<Contender> = ALTERNATIVES.iter().map(|a| alternative(*a)).collect();
    let codegen = subject::codegen()?;
    for (index, (what, options)) in OURS.iter().enumerate() {
        contenders.push(ours(&codegen, what, options, &work.join(format!("ours-{index}")))?);
    }
    contenders
        .par_iter()
        .enumerate()
        .map(|(index, contender)| row(contender, &numbers, &plugin, &work.join(format!("row-{index}"))))
        .collect()
}

fn alternative((function, what, c_type, lsb_rad, full_scale_mm): Alternative) -> Contender {
    let folder = cases::folder().join("comparison");
    Contender {
        what: what.into(),
        ours: false,
        settings: vec![
            ("NAME", "alternatives".into()),
            ("ARGUMENT", c_type.into()),
            ("RESULT", c_type.into()),
        ],
        source: folder.join(format!("{function}.c")),
        include: folder,
        routine: function.into(),
        full_scale_mm,
        lsb_rad,
        bound_arcsec: None,
    }
}

fn ours(codegen: &Path, what: &str, options: &[&str], folder: &Path) -> Result<Contender, Problem> {
    let mut options: Vec<String> = options.iter().map(|o| o.to_string()).collect();
    let given =
        options.iter().position(|o| o == "--full-scale").and_then(|at| options.get(at + 1)?.parse().ok());
    // A choice takes the scale by which one instruction limits.
    let free = options.iter().any(|o| o == "--target").then_some(2.0 * PAPER_RANGE_MM);
    if given.or(free).is_none() {
        options.extend(["--full-scale".into(), FULL_SCALE_MM.to_string()]);
    }
    let full_scale_mm = given.or(free).unwrap_or(FULL_SCALE_MM);
    let case = Case::new(what, Some(Device::Paper), options);
    let subject = subject::generate(codegen, &case, Shift::Strict, folder)?;
    let include = folder.join("c");
    Ok(Contender {
        what: what.into(),
        ours: true,
        settings: vec![
            ("NAME", NAME.into()),
            ("ARGUMENT", Subject::c_type(&subject.argument).into()),
            ("RESULT", Subject::c_type(&subject.result).into()),
        ],
        source: include.join(format!("{NAME}.c")),
        include,
        full_scale_mm: (subject.argument == "i32").then_some(full_scale_mm),
        routine: subject.routine,
        lsb_rad: subject.lsb_rad,
        bound_arcsec: Some(three_digits(subject.bound_arcsec)),
    })
}

fn row(contender: &Contender, numbers: &Path, plugin: &Path, out: &Path) -> Result<Row, Problem> {
    let (gcc, stack_bytes) = count(contender, "gcc", numbers, plugin, out)?;
    let (clang, _) = count(contender, "clang", numbers, plugin, out)?;
    let with = compile(contender, "gcc", &contender.routine, "", numbers, &out.join("flash"))?;
    let without = compile(contender, "gcc", "nothing", "", numbers, &out.join("empty"))?;
    Ok(Row {
        what: contender.what.clone(),
        ours: contender.ours,
        gcc,
        clang,
        flash_bytes: build::bytes(&with)?.0 - build::bytes(&without)?.0,
        stack_bytes,
        worst_arcsec: worst(contender, numbers, out)?,
        bound_arcsec: contender.bound_arcsec,
    })
}

fn compile(
    contender: &Contender,
    compiler: &str,
    routine: &str,
    flags: &str,
    numbers: &Path,
    out: &Path,
) -> Result<PathBuf, Problem> {
    let mut settings = vec![
        ("CORE", Core::M4f.name().to_string()),
        ("COMPILER", compiler.into()),
        ("GENERATED", contender.include.display().to_string()),
        ("SOURCES", contender.source.display().to_string()),
        ("ROUTINE", routine.into()),
        // Or clang calls a function for `fmaf`, for what that may do to errno.
        ("FLAGS", format!("-fno-math-errno -I{} {flags}", numbers.display())),
        ("OUT", out.display().to_string()),
    ];
    settings.extend(contender.settings.iter().cloned());
    build::make(&format!("compiling {} with {compiler}", contender.what), &settings)?;
    Ok(out.join("firmware.elf"))
}

fn count(
    contender: &Contender,
    compiler: &str,
    numbers: &Path,
    plugin: &Path,
    out: &Path,
) -> Result<(Count, u64), Problem> {
    let calls = 1021u32;
    // Words are the readings' own; of floats, the numbers 0 … 2³² − 1 are spread over the range.
    let (flags, sweep) = if let Some(full_scale_mm) = contender.full_scale_mm {
        let most = (PAPER_RANGE_MM / full_scale_mm * 2_147_483_648.0) as i32;
        (String::new(), Sweep { first: -most as u32, count: calls.into(), stride: most as u32 / (calls / 2) })
    } else {
        (
            format!("-DEVEN={PAPER_RANGE_MM}"),
            Sweep { first: 0, count: calls.into(), stride: u32::MAX / calls },
        )
    };
    let firmware = compile(contender, compiler, &contender.routine, &flags, numbers, &out.join(compiler))?;
    let (seen, call, stack) =
        machine::observe(&contender.what, Core::M4f, &firmware, plugin, &contender.routine, &[sweep])?;
    let count = Count {
        fewest: seen.fewest - call.fewest,
        average: (seen.sum + seen.calls / 2) / seen.calls - call.fewest,
        most: seen.most - call.fewest,
    };
    Ok((count, stack))
}

/// Compiles for the host and gives the largest error in arcseconds.
fn worst(contender: &Contender, numbers: &Path, out: &Path) -> Result<f64, Problem> {
    let program = out.join("worst");
    let of = |name: &str| contender.settings.iter().find(|(n, _)| *n == name).map_or("", |(_, value)| value);
    let mut command = Command::new("gcc");
    command
        .args(["-O2", "-std=c11", "-ffp-contract=off"])
        .arg(format!("-I{}", numbers.display()))
        .arg(format!("-I{}", contender.include.display()))
        .arg(format!("-DHEADER=\"{}.h\"", of("NAME")))
        .arg(format!("-DROUTINE={}", contender.routine))
        .arg(format!("-DARGUMENT={}", of("ARGUMENT")))
        .arg(format!("-DLSB={:e}L", contender.lsb_rad));
    if let Some(full_scale_mm) = contender.full_scale_mm {
        command.arg(format!("-DFULL_SCALE={full_scale_mm}L"));
    }
    command.arg("-o").arg(&program);
    command.arg(cases::folder().join("comparison/worst.c")).arg(&contender.source).arg("-lm");
    run("compiling for the host", &mut command)?;
    let text = run(&contender.what, &mut Command::new(&program))?;
    let worst = text.trim().parse::<f64>();
    worst.map(three_digits).map_err(|e| Problem::Content { path: program, message: e.to_string() })
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
