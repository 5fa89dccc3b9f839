//! Tests through the public items. Tests inside the library would compile it a second time, which takes long.

#![allow(clippy::unwrap_used)] // how a test fails

use numerics::{Complex, Symmetric, fourier, hermitian, parallel, student_95};

#[test]
fn few_degrees_of_freedom_widen() {
    assert!((student_95(10.0) / 2.2281 - 1.0).abs() < 1e-4);
    assert!((student_95(1e6) / 1.959964 - 1.0).abs() < 1e-4);
}

#[test]
fn solves_and_leaves_out_what_is_dependent() {
    let mut a = Symmetric::zero(3);
    let rows = [[4.0, 2.0, 4.0], [2.0, 3.0, 2.0], [4.0, 2.0, 4.0]];
    a.entries = rows.concat();
    let x = a.factor().solve(&[8.0, 7.0, 8.0]);
    assert_eq!(x[2], 0.0);
    assert!((4.0 * x[0] + 2.0 * x[1] - 8.0).abs() < 1e-12);
    assert!((2.0 * x[0] + 3.0 * x[1] - 7.0).abs() < 1e-12);
}

#[test]
fn dividing_undoes_multiplying() {
    let c = Complex::new;
    let s = [c(4.0, 0.0), c(1.0, -2.0), c(1.0, 2.0), c(5.0, 0.0)];
    let x = [c(1.0, 1.0), c(-2.0, 0.5)];
    let b = [x[0] * s[0] + x[1] * s[2], x[0] * s[1] + x[1] * s[3]];
    let found = hermitian::divide(&b, 1, &hermitian::cholesky(&s, 2).unwrap(), 2);
    assert!(found.iter().zip(&x).all(|(f, x)| (f - x).norm() < 1e-12));
    assert!(hermitian::cholesky(&[c(1.0, 0.0), c(1.0, 0.0), c(1.0, 0.0), c(1.0, 0.0)], 2).is_none());
}

#[test]
fn a_sine_stands_on_its_line_with_half_its_amplitude() {
    let record: Vec<f64> =
        (0..64).map(|n| 3.0 * (std::f64::consts::TAU * 5.0 * n as f64 / 64.0).sin()).collect();
    let x = fourier::coefficients(&record);
    assert!((x[5].norm() - 1.5).abs() < 1e-12);
    assert!(x.iter().enumerate().all(|(k, v)| k == 5 || v.norm() < 1e-12));
}

#[test]
fn the_window_keeps_the_power() {
    let w = fourier::hann(128);
    let power: f64 = w.iter().map(|v| v * v).sum::<f64>() / 128.0;
    assert!((power - 1.0).abs() < 1e-12);
}

#[test]
fn results_are_in_the_order_of_the_items() {
    let squares: Vec<usize> = (0..1000).map(|k| k * k).collect();
    assert_eq!(parallel::indices(0..1000, |k| k * k), squares);
    assert_eq!(parallel::filter_map(&squares, |s| (s % 2 == 0).then_some(*s)).len(), 500);
    assert_eq!(parallel::join(|| 1, || "two"), (1, "two"));
}
