//! Coefficients for a shape: interpolation at Chebyshev's nodes of each segment, rounded to words, and the constant
//! set so that the worst count above and the worst below lie equally far, with every rounding of the operations.

use rayon::prelude::*;

use super::TurnError;
use super::shape::{Arithmetic, Filling, Shape, Words};
use super::truth::{Enclosed, Truth};
use crate::approximate::interpolate;

/// The corrections that are wanted: of every count, and of any place between.
pub struct Targets<'a> {
    truth: &'a Truth,
    words: Words,
    /// Whole counts of the result that are added everywhere.
    pub zero: i64,
    /// The rest by count, in counts of the result.
    pub rest: Vec<f64>,
    /// The exact position of every count.
    pub exact: Vec<Enclosed>,
}

impl<'a> Targets<'a> {
    /// Solves for every count; `zero` takes off the middle of what is needed.
    pub fn new(truth: &'a Truth, words: Words) -> Self {
        let exact: Vec<Enclosed> = (0..words.counts)
            .into_par_iter()
            .map(|count| {
                let found = truth.at(words.reading(count));
                let missed = if words.whole() { 0.0 } else { truth.gain() };
                Enclosed { radius: (found.radius + missed).next_up(), ..found }
            })
            .collect();
        let mut targets = Targets { truth, words, zero: 0, rest: Vec::new(), exact };
        let rest: Vec<f64> = (targets.exact.iter().zip(0..))
            .map(|(exact, count)| targets.moved(exact.word, words.reading(count)))
            .collect();
        let (least, most) = ends(&rest);
        // What the mount adds, and what the harmonics have as their middle.
        let middle = (0.5 * (least + most)).round();
        let constant = words.in_counts(-(truth.zero() as i64 as f64));
        let whole = (constant + middle).round();
        targets.zero = whole as i64;
        targets.rest = rest.iter().map(|r| r + (constant - whole)).collect();
        targets
    }

    /// From a reading to its position, less the constant, in counts of the result.
    fn moved(&self, found: u64, reading: u64) -> f64 {
        let moved = found.wrapping_sub(reading).wrapping_add(self.truth.zero()) as i64;
        self.words.in_counts(moved as f64)
    }

    /// The rest at a place between counts.
    fn rest_at(&self, count: f64) -> f64 {
        let reading = (count * (2f64.powi(64) / f64::from(self.words.counts))) as i128 as u64;
        let constant = self.words.in_counts(-(self.truth.zero() as i64 as f64));
        self.moved(self.truth.at(reading).word, reading) + (constant - self.zero as f64)
    }
}

fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)))
}

/// The filling of a shape, and how far its corrections are from the wanted ones, in counts of the result, before
/// the last rounding.
///
/// # Errors
/// [`TurnError::Large`] where the corrections do not fit the shape's words.
pub fn fill(shape: Shape, targets: &Targets) -> Result<(Filling, f64), TurnError> {
    match shape {
        Shape::PerCount => {
            let table = targets.rest.iter().map(|r| vec![r.round() as i64]).collect();
            Ok((Filling { table, shifts: Vec::new(), fraction: 0, zero: targets.zero }, 0.0))
        }
        Shape::Segments { degree, arithmetic, .. } => segments(shape, targets, degree, arithmetic),
    }
}

fn segments(
    shape: Shape,
    targets: &Targets,
    degree: usize,
    arithmetic: Arithmetic,
) -> Result<(Filling, f64), TurnError> {
    let words = targets.words;
    let place_bits = shape.place_bits(words);
    let size = 1usize << place_bits;
    // Coefficients in counts of the result, of the place's powers: u from 0, or v = u/size − ½.
    let raw: Vec<Vec<f64>> = (0..shape.segments(words))
        .map(|segment| {
            let start = (segment * size) as f64;
            match arithmetic {
                Arithmetic::Long => {
                    interpolate(degree, -0.5, 0.5, &|v| targets.rest_at(start + (v + 0.5) * size as f64))
                }
                Arithmetic::Short => {
                    interpolate(degree, 0.0, size as f64 - 1.0, &|u| targets.rest_at(start + u))
                }
            }
        })
        .collect();
    let (fraction, shifts) = match arithmetic {
        Arithmetic::Long => (words.most_fraction(), Vec::new()),
        Arithmetic::Short => short_formats(&raw, words, degree, size).ok_or(TurnError::Large)?,
    };
    let mut largest = 0.0f64;
    let mut table = Vec::with_capacity(raw.len());
    for (segment, coefficients) in raw.iter().enumerate() {
        let mut scale = 2f64.powi(fraction as i32);
        let mut row = Vec::with_capacity(degree + 1);
        for (k, c) in coefficients.iter().enumerate() {
            row.push((c * scale).round() as i64);
            // The next coefficient is kept finer by what its product is shifted.
            scale *= shifts.get(k).map_or(1.0, |by| 2f64.powi(*by as i32));
        }
        row[0] = 0;
        let wanted = |u: usize| targets.rest[segment * size + u] * 2f64.powi(fraction as i32);
        let distance = |row: &[i64], u: usize| {
            let y = match arithmetic {
                Arithmetic::Short => short(row, &shifts, u as i64),
                Arithmetic::Long => long(row, place(u, place_bits)),
            };
            wanted(u) - y as f64
        };
        // The last segment may reach beyond the last count.
        let counts = size.min(targets.rest.len() - segment * size);
        let (least, most) = ends(&(0..counts).map(|u| distance(&row, u)).collect::<Vec<_>>());
        row[0] = (0.5 * (least + most)).round() as i64;
        largest = largest.max((most - row[0] as f64).abs()).max((least - row[0] as f64).abs());
        table.push(row);
    }
    let limit = match arithmetic {
        Arithmetic::Short => i64::from(i16::MAX),
        Arithmetic::Long => i64::from(i32::MAX),
    };
    if table.iter().flatten().any(|c| c.abs() > limit) {
        return Err(TurnError::Large);
    }
    let off = largest / 2f64.powi(fraction as i32);
    Ok((Filling { table, shifts, fraction, zero: targets.zero }, off))
}

/// The signed place of a long polynomial.
fn place(u: usize, bits: u32) -> i64 {
    i64::from((((u as u64 + (1u64 << (bits - 1))) << (32 - bits)) as u32) as i32)
}

fn short(row: &[i64], shifts: &[u32], u: i64) -> i64 {
    let top = row.len() - 1;
    (0..top).rev().fold(row[top], |y, k| row[k] + ((y * u) >> shifts[k]))
}

fn long(row: &[i64], place: i64) -> i64 {
    let top = row.len() - 1;
    (0..top).rev().fold(row[top], |y, k| row[k] + ((y * place) >> 32))
}

/// Fractional bits of the correction and the shifts of the products, as many as 16-bit coefficients allow.
fn short_formats(raw: &[Vec<f64>], words: Words, degree: usize, size: usize) -> Option<(u32, Vec<u32>)> {
    let room = |largest: f64| {
        // A tenth is left for the roundings, and for partial sums that exceed their coefficient.
        let bits = (0.9 * f64::from(i16::MAX) / largest.max(1e-9)).log2().floor();
        bits.clamp(-1.0, 60.0) as i32
    };
    // The partial sum from coefficient k on is a word of 16 bits as well: it is multiplied.
    let reach = |k: usize| {
        let at = |row: &Vec<f64>, u: f64| row[k..].iter().rev().fold(0.0, |sum, c| sum * u + c).abs();
        let ends = |row: &Vec<f64>| row[k].abs().max(at(row, size as f64)).max(at(row, 0.5 * size as f64));
        raw.iter().map(ends).fold(0.0, f64::max)
    };
    let fraction = room(reach(0)).min(words.most_fraction() as i32);
    if fraction < 1 {
        return None;
    }
    let (mut shifts, mut scale) = (Vec::new(), fraction);
    for k in 1..=degree {
        let by = (room(reach(k)) - scale).clamp(0, 15);
        if by < 1 {
            return None;
        }
        shifts.push(by as u32);
        scale += by;
    }
    Some((fraction as u32, shifts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_interpolated_exactly() {
        let found = interpolate(3, -1.0, 4.0, &|x| 1.0 - 2.0 * x + 0.5 * x * x + 0.25 * x * x * x);
        for (found, expected) in found.iter().zip([1.0, -2.0, 0.5, 0.25]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}
