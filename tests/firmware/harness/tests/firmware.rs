//! Generated routines on an emulated microcontroller. `.ci/firmware` runs all cases; here a few, so that
//! `cargo test` stays short, and controls that the checks can fail.

use std::path::Path;
use std::process::Command;

use firmware_tests::build::{self, Variant};
use firmware_tests::cases::{self, Case};
use firmware_tests::comparison;
use firmware_tests::machine::{self, Core, Sweep};
use firmware_tests::problem::Problem;
use firmware_tests::subject::{self, Shift, Subject};
use firmware_tests::{Task, perform, tools};
use indicatif::ProgressBar;

/// Whether the tools are there. Where one is missing, one line says which and how to install it; under
/// continuous integration that is a failure.
fn equipped() -> bool {
    match tools::find() {
        Ok(()) => true,
        Err(problem) => {
            assert!(!tools::is_ci(), "{problem}");
            println!("skipped: firmware under QEMU; {problem}");
            false
        }
    }
}

/// Outputs as on the host, and instructions, flash and stack as in the committed table.
#[test]
fn one_polynomial_on_every_core() {
    if equipped() {
        perform(Task::Check, "q31-degree-9", None, &ProgressBar::hidden()).unwrap();
    }
}

fn generated(name: &str, work: &Path) -> Subject {
    let all = cases::all().unwrap();
    let case: &Case = all.iter().find(|c| c.name == name).unwrap();
    subject::generate(&subject::codegen().unwrap(), case, Shift::Strict, &work.join("generated")).unwrap()
}

const SWEEP: Sweep = Sweep { first: 0, count: 1 << 16, stride: 65_521 };

/// A coefficient that is off by one in its last place changes the digest on the target.
#[test]
fn a_wrong_coefficient_is_noticed() {
    if !equipped() {
        return;
    }
    let work = tempfile::tempdir().unwrap();
    let subject = generated("q31-degree-9", work.path());
    let right =
        machine::on_host("", &build::host(&subject, &work.path().join("host")).unwrap(), &[SWEEP]).unwrap();

    let source = subject.folder.join("c/angle.c");
    let text = std::fs::read_to_string(&source).unwrap();
    let (_, constants) = text.split_once("] = {").unwrap();
    let (constants, _) = constants.split_once('}').unwrap();
    // Behind the two limits, c9 and c8.
    let number = constants.split(',').nth(6).unwrap().trim();
    let off_by_one = number.parse::<i32>().unwrap() + 1;
    std::fs::write(&source, text.replacen(number, &off_by_one.to_string(), 1)).unwrap();

    let variant = Variant::C { compiler: "gcc", shift: Shift::Strict };
    let firmware = build::firmware(&subject, Core::M4f, variant, false, &work.path().join("wrong")).unwrap();
    let found = machine::emulate("", Core::M4f, &firmware, "sweep", &[SWEEP]).unwrap();
    assert_ne!(found, right);
}

/// The digest of the firmware's C is that of its Rust, and of inputs one by one.
#[test]
fn digests_add_up() {
    if !equipped() {
        return;
    }
    let work = tempfile::tempdir().unwrap();
    let subject = generated("f32-degree-9", work.path());
    let variant = Variant::Rust { level: "3" };
    let firmware = build::firmware(&subject, Core::M3, variant, false, &work.path().join("rust")).unwrap();
    let whole = machine::emulate("", Core::M3, &firmware, "sweep", &[SWEEP]).unwrap();
    let half = SWEEP.count / 2;
    let second = Sweep { first: (half as u32).wrapping_mul(SWEEP.stride), count: half, ..SWEEP };
    let parts = [Sweep { count: half, ..SWEEP }, second];
    assert_eq!(machine::emulate("", Core::M3, &firmware, "sweep", &parts).unwrap(), whole);
    let host = build::host(&subject, &work.path().join("host")).unwrap();
    assert_eq!(machine::on_host("", &host, &[SWEEP]).unwrap(), whole);
}

/// The multiply-accumulate of cores with the DSP extension stands in what every compiler makes, once for each step of
/// Horner's scheme; on a core without it there is the portable text.
#[test]
fn the_multiply_accumulate_is_used_where_it_is() {
    if !equipped() {
        return;
    }
    let work = tempfile::tempdir().unwrap();
    let subject = generated("q31-degree-9", work.path());
    let variants = [
        Variant::C { compiler: "gcc", shift: Shift::Strict },
        Variant::C { compiler: "clang", shift: Shift::Strict },
        Variant::Rust { level: "3" },
    ];
    for (core, steps) in [(Core::M4f, 9), (Core::M3, 0)] {
        for variant in variants {
            let place = work.path().join(format!("{}-{}", core.name(), variant.name().replace(' ', "-")));
            let firmware = build::firmware(&subject, core, variant, false, &place).unwrap();
            let disassembled =
                Command::new("arm-none-eabi-objdump").arg("-d").arg(&firmware).output().unwrap();
            let text = String::from_utf8(disassembled.stdout).unwrap();
            assert!(text.contains("<nothing>"), "{variant:?}");
            let found = text.lines().filter(|line| line.contains("smmla")).count();
            assert_eq!(found, steps, "{variant:?}");
        }
    }
}

/// A fault on the target is an error, not a digest.
#[test]
fn a_refused_command_is_an_error() {
    if !equipped() {
        return;
    }
    let work = tempfile::tempdir().unwrap();
    let subject = generated("q31-degree-9", work.path());
    let variant = Variant::C { compiler: "clang", shift: Shift::Strict };
    let firmware = build::firmware(&subject, Core::M0, variant, false, &work.path().join("c")).unwrap();
    let refused = machine::emulate("", Core::M0, &firmware, "unknown", &[SWEEP]);
    assert!(matches!(refused, Err(Problem::Refused { .. })), "{refused:?}");
}

/// Needs no tool: the page is what the committed figures say, and these support what it claims.
#[test]
fn the_comparison_holds() {
    let rows = comparison::page::committed().unwrap();
    assert!(rows.iter().filter(|r| !r.ours).count() >= 5 && rows.iter().any(|r| r.ours));
    // The control: ours as costly as the library, and every alternative is unbeaten.
    let mut costly = rows;
    costly.iter_mut().filter(|r| r.ours).for_each(|r| r.gcc.average = 5_000);
    let alternatives = costly.iter().filter(|r| !r.ours).count();
    assert_eq!(comparison::page::unbeaten(&costly).len(), alternatives);
}
