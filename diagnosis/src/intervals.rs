//! The 95 % interval of every reported parameter, from the posterior of its effect's shape rather than from
//! the curvature at the best fit: a threshold or a time constant is rarely determined evenly to both sides,
//! and two far places may do nearly as well.
//!
//! Beside the base, the other effects and the tangents of their shapes, every shape of the effect has its
//! profile likelihood exp(S/2), S the whitened sum of squares that it explains, and given the shape the
//! amplitudes are normal. A parameter's interval is the central 95 % of that mixture, the shapes weighted
//! evenly over their range (Cox & Hinkley, Theoretical Statistics, 1974, sections 9.3 and 10.5). That the
//! noise level is itself an estimate widens everything by the ratio of Student's quantile to the normal one.

use numerics::{Basis, add_scaled, dot, of_triangle, parallel, student_95};

use crate::averaging::Rival;
use crate::correlation::Whitener;
use crate::effects::{CommonMode, Effect, Over, Range, Reading};
use crate::mixture::{Part, quantile};
use crate::noise::Noise;
use crate::rows::Rows;
use crate::thresholds::NORMAL_95;
use crate::thresholds::intervals::{
    CENTRAL, DETERMINED, DIVISIONS, HIDDEN, LEAST_OWN, MOST_DIVIDED, MOST_SEARCHED, NEARLY, NEGLIGIBLE,
    PARTS, PARTS_OF_MANY, STEP_REACH, UNEVEN,
};

/// Ratio of Student's 97.5 % quantile at `freedom` degrees to the normal one.
pub fn widening(freedom: f64) -> f64 {
    student_95(freedom) / NORMAL_95
}

/// What an effect's shapes are judged beside.
pub struct Beside<'a> {
    /// The recording.
    pub rows: &'a Rows,
    /// Its noise.
    pub noise: &'a Noise,
    /// What makes it white.
    pub whitener: &'a Whitener,
    /// Whitened base, other effects and their tangents.
    pub basis: Basis,
    /// Whitened observations less their part in the basis.
    pub residual: Vec<f64>,
    /// Ratio of Student's quantile to the normal one.
    pub widening: f64,
    /// [`Rows::scatter_of_places`].
    pub scatter_of_places: f64,
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
    fn place(&self, effect: &Over, shape: &[f64]) -> Option<Place> {
        let columns = effect.signature(shape);
        let width = columns.len();
        let mut q: Vec<Vec<f64>> = Vec::with_capacity(width);
        // Upper triangle R of the columns' factorisation, by rows.
        let mut r = vec![0.0; width * width];
        for (k, column) in columns.iter().enumerate() {
            let mut w = self.whitener.whiten(column);
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
        let (amplitudes, mut covariance) = of_triangle(&r, &scores);
        if effect.common_mode == CommonMode::Alone {
            let noise = self.noise_of_common_mode(&self.whitener.whiten(&columns[0]));
            let unknown_part = noise * columns[0].len() as f64 / (r[0] * r[0]);
            covariance[0] += (unknown_part * amplitudes[0]).powi(2);
        }
        if !effect.plausible_at(self.rows, shape, &amplitudes) {
            return None;
        }
        let log_likelihood = 0.5 * dot(&scores, &scores) / (self.widening * self.widening);
        Some(Place { shape: shape.to_vec(), log_likelihood, weight: 1.0, amplitudes, covariance })
    }

    /// Mean square of what a whitened common mode holds of the probes' noise: it scatters from row to row, and is no
    /// more than the noise of the angle, were all of it the probes', makes it. Noise in a column brings its amplitude
    /// nearer to zero by its part of the column's squares (Fuller, Measurement Error Models, 1987, section 1.1).
    fn noise_of_common_mode(&self, whitened: &[f64]) -> f64 {
        let steps = whitened.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
        let scatter = 0.5 * steps / (whitened.len() - 1).max(1) as f64;
        scatter.min(self.rows.common_mode_noise_um().powi(2))
    }

    /// The posterior of an effect's shape over everything that it can be: the whole range of its shape parameters is
    /// divided into cells, and those that may matter again and again, so that no place far from `best` that does nearly
    /// as well is missed, however narrow it is.
    fn posterior(&self, effect: &Over, best: &[f64]) -> Vec<Place> {
        let ranges = effect.ranges(self.rows);
        let tied = effect.shape_follows;
        let free: Vec<usize> = (0..best.len())
            .filter(|&k| !tied && !ranges[k].whole && ranges[k].high > ranges[k].low)
            .collect();
        let best_place = self.place(effect, best);
        if free.is_empty() {
            return best_place.into_iter().collect();
        }
        // Coordinates in which the shapes are spread evenly.
        let to = |k: usize, v: f64| if ranges[k].logarithmic { v.ln() } else { v };
        let at = |middle: &[f64]| {
            let mut shape = best.to_vec();
            for (k, u) in free.iter().zip(middle) {
                shape[*k] = if ranges[*k].logarithmic { u.exp() } else { *u };
            }
            effect.possible_shape(&shape).then(|| self.place(effect, &shape)).flatten()
        };
        let log_of = |p: &Option<Place>| p.as_ref().map_or(f64::NEG_INFINITY, |p| p.log_likelihood);
        let home: Vec<f64> = free.iter().map(|k| to(*k, best[*k])).collect();
        let mut top = log_of(&best_place);
        let placed = |cells: Vec<Cell>| -> Vec<(Cell, Option<Place>)> {
            let places = parallel::map(&cells, |cell| at(&cell.middle));
            cells.into_iter().zip(places).collect()
        };
        let mut open = placed(first_cells(self.rows, &free, &ranges, effect, best));
        let mut places = Vec::new();
        for division in 0..=DIVISIONS {
            top = open.iter().map(|(_, p)| log_of(p)).fold(top, f64::max);
            if top == f64::NEG_INFINITY {
                return Vec::new();
            }
            let hidden = HIDDEN * top * 0.25_f64.powi(division);
            open.retain(|(cell, place)| log_of(place) >= top - NEGLIGIBLE - hidden || cell.holds(&home));
            let most = if hidden < NEGLIGIBLE { MOST_DIVIDED } else { MOST_SEARCHED };
            if open.len() > most {
                // Where the likelihood jumps, the cells on the jump double with every division, and each holds less.
                let held = |(cell, place): &(Cell, Option<Place>)| cell.size() * (log_of(place) - top).exp();
                open.sort_by(|a, b| held(b).total_cmp(&held(a)));
                places.extend(open.drain(most..).filter_map(|(cell, place)| place_of_cell(&cell, place)));
            }
            let count = 1 << free.len();
            let parts = placed(open.drain(..).flat_map(|(cell, _)| cell.halves()).collect());
            let mut parts = parts.into_iter().peekable();
            while parts.peek().is_some() {
                let halves: Vec<(Cell, Option<Place>)> = parts.by_ref().take(count).collect();
                let logs = || halves.iter().map(|(_, p)| log_of(p));
                let change = logs().fold(f64::NEG_INFINITY, f64::max) - logs().fold(f64::INFINITY, f64::min);
                if change < UNEVEN || division == DIVISIONS {
                    places.extend(halves.into_iter().filter_map(|(cell, place)| place_of_cell(&cell, place)));
                } else {
                    open.extend(halves);
                }
            }
        }
        places
    }

    /// The posterior of the row at which a step begins, each gap between rows weighted by its length.
    fn step_places(&self, effect: &Over, best: &[f64]) -> Vec<Place> {
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
    fn weighed(&self, effect: &Effect, shape: &[f64]) -> Vec<Place> {
        let (step, over) = (effect.begins_at_a_row, effect.over(self.rows));
        let mut places = if step { self.step_places(&over, shape) } else { self.posterior(&over, shape) };
        let top = places.iter().map(|p| p.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
        places.retain(|p| p.log_likelihood > top - NEGLIGIBLE);
        places.iter_mut().for_each(|p| p.weight *= (p.log_likelihood - top).exp());
        let total: f64 = places.iter().map(|p| p.weight).sum();
        places.iter_mut().for_each(|p| p.weight /= total);
        places
    }

    /// A better shape where `shape` lies outside the central part of what the recording allows: the middle of that, which says
    /// least that is wrong of other recordings where the likeliest shape is the far end of a range in which nothing was read,
    /// such as a threshold between two temperatures. Where the middle is less likely, the likeliest shape of all.
    pub fn settled(&self, effect: &Effect, shape: &[f64]) -> Option<Vec<f64>> {
        let (places, over) = (self.weighed(effect, shape), effect.over(self.rows));
        let at = |k: usize, part: f64| {
            let on_axis = |p: &Place| Part { weight: p.weight, value: p.shape[k], deviation: 0.0 };
            quantile(&places.iter().map(on_axis).collect::<Vec<Part>>(), part)
        };
        let outside = |k: usize| shape[k] < at(k, CENTRAL[0]) || shape[k] > at(k, CENTRAL[1]);
        if effect.begins_at_a_row || places.is_empty() || !(0..shape.len()).any(outside) {
            return None;
        }
        let here = self.place(&over, shape)?;
        let best = places.iter().max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
        // The part of what it adds that the base and the others cannot make.
        let own = |place: &Place| {
            let mut sum = vec![0.0; self.rows.len()];
            let columns = over.signature(&place.shape);
            place.amplitudes.iter().zip(&columns).for_each(|(a, column)| add_scaled(&mut sum, *a, column));
            let left = (2.0 * place.log_likelihood).sqrt() * self.widening;
            let whitened = self.whitener.whiten(&sum);
            left / dot(&whitened, &whitened).sqrt()
        };
        let likely = |place: &Place| place.log_likelihood > best.log_likelihood - NEARLY;
        let middle: Vec<f64> = (0..shape.len()).map(|k| at(k, 0.5)).collect();
        let middle = over.possible_shape(&middle).then(|| self.place(&over, &middle)).flatten();
        let better = |place: &Place| likely(place) && own(place) > LEAST_OWN;
        match middle.filter(better) {
            Some(middle) => Some(middle.shape),
            None => (!likely(&here) && better(best)).then(|| best.shape.clone()),
        }
    }

    /// The parameters of a fitted effect with their intervals, averaged over the model and those with one of
    /// `rivals` more.
    pub fn parameters(
        &self,
        effect: &Effect,
        shape: &[f64],
        amplitudes: &[f64],
        rivals: &[Rival],
    ) -> Vec<(Reading, [f64; 2])> {
        let own = self.weighed(effect, shape);
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
            add(&beside, &beside.weighed(effect, shape), rival.weight);
        }
        readings
            .into_iter()
            .zip(&mut mixtures)
            .map(|(reading, mixture)| {
                let sum: f64 = mixture.iter().map(|p| p.weight).sum();
                mixture.iter_mut().for_each(|p| p.weight /= sum);
                let interval = if effect.begins_at_a_row && reading.name == "time_s" {
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
    fn read(&self, effect: &Effect, place: &Place) -> Vec<(f64, f64)> {
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
        let mut read: Vec<(f64, f64)> = here
            .iter()
            .zip(gradients)
            .map(|(reading, g)| {
                let variance: f64 =
                    (0..width * width).map(|i| g[i / width] * place.covariance[i] * g[i % width]).sum();
                (reading.value, self.widening * variance.max(0.0).sqrt())
            })
            .collect();
        if let Some(k) = effect.place_of_a_probe {
            // Readings are in degrees where the rows are in arcsec.
            read[k].1 = read[k].1.hypot(self.scatter_of_places / self.rows.per_degree());
        }
        read
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

/// The place in the middle of a cell, where there is one, with the cell's size as its weight.
fn place_of_cell(cell: &Cell, place: Option<Place>) -> Option<Place> {
    Some(Place { weight: cell.size(), ..place? })
}

/// A part of the range of the shape parameters that are free, in coordinates in which they are spread evenly.
struct Cell {
    middle: Vec<f64>,
    half: Vec<f64>,
}

impl Cell {
    fn size(&self) -> f64 {
        self.half.iter().product()
    }

    fn holds(&self, at: &[f64]) -> bool {
        (0..at.len()).all(|k| (at[k] - self.middle[k]).abs() <= self.half[k])
    }

    /// It, cut in two along every axis.
    fn halves(&self) -> Vec<Cell> {
        let half: Vec<f64> = self.half.iter().map(|h| 0.5 * h).collect();
        (0..1 << half.len())
            .map(|corner: usize| {
                let side = |k: usize| if corner >> k & 1 == 1 { half[k] } else { -half[k] };
                let middle = (0..half.len()).map(|k| self.middle[k] + side(k)).collect();
                Cell { middle, half: half.clone() }
            })
            .collect()
    }
}

/// The whole range of the free shape parameters in cells over which a signature stays much the same: the last one
/// first, since how finely the others are divided may depend on it (the place of a bump on its width).
fn first_cells(rows: &Rows, free: &[usize], ranges: &[Range], effect: &Effect, best: &[f64]) -> Vec<Cell> {
    let parts = if free.len() < 3 { PARTS } else { PARTS_OF_MANY };
    let mut cells = vec![(Cell { middle: Vec::new(), half: Vec::new() }, best.to_vec())];
    for &k in free.iter().rev() {
        let Range { low, high, logarithmic, .. } = ranges[k];
        let (from, to) = if logarithmic { (low.ln(), high.ln()) } else { (low, high) };
        cells = cells
            .into_iter()
            .flat_map(|(cell, shape)| {
                let spacing = effect.spacing(rows, k, &shape).unwrap_or((to - from) / parts);
                let count = ((to - from) / spacing).ceil().max(1.0);
                let half = 0.5 * (to - from) / count;
                (0..count as usize).map(move |i| {
                    let middle = from + half * (2 * i + 1) as f64;
                    let mut shape = shape.clone();
                    shape[k] = if logarithmic { middle.exp() } else { middle };
                    let longer = |first: f64, rest: &[f64]| {
                        let mut all = vec![first];
                        all.extend_from_slice(rest);
                        all
                    };
                    let cell = Cell { middle: longer(middle, &cell.middle), half: longer(half, &cell.half) };
                    (cell, shape)
                })
            })
            .collect();
    }
    cells.into_iter().map(|(cell, _)| cell).collect()
}
