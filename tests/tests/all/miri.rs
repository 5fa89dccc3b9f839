//! The committed generation under Miri, which watches for undefined behaviour in Rust, where Miri is to be had.

use std::fs;
use std::process::Command;

use arcsmith_tests::programs::root;

const MAIN: &str = include_str!("../../shim/miri.rs");

#[test]
fn the_committed_generation_is_clean_under_miri() {
    let miri = |arguments: &[&str]| {
        let mut command = Command::new("cargo");
        command.args(["+nightly", "miri"]).args(arguments);
        // What the cargo of this test set for its own toolchain.
        for variable in ["CARGO", "RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN", "CARGO_TARGET_DIR", "RUSTFLAGS"] {
            command.env_remove(variable);
        }
        command
    };
    if !miri(&["--version"]).output().is_ok_and(|o| o.status.success()) {
        println!(
            "skipped: the generated Rust under Miri; rustup toolchain install nightly --component miri,rust-src"
        );
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let generated = root().join("generated").canonicalize().unwrap();
    let manifest = format!(
        "[package]\nname = \"under_miri\"\nversion = \"0.0.0\"\nedition = \"2021\"\n\n[dependencies]\n\
         corrected_angle = {{ path = {:?} }}\n\n[workspace]\n",
        generated.display().to_string()
    );
    fs::create_dir(folder.path().join("src")).unwrap();
    fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
    fs::write(folder.path().join("src/main.rs"), MAIN).unwrap();
    let output = miri(&["run", "--quiet"]).current_dir(folder.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "4096 calls\n", "{said}");
}
