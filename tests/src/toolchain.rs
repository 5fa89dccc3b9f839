//! The compilers that the tests call.

use std::process::{Command, Stdio};

/// The C compilers that the generated sources must satisfy.
pub const C_COMPILERS: [&str; 2] = ["gcc", "clang"];

/// What the generated C is compiled with.
pub const C_FLAGS: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"];

/// Whether `tool` can be called. Where it cannot, one line says what is skipped for it; under continuous
/// integration (`CI=true`) a missing tool is a failure.
///
/// # Panics
/// Under continuous integration, where the tool is missing.
pub fn available(tool: &str, skipped: &str) -> bool {
    let found = Command::new(tool)
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    assert!(
        found || std::env::var("CI").as_deref() != Ok("true"),
        "{tool} is missing, needed for: {skipped}"
    );
    if !found {
        println!("skipped: {skipped} ({tool} is not installed)");
    }
    found
}
