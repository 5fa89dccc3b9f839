//! `periodic` terms: harmonics of the result itself, the implicit equation Θ + P(Θ) = u, u being the result
//! less all other errors.
//!
//! P has the period p, so the solution is Θ = u − Q(u) with a Q of the same period: no step of iteration is left
//! to run time. The phase of u is a wrapping product, and Q a table of cubic polynomials over one turn, found by
//! Newton's method and interpolation. It is proved by putting it in: where Θ̂ = u − Q̂(u) leaves a residual
//! R = Θ̂ + P(Θ̂) − u, the solution is within |R|/(1 − L), L < 1 being the steepest slope of P.
//!
//! Harmonics of several periods do not repeat together. Then one turn of the table is a little more than all that u
//! can be, and the harmonics have no whole numbers in it: the table costs more flash, and the proof is the same.

use fitter::terms::{Operator, Periodic, Term};

use super::builder::{Builder, Tracked};
use super::rows::{self, DEGREE, Names};
use super::sum::Sum;
use super::{PhysicsError, Result};
use crate::approximate::interpolate;
use crate::bound::of_type;
use crate::exact::{Interval, Polynomial, cos_sin, pi};
use crate::program::{Op, Type};

/// Segments that are tried for a period, as powers of two.
const SEGMENTS_LOG2: std::ops::RangeInclusive<u32> = 3..=10;
/// The most that are tried where several periods are solved over the whole range: 64 KiB of flash.
const MOST_SEGMENTS_LOG2: u32 = 12;
/// How much longer than the range a turn of the table is then: an eighth on either side, so that the segment in which
/// the turn's ends meet is out of reach.
const LONGER: f64 = 1.25;
/// Most terms of the Taylor series about the middle of a segment; it ends earlier where the rest no longer matters.
const MOST_TERMS: i64 = 40;
/// Part of a word to which the residual's maximum is searched, as a power of two; what the series leaves out and what
/// is dropped of its polynomials stay a thirty-second of that.
const FINE_LOG2: i64 = -3;

/// All harmonics, in turns: A(T) = Σ aₖcos 2πkT + bₖsin 2πkT.
struct Harmonics {
    /// Numbers, aₖ and bₖ; the numbers are whole where one period is all there is.
    parts: Vec<(Interval, Interval, Interval)>,
    /// The middle of what T can be, about which a turn is taken.
    middle: f64,
    /// The steepest slope of A.
    steepest: Interval,
}

/// Solves the periodic terms, where there are any; `statistic` is one unit of the file in the result's unit.
pub(super) fn solve(b: &mut Builder, terms: &[Term], statistic: &Interval) -> Result {
    let periodic: Vec<(&Term, &Periodic)> = (terms.iter())
        .filter_map(|term| match &term.operator {
            Operator::Periodic(periodic) => Some((term, periodic)),
            _ => None,
        })
        .collect();
    let Some((first, Periodic { period: common, .. })) = periodic.first() else { return Ok(()) };
    let effect = first.effect.clone();
    // All that u can be, in the file's unit.
    let all = b.sum.word.range.mul_pow2(-b.sum.bits).div(statistic);
    let one_period = periodic.iter().all(|(_, p)| p.period == *common);
    let (period, middle) = match one_period {
        true => (*common, 0.0),
        false => {
            let period = LONGER * (all.to_f64_up() - all.to_f64_down());
            (period, all.midpoint().to_f64() / period)
        }
    };
    let harmonics = Harmonics::of(&periodic, period, middle, one_period);
    let sizes = if one_period { SEGMENTS_LOG2 } else { harmonics.least_segments()..=MOST_SEGMENTS_LOG2 };
    let refuse =
        |why: &str| PhysicsError::NotGenerated { effect: effect.clone(), kind: "periodic", why: why.into() };
    let one = Interval::from_int(1);
    let rest = &one - &harmonics.steepest;
    if !one.mul_pow2(-10).certainly_le(&rest.lower()) {
        return Err(refuse(": it is so steep that the equation has no certain solution"));
    }
    // Turns of one word of the sum, and the phase as a product by an integer.
    let turn = &Interval::from_f64(period) * statistic;
    let rate = Interval::pow2(-b.sum.bits).div(&turn);
    let largest = Interval::from_int(i32::MAX.into());
    let fits = |by: &i64| rate.mul_pow2(32 + by).certainly_le(&largest);
    let by = (0..=32).rev().find(fits).ok_or_else(|| refuse(": its period is shorter than two words"))?;
    let factor = rate.mul_pow2(32 + by).round_to_i64().unwrap_or(0);
    let mismatch = (&Interval::from_int(factor).mul_pow2(-by) - &rate.mul_pow2(32)).magnitude();
    // In words of 2⁻³² turns.
    let off = &(&mismatch * &b.sum.word.range.magnitude()) + &one;
    let all = of_type(Type::I32);
    let phase = Op::Phase { a: b.sum.word.operand, factor, by: by as u32 };
    let phase = b.push("phase", phase, all, Interval::zero(), "a turn is 2^32")?;

    let (log2, rows, distance) = table(&harmonics, &turn, &b.sum, &rest, sizes);
    // Beside other rows the names say which these are.
    let alone = b.program.table.is_empty();
    let others = if alone { String::new() } else { format!("_{}", b.program.steps.len()) };
    let names = Names { of_others: &others, coefficient: "q", sum: &|_| format!("q{others}") };
    let by = 32 - i64::from(log2);
    let mut q = b.polynomials(phase.operand, &rows, (i64::from(i32::MIN) >> by, by), &names)?;
    // What the phase is off moves Q by its slope, at most L/(1 − L).
    let gain = one.div(&rest.lower()).upper();
    let slope = (&harmonics.steepest * &gain).upper();
    let moved = (&(&off.mul_pow2(-32) * &turn).mul_pow2(b.sum.bits) * &slope).upper();
    q.error = (&(&q.error + &distance) + &moved).upper();
    let word = b.add("y", &b.sum.word.clone(), &q, "less the periodic error")?;
    let error = (&(&b.sum.word.error * &gain) + &q.error).upper();
    b.sum.word = Tracked { error, ..word };
    b.sum.gain = (&b.sum.gain * &gain).upper();
    Ok(())
}

impl Harmonics {
    /// Those of all terms, in turns of a table of this period.
    fn of(periodic: &[(&Term, &Periodic)], period: f64, middle: f64, one_period: bool) -> Self {
        let turn_of_table = Interval::from_f64(period);
        let mut parts = Vec::new();
        for (term, periodic) in periodic {
            let turns = turn_of_table.div(&Interval::from_f64(periodic.period));
            for (k, pair) in periodic.harmonics.iter().zip(term.coefficients.chunks_exact(2)) {
                let [a, s] = [pair[0], pair[1]].map(|c| Interval::from_f64(c).div(&turn_of_table));
                let number = Interval::from_int(i64::from(*k));
                parts.push((if one_period { number } else { &number * &turns }, a, s));
            }
        }
        Harmonics::new(parts, middle)
    }

    fn new(parts: Vec<(Interval, Interval, Interval)>, middle: f64) -> Self {
        let two_pi = pi().mul_pow2(1);
        // |a cos + b sin| ≤ |a| + |b| is coarse; √(a² + b²) from f64, enlarged by far more than its rounding.
        let steepest = parts.iter().fold(Interval::zero(), |sum, (k, a, s)| {
            let size = a.to_f64().hypot(s.to_f64()) * (1.0 + 1e-12);
            &sum + &(&(&two_pi * k) * &Interval::from_f64(size))
        });
        Harmonics { parts, steepest: steepest.upper(), middle }
    }

    /// Two segments to a period of the highest harmonic, below which nothing is near; of numbers that are not whole.
    fn least_segments(&self) -> u32 {
        let highest = self.parts.iter().map(|(k, ..)| k.to_f64()).fold(1.0, f64::max);
        ((2.0 * highest).log2().ceil() as u32).clamp(*SEGMENTS_LOG2.start(), MOST_SEGMENTS_LOG2)
    }

    /// Value and slope in f64.
    fn at(&self, turns: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for (k, a, s) in &self.parts {
            let rate = std::f64::consts::TAU * k.to_f64();
            let (sine, cosine) = (rate * turns).sin_cos();
            let (a, s) = (a.to_f64(), s.to_f64());
            value += a * cosine + s * sine;
            slope += rate * (s * cosine - a * sine);
        }
        (value, slope)
    }

    /// q with T = t − q, T + A(T) = t, in f64.
    fn solution(&self, t: f64) -> f64 {
        let mut truth = t;
        for _ in 0..60 {
            let (value, slope) = self.at(truth);
            let step = (truth + value - t) / (1.0 + slope);
            truth -= step;
            if step.abs() <= f64::EPSILON * truth.abs() {
                break;
            }
        }
        t - truth
    }

    /// A(centre + δ(w)) as a polynomial of w, |w| ≤ ½, with what it is off: the Taylor series of A about the centre,
    /// whose powers of δ all harmonics share. What is left out of it is at most ΣrateⁿR·|δ|ⁿ/n!, R = √(a² + b²).
    fn around(&self, centre: &Interval, delta: &Polynomial, tolerance: &Interval) -> (Polynomial, Interval) {
        let half = Interval::pow2(-1);
        let reach = delta.range_around_zero(&half).magnitude();
        // Of every harmonic: its rate, and rateⁿ/n! times its value and its derivative over the rate at the centre.
        let mut harmonics: Vec<_> = (self.parts.iter())
            .map(|(k, a, s)| {
                let (cosine, sine) = cos_sin(&turned(&(centre * k)));
                (&pi().mul_pow2(1) * k, &(a * &cosine) + &(s * &sine), &(s * &cosine) - &(a * &sine))
            })
            .collect();
        let mut series = Vec::new();
        let mut power = Interval::from_int(1);
        let mut left = Interval::zero();
        for n in 0..MOST_TERMS {
            left = harmonics.iter().fold(Interval::zero(), |sum, (_, value, slope)| {
                (&sum + &(&(&value.magnitude() + &slope.magnitude()) * &power)).upper()
            });
            if left.certainly_le(tolerance) {
                break;
            }
            series.push(harmonics.iter().fold(Interval::zero(), |sum, (_, value, _)| &sum + value));
            power = (&power * &reach).upper();
            for (rate, value, slope) in &mut harmonics {
                let factor = rate.div(&Interval::from_int(n + 1));
                (*value, *slope) = (&*slope * &factor, -(&*value * &factor));
            }
        }
        let mut sum = Polynomial::constant(Interval::zero());
        let mut dropped = Interval::zero();
        for c in series.into_iter().rev() {
            sum = sum.mul(delta).add(&Polynomial::constant(c));
            dropped = (&(&dropped * &reach) + &sum.truncate(&half, &tolerance.mul_pow2(-4))).upper();
        }
        (sum, (&left + &dropped).upper())
    }
}

/// 2π times the part of `turns` after the point, within −π…π.
fn turned(turns: &Interval) -> Interval {
    let whole = turns.midpoint().round_to_i64().unwrap_or(0);
    &(turns - &Interval::from_int(whole)) * &pi().mul_pow2(1)
}

/// The table of −Q in words of the sum, as its number of segments (a power of two) and its rows, and how far it is from the
/// solution, in words: the smallest one that is within the tolerance, or the largest.
fn table(
    harmonics: &Harmonics,
    turn: &Interval,
    sum: &Sum,
    rest: &Interval,
    sizes: std::ops::RangeInclusive<u32>,
) -> (u32, Vec<Vec<i64>>, Interval) {
    let words_per_turn = turn.mul_pow2(sum.bits);
    // Rounded coefficients leave a residual of a word, whatever the number of segments.
    let wanted = &sum.tolerance + &Interval::from_ratio(5, 4).div(&rest.lower());
    let largest = *sizes.end();
    let mut segments_log2 = *sizes.start();
    loop {
        let segments = Segments { harmonics, words_per_turn: &words_per_turn, rest, segments_log2 };
        let rows: Vec<Vec<i64>> = (0..segments.count()).map(|row| segments.coefficients(row)).collect();
        let last = segments_log2 >= largest;
        // Exact arithmetic only where f64 does not show that this size is too coarse.
        if last || segments.tried(&rows) <= wanted.to_f64_up() {
            let distance = segments.distance(&rows);
            if last || distance.certainly_le(&wanted) {
                return (segments_log2, rows, distance);
            }
        }
        segments_log2 += 1;
    }
}

/// A turn in 2^`segments_log2` segments of the phase.
struct Segments<'a> {
    harmonics: &'a Harmonics,
    words_per_turn: &'a Interval,
    /// 1 − L, L being the steepest slope of the harmonics.
    rest: &'a Interval,
    segments_log2: u32,
}

impl Segments<'_> {
    fn count(&self) -> i64 {
        1 << self.segments_log2
    }

    /// The middle of a segment, in turns; row 0 begins at phase −½.
    fn middle(&self, row: i64) -> Interval {
        let place = Interval::from_ratio(2 * row + 1 - self.count(), 2 * self.count());
        let turns = (self.harmonics.middle - place.to_f64()).round() as i64;
        &place + &Interval::from_int(turns)
    }

    /// The cubic of −Q in a segment, in words.
    fn coefficients(&self, row: i64) -> Vec<i64> {
        let (middle, scale) = (self.middle(row).to_f64(), self.words_per_turn.to_f64());
        let value = |w: f64| -scale * self.harmonics.solution(middle + w / self.count() as f64);
        interpolate(DEGREE, 0.5, -0.5, &value).iter().map(|c| c.round() as i64).collect()
    }

    /// The largest distance from the solution that f64 finds at some points, in words.
    fn tried(&self, all: &[Vec<i64>]) -> f64 {
        let (scale, rest) = (self.words_per_turn.to_f64(), self.rest.to_f64_up());
        let of_row = |(row, c): (i64, &Vec<i64>)| {
            let middle = self.middle(row).to_f64();
            rows::tried(c, (-0.5, 0.5), |w, there| {
                let q = -there / scale;
                let (value, _) = self.harmonics.at(middle + w / self.count() as f64 - q);
                (value - q).abs() * scale / rest
            })
        };
        (0..).zip(all).map(of_row).fold(0.0, f64::max)
    }

    /// A bound of the distance from the solution, in words.
    fn distance(&self, rows: &[Vec<i64>]) -> Interval {
        let half = Interval::pow2(-1);
        let fine = Interval::pow2(FINE_LOG2).div(self.words_per_turn).lower();
        let tolerance = fine.mul_pow2(-5);
        // In turns, and before the slope enlarges it.
        let mut largest = Interval::zero();
        for (row, c) in (0..).zip(rows) {
            // q̂(w) in turns, exactly as the table has it.
            let q = Polynomial::new(
                c.iter().map(|c| -(Interval::from_int(*c).div(self.words_per_turn))).collect(),
            );
            let start = q.coefficients()[0].clone();
            let delta = Polynomial::linear(Interval::zero(), Interval::from_ratio(1, self.count()))
                .sub(&q.sub(&Polynomial::constant(start.clone())));
            let (value, off) = self.harmonics.around(&(&self.middle(row) - &start), &delta, &tolerance);
            let mut residual = value.sub(&q);
            let off = &off + &residual.truncate(&half, &tolerance);
            // Rows that are nearer than another need not be looked at closely.
            let least = (&largest - &off).lower().hull(&Interval::zero()).upper();
            let here = residual.supremum_beside(&-half.clone(), &half, &fine, &least);
            largest = (&here.upper() + &off).upper();
        }
        (&largest.div(&self.rest.lower()) * self.words_per_turn).upper()
    }
}
