//! What is reported of an effect and no expression of its parameters says.

use fitter::terms::{Hinge, Operator};

use super::{Effect, Handed};
use crate::rows::Rows;
use crate::thresholds::effects::report::LOOP_STEPS;

/// A figure of an effect with its shape and amplitudes in a recording.
pub type Function = fn(&Effect, &Rows, &[f64], &[f64]) -> f64;

/// The function of a name.
pub fn named(name: &str) -> Option<Function> {
    let known: [(&str, Function); 4] = [
        ("half_height_of_loop", half_height_of_loop),
        ("strongest_amplitude", strongest_amplitude),
        ("strongest_period", strongest_period),
        ("threshold", threshold),
    ];
    known.into_iter().find(|(known, _)| *known == name).map(|(_, function)| function)
}

/// The largest distance of the steady loop over the stroke from its own polynomial of order 9: of positions in any order the
/// rows trace no such loop.
fn half_height_of_loop(effect: &Effect, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> f64 {
    let (low, high) = rows.stroke();
    let forward = (-LOOP_STEPS..=LOOP_STEPS).map(|k| f64::from(k) / f64::from(LOOP_STEPS));
    let cycle: Vec<f64> = forward.clone().chain(forward.rev()).collect();
    let theta = cycle.iter().chain(&cycle).map(|x| 0.5 * (low + high) + 0.5 * x * (high - low)).collect();
    let count = 2 * cycle.len();
    let twice =
        Rows { theta, t_s: vec![0.0; count], pass: vec![0; count], pair: rows.pair, ..Rows::default() };
    let mut distance = vec![0.0; cycle.len()];
    for (amplitude, column) in amplitudes.iter().zip(effect.signature(&twice, shape)) {
        distance.iter_mut().zip(&column[cycle.len()..]).for_each(|(sum, value)| *sum += amplitude * value);
    }
    let mut polynomial = numerics::Basis::new(cycle.len());
    for column in crate::base::legendre(&cycle, 9) {
        polynomial.add(&column);
    }
    polynomial.project_off(&mut distance);
    distance.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()))
}

/// Number and amplitude of the strongest harmonic, of which each has a sine and a cosine.
fn strongest(amplitudes: &[f64]) -> (usize, f64) {
    let sizes = amplitudes.chunks_exact(2).map(|pair| pair[0].hypot(pair[1]));
    (1..).zip(sizes).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((1, 0.0))
}

fn strongest_amplitude(_: &Effect, _: &Rows, _: &[f64], amplitudes: &[f64]) -> f64 {
    strongest(amplitudes).1
}

fn strongest_period(effect: &Effect, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> f64 {
    effect.period(rows, shape).unwrap_or(f64::NAN) / strongest(amplitudes).0 as f64
}

/// Where a change of slope sets in, in the unit of places on the angle.
fn threshold(effect: &Effect, rows: &Rows, shape: &[f64], _: &[f64]) -> f64 {
    match effect.term(rows, shape) {
        Some(Handed { operator: Operator::Hinge(Hinge { threshold, .. }), .. }) => {
            threshold / rows.per_degree()
        }
        _ => f64::NAN,
    }
}
