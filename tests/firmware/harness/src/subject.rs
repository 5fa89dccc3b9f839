//! Generates a routine with the `codegen` program, as a user does, and reads its signature and bound from the
//! certificate.

use std::path::{Path, PathBuf};
use std::process::Command;

use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Operator, Play, Product, Scope, Term};
use serde_json::Value;

use crate::cases::{Case, Device};
use crate::problem::Problem;
use crate::run::run;

/// Name of the generated crate and files.
pub const NAME: &str = "angle";

/// Right shifts in the generated C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shift {
    /// Fully defined.
    Strict,
    /// The compiler's.
    Arithmetic,
}

impl Shift {
    /// As on codegen's command line.
    pub fn name(self) -> &'static str {
        match self {
            Shift::Strict => "strict",
            Shift::Arithmetic => "arithmetic",
        }
    }
}

/// A generated routine.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The case's name.
    pub case: String,
    /// Folder of the crate; the C files are in `c`.
    pub folder: PathBuf,
    /// The function's name.
    pub routine: String,
    /// Rust type of the arguments.
    pub argument: String,
    /// How many arguments.
    pub arguments: usize,
    /// Rust type of the second argument, where there are two.
    pub second: String,
    /// Whether it keeps a state from call to call.
    pub state: bool,
    /// Rust type of the value.
    pub result: String,
    /// What one unit of an integer result is, in radians; 1 for a float.
    pub lsb_rad: f64,
    /// Whether the polynomial is evaluated in floats.
    pub in_floats: bool,
    /// Smallest and largest valid reading, in millimetres.
    pub range_mm: (f64, f64),
    /// What a Q31 word's 2³¹ stands for, in millimetres.
    pub full_scale_mm: f64,
    /// Whether readings outside the range are reported.
    pub flag: bool,
    /// The proven bound in arcseconds.
    pub bound_arcsec: f64,
}

impl Subject {
    /// The type in C.
    pub fn c_type(rust: &str) -> &'static str {
        match rust {
            "f32" => "float",
            "u16" => "uint16_t",
            "u32" => "uint32_t",
            "i16" => "int16_t",
            _ => "int32_t",
        }
    }

    /// Inputs, by their number, next to which something changes: the ends of the range and of the type; of
    /// floats also both zeros, the infinities and what is no number.
    pub fn ends(&self) -> Vec<u32> {
        let (from, to) = self.range_mm;
        match (self.argument.as_str(), self.arguments) {
            ("f32", _) => {
                vec![(from as f32).to_bits(), (to as f32).to_bits(), 0, 1 << 31, 0x7f80_0000, 0xff80_0000]
            }
            ("i32", _) => {
                let word = |mm: f64| (mm / self.full_scale_mm * 2f64.powi(31)).round() as i32 as u32;
                vec![word(from), word(to), 0, 1 << 31]
            }
            // Sixteen bits are swept wholly; of wider counts the type has more than a converter.
            _ => vec![0, 1 << 24, 1 << 31],
        }
    }

    /// What decides how firmware around it looks, the routine itself apart.
    pub fn signature(&self) -> String {
        let plain = format!("{}-{}-{}-{}", self.argument, self.arguments, self.result, u8::from(self.flag));
        if self.state { format!("{plain}-{}-state", self.second) } else { plain }
    }

    /// The name by which Rust calls it.
    pub fn rust_name(&self) -> String {
        let capital = |word: &str| {
            let mut letters = word.chars();
            letters.next().map(|c| c.to_ascii_uppercase()).into_iter().chain(letters).collect::<String>()
        };
        match self.state {
            true => self.routine.split('_').map(capital).collect(),
            false => self.routine.clone(),
        }
    }
}

/// The device of Eq. 12.
pub fn paper_model() -> ErrorModel {
    ErrorModel {
        sensor: Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 },
        centre: 0.0,
        coefficients: vec![-6.15e-5, 0.1439, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4],
    }
}

/// What a diagnosis of such a device may add: three terms that firmware corrects.
fn terms() -> Vec<Term> {
    let term = |effect: &str, operator, coefficients| Term {
        effect: effect.into(),
        scope: Scope::Device,
        operator,
        coefficients,
        covariance: Vec::new(),
    };
    let temperature = || Product::of("temperature_c", 25.0);
    let gain = temperature().times("angle_arcsec", 0.0, 1);
    let plays = Play::of("angle_arcsec", &[250.0, 900.0, 2100.0]);
    vec![
        term("thermal_zero_drift", Operator::Product(temperature()), vec![0.35]),
        term("thermal_gain_drift", Operator::Product(gain), vec![2.1e-5]),
        term("hysteresis", Operator::Play(plays), vec![0.004, 0.003, 0.002]),
    ]
}

/// Half the range of the paper's device in millimetres.
pub const PAPER_RANGE_MM: f64 = 0.38;

/// Builds the program `codegen` with the features of the whole workspace, so that nothing is compiled twice, and gives its path.
///
/// # Errors
/// [`Problem::Refused`] where it does not build.
pub fn codegen() -> Result<PathBuf, Problem> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../Cargo.toml");
    let arguments = [
        "build",
        "--release",
        "-q",
        "--workspace",
        "--bin",
        "codegen",
        "--message-format",
        "json",
        "--manifest-path",
    ];
    let messages = run("building codegen", Command::new(cargo).args(arguments).arg(manifest))?;
    let executable = messages.lines().rev().find_map(|line| {
        let message: Value = serde_json::from_str(line).ok()?;
        let is_codegen = message["target"]["name"] == "codegen";
        is_codegen.then(|| message["executable"].as_str().map(PathBuf::from)).flatten()
    });
    executable.ok_or_else(|| Problem::Content {
        path: "cargo's messages".into(),
        message: "no executable of codegen among them".into(),
    })
}

/// Generates `case` into `folder`.
///
/// # Errors
/// [`Problem`] where codegen refuses, or where its certificate is not one of one routine.
pub fn generate(codegen: &Path, case: &Case, shift: Shift, folder: &Path) -> Result<Subject, Problem> {
    std::fs::create_dir_all(folder).map_err(Problem::file(folder))?;
    let mut command = Command::new(codegen);
    command.args(["--quiet", "--name", NAME, "--c-shift", shift.name(), "--out"]).arg(folder);
    if let Some(device) = case.coefficients {
        let mut file = Coefficients::of_model(&paper_model(), -PAPER_RANGE_MM, PAPER_RANGE_MM, "Eq. 12");
        if device == Device::PaperWithTerms {
            file.terms = terms();
        }
        let path = folder.with_extension("json");
        let text = serde_json::to_string_pretty(&file)
            .map_err(|e| Problem::Content { path: path.clone(), message: e.to_string() })?;
        std::fs::write(&path, text).map_err(Problem::file(&path))?;
        command.arg("--coefficients").arg(path);
    } else {
        command.arg("--demo");
    }
    run(&format!("generating {}", case.name), command.args(&case.options))?;
    read_certificate(case, folder)
}

fn read_certificate(case: &Case, folder: &Path) -> Result<Subject, Problem> {
    let path = folder.join("certificate.json");
    let wrong = |message: &str| Problem::Content { path: path.clone(), message: message.into() };
    let text = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let certificate: Value = serde_json::from_str(&text).map_err(|e| wrong(&e.to_string()))?;
    let routines = certificate["routines"].as_array().ok_or_else(|| wrong("it has no list of routines"))?;
    let of_rust: Vec<&Value> = routines.iter().filter(|r| r["language"] == "rust").collect();
    let [entry] = of_rust[..] else {
        return Err(wrong("a case has one routine: give one --format"));
    };
    let text_of = |value: &Value| value.as_str().map(str::to_string);
    let arguments = entry["input"].as_array().map_or(0, Vec::len);
    let path = folder.join(format!("c/{NAME}.h"));
    let header = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let subject = || {
        let range = &entry["range"];
        let range_mm = (range["from"].as_f64()?, range["to"].as_f64()?);
        Some(Subject {
            case: case.name.clone(),
            folder: folder.to_path_buf(),
            routine: text_of(&entry["routine"])?,
            argument: text_of(&entry["input"][0]["type"])?,
            arguments,
            second: text_of(&entry["input"][arguments.min(2).saturating_sub(1)]["type"])?,
            state: header.contains("_state;"),
            result: text_of(&entry["output"]["type"])?,
            lsb_rad: entry["output"]["lsb"].as_f64()?,
            in_floats: entry["format"].as_str()?.starts_with("f32"),
            range_mm,
            full_scale_mm: full_scale_mm(case, range_mm),
            flag: entry["out_of_range"] == "flag",
            bound_arcsec: entry["bound"].as_f64()?,
        })
    };
    subject().ok_or_else(|| wrong("an entry lacks routine, input, output or bound"))
}

/// As given, or codegen's own: the smallest power of two that holds the range.
fn full_scale_mm(case: &Case, (from, to): (f64, f64)) -> f64 {
    let after = case.options.iter().skip_while(|o| *o != "--full-scale").nth(1);
    let given = after.and_then(|o| o.parse().ok());
    given.unwrap_or_else(|| f64::max(from.abs(), to.abs()).log2().ceil().exp2())
}
