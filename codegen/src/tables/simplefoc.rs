//! SimpleFOC: the table of `CalibratedSensor`, n × float in radians.
//!
//! After `src/encoders/calibrated/CalibratedSensor.cpp` of simplefoc/Arduino-FOC-drivers 1.1.0 (commit 011c6123), function
//! `getSensorAngle`. In single precision, with the step h = 2π/n, i = ⌊a/h⌋ and u = (a − i h)/h:
//!
//! angle = a − ((1 − u) tᵢ + u tᵢ₊₁)
//!
//! The table is *taken off*, and its size is the constructor's. Up to 1.0.8 there were 128 entries that were added, and no
//! way to set them; what followed 1.1.0 has words of 16 bits. Neither takes this table. The angle a is that of the wrapped
//! sensor, `count / (float)cpr * _2PI` as the sensors of SimpleFOC compute it.

use fitter::coefficients::Coefficients;

use super::interpolate::Lines;
use super::ring::Ring;
use super::single::Fused;
use super::{Asked, Table, TableError, TableFirmware, describe};

/// Entries unless another number is asked for: the constructor's.
const USUAL_ENTRIES: usize = 200;
/// As many entries as anyone has memory for.
const MOST_ENTRIES: usize = 4096;
/// `_2PI`.
const TURN: f32 = std::f32::consts::TAU;
/// Name of the file.
const FILE: &str = "calibration_lut.h";
/// Entries in a line.
const IN_A_LINE: usize = 8;

/// The firmware.
pub struct SimpleFoc;

/// The sensor's angle in radians.
pub fn raw_angle(count: u32, counts: u32) -> f32 {
    count as f32 / counts as f32 * TURN
}

/// `getSensorAngle` of an angle from 0 to 2π.
pub fn calibrated(lut: &[f32], raw: f32, fused: Fused) -> f32 {
    let resolution = TURN / lut.len() as f32;
    let index = (raw / resolution) as usize;
    // Rounding never takes the last count of a turn to its end: see `Ring::of`, which has no more than 2¹⁸ counts.
    let (y0, y1) = (lut[index.min(lut.len() - 1)], lut[(index + 1) % lut.len()]);
    let distance = fused.other([-(index as f32), resolution], raw) / resolution;
    raw - fused.blend([1.0 - distance, y0], [distance, y1])
}

impl TableFirmware for SimpleFoc {
    fn name(&self) -> &'static str {
        "simplefoc"
    }

    fn source(&self) -> &'static str {
        "src/encoders/calibrated/CalibratedSensor.cpp of github.com/simplefoc/Arduino-FOC-drivers 1.1.0, commit 011c6123"
    }

    fn takes(&self) -> &'static [&'static str] {
        &["--bits", "--counts", "--entries"]
    }

    fn design(&self, coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Table, TableError> {
        let ring = Ring::of(self.name(), coefficients, asked, None)?;
        let entries = asked.wanted.entries.unwrap_or(USUAL_ENTRIES);
        let fewest = 4 * ring.harmonics as usize;
        if !(fewest..=MOST_ENTRIES).contains(&entries) {
            return Err(TableError::Entries { entries, fewest, most: MOST_ENTRIES, periods: ring.harmonics });
        }
        let lines = Lines::new(&ring, entries);
        let (values, minimax) = lines.best();
        let lut: Vec<f32> = values.iter().map(|turns| (-turns * std::f64::consts::TAU) as f32).collect();
        let turns = |radians: f32| f64::from(radians) / std::f64::consts::TAU;
        let worst =
            ring.worst(0.0, |count, fused| turns(calibrated(&lut, raw_angle(count, ring.counts), fused)));
        let bound = (worst * ring.revolution).next_up();
        let written = lines.worst(|node| -turns(lut[node]));
        let minimax = minimax * ring.revolution;
        let lsb = ring.revolution / std::f64::consts::TAU;
        Ok(Table {
            file: FILE,
            comment: "//",
            head_last: false,
            text: source_of(&lut),
            entries,
            format: "float in radians",
            degree: 1,
            input: format!(
                "the angle of the wrapped sensor, {} counts to the turn, 0 to 2π as SimpleFOC's sensors compute it",
                ring.counts
            ),
            output: ("f32", lsb),
            range: (0.0, f64::from(ring.counts - 1), "counts".into()),
            bound,
            parts: describe::parts(
                [minimax, written * ring.revolution],
                bound,
                ring.revolution / f64::from(ring.counts),
            ),
            minimax,
            zero: ring.zero * ring.revolution,
            left_out: ring.left_out.clone(),
            budget: ring.budget(coefficients, bound),
            load: vec![
                format!(
                    "#include \"{FILE}\", and construct: CalibratedSensor calibrated(sensor, {entries}, calibration_lut);"
                ),
                "Leave out calibrate(): it would write a table of its own".into(),
                "Let initFOC() find the zero: the table has none".into(),
            ],
        })
    }
}

/// The table as source.
fn source_of(lut: &[f32]) -> String {
    let lines = lut.chunks(IN_A_LINE).map(|chunk| {
        let entries: Vec<String> = chunk.iter().map(|entry| format!("{entry:?}f,")).collect();
        format!("    {}\n", entries.join(" "))
    });
    let lines: String = lines.collect();
    format!("#pragma once\n\nfloat calibration_lut[{}] = {{\n{lines}}};\n", lut.len())
}
