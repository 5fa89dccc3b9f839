//! Compiles the C pair in `generated/c` with every warning an error; the tests link it.

fn main() {
    let folder = "../generated/c";
    println!("cargo::rerun-if-changed={folder}");
    cc::Build::new()
        .file(format!("{folder}/corrected_angle.c"))
        .std("c99")
        .warnings(true)
        .extra_warnings(true)
        .flag("-Wconversion")
        .flag("-pedantic")
        .flag("-Werror")
        .compile("corrected_angle_c");
}
