//! The tools that firmware needs, and how to get those that are missing.

use std::process::Command;

use crate::machine::Core;
use crate::problem::Problem;

/// A program, and Debian's package that holds it.
const PROGRAMS: [(&str, &str); 7] = [
    ("make", "make"),
    ("gcc", "gcc"),
    ("clang", "clang"),
    ("arm-none-eabi-gcc", "gcc-arm-none-eabi"),
    ("arm-none-eabi-size", "binutils-arm-none-eabi"),
    ("arm-none-eabi-nm", "binutils-arm-none-eabi"),
    ("qemu-system-arm", "qemu-system-arm"),
];

/// Looks for every tool.
///
/// # Errors
/// [`Problem::Missing`]: in one line, what is missing and how to install it.
pub fn find() -> Result<(), Problem> {
    let mut missing = Vec::new();
    let mut packages = Vec::new();
    let mut need = |program: &str, package: &str| {
        missing.push(program.to_string());
        if !packages.contains(&package.to_string()) {
            packages.push(package.to_string());
        }
    };
    for (program, package) in PROGRAMS {
        if Command::new(program).arg("--version").output().is_err() {
            need(program, package);
        }
    }
    if Command::new("arm-none-eabi-gcc").arg("--version").output().is_ok() && !has_libm() {
        need("math.h for Arm", "libnewlib-arm-none-eabi");
    }
    let absent = absent_targets();
    missing.extend(absent.iter().map(|t| format!("Rust's {t}")));
    if missing.is_empty() {
        return Ok(());
    }
    let mut commands = Vec::new();
    if !packages.is_empty() {
        commands.push(format!("apt-get install -y --no-install-recommends {}", packages.join(" ")));
    }
    if !absent.is_empty() {
        commands.push(format!("rustup target add {}", absent.join(" ")));
    }
    Err(Problem::Missing(format!("missing: {}; install with: {}", missing.join(", "), commands.join(" && "))))
}

fn has_libm() -> bool {
    let answer = Command::new("arm-none-eabi-gcc").arg("-print-file-name=libm.a").output();
    answer.is_ok_and(|o| String::from_utf8_lossy(&o.stdout).trim().contains('/'))
}

/// Targets without a compiled `core`.
fn absent_targets() -> Vec<&'static str> {
    let has = |target: &&str| {
        let folder = Command::new("rustc").args(["--print", "target-libdir", "--target", target]).output();
        folder.is_ok_and(|o| std::fs::read_dir(String::from_utf8_lossy(&o.stdout).trim()).is_ok())
    };
    let mut targets: Vec<&str> = Core::ALL.iter().map(|c| c.rust_target()).filter(|t| !has(t)).collect();
    targets.dedup();
    targets
}

/// The compilers' versions, on which counted figures depend.
///
/// # Errors
/// [`Problem::Refused`] where one does not tell.
pub fn versions() -> Result<Vec<(String, String)>, Problem> {
    let first_line = |program: &str| {
        let text = crate::run::run("asking for a version", Command::new(program).arg("--version"))?;
        Ok((program.to_string(), text.lines().next().unwrap_or_default().trim().to_string()))
    };
    ["arm-none-eabi-gcc", "clang", "rustc"].into_iter().map(first_line).collect()
}

/// Whether this is a run that must not leave anything out.
pub fn is_ci() -> bool {
    std::env::var("CI").is_ok_and(|v| v == "true")
}
