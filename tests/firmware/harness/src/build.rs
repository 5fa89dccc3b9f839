//! Compiles firmware around a generated routine.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cases::folder;
use crate::machine::Core;
use crate::problem::Problem;
use crate::run::run;
use crate::subject::{NAME, Shift, Subject};

/// How a routine is compiled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// C by `gcc` or `clang`, at -O2.
    C {
        /// Which of the two.
        compiler: &'static str,
        /// Which C.
        shift: Shift,
    },
    /// Rust, at this `opt-level`.
    Rust {
        /// `3`, or `z`, which projects for microcontrollers usually set.
        level: &'static str,
    },
}

impl Variant {
    /// All of them.
    pub const ALL: [Variant; 6] = [
        Variant::C { compiler: "gcc", shift: Shift::Strict },
        Variant::C { compiler: "clang", shift: Shift::Strict },
        Variant::C { compiler: "gcc", shift: Shift::Arithmetic },
        Variant::C { compiler: "clang", shift: Shift::Arithmetic },
        Variant::Rust { level: "3" },
        Variant::Rust { level: "z" },
    ];

    /// As in the table.
    pub fn name(self) -> String {
        match self {
            Variant::C { compiler, shift } => format!("C {compiler} {}", shift.name()),
            Variant::Rust { level } => format!("Rust {level}"),
        }
    }

    /// The symbol whose calls are counted.
    pub fn symbol(self, subject: &Subject) -> String {
        match self {
            Variant::C { .. } if subject.state => format!("{}_update", subject.routine),
            Variant::C { .. } => subject.routine.clone(),
            Variant::Rust { .. } => "routine".into(),
        }
    }
}

/// Where a firmware is built.
pub fn place(work: &Path, subject: &Subject, core: Core, variant: Variant, empty: bool) -> PathBuf {
    let variant = variant.name().replace(' ', "-");
    let what = if empty { format!("empty-{}", subject.signature()) } else { subject.case.clone() };
    work.join(format!("{what}-{}-{variant}", core.name()))
}

/// Builds firmware into `out` and gives its file; `empty`: without the routine.
///
/// # Errors
/// [`Problem::Refused`] with the compiler's messages.
pub fn firmware(
    subject: &Subject,
    core: Core,
    variant: Variant,
    empty: bool,
    out: &Path,
) -> Result<PathBuf, Problem> {
    match variant {
        Variant::C { compiler, .. } => c(subject, core.name(), compiler, empty, out),
        Variant::Rust { level } => rust(subject, core, level, empty, out),
    }
}

/// Builds the same program for the host.
///
/// # Errors
/// [`Problem::Refused`] with the compiler's messages.
pub fn host(subject: &Subject, out: &Path) -> Result<PathBuf, Problem> {
    c(subject, "host", "gcc", false, out)
}

fn c(subject: &Subject, core: &str, compiler: &str, empty: bool, out: &Path) -> Result<PathBuf, Problem> {
    let routine = if empty { "nothing" } else { &subject.routine };
    let settings = [
        ("CORE", core.to_string()),
        ("COMPILER", compiler.to_string()),
        ("GENERATED", subject.folder.join("c").display().to_string()),
        ("NAME", NAME.to_string()),
        ("ROUTINE", routine.to_string()),
        ("ARGUMENT", Subject::c_type(&subject.argument).to_string()),
        ("ARGUMENTS", subject.arguments.to_string()),
        ("SECOND", Subject::c_type(&subject.second).to_string()),
        ("STATE", if subject.state { u8::from(empty) + 1 } else { 0 }.to_string()),
        ("RESULT", Subject::c_type(&subject.result).to_string()),
        ("FLAG", u8::from(subject.flag).to_string()),
        ("OUT", out.display().to_string()),
    ];
    make(&format!("compiling {} for {core} with {compiler}", subject.case), &settings)?;
    Ok(out.join("firmware.elf"))
}

/// Runs the Makefile of the C firmware.
///
/// # Errors
/// [`Problem::Refused`] with the compiler's messages.
pub fn make(what: &str, settings: &[(&str, String)]) -> Result<(), Problem> {
    let settings = settings.iter().map(|(name, value)| format!("{name}={value}"));
    // A make above this one must not pass its flags on.
    let mut command = Command::new("make");
    command.env_remove("MAKEFLAGS").arg("-s").arg("-C").arg(folder().join("c")).args(settings);
    run(what, &mut command).map(|_| ())
}

/// The files of the Rust firmware; its manifest apart, they are taken as they are.
const RUST_FILES: [&str; 7] = [
    "build.rs",
    "src/main.rs",
    "src/inputs.rs",
    "src/observe.rs",
    "src/routine.rs",
    "src/semihosting.rs",
    "src/start.rs",
];

/// What the committed manifest depends on; another generated crate takes its place.
const DEPENDENCY: &str = r#"path = "../../../generated", package = "corrected_angle""#;

fn rust(subject: &Subject, core: Core, level: &str, empty: bool, out: &Path) -> Result<PathBuf, Problem> {
    let from = folder().join("rust");
    std::fs::create_dir_all(out.join("src")).map_err(Problem::file(out))?;
    for file in RUST_FILES {
        std::fs::copy(from.join(file), out.join(file)).map_err(Problem::file(from.join(file)))?;
    }
    let path = from.join("Cargo.toml");
    let manifest = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    if manifest.matches(DEPENDENCY).count() != 1 {
        return Err(Problem::Content { path, message: format!("it does not say {DEPENDENCY} once") });
    }
    let generated = format!("path = {:?}, package = {NAME:?}", subject.folder.display().to_string());
    let manifest = manifest.replace(DEPENDENCY, &generated);
    std::fs::write(out.join("Cargo.toml"), manifest).map_err(Problem::file(out))?;

    let target = out.join("target");
    let mut command = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()));
    command
        .current_dir(out)
        .args(["build", "-q", "--release", "--target", core.rust_target(), "--target-dir"])
        .arg(&target)
        .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", level)
        .env("LINKER_SCRIPTS", folder().join("c"))
        .env("ROUTINE", subject.rust_name())
        .env("SECOND", &subject.second)
        .env("STATE", u8::from(subject.state).to_string())
        .env("ARGUMENT", &subject.argument)
        .env("ARGUMENTS", subject.arguments.to_string())
        .env("RESULT", &subject.result)
        .env("FLAG", u8::from(subject.flag).to_string())
        .env("EMPTY", u8::from(empty).to_string());
    // What a cargo above this one set for its own build. (Incremental builds do not inline across modules.)
    command.env("CARGO_INCREMENTAL", "0");
    for variable in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET", "CARGO_TARGET_DIR"] {
        command.env_remove(variable);
    }
    run(&format!("compiling {} for {} as Rust", subject.case, core.name()), &mut command)?;
    Ok(target.join(core.rust_target()).join("release/firmware"))
}

/// Bytes of flash that a firmware takes (code, constants and the initial values of data), and of memory for data.
///
/// # Errors
/// [`Problem`] where `arm-none-eabi-size` does not tell.
pub fn bytes(firmware: &Path) -> Result<(u64, u64), Problem> {
    let text = run("measuring flash", Command::new("arm-none-eabi-size").arg(firmware))?;
    let line = text.lines().nth(1).unwrap_or_default();
    let mut columns = line.split_whitespace().map(|c| c.parse::<u64>().ok());
    match [(); 3].map(|()| columns.next().flatten()) {
        [Some(text), Some(data), Some(bss)] => Ok((text + data, data + bss)),
        _ => Err(Problem::Content { path: firmware.into(), message: format!("size says {line:?}") }),
    }
}

/// Builds the plugin that counts instructions.
///
/// # Errors
/// [`Problem::Refused`] with the compiler's messages.
pub fn plugin(out: &Path) -> Result<PathBuf, Problem> {
    let library = out.join("observe.so");
    let source = folder().join("plugin/observe.c");
    let flags = ["-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-fvisibility=hidden", "-o"];
    run("compiling the plugin", Command::new("gcc").args(flags).arg(&library).arg(source))?;
    Ok(library)
}
