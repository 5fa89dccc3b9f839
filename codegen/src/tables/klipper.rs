//! Klipper: `calibrate` of an `[angle]` section, the sensor's angle at each full step of the motor.
//!
//! After `klippy/extras/angle.py` of Klipper3d/klipper at 84104bbb (August 2026), class `AngleCalibration`.
//! `load_calibration` fits 64 entries to the angles by least squares, and rounds them; `apply_calibration` computes, in
//! integers, for an angle a of 16 bits with b = ⌊a/1024⌋
//!
//! adjusted = c_b + ⌊((a mod 1024)·(c_{b+1} − c_b) + 512)/1024⌋
//!
//! The entries are what counts, and the file holds angles: those at which the lines between the wanted entries pass through
//! each step, so that nothing is left for the fit to weigh. Two things there are accounted for: an entry below zero is
//! rounded toward zero, and an angle that rounds to the end of the turn is taken for one at its beginning.
//!
//! Reference 0 of the recording is a step whose number is a multiple of four, since the list counts the motor's phase: the
//! first of the list that Klipper measured. Klipper counts from the smallest angle.

use fitter::coefficients::Coefficients;

use super::interpolate::Lines;
use super::ring::Ring;
use super::{Asked, Table, TableError, TableFirmware, chain, describe};

/// Entries that Klipper fits.
pub const ENTRIES: usize = 64;
/// Angles of a turn.
pub const ANGLES: u32 = 65_536;
/// Full steps of a turn unless another number is asked for: those of a motor of 1.8°.
const USUAL_STEPS: usize = 200;
/// Fewer leave stretches without an angle; more no motor has.
const STEPS: [usize; 2] = [128, 1024];
/// Whole numbers on either side of what is wanted that are tried at each entry.
const AROUND: usize = 3;
/// The last angle that is not taken for one at the beginning of the turn.
const LAST_ANGLE: f64 = 65_535.49;
/// How near to a whole number the fit has to come, so that no rounding of its arithmetic decides.
const SURE: f64 = 0.4;
/// Name of the file.
const FILE: &str = "angle_calibrate.cfg";
/// Angles in a line.
const IN_A_LINE: usize = 8;

/// The firmware.
pub struct Klipper;

/// `apply_calibration` of an angle of 16 bits, with 65 entries.
pub fn adjusted(calibration: &[i64], angle: i64) -> i64 {
    let bucket = ((angle & 0xffff) >> 10) as usize;
    let (low, high) = (calibration[bucket], calibration[bucket + 1]);
    let adjusted = low + (((angle & 1023) * (high - low) + 512) >> 10);
    let off = (adjusted - angle) & 0xffff;
    angle + off - ((off & 0x8000) << 1)
}

/// `load_calibration` of a list of rising angles from the smallest on: 65 entries, and how far the fitted ones are at most from
/// those that round without doubt.
pub fn load_calibration(angles: &[f64]) -> (Vec<i64>, f64) {
    let (turn, size) = (f64::from(ANGLES), f64::from(ANGLES) / ENTRIES as f64);
    // Normal equations, the right-hand side in the last column.
    let mut rows = vec![vec![0.0; ENTRIES + 1]; ENTRIES];
    for (step, angle) in angles.iter().enumerate() {
        let bucket = ((angle + 0.5) as usize % ANGLES as usize) / size as usize;
        let part = (angle - bucket as f64 * size) / size;
        let wraps = if bucket + 1 == ENTRIES { part * turn } else { 0.0 };
        let answer = step as f64 * turn / angles.len() as f64 - wraps;
        let weights = [(bucket, 1.0 - part), ((bucket + 1) % ENTRIES, part)];
        for (row, weight) in weights {
            for (column, other) in weights {
                rows[row][column] += weight * other;
            }
            rows[row][ENTRIES] += weight * answer;
        }
    }
    let fitted = solved(rows);
    // Python's int() cuts toward zero.
    let mut entries: Vec<i64> = fitted.iter().map(|value| (value + 0.5) as i64).collect();
    let off = fitted.iter().map(|value| (value - value.round()).abs()).fold(0.0, f64::max);
    entries.push(entries[0] + i64::from(ANGLES));
    (entries, off)
}

/// The solution of positive definite equations by elimination.
fn solved(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    for pivot in 0..ENTRIES {
        let by = rows[pivot].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(index, _)| *index != pivot) {
            let factor = row[pivot] / by[pivot];
            row.iter_mut().zip(&by).for_each(|(value, by)| *value -= factor * by);
        }
    }
    (0..ENTRIES).map(|row| rows[row][ENTRIES] / rows[row][row]).collect()
}

impl TableFirmware for Klipper {
    fn name(&self) -> &'static str {
        "klipper"
    }

    fn source(&self) -> &'static str {
        "klippy/extras/angle.py of github.com/Klipper3d/klipper, commit 84104bbb"
    }

    fn takes(&self) -> &'static [&'static str] {
        &["--entries"]
    }

    fn design(&self, coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Table, TableError> {
        let ring = Ring::of(self.name(), coefficients, asked, Some(ANGLES))?;
        let steps = asked.wanted.entries.unwrap_or(USUAL_STEPS);
        if !(STEPS[0]..=STEPS[1]).contains(&steps) || !steps.is_multiple_of(4) {
            return Err(TableError::Steps { steps, fewest: STEPS[0], most: STEPS[1] });
        }
        // Klipper counts from the step with the smallest angle: the first above the position at angle 0.
        let first = ((ring.at(0.0) - ring.zero) * steps as f64).ceil().rem_euclid(steps as f64) as usize;
        let zero = -ring.zero - first as f64 / steps as f64;
        let zero = zero - zero.round();
        let lines = Lines::new(&ring, ENTRIES);
        let (angles, calibration) = chosen(&lines, zero, steps)?;
        let turn = f64::from(ANGLES);
        let worst = ring.worst(zero, |count, _| adjusted(&calibration, count.into()) as f64 / turn);
        let bound = (worst * ring.revolution).next_up();
        let minimax = lines.best().1 * ring.revolution;
        let written =
            lines.worst(|node| calibration[node] as f64 / turn - node as f64 / ENTRIES as f64 - zero);
        // The list begins with a step whose number is a multiple of four.
        let before = first % 4;
        let listed: Vec<f64> = (0..steps).map(|index| angles[(index + steps - before) % steps]).collect();
        Ok(Table {
            file: FILE,
            comment: "#",
            head_last: false,
            text: section(&listed),
            entries: ENTRIES,
            format: "whole 65536ths of a turn, fitted by Klipper to the angle of each full step",
            degree: 1,
            input: "the sensor's angle, 16 bits".into(),
            output: ("integer", ring.revolution / turn),
            range: (0.0, turn - 1.0, "counts".into()),
            bound,
            parts: describe::parts([minimax, written * ring.revolution], bound, ring.revolution / turn),
            minimax,
            zero: (ring.zero + zero) * ring.revolution,
            left_out: ring.left_out.clone(),
            budget: ring.budget(coefficients, bound),
            load: vec![
                "Put `calibrate` into the section [angle …] of printer.cfg, in place of the one in the block of SAVE_CONFIG, \
                 and restart"
                    .into(),
                format!("full_steps_per_rotation of the stepper has to be {steps}"),
            ],
        })
    }
}

/// The angles of the steps, from the smallest on, and the entries that Klipper makes of them.
fn chosen(lines: &Lines, zero: f64, steps: usize) -> Result<(Vec<f64>, Vec<i64>), TableError> {
    let turn = f64::from(ANGLES);
    let place = |node: usize| node as f64 / ENTRIES as f64;
    // The first entry lies between the last step of the turn and the first, for both have an angle within the turn.
    let least = 2.0 - (turn / steps as f64).floor();
    let entry = |node: usize, k: usize| {
        let tried = ((place(node) + lines.at(node) + zero) * turn).round() + k as f64 - AROUND as f64;
        if node == 0 { tried.clamp(least, 0.0) } else { tried }
    };
    let added = |node: usize, value: f64| value / turn - place(node) - zero;
    let next = |node: usize| (node + 1) % ENTRIES;
    let (choice, _) = chain::ring(&[2 * AROUND + 1; ENTRIES], |i, a, b| {
        lines.distance(i, added(i, entry(i, a)), added(next(i), entry(next(i), b)))
    });
    // What the fit has to come to: Klipper takes what is below zero for one more.
    let fit = |value: f64| if value < 0.0 { value - 1.0 } else { value };
    let mut wanted: Vec<f64> = choice.iter().enumerate().map(|(i, k)| fit(entry(i, *k))).collect();
    wanted.push(wanted[0] + turn);
    let angle = |step: usize| {
        let value = turn * step as f64 / steps as f64;
        let node = (0..ENTRIES).find(|i| (wanted[*i]..wanted[*i + 1]).contains(&value))?;
        let part = (value - wanted[node]) / (wanted[node + 1] - wanted[node]);
        Some(rounded((turn * (node as f64 + part) / ENTRIES as f64).min(LAST_ANGLE)))
    };
    let angles: Option<Vec<f64>> = (0..steps).map(angle).collect();
    let angles =
        angles.filter(|angles| angles.windows(2).all(|pair| pair[0] < pair[1])).ok_or(TableError::Falls)?;
    let (calibration, off) = load_calibration(&angles);
    if off > SURE || calibration.windows(2).any(|pair| pair[1] <= pair[0]) {
        return Err(TableError::Falls);
    }
    Ok((angles, calibration))
}

/// An angle as it is written.
fn rounded(angle: f64) -> f64 {
    (angle * 1e6).round() / 1e6
}

/// The value of `calibrate`, as Klipper writes it, with more digits.
fn section(angles: &[f64]) -> String {
    let lines: Vec<String> = (angles.chunks(IN_A_LINE))
        .map(|chunk| chunk.iter().map(|angle| format!("{angle:.6}")).collect::<Vec<_>>().join(","))
        .collect();
    format!("calibrate =\n    {}\n", lines.join(",\n    "))
}
