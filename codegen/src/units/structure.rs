//! What the units share: range, input, degree, binary point; and the ranges in which their coefficients lie.

use fitter::error_model::{ErrorModel, Sensor};
use rayon::prelude::*;

use super::alike::{model, range};
use super::page::crc32;
use super::{Unit, UnitsError, Wanted};
use crate::approximate::minimax;
use crate::bound;
use crate::design::DesignError;
use crate::exact::{Interval, Polynomial};
use crate::format::Format;
use crate::fused::LARGEST_DEGREE;
use crate::input::InputPlan;
use crate::options::{Options, RoutineOptions};
use crate::output::OutputError;
use crate::program::{Op, Operand, PageWord, Program, Stage, Type};
use crate::quantity::Quantity;
use crate::reference::Reference;
use crate::routine::{self, RoutineError};

/// The coefficients of one unit, and what is proved of them.
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

/// The shared structure.
#[derive(Debug, Clone)]
pub struct Design {
    /// The routine; its page holds the ranges.
    pub program: Program,
    /// The input's steps and range.
    pub plan: InputPlan,
    /// What was asked for.
    pub options: RoutineOptions,
    /// Degree of the polynomials.
    pub degree: usize,
    /// A coefficient is a word of 2^−`bits` of the unit.
    pub bits: i64,
    /// What one word of the result stands for, in its unit.
    pub unit: Interval,
    /// Smallest and largest reading.
    pub range: (f64, f64),
    /// The bound of all units and of later ones, in the result's unit: the one that was asked for.
    pub total: f64,
    /// Rounding for any coefficients inside their ranges, in the result's unit.
    pub rounding: f64,
    /// The units' coefficients, in their order.
    pub fitted: Vec<Fitted>,
    /// Names and units of what is computed, by the first unit's model.
    pub quantity: Quantity,
    /// Tells pages of this routine from others.
    pub structure: u32,
}

/// Finds the lowest degree that serves all units.
///
/// # Errors
/// [`UnitsError`], which says what to change.
pub fn design(units: &[Unit], options: &Options, wanted: &Wanted) -> Result<Design, UnitsError> {
    if !(0.0..=10.0).contains(&wanted.margin) {
        return Err(UnitsError::Margin(wanted.margin));
    }
    let Prepared { plan, routine_options, references, quantity, range, sensor, target } =
        prepare(units, options, None)?;
    let shared =
        Shared { plan: &plan, options: &routine_options, references: &references, margin: wanted.margin };
    let degrees = match options.degree {
        Some(degree) if !(1..=LARGEST_DEGREE).contains(&degree) => {
            return Err(RoutineError::Degree(degree).into());
        }
        Some(degree) => degree..=degree,
        None => 1..=LARGEST_DEGREE,
    };
    let mut best: Option<(f64, usize, usize)> = None;
    let mut without_margin: Option<Design> = None;
    let mut largest = 1;
    for degree in degrees {
        largest = degree;
        let far = quantity.in_bound_unit(shared.furthest(degree));
        if far > target && degree < LARGEST_DEGREE && options.degree.is_none() {
            continue;
        }
        let (program, unit, bits, fitted) = shared.design(degree)?;
        let (worst, total) = (fitted.iter().map(|f| f.total).enumerate())
            .fold((0, 0.0), |(i, most), (j, total)| if total > most { (j, total) } else { (i, most) });
        let reached = quantity.in_bound_unit(total);
        if best.is_none_or(|(b, ..)| reached < b) {
            best = Some((reached, degree, worst));
        }
        if reached > target {
            continue;
        }
        if without_margin.is_some() && reached * (1.0 + wanted.margin) > target {
            continue;
        }
        let rounding = shared.rounding(&program, degree, bits)?;
        // So little less that no rounding of a unit's conversion shows.
        let most = target * (1.0 - 1e-12) / quantity.bound_units_per_unit;
        let mut design = Design {
            program,
            plan: plan.clone(),
            options: routine_options.clone(),
            degree,
            bits,
            unit,
            range,
            total: most.max(total),
            rounding,
            fitted,
            quantity: quantity.clone(),
            structure: 0,
        };
        design.structure = structure(&design, &sensor);
        // A degree more, where that leaves later units their margin within the bound that is asked for.
        if reached * (1.0 + wanted.margin) <= target || options.degree.is_some() {
            return Ok(design);
        }
        without_margin.get_or_insert(design);
    }
    if let Some(design) = without_margin {
        return Ok(design);
    }
    let (reachable, _, worst) = best.unwrap_or((f64::INFINITY, 0, 0));
    Err(UnitsError::Unreachable {
        degree: largest,
        wanted: target,
        reachable,
        worst: units[worst].name.clone(),
        unit: quantity.bound_unit,
    })
}

/// What all units share before a degree is chosen.
pub(super) struct Prepared {
    pub plan: InputPlan,
    pub routine_options: RoutineOptions,
    pub references: Vec<Reference>,
    pub quantity: Quantity,
    pub range: (f64, f64),
    pub sensor: Sensor,
    pub target: f64,
}

/// Holds the units against each other, and encloses their functions over the range; `at` is that of an earlier routine.
pub(super) fn prepare(
    units: &[Unit],
    options: &Options,
    at: Option<(f64, f64)>,
) -> Result<Prepared, UnitsError> {
    let first = units.first().ok_or_else(|| UnitsError::None { pattern: "--units".into() })?;
    let routine_options = options.routines.first().cloned().unwrap_or(RoutineOptions::of(Format::Q31));
    let format = routine_options.format;
    if !matches!(format, Format::Q31 | Format::Q31Split) {
        return Err(UnitsError::Format(format.name()));
    }
    let models: Vec<ErrorModel> =
        units.iter().map(|unit| model(unit, first, options)).collect::<Result<_, _>>()?;
    let quantity = Quantity::of(&models[0]);
    let range = match at {
        Some(at) => range(units, &Options { range: Some(at), ..options.clone() }, &quantity)?,
        None => range(units, options, &quantity)?,
    };
    // What serves the unit with the least noise serves all.
    let noises = units.iter().filter_map(|unit| unit.coefficients.noise());
    let noise = noises.reduce(f64::min);
    let target = options.bound.unwrap_or_else(|| quantity.default_bound(range.0, range.1, noise));
    if !(target.is_finite() && target > 0.0) {
        return Err(RoutineError::Bound(target).into());
    }
    let sensor = models[0].sensor.clone();
    let plan = routine_options.input.plan(&sensor, range.0, range.1, format.arithmetic(), true)?;
    let references: Vec<Reference> = (models.iter().zip(units))
        .map(|(model, unit)| {
            let steep = |cause| UnitsError::TooSteep { unit: unit.name.clone(), cause };
            routine::reference(model, &plan).map_err(steep)
        })
        .collect::<Result<_, _>>()?;
    Ok(Prepared { plan, routine_options, references, quantity, range, sensor, target })
}

pub(super) fn overflow(error: bound::Overflows) -> RoutineError {
    RoutineError::Design(DesignError::Overflows(error))
}

/// The units' references on the shared plan.
pub(super) struct Shared<'a> {
    pub plan: &'a InputPlan,
    pub options: &'a RoutineOptions,
    pub references: &'a [Reference],
    pub margin: f64,
}

/// Fewer fractional bits than this are of no use.
const FEWEST_BITS: i64 = 8;

impl Shared<'_> {
    fn ends(&self) -> (Interval, Interval) {
        let exponent = self.plan.program.variable_exponent;
        (self.plan.word_from.mul_pow2(-exponent), self.plan.word_to.mul_pow2(-exponent))
    }

    /// The best polynomials of a degree.
    pub fn best(&self, degree: usize) -> Vec<Polynomial> {
        let (from, to) = self.ends();
        self.references.par_iter().map(|r| minimax(&r.polynomial, degree, &from, &to)).collect()
    }

    /// The largest distance of the best polynomials from their models, in the result's unit.
    fn furthest(&self, degree: usize) -> f64 {
        let (from, to) = self.ends();
        let distances: Vec<f64> = (self.best(degree).par_iter().zip(self.references))
            .map(|(best, reference)| {
                let difference = best.sub(&reference.polynomial);
                let rough = difference.at(&from).magnitude().hull(&Interval::from_int(1).mul_pow2(-100));
                difference.supremum(&from, &to, &rough.magnitude().mul_pow2(-8)).to_f64_down()
            })
            .collect();
        distances.into_iter().fold(0.0, f64::max)
    }

    /// The program with the ranges, its unit, its binary point and the units' coefficients: with as many
    /// fractional bits as leave no step room to overflow, whatever coefficients the ranges hold.
    #[allow(clippy::type_complexity)]
    fn design(&self, degree: usize) -> Result<(Program, Interval, i64, Vec<Fitted>), RoutineError> {
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
            let fits =
                ranges.iter().all(|(from, to)| i32::try_from(*from).is_ok() && i32::try_from(*to).is_ok());
            let made = if fits { Some(self.program(&ranges, bits)) } else { None };
            match made {
                Some(Ok((program, unit))) => match bound::rounding(&program, self.plan) {
                    Ok(_) => {
                        let fitted = self.bounds(&words, bits)?;
                        return Ok((program, unit, bits, fitted));
                    }
                    Err(error) if bits <= FEWEST_BITS => return Err(overflow(error)),
                    Err(_) => {}
                },
                Some(Err(error)) if bits <= FEWEST_BITS => {
                    return Err(RoutineError::Design(DesignError::Output(error)));
                }
                _ => {}
            }
            bits -= 1;
        }
    }

    /// The smallest and largest word of each coefficient, widened by the margin: of the polynomial's bend by a part of
    /// its largest coefficient, for a unit whose model is of another order has quite different ones.
    fn ranges(&self, words: &[Vec<i64>], degree: usize) -> Vec<(i64, i64)> {
        let bend = words.iter().flat_map(|w| w.iter().skip(2)).map(|c| c.unsigned_abs()).max().unwrap_or(0);
        (0..=degree)
            .map(|k| {
                let of_units = words.iter().map(|w| w[k]);
                let (from, to) = of_units.fold((i64::MAX, i64::MIN), |(a, b), c| (a.min(c), b.max(c)));
                let own = from.unsigned_abs().max(to.unsigned_abs());
                let reach = if k < 2 { own } else { own.max(bend) } as f64;
                let more = (self.margin * reach).ceil() as i64;
                (from - more, to + more)
            })
            .collect()
    }

    pub fn program(&self, ranges: &[(i64, i64)], bits: i64) -> Result<(Program, Interval), OutputError> {
        let (format, output) = (self.options.format, self.options.output);
        let mut p = self.plan.program.clone();
        let x = Operand::Step(p.variable);
        p.page = (ranges.iter().enumerate())
            .map(|(k, (from, to))| PageWord { name: format!("c{k}"), from: *from, to: *to })
            .collect();
        let word = |p: &mut Program, k: usize| {
            p.push(Stage::Evaluation, &format!("c{k}"), Type::I32, Op::Word { index: k }, "")
        };
        let degree = ranges.len() - 1;
        let mut y = word(&mut p, degree);
        for k in (0..degree).rev() {
            let c = word(&mut p, k);
            y = p.push(Stage::Evaluation, "y", Type::I32, format.mul_add(y, x, 0, c), "");
        }
        let unit = output.from_fixed(&mut p, format, y, bits)?;
        Ok((p, unit))
    }

    /// How far the result is from the page's polynomial, in the result's unit, whatever the ranges hold. Errors are
    /// proved about the truncations' means, and those are what the program makes of coefficients that are all zero.
    pub fn rounding(&self, program: &Program, degree: usize, bits: i64) -> Result<f64, RoutineError> {
        let zeros = vec![(0, 0); degree + 1];
        let made = self.program(&zeros, bits);
        let (nothing, unit) = made.map_err(|e| RoutineError::Design(DesignError::Output(e)))?;
        let zero =
            Reference { polynomial: Polynomial::constant(Interval::zero()), remainder: Interval::zero() };
        let means = bound::bound(&nothing, self.plan, &zero, &unit).map_err(overflow)?.approximation;
        let words = bound::rounding(program, self.plan).map_err(overflow)?;
        Ok((&(&Interval::from_f64(words) * &unit) + &Interval::from_f64(means)).to_f64_up())
    }

    /// What is proved of each unit's words.
    pub fn bounds(&self, words: &[Vec<i64>], bits: i64) -> Result<Vec<Fitted>, RoutineError> {
        (words.par_iter().zip(self.references))
            .map(|(words, reference)| {
                let points: Vec<(i64, i64)> = words.iter().map(|w| (*w, *w)).collect();
                let made = self.program(&points, bits);
                let (program, unit) = made.map_err(|e| RoutineError::Design(DesignError::Output(e)))?;
                let bound = bound::bound(&program, self.plan, reference, &unit).map_err(overflow)?;
                Ok(Fitted {
                    words: words.clone(),
                    total: bound.total,
                    approximation: bound.approximation,
                    input: bound.input,
                })
            })
            .collect()
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

/// The CRC-32 of everything that gives a page's words their meaning.
pub(super) fn structure(design: &Design, sensor: &Sensor) -> u32 {
    let sensor = match sensor {
        Sensor::EddyCurrentPair { probe_distance_mm, .. } => format!("pair {probe_distance_mm:?}"),
        Sensor::Direct { unit, .. } => format!("direct {unit}"),
    };
    let text = format!(
        "{sensor} {:?} {:?} {} {} {:?} {:?}",
        design.options, design.range, design.degree, design.bits, design.total, design.program.page
    );
    crc32(text.as_bytes())
}
