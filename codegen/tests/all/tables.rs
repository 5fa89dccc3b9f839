//! Tables for firmware that exists: what it computes from them, and what its own calibration gives on the same data.

mod compiled;
mod device;
mod klipper;
mod linuxcnc;
mod moteus;
mod simplefoc;
mod vesc;

use crate::turn::fixtures;
use codegen::certificate::Entry;
use codegen::generate::Generated;
use codegen::options::Options;
use codegen::tables::{Asked, Firmware, TableError, Wanted, generate};
use codegen::turn::Encoder;
use device::{Device, Random};
use fitter::coefficients::Coefficients;

/// Encoders that are drawn unless `ARCSMITH_TABLES` names another number.
const USUAL: u64 = 12;

/// The encoders of a test.
fn devices() -> impl Iterator<Item = (Device, Random)> {
    let count = std::env::var("ARCSMITH_TABLES").ok().and_then(|count| count.parse().ok()).unwrap_or(USUAL);
    (0..count).map(|seed| {
        let mut random = Random::new(seed);
        (Device::draw(&mut random), random)
    })
}

/// The table of these coefficients for an encoder of so many counts.
fn table(
    firmware: Firmware,
    file: &Coefficients,
    counts: u32,
    wanted: Wanted,
    bound: Option<f64>,
) -> Result<Generated, TableError> {
    let encoder = Encoder { counts: Some(counts), ..Encoder::default() };
    let options = Options { encoder, bound, ..Options::default() };
    generate(firmware, file, "0", &Asked { wanted, options: &options })
}

/// The lines of a generated file that are no comment.
fn lines<'a>(generated: &'a Generated, file: &str, comment: &str) -> Vec<&'a str> {
    let text = &generated.files[std::path::Path::new(file)];
    text.lines().filter(|line| !line.starts_with(comment) && !line.is_empty()).collect()
}

fn entry(generated: &Generated) -> &Entry {
    &generated.certificate.routines[0]
}

/// The largest distance round the turn of results, in turns and by count, from the model's corrected positions once the
/// stated zero is taken off; in the sensor's unit.
fn worst(file: &Coefficients, results: &[f64], zero: f64) -> f64 {
    let revolution = file.turn.as_ref().unwrap().revolution;
    let counts = results.len() as f64;
    let off = results.iter().enumerate().map(|(count, result)| {
        let exact = fitter::turn::corrected(file, count as f64 / counts * revolution).unwrap();
        let off = (result * revolution - exact - zero) / revolution;
        (off - off.round()).abs() * revolution
    });
    off.fold(0.0, f64::max)
}

/// The zero that the certificate states.
fn zero(generated: &Generated) -> f64 {
    let line = entry(generated).left_out.iter().find(|line| line.starts_with("zero:")).unwrap();
    line.split_whitespace().filter_map(|word| word.parse().ok()).next().unwrap()
}

/// Half of the distance between the largest and the smallest of the errors that a table leaves of a device, in turns: the
/// zero is set elsewhere. `results` by count.
fn left(device: &Device, results: &[f64]) -> f64 {
    let counts = results.len() as f64;
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let from = results[0] - device.position(0.0);
    for (count, result) in results.iter().enumerate() {
        let off = result - device.position(count as f64 / counts) - from;
        let off = off - off.round();
        (least, most) = (least.min(off), most.max(off));
    }
    0.5 * (most - least)
}

/// What two tables leave of one device after the other, in degrees.
#[derive(Default)]
struct Compared {
    ours: Vec<f64>,
    theirs: Vec<f64>,
}

impl Compared {
    fn add(&mut self, ours: f64, theirs: f64) {
        assert!(
            ours <= theirs,
            "encoder {}: {ours} of a turn, and its own calibration {theirs}",
            self.ours.len()
        );
        self.ours.push(360.0 * ours);
        self.theirs.push(360.0 * theirs);
    }

    /// Prints the row of docs/firmware-tables.md, which is what all 200 encoders give.
    fn print(mut self, firmware: &str) {
        let count = self.ours.len();
        let figures = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            format!("{:.4} | {:.4}", values[count / 2], values[count - 1])
        };
        let row = format!("| {firmware} | {} | {} |", figures(&mut self.ours), figures(&mut self.theirs));
        println!("{row}  ({count} encoders; median and largest, arcsmith and its own calibration)");
        if count == 200 {
            let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/firmware-tables.md");
            assert!(
                std::fs::read_to_string(page).unwrap().contains(&row),
                "docs/firmware-tables.md has not\n{row}"
            );
        }
    }
}
