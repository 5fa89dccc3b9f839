//! How well the model itself is known: its 95 % band, from the covariance of what was fitted. This is an estimate
//! of statistics, not a proof, and stands apart from the bound: the bound says how near the routine is to the
//! model, the band how near the model is to the device.

use fitter::coefficients::Coefficients;
use fitter::terms::{Factor, Operator, Term};

use crate::physics::Physics;
use crate::quantity::Quantity;

/// Two-sided 95 % of a normal distribution.
const NORMAL_95: f64 = 1.959_964;
/// Readings at which the band is evaluated.
const POINTS: u32 = 401;

/// The largest half-width of the 95 % band over the range and the boxes, in the bound's unit; none where some
/// covariance is not known. Polynomial and terms are taken as independent of each other, for the file has no
/// covariance between them, and each term at its largest.
pub fn band(
    coefficients: &Coefficients,
    physics: &Physics,
    quantity: &Quantity,
    range: (f64, f64),
) -> Option<f64> {
    let covariance = &coefficients.identification.as_ref()?.covariance;
    let mut of_terms = 0.0;
    for term in &physics.terms {
        of_terms += variance(term, coefficients, physics, range)?;
    }
    if covariance.len() != coefficients.base.coefficients.len() {
        return None;
    }
    let of_base = |reading: f64| {
        let x = reading - coefficients.base.centre;
        let mut powers = vec![1.0; covariance.len()];
        for k in 1..powers.len() {
            powers[k] = powers[k - 1] * x;
        }
        let gain = coefficients.sensor.gain(reading) * quantity.bound_units_per_unit;
        gain * gain * quadratic(covariance, &powers)
    };
    let at = |i: u32| range.0 + (range.1 - range.0) * f64::from(i) / f64::from(POINTS - 1);
    let largest = (0..POINTS).map(|i| of_base(at(i))).fold(0.0, f64::max);
    Some(NORMAL_95 * (largest + of_terms).sqrt())
}

fn quadratic(covariance: &[Vec<f64>], v: &[f64]) -> f64 {
    let row = |row: &Vec<f64>| row.iter().zip(v).map(|(c, x)| c * x).sum::<f64>();
    covariance.iter().zip(v).map(|(r, x)| x * row(r)).sum::<f64>().max(0.0)
}

/// The largest variance that a term's coefficients give it.
fn variance(
    term: &Term,
    coefficients: &Coefficients,
    physics: &Physics,
    (from, to): (f64, f64),
) -> Option<f64> {
    if term.covariance.len() != term.coefficients.len() {
        return None;
    }
    // The ends between which an observable lies: each rises with what it is a function of.
    let ends = |name: &str| match physics.further.iter().find(|g| g.observable == name) {
        Some(input) => [input.from, input.to],
        None => [from, to].map(|reading| {
            let angle = coefficients.sensor.calculated(reading);
            match name {
                "angle_deg" => angle.to_degrees(),
                "angle_arcsec" => angle * fitter::units::ARCSEC_PER_RAD,
                _ => reading,
            }
        }),
    };
    let farthest = |name: &str, mean: f64| ends(name).iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
    let columns: Vec<f64> = match &term.operator {
        Operator::Product(product) => {
            let factor = |f: &Factor| farthest(&f.observable, f.mean).powi(i32::from(f.power));
            vec![product.factors.iter().map(factor).product()]
        }
        Operator::Play(play) => play.elements.iter().map(|e| e.half_width).collect(),
        Operator::Lag(lag) => vec![farthest(&lag.observable, lag.mean)],
        Operator::Hinge(hinge) => vec![farthest(&hinge.observable, hinge.threshold)],
        // Across the whole range from one call to the next.
        Operator::Rate(rate) => {
            let [low, high] = ends(&rate.observable);
            vec![(high - low).abs() / physics.period_s]
        }
        // Cosine and sine, bumps, steps and saturating terms stay within 1.
        Operator::Periodic(_) | Operator::Gaussian(_) | Operator::Exponential(_) | Operator::Step(_) => {
            vec![1.0; term.coefficients.len()]
        }
    };
    let sized: Vec<Vec<f64>> = term.covariance.iter().map(|r| r.iter().map(|c| c.abs()).collect()).collect();
    Some(quadratic(&sized, &columns))
}
