//! The generated Rust with overflow checks and debug assertions on, and, so that these see everything, every
//! `wrapping_` operation that is not meant to wrap made a `strict_` one: no input panics, and outputs are the same.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use arcsmith_tests::native::unpacked;
use codegen::format::Format;
use codegen::generate::{Generated, generate};
use codegen::input::{Arity, Encoding, Input};
use codegen::options::{Method, Options, OutOfRange, RoutineOptions};
use codegen::output::Output as Ending;
use codegen::source::Source;

const PLAIN: [&str; 1] = ["-Copt-level=2"];
const CHECKED: [&str; 3] = ["-Copt-level=2", "-Coverflow-checks=on", "-Cdebug-assertions=on"];

fn rustc(arguments: &[&str], folder: &Path) {
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(&compiler).args(arguments).current_dir(folder).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.is_empty(), "{arguments:?}:\n{text}");
}

/// Compiles a generation with `flags` and sweeps its routine.
fn swept(files: &BTreeMap<PathBuf, String>, routine: &str, flags: &[&str]) -> Output {
    let folder = unpacked(files);
    let shim = |name: &str| {
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("shim").join(name)).unwrap()
    };
    let caller = shim("batch.rs") + &shim("sweep.rs");
    let caller = caller.replace("angle::ROUTINE", &format!("angle::{routine}"));
    fs::write(folder.path().join("sweep.rs"), caller).unwrap();
    let library = ["--edition=2021", "--crate-type=rlib", "--crate-name=angle", "src/lib.rs"];
    rustc(&[&library, flags].concat(), folder.path());
    let program = ["--edition=2021", "--extern=angle=libangle.rlib", "-o", "sweep", "sweep.rs"];
    rustc(&[&program, flags].concat(), folder.path());
    Command::new(folder.path().join("sweep")).output().unwrap()
}

/// A sum of products from halves that is computed modulo 2³², and what it stands for.
const MODULO: [&str; 2] = [
    "    let factor = ((b & 0xffff) >> 1).wrapping_sub(half_b1 << 16);
    let sum = a.wrapping_mul(half_b1).wrapping_add(a1.wrapping_mul(factor));",
    "    let sum = a1.wrapping_mul((b & 0xffff) >> 1).wrapping_add((a & 0xffff).wrapping_mul(half_b1));",
];

/// The sources with every operation that must not overflow made one that panics where it does. A table's segment and
/// the place in it come from sums that are meant to wrap.
fn strict(files: &BTreeMap<PathBuf, String>) -> BTreeMap<PathBuf, String> {
    let meant = |line: &str| line.contains("let segment = ") || line.contains("let w = ");
    let one = |line: &str| if meant(line) { line.into() } else { line.replace(".wrapping_", ".strict_") };
    let source = |text: &String| {
        let text = text.replace(MODULO[0], MODULO[1]);
        text.lines().map(one).collect::<Vec<String>>().join("\n") + "\n"
    };
    let is_source = |path: &Path| path.extension().is_some_and(|e| e == "rs");
    files.iter().map(|(p, t)| (p.clone(), if is_source(p) { source(t) } else { t.clone() })).collect()
}

fn variants() -> Vec<Options> {
    let table = |format, degree, segments_log2| RoutineOptions {
        method: Method::Piecewise { degree, segments_log2, padded: false, place: None },
        ..RoutineOptions::of(format)
    };
    let counts = Encoding::Counts { bits: 16, gain: 1.2207e-5, offset: 32768.0 };
    let input = Input { arity: Arity::Probes, encoding: counts };
    let wanted = [
        (RoutineOptions::of(Format::Q31), OutOfRange::Clamp),
        (RoutineOptions::of(Format::Q31), OutOfRange::Continue),
        (RoutineOptions::of(Format::Q31Split), OutOfRange::Clamp),
        (RoutineOptions::of(Format::Q15), OutOfRange::Flag),
        (RoutineOptions::of(Format::F32), OutOfRange::Clamp),
        (RoutineOptions { output: Ending::F32, ..RoutineOptions::of(Format::Q31) }, OutOfRange::Clamp),
        (RoutineOptions { input, output: Ending::Nano, ..RoutineOptions::of(Format::Q31) }, OutOfRange::Flag),
        (table(Format::Q31, 1, 8), OutOfRange::Clamp),
        (table(Format::Q31, 2, 5), OutOfRange::Continue),
        (table(Format::Q31Split, 3, 4), OutOfRange::Clamp),
    ];
    wanted
        .into_iter()
        .map(|(routine, out_of_range)| Options {
            degree: (routine.method == Method::Fused).then_some(9),
            routines: vec![routine],
            bound: Some(f64::MAX),
            out_of_range,
            ..Options::default()
        })
        .collect()
}

fn generated(options: &Options) -> Generated {
    let (coefficients, sha256) = Source::Embedded.load().unwrap();
    generate(&coefficients, &sha256, options).unwrap_or_else(|e| panic!("{options:?}: {e}"))
}

#[test]
fn no_input_overflows() {
    for options in variants() {
        let generated = generated(&options);
        let routine = &generated.certificate.routines[0].routine;
        let plain = swept(&generated.files, routine, &PLAIN);
        let files = strict(&generated.files);
        assert!(
            files.values().all(|text| !text.contains("let factor = ")),
            "{options:?}: a sum is written otherwise"
        );
        let checked = swept(&files, routine, &CHECKED);
        let said = String::from_utf8_lossy(&checked.stderr);
        assert!(checked.status.success(), "{options:?}: {said}");
        assert_eq!(checked.stdout, plain.stdout, "{options:?}");
        assert_eq!(plain.stdout.len(), 17, "a digest of 16 digits");
    }
}

/// The control: with its last coefficient near the end of the word, a sum overflows, and that is seen.
#[test]
fn an_overflow_is_seen() {
    let options = &variants()[0];
    let generated = generated(options);
    let entry = &generated.certificate.routines[0];
    let mut files = strict(&generated.files);
    let source = files.get_mut(Path::new(&entry.file)).unwrap();
    let line = source.lines().find(|l| l.contains("// c0 = ")).unwrap().to_string();
    let from = line.rfind(".strict_add(").unwrap() + ".strict_add(".len();
    let to = from + line[from..].find(')').unwrap();
    let damaged = format!("{}2_147_000_000{}", &line[..from], &line[to..]);
    *source = source.replace(&line, &damaged);
    let seen = swept(&files, &entry.routine, &CHECKED);
    let said = String::from_utf8_lossy(&seen.stderr);
    assert!(!seen.status.success() && said.contains("overflow"), "{said}");
}
