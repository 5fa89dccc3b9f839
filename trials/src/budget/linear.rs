//! Sensors of a length: a smooth characteristic over two millimetres, read by a converter of 50 nm.

use std::fmt::Write;

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::Noise;
use twin::sensor::{Bench, Row, Schedule};

use super::reference::{A_QUARTER, Reference};
use super::{Fresh, TENTHS, Trial};

const ACCURACY_MM: f64 = 1.5e-4;
/// The noise of the bench's reference.
const REPEATABILITY_MM: f64 = 8e-5;
const COUNT_MM: f64 = 5e-5;
const MIDDLE: f64 = 32_768.0;

pub fn simulate(generator: &mut ChaCha12Rng) -> Trial {
    let schedule = Schedule { stops: 41, passes: 6, random: false, noise: Noise::White };
    let bench = Bench::from_seed(generator.random(), None, schedule.duration_s());
    let reference = Reference::draw(ACCURACY_MM, A_QUARTER, generator);
    let mut csv = String::from("t_s,pass,direction,measured,reference\n");
    let count = |row: &Row| (row.measured_mm / COUNT_MM).round();
    let rows = bench.record(&schedule, generator.random());
    let ends = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| {
        (low.min(row.measured_mm), high.max(row.measured_mm))
    });
    for row in &rows {
        let part = (row.measured_mm - ends.0) / (ends.1 - ends.0);
        let reference_mm = row.reference_mm + reference.error(part);
        let Row { t_s, pass, direction, .. } = row;
        // Writing into memory has no way to fail.
        let _ = writeln!(csv, "{t_s},{pass},{direction},{:.5},{reference_mm:.6}", COUNT_MM * count(row));
    }
    // Between the stops of the calibration as well.
    let again = Schedule { stops: 60, passes: 1, random: true, ..schedule };
    let inside = |row: &&Row| (ends.0..ends.1).contains(&(COUNT_MM * count(row)));
    let one = |row: &Row| {
        let place = COUNT_MM * count(row);
        let tenth = (TENTHS as f64 * (place - ends.0) / (ends.1 - ends.0)) as usize;
        Fresh { tenth: tenth.min(TENTHS - 1), place, word: (count(row) + MIDDLE) as i64, truth: row.clean_mm }
    };
    let fresh = bench.record(&again, generator.random()).iter().filter(inside).map(one).collect();
    Trial {
        csv: csv.into_bytes(),
        mirror: format!(
            "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n[reference]\naccuracy = {ACCURACY_MM:?}\nrepeatability = \
             {REPEATABILITY_MM:?}\n"
        ),
        options: super::mirror::counts(16, COUNT_MM, MIDDLE),
        fresh: super::one_in_each(fresh),
        turn: None,
        from_zero: false,
    }
}
