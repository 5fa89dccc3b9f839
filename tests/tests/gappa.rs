//! Every method and format has a Gappa script that proves the certificate's rounding, and none that proves less.

use std::time::Instant;

use arcsmith_tests::toolchain::available;
use codegen::format::Format;
use codegen::gappa;
use codegen::options::{Method, Options, OutOfRange, RoutineOptions};
use codegen::render::Renderer;
use codegen::routine;
use codegen::source::Source;
use codegen::verify::external::run_gappa;

/// Time for a script that must hold, and for one that must not: too tight a goal makes Gappa split on and on.
const SECONDS: u64 = 60;
const CONTROL_SECONDS: u64 = 2;

fn variants() -> Vec<RoutineOptions> {
    let table = |degree, segments_log2| Method::Piecewise { degree, segments_log2 };
    let fused = Format::ALL.into_iter().map(RoutineOptions::of);
    let tables = [Format::Q31, Format::Q31Split].into_iter().flat_map(|format| {
        [table(1, 8), table(2, 5), table(3, 4), table(1, 12)]
            .map(|method| RoutineOptions { method, ..RoutineOptions::of(format) })
    });
    fused.chain(tables).collect()
}

#[test]
fn every_format_and_table_is_proved_by_gappa() {
    if !available("gappa", "proofs by Gappa; apt-get install gappa") {
        return;
    }
    let renderer = Renderer::new().unwrap();
    let (coefficients, _) = Source::Embedded.load().unwrap();
    for wanted in variants() {
        let options = Options {
            routines: vec![wanted.clone()],
            bound: Some(f64::MAX),
            degree: (wanted.method == Method::Fused).then_some(9),
            out_of_range: OutOfRange::Clamp,
            ..Options::default()
        };
        let routine =
            routine::design(&coefficients, &options, &wanted).unwrap_or_else(|e| panic!("{wanted:?}: {e}"));
        let text = gappa::script(&renderer, &routine, "routine", "").unwrap();
        let text = text.unwrap_or_else(|| panic!("{wanted:?}: no script"));
        let folder = tempfile::tempdir().unwrap();
        let script = folder.path().join("routine.g");
        std::fs::write(&script, &text).unwrap();
        let started = Instant::now();
        assert_eq!(run_gappa(&script, SECONDS).unwrap(), Some(Ok(())), "{wanted:?}");
        println!("{}: {:.2} s", wanted.suffix(), started.elapsed().as_secs_f64());

        // The control: nine tenths of the rounding, which in fixed point is nearly reached, is not proved.
        let bound = routine.design.bound.rounding;
        let (before, claim) = text.rsplit_once("<= ").unwrap();
        let after = claim.split_once('}').unwrap().1;
        let tight = folder.path().join("tight.g");
        std::fs::write(&tight, format!("{before}<= {} }}{after}", 0.9 * bound)).unwrap();
        assert_ne!(run_gappa(&tight, CONTROL_SECONDS).unwrap(), Some(Ok(())), "{wanted:?}");
    }
}
