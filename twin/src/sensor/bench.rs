//! The sensor, how it is stepped through its range, and the recording.

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_distr::StandardNormal;

use super::surroundings::Courses;
use super::{Kind, Moment};
use crate::noise::{Noise, Source};
use crate::streams::{Stream, stream};
use crate::units::round_to;

/// Step of the simulation in seconds.
const STEP_S: f64 = 0.5;
/// Seconds from one reading to the next, and from one pass to the next.
const DWELL_S: f64 = 3.0;
const PAUSE_S: f64 = 24.0;
/// Standard deviation of where a stop comes to lie, in millimetres.
const SCATTER_MM: f64 = 1e-3;
/// Standard deviations of the noise of the reference and of the sensor in millimetres.
const REFERENCE_MM: f64 = 8e-5;
const SENSOR_MM: f64 = 4e-5;

/// A sensor on its bench.
pub struct Bench {
    /// Its characteristic: the error in millimetres is Σ c m^(n+1) of its reading m in millimetres.
    characteristic_mm: [f64; 5],
    zero_mm: f64,
    kind: Option<&'static Kind>,
    shape: Vec<f64>,
}

/// How the range is stepped through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// Stops of a pass.
    pub stops: usize,
    /// Passes, forward and backward in turn.
    pub passes: u32,
    /// Whether the stops of a pass come in random order.
    pub random: bool,
    /// The kind of noise.
    pub noise: Noise,
}

impl Schedule {
    /// How long a recording takes in seconds.
    pub fn duration_s(&self) -> f64 {
        f64::from(self.passes) * (self.stops as f64 * DWELL_S + PAUSE_S)
    }
}

/// One reading, positions in millimetres.
#[derive(Debug, Clone)]
pub struct Row {
    /// Time in seconds.
    pub t_s: f64,
    /// Number of the pass, from 1.
    pub pass: u32,
    /// +1 where the position grew, −1 where it fell.
    pub direction: f64,
    /// What the sensor reports, without the physics that is concealed.
    pub measured_mm: f64,
    /// What the reference reads.
    pub reference_mm: f64,
    /// What it would read without its noise.
    pub clean_mm: f64,
    /// What the concealed physics adds to `measured_mm` at unit strength.
    pub effect: f64,
    /// The columns, as logged.
    pub columns: Vec<f64>,
}

impl Bench {
    /// Standard deviation in millimetres of the error's noise of a kind, outliers included with their share; of noise
    /// that lasts, its white part.
    pub fn noise_mm(noise: &Noise) -> f64 {
        (REFERENCE_MM * noise.outlier_variance().sqrt()).hypot(SENSOR_MM)
    }

    /// The sensor of `seed`, with a kind of physics shaped for recordings of about `duration_s`.
    pub fn from_seed(seed: u64, kind: Option<&'static Kind>, duration_s: f64) -> Self {
        let mut generator = stream(seed, Stream::Sensor);
        let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
        let characteristic_mm = [2e-3, 4e-3, 3e-3, 1e-3, 1e-3].map(|most| uniform(-most, most));
        let zero_mm = uniform(-0.05, 0.05);
        let shape = kind.map_or_else(Vec::new, |kind| (kind.shape)(&mut uniform, duration_s));
        Self { characteristic_mm, zero_mm, kind, shape }
    }

    /// The numbers that shape the concealed physics.
    pub fn shape(&self) -> &[f64] {
        &self.shape
    }

    /// Its reading in millimetres at a true position, without noise and effects.
    fn raw_mm(&self, x_mm: f64) -> f64 {
        let error_mm = |m: f64| m * self.characteristic_mm.iter().rev().fold(0.0, |sum, c| sum * m + c);
        // Its slope is below 0.05: twelve steps leave less than 10⁻¹⁵.
        (0..12).fold(x_mm, |m, _| x_mm + error_mm(m))
    }

    /// Records it. One seed gives one recording; another the same sensor in other surroundings.
    pub fn record(&self, schedule: &Schedule, seed: u64) -> Vec<Row> {
        let [mut order, mut scatter, mut housekeeping, mut outliers] =
            [Stream::Order, Stream::Controller, Stream::Housekeeping, Stream::Outliers]
                .map(|of| stream(seed, of));
        let mut noise = [Stream::Autocollimator, Stream::Probes]
            .map(|of| Source::start(&schedule.noise, 1, stream(seed, of)));
        let mut physics = self.kind.map(|kind| (kind.build)(&self.shape));
        let mut courses = Courses::start(schedule.duration_s(), seed);
        let last = (schedule.stops.max(2) - 1) as f64;
        let mut stops: Vec<f64> = (0..schedule.stops).map(|i| 2.0 * i as f64 / last - 1.0).collect();
        let (mut t_s, mut x_mm) = (0.0, -1.0);
        let mut rows = Vec::new();
        for pass in 1..=schedule.passes {
            if pass > 1 {
                stops.reverse();
            }
            if schedule.random {
                stops.shuffle(&mut order);
            }
            for (index, stop) in stops.iter().enumerate() {
                let to_mm = stop + SCATTER_MM * scatter.sample::<f64, _>(StandardNormal);
                let from_mm = x_mm;
                let rest_s = if index == 0 { PAUSE_S } else { 0.0 } + scatter.random_range(-1.0..1.0);
                let steps = ((DWELL_S + rest_s) / STEP_S).round().max(2.0);
                let (mut effect, mut around) = (0.0, None);
                for step in 1..=steps as u32 {
                    // The stage moves during the first half of the way and rests then.
                    x_mm = from_mm + (to_mm - from_mm) * (2.0 * f64::from(step) / steps).min(1.0);
                    t_s += STEP_S;
                    let now = courses.advance(t_s, STEP_S, x_mm);
                    let moment = Moment { step_s: STEP_S, x_mm, raw_mm: self.raw_mm(x_mm), around: now };
                    effect = physics.as_mut().map_or(0.0, |physics| physics(&moment));
                    around = Some(now);
                }
                let growth = schedule.noise.factor_at(*stop);
                let disturbed = schedule.noise.disturbance(&mut outliers);
                let clean_mm = x_mm + self.zero_mm;
                let normal = || housekeeping.sample(StandardNormal);
                rows.push(Row {
                    t_s: round_to(t_s, 2),
                    pass,
                    direction: if to_mm >= from_mm { 1.0 } else { -1.0 },
                    measured_mm: self.raw_mm(x_mm) + growth * SENSOR_MM * noise[1].draw(0, t_s),
                    reference_mm: clean_mm + growth * disturbed * REFERENCE_MM * noise[0].draw(0, t_s),
                    clean_mm,
                    effect,
                    columns: around.map_or_else(Vec::new, |around| around.logged(normal)),
                });
            }
        }
        rows
    }
}
