//! What the devices share: range, input, degree, binary point; and the ranges in which their coefficients lie.

use fitter::error_model::{ErrorModel, Sensor};
use rayon::prelude::*;

use super::alike::{model, range};
use super::page::crc32;
use super::{Device, DevicesError, Wanted};
use crate::approximate::minimax;
use crate::bound::{self, Bound};
use crate::design::DesignError;
use crate::exact::{Interval, Polynomial};
use crate::format::Format;
use crate::fused::{LARGEST_DEGREE, supremum};
use crate::input::InputPlan;
use crate::options::{Options, RoutineOptions};
use crate::program::{Op, Operand, PageWord, Program, Stage, Type};
use crate::quantity::Quantity;
use crate::reference::Reference;
use crate::routine::{self, RoutineError};

/// The coefficients of one device, and what is proved of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// Words, constant first.
    pub words: Vec<i64>,
    /// |result − model| ≤ this over the range, in the result's unit.
    pub total: f64,
    /// Of this, the distance of the polynomial from the model.
    pub approximation: f64,
    /// Of this, the rounding of the input to the variable.
    pub input: f64,
}

/// A routine that is shared, and the devices' coefficients.
#[derive(Debug, Clone)]
pub struct Design {
    /// What was known before a degree was chosen.
    pub shared: Shared,
    /// The routine; its page holds the ranges.
    pub program: Program,
    /// Degree of the polynomials.
    pub degree: usize,
    /// A coefficient is a word of 2^−`bits` of the device.
    pub bits: i64,
    /// What one word of the result stands for, in its unit.
    pub unit: Interval,
    /// The bound of all devices and of later ones, in the result's unit: the one that was asked for.
    pub total: f64,
    /// Rounding for any coefficients inside their ranges, in the result's unit.
    pub rounding: f64,
    /// The devices' coefficients, in their order.
    pub fitted: Vec<Fitted>,
}

/// Finds the lowest degree that serves all devices.
///
/// # Errors
/// [`DevicesError`], which says what to change.
pub fn design(devices: &[Device], options: &Options, wanted: &Wanted) -> Result<Design, DevicesError> {
    if !(0.0..=10.0).contains(&wanted.margin) {
        return Err(DevicesError::Margin(wanted.margin));
    }
    let shared = Shared::new(devices, options, wanted, None)?;
    let (quantity, target) = (&shared.quantity, shared.target);
    let degrees = match options.degree {
        Some(degree) if !(1..=LARGEST_DEGREE).contains(&degree) => {
            return Err(RoutineError::Degree(degree).into());
        }
        Some(degree) => degree..=degree,
        None => 1..=LARGEST_DEGREE,
    };
    let largest = *degrees.end();
    let mut best: Option<(f64, usize)> = None;
    let mut without_margin: Option<Design> = None;
    for degree in degrees {
        let far = quantity.in_bound_unit(shared.furthest(degree));
        if far > target && degree < LARGEST_DEGREE && options.degree.is_none() {
            continue;
        }
        let design = shared.design(degree)?;
        let (worst, total) = (design.fitted.iter().map(|f| f.total).enumerate())
            .fold((0, 0.0), |(i, most), (j, total)| if total > most { (j, total) } else { (i, most) });
        let reached = quantity.in_bound_unit(total);
        if best.is_none_or(|(b, _)| reached < b) {
            best = Some((reached, worst));
        }
        // A degree more, where that leaves later devices their margin within the bound that is asked for.
        let roomy = reached * (1.0 + wanted.margin) <= target;
        if reached > target || (without_margin.is_some() && !roomy) {
            continue;
        }
        // So little less that no rounding of a device's conversion shows.
        let most = target * (1.0 - 1e-12) / quantity.bound_units_per_unit;
        let design = Design { total: most.max(total), rounding: design.any_rounding()?, ..design };
        if roomy || options.degree.is_some() {
            return Ok(design);
        }
        without_margin.get_or_insert(design);
    }
    without_margin.ok_or_else(|| {
        let (reachable, worst) = best.unwrap_or((f64::INFINITY, 0));
        let (worst, unit) = (devices[worst].name.clone(), quantity.bound_unit.clone());
        DevicesError::Unreachable { degree: largest, wanted: target, reachable, worst, unit }
    })
}

/// What all devices share before a degree is chosen.
#[derive(Debug, Clone)]
pub struct Shared {
    /// The input's steps and range.
    pub plan: InputPlan,
    /// What was asked for.
    pub options: RoutineOptions,
    /// The devices' functions over the range, in their order.
    pub references: Vec<Reference>,
    /// Names and units of what is computed, by the first unit's model.
    pub quantity: Quantity,
    /// Smallest and largest reading.
    pub range: (f64, f64),
    /// The first device's.
    pub sensor: Sensor,
    /// The bound that is asked for, in its unit.
    pub target: f64,
    /// See [`Wanted::margin`].
    pub margin: f64,
}

/// Fewer fractional bits than this are of no use.
const FEWEST_BITS: i64 = 8;

impl Shared {
    /// Holds the devices against each other, and encloses their functions over the range; `at` is that of an earlier
    /// routine.
    pub(super) fn new(
        devices: &[Device],
        options: &Options,
        wanted: &Wanted,
        at: Option<(f64, f64)>,
    ) -> Result<Shared, DevicesError> {
        let first = devices.first().ok_or_else(|| DevicesError::None { pattern: "nothing".into() })?;
        let routine_options = options.routines.first().cloned().unwrap_or(RoutineOptions::of(Format::Q31));
        let format = routine_options.format;
        if !matches!(format, Format::Q31 | Format::Q31Split) {
            return Err(DevicesError::Format(format.name()));
        }
        let models: Vec<ErrorModel> =
            devices.iter().map(|device| model(device, first, options)).collect::<Result<_, _>>()?;
        let quantity = Quantity::of(&models[0]);
        let asked = Options { range: at.or(options.range), ..options.clone() };
        let range = range(devices, &asked, &quantity)?;
        // What serves the device with the least noise serves all.
        let noise = devices.iter().filter_map(|device| device.coefficients.noise()).reduce(f64::min);
        let target = options.bound.unwrap_or_else(|| quantity.default_bound(range.0, range.1, noise));
        if !(target.is_finite() && target > 0.0) {
            return Err(RoutineError::Bound(target).into());
        }
        let sensor = models[0].sensor.clone();
        let plan = routine_options.input.plan(&sensor, range.0, range.1, format, true)?;
        let references: Vec<Reference> = (models.iter().zip(devices))
            .map(|(model, device)| {
                let steep = |cause| DevicesError::TooSteep { device: device.name.clone(), cause };
                routine::reference(model, &plan).map_err(steep)
            })
            .collect::<Result<_, _>>()?;
        let (options, margin) = (routine_options, wanted.margin);
        Ok(Shared { plan, options, references, quantity, range, sensor, target, margin })
    }

    /// The best polynomials of a degree.
    pub(super) fn best(&self, degree: usize) -> Vec<Polynomial> {
        let (from, to) = self.plan.range_in_v();
        self.references.par_iter().map(|r| minimax(&r.polynomial, degree, &from, &to)).collect()
    }

    /// The largest distance of the best polynomials from their models, in the result's unit.
    fn furthest(&self, degree: usize) -> f64 {
        let (from, to) = self.plan.range_in_v();
        let distances: Vec<f64> = (self.best(degree).par_iter().zip(&self.references))
            .map(|(best, reference)| supremum(best, reference, &from, &to).to_f64_down())
            .collect();
        distances.into_iter().fold(0.0, f64::max)
    }

    /// The program with the ranges, and the devices' coefficients: with as many fractional bits as leave no step room to
    /// overflow, whatever coefficients the ranges hold.
    fn design(&self, degree: usize) -> Result<Design, DesignError> {
        let best = self.best(degree);
        let largest = best
            .iter()
            .flat_map(|p| p.coefficients())
            .fold(Interval::zero(), |a, c| if a.certainly_le(&c.magnitude()) { c.magnitude() } else { a });
        let most = (30 - largest.log2_floor().unwrap_or(0)).min(self.options.output.most_fraction_bits());
        let mut bits = most;
        loop {
            let words: Vec<Vec<i64>> = best.iter().map(|p| rounded(p, degree, bits)).collect();
            let ranges = self.ranges(&words, degree);
            if ranges.iter().all(|w| i32::try_from(w.from).is_ok() && i32::try_from(w.to).is_ok()) {
                let checked = |made: (Program, Interval)| {
                    bound::rounding(&made.0, &self.plan)?;
                    Ok(made)
                };
                match self.program(ranges, bits).and_then(checked) {
                    Ok((program, unit)) => {
                        let fitted = self.bounds(&words, bits)?;
                        let (shared, total, rounding) = (self.clone(), 0.0, 0.0);
                        return Ok(Design { shared, program, degree, bits, unit, total, rounding, fitted });
                    }
                    Err(error) if bits <= FEWEST_BITS => return Err(error),
                    Err(_) => {}
                }
            }
            bits -= 1;
        }
    }

    /// The smallest and largest word of each coefficient, widened by the margin: of the polynomial's bend by a part of
    /// its largest coefficient, for a unit whose model is of another order has quite different ones.
    fn ranges(&self, words: &[Vec<i64>], degree: usize) -> Vec<PageWord> {
        let bend = words.iter().flat_map(|w| w.iter().skip(2)).map(|c| c.unsigned_abs()).max().unwrap_or(0);
        (0..=degree)
            .map(|k| {
                let of_units = words.iter().map(|w| w[k]);
                let (from, to) = of_units.fold((i64::MAX, i64::MIN), |(a, b), c| (a.min(c), b.max(c)));
                let own = from.unsigned_abs().max(to.unsigned_abs());
                let reach = if k < 2 { own } else { own.max(bend) } as f64;
                let more = (self.margin * reach).ceil() as i64;
                PageWord { name: format!("c{k}"), from: from - more, to: to + more }
            })
            .collect()
    }

    /// The program on a page with these ranges, and what its output word stands for.
    pub(super) fn program(&self, page: Vec<PageWord>, bits: i64) -> Result<(Program, Interval), DesignError> {
        let (format, output) = (self.options.format, self.options.output);
        let degree = page.len() - 1;
        let mut p = Program { page, ..self.plan.program.clone() };
        let x = Operand::Step(p.variable);
        let word = |p: &mut Program, k: usize| {
            p.push(Stage::Evaluation, &format!("c{k}"), Type::I32, Op::Word { index: k }, "")
        };
        let mut y = word(&mut p, degree);
        for k in (0..degree).rev() {
            let c = word(&mut p, k);
            y = p.push(Stage::Evaluation, "y", Type::I32, format.mul_add(y, x, 0, c), "");
        }
        let unit = output.from_fixed(&mut p, format, y, bits)?;
        Ok((p, unit))
    }

    /// The program on a page of one device, and what is proved of it against a function.
    fn proved(&self, words: &[i64], bits: i64, reference: &Reference) -> Result<Bound, DesignError> {
        let point = |(k, word): (usize, &i64)| PageWord { name: format!("c{k}"), from: *word, to: *word };
        let (program, unit) = self.program(words.iter().enumerate().map(point).collect(), bits)?;
        Ok(bound::bound(&program, &self.plan, reference, &unit)?)
    }

    /// What is proved of each device's words.
    pub(super) fn bounds(&self, words: &[Vec<i64>], bits: i64) -> Result<Vec<Fitted>, DesignError> {
        (words.par_iter().zip(&self.references))
            .map(|(words, reference)| {
                let Bound { total, approximation, input, .. } = self.proved(words, bits, reference)?;
                Ok(Fitted { words: words.clone(), total, approximation, input })
            })
            .collect()
    }
}

impl Design {
    /// How far the result is from the page's polynomial, in the result's unit, whatever the ranges hold. Errors are
    /// proved about the truncations' means, and those are what the program makes of coefficients that are all zero.
    pub(super) fn any_rounding(&self) -> Result<f64, DesignError> {
        let zero = Reference::constant(Interval::zero());
        let means = self.shared.proved(&vec![0; self.degree + 1], self.bits, &zero)?.approximation;
        let words = bound::rounding(&self.program, &self.shared.plan)?;
        Ok((&(&Interval::from_f64(words) * &self.unit) + &Interval::from_f64(means)).to_f64_up())
    }

    /// Tells pages of this routine from others: the CRC-32 of everything that gives a page's words their meaning.
    pub fn structure(&self) -> u32 {
        let Shared { options, range, sensor, .. } = &self.shared;
        let sensor = match sensor {
            Sensor::EddyCurrentPair { probe_distance_mm, .. } => format!("pair {probe_distance_mm:?}"),
            Sensor::Direct { unit, .. } => format!("direct {unit}"),
        };
        let text = format!(
            "{sensor} {options:?} {range:?} {} {} {:?} {:?}",
            self.degree, self.bits, self.total, self.program.page
        );
        crc32(text.as_bytes())
    }
}

pub(super) fn rounded(polynomial: &Polynomial, degree: usize, bits: i64) -> Vec<i64> {
    let mut words: Vec<i64> = polynomial
        .coefficients()
        .iter()
        .map(|c| c.mul_pow2(bits).round_to_i64().unwrap_or(i64::MAX))
        .collect();
    words.resize(degree + 1, 0);
    words
}
