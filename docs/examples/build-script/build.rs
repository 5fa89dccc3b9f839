//! Generates a routine that is proven within 0.01″; the build fails where none is. `target` in place of `formats` would
//! choose the cheapest for a core: a search that takes minutes where build scripts are not optimised.

use std::error::Error;

use codegen::format::Format;
use codegen::input::{Arity, Encoding, Input};
use codegen::options::Ends;
use codegen::output::Output;

fn main() -> Result<(), Box<dyn Error>> {
    let out_dir = std::env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR for build scripts")?;
    // A 16-bit converter for each probe, 15.26 nm a count.
    let counts = Encoding::Counts { bits: 16, gain: 1.526e-5, offset: 32768.0 };
    let input = Input { arity: Arity::Probes, encoding: counts };
    codegen::Builder::new()
        .coefficients("coefficients.json")
        .formats([Format::Q31])
        .bound_arcsec(0.01)
        .ends(Ends { input: Some(input), output: Some(Output::Nano), full_scale: None })
        .name("corrected_angle")
        .write_to(out_dir)?;
    Ok(())
}
