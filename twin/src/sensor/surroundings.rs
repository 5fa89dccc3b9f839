//! What surrounds the sensor and is recorded beside it.

use std::f64::consts::TAU;
use std::ops::Index;

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use crate::noise::Wander;
use crate::streams::{Stream, stream};

/// A recorded column: its place in [`COLUMNS`].
pub type Column = usize;

/// How a column goes over a recording.
#[derive(Debug, Clone, Copy)]
enum Course {
    /// It wanders about its mean, and cycles through the recording.
    Wandering,
    /// It stays at levels within twice the deviation, for a thirtieth of the recording on average.
    Levels,
    /// The position on a screw of 0.37 mm pitch whose belt slips: an angle in degrees.
    Shaft,
}

/// What a column is.
#[derive(Debug, Clone, Copy)]
pub struct Described {
    /// Its name with its unit.
    pub name: &'static str,
    mean: f64,
    deviation: f64,
    course: Course,
}

const fn wandering(name: &'static str, mean: f64, deviation: f64) -> Described {
    Described { name, mean, deviation, course: Course::Wandering }
}

const fn levels(name: &'static str, mean: f64, deviation: f64) -> Described {
    Described { name, mean, deviation, course: Course::Levels }
}

/// The temperature.
pub const TEMPERATURE: Column = 0;
pub const HUMIDITY: Column = 1;
pub const PRESSURE: Column = 2;
pub const SUPPLY: Column = 3;
pub const FLOW: Column = 4;
pub const CURRENT: Column = 5;
pub const TILT: Column = 6;
pub const STRAIN: Column = 7;
pub const VIBRATION: Column = 8;
pub const COOLANT: Column = 9;
pub const YAW: Column = 10;
pub const LIGHT: Column = 11;
pub const SHAFT: Column = 12;
pub const LOAD: Column = 13;

/// All columns.
pub const COLUMNS: [Described; 14] = [
    wandering("temperature_c", 24.0, 2.5),
    wandering("humidity_pct", 45.0, 9.0),
    wandering("pressure_hpa", 1005.0, 6.0),
    wandering("supply_v", 12.0, 0.15),
    wandering("purge_lpm", 6.0, 1.2),
    levels("current_a", 0.0, 0.4),
    wandering("tilt_deg", 0.0, 35.0),
    levels("strain_ue", 20.0, 30.0),
    wandering("vibration_mm_s", 1.5, 0.5),
    wandering("coolant_c", 19.0, 1.0),
    wandering("yaw_arcsec", 0.0, 8.0),
    wandering("light_klx", 1.2, 0.4),
    Described { name: "shaft_deg", mean: 0.0, deviation: 150.0, course: Course::Shaft },
    levels("load_n", 12.0, 4.0),
];

/// The values of all columns at one time.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings([f64; COLUMNS.len()]);

impl Index<Column> for Surroundings {
    type Output = f64;

    fn index(&self, column: Column) -> &f64 {
        &self.0[column]
    }
}

/// Screw pitch in millimetres.
const PITCH_MM: f64 = 0.37;
/// Part of a column's deviation that its instrument errs by.
const INSTRUMENT: f64 = 0.003;

/// One column on its way through a recording.
struct Running {
    of: Described,
    generator: ChaCha12Rng,
    wander: Wander,
    /// The wander without its roughness.
    smooth: f64,
    level: f64,
    cycles: f64,
    phase: f64,
}

impl Running {
    fn start(column: Column, duration_s: f64, seed: u64) -> Self {
        let mut generator = stream(seed, Stream::Surroundings(column as u32));
        let cycles = generator.random_range(0.8..2.5);
        let phase = generator.random_range(0.0..TAU);
        let wander = Wander::start(1.0, 0.12 * duration_s, &mut generator);
        let level = generator.random_range(-2.0..2.0);
        Self { of: COLUMNS[column], generator, wander, smooth: 0.0, level, cycles, phase }
    }

    fn advance(&mut self, t_s: f64, step_s: f64, duration_s: f64, x_mm: f64) -> f64 {
        let wandered = self.wander.at(t_s, &mut self.generator);
        self.smooth += (wandered - self.smooth) * (step_s / (0.02 * duration_s)).min(1.0);
        if self.generator.random::<f64>() < 30.0 * step_s / duration_s {
            self.level = self.generator.random_range(-2.0..2.0);
        }
        let cycle = (TAU * self.cycles * t_s / duration_s + self.phase).sin();
        let Described { mean, deviation, course, .. } = self.of;
        match course {
            Course::Wandering => mean + deviation * (0.6 * self.smooth + 1.1 * cycle),
            Course::Levels => mean + deviation * (self.level + 0.1 * self.smooth),
            Course::Shaft => (360.0 * x_mm / PITCH_MM + deviation * self.smooth).rem_euclid(360.0),
        }
    }
}

/// All columns on their way through a recording.
pub(super) struct Courses {
    running: Vec<Running>,
    duration_s: f64,
}

impl Courses {
    pub(super) fn start(duration_s: f64, seed: u64) -> Self {
        let running = (0..COLUMNS.len()).map(|column| Running::start(column, duration_s, seed)).collect();
        Self { running, duration_s }
    }

    /// The surroundings at the end of a step.
    pub(super) fn advance(&mut self, t_s: f64, step_s: f64, x_mm: f64) -> Surroundings {
        let mut values = [0.0; COLUMNS.len()];
        for (value, running) in values.iter_mut().zip(&mut self.running) {
            *value = running.advance(t_s, step_s, self.duration_s, x_mm);
        }
        Surroundings(values)
    }
}

impl Surroundings {
    /// As the instruments show them; `normal` gives standard normal deviates.
    pub(super) fn logged(&self, mut normal: impl FnMut() -> f64) -> Vec<f64> {
        let errs =
            |of: &Described| if matches!(of.course, Course::Shaft) { 0.1 } else { INSTRUMENT * of.deviation };
        self.0.iter().zip(&COLUMNS).map(|(value, of)| value + errs(of) * normal()).collect()
    }
}
