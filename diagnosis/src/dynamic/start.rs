//! Where the identification of the nominal plant starts: the equation of motion between signals that have
//! passed the same low-pass filter (state-variable filters: P. C. Young, Automatica 17 (1981)), solved by
//! least squares and refined by instrumental variables from the model's own simulation (SRIVC).

use fitter::plant::Hold;
use numerics::{Symmetric, parallel};

use super::data::{ALL, Data, HOLDS};
use super::estimate::{Fitted, Simulated, fit_with_each_hold};
use super::model::Model;
use crate::thresholds::dynamic::start::{ROUNDS, WIDTHS};

/// The nominal plant of a recording, fitted by output error, for every way in which the drive may run
/// between its samples; the best first. Empty where no start leads to a plant that can be simulated.
pub fn nominal(data: &Data) -> Vec<Fitted> {
    let states = data.first_states();
    let cost = |plant: [f64; 3]| -> Option<(f64, Vec<f64>)> {
        let y = Model::nominal(plant, Hold::FirstOrder).positions(&states, data).ok()?;
        let cost: f64 =
            data.runs.iter().flat_map(|r| r.clone()).map(|k| (y[k] - data.position[k]).powi(2)).sum();
        cost.is_finite().then_some((cost, y))
    };
    let starts: Vec<Vec<(f64, [f64; 3])>> = parallel::map(&WIDTHS, |width| {
        let omega = (width * data.scale.rate).min(1.0 / data.step_s);
        let mut denominator = [2.0 * omega, omega * omega];
        let mut simulated: Option<Vec<f64>> = None;
        let mut found = Vec::new();
        for _ in 0..ROUNDS {
            let Some(next) = solve(data, denominator, simulated.as_deref()) else { break };
            // A filter has to be stable, and no slower than the plant can be seen.
            if next[1] > 0.0 && next[0] > 0.0 {
                denominator = [next[0].max(0.02 * next[1].sqrt()), next[1]];
            }
            simulated = match cost(next) {
                Some((cost, y)) => {
                    found.push((cost, next));
                    Some(y)
                }
                None => None,
            };
        }
        found
    });
    let Some((_, plant)) = starts.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Vec::new();
    };
    let mut fitted = fit_with_each_hold(HOLDS, &Model::nominal(plant, HOLDS[0]), &states, data, ALL);
    fitted.sort_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)));
    fitted
}

/// Filtered signal and its first two derivatives through 1 / (s² + a s + b), by steps in which the input
/// runs straight.
fn filtered(values: &[f64], [a, b]: [f64; 2], step_s: f64) -> Vec<[f64; 3]> {
    // Fourth-order Runge–Kutta with enough steps; the filter is no faster than the sampling.
    let substeps = ((b.sqrt().max(a) * step_s / 0.3).ceil() as usize).clamp(1, 64);
    let h = step_s / substeps as f64;
    let (mut x, mut v) = (values[0] / b, 0.0);
    let mut out = Vec::with_capacity(values.len());
    for k in 0..values.len() {
        out.push([x, v, values[k] - a * v - b * x]);
        let Some(next) = values.get(k + 1) else { break };
        for i in 0..substeps {
            let at = |part: f64| values[k] + (next - values[k]) * (i as f64 + part) / substeps as f64;
            let rate = |x: f64, v: f64, u: f64| (v, u - a * v - b * x);
            let (k1, l1) = rate(x, v, at(0.0));
            let (k2, l2) = rate(x + 0.5 * h * k1, v + 0.5 * h * l1, at(0.5));
            let (k3, l3) = rate(x + 0.5 * h * k2, v + 0.5 * h * l2, at(0.5));
            let (k4, l4) = rate(x + h * k3, v + h * l3, at(1.0));
            x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
    }
    out
}

/// Solves y″ = −d y′ − k y + g u + c between filtered signals; the instruments are the filtered simulation,
/// where there is one.
fn solve(data: &Data, filter: [f64; 2], simulated: Option<&[f64]>) -> Option<[f64; 3]> {
    const UNKNOWNS: usize = 4;
    let mut cross = [[0.0; UNKNOWNS]; UNKNOWNS];
    let mut right = [0.0; UNKNOWNS];
    for run in &data.runs {
        let y = filtered(&data.position[run.clone()], filter, data.step_s);
        let u = filtered(&data.drive[run.clone()], filter, data.step_s);
        let z = simulated.map(|s| filtered(&s[run.clone()], filter, data.step_s));
        // The filter's own transient is left out.
        let skip = ((6.0 / filter[0].max(filter[1].sqrt()) / data.step_s) as usize).min(run.len() / 4);
        for k in skip..run.len() {
            let row = [-y[k][1], -y[k][0], u[k][0], 1.0];
            let instrument = match &z {
                Some(z) => [-z[k][1], -z[k][0], u[k][0], 1.0],
                None => row,
            };
            for i in 0..UNKNOWNS {
                right[i] += instrument[i] * y[k][2];
                for j in 0..UNKNOWNS {
                    cross[i][j] += instrument[i] * row[j];
                }
            }
        }
    }
    // The normal equations of the instrumental system: small, and symmetric once squared.
    let scale: Vec<f64> = (0..UNKNOWNS).map(|i| cross[i][i].abs().sqrt().max(f64::MIN_POSITIVE)).collect();
    let mut square = Symmetric::zero(UNKNOWNS);
    let mut target = vec![0.0; UNKNOWNS];
    for i in 0..UNKNOWNS {
        for j in 0..UNKNOWNS {
            *square.at_mut(i, j) = (0..UNKNOWNS)
                .map(|k| cross[k][i] * cross[k][j] / (scale[k] * scale[k] * scale[i] * scale[j]))
                .sum();
        }
        target[i] = (0..UNKNOWNS).map(|k| cross[k][i] * right[k] / (scale[k] * scale[k] * scale[i])).sum();
    }
    let x = square.factor().solve(&target);
    let plant = [x[0] / scale[0], x[1] / scale[1], x[2] / scale[2]];
    plant.iter().all(|v| v.is_finite()).then_some(plant)
}
