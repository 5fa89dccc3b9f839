//! The method of one fused polynomial: the whole corrected angle θ(s) − Δθ(s) by Horner's scheme, in fixed
//! point or in floats.

use crate::approximate::{chebyshev, least_distance, minimax};
use crate::bound;
use crate::design::{Design, DesignError};
use crate::exact::{Interval, Polynomial};
use crate::format::Format;
use crate::input::InputPlan;
use crate::output::Output;
use crate::program::{Operand, Program, Stage, Type};
use crate::quantize;
use crate::reference::Reference;

/// The highest degree that is tried.
pub const LARGEST_DEGREE: usize = 16;

/// Designs the routine of the given degree; `headroom` bits of the last sum are left to what is added to it. Floats take a
/// linear coefficient of two where one does not bring the bound down to `enough`, and two do better.
///
/// # Errors
/// [`DesignError`] where the output's format cannot hold the range.
pub fn design(
    plan: &InputPlan,
    reference: &Reference,
    (format, output): (Format, Output),
    degree: usize,
    headroom: i64,
    enough: f64,
) -> Result<Design, DesignError> {
    let (from, to) = plan.range_in_v();
    let best = minimax(&reference.polynomial, degree, &from, &to);
    let minimax = nearer_than_none(&best, reference, degree, &from, &to).to_f64_down();
    let build = |grid: &Grid, search: bool| -> Result<Design, DesignError> {
        let mut units: Vec<i64> = best
            .coefficients()
            .iter()
            .zip(&grid.bits)
            .enumerate()
            .map(|(k, (c, &bits))| (c - &grid.first(k)).mul_pow2(bits).round_to_i64().unwrap_or(0))
            .collect();
        let (program, unit) = grid.program(plan, format, output, &units)?;
        let words = bound::words(&program, plan);
        // Which correction of the coefficients brings the program, with all its biases, nearest.
        let residual = reference
            .polynomial
            .sub(&bound::output_polynomial(&program, plan, &words.0, &words.1)?.scale(&unit));
        let lsb: Vec<f64> = grid.bits.iter().map(|&k| Interval::pow2(-k).to_f64()).collect();
        if search {
            let roundings = bound::roundings(&program, plan, &unit)?;
            let correction = quantize::nearest(&residual, &lsb, (&from, &to), &roundings);
            units.iter_mut().zip(&correction).for_each(|(u, d)| *u += d);
        }
        let (program, unit) = grid.program(plan, format, output, &units)?;
        let bound = bound::bound(&program, plan, reference, &unit)?;
        let (segments, sum_bits, account) = (1, grid.bits[0], None);
        Ok(Design { program, bound, degree, segments, minimax, unit, sum_bits, account })
    };
    if !format.is_fixed() {
        let one = of_exact_sums(Grid::float(&best), &best, (&from, &to), format, &build)?;
        if one.bound.total <= enough {
            return Ok(one);
        }
        let two = Grid::float(&best).with_two_linear(&best, format);
        let two = of_exact_sums(two, &best, (&from, &to), format, &build)?;
        return Ok(if two.bound.total < one.bound.total { two } else { one });
    }
    let reach = plan.reach_in_v();
    let least = headroom;
    // A sum may leave its type at its end by a few units: then one bit less, and again. On a short range the
    // search may move high coefficients so far, for next to nothing, that no headroom is enough: then each
    // coefficient is rounded alone.
    let fixed = |common: bool| {
        let grid =
            |headroom| Grid::fixed(&best, (&reach.0, &reach.1), format, output, least + headroom, common);
        let attempts = (0..=MOST_HEADROOM).map(|bits| (bits, true)).chain([(1, false), (2, false)]);
        let mut last = build(&grid(0), true);
        for (headroom, search) in attempts.skip(1) {
            if !matches!(last, Err(DesignError::Overflows(_))) {
                break;
            }
            last = build(&grid(headroom), search);
        }
        last
    };
    // One binary point for all is simpler and an instruction a step cheaper; finer ones must earn that.
    match (fixed(true), fixed(false)) {
        (Ok(common), Ok(stepped)) if common.bound.total > WORTH_A_SHIFT * stepped.bound.total => Ok(stepped),
        (Ok(common), _) => Ok(common),
        (Err(_), stepped) => stepped,
    }
}

/// The design of floats of this grid, or of one on which some coefficients are so coarse that the sums they are in are exact,
/// where that makes the bound smaller.
fn of_exact_sums(
    mut grid: Grid,
    best: &Polynomial,
    (from, to): (&Interval, &Interval),
    format: Format,
    build: &dyn Fn(&Grid, bool) -> Result<Design, DesignError>,
) -> Result<Design, DesignError> {
    let mut design = build(&grid, true)?;
    // A product that is rounded together with the sum has more bits than any coefficient.
    let rounds = format == Format::F32 && design.bound.evaluation > design.bound.approximation;
    let coarser = if rounds { grid.of_exact_sums(best, from, to) } else { Vec::new() };
    let lower = |now: f64, before: f64| now < WORTH_COARSER * before;
    for (k, bits) in coarser {
        let mut tried = grid.clone();
        tried.bits[k] = bits;
        // The rounding is nearly the same whatever coefficients are found.
        if !lower(build(&tried, false)?.bound.rounding, design.bound.rounding) {
            continue;
        }
        let better = build(&tried, true)?;
        if lower(better.bound.total, design.bound.total) {
            (grid, design) = (tried, better);
        }
    }
    Ok(design)
}

/// The steps of a polynomial of this degree in one common format, whatever its coefficients.
///
/// # Errors
/// [`DesignError`] as for [`design`].
pub fn outline(
    plan: &InputPlan,
    (format, output): (Format, Output),
    degree: usize,
) -> Result<Program, DesignError> {
    let grid = Grid { bits: vec![format.bits() - 1; degree + 1], first: None };
    grid.program(plan, format, output, &vec![1; degree + 1]).map(|(program, _)| program)
}

/// What no polynomial of `degree` betters, in the reference's unit, estimated in floats and far sooner than [`best_error`]: π/4 of every further Chebyshev coefficient of the
/// function, for Tₖ is orthogonal to it; in fixed point also half a unit of the last product, whose sum reaches about as
/// far as the function.
pub fn least_error(plan: &InputPlan, reference: &Reference, format: Format, degree: usize) -> f64 {
    let (from, to) = plan.range_in_v();
    let centre = from.hull(&to).midpoint();
    let series = chebyshev(&reference.polynomial, &centre, &(&to - &centre));
    let further = series.iter().skip(degree + 1);
    let approximation = std::f64::consts::FRAC_PI_4 * further.map(|c| c.to_f64().abs()).fold(0.0, f64::max);
    let span = (&reference.polynomial.at(&to) - &reference.polynomial.at(&from)).to_f64().abs();
    let unit = if format.is_fixed() { 0.5 * span * 0.5f64.powi(format.bits() as i32) } else { 0.0 };
    approximation.max(0.5 * unit)
}

/// A lower bound of the supremum error of any polynomial of `degree`, in the reference's unit; the best one's is more by
/// less than a thousandth.
pub fn best_error(plan: &InputPlan, reference: &Reference, degree: usize) -> Interval {
    let (from, to) = plan.range_in_v();
    let best = minimax(&reference.polynomial, degree, &from, &to);
    nearer_than_none(&best, reference, degree, &from, &to)
}

/// The same, given the best polynomial.
fn nearer_than_none(
    best: &Polynomial,
    reference: &Reference,
    degree: usize,
    from: &Interval,
    to: &Interval,
) -> Interval {
    let least = &least_distance(&reference.polynomial, best, degree, from, to) - &reference.remainder;
    least.lower().magnitude_max(&Interval::zero())
}

/// The largest distance of a polynomial from the reference's, enclosed, for v from `from` to `to` (points).
pub(crate) fn supremum(
    polynomial: &Polynomial,
    reference: &Reference,
    from: &Interval,
    to: &Interval,
) -> Interval {
    let difference = polynomial.sub(&reference.polynomial);
    let rough = difference.at(from).magnitude().hull(&Interval::pow2(-100)).magnitude();
    difference.supremum(from, to, &rough.mul_pow2(-11))
}

/// Bits of a float's significand.
const FLOAT_BITS: i64 = 24;

/// A common binary point is kept while its bound is at most so much larger.
const WORTH_A_SHIFT: f64 = 1.25;

/// A coefficient is made coarser where the bound is then at most so much of what it was.
const WORTH_COARSER: f64 = 0.999;

/// So many bits are given up at most where a sum would leave its type.
const MOST_HEADROOM: i64 = 4;

/// Where the binary point of every coefficient stands: cₖ of vᵏ is an integer times 2^−bits[k].
#[derive(Clone)]
struct Grid {
    bits: Vec<i64>,
    /// Of a linear coefficient of two floats the first; the grid is that of the second.
    first: Option<Interval>,
}

impl Grid {
    /// Fixed point: as many bits as the largest partial sum of Horner's scheme from coefficient k on leaves,
    /// never more than a later one, so that only left shifts are needed on the way; or, `common`, the
    /// coarsest of these for all.
    fn fixed(
        best: &Polynomial,
        (from, to): (&Interval, &Interval),
        format: Format,
        output: Output,
        headroom: i64,
        common: bool,
    ) -> Self {
        let c = best.coefficients();
        let room = |k: usize| {
            let partial = Polynomial::new(c[k..].to_vec());
            let tolerance = partial.range(from, to).magnitude().mul_pow2(-10);
            let reach = partial.supremum(from, to, &tolerance).upper().hull(&c[k]);
            format.bits() - 1 - headroom - reach.log2_floor().unwrap_or(-120).max(-120)
        };
        let mut bits: Vec<i64> = (0..c.len()).map(room).collect();
        // The last sum cannot be finer than what is added to it.
        bits[0] = bits[0].min(bits[1]).min(output.most_fraction_bits());
        for k in 1..bits.len() {
            bits[k] = bits[k].min(bits[k - 1]);
        }
        if common {
            let coarsest = bits[bits.len() - 1];
            bits.fill(coarsest);
        }
        bits[0] = (bits[0] + format.last_gain()).min(output.most_fraction_bits());
        Grid { bits, first: None }
    }

    /// Floats: 24 bits each.
    fn float(best: &Polynomial) -> Self {
        let bits = |c: &Interval| FLOAT_BITS - 1 - c.log2_floor().unwrap_or(-100).max(-100);
        Grid { bits: best.coefficients().iter().map(bits).collect(), first: None }
    }

    /// Coefficients that are smaller than the sum that they are added to, and the bits by which they are multiples of its unit
    /// in the last place, the highest first: where the product before has that unit too, the sum is exact then.
    fn of_exact_sums(&self, best: &Polynomial, from: &Interval, to: &Interval) -> Vec<(usize, i64)> {
        let c = best.coefficients();
        let reach = |k: usize| {
            let partial = Polynomial::new(c[k..].to_vec());
            let tolerance = partial.range(from, to).magnitude().mul_pow2(-10);
            partial.supremum(from, to, &tolerance).upper()
        };
        let reaches: Vec<Interval> = (0..c.len()).map(reach).collect();
        let log2 = |value: &Interval| value.log2_floor().unwrap_or(-100);
        let radius = from.hull(to).magnitude();
        let bits = |k: usize| FLOAT_BITS - 1 - log2(&reaches[k]);
        let may =
            |k: &usize| bits(*k) < self.bits[*k] && log2(&(&reaches[k + 1] * &radius)) >= log2(&reaches[*k]);
        (0..c.len() - 1).rev().filter(may).map(|k| (k, bits(k))).collect()
    }

    /// The same with a linear coefficient of two floats. Where product and sum are rounded together, the first is the
    /// nearest float. Where each is, it is the nearest power of two, of which the product is exact. What it leaves has so
    /// many bits that a search has some to spare.
    fn with_two_linear(mut self, best: &Polynomial, format: Format) -> Self {
        let linear = &best.coefficients()[1];
        let nearest = Interval::from_int(linear.mul_pow2(self.bits[1]).round_to_i64().unwrap_or(0));
        let first = match linear.log2_floor() {
            Some(log2) if format == Format::F32 => {
                let below = Interval::pow2(log2);
                let above = linear.to_f64().abs() > 1.5 * below.to_f64();
                let size = below.mul_pow2(above.into());
                if linear.to_f64() < 0.0 { -size } else { size }
            }
            _ => nearest.mul_pow2(-self.bits[1]),
        };
        let rest = (linear - &first).log2_floor();
        self.bits[1] = match rest {
            Some(log2) if format == Format::F32 => FLOAT_BITS - 2 - log2,
            _ => self.bits[1] + FLOAT_BITS - 1,
        };
        self.first = Some(first);
        self
    }

    /// What is not searched of coefficient k.
    fn first(&self, k: usize) -> Interval {
        self.first.clone().filter(|_| k == 1).unwrap_or_else(Interval::zero)
    }

    /// The program with coefficients `units[k]·2^−bits[k]`, and what its output word stands for.
    fn program(
        &self,
        plan: &InputPlan,
        format: Format,
        output: Output,
        units: &[i64],
    ) -> Result<(Program, Interval), DesignError> {
        let mut p = plan.program.clone();
        let x = Operand::Step(p.variable);
        let n = units.len() - 1;
        match format {
            Format::Q31 | Format::Q31Split | Format::Q15 => {
                let value = |k: usize| Interval::from_int(units[k]).mul_pow2(-self.bits[k]).to_f64();
                let note = |k: usize| format!("c{k} = {:.9e}, in 2^-{}", value(k), self.bits[k]);
                let mut y = Operand::Int(units[n]);
                for k in (0..n).rev() {
                    let shift = (self.bits[k] - self.bits[k + 1]) as u32;
                    let op = format.mul_add(y, x, shift, Operand::Int(units[k]));
                    y = p.push(Stage::Evaluation, "y", Type::I32, op, note(k));
                }
                let unit = output.from_fixed(&mut p, format, y, self.bits[0])?;
                Ok((p, unit))
            }
            Format::F32 | Format::F32Fma => {
                let e = p.variable_exponent;
                let float =
                    |exact: Interval, k: usize| Operand::Float(exact.mul_pow2(-e * k as i64).to_f64() as f32);
                let coefficient = |k: usize| float(Interval::from_int(units[k]).mul_pow2(-self.bits[k]), k);
                let mut y = coefficient(n);
                for k in (0..n).rev() {
                    let two = k == 1 && self.first.is_some();
                    let note = if two { "c1, its second part".into() } else { format!("c{k}") };
                    y = p.push(
                        Stage::Evaluation,
                        "y",
                        Type::F32,
                        format.mul_add(y, x, 0, coefficient(k)),
                        note,
                    );
                }
                // Last: the sum of all that is small is rounded finely.
                if let Some(first) = &self.first {
                    let op = format.mul_add(float(first.clone(), 1), x, 0, y);
                    p.push(Stage::Evaluation, "y", Type::F32, op, "c1, its first part");
                }
                // The result is the last step as it is.
                if output == Output::F32 {
                    Ok((p, Interval::from_int(1)))
                } else {
                    Err(DesignError::FloatOnly)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_coefficients;
    use crate::input::{Arity, Encoding, Input};
    use crate::options::{Method, Options, RoutineOptions};
    use crate::quantity::Quantity;
    use crate::routine;

    /// Proven bounds on the paper's device over |s| ≤ 0.38 mm at degree 9, in arcsec.
    #[test]
    fn bounds_on_the_device_of_the_paper() {
        let reading = |encoding| Input { arity: Arity::Reading, encoding };
        let q31 = reading(Encoding::Q31 { full_scale: Some(0.4) });
        let counts = reading(Encoding::Counts { bits: 16, gain: 0.8 / 65536.0, offset: 32768.0 });
        let coefficients = paper_coefficients();
        let quantity = Quantity::of(&coefficients.error_model());
        for (format, input, output, arcsec) in [
            (Format::Q31, q31, Output::PowerOfTwo, 1.0e-4),
            (Format::Q31, q31, Output::Nano, 2.1e-4),
            (Format::Q31, counts, Output::PowerOfTwo, 1.0e-4),
            (Format::Q31, reading(Encoding::F32), Output::PowerOfTwo, 1.0e-4),
            (Format::Q31, reading(Encoding::F32), Output::F32, 3.5e-4),
            (Format::F32, reading(Encoding::F32), Output::F32, 5.7e-4),
            (Format::F32Fma, reading(Encoding::F32), Output::F32, 5.2e-4),
        ] {
            let wanted = RoutineOptions { method: Method::Fused, format, input, output };
            let options = Options { degree: Some(9), ..Options::default() };
            let routine = routine::design(&coefficients, &options, &wanted).unwrap();
            let bound = quantity.in_bound_unit(routine.design.bound.total);
            assert!(bound <= arcsec, "{wanted:?}: {bound:e}");
        }
    }

    /// The certified distance is that of the densest of readings, to a thousandth, in every format and degree; and no
    /// polynomial of the degree is nearer than the certificate says.
    #[test]
    fn the_supremum_is_refined_in_every_format() {
        let coefficients = paper_coefficients();
        for format in Format::ALL.into_iter().chain([Format::F32Fma]) {
            for degree in 3..=10 {
                let wanted = RoutineOptions::of(format);
                let options = Options { degree: Some(degree), bound: Some(1e9), ..Options::default() };
                let routine = routine::design(&coefficients, &options, &wanted).unwrap();
                let (design, plan) = (&routine.design, &routine.plan);
                let (from, to) = bound::words(&design.program, plan);
                let there = bound::output_polynomial(&design.program, plan, &from, &to).unwrap();
                let difference = there.scale(&design.unit).sub(&routine.reference.polynomial);
                let roundings = bound::roundings(&design.program, plan, &design.unit).unwrap();
                // The bound on each piece, from below.
                let mut reached = 0.0f64;
                for piece in roundings {
                    for i in 0..=20 {
                        let v = piece.from + (piece.to - piece.from) * f64::from(i) / 20.0;
                        let distance = difference.at(&Interval::from_f64(v)).magnitude_lower().to_f64_down();
                        reached = reached.max(distance + piece.most);
                    }
                }
                let bound = &design.bound;
                let others = bound.input + 1e-9 * bound.total;
                assert!(
                    bound.total <= 1.001 * reached + others,
                    "{format:?}, degree {degree}: {:e} where {reached:e} is reached",
                    bound.total
                );
                let largest = supremum(
                    &difference,
                    &Reference {
                        polynomial: Polynomial::constant(Interval::zero()),
                        remainder: Interval::zero(),
                    },
                    &from.mul_pow2(-design.program.variable_exponent),
                    &to.mul_pow2(-design.program.variable_exponent),
                );
                assert!(design.minimax <= largest.to_f64_up(), "{format:?}, degree {degree}");
            }
        }
    }

    /// Where one float does not do, the linear coefficient is of two: the last rounding is nearly all that is left. Where
    /// one does, it stays one.
    #[test]
    fn two_floats_where_one_does_not_do() {
        let coefficients = paper_coefficients();
        let quantity = Quantity::of(&coefficients.error_model());
        for (format, two) in [(Format::F32, 3.1e-4), (Format::F32Fma, 2.6e-4)] {
            let steps = |arcsec: f64| {
                let options = Options { degree: Some(9), bound: Some(arcsec), ..Options::default() };
                let routine = routine::design(&coefficients, &options, &RoutineOptions::of(format)).unwrap();
                assert!(quantity.in_bound_unit(routine.design.bound.total) <= arcsec);
                routine.design.program.steps.len()
            };
            assert_eq!(steps(two), steps(9e-4) + 1);
        }
    }
}
