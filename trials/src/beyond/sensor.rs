//! The position sensor as a device of the trials.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::sensor::{Bench, COLUMNS, Row, Schedule, TEMPERATURE, find};

use super::draw::Made;
use super::lab::Lab;
use super::plan::{Assignment, Condition};

/// A sensor with physics concealed in it, and how it is recorded.
pub struct Sensor {
    bench: Bench,
    schedule: Schedule,
    seed: u64,
    fresh_schedule: Schedule,
    fresh_seed: u64,
    /// The recorded columns.
    columns: Vec<usize>,
}

impl Sensor {
    /// Draws a sensor and its schedules.
    pub fn draw(assignment: &Assignment, generator: &mut ChaCha12Rng) -> Self {
        let kind = assignment.concealed.and_then(|kind| find(kind.id));
        let mut columns: Vec<usize> = kind.map_or_else(Vec::new, |kind| kind.columns.to_vec());
        // The temperature is always recorded.
        columns.push(TEMPERATURE);
        // Two columns that have nothing to do with it.
        columns.extend((0..2).map(|_| generator.random_range(0..COLUMNS.len())));
        columns.sort_unstable();
        columns.dedup();
        let noise = (assignment.family.noise)();
        let mut schedule = |condition| Schedule { noise, ..schedule(condition, generator) };
        let (first, fresh) = (schedule(assignment.condition), schedule(Condition::Plain));
        Self {
            bench: Bench::from_seed(generator.random(), kind, first.duration_s()),
            schedule: first,
            seed: generator.random(),
            fresh_schedule: Schedule { noise: twin::Noise::White, ..fresh },
            fresh_seed: generator.random(),
            columns,
        }
    }

    fn lab(&self, schedule: &Schedule, seed: u64, strength: f64) -> Lab {
        let rows = self.bench.record(schedule, seed);
        let of = |value: &dyn Fn(&Row) -> f64| rows.iter().map(value).collect::<Vec<f64>>();
        let measured = of(&|row| row.measured_mm + strength * row.effect);
        let mut columns = vec![
            ("t_s".to_owned(), of(&|row| row.t_s)),
            ("pass".to_owned(), of(&|row| f64::from(row.pass))),
            ("direction".to_owned(), of(&|row| row.direction)),
            ("measured".to_owned(), measured.clone()),
            ("reference".to_owned(), of(&|row| row.reference_mm)),
        ];
        let further = |column: &usize| (COLUMNS[*column].name.to_owned(), of(&|row| row.columns[*column]));
        columns.extend(self.columns.iter().map(further));
        Lab {
            columns,
            measured,
            reference: "reference",
            clean: of(&|row| row.clean_mm),
            effect: of(&|row| strength * row.effect),
            noise: Bench::noise_mm(&schedule.noise),
        }
    }
}

impl Made for Sensor {
    fn record(&self, strength: f64) -> Option<Lab> {
        Some(self.lab(&self.schedule, self.seed, strength))
    }

    fn record_afresh(&self, strength: f64) -> Option<Lab> {
        Some(self.lab(&self.fresh_schedule, self.fresh_seed, strength))
    }

    fn shape(&self) -> Vec<f64> {
        self.bench.shape().to_vec()
    }
}

/// Decimals of a column.
pub fn decimals(column: &str) -> usize {
    match column {
        "pass" | "direction" => 0,
        "measured" | "reference" => 7,
        "t_s" => 2,
        _ => 4,
    }
}

fn schedule(condition: Condition, generator: &mut ChaCha12Rng) -> Schedule {
    let (stops, passes) = match condition {
        Condition::FewRows => (generator.random_range(25..=41), 3),
        Condition::ManyRows => (101, 14),
        _ => (generator.random_range(41..=81), generator.random_range(6..=10)),
    };
    Schedule { stops, passes, random: condition == Condition::RandomOrder, noise: twin::Noise::White }
}
