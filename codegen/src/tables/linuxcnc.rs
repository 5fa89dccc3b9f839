//! LinuxCNC: `COMP_FILE`, up to 256 lines *nominal forward reverse*, straight lines between them, for each direction.
//!
//! After `src/emc/motion` of LinuxCNC/linuxcnc at 5c41560e (2.10.0~pre1, August 2026): `usrmotLoadComp` in `usrmotintf.cc`
//! reads the lines, `EMCMOT_SET_JOINT_COMP` in `command.c` stores trims and slopes in single precision, and
//! `compute_screw_comp` in `control.c` adds, in double precision, for a position p from nominal pᵢ on
//!
//! forwardᵢ + slopeᵢ (p − pᵢ) while the joint moves up, the same of reverse while it moves down
//!
//! to the position that is commanded. Before the first nominal and after the last the outermost trims hold. The file is of
//! type 1, whose numbers are the trims; of type 0 they are positions, from which LinuxCNC takes trims that hold at another
//! place. Reading ends at the first line that is no triplet: a head at the top would switch the compensation off.
//!
//! The reading is what the machine is commanded to, the reference where it goes. So that it goes to p it has to be
//! commanded to m with m − Δ(m) = p, and the trim is m − p.

use fitter::coefficients::Coefficients;

use super::axis::Axis;
use super::interpolate::Lines;
use super::{Asked, Table, TableError, TableFirmware, describe};
use crate::budget;

/// `EMCMOT_COMP_SIZE`.
pub const MOST_ENTRIES: usize = 256;
/// Name of the file.
const FILE: &str = "joint.comp";

/// The firmware.
pub struct LinuxCnc;

/// A line as LinuxCNC keeps it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Where it holds.
    pub nominal: f64,
    /// Forward and reverse: the trim, and its slope up to the next nominal.
    pub trims: [(f32, f32); 2],
}

/// The entries of lines *nominal forward reverse*, as `EMCMOT_SET_JOINT_COMP` stores them.
pub fn stored(lines: &[[f64; 3]]) -> Vec<Entry> {
    let trims = |line: &[f64; 3]| [line[1] as f32, line[2] as f32];
    let entry = |(index, line): (usize, &[f64; 3])| {
        let of = |direction: usize| {
            let trim = trims(line)[direction];
            let slope = lines
                .get(index + 1)
                .map_or(0.0, |next| (f64::from(trims(next)[direction] - trim) / (next[0] - line[0])) as f32);
            (trim, slope)
        };
        Entry { nominal: line[0], trims: [of(0), of(1)] }
    };
    lines.iter().enumerate().map(entry).collect()
}

/// `backlash_corr` at a position; `direction` 0 moves up, 1 down.
pub fn correction(entries: &[Entry], position: f64, direction: usize) -> f64 {
    let after = entries.partition_point(|entry| entry.nominal <= position);
    let Some(index) = after.checked_sub(1) else { return f64::from(entries[0].trims[direction].0) };
    let (trim, slope) = entries[index].trims[direction];
    f64::from(trim) + f64::from(slope) * (position - entries[index].nominal)
}

impl TableFirmware for LinuxCnc {
    fn name(&self) -> &'static str {
        "linuxcnc"
    }

    fn source(&self) -> &'static str {
        "src/emc/motion/control.c of github.com/LinuxCNC/linuxcnc, commit 5c41560e (2.10.0~pre1)"
    }

    fn takes(&self) -> &'static [&'static str] {
        &["--from and --to", "--extrapolate", "--entries"]
    }

    fn design(&self, coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Table, TableError> {
        let entries = asked.wanted.entries.unwrap_or(MOST_ENTRIES);
        let axis = Axis::of(coefficients, asked)?;
        let fewest = 2 + (4.0 * axis.periods).ceil() as usize;
        if !(fewest..=MOST_ENTRIES).contains(&entries) {
            return Err(TableError::Entries {
                entries,
                fewest,
                most: MOST_ENTRIES,
                periods: axis.periods.ceil() as u32,
            });
        }
        let (from, to) = axis.range;
        let place = |part: f64| from + (to - from) * part;
        let directions =
            [1.0, -1.0].map(|direction| Lines::along(entries, |part| axis.trim(place(part), direction)));
        let [(up, off_up), (down, off_down)] = [directions[0].best(), directions[1].best()];
        let minimax = off_up.max(off_down);
        let triplet = |index: usize| {
            let nominal = place(index as f64 / (entries - 1) as f64);
            [nominal, f64::from(up[index] as f32), f64::from(down[index] as f32)]
        };
        let triplets: Vec<[f64; 3]> = (0..entries).map(triplet).collect();
        let kept = stored(&triplets);
        let of =
            |direction: usize| directions[direction].worst(|node| f64::from(kept[node].trims[direction].0));
        let written = of(0).max(of(1));
        let bound = axis.bound(&kept);
        let unit = coefficients.sensor.error_unit().to_string();
        Ok(Table {
            file: FILE,
            comment: "#",
            head_last: true,
            text: triplets.iter().map(|[p, f, r]| format!("{p:?} {f:?} {r:?}\n")).collect(),
            entries,
            format: "triplets of type 1, single precision",
            degree: 1,
            input: format!(
                "the commanded position in {unit}, the machine's unit, after a reversal has been run off"
            ),
            output: ("f64", 1.0),
            range: (from, to, unit),
            bound,
            parts: describe::parts([minimax, written], bound, 1.0),
            minimax,
            zero: axis.zero,
            left_out: axis.left_out.iter().map(ToString::to_string).collect(),
            budget: budget::of_axis(coefficients, axis.taken, axis.left_out, axis.range, bound),
            load: vec![
                format!("[JOINT_N] COMP_FILE = {FILE}, COMP_FILE_TYPE = 1; BACKLASH is not used then"),
                "This text may stay where it is: LinuxCNC reads up to the first line that is no triplet"
                    .into(),
            ],
        })
    }
}
