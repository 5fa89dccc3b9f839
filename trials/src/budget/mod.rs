//! Whether the expanded uncertainty of a budget holds what it states: devices are simulated and calibrated against a
//! reference with an error of its own; the calibration is fitted, a routine generated with its budget; then one fresh
//! reading in every tenth of the range is corrected by that routine and held against the truth.
//!
//! A device contributes one reading to each tenth. Its ten errors have the reference's error in common, so that the pooled
//! share is of as many independent devices, not readings.

mod encoder;
mod linear;
mod mirror;
mod reference;

use std::borrow::Cow;
use std::ops::RangeInclusive;

use codegen::generate::{Generated, generate};
use codegen::interpret::{Word, interpret};
use codegen::options::Options;
use codegen::program::Program;
use fitter::progress::Progress;
use fitter::{Coefficients, Mirror, Recording, faults, fit};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::CampaignError;
use crate::score::{Figure, Share};

/// What is wanted of the stated 95 %: pooled, and in each tenth of the range.
const POOLED: RangeInclusive<f64> = 0.93..=0.97;
const IN_A_TENTH: RangeInclusive<f64> = 0.90..=0.99;
const TENTHS: usize = 10;

/// A kind of sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A scanning mirror with two probes.
    Mirror,
    /// A magnetic encoder that turns.
    Encoder,
    /// A sensor that reports a length.
    Linear,
    /// One that drifts with temperature, which a diagnosis has to find.
    Warmed,
    /// One whose noise lasts from one reading to the next.
    Correlated,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 5] = [Kind::Mirror, Kind::Encoder, Kind::Linear, Kind::Warmed, Kind::Correlated];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Mirror => "mirror",
            Kind::Encoder => "encoder",
            Kind::Linear => "linear",
            Kind::Warmed => "warmed",
            Kind::Correlated => "correlated",
        }
    }

    /// A stream of random numbers of its own.
    fn stream(self) -> u64 {
        match self {
            Kind::Mirror => 1,
            Kind::Encoder => 2,
            Kind::Linear => 3,
            Kind::Warmed => 4,
            Kind::Correlated => 5,
        }
    }

    fn simulate(self, generator: &mut ChaCha12Rng) -> Trial {
        match self {
            Kind::Mirror => mirror::simulate(generator),
            Kind::Encoder => encoder::simulate(generator),
            Kind::Linear => linear::simulate(generator),
            Kind::Warmed => linear::warmed(generator),
            Kind::Correlated => linear::correlated(generator),
        }
    }
}

/// A device that was calibrated, and its fresh readings.
struct Trial {
    /// The calibration recording.
    csv: Vec<u8>,
    /// What is stated of sensor and reference.
    mirror: String,
    /// Whether the coefficients are those of a diagnosis.
    diagnosed: bool,
    /// What the routine is to be given and to return.
    options: Options,
    /// Fresh readings.
    fresh: Vec<Fresh>,
    /// One whole turn in the budget's unit; none where nothing turns.
    turn: Option<f64>,
    /// Whether the true values count from the zero α₀ that the fit found.
    from_zero: bool,
}

/// A fresh reading.
#[derive(Debug, Clone, Copy)]
struct Fresh {
    /// Which tenth of the range it lies in.
    tenth: usize,
    /// Where it lies in the budget's table.
    place: f64,
    /// The word of the converter.
    word: i64,
    /// That of the further input.
    further: Option<i64>,
    /// The true value in the budget's unit, on the scale of the reference.
    truth: f64,
}

/// The first reading in each tenth of the range.
fn one_in_each(fresh: Vec<Fresh>) -> Vec<Fresh> {
    let first = |tenth| fresh.iter().find(|one| one.tenth == tenth).copied();
    (0..TENTHS).filter_map(first).collect()
}

/// What was measured of a kind.
#[derive(Debug, Clone, Serialize)]
pub struct Covered {
    /// The kind of sensor.
    pub kind: &'static str,
    /// Devices that gave a budget.
    pub devices: Share,
    /// Readings within their expanded uncertainty.
    pub pooled: Share,
    /// The same in each tenth of the range.
    pub tenths: Vec<Share>,
    /// Root mean square of the error over the expanded uncertainty.
    pub error_over_expanded: f64,
}

impl Covered {
    /// Held against what is wanted.
    pub fn figures(&self) -> Vec<Figure> {
        let kind = self.kind;
        let percent = |range: &RangeInclusive<f64>| {
            format!("{:.0}–{:.0} %", 100.0 * range.start(), 100.0 * range.end())
        };
        let within = |range: &RangeInclusive<f64>, share: &Share| share.value().map(|v| range.contains(&v));
        let ends = |pick: fn(f64, f64) -> f64, start| {
            100.0 * self.tenths.iter().filter_map(|share| share.value()).fold(start, pick)
        };
        let tenths = format!("{:.1} to {:.1} %", ends(f64::min, 1.0), ends(f64::max, 0.0));
        let all = self.tenths.iter().map(|share| within(&IN_A_TENTH, share)).collect::<Option<Vec<_>>>();
        let devices = format!("{kind}: devices with a budget");
        vec![
            // Whether a diagnosis names what was concealed is scored by other trials: an effect with a memory in its place needs
            // a routine that is called again and again.
            match kind == Kind::Warmed.name() {
                true => Figure::noted(devices, self.devices.to_string()),
                false => Figure::at_least(devices, 1.0, self.devices),
            },
            Figure::new(
                format!("{kind}: errors within U"),
                percent(&POOLED),
                self.pooled.to_string(),
                within(&POOLED, &self.pooled),
            ),
            Figure::new(
                format!("{kind}: the same in each tenth of the range"),
                percent(&IN_A_TENTH),
                tenths,
                all.map(|all| all.into_iter().all(|within| within)),
            ),
            Figure::noted(format!("{kind}: rms of error over U"), format!("{:.3}", self.error_over_expanded)),
        ]
    }
}

/// Simulates so many devices of a kind.
///
/// # Errors
/// [`CampaignError::Threads`].
pub fn run(
    kind: Kind,
    devices: usize,
    seed: u64,
    jobs: usize,
    watch: &dyn Progress,
) -> Result<Covered, CampaignError> {
    watch.doing(kind.name());
    watch.steps(devices as u64);
    let pool = crate::workspace::threads(jobs)?;
    let one = |device: usize| {
        let mut generator = ChaCha12Rng::seed_from_u64(seed);
        generator.set_stream((kind.stream() << 40) + device as u64);
        let errors = errors(&kind.simulate(&mut generator));
        watch.advance(1);
        if let Err(reason) = &errors {
            watch.warn(&format!("{} {device}: {reason}", kind.name()));
        }
        errors.ok()
    };
    let all: Vec<Option<Vec<(usize, f64)>>> =
        pool.install(|| (0..devices).into_par_iter().map(one).collect());
    let mut covered = Covered {
        kind: kind.name(),
        devices: Share::default(),
        pooled: Share::default(),
        tenths: vec![Share::default(); TENTHS],
        error_over_expanded: 0.0,
    };
    for device in &all {
        covered.devices.count(device.is_some());
        for (tenth, error) in device.iter().flatten() {
            covered.tenths[*tenth].count(*error <= 1.0);
            covered.pooled.count(*error <= 1.0);
            covered.error_over_expanded += error * error;
        }
    }
    covered.error_over_expanded = (covered.error_over_expanded / (covered.pooled.of.max(1)) as f64).sqrt();
    Ok(covered)
}

/// Of every fresh reading its tenth, and its error over the expanded uncertainty there.
fn errors(trial: &Trial) -> Result<Vec<(usize, f64)>, String> {
    let coefficients = fitted(trial)?;
    let generated = generate(&coefficients, "", &trial.options).map_err(|e| e.to_string())?;
    let (program, lsb) = routine(&generated).ok_or("has no routine")?;
    let budget = &generated.certificate.budgets.first().ok_or("has no budget")?.budget;
    if let Some(missing) = budget.missing.first() {
        return Err(format!("lacks {missing}"));
    }
    let zero = coefficients.identification.as_ref().and_then(|i| i.zero.as_ref());
    let zero = zero.filter(|_| trial.from_zero).map_or(0.0, |zero| zero.alpha0_arcsec);
    let error = |fresh: &Fresh| {
        let words: Vec<Word> =
            [Some(fresh.word), fresh.further].into_iter().flatten().map(Word::Int).collect();
        let outcome = interpret(program, &words).map_err(|e| e.to_string())?;
        let Word::Int(word) = outcome.word else { return Err("returns a float".to_string()) };
        let apart = word as f64 * lsb - (fresh.truth - zero);
        let apart = trial.turn.map_or(apart, |turn| apart - turn * (apart / turn).round());
        Ok((fresh.tenth, apart.abs() / budget.expanded_at(fresh.place)))
    };
    trial.fresh.iter().map(error).collect()
}

/// The fit, as `arcsmith fit` makes it, or `arcsmith diagnose`.
fn fitted(trial: &Trial) -> Result<Coefficients, String> {
    let mirror = Mirror::parse("mirror.toml", &trial.mirror).map_err(|e| e.to_string())?;
    let recording = Recording::from_bytes("calibration.csv", &trial.csv).map_err(|e| e.to_string())?;
    if trial.diagnosed {
        let outcome = diagnosis::diagnose(&recording, &mirror, None, None, &diagnosis::Options::default());
        let outcome = outcome.map_err(|e| e.to_string())?;
        return outcome.coefficients.ok_or_else(|| "has no model".to_string());
    }
    let screened = faults::screen(Cow::Owned(recording), &mirror.sensor).map_err(|e| e.to_string())?;
    let fit = fit(&screened.recording, &mirror, &fitter::Options::default()).map_err(|e| e.to_string())?;
    Ok(fit.coefficients)
}

/// The routine, and what one unit of its result stands for in the budget's unit.
fn routine(generated: &Generated) -> Option<(&Program, f64)> {
    let of_turn = || generated.turn.as_ref().map(|turn| (&turn.program, turn.unit_per_count));
    let first = generated.routines.first().map(|routine| &routine.design);
    first
        .map(|design| (&design.program, design.unit.to_f64() * generated.quantity.bound_units_per_unit))
        .or_else(of_turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twenty devices that cover 95 % give less than 81 % once in a thousand times. That too much is covered, they cannot show.
    #[test]
    fn the_stated_uncertainty_holds_for_some_devices() {
        the_stated_uncertainty_holds(20, 1, 0.81..=1.0);
    }

    /// Eighty devices that cover 95 % give less than 88 % or more than 99.5 % once in a thousand times.
    #[test]
    #[ignore = "takes long: in .ci/full"]
    fn the_stated_uncertainty_holds_for_many_devices() {
        the_stated_uncertainty_holds(80, 3, 0.88..=0.995);
    }

    /// The same as `arcsmith trials budget`, with fewer devices: the share covered is within the scatter of so few.
    fn the_stated_uncertainty_holds(devices: usize, misnamed: usize, covers: std::ops::RangeInclusive<f64>) {
        for kind in Kind::ALL {
            let covered = run(kind, devices, 20_261_124, 2, &()).unwrap();
            // So many at most: one in two hundred diagnoses takes the drift with temperature for another effect.
            let fewest = if kind == Kind::Warmed { devices - misnamed } else { devices };
            assert!(covered.devices.hits >= fewest as u64, "{covered:?}");
            let share = covered.pooled.value().unwrap();
            assert!(covers.contains(&share), "{covered:?}");
        }
    }
}
