//! The 95 % interval of every reported parameter, from the posterior of its effect's shape rather than from
//! the curvature at the best fit: a threshold or a time constant is seldom determined evenly to both sides,
//! and two far places may do nearly as well.
//!
//! Beside the base, the other effects and the tangents of their shapes, every shape of the effect has its
//! profile likelihood exp(S/2), S the whitened sum of squares that it explains, and given the shape the
//! amplitudes are normal. A parameter's interval is the central 95 % of that mixture, the shapes weighted
//! evenly over their range (Cox & Hinkley, Theoretical Statistics, 1974, sections 9.3 and 10.5). That the
//! noise level is itself an estimate widens everything by the ratio of Student's quantile to the normal one.

use crate::averaging::Rival;
use crate::effects::{Effect, Reading};
use crate::linear::{Basis, add_scaled, dot};
use crate::mixture::{Part, quantile};
use crate::noise::Noise;
use crate::rows::Rows;

/// Standard normal quantile of 97.5 %.
const NORMAL: f64 = 1.959_963_985;
/// Places over the whole range of a single shape parameter at which its likelihood is looked at.
const COARSE: usize = 48;
/// Standard deviations about the best fit that are covered evenly, and places per standard deviation.
const REACH: f64 = 5.0;
const FINE: f64 = 3.0;
/// Places along each axis where there are two shape parameters.
const SQUARE: i32 = 8;
/// Fall of the log likelihood below the largest at which nothing more is expected.
const NEGLIGIBLE: f64 = 9.0;
/// Change of the log likelihood between neighbouring places above which one is put between them.
const UNEVEN: f64 = 0.7;
/// Rows about a step's best place whose likelihood is looked at.
const STEP_REACH: usize = 60;
/// Part of a column's length that must be left beside the others for its amplitude to mean anything.
const DETERMINED: f64 = 1e-5;

/// What an effect's shapes are judged beside.
pub struct Beside<'a> {
    /// The recording.
    pub rows: &'a Rows,
    /// Its noise.
    pub noise: &'a Noise,
    /// Whitened base, other effects and their tangents.
    pub basis: Basis,
    /// Whitened observations less their part in the basis.
    pub residual: Vec<f64>,
    /// Ratio of Student's quantile to the normal one.
    pub widening: f64,
    /// What the observations as they were read leave without the effect, for a step; else empty.
    pub left: &'a [f64],
}

/// One shape with what follows from it.
struct Place {
    shape: Vec<f64>,
    log_likelihood: f64,
    weight: f64,
    amplitudes: Vec<f64>,
    /// Of the amplitudes, by rows.
    covariance: Vec<f64>,
}

impl Beside<'_> {
    /// The amplitudes and the likelihood of a shape; none where nothing of it is left or it is implausible.
    fn place(&self, effect: &dyn Effect, shape: &[f64]) -> Option<Place> {
        let columns = effect.signature(self.rows, shape);
        let width = columns.len();
        let mut q: Vec<Vec<f64>> = Vec::with_capacity(width);
        // Upper triangle R of the columns' factorisation, by rows.
        let mut r = vec![0.0; width * width];
        for (k, column) in columns.iter().enumerate() {
            let mut w = self.noise.whiten(column);
            let length = dot(&w, &w).sqrt();
            self.basis.project_off(&mut w);
            if dot(&w, &w).sqrt() < 0.1 * length {
                self.basis.project_off(&mut w);
            }
            for (j, other) in q.iter().enumerate() {
                let a = dot(other, &w);
                r[j * width + k] = a;
                add_scaled(&mut w, -a, other);
            }
            let left = dot(&w, &w).sqrt();
            if left.is_nan() || left <= DETERMINED * length {
                return None;
            }
            r[k * width + k] = left;
            w.iter_mut().for_each(|v| *v /= left);
            q.push(w);
        }
        let scores: Vec<f64> = q.iter().map(|q| dot(q, &self.residual)).collect();
        let inverse = inverse_of_triangle(&r, width);
        let amplitudes: Vec<f64> =
            (0..width).map(|a| (a..width).map(|k| inverse[a * width + k] * scores[k]).sum()).collect();
        if !effect.plausible_at(shape, &amplitudes) {
            return None;
        }
        let covariance = (0..width * width)
            .map(|i| {
                let (a, b) = (i / width, i % width);
                (a.max(b)..width).map(|k| inverse[a * width + k] * inverse[b * width + k]).sum()
            })
            .collect();
        let log_likelihood = 0.5 * dot(&scores, &scores) / (self.widening * self.widening);
        Some(Place { shape: shape.to_vec(), log_likelihood, weight: 1.0, amplitudes, covariance })
    }

    /// The posterior of an effect's shape about `best`; `deviation` is the standard deviation of each shape
    /// parameter as the curvature has it.
    fn posterior(&self, effect: &dyn Effect, best: &[f64], deviation: &[f64]) -> Vec<Place> {
        let ranges = effect.ranges(self.rows);
        let tied = effect.shape_follows();
        let free: Vec<usize> = (0..best.len())
            .filter(|&k| !tied && !ranges[k].whole && ranges[k].high > ranges[k].low)
            .collect();
        // Coordinates in which the shapes are spread evenly.
        let to = |k: usize, v: f64| if ranges[k].logarithmic { v.ln() } else { v };
        let from = |k: usize, u: f64| if ranges[k].logarithmic { u.exp() } else { u };
        let limits = |k: usize| (to(k, ranges[k].low), to(k, ranges[k].high));
        let spread = |k: usize| {
            let per = if ranges[k].logarithmic { best[k].abs().max(1e-300) } else { 1.0 };
            let (low, high) = limits(k);
            let d = deviation[k] / per;
            if d.is_finite() && d > 0.0 { d.min(0.2 * (high - low)) } else { 0.02 * (high - low) }
        };
        match free.as_slice() {
            [k] => {
                let k = *k;
                let (low, high) = limits(k);
                let (centre, d) = (to(k, best[k]), spread(k));
                let mut at: Vec<f64> =
                    (0..=COARSE).map(|i| low + (high - low) * i as f64 / COARSE as f64).collect();
                let near = (REACH * FINE) as i32;
                at.extend((-near..=near).map(|i| centre + d * f64::from(i) / FINE));
                at.retain(|u| (low..=high).contains(u));
                at.sort_by(f64::total_cmp);
                at.dedup();
                let with = |u: f64| {
                    let mut shape = best.to_vec();
                    shape[k] = from(k, u);
                    shape
                };
                self.along(effect, at, with)
            }
            [i, k] => {
                let (i, k) = (*i, *k);
                let mut places = Vec::new();
                for a in -SQUARE..=SQUARE {
                    for b in -SQUARE..=SQUARE {
                        let mut shape = best.to_vec();
                        for (k, part) in [(i, a), (k, b)] {
                            let u = to(k, best[k]) + REACH * spread(k) * f64::from(part) / f64::from(SQUARE);
                            let (low, high) = limits(k);
                            if !(low..=high).contains(&u) {
                                shape.clear();
                                break;
                            }
                            shape[k] = from(k, u);
                        }
                        if !shape.is_empty() {
                            places.extend(self.place(effect, &shape));
                        }
                    }
                }
                places
            }
            _ => self.place(effect, best).into_iter().collect(),
        }
    }

    /// Places along one coordinate, more of them where the likelihood changes, weighted by their distances.
    fn along(&self, effect: &dyn Effect, at: Vec<f64>, with: impl Fn(f64) -> Vec<f64>) -> Vec<Place> {
        let mut line: Vec<(f64, Option<Place>)> =
            at.into_iter().map(|u| (u, self.place(effect, &with(u)))).collect();
        let log_of = |p: &Option<Place>| p.as_ref().map_or(f64::NEG_INFINITY, |p| p.log_likelihood);
        for _ in 0..4 {
            let top = line.iter().map(|(_, p)| log_of(p)).fold(f64::NEG_INFINITY, f64::max);
            let mut finer: Vec<(f64, Option<Place>)> = Vec::with_capacity(2 * line.len());
            let mut added = false;
            for (u, place) in line {
                if let Some((before, last)) = finer.last() {
                    let (a, b) = (log_of(last), log_of(&place));
                    let split = a.max(b) > top - NEGLIGIBLE && (a - b).abs() >= UNEVEN;
                    if split {
                        let middle = 0.5 * (before + u);
                        finer.push((middle, self.place(effect, &with(middle))));
                        added = true;
                    }
                }
                finer.push((u, place));
            }
            line = finer;
            if !added {
                break;
            }
        }
        let at: Vec<f64> = line.iter().map(|(u, _)| *u).collect();
        let last = at.len().saturating_sub(1);
        line.into_iter()
            .enumerate()
            .filter_map(|(i, (_, place))| {
                let width = 0.5 * (at[(i + 1).min(last)] - at[i.saturating_sub(1)]);
                place.map(|p| Place { weight: width, ..p })
            })
            .collect()
    }

    /// The posterior of the row at which a step begins, each gap between rows weighted by its length.
    fn step_places(&self, effect: &dyn Effect, best: &[f64]) -> Vec<Place> {
        let t = &self.rows.t_s;
        let centre = best[0] as usize;
        let near = match self.place(effect, best) {
            Some(place) if !self.left.is_empty() => {
                crate::steps::places(self.left, self.noise, place.amplitudes[0], centre)
            }
            _ => Vec::new(),
        };
        if !near.is_empty() {
            // A high step: single rows decide, as they were read.
            let at = |(k, log_likelihood): (usize, f64)| {
                let weight = (t[k] - t[k - 1]).max(1e-9);
                self.place(effect, &[k as f64]).map(|p| Place { weight, log_likelihood, ..p })
            };
            return near.into_iter().filter_map(at).collect();
        }
        let (from, to) = (centre.saturating_sub(STEP_REACH).max(1), (centre + STEP_REACH).min(t.len() - 1));
        (from..=to)
            .filter_map(|k| {
                let weight = (t[k] - t[k - 1]).max(1e-9);
                self.place(effect, &[k as f64]).map(|p| Place { weight, ..p })
            })
            .collect()
    }

    /// The same with columns more beside it.
    fn with(&self, columns: &[Vec<f64>]) -> Beside<'_> {
        let mut basis = self.basis.clone();
        let mut residual = self.residual.clone();
        for column in columns {
            let rank = basis.rank();
            basis.add(column);
            if basis.rank() > rank {
                let q = basis.columns.get(rank);
                let a = dot(q, &residual);
                add_scaled(&mut residual, -a, q);
            }
        }
        Beside { basis, residual, ..*self }
    }

    /// The places that matter for a fitted effect, with weights that sum to one.
    fn weighed(&self, effect: &dyn Effect, shape: &[f64], deviation: &[f64]) -> Vec<Place> {
        let step = effect.id() == "mount_step";
        let mut places =
            if step { self.step_places(effect, shape) } else { self.posterior(effect, shape, deviation) };
        let top = places.iter().map(|p| p.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
        places.retain(|p| p.log_likelihood > top - NEGLIGIBLE);
        places.iter_mut().for_each(|p| p.weight *= (p.log_likelihood - top).exp());
        let total: f64 = places.iter().map(|p| p.weight).sum();
        places.iter_mut().for_each(|p| p.weight /= total);
        places
    }

    /// The parameters of a fitted effect with their intervals, averaged over the model and those with one of
    /// `rivals` more.
    pub fn parameters(
        &self,
        effect: &dyn Effect,
        shape: &[f64],
        amplitudes: &[f64],
        deviation: &[f64],
        rivals: &[Rival],
    ) -> Vec<(Reading, [f64; 2])> {
        let own = self.weighed(effect, shape, deviation);
        let readings = effect.readings(self.rows, shape, amplitudes);
        let mut mixtures: Vec<Vec<Part>> = vec![Vec::with_capacity(own.len()); readings.len()];
        let total = 1.0 + rivals.iter().map(|r| r.weight).sum::<f64>();
        let mut add = |beside: &Beside, places: &[Place], weight: f64| {
            for place in places {
                for (mixture, (value, deviation)) in mixtures.iter_mut().zip(beside.read(effect, place)) {
                    mixture.push(Part { weight: place.weight * weight / total, value, deviation });
                }
            }
        };
        add(self, &own, 1.0);
        for rival in rivals {
            let beside = self.with(&rival.columns);
            add(&beside, &beside.weighed(effect, shape, deviation), rival.weight);
        }
        readings
            .into_iter()
            .zip(&mut mixtures)
            .map(|(reading, mixture)| {
                let sum: f64 = mixture.iter().map(|p| p.weight).sum();
                mixture.iter_mut().for_each(|p| p.weight /= sum);
                let interval = if effect.id() == "mount_step" && reading.name == "time_s" {
                    self.step_time(&own)
                } else {
                    [quantile(mixture, 0.025), quantile(mixture, 0.975)]
                };
                // Where no shape could be judged nothing is known.
                let known = !mixture.is_empty() && interval.iter().all(|v| v.is_finite());
                (reading, if known { interval } else { [f64::MIN, f64::MAX] })
            })
            .collect()
    }

    /// Every reported parameter at a place, with the deviation that the amplitudes give it.
    fn read(&self, effect: &dyn Effect, place: &Place) -> Vec<(f64, f64)> {
        let width = place.amplitudes.len();
        let here = effect.readings(self.rows, &place.shape, &place.amplitudes);
        let mut gradients = vec![vec![0.0; width]; here.len()];
        for k in 0..width {
            // A difference over a tenth of a deviation: no reading bends within it.
            let h = 0.1 * place.covariance[k * width + k].sqrt();
            let mut moved = place.amplitudes.clone();
            moved[k] += h;
            for (g, (m, v)) in
                gradients.iter_mut().zip(effect.readings(self.rows, &place.shape, &moved).iter().zip(&here))
            {
                g[k] = (m.value - v.value) / h;
            }
        }
        here.iter()
            .zip(gradients)
            .map(|(reading, g)| {
                let variance: f64 =
                    (0..width * width).map(|i| g[i / width] * place.covariance[i] * g[i % width]).sum();
                (reading.value, self.widening * variance.max(0.0).sqrt())
            })
            .collect()
    }

    /// The central 95 % of a step's time: even over the gap between two rows.
    fn step_time(&self, places: &[Place]) -> [f64; 2] {
        let t = &self.rows.t_s;
        [0.025, 0.975].map(|part| {
            let mut left = part;
            for place in places {
                let k = place.shape[0] as usize;
                if left <= place.weight {
                    return t[k - 1] + (t[k] - t[k - 1]) * left / place.weight;
                }
                left -= place.weight;
            }
            places.last().map_or(f64::NAN, |p| t[p.shape[0] as usize])
        })
    }
}

/// Inverse of an upper triangular matrix, by rows.
fn inverse_of_triangle(r: &[f64], n: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; n * n];
    for k in 0..n {
        inverse[k * n + k] = 1.0 / r[k * n + k];
        for j in (0..k).rev() {
            let sum: f64 = (j + 1..=k).map(|i| r[j * n + i] * inverse[i * n + k]).sum();
            inverse[j * n + k] = -sum / r[j * n + j];
        }
    }
    inverse
}

/// Ratio of Student's 97.5 % quantile at `freedom` degrees to the normal one.
pub fn widening(freedom: f64) -> f64 {
    use statrs::distribution::{ContinuousCDF, StudentsT};
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(1.0, |t| t.inverse_cdf(0.975) / NORMAL)
}

#[cfg(test)]
mod tests {
    use super::{NORMAL, widening};

    #[test]
    fn few_degrees_of_freedom_widen() {
        // Student's quantile at 10 degrees is 2.2281.
        assert!((widening(10.0) - 2.2281 / NORMAL).abs() < 1e-4);
        assert!((widening(1e6) - 1.0).abs() < 1e-4);
    }
}
