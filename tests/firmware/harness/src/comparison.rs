//! Generated routines beside what engineers write otherwise, counted on Cortex-M4F in one run.
//!
//! The alternatives are the C files of `tests/firmware/comparison`; their numbers are computed here from the
//! model of Eq. 12. Worst errors are measured on the host, all in the same way; instructions under QEMU.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use minijinja::{Environment, context};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::build;
use crate::cases::{self, Case, Device};
use crate::machine::{self, Core, Sweep};
use crate::problem::Problem;
use crate::run::run;
use crate::subject::{self, NAME, PAPER_RANGE_MM, Shift, Subject};
use crate::table;

/// What a Q31 word's 2³¹ stands for in this comparison, in millimetres, where an entry does not say otherwise.
const FULL_SCALE_MM: f64 = 0.5;

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

/// Function, what it is, type in C, radians of one unit.
const ALTERNATIVES: [(&str, &str, &str, f64); 5] = [
    ("eq13_double", "Eq. 13 in double precision, atan", "double", 1.0),
    ("eq13_float", "Eq. 13 in single precision, atanf", "float", 1.0),
    ("table_linear", "table of 1024 floats, linear", "float", 1.0),
    ("table_quadratic", "table of 64 parabolas, float", "float", 1.0),
    (
        "linear_interp_q31",
        "table of 1025 words, as CMSIS-DSP's linear_interp_q31",
        "int32_t",
        1.0 / 8_589_934_592.0,
    ),
];

/// What we set beside them.
const OURS: [(&str, &[&str]); 10] = [
    ("one polynomial, q31", &["--format", "q31", "--degree", "9"]),
    ("one polynomial, f32", &["--format", "f32", "--degree", "9"]),
    ("table 3x16, q31", &["--format", "q31", "--table", "3x16", "--full-scale", "0.76"]),
    ("table 3x32, q31", &["--format", "q31", "--table", "3x32"]),
    ("table 2x32, q31", &["--format", "q31", "--table", "2x32", "--full-scale", "0.76"]),
    ("table 2x128, q31", &["--format", "q31", "--table", "2x128", "--full-scale", "0.76"]),
    (
        "one polynomial, q31, no limits",
        &["--format", "q31", "--full-scale", "0.4", "--out-of-range", "continue"],
    ),
    ("table 2x128, q31, no limits", &["--format", "q31", "--table", "2x128", "--out-of-range", "continue"]),
    ("table 1x1024, q31, no limits", &["--format", "q31", "--table", "1x1024", "--out-of-range", "continue"]),
    ("table 1x256, q31", &["--format", "q31", "--table", "1x256", "--full-scale", "0.76"]),
];

/// Measures all of them.
///
/// # Errors
/// The first [`Problem`] that was met.
pub fn measure(work: &Path) -> Result<Vec<Row>, Problem> {
    let numbers = work.join("numbers");
    write_numbers(&numbers)?;
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

fn alternative((function, what, c_type, lsb_rad): (&str, &str, &str, f64)) -> Contender {
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
        full_scale_mm: (c_type == "int32_t").then_some(FULL_SCALE_MM),
        lsb_rad,
        bound_arcsec: None,
    }
}

fn ours(codegen: &Path, what: &str, options: &[&str], folder: &Path) -> Result<Contender, Problem> {
    let mut options: Vec<String> = options.iter().map(|o| o.to_string()).collect();
    let given =
        options.iter().position(|o| o == "--full-scale").and_then(|at| options.get(at + 1)?.parse().ok());
    if given.is_none() {
        options.extend(["--full-scale".into(), FULL_SCALE_MM.to_string()]);
    }
    let full_scale_mm = given.unwrap_or(FULL_SCALE_MM);
    let case = Case { name: what.into(), coefficients: Some(Device::Paper), options };
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
        flash_bytes: build::flash_bytes(&with)? - build::flash_bytes(&without)?,
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
        ("FLAGS", format!("-I{} {flags}", numbers.display())),
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

/// The numbers of the alternatives' tables, from the model.
fn write_numbers(folder: &Path) -> Result<(), Problem> {
    std::fs::create_dir_all(folder).map_err(Problem::file(folder))?;
    let model = subject::paper_model();
    let angle = |s_mm: f64| model.corrected(s_mm);
    let write = |name: &str, numbers: &[String]| {
        let path = folder.join(name);
        std::fs::write(&path, numbers.join(",\n") + "\n").map_err(Problem::file(&path))
    };
    let float = |value: f64| format!("{:e}f", value as f32);
    let coefficients: Vec<String> = model.coefficients.iter().map(|a| format!("{a:e}")).collect();
    write("coefficients.inc", &coefficients)?;
    let rounded: Vec<String> = model.coefficients.iter().map(|a| float(*a)).collect();
    write("coefficients_f32.inc", &rounded)?;
    let at = |fraction: f64, half_mm: f64| half_mm * (2.0 * fraction - 1.0);
    let linear = |i: u32| float(angle(at(f64::from(i) / 1023.0, PAPER_RANGE_MM)));
    write("linear.inc", &(0..1024).map(linear).collect::<Vec<_>>())?;
    let words =
        |i: u32| format!("{}", (angle(at(f64::from(i) / 1024.0, FULL_SCALE_MM)) * 2f64.powi(33)).round());
    write("words.inc", &(0..=1024).map(words).collect::<Vec<_>>())?;
    let parabola = |i: u32| {
        // Through the three Chebyshev nodes of the segment, which is nearly the best.
        let node = |k: u32| 0.5 - 0.5 * (f64::from(2 * k + 1) * std::f64::consts::PI / 6.0).cos();
        let value = |t: f64| angle(at((f64::from(i) + t) / 64.0, PAPER_RANGE_MM));
        let [t0, t1, t2] = [node(0), node(1), node(2)];
        let slope = (value(t1) - value(t0)) / (t1 - t0);
        let c2 = ((value(t2) - value(t1)) / (t2 - t1) - slope) / (t2 - t0);
        let c1 = slope - c2 * (t0 + t1);
        let c0 = value(t0) - t0 * (c1 + t0 * c2);
        format!("{{ {}, {}, {} }}", float(c0), float(c1), float(c2))
    };
    write("quadratic.inc", &(0..64).map(parabola).collect::<Vec<_>>())
}

/// The committed figures.
pub fn path() -> PathBuf {
    cases::folder().join("comparison.json")
}

/// The page for people.
pub fn page() -> PathBuf {
    cases::folder().join("../../docs/comparison.md")
}

/// Renders the page.
///
/// # Errors
/// [`Problem::Content`] where the template is defective.
pub fn render(rows: &[Row]) -> Result<String, Problem> {
    let path = cases::folder().join("comparison/page.md.jinja");
    let template = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let power = |value: f64| format!("{value:.1e}");
    let cells = |row: &Row| {
        context! {
            what => &*row.what, ours => row.ours,
            gcc => described(&row.gcc), clang => described(&row.clang),
            flash => row.flash_bytes, stack => row.stack_bytes,
            worst => power(row.worst_arcsec), bound => row.bound_arcsec.map(power),
        }
    };
    let rows: Vec<minijinja::Value> = rows.iter().map(cells).collect();
    let text = Environment::new().render_str(&template, context! { rows });
    text.map(|t| t + "\n").map_err(|e| Problem::Content { path, message: format!("{e:#}") })
}

fn described(count: &Count) -> String {
    let mut text = count.average.to_string();
    if count.fewest != count.most {
        let _ = write!(text, " ({}…{})", count.fewest, count.most);
    }
    text
}

/// What the page claims, checked: every alternative is beaten by one routine of ours in instructions (both
/// compilers) and in error; double precision in instructions only, a hundredfold. Gives what does not hold.
pub fn unbeaten(rows: &[Row]) -> Vec<String> {
    let ours: Vec<&Row> = rows.iter().filter(|r| r.ours).collect();
    let beaten = |row: &&Row| {
        ours.iter().any(|our| {
            if row.what.contains("double") {
                row.gcc.average >= 100 * our.gcc.average
            } else {
                our.gcc.average < row.gcc.average
                    && our.clang.average < row.clang.average
                    && our.worst_arcsec < row.worst_arcsec
            }
        })
    };
    rows.iter()
        .filter(|r| !r.ours)
        .filter(|r| !beaten(r))
        .map(|r| format!("{} is not beaten", r.what))
        .collect()
}

/// Writes the figures and the page.
///
/// # Errors
/// [`Problem::File`] where they cannot be written.
pub fn write(rows: &[Row]) -> Result<(), Problem> {
    let page = page();
    if let Some(folder) = page.parent() {
        std::fs::create_dir_all(folder).map_err(Problem::file(folder))?;
    }
    table::write_json(&path(), &rows)?;
    table::write_text(&page, &render(rows)?)
}

/// Holds `found` against the committed figures and the page against them; figures of other compilers than
/// `instructions.json` was made by are not compared.
///
/// # Errors
/// [`Problem::Figures`] with what differs, or which alternative is not beaten.
pub fn check(found: &[Row], same_compilers: bool) -> Result<(), Problem> {
    let lost = unbeaten(found);
    if !lost.is_empty() {
        return Err(Problem::Figures(lost.join("\n")));
    }
    let path = path();
    let text = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let committed: Vec<Row> = serde_json::from_str(&text)
        .map_err(|e| Problem::Content { path: path.clone(), message: e.to_string() })?;
    let again = "run cargo run --release -p firmware-tests -- compare --write";
    let shown = std::fs::read_to_string(page()).map_err(Problem::file(page()))?;
    if shown != render(&committed)? {
        return Err(Problem::Figures(format!(
            "docs/comparison.md is not what comparison.json says: {again}"
        )));
    }
    if same_compilers && committed != found {
        let differs =
            |(before, now): (&Row, &Row)| (before != now).then(|| format!("now {now:?}\nwas {before:?}"));
        let lines: Vec<String> = committed.iter().zip(found).filter_map(differs).collect();
        return Err(Problem::Figures(format!("the comparison differs; {again}\n{}", lines.join("\n"))));
    }
    Ok(())
}
