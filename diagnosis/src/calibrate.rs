//! How strong the strongest of all candidates is when there is nothing: the distribution of every family's
//! largest statistic, and of the best family over all, by resampling the recording's own whitened residual
//! through the same projections. Correlation left over because the correlation is only known with an uncertainty is put
//! into the resamples by drawing its time from its posterior; the level's uncertainty by drawing its χ².

use std::sync::OnceLock;

use numerics::{Basis, Columns, SingleColumns, parallel, rms};
use pulp::{Arch, Simd, WithSimd};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::function::{erf::erfc, gamma::gamma_ur};

use crate::correlation::{Correlation, Process};
use crate::dictionary::{Dictionary, Family, Kind, Projected};
use crate::effects::Effect;
use crate::jumps::Jumps;
use crate::noise::Noise;
use crate::thresholds::calibrate::{
    FALSE_ALARMS, MOST_NEW, MOST_RANKS, NEIGHBOURHOODS, PRIOR_TAIL, RESAMPLES, TABLE_DENSITY, TABLE_END,
    TABLE_RANK, TAIL, TOGETHER,
};

/// P(M > m) = K exp(−a m) for a family's largest statistic m = −ln P(χ²_d > S).
#[derive(Debug, Clone, Copy)]
pub struct Tail {
    /// ln K.
    pub log_count: f64,
    /// a.
    pub slope: f64,
}

impl Tail {
    /// −ln p of a family whose largest statistic is `m`.
    pub fn surprise(&self, m: f64) -> f64 {
        (self.slope * m - self.log_count).max(0.0)
    }

    /// The statistic at which −ln p is `surprise`.
    pub fn at(&self, surprise: f64) -> f64 {
        (surprise + self.log_count) / self.slope
    }

    /// Fits the tail to resampled maxima: exceedances over a high quantile, exponential.
    fn fit(maxima: &mut [f64]) -> Tail {
        maxima.sort_by(f64::total_cmp);
        let count = maxima.len();
        let kept = ((count as f64 * TAIL) as usize).max(10).min(count - 1);
        let threshold = maxima[count - kept - 1];
        let excess: f64 = maxima[count - kept..].iter().map(|m| m - threshold).sum();
        // Gamma prior on the slope, centred on 1.
        let slope = (kept as f64 + PRIOR_TAIL) / (excess + PRIOR_TAIL);
        let part = kept as f64 / count as f64;
        Tail { log_count: part.ln() + slope * threshold, slope }
    }
}

/// What resampling found.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// One tail per family.
    pub families: Vec<Tail>,
    /// Tail of the best family's −ln(p/share).
    pub overall: Tail,
    /// −ln(p/share) that the best family must reach.
    pub threshold: f64,
    /// Tail of the best generic family's −ln p, all of them alike.
    pub remainder: Tail,
}

impl Calibration {
    /// −ln of the family-wise p-value of a family's −ln p.
    pub fn family_wise(&self, surprise: f64, share: f64) -> f64 {
        self.overall.surprise(surprise + share.ln())
    }

    /// The sum of squares that a candidate of rank `rank` of `family` must explain to be taken.
    pub fn price(&self, family: usize, share: f64, rank: usize) -> f64 {
        chi_squared_at(self.families[family].at(self.threshold - share.ln()), rank)
    }
}

/// −ln P(χ²_d > s), by linear interpolation of a table where it is smooth: within 1e-3, which is nothing
/// beside the tails' own uncertainty.
pub fn log_tail(s: f64, d: usize) -> f64 {
    static TABLE: OnceLock<Vec<Vec<f64>>> = OnceLock::new();
    if d == 0 || s <= 0.0 {
        return 0.0;
    }
    if d > TABLE_RANK || !(1.0..TABLE_END).contains(&s) {
        return exact_log_tail(s, d);
    }
    let table = TABLE.get_or_init(|| {
        let entries = (TABLE_END * TABLE_DENSITY) as usize + 2;
        (0..=TABLE_RANK)
            .map(|d| (0..entries).map(|k| exact_log_tail(k as f64 / TABLE_DENSITY, d)).collect())
            .collect()
    });
    let at = s * TABLE_DENSITY;
    let k = at as usize;
    let part = at - k as f64;
    table[d][k] * (1.0 - part) + table[d][k + 1] * part
}

/// −ln P(χ²_d > s).
fn exact_log_tail(s: f64, d: usize) -> f64 {
    if s <= 0.0 || d == 0 {
        return 0.0;
    }
    match d {
        1 if s < 1000.0 => -erfc((0.5 * s).sqrt()).ln(),
        1 => 0.5 * s + 0.5 * (std::f64::consts::PI * 0.5 * s).ln(),
        2 => 0.5 * s,
        _ if s < 1000.0 => -gamma_ur(0.5 * d as f64, 0.5 * s).max(1e-300).ln(),
        _ => {
            // Leading term of the incomplete gamma function's expansion.
            let a = 0.5 * d as f64;
            let x = 0.5 * s;
            x - (a - 1.0) * x.ln() + statrs::function::gamma::ln_gamma(a)
        }
    }
}

/// The s at which −ln P(χ²_d > s) is `m`.
pub fn chi_squared_at(m: f64, d: usize) -> f64 {
    let (mut low, mut high) = (0.0, 2.0 * m + 4.0 * d as f64 + 20.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if log_tail(middle, d) < m { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Largest statistic of every family in each of the resamples, to be found in the widest registers that the
/// processor has.
struct FamilyMaxima<'a> {
    dictionary: &'a Dictionary,
    projected: &'a Projected,
    catalogue: &'a [Effect],
    /// Every projected column's scores in all resamples, one column after another, to be multiplied by the square
    /// root of the resample's scale.
    products: &'a [f32],
    /// For every family what its best step explains.
    steps: &'a [Option<[f32; TOGETHER]>],
    scales: &'a [f64; TOGETHER],
}

impl WithSimd for FamilyMaxima<'_> {
    type Output = Vec<[f64; TOGETHER]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<[f64; TOGETHER]> {
        let mut all = Vec::with_capacity(self.dictionary.families.len());
        for (family, steps) in self.dictionary.families.iter().zip(self.steps) {
            all.push(self.of(family, steps.as_ref()));
        }
        all
    }
}

impl FamilyMaxima<'_> {
    #[inline(always)]
    fn of(&self, family: &Family, steps: Option<&[f32; TOGETHER]>) -> [f64; TOGETHER] {
        // Candidates of one rank share one tail: only the largest needs it.
        let mut by_rank = [[0.0_f32; TOGETHER]; MOST_RANKS];
        let mut best = [0.0_f64; TOGETHER];
        if let Some(steps) = steps {
            by_rank[1] = *steps;
        }
        for c in family.candidates.clone() {
            let range = self.projected.of[c].clone();
            let rank = range.len();
            let mut sums = [0.0_f32; TOGETHER];
            for scores in self.products[range.start * TOGETHER..range.end * TOGETHER].chunks_exact(TOGETHER) {
                for (sum, v) in sums.iter_mut().zip(scores) {
                    *sum += v * v;
                }
            }
            if let (Kind::Effect(e), 1) = (&family.kind, rank) {
                let possible = [-1.0, 1.0].map(|sign| self.catalogue[*e].plausible_sign(sign));
                if possible != [true, true] {
                    let scores = &self.products[range.start * TOGETHER..];
                    for (sum, v) in sums.iter_mut().zip(scores) {
                        *sum = if possible[usize::from(*v > 0.0)] { *sum } else { 0.0 };
                    }
                }
            }
            match by_rank.get_mut(rank) {
                Some(largest) => {
                    for (l, s) in largest.iter_mut().zip(sums) {
                        *l = if s > *l { s } else { *l };
                    }
                }
                None => {
                    for b in 0..TOGETHER {
                        best[b] = best[b].max(log_tail(f64::from(sums[b]) * self.scales[b], rank));
                    }
                }
            }
        }
        for (rank, largest) in by_rank.iter().enumerate() {
            for b in 0..TOGETHER {
                best[b] = best[b].max(log_tail(f64::from(largest[b]) * self.scales[b], rank));
            }
        }
        best
    }
}

/// Resamples the search.
pub fn calibrate(
    dictionary: &Dictionary,
    projected: &Projected,
    catalogue: &[Effect],
    base: &Basis,
    noise: &Noise,
    angles: &[f64],
    shares: &[f64],
) -> Calibration {
    let neighbours = Neighbours::new(angles);
    let memories = Memory::all(noise);
    let whitener = noise.whitener();
    let jumps: Vec<Option<Jumps>> =
        dictionary.families.iter().map(|family| dictionary.jumps(family, &whitener, base)).collect();
    // Six digits are enough for a tail, and take half the time.
    let candidates: Vec<SingleColumns> = parallel::map(&projected.blocks, |block| block.into());
    let maxima: Vec<Vec<Vec<f64>>> = parallel::indices(0..2 * RESAMPLES / TOGETHER, |group| {
        let mut random = ChaCha8Rng::seed_from_u64(0x5eed_d1a6);
        random.set_stream(group as u64);
        let mut resamples = Columns::new(noise.whitened_residual.len());
        resamples.reserve(TOGETHER);
        let mut scales = [0.0; TOGETHER];
        for (k, scale) in scales.iter_mut().enumerate() {
            let place = (group * TOGETHER + k) % RESAMPLES;
            let part = (place as f64 + random.random::<f64>()) / RESAMPLES as f64;
            let memory = Memory::at(&memories, part);
            resamples.push(&resample(noise, &neighbours, memory, &mut random));
            // χ² of the level's freedom, by the Wilson–Hilferty cube.
            let z = standard_normal(&mut random);
            let v = 2.0 / (9.0 * noise.freedom);
            *scale = 1.0 / (1.0 - v + z * v.sqrt()).powi(3).max(0.2);
        }
        let single = SingleColumns::from(&resamples);
        let mut products = Vec::with_capacity(projected.parts.len() * TOGETHER);
        candidates.iter().for_each(|block| single.products_onto(block, &mut products));
        resamples.project_off(&base.columns);
        let steps: Vec<Option<[f32; TOGETHER]>> = jumps
            .iter()
            .map(|jumps| {
                let jumps = jumps.as_ref()?;
                Some(std::array::from_fn(|b| jumps.best(resamples.get(b)).map_or(0.0, |best| best.1 as f32)))
            })
            .collect();
        let maxima = Arch::new().dispatch(FamilyMaxima {
            dictionary,
            projected,
            catalogue,
            products: &products,
            steps: &steps,
            scales: &scales,
        });
        (0..TOGETHER).map(|b| maxima.iter().map(|m| m[b]).collect()).collect()
    });
    let maxima: Vec<Vec<f64>> = maxima.into_iter().flatten().collect();
    let mut families: Vec<Tail> = (0..dictionary.families.len())
        .map(|f| Tail::fit(&mut maxima[..RESAMPLES].iter().map(|m| m[f]).collect::<Vec<f64>>()))
        .collect();
    // Tail of the best among the families that have a share.
    let best_of = |share: &dyn Fn(usize) -> f64| {
        let best_in = |m: &Vec<f64>| {
            (0..m.len())
                .filter(|f| share(*f) > 0.0)
                .map(|f| families[f].surprise(m[f]) + share(f).ln())
                .fold(f64::NEG_INFINITY, f64::max)
        };
        Tail::fit(&mut maxima[RESAMPLES..].iter().map(best_in).collect::<Vec<f64>>())
    };
    let overall = best_of(&|f| shares[f]);
    let is_generic = |f: usize| matches!(dictionary.families[f].kind, Kind::Generic(_));
    let remainder = best_of(&|f| if is_generic(f) { 1.0 } else { 0.0 });
    let threshold = overall.at(-FALSE_ALARMS.ln());
    // The resamples hold those that were chosen from many, not the choice: each counts as often as it stands for others.
    for (tail, family) in families.iter_mut().zip(&dictionary.families) {
        tail.log_count += family.stands_for.ln();
    }
    Calibration { families, overall, threshold, remainder }
}

/// One resample: whitened residuals drawn from the rows nearest in the angle, with random signs, given a
/// correlation, whitened by the estimate. Drawn from all rows they would spread a variance that
/// changes along the stroke, beyond what its model follows, evenly over it.
fn resample(noise: &Noise, neighbours: &Neighbours, memory: &Memory, random: &mut ChaCha8Rng) -> Vec<f64> {
    let drawn: Vec<f64> = (0..noise.whitened_residual.len())
        .map(|i| {
            let bits = random.next_u64();
            let pick = neighbours.pick(i, bits >> 1);
            let value = memory.level * noise.whitened_residual[pick];
            if bits & 1 == 0 { value } else { -value }
        })
        .collect();
    let coloured = memory.correlation.colour(drawn.into_iter());
    noise.correlation.whiten(coloured.into_iter())
}

/// What the noise may remember.
struct Memory {
    correlation: Correlation,
    /// Its posterior weight.
    weight: f64,
    /// The standard deviation that goes with it, relative to that of the estimate: a recording tells what is new in
    /// each reading far better than how long it is remembered.
    level: f64,
}

impl Memory {
    /// The posterior.
    fn all(noise: &Noise) -> Vec<Memory> {
        let seen = noise.correlation.colour(noise.whitened_residual.iter().copied());
        let of = |(process, weight): &(Process, f64)| {
            let correlation = noise.correlation.with(process);
            let new = rms(&correlation.whiten(seen.iter().copied()));
            let level = (new * MOST_NEW.sqrt()).min(1.0);
            Memory { correlation, weight: *weight, level }
        };
        noise.posterior.iter().map(of).collect()
    }

    /// The one up to which `part` of the posterior lies.
    fn at(posterior: &[Memory], part: f64) -> &Memory {
        let mut sum = 0.0;
        let reached = posterior.iter().find(|memory| {
            sum += memory.weight;
            sum >= part
        });
        reached.unwrap_or(&posterior[posterior.len() - 1])
    }
}

/// The rows nearest to every row in the angle.
struct Neighbours {
    /// Rows by angle.
    sorted: Vec<usize>,
    /// Place of every row in that order.
    place: Vec<usize>,
    /// How many of them a draw is from.
    window: usize,
}

impl Neighbours {
    fn new(angles: &[f64]) -> Neighbours {
        let n = angles.len();
        let mut sorted: Vec<usize> = (0..n).collect();
        sorted.sort_by(|a, b| angles[*a].total_cmp(&angles[*b]));
        let mut place = vec![0; n];
        sorted.iter().enumerate().for_each(|(k, row)| place[*row] = k);
        Neighbours { sorted, place, window: (n / NEIGHBOURHOODS).clamp(16.min(n), n) }
    }

    fn pick(&self, row: usize, random: u64) -> usize {
        let first = self.place[row].saturating_sub(self.window / 2).min(self.sorted.len() - self.window);
        self.sorted[first + (random % self.window as u64) as usize]
    }
}

/// A standard normal number (Box–Muller).
fn standard_normal(random: &mut ChaCha8Rng) -> f64 {
    let u: f64 = random.random::<f64>().max(1e-300);
    let v: f64 = random.random();
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}
