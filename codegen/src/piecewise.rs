//! The method of a table: a polynomial of low degree for each segment, found by shifting the variable.
//!
//! A row's polynomial is one of the variable itself ([`Place::Whole`]): a shift finds the row, and nothing else stands
//! before the products. Half a width added before the shift centres the segments at multiples of their width
//! ([`Place::Centred`]), so that half a segment lies at either end, where functions bend most. Where such polynomials,
//! which reach far at zero, would cost bits, a row's polynomial is one of the place in its segment ([`Place::Segment`]),
//! from the segment's middle: the variable shifted left, wrapped to a signed word. Where the range comes too close to the
//! end of the word for the half width, segments begin at multiples, and it is added for the place.
//!
//! Where segments begin at multiples the table holds the rows that some argument reaches. Of three words a row is packed, or padded to four, so that its
//! address is one shift.

use rayon::prelude::*;

use crate::approximate::{least_distance, minimax};
use crate::bound;
use crate::design::{Design, DesignError};
use crate::exact::{Interval, Polynomial};
use crate::format::Format;
use crate::input::InputPlan;
use crate::options::Place;
use crate::output::Output;
use crate::program::{Op, Operand, Program, Stage, Type};
use crate::quantize;
use crate::reference::Reference;

/// The form of a table.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Degree of its polynomials.
    pub degree: usize,
    /// Segments of all words of the variable, as a power of two.
    pub segments_log2: u32,
    /// Whether a row is padded to a power of two of words.
    pub padded: bool,
    /// What its polynomials are of.
    pub place: Place,
}

impl Shape {
    fn width(&self) -> usize {
        let words = self.degree + 1;
        if self.padded { words.next_power_of_two() } else { words }
    }
}

/// Designs a table in a format of 32-bit words. A plan without a last shift to the left ([`InputPlan::unshifted`]) saves
/// an instruction. `least_headroom` bits of the sum are left to what is added to it.
///
/// # Errors
/// [`DesignError`] where the table or the output's format cannot hold the range.
pub fn design(
    plan: &InputPlan,
    reference: &Reference,
    (format, output): (Format, Output),
    shape: &Shape,
    least_headroom: i64,
) -> Result<Design, DesignError> {
    let (degree, width) = (shape.degree, shape.width());
    let (layout, rows) = Layout::new(plan, (format, output), shape)?;
    let empty = program(plan, format, output, degree, &layout, &[], 0)?.0;
    let segments: Vec<Segment> = bound::segments(&empty, bound::words(&empty, plan))
        .into_par_iter()
        .map(|(row, from, to)| Segment::new(reference, degree, &layout, row, from, to))
        .collect();
    let reach =
        segments.iter().map(|s| s.reach.clone()).reduce(|a, b| a.hull(&b)).unwrap_or_else(Interval::zero);
    let minimax = segments.iter().map(|s| s.distance.to_f64_down()).fold(0.0, f64::max);
    let build = |headroom: i64| -> Result<Design, DesignError> {
        let bits =
            format.bits() - 1 - least_headroom - headroom - reach.log2_floor().unwrap_or(-120).max(-120);
        let bits = bits.min(output.most_fraction_bits());
        let mut table = vec![vec![0; width]; rows];
        for s in &segments {
            let Some(row) = table.get_mut(s.row) else { continue };
            *row =
                s.local.coefficients().iter().map(|c| c.mul_pow2(bits).round_to_i64().unwrap_or(0)).collect();
            row.resize(width, 0);
        }
        let (rough, unit) = program(plan, format, output, degree, &layout, &table, bits)?;
        let lsb = vec![Interval::pow2(-bits).to_f64(); degree + 1];
        // Which correction brings the program, with its biases, nearest on a segment.
        let correction = |s: &Segment| -> Result<Vec<i64>, DesignError> {
            let there = bound::output_polynomial(&rough, plan, &s.from, &s.to)?.scale(&unit);
            let residual = s.in_place(&reference.polynomial.sub(&there));
            Ok(quantize::nearest(&residual, &lsb, (&s.ends().0, &s.ends().1), &[]))
        };
        let corrections: Vec<Vec<i64>> = segments.par_iter().map(correction).collect::<Result<_, _>>()?;
        for (s, correction) in segments.iter().zip(corrections) {
            if let Some(row) = table.get_mut(s.row) {
                row.iter_mut().zip(correction).for_each(|(c, d)| *c += d);
            }
        }
        fill_unreachable(&mut table, &segments);
        let (program, unit) = program(plan, format, output, degree, &layout, &table, bits)?;
        let bound = bound::bound(&program, plan, reference, &unit)?;
        let (segments, sum_bits, account) = (rows, bits, None);
        Ok(Design { program, bound, degree, segments, minimax, unit, sum_bits, account })
    };
    build(0).or_else(|e| if matches!(e, DesignError::Overflows(_)) { build(1) } else { Err(e) })
}

/// The steps of a table of this shape with its rows, whatever is in them.
///
/// # Errors
/// [`DesignError`] as for [`design`].
pub fn outline(
    plan: &InputPlan,
    (format, output): (Format, Output),
    shape: &Shape,
) -> Result<Program, DesignError> {
    let (layout, rows) = Layout::new(plan, (format, output), shape)?;
    let table = vec![vec![0; shape.width()]; rows];
    Ok(program(plan, format, output, shape.degree, &layout, &table, format.bits() - 1)?.0)
}

/// About what no table of this shape betters, in the reference's unit: |f⁽ⁿ⁺¹⁾| rⁿ⁺¹ / (2ⁿ (n + 1)!) on a segment of half
/// width r, of the smallest derivative that is seen there.
pub fn least_error(plan: &InputPlan, reference: &Reference, shape: &Shape) -> f64 {
    let (from, to) = plan.range_in_v();
    let (from, to) = (from.to_f64(), to.to_f64());
    let order = shape.degree + 1;
    let derivative = (0..order).fold(reference.polynomial.clone(), |p, _| p.derivative());
    let c: Vec<f64> = derivative.coefficients().iter().map(Interval::to_f64).collect();
    let at = |v: f64| c.iter().rev().fold(0.0, |sum, c| sum * v + c);
    let width = 0.5f64.powi(shape.segments_log2 as i32);
    let factorial: f64 = (1..=order).map(|k| k as f64).product();
    let scale = (0.5 * width).powi(order as i32) / (2f64.powi(shape.degree as i32) * factorial);
    let mut largest = 0.0f64;
    let mut start = (from / width).ceil() * width;
    while start + width <= to {
        let seen = [0.0, 0.25, 0.5, 0.75, 1.0].map(|part| at(start + part * width));
        if seen.iter().all(|d| d.signum() == seen[0].signum()) {
            largest = largest.max(seen.iter().map(|d| d.abs()).fold(f64::INFINITY, f64::min));
        }
        start += width;
    }
    largest * scale
}

/// Where the segments lie.
#[derive(Debug, Clone, Copy)]
struct Layout {
    segments_log2: u32,
    /// Words of the variable are v times two to this.
    exponent: i64,
    place: Place,
    /// Whether segments are centred at the multiples of their width, or begin there.
    centred: bool,
    /// The segment of the table's first row.
    first: usize,
}

impl Layout {
    /// With the number of the table's rows, which does not depend on the coefficients.
    fn new(
        plan: &InputPlan,
        (format, output): (Format, Output),
        shape: &Shape,
    ) -> Result<(Self, usize), DesignError> {
        let (exponent, place) = (plan.program.variable_exponent, shape.place);
        let mut layout =
            Layout { segments_log2: shape.segments_log2, exponent, place, centred: true, first: 0 };
        let last = bound::reach(&plan.program, plan).1;
        let sum = &last + &Interval::from_int(layout.half_width() + layout.half_range());
        layout.centred = place != Place::Whole && sum.certainly_le(&Interval::from_int(u32::MAX.into()));
        let all = program(plan, format, output, shape.degree, &layout, &[], 0)?.0;
        let reached = bound::segments(&all, bound::reach(&all, plan));
        let rows = if layout.centred {
            // A sum that wraps shows nothing of the rows before those that are reached.
            reached.last().map_or(0, |(row, ..)| row + 1).max(1 << layout.segments_log2)
        } else {
            layout.first = reached.first().map_or(0, |(row, ..)| *row);
            // Of a single row nothing would have to be found.
            reached.len().max(2)
        };
        Ok((layout, rows))
    }

    /// Words from the middle of a segment to its end.
    fn half_width(&self) -> i64 {
        self.half_range() >> self.segments_log2
    }

    /// Words from zero to v = ½.
    fn half_range(&self) -> i64 {
        1 << (self.exponent - 1)
    }

    /// A segment's width as a power of two.
    fn width_log2(&self) -> u32 {
        (self.exponent - i64::from(self.segments_log2)) as u32
    }

    /// v of the middle of a row's segment.
    fn middle(&self, row: usize) -> Interval {
        let from_zero = (row + self.first) as i64 - (1 << (self.segments_log2 - 1));
        let halves = 2 * from_zero + i64::from(!self.centred);
        Interval::from_int(halves).mul_pow2(-i64::from(self.segments_log2) - 1)
    }
}

/// A segment that can be reached, and the best polynomial on it.
struct Segment {
    row: usize,
    /// First and last word of the variable.
    from: Interval,
    to: Interval,
    /// v of the segment's middle.
    middle: Interval,
    layout: Layout,
    /// The best polynomial, of the place: w = (v − middle)/width, |w| ≤ ½, or the word/2³².
    local: Polynomial,
    /// The largest value on the way of evaluating it.
    reach: Interval,
    /// No polynomial of the degree is nearer than this.
    distance: Interval,
}

impl Segment {
    fn new(
        reference: &Reference,
        degree: usize,
        layout: &Layout,
        row: usize,
        from: Interval,
        to: Interval,
    ) -> Self {
        let mut segment = Segment {
            row,
            from,
            to,
            middle: layout.middle(row),
            layout: *layout,
            local: Polynomial::constant(Interval::zero()),
            reach: Interval::zero(),
            distance: Interval::zero(),
        };
        let (a, b) = segment.ends();
        let function = segment.in_place(&reference.polynomial);
        segment.local = minimax(&function, degree, &a, &b);
        let least = &least_distance(&function, &segment.local, degree, &a, &b) - &reference.remainder;
        segment.distance = least.lower().magnitude_max(&Interval::zero());
        let c = segment.local.coefficients();
        segment.reach = (0..c.len())
            .map(|k| Polynomial::new(c[k..].to_vec()).range(&a, &b).hull(&c[k]))
            .reduce(|a, b| a.hull(&b))
            .unwrap_or_else(Interval::zero);
        segment
    }

    /// The places of its ends; of a segment of which a single word is reached, one more, for a polynomial needs width.
    fn ends(&self) -> (Interval, Interval) {
        let (a, b) = (self.place(&self.from), self.place(&self.to));
        if b.certainly_le(&a) { (a, self.place(&(&self.to + &Interval::from_int(1)))) } else { (a, b) }
    }

    /// A word of the variable as the place.
    fn place(&self, word: &Interval) -> Interval {
        if self.layout.place != Place::Segment {
            return word.mul_pow2(-32);
        }
        (&word.mul_pow2(-self.layout.exponent) - &self.middle).mul_pow2(self.layout.segments_log2.into())
    }

    /// A function of v as one of the place.
    fn in_place(&self, function: &Polynomial) -> Polynomial {
        if self.layout.place != Place::Segment {
            return function.stretch_pow2(32 - self.layout.exponent);
        }
        function.shift(&self.middle).stretch_pow2(-i64::from(self.layout.segments_log2))
    }
}

/// Rows that no input reaches repeat their nearest neighbour, so that the table reads on smoothly.
fn fill_unreachable(table: &mut [Vec<i64>], segments: &[Segment]) {
    let (Some(first), Some(last)) = (segments.first(), segments.last()) else { return };
    let (low, high) = (table[first.row].clone(), table[last.row].clone());
    table[..first.row].fill(low);
    table[last.row + 1..].fill(high);
}

/// The program with coefficients table[row][k]·2^−bits of the place's powers, and its output's unit.
fn program(
    plan: &InputPlan,
    format: Format,
    output: Output,
    degree: usize,
    layout: &Layout,
    table: &[Vec<i64>],
    bits: i64,
) -> Result<(Program, Interval), DesignError> {
    let mut p = plan.program.clone();
    let x = Operand::Step(p.variable);
    // Half the range so that the lowest segment is row 0.
    let (to_middle, to_start) =
        if layout.centred { (layout.half_width(), 0) } else { (0, layout.half_width()) };
    let by = layout.width_log2();
    let add = to_middle + layout.half_range() - ((layout.first as i64) << by);
    // From the start of the range a shift of the signed word does; otherwise the sum is positive.
    let ty = if layout.centred { Type::U32 } else { Type::I32 };
    let row = p.push(Stage::Evaluation, "segment", ty, Op::Index { a: x, add, by }, "");
    let w = match layout.place {
        Place::Whole | Place::Centred => x,
        Place::Segment => {
            let wrap = Op::Wrap { a: x, add: to_start, by: 32 - by };
            p.push(Stage::Evaluation, "w", Type::I32, wrap, "the place in it, from its middle")
        }
    };
    let entry = |p: &mut Program, k: usize| {
        p.push(Stage::Evaluation, &format!("c{k}"), Type::I32, Op::Entry { index: row, column: k }, "")
    };
    let mut y = entry(&mut p, degree);
    for k in (0..degree).rev() {
        let c = entry(&mut p, k);
        y = p.push(Stage::Evaluation, "y", Type::I32, format.mul_add(y, w, 0, c), "");
    }
    p.table = table.to_vec();
    let unit = output.from_fixed(&mut p, format, y, bits)?;
    Ok((p, unit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_coefficients;
    use crate::input::{Arity, Encoding, Input};
    use crate::options::{Method, Options, OutOfRange, RoutineOptions};
    use crate::quantity::Quantity;
    use crate::routine::{self, Routine};

    fn table(full_scale: f64, out_of_range: OutOfRange) -> (Routine, f64) {
        let method =
            Method::Piecewise { degree: 2, segments_log2: 5, padded: false, place: Some(Place::Whole) };
        let encoding = Encoding::Q31 { full_scale: Some(full_scale) };
        let input = Input { arity: Arity::Reading, encoding };
        let wanted = RoutineOptions { method, format: Format::Q31, input, output: Output::PowerOfTwo };
        let coefficients = paper_coefficients();
        let routine =
            routine::design(&coefficients, &Options { out_of_range, ..Options::default() }, &wanted).unwrap();
        let bound = Quantity::of(&coefficients.error_model()).in_bound_unit(routine.design.bound.total);
        (routine, bound)
    }

    /// Twice the range's end: limits that one instruction saturates to, no shift before the row is found, and nothing else
    /// before the products; packed rows.
    #[test]
    fn a_saturating_table_is_short() {
        let (routine, arcsec) = table(0.76, OutOfRange::Clamp);
        let p = &routine.design.program;
        assert!(matches!(p.steps[p.clamped].op, Op::Clamp { lo: -0x4000_0000, hi: 0x3fff_ffff, .. }));
        assert!(!p.steps.iter().any(|s| matches!(s.op, Op::ShiftLeft { .. } | Op::Wrap { .. })));
        assert_eq!((p.table.len(), p.table[0].len()), (32, 3));
        assert!(arcsec <= 0.005, "{arcsec}");
    }

    /// The range's end: every word is inside, and nothing is limited; the same where nothing is to be limited.
    #[test]
    fn a_table_of_every_word_has_no_limits() {
        for (full_scale, out_of_range) in [(0.38, OutOfRange::Clamp), (0.4, OutOfRange::Continue)] {
            let (routine, arcsec) = table(full_scale, out_of_range);
            let p = &routine.design.program;
            assert!(!p.steps.iter().any(|s| matches!(s.op, Op::Clamp { .. })));
            assert_eq!(p.table.len(), 32);
            assert!(arcsec <= 0.005, "{arcsec}");
        }
    }
}
