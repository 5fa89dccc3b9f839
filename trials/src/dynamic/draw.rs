//! One dynamic trial: a mechanism with effects of the wanted strength concealed in it.

use fitter::plant::{Hold, PlantEffect};
use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::dynamic::effects::{Specification, find};
use twin::dynamic::{Series, Typical};

use super::matched::rms;
use super::nearest_effect::{Scene, positions};
use super::plan::{Assignment, circumstances};
use super::truth::{Concealed, Truth};
use crate::error::CampaignError;
use crate::linear::norm;
use crate::workspace::first_draw;

/// Draws of one assignment before it is given up.
const TRIES: u32 = 40;
/// The least ρ of what is concealed.
pub const LEAST_RHO: f64 = 12.0;
/// Part of an effect's ρ that the others must leave of it; where they take more, two effects are one.
const OWN: f64 = 0.1;

/// A trial with what is needed to record it.
pub struct Trial {
    pub truth: Truth,
    pub series: Series,
}

impl Trial {
    /// Draws a trial.
    ///
    /// # Errors
    /// [`CampaignError::Undrawn`] where no draw can be seen and simulated.
    pub fn draw(assignment: &Assignment, file: &str) -> Result<Self, CampaignError> {
        let draw = |generator: &mut ChaCha12Rng| attempt_one(assignment, file, generator);
        first_draw(TRIES, assignment.seed, assignment.group, draw)
    }
}

fn attempt_one(assignment: &Assignment, file: &str, generator: &mut ChaCha12Rng) -> Option<Trial> {
    let drawn = circumstances(assignment, generator);
    let seed = generator.random();
    let typical = drawn.bench.typical(seed);
    let make = |id: &str, strength: f64, generator: &mut ChaCha12Rng| {
        find(id).map(|specification| drawn_effect(specification, strength, &typical, generator))
    };
    let effects: Vec<PlantEffect> = drawn
        .ids
        .iter()
        .zip(&drawn.strengths)
        .filter_map(|(id, strength)| make(id, *strength, generator))
        .collect();
    let bench = drawn.bench.with_effects(effects.clone()).ok()?;
    let clean = positions(&bench, seed)?;
    let scene = Scene::new(&drawn.bench, &bench, seed, &effects, &clean, &typical)?;
    let concealed = conceal(&scene, generator)?;
    let series = bench.record(seed).ok()?;
    let noise: Vec<f64> = series.positions[0].iter().zip(&clean).map(|(a, b)| a - b).collect();
    let truth = Truth {
        recording: file.to_owned(),
        group: assignment.group,
        noise: drawn.noise.to_owned(),
        excitation: drawn.excitation.to_owned(),
        hold: hold_name(bench.model.hold).to_owned(),
        noise_rms: rms(&noise),
        effects: concealed,
    };
    Some(Trial { truth, series })
}

/// An effect of a strength.
pub fn drawn_effect(
    specification: &Specification,
    strength: f64,
    typical: &Typical,
    generator: &mut ChaCha12Rng,
) -> PlantEffect {
    PlantEffect::new(specification.id, &(specification.draw)(strength, typical, generator))
}

/// What each effect adds and how well it can be seen and told; none where one of them cannot be seen.
fn conceal(scene: &Scene, generator: &mut ChaCha12Rng) -> Option<Vec<Concealed>> {
    let mut concealed = Vec::new();
    for (index, effect) in scene.effects.iter().enumerate() {
        let alone = norm(&scene.nominal().projected_off(scene.white(index)));
        let rest = scene.beside(index).projected_off(scene.white(index));
        let rho = norm(&rest);
        if rho < LEAST_RHO || rho < OWN * alone {
            return None;
        }
        let parameters = effect.parameters.iter().filter_map(|(n, v)| Some((n.clone(), v.get(0)?)));
        concealed.push(Concealed {
            id: effect.id.clone(),
            parameters: parameters.collect(),
            effect_rms: rms(&scene.added[index]),
            rho,
            depends_on: depends_on(&effect.id),
            imitation: scene.closest(index, &rest, generator),
        });
    }
    Some(concealed)
}

/// The variables of which any may rightly be located first.
pub fn depends_on(id: &str) -> Vec<String> {
    find(id).map_or_else(Vec::new, |s| s.depends_on.iter().map(|v| (*v).to_owned()).collect())
}

fn hold_name(hold: Hold) -> &'static str {
    match hold {
        Hold::ZeroOrder => "zero-order",
        Hold::FirstOrder => "first-order",
        Hold::BandLimited => "band-limited",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamic::plan::known_in_free_run;
    use crate::dynamic::truth::Group;
    use twin::dynamic::effects::catalogue;

    fn trial(group: Group, number: usize) -> Trial {
        Trial::draw(&Assignment { group, number, seed: 40 + number as u64 }, "r.csv").unwrap()
    }

    #[test]
    fn a_trial_comes_again_from_its_seed_and_can_be_seen() {
        let one = trial(Group::Pair, 1);
        assert_eq!(one.truth.effects.len(), 2);
        assert!(one.truth.effects.iter().all(|e| e.rho >= LEAST_RHO && e.effect_rms > 0.0));
        let again = trial(Group::Pair, 1);
        assert_eq!((one.truth, one.series), (again.truth, again.series));
    }

    /// A lag before a linear mechanism and one behind it are one and the same.
    #[test]
    fn what_nobody_can_tell_is_known() {
        let mut known = catalogue::ALL.iter().filter(|s| known_in_free_run(s) == Some(true));
        let lag = known.position(|s| s.id == "drive_lag").unwrap();
        let truth = trial(Group::Single, lag).truth;
        assert_eq!(truth.effects[0].id, "drive_lag");
        assert!(!truth.can_tell(), "{truth:?}");
        let friction = trial(Group::Single, 0).truth;
        assert_eq!(friction.effects[0].id, "coulomb_friction");
        assert!(friction.can_tell(), "{friction:?}");
    }
}
