//! From a twin's calibration to firmware in the twin's own loop: a device whose gain drifts with temperature and whose
//! stroke has hysteresis is recorded, diagnosed, its routine generated and compiled, and put into the loop on fresh
//! recordings of the same device. What is judged is the true angle of the mirror, which only the twin knows.

use std::cell::RefCell;
use std::fs;
use std::path::Path;
use std::process::Command;

use arcsmith_tests::programs::{both, run};
use arcsmith_tests::toolchain::available;
use codegen::certificate::Certificate;
use fitter::units::ARCSEC_PER_RAD;
use libloading::Library;
use twin::{Corrector, Device, Protocol, Temperature, record, record_corrected, write_file};

const FULL_SCALE_MM: f64 = 0.76;
/// The thermometer's converter: °C of a count, and the count that stands for 0 °C.
const GAIN_C: f64 = 0.01;
const ZERO: f64 = 500.0;

/// A compiled routine in the loop.
struct Routine {
    library: Library,
    lsb_rad: f64,
    /// As the routine keeps it; empty before the first stop.
    state: RefCell<Vec<u8>>,
}

impl Routine {
    /// Compiles the C that `codegen` wrote into `folder`; `further` where it takes the temperature as well.
    fn of(folder: &Path, further: bool) -> Routine {
        let text = fs::read_to_string(folder.join("certificate.json")).unwrap();
        let certificate: Certificate = serde_json::from_str(&text).unwrap();
        let entry = certificate.routines.iter().find(|r| r.language == "c").unwrap();
        println!("  {}: bound {:.1e}\"", entry.routine, entry.bound);
        let library = folder.join("routine.so");
        let shim = Path::new(env!("CARGO_MANIFEST_DIR")).join("shim/state.c");
        let output = Command::new("gcc")
            .args(["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", "-o"])
            .arg(&library)
            .args(["-DHEADER=\"corrected_angle.h\"", &format!("-DROUTINE={}", entry.routine)])
            .args([&format!("-DFURTHER={}", u8::from(further)), "-I"])
            .arg(folder.join("c"))
            .args([&folder.join("c/corrected_angle.c"), &shim])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        // SAFETY: compiled just now from the project's own sources; runs nothing on loading.
        let library = unsafe { Library::new(&library) }.unwrap();
        Routine { library, lsb_rad: entry.output.lsb, state: RefCell::default() }
    }

    fn words(x1_mm: f64, x2_mm: f64, temperature_c: f64) -> (i32, u16) {
        let s = ((x2_mm - x1_mm) / FULL_SCALE_MM * 2f64.powi(31)).round() as i32;
        (s, (temperature_c / GAIN_C + ZERO).round() as u16)
    }

    /// Calls it from the state where it last settled; gives the state after the call.
    fn call(&self, (s, t): (i32, u16)) -> (f64, Vec<u8>) {
        let mut state = self.state.borrow().clone();
        // SAFETY: signatures and size are those of tests/shim/state.c; the vector is as large as it says, and
        // allocated with the alignment of any type.
        unsafe {
            let size = self.library.get::<extern "C" fn() -> usize>(b"state_size\0").unwrap();
            let init = self.library.get::<unsafe extern "C" fn(*mut u64, i32, u16)>(b"state_init\0").unwrap();
            let update = self
                .library
                .get::<unsafe extern "C" fn(*mut u64, i32, u16) -> i32>(b"state_update\0")
                .unwrap();
            let mut aligned = vec![0u64; size().div_ceil(8)];
            if state.is_empty() {
                init(aligned.as_mut_ptr(), s, t);
            } else {
                for (word, bytes) in aligned.iter_mut().zip(state.chunks_exact(8)) {
                    *word = u64::from_ne_bytes(bytes.try_into().unwrap());
                }
            }
            let result = update(aligned.as_mut_ptr(), s, t);
            state = aligned.iter().flat_map(|word| word.to_ne_bytes()).collect();
            (f64::from(result) * self.lsb_rad, state)
        }
    }
}

impl Corrector for Routine {
    fn angle_rad(&self, x1_mm: f64, x2_mm: f64, temperature_c: f64) -> f64 {
        self.call(Routine::words(x1_mm, x2_mm, temperature_c)).0
    }

    fn settled(&mut self, x1_mm: f64, x2_mm: f64, temperature_c: f64) {
        let (_, state) = self.call(Routine::words(x1_mm, x2_mm, temperature_c));
        *self.state.borrow_mut() = state;
    }
}

/// How far the true angle is from the command over a recording, its mean apart (the zero is free): root mean square
/// and largest, in arcseconds.
fn left(device: &Device, seed: u64, corrector: &mut dyn Corrector) -> (f64, f64) {
    let protocol = Protocol { temperature: Temperature::chamber(), ..Protocol::verification() };
    let errors: Vec<f64> = record_corrected(device, &protocol, seed, corrector)
        .iter()
        .map(|(reading, truth)| (truth.true_angle_rad - reading.command_deg.to_radians()) * ARCSEC_PER_RAD)
        .collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let square = errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / errors.len() as f64;
    (square.sqrt(), errors.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max))
}

#[test]
fn generated_c_in_the_loop_takes_off_what_was_diagnosed() {
    if !available("gcc", "the generated routine in the twin's loop") {
        return;
    }
    for seed in [3u64, 8] {
        let effects = ["thermal_gain_drift:coefficient_ppm_per_k=60", "hysteresis:half_height_arcsec=4"];
        let effects = effects.map(|e| e.parse().unwrap()).to_vec();
        let device = Device::from_seed(seed).with_effects(effects).unwrap();
        let d_mm = device.geometry.probe_distance_mm;
        let folder = tempfile::tempdir().unwrap();
        let run = |program: &str, arguments: &[&str]| {
            let output = run(program, folder.path(), arguments);
            assert_eq!(output.status.code(), Some(0), "{program} {arguments:?}:\n{}", both(&output));
        };
        let gap_mm = device.geometry.initial_gap_mm;
        let mirror = format!("[geometry]\nprobe_distance_mm = {d_mm:?}\ninitial_gap_mm = {gap_mm:?}\n");
        fs::write(folder.path().join("mirror.toml"), mirror).unwrap();
        let protocol = Protocol { temperature: Temperature::chamber(), ..Protocol::fine() };
        let calculated = |x1, x2| twin::calculated_angle_rad(x1, x2, d_mm);
        let log = record(&device, &protocol, 100 + seed, &calculated);
        write_file(&log, &folder.path().join("r.csv")).unwrap();
        let coldest = log.iter().map(|r| r.temperature_c).fold(f64::INFINITY, f64::min);
        let hottest = log.iter().map(|r| r.temperature_c).fold(f64::NEG_INFINITY, f64::max);

        run("arcsmith", &["diagnose", "r.csv", "--mirror", "mirror.toml", "--out", "d", "--no-report"]);
        let report = fs::read_to_string(folder.path().join("d/r.json")).unwrap();
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        let named: Vec<&str> =
            report["effects"].as_array().unwrap().iter().filter_map(|e| e["id"].as_str()).collect();
        println!("device {seed}: {named:?}, {coldest:.1}…{hottest:.1} °C");
        let file = folder.path().join("d/r.coefficients.json");
        let full_scale = FULL_SCALE_MM.to_string();
        let further = format!("temperature_c={coldest}..{hottest}:counts:13:{GAIN_C}:{ZERO}");
        let common =
            ["--full-scale", &full_scale, "--format", "q31", "--coefficients", file.to_str().unwrap()];
        let with = [&common[..], &["--further", &further, "--out", "with"]].concat();
        run("codegen", &with);
        let mut without = [&common[..], &["--out", "without"]].concat();
        let plays = ["hysteresis", "backlash"];
        named.iter().filter(|id| !plays.contains(id)).for_each(|id| without.extend(["--without", id]));
        run("codegen", &without);

        for fresh in [1000 + seed, 2000 + seed] {
            let none = Plain { d_mm };
            let before = left(&device, fresh, &mut { none });
            let play_only = left(&device, fresh, &mut Routine::of(&folder.path().join("without"), false));
            let after = left(&device, fresh, &mut Routine::of(&folder.path().join("with"), true));
            println!(
                "  fresh recording {fresh}: {before:.1?}\" uncorrected, {play_only:.2?}\" without the drift, \
                 {after:.2?}\" with all (root mean square, largest)"
            );
            assert!(after.0 < before.0 && after.0 < 1.5, "{after:?}");
        }
    }
}

/// The calculated angle, uncorrected.
struct Plain {
    d_mm: f64,
}

impl Corrector for Plain {
    fn angle_rad(&self, x1_mm: f64, x2_mm: f64, _: f64) -> f64 {
        twin::calculated_angle_rad(x1_mm, x2_mm, self.d_mm)
    }

    fn settled(&mut self, _: f64, _: f64, _: f64) {}
}
