//! Sensors of a length: a smooth characteristic over two millimetres, read by a converter of 50 nm. Plain; with a drift with
//! temperature, which a diagnosis has to find; and with noise that lasts from one reading to the next.

use std::fmt::Write;

use codegen::options::Options;
use codegen::physics::{Further, FurtherEncoding};
use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::Noise;
use twin::sensor::{Bench, Row, Schedule, TEMPERATURE};

use super::reference::{A_QUARTER, Reference};
use super::{Fresh, TENTHS, Trial};

const ACCURACY_MM: f64 = 1.5e-4;
/// Of the reference of noise that lasts: so good that it does not hide what that noise does.
const GOOD_ACCURACY_MM: f64 = 3e-5;
/// The noise of the bench's reference.
const REPEATABILITY_MM: f64 = 8e-5;
const COUNT_MM: f64 = 5e-5;
const MIDDLE: f64 = 32_768.0;
/// Smallest and largest drift with temperature, either way.
const DRIFT_MM_PER_K: [f64; 2] = [3e-5, 1.2e-4];
/// Where the drift is nothing.
const MEAN_C: f64 = 24.0;
/// One count of the thermometer of the firmware: 13 bits from 0 °C on.
const COUNT_C: f64 = 0.01;
/// Decimals of a recorded temperature.
const DECIMALS_OF_C: i32 = 3;

/// A plain one.
pub fn simulate(generator: &mut ChaCha12Rng) -> Trial {
    Setting { passes: 6, noise: Noise::White, accuracy_mm: ACCURACY_MM, noisy: true, warmed: false }
        .simulate(generator)
}

/// One that drifts with temperature.
pub fn warmed(generator: &mut ChaCha12Rng) -> Trial {
    Setting { passes: 6, noise: Noise::White, accuracy_mm: ACCURACY_MM, noisy: true, warmed: true }
        .simulate(generator)
}

/// One whose noise lasts, held against a reference without noise.
pub fn correlated(generator: &mut ChaCha12Rng) -> Trial {
    let noise = Noise::autocorrelated();
    Setting { passes: 3, noise, accuracy_mm: GOOD_ACCURACY_MM, noisy: false, warmed: false }
        .simulate(generator)
}

/// What is calibrated, and how.
struct Setting {
    passes: u32,
    noise: Noise,
    accuracy_mm: f64,
    /// Whether the reference has noise.
    noisy: bool,
    /// Whether the sensor drifts with temperature, which is recorded.
    warmed: bool,
}

impl Setting {
    fn simulate(self, generator: &mut ChaCha12Rng) -> Trial {
        let Setting { passes, noise, accuracy_mm, noisy, warmed } = self;
        let schedule = Schedule { stops: 41, passes, random: false, noise };
        let bench = Bench::from_seed(generator.random(), None, schedule.duration_s());
        let reference = Reference::draw(accuracy_mm, A_QUARTER, generator);
        let drift = if warmed { drift(generator) } else { 0.0 };
        let measured_mm = |row: &Row| row.measured_mm + drift * (row.columns[TEMPERATURE] - MEAN_C);
        let count = |row: &Row| (measured_mm(row) / COUNT_MM).round();
        let rows = bench.record(&schedule, generator.random());
        let place_mm = |row: &Row| COUNT_MM * count(row);
        let (ends, warm) = (ends(rows.iter().map(place_mm)), ends(rows.iter().map(recorded_c)));
        let part = |row: &Row| (place_mm(row) - ends.0) / (ends.1 - ends.0);
        let mut csv = String::from("t_s,pass,direction,measured,reference");
        csv += if warmed { ",temperature_c\n" } else { "\n" };
        for row in &rows {
            let read_mm = if noisy { row.reference_mm } else { row.clean_mm };
            let reference_mm = read_mm + reference.error(part(row));
            let Row { t_s, pass, direction, .. } = row;
            // Writing into memory has no way to fail.
            let _ = write!(csv, "{t_s},{pass},{direction},{:.5},{reference_mm:.6}", place_mm(row));
            let _ = match warmed {
                true => writeln!(csv, ",{}", recorded_c(row)),
                false => writeln!(csv),
            };
        }
        // Between the stops of the calibration as well.
        let again = Schedule { stops: 60, passes: 1, random: true, ..schedule };
        let counts_c = |row: &Row| (row.columns[TEMPERATURE] / COUNT_C).round();
        let inside = |row: &&Row| {
            let valid = !warmed || (warm.0..warm.1).contains(&(COUNT_C * counts_c(row)));
            valid && (ends.0..ends.1).contains(&place_mm(row))
        };
        let one = |row: &Row| Fresh {
            tenth: ((TENTHS as f64 * part(row)) as usize).min(TENTHS - 1),
            place: place_mm(row),
            word: (count(row) + MIDDLE) as i64,
            further: warmed.then(|| counts_c(row) as i64),
            truth: row.clean_mm,
        };
        let fresh = bench.record(&again, generator.random()).iter().filter(inside).map(one).collect();
        let stated = if noisy { format!("repeatability = {REPEATABILITY_MM:?}\n") } else { String::new() };
        let further = warmed.then(|| thermometer(warm)).into_iter().collect();
        Trial {
            csv: csv.into_bytes(),
            mirror: format!(
                "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n[reference]\naccuracy = {accuracy_mm:?}\n{stated}"
            ),
            diagnosed: warmed,
            options: Options { further, ..super::mirror::counts(16, COUNT_MM, MIDDLE) },
            fresh: super::one_in_each(fresh),
            turn: None,
            from_zero: false,
        }
    }
}

fn drift(generator: &mut ChaCha12Rng) -> f64 {
    let [least, most] = DRIFT_MM_PER_K;
    let size = generator.random_range(least..most);
    if generator.random() { size } else { -size }
}

/// The temperature as it stands in the recording.
fn recorded_c(row: &Row) -> f64 {
    let scale = 10f64.powi(DECIMALS_OF_C);
    (row.columns[TEMPERATURE] * scale).round() / scale
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The thermometer that the routine is given, over what was recorded.
fn thermometer((from, to): (f64, f64)) -> Further {
    let encoding = FurtherEncoding::Counts { bits: 13, gain: COUNT_C, offset: 0.0 };
    Further { observable: "temperature_c".into(), from, to, encoding }
}
