//! One trial: a device with effects of the wanted strengths concealed in it.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::effects::{Scope, catalogue};
use twin::{Device, Injected, Protocol, Reading, calculated_angle_rad, contributions, noise_covariance};

use crate::benchmark::{self, Known};
use crate::error::CampaignError;
use crate::formulas::Columns;
use crate::matched::Metric;
use crate::plan::{Assignment, circumstances};
use crate::truth::{Concealed, Group, Truth};
use crate::workspace::first_draw;

/// Draws of one assignment before it is given up.
const TRIES: u32 = 60;
/// Part of an effect's ρ² that the other effects may take from it; beyond, two effects are one.
const SHARED: f64 = 0.9;

/// A trial with what is needed to record its device again.
pub struct Trial {
    /// What is concealed.
    pub truth: Truth,
    /// The device.
    pub device: Device,
    /// The protocol.
    pub protocol: Protocol,
    /// Seed of the recording.
    pub seed: u64,
    /// Seed of a fresh recording of the same device.
    pub fresh_seed: u64,
}

impl Trial {
    /// Draws a trial.
    ///
    /// # Errors
    /// [`CampaignError::Undrawn`] where no draw has the wanted strength within the ranges of the parameters.
    pub fn draw(assignment: &Assignment, file: String) -> Result<Self, CampaignError> {
        let draw = |generator: &mut ChaCha12Rng| attempt_one(assignment, &file, generator);
        first_draw(TRIES, assignment.seed, assignment.group, draw)
    }

    /// The recording.
    pub fn record(&self) -> Vec<Reading> {
        let feedback = feedback(&self.device);
        twin::record(&self.device, &self.protocol, self.seed, &feedback)
    }

    /// A fresh recording of the same device, in other surroundings and with other noise; what happened in the
    /// time of the first recording only does not happen again.
    pub fn record_fresh(&self) -> Vec<Reading> {
        let device =
            match self.device.with_effects(self.device.effects().filter(|e| stays(e)).cloned().collect()) {
                Ok(device) => device,
                // The same effects were accepted before.
                Err(_) => self.device.clone(),
            };
        let feedback = feedback(&device);
        twin::record(&device, &self.protocol, self.fresh_seed, &feedback)
    }

    /// The true covariance of the noise of the recording.
    pub fn covariance(&self) -> Vec<f64> {
        let feedback = feedback(&self.device);
        let rows = twin::record_with_truth(&self.device, &self.protocol, self.seed, &feedback);
        let truths: Vec<_> = rows.into_iter().map(|(_, truth)| truth).collect();
        noise_covariance(&truths, &self.protocol.noise)
    }

    /// Whether a detector that knows the noise and the formulas finds something in the recording.
    pub fn benchmark(&self) -> Option<bool> {
        let log = twin::record_with_truth(&self.device, &self.protocol, self.seed, &feedback(&self.device));
        let (readings, truths): (Vec<Reading>, Vec<_>) = log.into_iter().unzip();
        let columns = Columns::new(&readings, self.distance_mm());
        let known = Known { truths: &truths, noise: &self.protocol.noise, distance_mm: self.distance_mm() };
        benchmark::detects(&columns, &known, self.fresh_seed)
    }

    /// ρ of what the named effects, whatever their parameters, leave of everything that is concealed.
    pub fn left_by(&self, ids: &[&str]) -> Option<f64> {
        let columns = Columns::new(&self.record(), self.distance_mm());
        let metric = Metric::new(&columns, &self.covariance(), self.distance_mm())?;
        let added = contributions(&self.device, &self.protocol, self.seed, &feedback(&self.device));
        Some(metric.left_by(&columns, &added, ids))
    }

    /// ρ of another error of the reading beside the base model, in arcsec for every row of the recording; none where the
    /// covariance of the noise is not positive definite.
    pub fn rho_of(&self, error_arcsec: &[f64]) -> Option<f64> {
        let columns = Columns::new(&self.record(), self.distance_mm());
        let metric = Metric::new(&columns, &self.covariance(), self.distance_mm())?;
        metric.rho(&[error_arcsec.to_vec()]).first().copied()
    }

    /// ρ of every effect that is concealed, beside the others.
    pub fn rho(&self) -> Option<Vec<f64>> {
        let columns = Columns::new(&self.record(), self.distance_mm());
        let metric = Metric::new(&columns, &self.covariance(), self.distance_mm())?;
        Some(metric.rho(&contributions(&self.device, &self.protocol, self.seed, &feedback(&self.device))))
    }

    /// ρ of what the closest other effect leaves of the first that is concealed; none where no other comes close.
    pub fn left_by_imitation(&self) -> Option<f64> {
        let columns = Columns::new(&self.record(), self.distance_mm());
        let metric = Metric::new(&columns, &self.covariance(), self.distance_mm())?;
        let added = contributions(&self.device, &self.protocol, self.seed, &feedback(&self.device));
        let ids: Vec<&str> = self.device.effects().map(|effect| effect.id.as_str()).collect();
        closest(&metric, &columns, &added, &ids, 0).map(|(_, left)| left)
    }

    /// Distance of the probes in millimetres.
    pub fn distance_mm(&self) -> f64 {
        self.device.geometry.probe_distance_mm
    }
}

fn stays(effect: &Injected) -> bool {
    catalogue::find(&effect.id).is_some_and(|s| s.scope == Scope::Device)
}

/// The controller steers by the calculated angle, as it does before any calibration.
fn feedback(device: &Device) -> impl Fn(f64, f64) -> f64 + use<> {
    let distance_mm = device.geometry.probe_distance_mm;
    move |x1, x2| calculated_angle_rad(x1, x2, distance_mm)
}

fn attempt_one(assignment: &Assignment, file: &str, generator: &mut ChaCha12Rng) -> Option<Trial> {
    let drawn = circumstances(assignment, generator);
    // Probes that match: as drawn, a device leaks some common motion, which nobody concealed.
    let bare = Device::from_seed(generator.random()).with_mismatch(0.0);
    let (seed, fresh_seed) = (generator.random(), generator.random());
    let protocol = drawn.protocol;
    let mut effects: Vec<Injected> = drawn
        .ids
        .iter()
        .filter_map(|id| catalogue::find(id))
        .map(|specification| twin::effects::draw(specification, &protocol, generator))
        .collect();
    let step_sigmas = 3.6 * (2.2f64).powf(generator.random::<f64>());
    let mut device = bare.with_effects(effects.clone()).ok()?;
    protocol.suits(&device).ok()?;
    let feedback = feedback(&device);
    let log = twin::record_with_truth(&device, &protocol, seed, &feedback);
    let (readings, truths): (Vec<Reading>, Vec<_>) = log.into_iter().unzip();
    let square: f64 = truths.iter().map(|t| t.noise_arcsec().powi(2)).sum();
    let noise_arcsec = (square / truths.len() as f64).sqrt();
    let mut concealed = Vec::new();
    if !effects.is_empty() {
        let distance_mm = device.geometry.probe_distance_mm;
        let columns = Columns::new(&readings, distance_mm);
        let metric = Metric::new(&columns, &noise_covariance(&truths, &protocol.noise), distance_mm)?;
        // Nearly everything is proportional to its strength: the second round settles the rest.
        let mut rho = Vec::new();
        let mut added = Vec::new();
        for round in 0..3 {
            added = contributions(&device, &protocol, seed, &feedback);
            rho = metric.rho(&added);
            // What any detector sees of effects that are one is what each of them is alone.
            if assignment.group == Group::Twice {
                rho = metric.rho_alone(&added);
            } else if round == 0 && several_are_one(&rho, &metric.rho_alone(&added)) {
                return None;
            }
            if round == 2 {
                break;
            }
            for ((effect, now), wanted) in effects.iter_mut().zip(&rho).zip(&drawn.rho) {
                let factor = match assignment.group {
                    Group::Step if round == 0 => step_sigmas * noise_arcsec,
                    Group::Step => 1.0,
                    _ => wanted / now,
                };
                *effect = effect.scaled(factor);
            }
            device = bare.with_effects(effects.clone()).ok()?;
        }
        let reached = |(rho, wanted): (&f64, &f64)| (rho / wanted - 1.0).abs() < 0.02;
        if assignment.group != Group::Step && !rho.iter().zip(&drawn.rho).all(reached) {
            return None;
        }
        let imitated = |index: usize| match assignment.group {
            Group::Weak | Group::Ambiguous | Group::Interval | Group::Twice => None,
            _ => closest(&metric, &columns, &added, &drawn.ids, index),
        };
        for (index, effect) in effects.iter().enumerate() {
            concealed.push(Concealed {
                id: effect.id.clone(),
                parameters: effect.parameters.clone(),
                rho: rho[index],
                depends_on: depends_on(&effect.id),
                imitation: imitated(index),
                step_window_s: step_window_s(effect.parameters.get("time_s").copied(), &columns.t_s),
            });
        }
    }
    let truth = Truth {
        recording: file.to_owned(),
        group: assignment.group,
        family: drawn.family.to_owned(),
        schedule: drawn.schedule.to_owned(),
        temperature: drawn.temperature.to_owned(),
        noise_arcsec,
        effects: concealed,
        fresh_is_fair: true,
    };
    Some(Trial { truth, device, protocol, seed, fresh_seed })
}

/// The effect of the table that comes nearest to one of the concealed, beside the others or in its place, and what it
/// leaves of it.
fn closest(
    metric: &Metric,
    columns: &Columns,
    added: &[Vec<f64>],
    ids: &[&str],
    index: usize,
) -> Option<(String, f64)> {
    [metric.closest_imitation(columns, added, ids, index), metric.without(columns, added, ids, index)]
        .into_iter()
        .flatten()
        .min_by(|a, b| a.rho_left.total_cmp(&b.rho_left))
        .map(|nearest| (nearest.id, nearest.rho_left))
}

fn several_are_one(rho: &[f64], alone: &[f64]) -> bool {
    rho.iter().zip(alone).any(|(rho, alone)| rho * rho < (1.0 - SHARED) * alone * alone)
}

/// The variables of which any may rightly be located first.
pub fn depends_on(id: &str) -> Vec<String> {
    catalogue::find(id).map_or_else(Vec::new, |s| s.depends_on.iter().map(|v| (*v).to_owned()).collect())
}

/// The times between which a step is placed to within one row.
pub fn step_window_s(time_s: Option<f64>, t_s: &[f64]) -> Option<[f64; 2]> {
    let time_s = time_s?;
    let first = t_s.iter().position(|t| *t >= time_s)?;
    let before = first.checked_sub(2).map_or(-1.0, |row| t_s[row]);
    Some([before, t_s.get(first + 1).copied().unwrap_or(f64::MAX)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Counts, assignments};

    #[test]
    fn a_trial_has_the_strength_that_was_wanted_and_comes_again_from_its_seed() {
        for assignment in assignments(&Counts { trials: 20, ..Counts::default() }, 4)
            .iter()
            .filter(|a| a.group == Group::Pair)
        {
            let trial = Trial::draw(assignment, "r.csv".to_owned()).unwrap();
            assert_eq!(trial.truth.effects.len(), 2);
            assert!(trial.truth.effects.iter().all(|e| (8.0..31.0).contains(&e.rho)));
            let again = Trial::draw(assignment, "r.csv".to_owned()).unwrap();
            assert_eq!(trial.truth, again.truth);
            assert_eq!(trial.record(), again.record());
            assert_ne!(trial.record(), trial.record_fresh());
        }
    }

    /// A drift and a warm-up together are very nearly another warm-up.
    #[test]
    fn effects_that_do_without_one_of_them_cannot_be_told() {
        let drift = Injected::new("time_drift", [("rate_arcsec_per_h", 3.0)]);
        let warm = Injected::new("warmup_drift", [("amplitude_arcsec", 3.0), ("time_constant_s", 200.0)]);
        let device = Device::from_seed(1).with_mismatch(0.0).with_effects(vec![drift, warm]).unwrap();
        let protocol = Protocol::calibration();
        let feedback = feedback(&device);
        let log = twin::record_with_truth(&device, &protocol, 1, &feedback);
        let (readings, truths): (Vec<Reading>, Vec<_>) = log.into_iter().unzip();
        let columns = Columns::new(&readings, 12.0);
        let metric = Metric::new(&columns, &noise_covariance(&truths, &protocol.noise), 12.0).unwrap();
        let added = contributions(&device, &protocol, 1, &feedback);
        let ids = ["time_drift", "warmup_drift"];
        let without_drift = metric.without(&columns, &added, &ids, 0).unwrap().rho_left;
        let without_warm = metric.without(&columns, &added, &ids, 1).unwrap().rho_left;
        // A drift alone cannot bend; a slower warm-up nearly can be both.
        assert!(without_drift < 4.1 && without_drift < 0.3 * without_warm, "{without_drift} {without_warm}");
    }

    #[test]
    fn a_step_is_placed_between_its_neighbours() {
        // The first row after it is that at 3: right are the rows at 2, 3 and 4.
        assert_eq!(step_window_s(Some(2.5), &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), Some([1.0, 4.0]));
    }

    /// ρ of a constant shape in white noise is known: a step in the middle of n rows, h √n / (2σ), but for
    /// what the base model takes of it.
    #[test]
    fn rho_of_a_step_in_white_noise() {
        let effect = Injected::new("mount_step", [("step_arcsec", 1.0), ("time_s", 390.0)]);
        let device = Device::from_seed(1).with_mismatch(0.0).with_effects(vec![effect]).unwrap();
        let protocol = Protocol::calibration();
        let feedback = feedback(&device);
        let log = twin::record_with_truth(&device, &protocol, 1, &feedback);
        let (readings, truths): (Vec<Reading>, Vec<_>) = log.into_iter().unzip();
        let columns = Columns::new(&readings, 12.0);
        let metric = Metric::new(&columns, &noise_covariance(&truths, &protocol.noise), 12.0).unwrap();
        let rho = metric.rho(&contributions(&device, &protocol, 1, &feedback))[0];
        let noise = truths[0].noise_arcsec();
        let wanted = 210f64.sqrt() / 2.0 / noise;
        assert!((rho / wanted - 1.0).abs() < 0.05, "{rho} for {wanted}");
    }

    /// The physics of `twin` and the formulas of the table are written independently: where they agree, either
    /// is checked by the other, and a model that knows the effects can come down to the noise.
    #[test]
    fn what_was_concealed_is_what_the_table_says() {
        for number in 0..15 {
            let assignment =
                Assignment { group: Group::Strong, number, seed: 77 + number as u64, cell: None };
            let trial = Trial::draw(&assignment, "r.csv".to_owned()).unwrap();
            let columns = Columns::new(&trial.record(), 12.0);
            let metric = Metric::new(&columns, &trial.covariance(), 12.0).unwrap();
            let feedback = feedback(&trial.device);
            let added = contributions(&trial.device, &trial.protocol, trial.seed, &feedback);
            let left = metric.left_by(&columns, &added[..1], &[&trial.truth.effects[0].id]);
            let part = left / trial.truth.effects[0].rho;
            // What remains is mostly the noise of the logged observable.
            assert!(part < 0.2, "{:?}: {part}", trial.truth);
        }
    }
}
