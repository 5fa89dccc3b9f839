//! Best polynomial approximation by Remez exchange.
//!
//! The function comes as a polynomial of high degree (see [`crate::reference`]). Written in Chebyshev
//! polynomials of the range, exactly, it splits into the part of degree ≤ n, kept as it is, and a tail that
//! is as small as the approximation error itself. Only the tail is exchanged, in `f64`: its rounding is
//! 10⁻¹⁵ of the *error*, not of the function, so the result is a best approximation to that precision
//! however small the error is. What is claimed about the result is certified elsewhere, exactly.

use crate::exact::{Interval, Polynomial};

/// Points of the search grid per alternation.
const GRID_PER_EXTREMUM: usize = 48;
/// Exchanges before giving up; each squares the distance from the best.
const EXCHANGES: usize = 40;
/// Levelled to this part of the error is levelled.
const LEVEL: f64 = 1e-5;

/// The best approximation of `function` of degree ≤ `degree` for v from `from` to `to` (points).
pub fn minimax(function: &Polynomial, degree: usize, from: &Interval, to: &Interval) -> Polynomial {
    let centre = from.hull(to).midpoint();
    let radius = (to - &centre).upper();
    let mut series = chebyshev(function, &centre, &radius);
    if series.len() > degree + 1 {
        let tail: Vec<f64> =
            series.iter().enumerate().map(|(k, c)| if k <= degree { 0.0 } else { c.to_f64() }).collect();
        let correction = exchange(&tail, degree);
        series.truncate(degree + 1);
        for (c, add) in series.iter_mut().zip(correction) {
            *c = &*c + &Interval::from_f64(add);
        }
    }
    let mut in_u = from_chebyshev(&series);
    let mut power = Interval::from_int(1);
    for c in &mut in_u {
        *c = c.div(&power).midpoint();
        power = (&power * &radius).midpoint();
    }
    let in_v = Polynomial::new(in_u).shift(&-centre);
    Polynomial::new(in_v.coefficients().iter().map(Interval::midpoint).collect())
}

/// A lower bound of the distance of every polynomial of degree ≤ `degree` from `function` for v from `from` to `to`
/// (points), given the best one: where its distance alternates in sign at degree + 2 points, none is nearer than the
/// least of these (de la Vallée-Poussin). The points are searched in `f64`, the distances enclosed.
pub fn least_distance(
    function: &Polynomial,
    best: &Polynomial,
    degree: usize,
    from: &Interval,
    to: &Interval,
) -> Interval {
    let centre = from.hull(to).midpoint();
    // Not beyond either end.
    let (above, below) = ((to - &centre).lower(), (&centre - from).lower());
    let radius = if above.certainly_le(&below) { above } else { below };
    let difference = function.sub(best);
    let series: Vec<f64> = chebyshev(&difference, &centre, &radius).iter().map(Interval::to_f64).collect();
    let cells = GRID_PER_EXTREMUM * (degree + 2);
    let grid: Vec<f64> =
        (0..=cells).map(|i| -(std::f64::consts::PI * i as f64 / cells as f64).cos()).collect();
    let errors: Vec<f64> = grid.iter().map(|&u| clenshaw(&series, u)).collect();
    let Some(kept) = strongest_run(&errors, alternating_extrema(&errors), degree + 2) else {
        return Interval::zero();
    };
    let distances = kept.iter().enumerate().map(|(k, &i)| {
        let u = refine(&grid, &errors, i).clamp(-1.0, 1.0);
        let there = difference.at(&(&centre + &(&radius * &Interval::from_f64(u))).midpoint());
        let upward = (errors[kept[0]] > 0.0) == (k % 2 == 0);
        (if upward { there } else { -there }).lower()
    });
    let least =
        distances.reduce(|a, b| if a.certainly_le(&b) { a } else { b }).unwrap_or_else(Interval::zero);
    if least.certainly_le(&Interval::zero()) { Interval::zero() } else { least }
}

/// Chebyshev coefficients of a function of v = centre + radius·u in u, as points near them.
pub(crate) fn chebyshev(function: &Polynomial, centre: &Interval, radius: &Interval) -> Vec<Interval> {
    let mut power = Interval::from_int(1);
    let mut in_u = function.shift(centre).coefficients().to_vec();
    for c in &mut in_u {
        *c = (&*c * &power).midpoint();
        power = (&power * radius).midpoint();
    }
    to_chebyshev(&in_u)
}

/// Chebyshev coefficients of Σcₖuᵏ, by Horner with u·Tₖ = (Tₖ₊₁ + T|ₖ₋₁|)/2.
pub(crate) fn to_chebyshev(monomial: &[Interval]) -> Vec<Interval> {
    let mut series: Vec<Interval> = Vec::with_capacity(monomial.len());
    for c in monomial.iter().rev() {
        let mut next = vec![Interval::zero(); series.len() + 1];
        for (k, s) in series.iter().enumerate() {
            let half = s.mul_pow2(-1).midpoint();
            next[k + 1] = &next[k + 1] + &half;
            let mirrored = k.abs_diff(1);
            next[mirrored] = &next[mirrored] + &half;
        }
        next[0] = &next[0] + c;
        series = next;
    }
    series
}

/// Monomial coefficients of ΣcₖTₖ(u), by Tₖ₊₁ = 2u·Tₖ − Tₖ₋₁.
fn from_chebyshev(series: &[Interval]) -> Vec<Interval> {
    let n = series.len();
    let mut sum = vec![Interval::zero(); n];
    let mut previous = vec![0i64; n];
    let mut current = vec![0i64; n];
    current[0] = 1;
    for (k, c) in series.iter().enumerate() {
        for (s, t) in sum.iter_mut().zip(&current) {
            *s = &*s + &(c * &Interval::from_int(*t));
        }
        let factor = if k == 0 { 1 } else { 2 };
        let next: Vec<i64> = (0..n)
            .map(|i| factor * (if i > 0 { current[i - 1] } else { 0 }) - if k == 0 { 0 } else { previous[i] })
            .collect();
        previous = std::mem::replace(&mut current, next);
    }
    sum
}

/// Chebyshev coefficients c₀…c_degree of the best approximation of ΣtailₖTₖ on [−1, 1].
fn exchange(tail: &[f64], degree: usize) -> Vec<f64> {
    let points = degree + 2;
    let mut at: Vec<f64> =
        (0..points).map(|i| -(std::f64::consts::PI * i as f64 / (points - 1) as f64).cos()).collect();
    let cells = GRID_PER_EXTREMUM * points;
    let grid: Vec<f64> =
        (0..=cells).map(|i| -(std::f64::consts::PI * i as f64 / cells as f64).cos()).collect();
    let values: Vec<f64> = grid.iter().map(|&u| clenshaw(tail, u)).collect();
    let mut best = vec![0.0; degree + 1];
    let mut best_error = f64::INFINITY;
    for _ in 0..EXCHANGES {
        let levelled = levelled_interpolant(&at, tail, degree);
        let errors: Vec<f64> = grid.iter().zip(&values).map(|(&u, v)| v - clenshaw(&levelled, u)).collect();
        let extrema = alternating_extrema(&errors);
        let largest = extrema.iter().map(|&i| errors[i].abs()).fold(0.0, f64::max);
        if largest < best_error {
            best_error = largest;
            best = levelled;
        }
        let Some(kept) = strongest_run(&errors, extrema, points) else { break };
        let smallest = kept.iter().map(|&i| errors[i].abs()).fold(f64::INFINITY, f64::min);
        if largest - smallest <= LEVEL * largest {
            break;
        }
        at = kept.iter().map(|&i| refine(&grid, &errors, i)).collect();
    }
    best
}

/// The polynomial of degree ≤ n whose error is +e, −e, +e, … at the n + 2 points `at`.
fn levelled_interpolant(at: &[f64], tail: &[f64], degree: usize) -> Vec<f64> {
    let weight = |among: &[f64], i: usize| {
        among
            .iter()
            .enumerate()
            .filter(|(j, _)| *j != i)
            .map(|(_, x)| 2.0 * (among[i] - x))
            .product::<f64>()
            .recip()
    };
    let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let values: Vec<f64> = at.iter().map(|&u| clenshaw(tail, u)).collect();
    let (mut above, mut below) = (0.0, 0.0);
    for (i, v) in values.iter().enumerate() {
        let w = weight(at, i);
        above += w * v;
        below += w * sign(i);
    }
    let level = above / below;
    // The last point is left out: the others determine the polynomial. Barycentric, at Chebyshev nodes.
    let among = &at[..=degree];
    let weights: Vec<f64> = (0..=degree).map(|i| weight(among, i)).collect();
    let ordinates: Vec<f64> = (0..=degree).map(|i| values[i] - sign(i) * level).collect();
    let n = degree + 1;
    let nodes: Vec<f64> =
        (0..n).map(|j| (std::f64::consts::PI * (j as f64 + 0.5) / n as f64).cos()).collect();
    let at_nodes: Vec<f64> = nodes
        .iter()
        .map(|&u| {
            if let Some(i) = among.iter().position(|&x| x == u) {
                return ordinates[i];
            }
            let terms = || weights.iter().zip(among).map(|(w, x)| w / (u - x));
            let numerator: f64 = terms().zip(&ordinates).map(|(t, y)| t * y).sum();
            numerator / terms().sum::<f64>()
        })
        .collect();
    (0..n)
        .map(|k| {
            let basis = |j: usize| (std::f64::consts::PI * k as f64 * (j as f64 + 0.5) / n as f64).cos();
            let sum: f64 = at_nodes.iter().enumerate().map(|(j, y)| y * basis(j)).sum();
            sum * if k == 0 { 1.0 } else { 2.0 } / n as f64
        })
        .collect()
}

/// ΣcₖTₖ(u) by Clenshaw's recurrence.
pub(crate) fn clenshaw(series: &[f64], u: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for c in series.iter().skip(1).rev() {
        (b1, b2) = (2.0 * u * b1 - b2 + c, b1);
    }
    series.first().copied().unwrap_or(0.0) + u * b1 - b2
}

/// The index of the largest magnitude in every run of one sign.
fn alternating_extrema(errors: &[f64]) -> Vec<usize> {
    let mut extrema: Vec<usize> = Vec::new();
    for (i, e) in errors.iter().enumerate() {
        match extrema.last_mut() {
            Some(last) if (errors[*last] > 0.0) == (*e > 0.0) => {
                if e.abs() > errors[*last].abs() {
                    *last = i;
                }
            }
            _ => extrema.push(i),
        }
    }
    extrema
}

/// `count` consecutive extrema, dropping the smaller end until so many are left; `None` where there are fewer.
fn strongest_run(errors: &[f64], mut extrema: Vec<usize>, count: usize) -> Option<Vec<usize>> {
    while extrema.len() > count {
        let (first, last) = (errors[extrema[0]].abs(), errors[extrema[extrema.len() - 1]].abs());
        if first < last {
            extrema.remove(0);
        } else {
            extrema.pop();
        }
    }
    (extrema.len() == count).then_some(extrema)
}

/// The vertex of the parabola through a grid extremum and its neighbours.
fn refine(grid: &[f64], errors: &[f64], i: usize) -> f64 {
    if i == 0 || i + 1 == grid.len() {
        return grid[i];
    }
    let (x0, x1, x2) = (grid[i - 1], grid[i], grid[i + 1]);
    let (s01, s12) = ((errors[i] - errors[i - 1]) / (x1 - x0), (errors[i + 1] - errors[i]) / (x2 - x1));
    let curvature = (s12 - s01) / (x2 - x0);
    if curvature == 0.0 {
        return x1;
    }
    (0.5 * (x0 + x1 - s01 / curvature)).clamp(x0, x2)
}

/// The polynomial through the values at Chebyshev's nodes of an interval, in the powers of its variable.
pub(crate) fn interpolate(degree: usize, from: f64, to: f64, value: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let count = degree + 1;
    let nodes: Vec<f64> = (0..count)
        .map(|i| {
            let angle = std::f64::consts::PI * (i as f64 + 0.5) / count as f64;
            0.5 * (from + to) - 0.5 * (to - from) * angle.cos()
        })
        .collect();
    // Newton's divided differences, then Horner's scheme from the inside out.
    let mut differences: Vec<f64> = nodes.iter().map(|x| value(*x)).collect();
    for order in 1..count {
        for i in (order..count).rev() {
            let span = nodes[i] - nodes[i - order];
            differences[i] = if span == 0.0 { 0.0 } else { (differences[i] - differences[i - 1]) / span };
        }
    }
    let mut powers = vec![0.0; count];
    for i in (0..count).rev() {
        for k in (0..count).rev() {
            powers[k] = if k > 0 { powers[k - 1] } else { 0.0 } - nodes[i] * powers[k];
        }
        powers[0] += differences[i];
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_model;
    use crate::reference::{ReadingMap, Reference};

    fn certified_error_arcsec(degree: usize) -> f64 {
        let map = ReadingMap { offset: Interval::zero(), slope: Interval::from_int(1) };
        let end = Interval::from_f64(0.38);
        let reference = Reference::new(&paper_model(), &map, &-end.clone(), &end).unwrap();
        let best = minimax(&reference.polynomial, degree, &-end.clone(), &end);
        let difference = best.sub(&reference.polynomial);
        let sup = difference.supremum(&-end.clone(), &end, &Interval::from_f64(1e-17));
        sup.to_f64_up() * 206_264.806_247_096_36
    }

    /// Supremum errors of best approximations of Eq. 13 on |s| ≤ 0.38 mm, found independently.
    #[test]
    fn known_best_errors_are_reached() {
        for (degree, arcsec) in
            [(3, 1.60), (4, 0.95), (6, 0.55), (8, 0.14), (9, 6.1e-5), (10, 3.4e-5), (11, 1.5e-8)]
        {
            let found = certified_error_arcsec(degree);
            assert!((found / arcsec - 1.0).abs() < 0.04, "degree {degree}: {found} instead of {arcsec}");
        }
    }

    /// A best approximation of xⁿ⁺¹ on [−1, 1] is 2⁻ⁿ away (Chebyshev).
    #[test]
    fn chebyshev_s_theorem() {
        let one = Interval::from_int(1);
        for n in 1..12 {
            let mut c = vec![Interval::zero(); n + 1];
            c.push(one.clone());
            let f = Polynomial::new(c);
            let p = minimax(&f, n, &-one.clone(), &one);
            let sup = f.sub(&p).supremum(&-one.clone(), &one, &Interval::from_f64(1e-12)).to_f64_up();
            assert!((sup * 2f64.powi(n as i32) - 1.0).abs() < 1e-4, "n = {n}: {sup}");
        }
    }
}
