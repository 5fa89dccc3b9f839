//! The combination of some functions that is nearest to another on points, in the supremum norm with a margin.
//!
//! Least E with |tᵢ − Σxₖ·φₖᵢ| + wᵢ ≤ E for every point i, a linear programme. Its dual has one weight for each active
//! point: it is solved by exchanging one active point at a time (the simplex method, of which Remez' single exchange is
//! the special case of polynomials).

use super::subtract;

/// Exchanges before giving up: then the last level is not the least, but what is found is a combination all the same.
const EXCHANGES: usize = 400;
/// A point so little above the level, as a part of it, is on it.
const ON_THE_LEVEL: f64 = 1e-9;

/// An active point: s·(t − Σxφ) + w = E. `None` stands for none yet.
type Active = Option<(usize, f64)>;

/// The factors of `functions` and the level E.
pub(super) fn level(functions: &[Vec<f64>], target: &[f64], margin: &[f64]) -> (Vec<f64>, f64) {
    let n = functions.len();
    // Functions of size 1, so that equations are balanced.
    let sizes: Vec<f64> =
        functions.iter().map(|f| f.iter().fold(f64::MIN_POSITIVE, |m: f64, v| m.max(v.abs()))).collect();
    let functions: Vec<Vec<f64>> =
        functions.iter().zip(&sizes).map(|(f, size)| f.iter().map(|v| v / size).collect()).collect();
    let mut active: Vec<Active> = vec![None; n + 1];
    let mut solution = vec![0.0; n + 1];
    for _ in 0..EXCHANGES {
        let matrix = matrix(&functions, &active);
        let start = active.contains(&None);
        // Until all points are there, only their number counts.
        let cost = |(i, s): (usize, f64)| if start { 0.0 } else { s * target[i] + margin[i] };
        let costs: Vec<f64> = active.iter().map(|a| a.map_or(-1.0, cost)).collect();
        let Some([prices]) = solve(&matrix, [&costs], true) else { break };
        let mut sums = vec![0.0; target.len()];
        functions.iter().zip(&prices).for_each(|(f, price)| subtract(&mut sums, -price, f));
        // The point that is furthest above the level, and on which side.
        let mut entering = (0, 1.0);
        let mut above = f64::NEG_INFINITY;
        for (i, sum) in sums.iter().enumerate() {
            let (rest, margin) = if start { (-sum, 0.0) } else { (target[i] - sum, margin[i]) };
            if rest.abs() + margin > above {
                above = rest.abs() + margin;
                entering = (i, if rest > 0.0 { 1.0 } else { -1.0 });
            }
        }
        let done = above - prices[n] <= ON_THE_LEVEL * if start { 1.0 } else { prices[n].abs() };
        if !start {
            solution = prices;
        }
        if done {
            break;
        }
        let mut total = vec![0.0; n + 1];
        total[n] = 1.0;
        let entered = column(&functions, entering);
        let Some([weights, change]) = solve(&matrix, [&total, &entered], false) else { break };
        let leaving = (0..=n)
            .filter(|j| change[*j] > SMALLEST_PIVOT)
            .min_by(|a, b| (weights[*a] / change[*a]).total_cmp(&(weights[*b] / change[*b])));
        let Some(leaving) = leaving else { break };
        active[leaving] = Some(entering);
    }
    let factors: Vec<f64> = (0..n).map(|k| solution[k] / sizes[k]).collect();
    (factors, solution[n])
}

/// Pivots below are zero but for rounding, of functions of size 1.
const SMALLEST_PIVOT: f64 = 1e-12;

/// The column of an active point.
fn column(functions: &[Vec<f64>], (i, s): (usize, f64)) -> Vec<f64> {
    functions.iter().map(|f| s * f[i]).chain([1.0]).collect()
}

/// The columns of the active points; for a missing one a unit vector.
fn matrix(functions: &[Vec<f64>], active: &[Active]) -> Vec<Vec<f64>> {
    let unit = |j: usize| (0..active.len()).map(|k| f64::from(k == j)).collect();
    active
        .iter()
        .enumerate()
        .map(|(j, a)| a.map_or_else(|| unit(j), |point| column(functions, point)))
        .collect()
}

/// Solves Mx = b for every right side, or xᵀM = bᵀ where `transposed`, M being given by its columns; `None` where it is singular.
fn solve<const SIDES: usize>(
    columns: &[Vec<f64>],
    right: [&[f64]; SIDES],
    transposed: bool,
) -> Option<[Vec<f64>; SIDES]> {
    let n = columns.len();
    let width = n + SIDES;
    let entry = |i: usize, j: usize| if transposed { columns[i][j] } else { columns[j][i] };
    let row = |i: usize| (0..n).map(move |j| entry(i, j)).chain(right.iter().map(move |side| side[i]));
    let mut rows: Vec<f64> = (0..n).flat_map(row).collect();
    for k in 0..n {
        let size = |i: usize| rows[i * width + k].abs();
        let pivot = (k..n).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
        if size(pivot) < SMALLEST_PIVOT {
            return None;
        }
        let (above, below) = rows.split_at_mut((k + 1) * width);
        let top = &mut above[k * width..];
        if pivot > k {
            top.swap_with_slice(&mut below[(pivot - k - 1) * width..][..width]);
        }
        for row in below.chunks_exact_mut(width) {
            let factor = row[k] / top[k];
            if factor != 0.0 {
                row[k..].iter_mut().zip(&top[k..]).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
    Some(std::array::from_fn(|side| {
        let mut x = vec![0.0; n];
        for k in (0..n).rev() {
            let row = &rows[k * width..(k + 1) * width];
            let known: f64 = (k + 1..n).map(|j| row[j] * x[j]).sum();
            x[k] = (row[n + side] - known) / row[k];
        }
        x
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of xⁿ on [−1, 1] the best combination of lower powers leaves 2^(1 − n) (Chebyshev).
    #[test]
    fn the_level_of_a_power_is_chebyshev_s() {
        let points: Vec<f64> =
            (0..400).map(|i| -(std::f64::consts::PI * f64::from(i) / 399.0).cos()).collect();
        for n in 1..10 {
            let power = |k: i32| -> Vec<f64> { points.iter().map(|x| x.powi(k)).collect() };
            let lower: Vec<Vec<f64>> = (0..n).map(power).collect();
            let level = level(&lower, &power(n), &vec![0.0; points.len()]).1 * 2f64.powi(n - 1);
            assert!((level - 1.0).abs() < 1e-3, "n = {n}: {level}");
        }
    }

    /// With a margin no point is above the level, and as many as there are unknowns, and one, are on it.
    #[test]
    fn the_margin_counts() {
        let points: Vec<f64> = (0..300).map(|i| f64::from(i) / 299.0).collect();
        let functions: Vec<Vec<f64>> = (0..4).map(|k| points.iter().map(|x| x.powi(k)).collect()).collect();
        let target: Vec<f64> = points.iter().map(|x| x.exp()).collect();
        let margin: Vec<f64> = points.iter().map(|x| if *x > 0.7 { 1e-3 } else { 0.0 }).collect();
        let (factors, level) = level(&functions, &target, &margin);
        let mut rest = target;
        functions.iter().zip(&factors).for_each(|(f, x)| subtract(&mut rest, *x, f));
        let sums: Vec<f64> = rest.iter().zip(&margin).map(|(r, w)| r.abs() + w).collect();
        assert!(sums.iter().all(|s| *s <= level * (1.0 + 1e-6)), "{level}");
        assert_eq!(sums.iter().filter(|s| **s >= level * (1.0 - 1e-6)).count(), 5);
    }
}
