//! The paper's table on simulated mirrors: calibrated, fitted, generated, and verified with the generated q31
//! routine in the loop. `cargo run --release -p arcsmith-tests --example paper` prints the distribution.

use arcsmith_tests::native::Native;
use arcsmith_tests::paper::{
    Outcome, calibration, campaign, curve, displacement_word, loop_options, share, verification,
};
use arcsmith_tests::toolchain::{C_COMPILERS, available};
use codegen::generate::generate;
use codegen::interpret::{Word, interpret};
use codegen::options::OutOfRange;
use fitter::Mirror;

#[test]
fn the_papers_figures_come_out_of_some_devices() {
    the_papers_figures_come_out(60);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn the_papers_figures_come_out_of_many_devices() {
    the_papers_figures_come_out(200);
}

/// Of so many devices, the seeds from 1.
fn the_papers_figures_come_out(seeds: u64) {
    let outcomes = campaign(seeds);
    let reaches = |what: &str, wanted: f64, holds: &dyn Fn(&Outcome) -> bool| {
        let found = share(&outcomes, holds);
        println!("{what}: {:.1} % of {seeds} devices (at least {:.0} %)", 100.0 * found, 100.0 * wanted);
        assert!(found >= wanted, "{what}: {found}, expected {wanted}");
    };
    reaches("before 0.28 deg", 1.0, &|o| (0.275..0.285).contains(&o.before_deg));
    reaches("order within 7 to 11", 0.80, &|o| (7..=11).contains(&o.order));
    reaches("fit error of the averaged points below 0.5 arcsec", 0.55, &|o| o.fit_error < 0.5);
    reaches("mean error of every point in ±1.3 deg below 1.1 arcsec", 0.85, &|o| o.mean_error < 1.1);
    reaches("standard deviation of every point below 1.2 arcsec", 0.98, &|o| o.deviation < 1.2);
    reaches("bound within 0.01 arcsec", 1.0, &|o| o.bound <= 0.01);

    // Figure 6: both errors are large below order 3; the training error falls on and on, the testing error
    // rises again beyond the orders that are chosen and leaves the training error behind.
    let errors: Vec<(f64, f64)> = (1..=15).map(|order| curve(&outcomes, order).unwrap()).collect();
    let (training, testing) = (|n: usize| errors[n - 1].0, |n: usize| errors[n - 1].1);
    let least = (1..=15).map(testing).fold(f64::INFINITY, f64::min);
    for order in 1..3 {
        assert!(training(order) > 5.0 * least && testing(order) > 5.0 * least, "order {order}: {errors:?}");
    }
    assert!((2..=15).all(|order| training(order) <= training(order - 1)), "{errors:?}");
    let best = (1..=15).min_by(|a, b| testing(*a).total_cmp(&testing(*b))).unwrap();
    assert!((7..=11).contains(&best), "the least testing error is at order {best}: {errors:?}");
    assert!(testing(15) > 1.2 * least && testing(15) > 1.5 * training(15), "{errors:?}");
}

/// In the loop the compiled routines are the interpreted one: the same recording, to the digit.
#[test]
fn compiled_routines_in_the_loop_give_the_same_recording() {
    let device = twin::Device::from_seed(1);
    let fit = fitter::fit(&calibration(&device, 1), &Mirror::paper(), &fitter::Options::default()).unwrap();
    let generated = generate(&fit.coefficients, "", &loop_options()).unwrap();
    let entry = &generated.certificate.routines[0];
    let design = &generated.routines[0].design;
    let lsb_rad = entry.output.lsb;
    let by_interpreter = verification(&device, 1, &|x1, x2| {
        let words = [Word::Int(x1.into()), Word::Int(x2.into())];
        interpret(&design.program, &words).unwrap().word.bits() as f64 * lsb_rad
    });
    let by = |native: &Native| {
        verification(&device, 1, &|x1, x2| {
            f64::from(native.run(&[[x1 as u32, x2 as u32]])[0].bits as i32) * lsb_rad
        })
    };
    assert_eq!(by(&Native::rust(&generated.files, entry)), by_interpreter);
    for compiler in C_COMPILERS {
        if available(compiler, "generated C in the loop") {
            let c = Native::c(&generated.files, entry, OutOfRange::Clamp, compiler);
            assert_eq!(by(&c), by_interpreter, "{compiler}");
        }
    }
    // The corrected angle lands on the command: the words' own resolution is some 10⁻⁵ arcsec.
    let landed = by_interpreter.iter().all(|r| {
        let words = [r.x1_mm, r.x2_mm].map(|x| Word::Int(displacement_word(x).into()));
        let angle_rad = interpret(&design.program, &words).unwrap().word.bits() as f64 * lsb_rad;
        (angle_rad.to_degrees() - r.command_deg).abs() * 3600.0 < 0.3
    });
    assert!(landed);
}
