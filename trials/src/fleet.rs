//! Whether the fleet's own answers hold: fleets of simulated mirrors are recorded into a folder, `fleet` is run on it, and
//! its page in JSON is held against what was drawn.
//!
//! - *Pooled*: one effect in every unit, its parameter drawn about a mean with a spread. How often the intervals of mean and
//!   spread hold these.
//! - *Weak*: one effect of ρ 2 in every unit: too little for a diagnosis of one unit.
//! - *Nothing*: no effect. Whether the fleet shows one.
//!
//! In none of them does a unit depart, or do lots and times mean anything: whether the fleet says so nevertheless.

use std::fmt::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;
use statrs::distribution::{ContinuousCDF, Normal};
use twin::{
    Device, Noise, Protocol, Temperature, calculated_angle_rad, contributions, noise_covariance,
    record_with_truth, write_file,
};

use crate::error::CampaignError;
use crate::formulas::Columns;
use crate::matched::Metric;
use crate::programs::Programs;
use crate::score::{Figure, Share};
use crate::workspace::{Campaign, empty_folder, put, threads};

/// What is wanted of a stated 95 %.
const WANTED: RangeInclusive<f64> = 0.93..=0.97;
/// False alarms of a question that are allowed.
const FALSE_ALARMS: f64 = 0.01;
/// Units of a fleet of weak effects, and their strength.
const WEAK_UNITS: usize = 200;
const WEAK_RHO: f64 = 2.0;
/// Strength of the mean of a pooled effect, and of its spread.
const MEAN_RHO: f64 = 12.0;
const SPREAD_RHO: f64 = 3.0;
/// Ids and parameters, linear each.
const EFFECTS: [[&str; 2]; 3] = [
    ["thermal_zero_drift", "coefficient_arcsec_per_k"],
    ["cross_axis_coupling", "coefficient_arcsec_per_arcsec"],
    ["coil_crosstalk", "coefficient_arcsec_per_a"],
];
const MIRROR: &str = include_str!("mirror.toml");

/// How many fleets of each kind, and units of each but the weak ones.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Counts {
    /// Fleets of a pooled effect.
    pub pooled: usize,
    /// Fleets of a weak effect.
    pub weak: usize,
    /// Fleets of nothing.
    pub nulls: usize,
    /// Units of a fleet.
    pub units: usize,
}

/// What was measured: of the fleets, and of the units where these are counted.
#[derive(Debug, Default, Serialize)]
pub struct Measured {
    mean: Share,
    spread: Share,
    pooled_shown: Share,
    others_shown: Share,
    weak_found: Share,
    weak_named: Share,
    shown: Share,
    outlying: Share,
    lots: Share,
    trends: Share,
    named: Share,
    /// What was said where there is nothing to say.
    alarms: Vec<String>,
}

/// How strong an effect is in each unit.
#[derive(Clone, Copy, PartialEq)]
enum Strength {
    /// Its parameter is normal about a mean: that of [`MEAN_RHO`] in the first unit, with the spread of [`SPREAD_RHO`].
    Normal,
    /// Of this ρ.
    Rho(f64),
}

/// One fleet to be drawn.
struct Fleet {
    units: usize,
    /// Id and parameter of the effect, and how strong it is.
    effect: Option<([&'static str; 2], Strength)>,
    noise: Noise,
    seed: u64,
}

impl Campaign<Counts> {
    /// Runs all fleets.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn fleets(&self, programs: &Programs) -> Result<Measured, CampaignError> {
        let Counts { pooled, weak, nulls, units } = self.counts;
        let mut measured = Measured::default();
        let fleet = |kind: u64, number: usize, units, effect, noise| Fleet {
            units,
            effect,
            noise,
            seed: self.seed ^ (kind << 60) ^ ((number as u64) << 24),
        };
        programs.begin("pooled", pooled);
        for number in 0..pooled {
            let effect = EFFECTS[number % EFFECTS.len()];
            let fleet = fleet(1, number, units, Some((effect, Strength::Normal)), Noise::White);
            let (answer, truth) = self.answer(programs, &fleet)?;
            measured.count_pooled(&answer, effect, truth);
        }
        programs.begin("weak", weak);
        for number in 0..weak {
            let effect = EFFECTS[number % EFFECTS.len()];
            let fleet = fleet(2, number, WEAK_UNITS, Some((effect, Strength::Rho(WEAK_RHO))), Noise::White);
            let (answer, _) = self.answer(programs, &fleet)?;
            measured.count_weak(&answer, effect[0]);
        }
        programs.begin("nothing", nulls);
        for number in 0..nulls {
            let noises = [Noise::White, Noise::autocorrelated(), Noise::heteroscedastic(), Noise::outliers()];
            let noise = noises[number % noises.len()];
            let (answer, _) = self.answer(programs, &fleet(3, number, units, None, noise))?;
            measured.count_nothing(&answer);
        }
        Ok(measured)
    }

    /// Records a fleet and has it diagnosed; the answer, with mean and spread that were drawn from.
    fn answer(&self, programs: &Programs, fleet: &Fleet) -> Result<(Value, [f64; 2]), CampaignError> {
        let folder = std::path::absolute(&self.out).unwrap_or_else(|_| self.out.clone());
        let (recordings, results) = (folder.join("recordings"), folder.join("results"));
        empty_folder(&recordings)?;
        empty_folder(&results)?;
        put(&folder.join("mirror.toml"), MIRROR)?;
        put(&folder.join("lots.csv"), &fleet.lots())?;
        let drawn = threads(self.jobs)?.install(|| fleet.draw(&recordings))?;
        let run = programs.fleet(&folder, self.jobs)?;
        run.map_err(|reason| CampaignError::Refused { program: "fleet", what: "a fleet", reason })?;
        programs.watch.advance(1);
        let path = results.join("fleet.json");
        let text = std::fs::read_to_string(&path).map_err(|error| CampaignError::Unreadable {
            path: path.clone(),
            reason: error.kind(),
            expected: EXPECTED,
        })?;
        let answer = serde_json::from_str(&text).map_err(|reason| CampaignError::Form {
            path,
            reason,
            expected: EXPECTED,
        })?;
        Ok((answer, drawn))
    }
}

const EXPECTED: &str = "the page of a fleet in JSON";

impl Fleet {
    fn generator(&self, unit: usize) -> ChaCha12Rng {
        let mut generator = ChaCha12Rng::seed_from_u64(self.seed);
        generator.set_stream(unit as u64);
        generator
    }

    /// Lots and times that mean nothing.
    fn lots(&self) -> String {
        let mut text = "unit,lot,time\n".to_string();
        for unit in 0..self.units {
            let mut generator = self.generator(self.units + unit);
            let (lot, time) = (generator.random_range(0..2), generator.random_range(0.0..100.0));
            // Writing to memory does not fail.
            let _ = writeln!(text, "u{unit:05},lot {lot},{time:.2}");
        }
        text
    }

    /// Records the units into a folder; mean and spread that they were drawn from.
    fn draw(&self, folder: &Path) -> Result<[f64; 2], CampaignError> {
        let first = self.effect.map_or(1.0, |(effect, _)| self.rho_of_one(effect, 0).unwrap_or(1.0));
        let truth = [MEAN_RHO / first, SPREAD_RHO / first];
        let record = |unit: usize| {
            let (device, seed) = self.device(unit);
            let value = match self.effect {
                Some((_, Strength::Normal)) => {
                    truth[0] + truth[1] * normal(&mut self.generator(2 * self.units + unit))
                }
                Some((effect, Strength::Rho(rho))) => rho / self.rho_of_one(effect, unit).unwrap_or(1.0),
                None => 0.0,
            };
            let device = self.effect.map_or(device.clone(), |(effect, _)| with(&device, effect, value));
            let log = twin::record(&device, &self.protocol(), seed, &feedback(&device));
            Ok(write_file(&log, &folder.join(format!("u{unit:05}.csv")))?)
        };
        (0..self.units).into_par_iter().map(record).collect::<Result<(), CampaignError>>()?;
        Ok(truth)
    }

    /// A device whose probes match, and the seed of its recording.
    fn device(&self, unit: usize) -> (Device, u64) {
        let mut generator = self.generator(unit);
        (Device::from_seed(generator.random()).with_mismatch(0.0), generator.random())
    }

    fn protocol(&self) -> Protocol {
        Protocol { temperature: Temperature::levels(), noise: self.noise, ..Protocol::calibration() }
    }

    /// ρ of an effect whose parameter is 1; none where the covariance of the noise is not positive definite.
    fn rho_of_one(&self, effect: [&str; 2], unit: usize) -> Option<f64> {
        let (device, seed) = self.device(unit);
        let (device, protocol) = (with(&device, effect, 1.0), self.protocol());
        let feedback = feedback(&device);
        let (log, truths): (Vec<_>, Vec<_>) =
            record_with_truth(&device, &protocol, seed, &feedback).into_iter().unzip();
        let distance_mm = device.geometry.probe_distance_mm;
        let covariance = noise_covariance(&truths, &protocol.noise);
        let metric = Metric::new(&Columns::new(&log, distance_mm), &covariance, distance_mm)?;
        metric.rho(&contributions(&device, &protocol, seed, &feedback)).first().copied()
    }
}

/// The device with an effect whose parameter has this value.
fn with(device: &Device, [id, parameter]: [&str; 2], value: f64) -> Device {
    let effect = format!("{id}:{parameter}={value}").parse();
    let made = effect.and_then(|effect| device.with_effects(vec![effect]));
    made.unwrap_or_else(|error| unreachable!("the effects of this file are of the catalogue: {error}"))
}

fn feedback(device: &Device) -> impl Fn(f64, f64) -> f64 + use<> {
    let distance_mm = device.geometry.probe_distance_mm;
    move |x1, x2| calculated_angle_rad(x1, x2, distance_mm)
}

fn normal(generator: &mut ChaCha12Rng) -> f64 {
    let uniform: f64 = generator.random();
    Normal::standard().inverse_cdf(uniform.clamp(1e-12, 1.0 - 1e-12))
}

fn list<'a>(answer: &'a Value, name: &str) -> impl Iterator<Item = &'a Value> {
    answer[name].as_array().into_iter().flatten()
}

impl Measured {
    fn count_pooled(&mut self, answer: &Value, [id, parameter]: [&str; 2], [mean, spread]: [f64; 2]) {
        let all = answer["parameters"].as_array();
        let is = |one: &&Value| one["effect"] == id && one["parameter"] == parameter;
        let found = all.and_then(|all| all.iter().find(is));
        let holds = |interval: &str, truth: f64| {
            let end = |k: usize| found.and_then(|one| one[interval][k].as_f64());
            matches!((end(0), end(1)), (Some(low), Some(high)) if (low..=high).contains(&truth))
        };
        self.mean.count(holds("mean_ci95", mean));
        self.spread.count(holds("spread_ci95", spread));
        let shown = |one: &&Value| one["shown_by_fleet"].is_number();
        self.pooled_shown.count(found.as_ref().is_some_and(shown));
        let other = |one: &Value| one["effect"] != id && shown(&one);
        self.others_shown.count(all.is_some_and(|all| all.iter().any(other)));
        self.count_alarms(answer);
    }

    fn count_weak(&mut self, answer: &Value, id: &str) {
        let of = |list: &str, has: &str| {
            answer[list].as_array().is_some_and(|all| {
                all.iter().any(|one| one["effect"] == id && (has.is_empty() || one[has].is_number()))
            })
        };
        self.weak_found.count(of("parameters", "shown_by_fleet"));
        let units = answer["units"].as_u64().unwrap_or(0);
        let named = answer["physics"].as_array().and_then(|all| all.iter().find(|one| one["effect"] == id));
        self.weak_named.of += units;
        self.weak_named.hits += named.and_then(|one| one["units"].as_u64()).unwrap_or(0);
    }

    fn count_nothing(&mut self, answer: &Value) {
        let shown: Vec<String> = list(answer, "parameters")
            .filter(|one| one["shown_by_fleet"].is_number())
            .map(|one| format!("{} {}: is shown", one["effect"], one["at"]))
            .collect();
        self.shown.count(!shown.is_empty());
        self.alarms.extend(shown);
        self.named.of += answer["units"].as_u64().unwrap_or(0);
        self.named.hits += list(answer, "physics").filter_map(|one| one["units"].as_u64()).sum::<u64>();
        self.count_alarms(answer);
    }

    /// What is said of units, lots and times, of which there is nothing to say.
    fn count_alarms(&mut self, answer: &Value) {
        let level = answer["false_alarms"].as_f64().unwrap_or(FALSE_ALARMS);
        let mut said = |what: &str, of: &dyn Fn(&Value) -> Option<f64>| {
            let alarms = list(answer, "parameters").filter(|one| of(one).is_some_and(|p| p < level));
            let alarms: Vec<String> =
                alarms.map(|one| format!("{} {}: {what}", one["effect"], one["parameter"])).collect();
            self.alarms.extend(alarms.iter().cloned());
            !alarms.is_empty()
        };
        let lots = said("lots differ", &|one| one["lots"]["p_value"].as_f64());
        let trend = said("a trend", &|one| one["trend"]["p_value"].as_f64());
        self.lots.count(lots);
        self.trends.count(trend);
        let outlying: Vec<String> = list(answer, "outlying")
            .map(|one| format!("{} {}: {} stands out", one["effect"], one["parameter"], one["unit"]))
            .collect();
        self.outlying.count(!outlying.is_empty());
        self.alarms.extend(outlying);
    }

    /// Held against what is wanted.
    pub fn figures(&self) -> Vec<Figure> {
        let covers = |what: &str, share: Share| {
            let wanted = format!("{:.0}–{:.0} %", 100.0 * WANTED.start(), 100.0 * WANTED.end());
            Figure::new(what, wanted, share.to_string(), share.value().map(|value| WANTED.contains(&value)))
        };
        vec![
            covers("pooled: the mean lies in its interval", self.mean),
            covers("pooled: the spread lies in its interval", self.spread),
            Figure::reported("pooled: the fleet shows the effect", self.pooled_shown),
            Figure::at_least("weak: the fleet shows the effect", 1.0, self.weak_found),
            Figure::reported("weak: units that name the effect alone", self.weak_named),
            Figure::at_most("nothing: an effect is shown", FALSE_ALARMS, self.shown),
            Figure::at_most("pooled: another effect is shown", FALSE_ALARMS, self.others_shown),
            Figure::at_most("pooled and nothing: a unit stands out", FALSE_ALARMS, self.outlying),
            Figure::at_most("pooled and nothing: lots differ", FALSE_ALARMS, self.lots),
            Figure::at_most("pooled and nothing: a trend", FALSE_ALARMS, self.trends),
            Figure::reported("nothing: units that name an effect", self.named),
        ]
    }
}
