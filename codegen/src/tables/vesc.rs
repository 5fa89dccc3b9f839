//! VESC: `enc_corr`, a whole *electrical* degree for each mechanical one, without interpolation.
//!
//! After `motor/mcpwm_foc.c` of vedderb/bldc at b9d287b3 (firmware 7.01, August 2026), and `ext_enc_corr` in
//! `lispBM/lispif_vesc_extensions.c`, which takes −120 … 120. With the encoder's angle a in degrees and its ratio ρ:
//!
//! phase = norm(a ρ − offset − t₍⌊a⌋₎), of an inverted encoder norm((360 − a) ρ − offset − t₍⌊a⌋₎)
//!
//! The angle is `(float)count * 360.0 / counts`, as the encoders of VESC compute it. The correction is exact, so that what
//! single precision rounds of the phase is what it rounds without a table; it is added to the bound.

use fitter::coefficients::Coefficients;

use super::ring::Ring;
use super::{Asked, Table, TableError, TableFirmware, describe};

/// Entries of the table.
pub const ENTRIES: usize = 360;
/// The largest entry that is taken.
const LARGEST: f64 = 120.0;
/// Places of the constant within a degree that are tried.
const CONSTANTS: usize = 200;
/// Roundings of the phase: product, offset, table, and two steps of the turn; each of half a unit in the last place.
const ROUNDINGS: f64 = 5.0;
/// Name of the file.
const FILE: &str = "enc_corr.lisp";

/// The firmware.
pub struct Vesc;

/// The index of a count's entry.
pub fn index(count: u32, counts: u32) -> usize {
    let angle = (f64::from(count as f32) * 360.0 / f64::from(counts)) as f32;
    (angle as usize).min(ENTRIES - 1)
}

impl TableFirmware for Vesc {
    fn name(&self) -> &'static str {
        "vesc"
    }

    fn source(&self) -> &'static str {
        "motor/mcpwm_foc.c of github.com/vedderb/bldc, commit b9d287b3 (firmware 7.01)"
    }

    fn takes(&self) -> &'static [&'static str] {
        &["--bits", "--counts", "--ratio"]
    }

    fn design(&self, coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Table, TableError> {
        let ring = Ring::of(self.name(), coefficients, asked, None)?;
        let ratio = asked.wanted.ratio.ok_or(TableError::NoRatio)?;
        if !(ratio.is_finite() && ratio.abs() >= 1.0) {
            return Err(TableError::Ratio { ratio });
        }
        // From turns to electrical degrees. The table is taken off, of an inverted encoder from a phase that falls.
        let electrical = -360.0 * ratio;
        let (least, most) = ring.ends();
        let half = 0.5 * (most - least) * electrical.abs();
        if half > LARGEST {
            return Err(TableError::Large { half, largest: LARGEST, unit: "electrical degrees" });
        }
        let cells = Cells::new(&ring);
        let (table, constant) = cells.choose(electrical, -0.5 * (least + most));
        let correction = |count: u32| f64::from(table[index(count, ring.counts)]) / electrical;
        let phase = 360.0 * (ratio.abs() + 2.0);
        let rounding = ROUNDINGS * 0.5 * f64::from(f32::EPSILON) * phase / electrical.abs();
        let worst =
            ring.worst(constant, |count, _| f64::from(count) / f64::from(ring.counts) + correction(count));
        let bound = ((worst + rounding) * ring.revolution).next_up();
        let minimax = cells.widest() * ring.revolution;
        Ok(Table {
            file: FILE,
            comment: ";",
            head_last: false,
            text: script(&table),
            entries: ENTRIES,
            format: "whole electrical degrees, int8",
            degree: 0,
            input: format!(
                "the encoder's angle, {} counts to the turn; foc_encoder_ratio {}, {}inverted",
                ring.counts,
                ratio.abs(),
                if ratio < 0.0 { "" } else { "not " }
            ),
            output: ("f32", ring.revolution / electrical.abs()),
            range: (0.0, f64::from(ring.counts - 1), "counts".into()),
            bound,
            parts: describe::parts(
                [minimax, worst * ring.revolution],
                bound,
                ring.revolution / electrical.abs(),
            ),
            minimax,
            zero: (ring.zero + constant) * ring.revolution,
            left_out: ring.left_out.clone(),
            budget: ring.budget(coefficients, bound),
            load: vec![
                format!("VESC Tool, VESC Dev Tools, Lisp: open {FILE}, and run it once"),
                "Detect the encoder's offset again afterwards, with the correction enabled".into(),
            ],
        })
    }
}

/// The least and the most that is wanted within each entry's degree, in turns.
struct Cells(Vec<(f64, f64)>);

impl Cells {
    fn new(ring: &Ring) -> Cells {
        let mut cells = vec![(f64::INFINITY, f64::NEG_INFINITY); ENTRIES];
        for (count, wanted) in (0..).zip(&ring.wanted) {
            let cell = &mut cells[index(count, ring.counts)];
            *cell = (cell.0.min(*wanted), cell.1.max(*wanted));
        }
        // Of fewer than 360 counts some entries are never read.
        cells.iter_mut().filter(|cell| cell.0 > cell.1).for_each(|cell| *cell = (0.0, 0.0));
        Cells(cells)
    }

    /// What is left where every degree has the best constant there is.
    fn widest(&self) -> f64 {
        self.0.iter().map(|(least, most)| 0.5 * (most - least)).fold(0.0, f64::max)
    }

    /// The whole entries and the constant that leave least; `centre` is a constant in turns that makes what is wanted as
    /// small as it can be.
    fn choose(&self, electrical: f64, centre: f64) -> (Vec<i8>, f64) {
        let mut best = (Vec::new(), 0.0, f64::INFINITY);
        for k in 0..CONSTANTS {
            let constant = centre + (k as f64 / CONSTANTS as f64 - 0.5) / electrical;
            let entry = |(least, most): &(f64, f64)| {
                ((0.5 * (least + most) + constant) * electrical).round().clamp(-LARGEST, LARGEST) as i8
            };
            let table: Vec<i8> = self.0.iter().map(entry).collect();
            let off = self.0.iter().zip(&table).map(|((least, most), entry)| {
                let value = f64::from(*entry) / electrical - constant;
                (value - least).abs().max((value - most).abs())
            });
            let worst = off.fold(0.0, f64::max);
            if worst < best.2 {
                best = (table, constant, worst);
            }
        }
        (best.0, best.1)
    }
}

/// The script that sets every entry, enables the correction and stores it.
fn script(table: &[i8]) -> String {
    let entries = table.iter().enumerate().map(|(angle, entry)| format!("(enc-corr {angle} {entry})\n"));
    let entries: String = entries.collect();
    format!("(enc-corr-en 0)\n{entries}(enc-corr-en 1)\n(store-backup)\n")
}
