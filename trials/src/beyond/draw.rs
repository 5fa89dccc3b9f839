//! One recording: a device with physics of the wanted strength concealed in it, and a fresh recording of it.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};

use super::lab::Lab;
use super::mirror::{self, Mirror};
use super::motion;
use super::oracle;
use super::plan::{Assignment, Condition, Device};
use super::sensor::{self, Sensor};
use crate::error::CampaignError;
use crate::linear::deviation;
use crate::workspace::first_draw;

/// Draws of one assignment before it is given up.
const TRIES: u32 = 40;

/// What was concealed in one recording.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Truth {
    pub recording: String,
    pub device: Device,
    /// The kind; none of a null.
    pub kind: Option<String>,
    /// Whether it is an effect of the catalogue that was left out there.
    pub left_out: bool,
    /// Whether a fresh recording of the device shows it again.
    pub lasts: bool,
    pub family: String,
    pub condition: Condition,
    /// ρ, counted against the white part of noise that lasts.
    pub rho: f64,
    /// The amplitude, and the numbers that shape it.
    pub strength: f64,
    pub shape: Vec<f64>,
    /// The variables that carry it.
    pub depends_on: Vec<String>,
    /// Standard deviation of the noise, in the unit of the reading.
    pub noise: f64,
    pub rows: usize,
}

/// A recording and what is needed to score what is said of it.
pub struct Drawn {
    pub truth: Truth,
    pub seen: Lab,
    pub fresh: Lab,
    /// Mean square of what the base alone leaves of the fresh recording, where no program is asked for it.
    pub base: Option<f64>,
    /// Mean square of what an oracle leaves of the fresh recording.
    pub oracle: f64,
}

impl Drawn {
    /// Draws a recording.
    ///
    /// # Errors
    /// [`CampaignError::Undrawn`] where no draw can be seen.
    pub fn draw(assignment: &Assignment, file: String) -> Result<Self, CampaignError> {
        let id = assignment.concealed.map_or("null", |kind| kind.id);
        let draw = |generator: &mut ChaCha12Rng| attempt(assignment, &file, generator);
        // Some conditions leave nothing of some physics; then the recording is a plain one.
        let plain = Assignment { condition: Condition::Plain, ..*assignment };
        first_draw(TRIES, assignment.seed, id, draw)
            .or_else(|_| first_draw(TRIES, assignment.seed, id, |g| attempt(&plain, &file, g)))
    }

    /// The recordings as CSV, the fresh one last.
    pub fn csv(&self) -> [String; 2] {
        let decimals = match self.truth.device {
            Device::Mirror => mirror::decimals,
            Device::Sensor => sensor::decimals,
            Device::Motion => motion::decimals,
        };
        [&self.seen, &self.fresh].map(|lab| lab.csv(decimals))
    }

    /// The reference of the fresh recording without its noise as CSV, row for row, unrounded.
    pub fn clean_csv(&self) -> String {
        let rows = self.fresh.clean.iter().map(|value| format!("{value}\n"));
        format!("{}\n", self.fresh.reference) + &rows.collect::<String>()
    }
}

/// A device with physics concealed in it, and how it is recorded.
pub trait Made {
    /// The recording, what is concealed being so strong; none where no device can have it that strong.
    fn record(&self, strength: f64) -> Option<Lab>;

    /// The fresh one; what happened in the time of the first alone does not happen again.
    fn record_afresh(&self, strength: f64) -> Option<Lab>;

    /// The numbers that shape what is concealed.
    fn shape(&self) -> Vec<f64>;
}

fn attempt(assignment: &Assignment, file: &str, generator: &mut ChaCha12Rng) -> Option<Drawn> {
    let made: Box<dyn Made> = match assignment.device {
        Device::Mirror => Box::new(Mirror::draw(assignment, generator)),
        Device::Sensor => Box::new(Sensor::draw(assignment, generator)),
        Device::Motion => return motion::attempt(assignment, file, generator),
    };
    let (condition, noise) = (assignment.condition, (assignment.family.noise)());
    let carriers = assignment.concealed.map_or_else(Vec::new, |kind| kind.carriers());
    let falls: ChaCha12Rng = ChaCha12Rng::clone(generator);
    let sign = if generator.random() { 1.0 } else { -1.0 };
    let record = |strength: f64| {
        let mut lab = made.record(strength)?;
        condition.falls_on(&mut lab, &carriers, &mut falls.clone());
        round(&mut lab, assignment.family.step);
        Some(lab)
    };
    // So little that the reading is what it would be without: the units of a strength are those of its kind.
    let mut strength = if assignment.device == Device::Sensor { 1e-9 * sign } else { 1.0 };
    let mut seen = record(strength)?;
    let mut rho = 0.0;
    if assignment.concealed.is_some() {
        // Nearly everything is proportional to its strength: the second round settles the rest.
        for _ in 0..2 {
            strength *= assignment.rho / oracle::rho(&seen, &noise)?;
            seen = record(strength)?;
        }
        rho = oracle::rho(&seen, &noise)?;
    }
    let mut fresh = made.record_afresh(strength)?;
    condition.afresh().falls_on(&mut fresh, &carriers, &mut falls.clone());
    let truth = Truth {
        recording: file.to_owned(),
        device: assignment.device,
        kind: assignment.concealed.map(|kind| kind.id.to_owned()),
        left_out: assignment.concealed.is_some_and(|kind| kind.left_out),
        lasts: assignment.concealed.is_some_and(|kind| kind.lasts),
        family: assignment.family.name.to_owned(),
        condition,
        rho,
        strength,
        shape: made.shape(),
        depends_on: assignment
            .concealed
            .map_or_else(Vec::new, |kind| kind.depends_on.iter().map(|name| (*name).to_owned()).collect()),
        noise: seen.noise,
        rows: seen.rows(),
    };
    let oracle = deviation(&fresh.covered(&seen, &oracle::left(&seen, &fresh))).powi(2);
    Some(Drawn { truth, seen, fresh, base: None, oracle })
}

/// Rounds the reference to steps of so many standard deviations of the noise; not at all where that is 0.
fn round(lab: &mut Lab, step: f64) {
    if step > 0.0 {
        let unit = step * lab.noise;
        lab.change(lab.reference, |values| values.iter_mut().for_each(|v| *v = (*v / unit).round() * unit));
        // Rounding errs evenly over a step.
        lab.noise *= (1.0 + step * step / 12.0).sqrt();
    }
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::beyond::plan::{FAMILIES, kinds};

    fn drawn(index: usize, condition: Condition) -> Drawn {
        let kind = kinds()[index];
        let assignment = Assignment {
            concealed: Some(kind),
            device: kind.device,
            family: FAMILIES[0],
            condition,
            rho: 40.0,
            seed: 70 + index as u64,
        };
        Drawn::draw(&assignment, "r.csv".to_owned()).unwrap()
    }

    /// The recording as it would be without what is concealed, or as if nobody knew of it.
    fn without(lab: &Lab, corrected: bool) -> Lab {
        let less = |m: &f64, e: &f64| if corrected { m - e } else { *m };
        let measured = lab.measured.iter().zip(&lab.effect).map(|(m, e)| less(m, e)).collect();
        Lab { measured, effect: vec![0.0; lab.rows()], ..lab.clone() }
    }

    #[test]
    fn every_kind_has_the_strength_that_was_wanted_and_an_oracle_corrects_it() {
        (0..kinds().len()).into_par_iter().for_each(|index| {
            let drawn = drawn(index, Condition::Plain);
            let (truth, id) = (&drawn.truth, kinds()[index].id);
            if let Some(base) = drawn.base {
                // Nine tenths of what there is beside nothing at all.
                assert!(drawn.oracle < 0.1 * base && truth.rho >= 12.0, "{id}: {} of {base}", drawn.oracle);
                return;
            }
            assert!((truth.rho / 40.0 - 1.0).abs() < 0.05, "{id}: ρ {}", truth.rho);
            if !truth.lasts {
                return;
            }
            let left = |corrected: bool| {
                let of = [&drawn.seen, &drawn.fresh].map(|lab| without(lab, corrected));
                deviation(&oracle::left(&of[0], &of[1])).powi(2)
            };
            let (base, floor) = (left(false), left(true));
            let gain = (base - drawn.oracle) / (base - floor);
            assert!(gain > 0.9, "{id}: {gain} of what there is, from {base} by {} to {floor}", drawn.oracle);
        });
    }

    #[test]
    fn a_recording_comes_again_from_its_seed_and_its_condition_shows() {
        let humid = kinds().iter().position(|kind| kind.id == "ooc_swelling").unwrap();
        let plain = drawn(humid, Condition::Plain);
        assert_eq!(plain.csv(), drawn(humid, Condition::Plain).csv());
        assert!(!plain.seen.column("humidity_pct").is_empty());
        let missing = drawn(humid, Condition::ColumnsMissing);
        assert!(
            missing.seen.column("humidity_pct").is_empty() && missing.fresh.column("humidity_pct").is_empty()
        );
        let forward = drawn(humid, Condition::ForwardOnly);
        assert!(forward.seen.column("direction").iter().all(|direction| *direction > 0.0));
        let changes = |drawn: &Drawn| {
            let temperature_c = drawn.seen.column("temperature_c");
            temperature_c.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64
                / temperature_c.len() as f64
        };
        assert!(changes(&plain) > 0.9 && changes(&drawn(humid, Condition::ThermometerHeld)) < 0.1);
        let rows = |condition| drawn(humid, condition).truth.rows;
        assert!(rows(Condition::FewRows) < 130 && rows(Condition::ManyRows) > 1000);
        assert!(rows(Condition::UnequalPasses) < plain.truth.rows);
    }
}
