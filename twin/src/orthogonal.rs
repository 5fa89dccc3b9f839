//! Least squares by a polynomial, for the definition of what is measured against one.

/// What a least-squares polynomial of the given order in `x` leaves of `y`: orthogonal polynomials on the
/// points themselves by the three-term recurrence (Forsythe 1957).
pub(crate) fn residual(x: &[f64], y: &[f64], order: usize) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut residual = y.to_vec();
    let mut previous = vec![0.0; x.len()];
    let mut current = vec![1.0; x.len()];
    let mut previous_square = 1.0;
    for degree in 0..=order {
        let square = dot(&current, &current);
        // Fewer distinct points than terms: the polynomial already passes through all of them.
        if square <= 0.0 {
            break;
        }
        let amount = dot(&residual, &current) / square;
        residual.iter_mut().zip(&current).for_each(|(r, p)| *r -= amount * p);
        let centre = x.iter().zip(&current).map(|(x, p)| x * p * p).sum::<f64>() / square;
        let back = if degree == 0 { 0.0 } else { square / previous_square };
        let next: Vec<f64> =
            x.iter().zip(&current).zip(&previous).map(|((x, p), q)| (x - centre) * p - back * q).collect();
        (previous, current, previous_square) = (current, next, square);
    }
    residual
}

#[cfg(test)]
mod tests {
    use super::residual;

    #[test]
    fn a_polynomial_leaves_nothing_and_what_is_left_is_orthogonal_to_every_power() {
        let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 20.0 - 0.7).collect();
        let power = |n: i32| x.iter().map(|x| x.powi(n)).collect::<Vec<f64>>();
        let cubic: Vec<f64> = x.iter().map(|x| 1.0 - 2.0 * x + 0.5 * x.powi(3)).collect();
        assert!(residual(&x, &cubic, 3).iter().all(|r| r.abs() < 1e-12));
        let left = residual(&x, &power(6), 5);
        assert!(left.iter().any(|r| r.abs() > 1e-3));
        for n in 0..=5 {
            let overlap: f64 = left.iter().zip(power(n)).map(|(r, p)| r * p).sum();
            assert!(overlap.abs() < 1e-12, "{n}: {overlap}");
        }
    }
}
