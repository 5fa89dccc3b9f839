//! Where to start the loop from: what the hysteresis acts on (the drive, or the elongation that the
//! structure answers with) and how strongly.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::looped::{Looped, Stretch};
use super::modal::Modal;
use super::operator::{Operator, Plays};
use super::sensitivity;
use crate::numerics::Limits;
use crate::thresholds::dynamic::linear::hysteresis::{EXPONENT, STRENGTHS};

/// What the operator acts on at the start of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Acts {
    /// On the drive: w joins u.
    OnDrive,
    /// On the static drive that would hold the position, z = G(1)⁺ y(k + ahead).
    OnElongation { ahead: bool },
}

/// The best start over what the operator may act on and how strongly; `None` where none can be simulated.
pub fn start(linear: &Modal, stretches: &[Stretch], hysteresis: bool) -> Option<Looped> {
    let mut best: Option<(f64, Looped)> = None;
    let acts = [Acts::OnDrive, Acts::OnElongation { ahead: false }, Acts::OnElongation { ahead: true }];
    for acts in acts {
        let Some((cz, dz)) = signal(linear, acts) else { continue };
        let Some((cz, dz, size)) = unit_size(linear, cz, dz, stretches) else { continue };
        for strength in STRENGTHS {
            let operator = if hysteresis {
                Operator::Hysteresis(Plays::unit(EXPONENT))
            } else {
                Operator::Memoryless { exponent: EXPONENT }
            };
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
fn signal(linear: &Modal, acts: Acts) -> Option<(Vec<f64>, Vec<f64>)> {
    let (n, m, p) = (linear.order(), linear.inputs, linear.outputs);
    let Acts::OnElongation { ahead } = acts else {
        let unit = (0..m * m).map(|i| if i / m == i % m { 1.0 } else { 0.0 }).collect();
        return Some((vec![0.0; m * n], unit));
    };
    let gain = linear.response(crate::dynamic::spectrum::Complex::new(1.0, 0.0));
    let g = Mat::from_fn(p, m, |i, j| gain[i * m + j].re);
    let mut gram = g.transpose() * &g;
    let trace: f64 = (0..m).map(|i| gram[(i, i)]).sum();
    for i in 0..m {
        gram[(i, i)] += 1e-6 * trace;
    }
    let inverse = gram.llt(Side::Lower).ok()?.solve(g.transpose());
    let c = Mat::from_fn(p, n, |i, s| linear.c[i * n + s]);
    let d = Mat::from_fn(p, m, |i, j| linear.d[i * m + j]);
    let (c, d) = if ahead {
        let b = Mat::from_fn(n, m, |s, j| linear.b[s * m + j]);
        let mut moved = Mat::<f64>::zeros(p, n);
        for (k, block) in linear.blocks.iter().enumerate() {
            let a = block.matrix();
            for i in 0..p {
                moved[(i, 2 * k)] = c[(i, 2 * k)] * a[0] + c[(i, 2 * k + 1)] * a[2];
                moved[(i, 2 * k + 1)] = c[(i, 2 * k)] * a[1] + c[(i, 2 * k + 1)] * a[3];
            }
        }
        (moved, &c * &b)
    } else {
        (c, d)
    };
    let rows = |matrix: Mat<f64>, columns: usize| -> Vec<f64> {
        (0..m * columns).map(|i| matrix[(i / columns, i % columns)]).collect()
    };
    Some((rows(&inverse * c, n), rows(&inverse * d, m)))
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
