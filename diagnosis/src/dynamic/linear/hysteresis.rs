//! Where to start the loop from: what the hysteresis acts on (the drive, or the elongation that the
//! structure answers with) and how strongly.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use numerics::Limits;

use super::looped::{Looped, Stretch};
use super::modal::Modal;
use super::operator::Operator;
use super::sensitivity;
use crate::thresholds::dynamic::linear::hysteresis::{EXPONENT, STRENGTHS};

/// The best start over what the operator may act on and how strongly; `None` where none can be simulated.
pub fn start(linear: &Modal, stretches: &[Stretch], hysteresis: bool) -> Option<Looped> {
    let mut best: Option<(f64, Looped)> = None;
    for signal in [on_drive, on_elongation, on_next_elongation] {
        let Some((cz, dz)) = signal(linear) else { continue };
        let Some((cz, dz, size)) = unit_size(linear, cz, dz, stretches) else { continue };
        for strength in STRENGTHS {
            let operator =
                if hysteresis { Operator::hysteresis(EXPONENT) } else { Operator::memoryless(EXPONENT) };
            let scaled = |b: &[f64]| -> Vec<f64> {
                b.chunks_exact(linear.inputs)
                    .flat_map(|row| row.iter().zip(&size).map(|(b, s)| strength * b * s))
                    .collect()
            };
            let (e, f) = (scaled(&linear.b), scaled(&linear.d));
            let model = Looped { linear: linear.clone(), e, f, cz: cz.clone(), dz: dz.clone(), operator };
            let Some(cost) = sensitivity::cost(&model, stretches) else { continue };
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, model));
            }
        }
    }
    best.map(|(_, model)| model)
}

/// The start, fitted in full.
pub fn fit(linear: &Modal, stretches: &[Stretch], hysteresis: bool, limits: Limits) -> Option<Looped> {
    Some(sensitivity::fit(&start(linear, stretches, hysteresis)?, stretches, limits))
}

/// C_z and D_z of a signal per drive.
type Signal = Option<(Vec<f64>, Vec<f64>)>;

/// The drive itself: w joins u.
fn on_drive(linear: &Modal) -> Signal {
    let (n, m) = (linear.order(), linear.inputs);
    Some((vec![0.0; m * n], (0..m * m).map(|i| if i / m == i % m { 1.0 } else { 0.0 }).collect()))
}

/// The static drive that would hold the position.
fn on_elongation(linear: &Modal) -> Signal {
    held(linear, linear.c.clone(), linear.d.clone())
}

/// That which would hold the next position.
fn on_next_elongation(linear: &Modal) -> Signal {
    let (n, m, p) = (linear.order(), linear.inputs, linear.outputs);
    let matrix = |rows: usize, columns: usize, values: &[f64]| {
        Mat::from_fn(rows, columns, |i, j| values[i * columns + j])
    };
    let through = matrix(p, n, &linear.c) * matrix(n, m, &linear.b);
    let mut ahead = linear.c.clone();
    linear.times_a(&mut ahead);
    held(linear, ahead, (0..p * m).map(|i| through[(i / m, i % m)]).collect())
}

/// G(1)⁺ of positions C x + D u.
fn held(linear: &Modal, c: Vec<f64>, d: Vec<f64>) -> Signal {
    let (n, m, p) = (linear.order(), linear.inputs, linear.outputs);
    let gain = linear.response(crate::dynamic::spectrum::Complex::new(1.0, 0.0));
    let g = Mat::from_fn(p, m, |i, j| gain[i * m + j].re);
    let mut gram = g.transpose() * &g;
    let trace: f64 = (0..m).map(|i| gram[(i, i)]).sum();
    for i in 0..m {
        gram[(i, i)] += 1e-6 * trace;
    }
    let inverse = gram.llt(Side::Lower).ok()?.solve(g.transpose());
    let rows = |values: Vec<f64>, columns: usize| -> Vec<f64> {
        let product = &inverse * Mat::from_fn(p, columns, |i, j| values[i * columns + j]);
        (0..m * columns).map(|i| product[(i / columns, i % columns)]).collect()
    };
    Some((rows(c, n), rows(d, m)))
}

/// Scales every signal to a largest value of one over the stretches; the sizes, too.
fn unit_size(
    linear: &Modal,
    mut cz: Vec<f64>,
    mut dz: Vec<f64>,
    stretches: &[Stretch],
) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
    let (n, m) = (linear.order(), linear.inputs);
    let q = dz.len() / m;
    let probe = Looped::plain(Modal { outputs: q, c: cz.clone(), d: dz.clone(), ..linear.clone() });
    let mut size = vec![0.0f64; q];
    for stretch in stretches {
        let z = if stretch.periodic {
            probe.steady(&stretch.drive)?
        } else {
            probe.simulate(&stretch.drive, &mut probe.rest())?
        };
        for row in z.chunks_exact(q) {
            for (s, z) in size.iter_mut().zip(row) {
                *s = s.max(z.abs());
            }
        }
    }
    if size.iter().any(|&s| s <= 0.0 || s.is_nan()) {
        return None;
    }
    for l in 0..q {
        cz[l * n..(l + 1) * n].iter_mut().for_each(|v| *v /= size[l]);
        dz[l * m..(l + 1) * m].iter_mut().for_each(|v| *v /= size[l]);
    }
    Some((cz, dz, size))
}
