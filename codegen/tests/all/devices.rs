//! Routines for many devices: random coefficients and damaged pages through the compiled C and Rust alike.

use std::path::{Path, PathBuf};
use std::process::Command;

use codegen::devices::page::{Page, crc32};
use codegen::devices::{Device, DevicesError, Generated, Wanted, earlier, generate, render, verify};
use codegen::files;
use codegen::format::Format;
use codegen::options::{Ends, Method, Options};
use codegen::verify::compile::Place;
use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::units::ARCSEC_PER_RAD;
use proptest::prelude::*;
use tempfile::TempDir;

const HALF_RANGE_MM: f64 = 0.37;
const FULL_SCALE_MM: f64 = 0.5;

/// A mirror whose coefficients are those of the paper's, each times its factor.
fn device(name: &str, factors: &[f64; 4]) -> Device {
    let paper = [-6.15e-5, 0.1439, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4];
    let coefficients = paper.iter().enumerate().map(|(k, a)| a * factors[k % 4]).collect();
    let model = ErrorModel {
        sensor: Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 },
        centre: 0.0,
        coefficients,
    };
    let coefficients = Coefficients::of_model(&model, -HALF_RANGE_MM, HALF_RANGE_MM, "by hand");
    Device { name: name.into(), sha256: codegen::generate::sha256(coefficients.to_json()), coefficients }
}

fn three() -> Vec<Device> {
    vec![
        device("a", &[1.0, 1.0, 1.0, 1.0]),
        device("b", &[-0.5, 0.9, 1.3, 0.4]),
        device("c", &[2.0, 1.1, -0.7, 1.2]),
    ]
}

fn options() -> Options {
    let ends = Ends { full_scale: Some(FULL_SCALE_MM), ..Ends::default() };
    let routines = vec![ends.routine(Method::Fused, Format::Q31)];
    Options { routines, bound: Some(0.005), ..Options::default() }
}

/// The generated files with the programs of `arcsmith verify`, compiled.
struct Compiled {
    _folder: TempDir,
    programs: Vec<(&'static str, PathBuf)>,
}

impl Compiled {
    fn new(generated: &Generated) -> Self {
        let folder = tempfile::tempdir().unwrap();
        files::write(folder.path(), &generated.files).unwrap();
        let build = folder.path().join("run");
        std::fs::create_dir(&build).unwrap();
        let place = Place { generated: folder.path(), base: &generated.name, build: &build };
        let programs = verify::compile(&place, &generated.design, true).unwrap();
        Compiled { _folder: folder, programs }
    }

    /// Status and results of pages with words, the same in both languages.
    fn both(&self, pages: &[(Vec<u8>, Vec<i32>)]) -> Vec<(i32, Vec<i32>)> {
        let readings: Vec<Vec<Vec<u32>>> =
            pages.iter().map(|(_, words)| words.iter().map(|w| vec![*w as u32]).collect()).collect();
        let given: Vec<verify::Given> =
            pages.iter().zip(&readings).map(|((page, _), readings)| (&page[..], &readings[..])).collect();
        let found: Vec<_> = self.programs.iter().map(|(_, p)| verify::run(p, &given).unwrap()).collect();
        assert_eq!(found[0], found[1]);
        let signed = |(status, results): &(i32, Vec<u32>)| {
            (*status, results.iter().map(|word| *word as i32).collect())
        };
        found[0].iter().map(signed).collect()
    }
}

fn sealed(mut bytes: Vec<u8>, word: usize, value: u32) -> Vec<u8> {
    bytes[4 * word..4 * word + 4].copy_from_slice(&value.to_le_bytes());
    let end = bytes.len() - 4;
    let crc = crc32(&bytes[..end]);
    bytes[end..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

fn word(bytes: &[u8], index: usize) -> u32 {
    u32::from_le_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap())
}

/// Words of s over the range and beyond it.
fn words() -> Vec<i32> {
    (-64..=64).map(|i| i * (i32::MAX / 64)).chain([i32::MIN, i32::MAX, 0, 1, -1]).collect()
}

#[test]
fn every_device_is_within_its_bound_and_the_loader_refuses_damage() {
    let devices = three();
    let generated = generate(&devices, &options(), &Wanted::default()).unwrap();
    let design = &generated.design;
    let compiled = Compiled::new(&generated);
    let lsb = design.unit.to_f64();
    assert!(design.total * ARCSEC_PER_RAD <= 0.005);
    let mut pages = Vec::new();
    for (device, fitted) in devices.iter().zip(&design.fitted) {
        let bytes = render::page(design, device, fitted).bytes();
        let file = &generated.files[Path::new(&format!("pages/{}.bin", device.name))];
        assert_eq!(file, &bytes);
        pages.push((bytes, words()));
    }
    for ((device, fitted), (status, results)) in devices.iter().zip(&design.fitted).zip(compiled.both(&pages))
    {
        assert_eq!(status, 0);
        let model = device.coefficients.error_model();
        for (word, result) in words().iter().zip(results) {
            let s = (f64::from(*word) * FULL_SCALE_MM / 2f64.powi(31)).clamp(-HALF_RANGE_MM, HALF_RANGE_MM);
            let off = (f64::from(result) * lsb - model.corrected(s)).abs();
            // The end of the range is the last word inside it.
            let end = if s.abs() == HALF_RANGE_MM { 2.0 * lsb } else { 0.0 };
            assert!(off <= fitted.total + end + 1e-15, "{}: {off:e} > {:e}", device.name, fitted.total);
        }
    }

    // One bit anywhere, in every place.
    let good = pages[0].0.clone();
    let flipped: Vec<(Vec<u8>, Vec<i32>)> = (0..8 * good.len())
        .map(|bit| {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            (bytes, vec![5])
        })
        .collect();
    assert!(compiled.both(&flipped).iter().all(|(status, _)| *status != 0));

    // Damage that a CRC covers, one kind after the other.
    let last = word(&good, 6 + design.degree) as i32;
    let beyond = design.program.page[design.degree].to as i32 + 1;
    assert!(last < beyond);
    // The routine's bound, which has a margin beyond the devices'.
    let most = (256.0 * (design.total / lsb).next_up()).ceil() as u32;
    assert!((0..devices.len()).all(|i| word(&pages[i].0, 4) <= most));
    for (bytes, expected) in [
        (good[..good.len() - 1].to_vec(), 1),
        (Vec::new(), 1),
        (sealed(good.clone(), 0, 0), 2),
        (vec![0xff; good.len()], 2),
        (sealed(good.clone(), 1, 2), 3),
        (sealed(good.clone(), 2, good.len() as u32 + 4), 4),
        (sealed(good.clone(), 3, design.structure() ^ 1), 6),
        (sealed(good.clone(), 4, most), 0),
        (sealed(good.clone(), 4, most + 1), 7),
        (sealed(good.clone(), 6 + design.degree, (beyond - 1) as u32), 0),
        (sealed(good.clone(), 6 + design.degree, beyond as u32), 8),
        (sealed(good.clone(), 6, i32::MIN as u32), 8),
        ([good.clone(), vec![7; 100]].concat(), 0),
    ] {
        let (status, _) = compiled.both(&[(bytes, vec![5])])[0].clone();
        assert_eq!(status, expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    /// Whatever coefficients the ranges hold: no overflow, the interpreter's bits, and the stated rounding.
    #[test]
    fn any_coefficients_in_their_ranges_are_evaluated_within_the_rounding(
        factors in prop::collection::vec(prop::array::uniform4(-2.0..2.0f64), 1..4),
        margin in 0.0..1.0f64,
        places in prop::collection::vec(prop::collection::vec(prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64], 17), 24),
    ) {
        let devices: Vec<Device> = factors.iter().enumerate().map(|(i, f)| device(&format!("u{i}"), f)).collect();
        let generated = generate(&devices, &options(), &Wanted { margin, ..Wanted::default() }).unwrap();
        let design = &generated.design;
        let compiled = Compiled::new(&generated);
        let pages: Vec<(Vec<u8>, Vec<i32>)> = places
            .iter()
            .map(|at| {
                let coefficients = (design.program.page.iter().zip(at))
                    .map(|(w, at)| (w.from + ((w.to - w.from) as f64 * at) as i64).clamp(w.from, w.to) as i32)
                    .collect();
                let page = Page { structure: design.structure(), proved: 0, origin: 0, coefficients };
                (page.bytes(), words())
            })
            .collect();
        let found = compiled.both(&pages);
        let lsb = design.unit.to_f64();
        for ((bytes, words), (status, results)) in pages.iter().zip(found) {
            prop_assert_eq!(status, 0);
            let c: Vec<i32> = (0..=design.degree).map(|k| word(bytes, 6 + k) as i32).collect();
            for (s, result) in words.iter().zip(results) {
                let from = (-HALF_RANGE_MM / FULL_SCALE_MM * 2f64.powi(31)).ceil();
                let s = f64::from(*s).clamp(from, -from);
                // v, of which 2³¹ are a half.
                let v = (s * FULL_SCALE_MM / 2f64.powi(31) - design.shared.plan.map.offset.to_f64()) / design.shared.plan.map.slope.to_f64();
                let exact = c.iter().rev().fold(0.0, |sum, c| sum * v + f64::from(*c)) * 2f64.powi(-(design.bits as i32));
                let off = (f64::from(result) * lsb - exact).abs();
                prop_assert!(off <= design.rounding + 1e-14, "{off:e} {:e}", design.rounding);
            }
        }
    }
}

/// A later device gets a page for the routine that is in the firmware; one outside the ranges is refused.
#[test]
fn later_devices_share_an_earlier_routine() {
    let generated = generate(&three(), &options(), &Wanted::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    files::write(folder.path(), &generated.files).unwrap();
    let earlier = earlier::read(&folder.path().join("units.json")).unwrap();
    let wanted = Wanted { earlier: Some(earlier), ..Wanted::default() };
    let later = generate(&[device("d", &[0.3, 1.0, 0.6, 0.8])], &options(), &wanted).unwrap();
    let names: Vec<String> = later.files.keys().map(|path| path.display().to_string()).collect();
    assert_eq!(names, ["pages/d.bin", "pages/d.hex"]);
    let compiled = Compiled::new(&generated);
    let page = later.files[Path::new("pages/d.bin")].clone();
    let (status, results) = compiled.both(&[(page, words())])[0].clone();
    assert_eq!(status, 0);
    let model = device("d", &[0.3, 1.0, 0.6, 0.8]).coefficients.error_model();
    for (word, result) in words().iter().zip(results) {
        let s = f64::from(*word) * FULL_SCALE_MM / 2f64.powi(31);
        let off = (f64::from(result) * later.design.unit.to_f64() - model.corrected(s)).abs();
        assert!(s.abs() > HALF_RANGE_MM || off <= generated.design.total + 1e-15, "{off:e}");
    }
    // The same devices anew give the same pages.
    let again = generate(&three(), &options(), &wanted).unwrap();
    assert!(again.files.iter().all(|(path, bytes)| generated.files.get(path) == Some(bytes)));

    let error = generate(&[device("e", &[9.0, 1.0, 1.0, 1.0])], &options(), &wanted).unwrap_err();
    assert!(matches!(error, DevicesError::Outside { .. }), "{error}");
    let ends = Ends { full_scale: Some(0.75), ..Ends::default() };
    let other = Options { routines: vec![ends.routine(Method::Fused, Format::Q31)], ..options() };
    let error = generate(&three(), &other, &wanted).unwrap_err();
    assert!(matches!(error, DevicesError::OtherStructure { .. }), "{error}");
    std::fs::write(folder.path().join("units.json"), "{}").unwrap();
    assert!(matches!(earlier::read(&folder.path().join("units.json")), Err(DevicesError::Earlier { .. })));
}

/// A device somewhat further from its model than the worst of the first ones is served by the same routine, within the
/// margin and the bound that was asked for; one far worse is refused.
#[test]
fn a_later_device_may_be_a_little_worse() {
    let options = options();
    let first = vec![device("a", &[1.0, 1.0, 1.0, 1.0]), device("b", &[0.9, 1.0, 0.9, 0.95])];
    let generated = generate(&first, &options, &Wanted::default()).unwrap();
    let worst = generated.design.fitted.iter().map(|f| f.total).fold(0.0, f64::max);
    let asked = options.bound.unwrap() / ARCSEC_PER_RAD;
    assert!(generated.design.total <= asked * (1.0 + 1e-12));
    assert!(generated.design.total >= worst * 1.2, "{:e} {worst:e}", generated.design.total);
    let folder = tempfile::tempdir().unwrap();
    files::write(folder.path(), &generated.files).unwrap();
    let earlier = earlier::read(&folder.path().join("units.json")).unwrap();
    let wanted = Wanted { earlier: Some(earlier), ..Wanted::default() };
    let later = generate(&[device("c", &[1.1, 1.0, 1.1, 1.1])], &options, &wanted).unwrap();
    assert!(later.design.fitted[0].total > worst, "{:e} {worst:e}", later.design.fitted[0].total);
    files::write(folder.path(), &later.files).unwrap();
    let devices = [device("c", &[1.1, 1.0, 1.1, 1.1])];
    let report = verify::verify(folder.path(), &later, &devices, &wanted, true).unwrap();
    assert!(report.holds() && report.sweeps.len() == 2, "{}", report.text());
    // One beyond the bound that was asked for is refused: here, one of which the degree is too low.
    let low = Options { degree: Some(5), bound: Some(1.3 * LOW_DEGREE_ARCSEC), ..options };
    let low_first = generate(&first[..1], &low, &Wanted::default()).unwrap();
    files::write(folder.path(), &low_first.files).unwrap();
    let earlier = earlier::read(&folder.path().join("units.json")).unwrap();
    let wanted = Wanted { earlier: Some(earlier), ..Wanted::default() };
    let error = generate(&[device("d", &[1.0, 1.0, 1.0, 1.8])], &low, &wanted).unwrap_err();
    assert!(matches!(error, DevicesError::Coarse { .. } | DevicesError::Outside { .. }), "{error}");
}

/// About what degree 5 leaves of the paper's error over the range.
const LOW_DEGREE_ARCSEC: f64 = 0.8;

/// `arcsmith verify --devices`: what is generated holds; a damaged page, table of limits or certificate does not.
#[test]
fn what_was_damaged_is_found() {
    let devices = three();
    let generated = generate(&devices, &options(), &Wanted::default()).unwrap();
    let check = |damage: &dyn Fn(&Path)| {
        let folder = tempfile::tempdir().unwrap();
        files::write(folder.path(), &generated.files).unwrap();
        damage(folder.path());
        verify::verify(folder.path(), &generated, &devices, &Wanted::default(), false).unwrap()
    };
    let good = check(&|_| {});
    assert!(good.holds() && good.sweeps.len() == 6 && good.damaged > 500, "{}", good.text());
    // A page with a coefficient that is another, its CRC right.
    let page = check(&|folder| {
        let path = folder.join("pages/b.bin");
        let bytes = std::fs::read(&path).unwrap();
        let other = word(&bytes, 8).wrapping_add(4000);
        std::fs::write(&path, sealed(bytes, 8, other)).unwrap();
    });
    assert!(!page.holds() && !page.certificate.is_empty(), "{}", page.text());
    assert!(page.sweeps.iter().all(|s| (s.unit == "b") == (s.different > 0)), "{}", page.text());
    assert!(page.sweeps.iter().any(|s| s.unit == "b" && s.worst > s.bound), "{}", page.text());
    // A loader in C that takes what has another CRC.
    let loader = check(&|folder| {
        let path = folder.join("c/corrected_angle.c");
        let text = std::fs::read_to_string(&path).unwrap();
        let line = text.lines().find(|l| l.contains("crc") && l.contains("!=")).unwrap();
        std::fs::write(&path, text.replacen(line, &line.replace("!=", "=="), 1)).unwrap();
    });
    assert!(!loader.holds() && !loader.taken.is_empty(), "{}", loader.text());
    // A certificate that promises more.
    let certificate = check(&|folder| {
        let path = folder.join("certificate.json");
        let text = std::fs::read_to_string(&path).unwrap();
        let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let bound = value["routines"][0]["bound"].as_f64().unwrap();
        value["routines"][0]["bound"] = (0.5 * bound).into();
        std::fs::write(&path, value.to_string()).unwrap();
    });
    assert!(!certificate.holds() && certificate.sweeps.iter().all(|s| s.different == 0));
}

#[test]
fn units_that_share_nothing_are_refused() {
    let generate = |devices: &[Device]| generate(devices, &options(), &Wanted::default()).unwrap_err();
    assert!(matches!(generate(&[]), DevicesError::None { .. }));
    let mut other = three();
    other[1].coefficients.sensor = Sensor::EddyCurrentPair { probe_distance_mm: 12.5, initial_gap_mm: 0.3 };
    assert!(matches!(generate(&other), DevicesError::Structure { what: "probe_distance_mm", .. }));
    let mut other = three();
    (other[2].coefficients.valid_range.from, other[2].coefficients.valid_range.to) = (0.5, 0.6);
    assert!(matches!(generate(&other), DevicesError::Range { .. }));
    let impossible = Options { bound: Some(1e-9), ..options() };
    let error = codegen::devices::generate(&three(), &impossible, &Wanted::default()).unwrap_err();
    assert!(matches!(error, DevicesError::Unreachable { .. }), "{error}");
    let beyond = Options { range: Some((-0.5, 0.5)), ..options() };
    let error = codegen::devices::generate(&three(), &beyond, &Wanted::default()).unwrap_err();
    assert!(matches!(error, DevicesError::BeyondRecording { .. }), "{error}");
}

/// The program: one sentence, exit code 2, nothing written.
#[test]
fn bad_input_ends_with_2_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for device in three() {
        std::fs::write(folder.path().join(format!("{}.json", device.name)), device.coefficients.to_json())
            .unwrap();
    }
    std::fs::write(folder.path().join("broken.json"), "{").unwrap();
    std::fs::create_dir(folder.path().join("again")).unwrap();
    std::fs::copy(folder.path().join("a.json"), folder.path().join("again/a.json")).unwrap();
    let run = |arguments: &[&str]| {
        let program = Command::new(env!("CARGO_BIN_EXE_codegen"))
            .args(arguments)
            .args(["--out", "out"])
            .current_dir(folder.path())
            .output();
        program.unwrap()
    };
    for (arguments, said) in [
        (vec!["--devices", "nothing-*.json"], "nothing-*.json"),
        (vec!["--devices", "a.json", "again/a.json"], "device `a`"),
        (vec!["--devices", "a.json", "broken.json"], "broken.json"),
        (vec!["--devices", "a.json", "--margin", "-1"], "margin"),
        (vec!["--devices", "a.json", "--page-address", "0x11"], "multiple of 16"),
        (vec!["--devices", "a.json", "--format", "f32"], "f32"),
        (vec!["--devices", "a.json", "--target", "cortex-m0"], "--target"),
        (vec!["--devices", "a.json", "--pages-for", "b.json"], "b.json"),
        (vec!["--devices", "a.json", "--from", "-0.5", "--to", "0.5"], "covers"),
        (vec!["--coefficients", "a.json", "--output-bits", "16"], "--output-bits"),
        (vec!["--coefficients", "a.json", "--flash-bytes", "16"], "--target"),
    ] {
        let out = run(&arguments);
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(said), "{arguments:?}: {message}");
        assert!(!folder.path().join("out").exists(), "{arguments:?}");
    }
    let out = run(&["--devices", "[a-c].json", "?.json", "--quiet"]);
    assert_eq!(out.status.code(), Some(2), "only `*` is a pattern");
    let out = run(&["--devices", "a.json", "b.json", "c.json", "--quiet"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let out = run(&["check", "--devices", "a.json", "b.json", "c.json", "--quiet"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stdout));
    std::fs::write(folder.path().join("out/pages/a.bin"), [0; 64]).unwrap();
    let out = run(&["check", "--devices", "a.json", "b.json", "c.json", "--quiet"]);
    assert_eq!(out.status.code(), Some(1));
}
