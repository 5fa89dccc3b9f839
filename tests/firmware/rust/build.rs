//! What is built: the routine under test, named by environment variables, and the board's memory.
//!
//! ROUTINE: its name. ARGUMENT: type of its arguments; ARGUMENTS: how many, 1 or 2. RESULT: type of its value.
//! SECOND: type of the second argument. STATE: 1 where it is a type that keeps a state, with `new` and `update`.
//! FLAG: 1 where it tells readings outside the range. EMPTY: 1 for the firmware without the routine.

use std::path::Path;
use std::{env, fs};

fn main() {
    let given = |name: &str, usual: &str| {
        println!("cargo:rerun-if-env-changed={name}");
        env::var(name).unwrap_or_else(|_| usual.into())
    };
    let argument = given("ARGUMENT", "i32");
    let state = given("STATE", "0") == "1";
    let named = format!(
        "use generated::{} as {};\npub type Argument = {argument};\n{}pub type Value = {};\n",
        given("ROUTINE", "corrected_angle_q31"),
        if state { "GeneratedRoutine" } else { "generated_routine" },
        match given("ARGUMENTS", "1") == "1" {
            true => String::new(),
            false => format!("pub type Second = {};\n", given("SECOND", &argument)),
        },
        given("RESULT", "i32")
    );
    for condition in ["one_argument", "float", "halves", "flag", "empty", "state"] {
        println!("cargo:rustc-check-cfg=cfg({condition})");
    }
    let one_argument = given("ARGUMENTS", "1") == "1";
    let conditions = [
        ("one_argument", one_argument),
        ("float", argument == "f32"),
        ("halves", argument == "u16" && !one_argument),
        ("flag", given("FLAG", "0") == "1"),
        ("empty", given("EMPTY", "0") == "1"),
        ("state", state),
    ];
    for (condition, _) in conditions.iter().filter(|(_, holds)| *holds) {
        println!("cargo:rustc-cfg={condition}");
    }
    let out = env::var("OUT_DIR").expect("set by cargo");
    fs::write(Path::new(&out).join("named.rs"), named).expect("OUT_DIR can be written");

    let manifest = env::var("CARGO_MANIFEST_DIR").expect("set by cargo");
    let scripts = given("LINKER_SCRIPTS", &format!("{manifest}/../c"));
    let target = env::var("TARGET").expect("set by cargo");
    let board = match target.split('-').next() {
        Some("thumbv6m") => "microbit",
        Some("thumbv8m.main") => "mps2_an505",
        _ => "mps2",
    };
    println!("cargo:rustc-link-search={scripts}");
    println!("cargo:rustc-link-arg=-T{board}.ld");
    println!("cargo:rerun-if-changed={scripts}");
}
