//! Coefficients that a format can hold, chosen together so that the final supremum error is small.
//!
//! Rounding each coefficient alone leaves an error that the others could have taken up. The polynomials that the
//! format can express are a lattice ([`lattice`]). What is sought is the one of which the largest |distance| + rounding
//! over the range is least, the rounding being what the operations add there. Several searches start: at the
//! lattice points nearest to the function and to its best polynomial in the mean (Babai), and from the best polynomial
//! with real coefficients, of which one coordinate after the other is set to an integer and the rest levelled again
//! ([`level`]), in a beam search. From each, exchanges of up to three coordinates at once lower the
//! supremum further. Everything here is search in `f64`; what comes out is bounded elsewhere, exactly.

mod lattice;
mod level;

use crate::approximate::{chebyshev, clenshaw};
use crate::exact::{Interval, Polynomial};
use lattice::Lattice;
use level::level;

/// Sample points per coefficient.
const SAMPLES_PER_COEFFICIENT: usize = 160;
/// One of so many is looked at while searching.
const SPARSE: usize = 10;
/// Times that points are added where what is left is largest between them.
const REFINEMENTS: usize = 3;
/// Width of the beam search that sets coordinates to integers.
const BEAM: usize = 3;
/// Coordinates that are exchanged at once.
const MOST_TOGETHER: usize = 3;
/// So little above what real coefficients reach, as a part of it, integers are as good.
const NOTHING_TO_GAIN: f64 = 1e-6;
/// Rounds of exchanges; each must improve.
const ROUNDS: usize = 200;

/// What the operations round on a part of the range.
#[derive(Debug, Clone, Copy)]
pub struct Rounding {
    /// v where the part begins.
    pub from: f64,
    /// v where it ends.
    pub to: f64,
    /// The largest there, in the unit of the function.
    pub most: f64,
}

/// Integer corrections δₖ so that Σδₖ·lsbₖ·vᵏ comes close to `residual` (in the supremum norm, `roundings` added) for
/// v from `from` to `to` (points). `lsb[k]` is what one unit of coefficient k stands for.
pub fn nearest(
    residual: &Polynomial,
    lsb: &[f64],
    (from, to): (&Interval, &Interval),
    roundings: &[Rounding],
) -> Vec<i64> {
    let n = lsb.len();
    let centre = from.hull(to).midpoint();
    let radius = (to - &centre).upper();
    let series: Vec<f64> = chebyshev(residual, &centre, &radius).iter().map(Interval::to_f64).collect();
    let (centre, radius) = (centre.to_f64(), radius.to_f64());
    let lattice = Lattice::of_powers(lsb, centre, radius);
    let margin = |u: f64| {
        let v = centre + radius * u;
        let there = roundings.iter().filter(|r| r.from <= v && v <= r.to);
        there.map(|r| r.most).fold(0.0, f64::max)
    };
    let all = Samples::new(&lattice, &series, SAMPLES_PER_COEFFICIENT * n, margin);
    let (some, best, level) = all.that_matter();
    let largest = |x: &[i64]| all.largest(&all.rest(x));
    let rounded = lattice.nearest_plane(&lattice.sum(&best));
    if largest(&rounded) <= level * (1.0 + NOTHING_TO_GAIN) {
        return lattice.coefficients(&rounded);
    }
    let mut found = some.set_one_by_one();
    found.push(lattice.nearest_plane(&series));
    found.push(rounded);
    for candidate in &mut found {
        some.descend(candidate);
    }
    let best = found.into_iter().min_by(|a, b| largest(a).total_cmp(&largest(b)));
    let mut best = best.unwrap_or_else(|| vec![0; n]);
    all.descend(&mut best);
    lattice.coefficients(&best)
}

/// The function and the lattice's vectors at points of the range.
struct Samples {
    /// The function's value at each point.
    target: Vec<f64>,
    /// What the operations round there.
    margin: Vec<f64>,
    /// The value of each basis vector at each point.
    basis: Vec<Vec<f64>>,
}

impl Samples {
    fn new(lattice: &Lattice, series: &[f64], count: usize, margin: impl Fn(f64) -> f64) -> Self {
        let points: Vec<f64> =
            (0..count).map(|i| -(std::f64::consts::PI * i as f64 / (count - 1) as f64).cos()).collect();
        let values = |series: &[f64]| points.iter().map(|&u| clenshaw(series, u)).collect();
        Samples {
            target: values(series),
            margin: points.iter().map(|&u| margin(u)).collect(),
            basis: lattice.series().map(|s| values(&s)).collect(),
        }
    }

    /// Some of the points, among them those where the best real coefficients leave most; these, and what they leave.
    fn that_matter(&self) -> (Samples, Vec<f64>, f64) {
        let count = self.target.len();
        let mut which: Vec<usize> = (0..count).filter(|i| i % SPARSE == 0 || i + 1 == count).collect();
        loop {
            let at = |values: &[f64]| which.iter().map(|&i| values[i]).collect();
            let basis = self.basis.iter().map(|b| at(b)).collect();
            let some = Samples { target: at(&self.target), margin: at(&self.margin), basis };
            let (best, level) = some.levelled(self.basis.len(), &some.target);
            let mut rest = self.target.clone();
            self.basis.iter().zip(&best).for_each(|(b, x)| subtract(&mut rest, *x, b));
            let most = |i: &usize| rest[*i].abs() + self.margin[*i];
            let peak = |i: &usize| most(i) >= most(&(i - 1)) && most(i) >= most(&(i + 1));
            let before = which.len();
            which.extend((1..count - 1).filter(peak));
            which.sort_unstable();
            which.dedup();
            if which.len() == before || which.len() > count / SPARSE + REFINEMENTS * 2 * self.basis.len() {
                return (some, best, level);
            }
        }
    }

    /// What a lattice point leaves of the function.
    fn rest(&self, x: &[i64]) -> Vec<f64> {
        let mut rest = self.target.clone();
        for (b, &x) in self.basis.iter().zip(x) {
            subtract(&mut rest, x as f64, b);
        }
        rest
    }

    fn largest(&self, rest: &[f64]) -> f64 {
        rest.iter().zip(&self.margin).map(|(r, m)| r.abs() + m).fold(0.0, f64::max)
    }

    /// The real coordinates of the first `free` vectors that level what is left of a target, and the level.
    fn levelled(&self, free: usize, target: &[f64]) -> (Vec<f64>, f64) {
        if free == 0 {
            return (Vec::new(), self.largest(target));
        }
        level(&self.basis[..free], target, &self.margin)
    }

    /// Sets one coordinate after the other to an integer beside what levels the rest, the last vector first.
    fn set_one_by_one(&self) -> Vec<Vec<i64>> {
        let n = self.basis.len();
        let (free, level) = self.levelled(n, &self.target);
        let mut partials = vec![Partial { set: vec![0; n], rest: self.target.clone(), free, level }];
        for k in (0..n).rev() {
            let mut next: Vec<Partial> = Vec::new();
            for partial in &partials {
                let below = partial.free[k].floor();
                for x in [below, below + 1.0] {
                    let mut rest = partial.rest.clone();
                    subtract(&mut rest, x, &self.basis[k]);
                    let mut set = partial.set.clone();
                    set[k] = x as i64;
                    let (free, level) = self.levelled(k, &rest);
                    next.push(Partial { set, rest, free, level });
                }
            }
            next.sort_by(|a, b| a.level.total_cmp(&b.level));
            next.truncate(BEAM);
            partials = next;
        }
        partials.into_iter().map(|partial| partial.set).collect()
    }

    /// Exchanges of one, two or three coordinates by one each, as long as the largest rest falls.
    fn descend(&self, x: &mut [i64]) {
        let mut rest = self.rest(x);
        let mut norm = self.largest(&rest);
        for _ in 0..ROUNDS {
            let mut best = None;
            for together in 1..=MOST_TOGETHER {
                let mut exchange = Exchange { samples: self, least: norm, best: None };
                exchange.more(&rest, 0, together, &mut Vec::new());
                best = exchange.best.map(|moves| (exchange.least, moves));
                if best.is_some() {
                    break;
                }
            }
            let Some((least, moves)) = best else { break };
            for (k, by) in moves {
                x[k] += by;
                subtract(&mut rest, by as f64, &self.basis[k]);
            }
            norm = least;
        }
    }
}

/// A search for the best exchange.
struct Exchange<'a> {
    samples: &'a Samples,
    least: f64,
    best: Option<Vec<(usize, i64)>>,
}

impl Exchange<'_> {
    /// Tries `together` more coordinates from number `first` on.
    fn more(&mut self, rest: &[f64], first: usize, together: usize, moves: &mut Vec<(usize, i64)>) {
        for k in first..self.samples.basis.len() {
            for by in [-1i64, 1] {
                let moved = rest.iter().zip(&self.samples.basis[k]).map(|(r, b)| r - by as f64 * b);
                moves.push((k, by));
                if together == 1 {
                    // Given up at the first point that is too far.
                    let mut largest = 0.0f64;
                    let near = moved.zip(&self.samples.margin).all(|(r, m)| {
                        largest = largest.max(r.abs() + m);
                        largest < self.least
                    });
                    if near {
                        (self.least, self.best) = (largest, Some(moves.clone()));
                    }
                } else {
                    let moved: Vec<f64> = moved.collect();
                    self.more(&moved, k + 1, together - 1, moves);
                }
                moves.pop();
            }
        }
    }
}

/// Some coordinates set to integers, and the others as real numbers that level what is left.
struct Partial {
    set: Vec<i64>,
    rest: Vec<f64>,
    free: Vec<f64>,
    level: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(x, y)| *x -= factor * y);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half() -> (Interval, Interval) {
        let half = Interval::from_f64(0.5);
        (-half.clone(), half)
    }

    fn supremum(residual: &Polynomial, delta: &[i64], lsb: &[f64]) -> f64 {
        let taken = delta.iter().zip(lsb).map(|(&d, &l)| &Interval::from_int(d) * &Interval::from_f64(l));
        let rest = residual.sub(&Polynomial::new(taken.collect()));
        rest.supremum(&half().0, &half().1, &Interval::from_f64(1e-6)).to_f64_up()
    }

    /// A polynomial that the lattice holds is found exactly, however far away the search starts.
    #[test]
    fn a_lattice_point_is_found() {
        let lsb = [1e-3, 1e-3, 1e-3, 1e-3];
        let wanted = [17, -40, 3, 99];
        let residual = Polynomial::new(
            wanted.iter().zip(lsb).map(|(&w, l)| &Interval::from_int(w) * &Interval::from_f64(l)).collect(),
        );
        assert_eq!(nearest(&residual, &lsb, (&half().0, &half().1), &[]), wanted);
    }

    /// Of all coefficients in a box around the exact ones none is nearer, whatever these are.
    #[test]
    fn nothing_near_is_better() {
        for seed in 0..20 {
            let exact = [0, 1, 2].map(|k| (f64::from(seed * 3 + k) * 0.618).fract() - 0.5);
            // And a part that no polynomial of the degree has.
            let all = exact.iter().chain([0.3, 1.1].iter());
            let residual = Polynomial::new(all.map(|&c| Interval::from_f64(c)).collect());
            let lsb = [1.0, 1.0, 1.0];
            let found = supremum(&residual, &nearest(&residual, &lsb, (&half().0, &half().1), &[]), &lsb);
            for box_ in 0..9 * 9 * 9 {
                let delta = [box_ % 9 - 4, box_ / 9 % 9 - 4, box_ / 81 - 4];
                let there = supremum(&residual, &delta, &lsb);
                assert!(
                    found <= there * (1.0 + 1e-4),
                    "{exact:?}: {delta:?} gives {there}, found was {found}"
                );
            }
        }
    }

    /// Where the operations round much at one end, the distance is made small there.
    #[test]
    fn the_rounding_counts() {
        let residual = Polynomial::new([0.0, 0.0, 0.0, 1.0].map(Interval::from_f64).to_vec());
        let lsb = [1e-6; 3];
        let rounding = [Rounding { from: 0.25, to: 0.5, most: 0.02 }];
        let total = |delta: &[i64]| {
            let at = |v: f64| {
                let rest = v.powi(3) - (0..3).map(|k| delta[k] as f64 * 1e-6 * v.powi(k as i32)).sum::<f64>();
                rest.abs() + if v >= 0.25 { 0.02 } else { 0.0 }
            };
            (0..=1000).map(|i| at(f64::from(i) / 1000.0 - 0.5)).fold(0.0, f64::max)
        };
        let [without, with] =
            [&[][..], &rounding].map(|r| total(&nearest(&residual, &lsb, (&half().0, &half().1), r)));
        assert!(with < 0.9 * without, "{with} instead of {without}");
    }
}
