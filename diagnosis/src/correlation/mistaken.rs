//! What looks like correlated noise and is none: a step, a seat that differs from pass to pass, a sway, the
//! trace of an earlier move. Left in, it would be taken for correlation, and the noise would then hide it.

use numerics::{Basis, Columns, add_scaled, cholesky, dot, parallel};

use super::{Correlation, Process, Whitener, orthonormal};
use crate::jumps::{Jumps, step};
use crate::thresholds::correlation::COARSE;
use crate::thresholds::correlation::mistaken::{
    CORRELATION_SEEN, FEW_COLUMNS, FIRST_STEP, MOST_TAKEN, NEARLY, SLOW_GAIN, SLOW_GAIN_PER_COLUMN,
};
use crate::thresholds::dictionary::SMALLEST_PART;

impl Correlation {
    /// The groups of `suspects` (each a number of columns) that explain the observations so much better than
    /// correlation alone can that they are no noise; wherever there are suspects a step from any row k on is one
    /// more, numbered `suspects.len() + k` (see [`suspect`]). None where no correlation is seen: nothing is then
    /// taken for it.
    pub fn mistaken(
        &self,
        clean: &[f64],
        model: &[Vec<f64>],
        shape: &[f64],
        suspects: &[Vec<Vec<f64>>],
    ) -> Vec<usize> {
        if suspects.is_empty() {
            return Vec::new();
        }
        let n = clean.len();
        let columns = orthonormal(model, shape);
        // Per process: basis, residual, and what does not depend on the suspects of −2 log likelihood
        // of the observations' part outside the model.
        let forgotten = self.forgotten().into_iter().step_by(COARSE);
        let mut places = self.places(forgotten, &columns, clean, shape);
        let freedom = (n - columns.count()).max(1) as f64;
        let deviance = |place: &Place, rss: f64| place.deviance(rss, freedom);
        let now = |place: &Place| deviance(place, dot(&place.residual, &place.residual));
        let best = places.iter().map(now).fold(f64::INFINITY, f64::min);
        if now(&places[0]) - best < CORRELATION_SEEN {
            return Vec::new();
        }
        let of_a_step = SLOW_GAIN + 2.0 * (n as f64 / FEW_COLUMNS).ln().max(0.0);
        let mut taken = Vec::new();
        while taken.len() < MOST_TAKEN {
            let before = places.iter().map(now).fold(f64::INFINITY, f64::min);
            // Gain of every group over what is asked of it, with the process that suits it best.
            let gains: Vec<Vec<f64>> = parallel::map(&places, |place| {
                let rss = dot(&place.residual, &place.residual);
                let of_groups = place.explained_by(suspects).into_iter().zip(suspects);
                let of_groups = of_groups.map(|(explained, group)| {
                    (explained, SLOW_GAIN + SLOW_GAIN_PER_COLUMN * (group.len() as f64 - 1.0))
                });
                let of_steps = place.explained_by_steps().into_iter().map(|explained| (explained, of_a_step));
                of_groups
                    .chain(of_steps)
                    .map(|(explained, asked)| before - deviance(place, rss - explained) - asked)
                    .collect()
            });
            let open: Vec<(usize, f64)> = (0..suspects.len() + n)
                .filter(|k| !taken.contains(k))
                .map(|k| (k, gains.iter().map(|g| g[k]).fold(f64::NEG_INFINITY, f64::max)))
                .collect();
            // The simplest of those that gain nearly as much as the best: offsets of all passes hold every step
            // between two of them.
            let enough = NEARLY * open.iter().map(|o| o.1).fold(0.0, f64::max);
            let width = |k: usize| suspects.get(k).map_or(1, Vec::len);
            let next = open
                .into_iter()
                .filter(|(_, gain)| *gain > 0.0 && *gain >= enough)
                .min_by(|a, b| width(a.0).cmp(&width(b.0)).then(b.1.total_cmp(&a.1)));
            let Some((k, _)) = next else { break };
            taken.push(k);
            let group = suspect(suspects, k, n);
            places.iter_mut().for_each(|place| place.take(&group));
        }
        taken
    }
}

impl Correlation {
    /// How much more likely (in −2 log likelihood) `added` columns beside the model's make the observations, noise being
    /// whatever suits either best: what noise that lasts explains as well gains nothing.
    pub fn gain(&self, clean: &[f64], model: &[Vec<f64>], shape: &[f64], added: &[Vec<f64>]) -> f64 {
        let columns = orthonormal(model, shape);
        let freedom = clean.len().saturating_sub(columns.count()).max(1) as f64;
        let both = |place: &Place| {
            let rss = dot(&place.residual, &place.residual);
            let explained = place.explained_by(&[added.to_vec()])[0];
            [rss, rss - explained].map(|rss| place.deviance(rss, freedom))
        };
        let least = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].min(b[1])];
        let [without, with] = self
            .places(self.tried(), &columns, clean, shape)
            .iter()
            .map(both)
            .fold([f64::INFINITY; 2], least);
        without - with
    }

    /// The process under which the observations are likeliest beside the model's columns, and by how much it is likelier than
    /// this one, in −2 log likelihood.
    pub fn likeliest(&self, clean: &[f64], model: &[Vec<f64>], shape: &[f64]) -> (Process, f64) {
        let columns = orthonormal(model, shape);
        let freedom = clean.len().saturating_sub(columns.count()).max(1) as f64;
        let deviance = |process: &Process| {
            let place = Place::new(self.with(process), &columns, clean, shape);
            place.deviance(dot(&place.residual, &place.residual), freedom)
        };
        let own = deviance(self.process());
        let tried: Vec<Process> = self.tried().collect();
        let deviances = parallel::map(&tried, deviance);
        let least = deviances.into_iter().zip(tried).min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((least, process)) if least < own => (process, own - least),
            _ => (self.process().clone(), 0.0),
        }
    }

    /// The processes that are tried.
    fn tried(&self) -> impl Iterator<Item = Process> {
        self.forgotten().into_iter().chain(self.lasting()).step_by(COARSE)
    }

    /// The recording seen as white, and with every one of the processes.
    fn places(
        &self,
        processes: impl Iterator<Item = Process>,
        columns: &Columns,
        clean: &[f64],
        shape: &[f64],
    ) -> Vec<Place> {
        let processes: Vec<Process> = std::iter::once(Process::white()).chain(processes).collect();
        parallel::map(&processes, |process| Place::new(self.with(process), columns, clean, shape))
    }
}

/// The columns of the suspect `k` among `n` rows: one of the groups, or beyond them a step.
pub fn suspect(groups: &[Vec<Vec<f64>>], k: usize, n: usize) -> Vec<Vec<f64>> {
    groups.get(k).cloned().unwrap_or_else(|| vec![step(n, k - groups.len())])
}

/// A recording seen with one process of noise.
struct Place {
    whitener: Whitener,
    basis: Basis,
    residual: Vec<f64>,
    constant: f64,
}

impl Place {
    /// −2 log likelihood where so much is left.
    fn deviance(&self, rss: f64, freedom: f64) -> f64 {
        self.constant + freedom * rss.max(1e-300).ln()
    }

    fn new(correlation: Correlation, columns: &Columns, clean: &[f64], shape: &[f64]) -> Place {
        let white = correlation.whitened(columns);
        let (factor, log_determinant) = cholesky(&white.products(&white), columns.count());
        let basis = Basis { columns: white.orthonormal(&factor) };
        let mut residual = correlation.whiten(clean.iter().zip(shape).map(|(v, s)| v / s));
        basis.project_off(&mut residual);
        let constant = correlation.log_determinant() + log_determinant;
        Place { whitener: correlation.whitener(shape), basis, residual, constant }
    }

    /// What each group of columns explains of the residual r beside the basis Q. Whitened columns wᵢ have there
    /// the Gram matrix wᵢ·wⱼ − (Qᵀwᵢ)·(Qᵀwⱼ), and what they explain follows from its Cholesky factor: all the
    /// products with Q at once, and nothing projected row by row.
    fn explained_by(&self, groups: &[Vec<Vec<f64>>]) -> Vec<f64> {
        let mut white = Columns::new(self.residual.len());
        self.whitener.whiten_onto(groups.iter().flatten().map(Vec::as_slice), &mut white);
        let mut beside = self.basis.columns.clone();
        beside.push(&self.residual);
        let (count, rank) = (white.count(), self.basis.rank());
        let products = white.products(&beside);
        let gram = |i: usize, j: usize| -> f64 {
            let inside: f64 = (0..rank).map(|b| products[b * count + i] * products[b * count + j]).sum();
            dot(white.get(i), white.get(j)) - inside
        };
        let mut first = 0;
        groups
            .iter()
            .map(|group| {
                let own = first..first + group.len();
                first = own.end;
                // Rows of the factor, each with its column and its part of the residual.
                let mut factor: Vec<(usize, Vec<f64>, f64)> = Vec::with_capacity(group.len());
                for k in own {
                    let mut row: Vec<f64> = Vec::with_capacity(factor.len() + 1);
                    for (column, above, _) in &factor {
                        let value = gram(k, *column) - dot(&above[..row.len()], &row);
                        row.push(value / above[row.len()]);
                    }
                    let left = gram(k, k) - dot(&row, &row);
                    let length = dot(white.get(k), white.get(k));
                    if left > SMALLEST_PART * SMALLEST_PART * length {
                        let along: f64 = factor.iter().zip(&row).map(|((_, _, part), r)| part * r).sum();
                        let part = (products[rank * count + k] - along) / left.sqrt();
                        row.push(left.sqrt());
                        factor.push((k, row, part));
                    }
                }
                factor.iter().map(|(_, _, part)| part * part).sum()
            })
            .collect()
    }

    /// What the step from every row on explains of the residual.
    fn explained_by_steps(&self) -> Vec<f64> {
        let n = self.residual.len();
        let rows = FIRST_STEP..n.saturating_sub(1);
        let scores = Jumps::beside(&self.whitener, &self.basis, rows, SMALLEST_PART).scores(&self.residual);
        scores.into_iter().map(|s| s * s).collect()
    }

    /// Takes a group of columns out of the residual.
    fn take(&mut self, group: &[Vec<f64>]) {
        for column in group {
            let rank = self.basis.rank();
            let white = self.whitener.whiten(column);
            if self.basis.add(&white) {
                let q = self.basis.columns.get(rank);
                let a = dot(q, &self.residual);
                add_scaled(&mut self.residual, -a, q);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::white;
    use super::{Correlation, Process, step};

    #[test]
    fn a_step_is_not_taken_for_correlation() {
        let n = 210;
        let none = Correlation::none(&(0..n).map(|i| 3.0 * i as f64).collect::<Vec<f64>>());
        let model = vec![vec![1.0; n]];
        let shape = vec![1.0; n];
        // A wave; the steps come of themselves.
        let suspects = [vec![(0..n).map(|i| (0.2 * i as f64).sin()).collect::<Vec<f64>>()]];
        for time in [1e-3, 2.3] {
            let noise = none.with(&Process::slow(1.0, time)).colour(white(n, 9).into_iter());
            assert!(none.mistaken(&noise, &model, &shape, &suspects).is_empty());
            let stepped: Vec<f64> = noise.iter().zip(step(n, 101)).map(|(e, s)| e + 5.0 * s).collect();
            let taken = none.mistaken(&stepped, &model, &shape, &suspects);
            assert_eq!(taken, [suspects.len() + 101]);
        }
    }

    #[test]
    fn a_sway_is_no_correlation_and_a_step_between_passes_no_offset_of_them() {
        let n = 210;
        let none = Correlation::none(&(0..n).map(|i| 3.0 * i as f64).collect::<Vec<f64>>());
        let (model, shape) = (vec![vec![1.0; n]], vec![1.0; n]);
        let wave = |periods: f64| {
            let phase = move |i: usize| std::f64::consts::TAU * periods * i as f64 / n as f64;
            vec![
                (0..n).map(|i| phase(i).sin()).collect(),
                (0..n).map(|i| phase(i).cos()).collect::<Vec<f64>>(),
            ]
        };
        let mut suspects: Vec<_> = (4..40).map(|k| wave(0.5 * f64::from(k))).collect();
        let step = step(n, 120);
        let pass = |p: usize| (0..n).map(|i| if i / 30 == p { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        suspects.push((1..7).map(pass).collect());
        let noise = none.with(&Process::slow(1.0, 1.0)).colour(white(n, 11).into_iter());
        let with = |what: &[f64], size: f64| -> Vec<f64> {
            noise.iter().zip(what).map(|(e, w)| e + size * w).collect()
        };
        assert!(none.mistaken(&noise, &model, &shape, &suspects).is_empty());
        // Nine periods are the fifteenth of the waves; the steps follow on the offsets of passes.
        let swayed = none.mistaken(&with(&wave(9.0)[0], 1.5), &model, &shape, &suspects);
        assert_eq!(swayed.first(), Some(&14));
        let stepped = none.mistaken(&with(&step, 3.0), &model, &shape, &suspects);
        assert_eq!(stepped.first(), Some(&(suspects.len() + 120)));
    }
}
