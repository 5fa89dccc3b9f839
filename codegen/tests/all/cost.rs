//! The cost model against instructions that were counted on the cores (`tests/firmware/instructions.json`).

use codegen::cost::Core;
use codegen::format::Format;
use codegen::options::OutOfRange::{Clamp, Continue};
use codegen::options::{Ends, Method, Options};
use codegen::routine;
use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};

/// The device of Eq. 12 over |s| ≤ 0.38 mm.
fn paper() -> Coefficients {
    let model = ErrorModel {
        sensor: Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 },
        centre: 0.0,
        coefficients: vec![-6.15e-5, 0.1439, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4],
    };
    Coefficients::of_model(&model, -0.38, 0.38, "by hand")
}

#[test]
fn estimates_are_as_close_to_the_counts_as_they_claim() {
    let text = std::fs::read_to_string("../tests/firmware/instructions.json").unwrap();
    let counted: serde_json::Value = serde_json::from_str(&text).unwrap();
    let table = |degree, segments_log2| Method::Piecewise { degree, segments_log2, padded: false, place: None };
    let f32 = Format::F32;
    let mut seen = Vec::new();
    for (name, method, format, full_scale, out_of_range) in [
        ("q31-degree-9", Method::Fused, Format::Q31, Some(0.4), Clamp),
        ("q31-degree-9-without-limits", Method::Fused, Format::Q31, Some(0.4), Continue),
        ("q31-degree-9-every-word", Method::Fused, Format::Q31, Some(0.38), Clamp),
        ("q31-split-degree-9", Method::Fused, Format::Q31Split, Some(0.4), Clamp),
        ("f32-degree-9", Method::Fused, f32, None, Clamp),
        ("q31-table-1x256", table(1, 8), Format::Q31, Some(0.76), Clamp),
        ("q31-table-2x32", table(2, 5), Format::Q31, Some(0.76), Clamp),
        ("q31-table-2x32-without-limits", table(2, 5), Format::Q31, Some(0.4), Continue),
        ("q31-table-3x16", table(3, 4), Format::Q31, Some(0.76), Clamp),
        ("q31-split-table-3x16", table(3, 4), Format::Q31Split, None, Clamp),
    ] {
        let wanted = Ends { full_scale, ..Ends::default() }.routine(method, format);
        let options = Options { degree: Some(9), bound: Some(1.0), out_of_range, ..Options::default() };
        let routine = routine::design(&paper(), &options, &wanted).unwrap();
        for (core, key) in [(Core::CortexM0, "m0"), (Core::CortexM3, "m3"), (Core::CortexM4f, "m4f")] {
            let inside = &counted["routines"][name][key]["C gcc strict"]["inside"];
            let (fewest, most) = (inside[0].as_f64().unwrap(), inside[1].as_f64().unwrap());
            let estimate = core.cost(&routine.design.program).instructions;
            seen.push((name, key, estimate / (0.5 * (fewest + most)) - 1.0));
        }
    }
    let worst = seen.iter().map(|(_, _, error)| error.abs()).fold(0.0, f64::max);
    assert!(worst <= Core::RELATIVE_ERROR, "{seen:?}");
    // The claim is not idle either.
    assert!(worst >= 0.4 * Core::RELATIVE_ERROR, "{seen:?}");
}
