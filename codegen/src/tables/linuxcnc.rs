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
use fitter::error_model::Sensor;
use fitter::terms::{Operator, Periodic, Product, Scope, Term};

use super::interpolate::Lines;
use super::{Asked, Table, TableError, TableFirmware, describe};
use crate::approximate::to_chebyshev;
use crate::budget;
use crate::exact::Interval;
use crate::extent::LeftOut;

/// `EMCMOT_COMP_SIZE`.
pub const MOST_ENTRIES: usize = 256;
/// Periods in the range for which there are four entries each.
const MOST_PERIODS: f64 = 63.0;
/// Places in a stretch at which the bound is computed.
const PLACES: usize = 64;
/// Steps of Newton's method.
const STEPS: usize = 30;
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
        let of = |way: usize| {
            let trim = trims(line)[way];
            let slope = lines
                .get(index + 1)
                .map_or(0.0, |next| (f64::from(trims(next)[way] - trim) / (next[0] - line[0])) as f32);
            (trim, slope)
        };
        Entry { nominal: line[0], trims: [of(0), of(1)] }
    };
    lines.iter().enumerate().map(entry).collect()
}

/// `backlash_corr` at a position; `way` 0 moves up, 1 down.
pub fn correction(entries: &[Entry], position: f64, way: usize) -> f64 {
    let after = entries.partition_point(|entry| entry.nominal <= position);
    match after.checked_sub(1) {
        Some(index) => in_stretch(&entries[index], position, way),
        None => f64::from(entries[0].trims[way].0),
    }
}

fn in_stretch(entry: &Entry, position: f64, way: usize) -> f64 {
    let (trim, slope) = entry.trims[way];
    f64::from(trim) + f64::from(slope) * (position - entry.nominal)
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
        let ways = [1.0, -1.0].map(|way| Lines::along(entries, |part| axis.trim(place(part), way)));
        let [(up, off_up), (down, off_down)] = [ways[0].best(), ways[1].best()];
        let minimax = off_up.max(off_down);
        let triplet = |index: usize| {
            let nominal = place(index as f64 / (entries - 1) as f64);
            [nominal, f64::from(up[index] as f32), f64::from(down[index] as f32)]
        };
        let triplets: Vec<[f64; 3]> = (0..entries).map(triplet).collect();
        let kept = stored(&triplets);
        let of = |way: usize| ways[way].worst(|node| f64::from(kept[node].trims[way].0));
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

/// What a position has to be commanded to.
struct Axis {
    /// Coefficients of the polynomial of the reading, about its centre.
    polynomial: Vec<f64>,
    centre: f64,
    /// Periodic errors of the true position: 2πk/p, and the coefficients of cosine and sine.
    waves: Vec<(f64, f64, f64)>,
    /// Half of the lost motion: what a move up adds to the error, and a move down takes off.
    half: f64,
    /// By how much the machine's positions are above the reference's: at position 0, or at the end nearest to it, the
    /// command is left as it is on average of both ways.
    zero: f64,
    /// How far a command may be from the centre.
    reach: f64,
    range: (f64, f64),
    /// Periods of the shortest wave in the range.
    periods: f64,
    /// The terms that are in the table.
    taken: Vec<Term>,
    left_out: Vec<LeftOut>,
}

impl Axis {
    fn of(coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Axis, TableError> {
        match &coefficients.sensor {
            Sensor::Direct { revolution: None, .. } => {}
            Sensor::Direct { .. } => return Err(TableError::Wraps),
            Sensor::EddyCurrentPair { .. } => return Err(TableError::NotDirect),
        }
        let covered = &coefficients.valid_range;
        let range = asked.options.range.unwrap_or((covered.from, covered.to));
        let beyond = range.0 < covered.from || range.1 > covered.to;
        if range.0 >= range.1 || (beyond && !asked.options.extrapolate) {
            return Err(TableError::Range { range, covered: (covered.from, covered.to) });
        }
        let mut axis = Axis {
            polynomial: [&coefficients.base.coefficients[..], &[0.0; 2]].concat(),
            centre: coefficients.base.centre,
            waves: Vec::new(),
            half: 0.0,
            zero: 0.0,
            reach: 0.0,
            range,
            periods: 0.0,
            taken: Vec::new(),
            left_out: Vec::new(),
        };
        for term in &coefficients.terms {
            match axis.take(term) {
                Ok(()) => axis.taken.push(term.clone()),
                Err(why) => {
                    let device = term.scope == Scope::Device;
                    axis.left_out.push(LeftOut::of(term, coefficients, axis.range, why, device));
                }
            }
        }
        axis.set_zero();
        axis.set_reach()?;
        Ok(axis)
    }

    /// Takes a term into the table, or says why it is left out.
    fn take(&mut self, term: &Term) -> Result<(), &'static str> {
        let weight = term.coefficients.first().copied().unwrap_or(0.0);
        Err(match &term.operator {
            _ if term.scope == Scope::Recording => "it belongs to the recording, not to the device",
            Operator::Play(play) if play.observable == "measured" => {
                let halves = play.elements.iter().zip(&term.coefficients);
                self.half += halves.map(|(element, c)| element.half_width * c).sum::<f64>();
                return Ok(());
            }
            Operator::Product(product) if factor(product, "direction").is_some() => {
                self.half += weight;
                self.polynomial[0] -= weight * factor(product, "direction").unwrap_or_default();
                return Ok(());
            }
            // A slope, and a constant.
            Operator::Product(product) if factor(product, "measured").is_some() => {
                self.polynomial[0] +=
                    weight * (self.centre - factor(product, "measured").unwrap_or_default());
                self.polynomial[1] += weight;
                return Ok(());
            }
            Operator::Periodic(periodic) if self.periods_of(periodic) > MOST_PERIODS => {
                "it has more periods than the file has entries for"
            }
            Operator::Periodic(periodic) => {
                self.periods = self.periods.max(self.periods_of(periodic));
                for (k, pair) in periodic.harmonics.iter().zip(term.coefficients.chunks_exact(2)) {
                    let rate = std::f64::consts::TAU * f64::from(*k) / periodic.period;
                    self.waves.push((rate, pair[0], pair[1]));
                }
                return Ok(());
            }
            Operator::Rate(_) => "a position alone does not tell the speed",
            _ => "it is no function of position and direction that the table is made of",
        })
    }

    /// Periods of the shortest wave in the range.
    fn periods_of(&self, periodic: &Periodic) -> f64 {
        let highest = periodic.harmonics.iter().copied().max().unwrap_or(0);
        (self.range.1 - self.range.0) * f64::from(highest) / periodic.period
    }

    /// Takes the zero off the polynomial.
    fn set_zero(&mut self) {
        let home = 0.0f64.clamp(self.range.0, self.range.1);
        let straight = home - self.polynomial_at(home).0;
        // r + P(r) = straight: the steps fall with P's slope, which the file's reader limits.
        let reference = (0..200).fold(straight, |reference, _| straight - self.waves_at(reference));
        self.zero = home - reference;
        self.polynomial[0] -= self.zero;
    }

    /// The largest distance of a command from the centre: R = r + the largest trim within R, so that all commands lie within.
    fn set_reach(&mut self) -> Result<(), TableError> {
        let positions = (self.range.0 - self.centre).abs().max((self.range.1 - self.centre).abs());
        let waves: f64 = self.waves.iter().map(|(_, a, b)| a.hypot(*b)).sum();
        self.reach = positions;
        for _ in 0..STEPS {
            let steepest = self.slopes(1);
            if steepest >= STEEPEST {
                return Err(TableError::Steep { steepest });
            }
            self.reach = (positions + self.slopes(0) + waves + self.half.abs()) * (1.0 + 1e-9);
        }
        Ok(())
    }

    /// The polynomial and its derivative at a command.
    fn polynomial_at(&self, command: f64) -> (f64, f64) {
        let x = command - self.centre;
        self.polynomial.iter().rev().fold((0.0, 0.0), |(v, s), c| (v * x + c, s * x + v))
    }

    /// The waves at a position on the reference's scale.
    fn waves_at(&self, reference: f64) -> f64 {
        let of = |(rate, a, b): &(f64, f64, f64)| a * (rate * reference).cos() + b * (rate * reference).sin();
        self.waves.iter().map(of).sum()
    }

    /// The trim at a position: `way` is 1 while the joint moves up, −1 while it moves down, 0 between both.
    fn trim(&self, position: f64, way: f64) -> f64 {
        let fixed = way * self.half + self.waves_at(position - self.zero);
        // m − q(m) = p + fixed, for the difference of m and p.
        let mut trim = fixed;
        for _ in 0..STEPS {
            let (value, slope) = self.polynomial_at(position + trim);
            let step = (trim - value - fixed) / (1.0 - slope);
            trim -= step;
            if step.abs() <= 2.0 * f64::EPSILON * trim.abs() {
                break;
            }
        }
        trim
    }

    /// Upper bound of the polynomial's derivative of this order at all commands: the sum of the magnitudes of its Chebyshev
    /// coefficients there.
    fn slopes(&self, order: usize) -> f64 {
        let reach = Interval::from_f64(self.reach);
        let mut power = Interval::from_int(1);
        let scaled = self.polynomial.iter().map(|c| {
            let scaled = &Interval::from_f64(*c) * &power;
            power = &power * &reach;
            scaled
        });
        let scaled: Vec<Interval> = scaled.collect();
        let mut series: Vec<f64> = to_chebyshev(&scaled).iter().map(Interval::to_f64).collect();
        for _ in 0..order {
            // c′ₖ₋₁ = c′ₖ₊₁ + 2k cₖ, and half of the first.
            let mut derivative = vec![0.0; series.len() + 1];
            for k in (1..series.len()).rev() {
                derivative[k - 1] = derivative[k + 1] + 2.0 * k as f64 * series[k];
            }
            derivative[0] *= 0.5;
            derivative.truncate(series.len() - 1);
            series = derivative;
        }
        let sum: f64 = series.iter().map(|c| c.abs()).sum();
        sum / self.reach.powi(order as i32) * (1.0 + 1e-9)
    }

    /// The largest distance of the stored table from the trims over all positions of the range and both
    /// directions: the largest at many places, what a curve can do between two of them, and what double precision rounds.
    fn bound(&self, kept: &[Entry]) -> f64 {
        let ways = [(0, 1.0), (1, -1.0)];
        let mut largest = 0.0f64;
        let mut widest = 0.0f64;
        for pair in kept.windows(2) {
            let width = pair[1].nominal - pair[0].nominal;
            widest = widest.max(width / PLACES as f64);
            for k in 0..=PLACES {
                let position = pair[0].nominal + width * k as f64 / PLACES as f64;
                for (way, sign) in ways {
                    let off = in_stretch(&pair[0], position, way) - self.trim(position, sign);
                    largest = largest.max(off.abs());
                }
            }
        }
        largest + 0.125 * widest * widest * self.curvature() + self.rounding()
    }

    /// Upper bound of the trim's second derivative: of m(p) with (1 − q′) m′ = 1 + P′.
    fn curvature(&self) -> f64 {
        let waves =
            |order: i32| self.waves.iter().map(|(rate, a, b)| a.hypot(*b) * rate.powi(order)).sum::<f64>();
        let straight = 1.0 - self.slopes(1);
        let slope = (1.0 + waves(1)) / straight;
        (waves(2) + self.slopes(2) * slope * slope) / straight
    }

    /// What double precision rounds of a trim: every operation of polynomial and waves, with the phase's error, a hundred
    /// units in the last place of all that is summed; the slope of the polynomial makes it larger.
    fn rounding(&self) -> f64 {
        let farthest = self.reach + self.centre.abs() + self.zero.abs();
        let waves: f64 = self.waves.iter().map(|(rate, a, b)| a.hypot(*b) * (1.0 + rate * farthest)).sum();
        let sum = self.slopes(0) + waves + self.half.abs() + farthest * (1.0 + self.slopes(1));
        100.0 * f64::EPSILON * sum / (1.0 - self.slopes(1))
    }
}

/// The mean from which a product counts the observable, where it is that alone.
fn factor(product: &Product, observable: &str) -> Option<f64> {
    match &product.factors[..] {
        [only] if only.observable == observable && only.power == 1 => Some(only.mean),
        _ => None,
    }
}

/// The slope from which on no inverse is claimed.
const STEEPEST: f64 = 0.5;
