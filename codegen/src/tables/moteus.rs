//! moteus: `motor_position.sources.N.compensation_table`, 256 × int8, and `compensation_scale`.
//!
//! After `fw/motor_position.h` of mjbots/moteus at db1a7623 (June 2026), functions `lerp` and `ISR_UpdateSources`. In
//! single precision, with r = count·(1/cpr), i = ⌊256 r⌋ and u = 256 (r − i/256):
//!
//! compensated = wrap(count + (tᵢ s/127 (1 − u) + tᵢ₊₁ s/127 u)·cpr)
//!
//! An entry holds *at* i/256 of the turn; the comment above the table there, which puts it at the middle of its stretch, is
//! older than the interpolation. The count is the source's after its own `offset` and `sign`.

use fitter::coefficients::Coefficients;
use rayon::prelude::*;

use super::interpolate::Lines;
use super::ring::Ring;
use super::single::Fused;
use super::{Asked, Table, TableError, TableFirmware, chain, describe};

/// Name of the file.
const FILE: &str = "compensation.cfg";
/// Entries of the table.
pub const ENTRIES: usize = 256;
/// The last source.
const LAST_SOURCE: u32 = 2;
/// Scales that are tried, and by how much the largest is above the smallest; places of the constant within a step.
const SCALES: usize = 48;
const WIDER: f64 = 0.06;
const CONSTANTS: usize = 12;

/// The firmware.
pub struct Moteus;

/// What the firmware is configured with.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensation {
    /// `compensation_table`.
    pub table: Vec<i8>,
    /// `compensation_scale`, in turns.
    pub scale: f32,
}

impl Compensation {
    /// `status.compensated_value` of a count, as the firmware computes it.
    pub fn compensated(&self, count: u32, cpr: u32, fused: Fused) -> f32 {
        if self.scale == 0.0 || self.table.iter().all(|entry| *entry == 0) {
            return count as f32;
        }
        let (scale, turn) = (self.scale / 127.0, cpr as f32);
        let inverse = 1.0 / turn;
        let ratio = count as f32 * inverse;
        let left = ((ratio * 256.0) as usize).min(ENTRIES - 1);
        let part = (ratio - left as f32 / 256.0) * 256.0;
        let comp = |at: usize| f32::from(self.table[at]) * scale;
        let (a, b) = (comp(left), comp((left + 1) % ENTRIES));
        let value = fused.blend([a, 1.0 - part], [b, part]);
        let sum = fused.other([value, turn], count as f32);
        let within = sum - (sum * inverse) as i32 as f32 * turn;
        if within >= 0.0 { within } else { within + turn }
    }
}

impl TableFirmware for Moteus {
    fn name(&self) -> &'static str {
        "moteus"
    }

    fn source(&self) -> &'static str {
        "fw/motor_position.h of github.com/mjbots/moteus, commit db1a7623"
    }

    fn takes(&self) -> &'static [&'static str] {
        &["--bits", "--counts", "--source"]
    }

    fn design(&self, coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Table, TableError> {
        let source = asked.wanted.source.unwrap_or(0);
        if source > LAST_SOURCE {
            return Err(TableError::Source { source, most: LAST_SOURCE });
        }
        let ring = Ring::of(self.name(), coefficients, asked, None)?;
        let lines = Lines::new(&ring, ENTRIES);
        let (chosen, constant) = choose(&ring, &lines);
        let cpr = ring.counts;
        let worst = ring.worst(constant, |count, fused| {
            f64::from(chosen.compensated(count, cpr, fused)) / f64::from(cpr)
        });
        let exact = lines.worst(|i| f64::from(chosen.table[i]) * f64::from(chosen.scale / 127.0) - constant);
        let bound = (worst * ring.revolution).next_up();
        let minimax = lines.best().1 * ring.revolution;
        let lsb = ring.revolution / f64::from(cpr);
        let parts = describe::parts([minimax, exact * ring.revolution], bound, lsb);
        Ok(Table {
            file: FILE,
            comment: "#",
            head_last: false,
            text: lines_of(&chosen, source),
            entries: ENTRIES,
            format: "int8 with one scale",
            degree: 1,
            input: format!(
                "the count of source {source}, 0 … {} (cpr {cpr}), after its offset and sign",
                cpr - 1
            ),
            output: ("f32", lsb),
            range: (0.0, f64::from(cpr - 1), "counts".into()),
            bound,
            parts,
            minimax,
            zero: (ring.zero + constant) * ring.revolution,
            left_out: ring.left_out.clone(),
            budget: ring.budget(coefficients, bound),
            load: vec![
                format!("moteus_tool --target 1 --restore-config {FILE}"),
                "If this source is used for commutation, calibrate the motor again afterwards: moteus_tool \
                 --target 1 --calibrate"
                    .into(),
            ],
        })
    }
}

/// The scale, the constant and the entries whose lines are nearest: every scale with every constant has its best entries.
fn choose(ring: &Ring, lines: &Lines) -> (Compensation, f64) {
    let (least, most) = ring.ends();
    let middle = 0.5 * (least + most);
    if most <= least {
        return (Compensation { table: vec![0; ENTRIES], scale: 0.0 }, -middle);
    }
    // The extremes may lie half a step beyond −128 and 127.
    let smallest = (most - least) / 256.0;
    let tried: Vec<(usize, usize)> =
        (0..SCALES).flat_map(|scale| (0..CONSTANTS).map(move |constant| (scale, constant))).collect();
    let found = tried.par_iter().map(|(scale, at)| {
        let step = smallest * (1.0 + WIDER * *scale as f64 / SCALES as f64);
        let scale = (127.0 * step) as f32;
        let step = f64::from(scale / 127.0);
        let constant = (*at as f64 / CONSTANTS as f64 - 0.5 - 0.5) * step - middle;
        let entry = |node: usize, k: usize| {
            let nearest = ((lines.at(node) + constant) / step).round() + k as f64 - 1.0;
            nearest.clamp(-128.0, 127.0)
        };
        let value = |node: usize, k: usize| entry(node, k) * step - constant;
        let (choice, worst) =
            chain::ring(&[3; ENTRIES], |i, a, b| lines.distance(i, value(i, a), value((i + 1) % ENTRIES, b)));
        let table = choice.iter().enumerate().map(|(node, k)| entry(node, *k) as i8).collect();
        (worst, Compensation { table, scale }, constant)
    });
    let found: Vec<_> = found.collect();
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or((Compensation { table: vec![0; ENTRIES], scale: 0.0 }, -middle), |(_, c, k)| (c, k))
}

/// The lines of the configuration, without `conf set`.
fn lines_of(chosen: &Compensation, source: u32) -> String {
    let key = format!("motor_position.sources.{source}");
    let mut text = format!("{key}.compensation_scale {:?}\n", chosen.scale);
    for (index, entry) in chosen.table.iter().enumerate() {
        text += &format!("{key}.compensation_table.{index} {entry}\n");
    }
    text
}
