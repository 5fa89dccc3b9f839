//! Which dynamic trials there are, and in which circumstances.

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use twin::Noise;
use twin::dynamic::effects::{Specification, catalogue};
use twin::dynamic::{Bench, Excitation};

use super::truth::Group;

/// What part of the trials each group gets.
const PARTS: [(Group, f64); 4] =
    [(Group::Null, 0.2), (Group::Single, 0.44), (Group::Pair, 0.2), (Group::Outside, 0.16)];

/// A trial that is to be drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assignment {
    pub group: Group,
    pub number: usize,
    /// Seed of everything about it.
    pub seed: u64,
}

pub fn assignments(trials: usize, seed: u64) -> Vec<Assignment> {
    let mut seeds = ChaCha12Rng::seed_from_u64(seed);
    let mut list = Vec::new();
    for (group, part) in PARTS {
        let count = (part * trials as f64).round() as usize;
        list.extend((0..count).map(|number| Assignment { group, number, seed: seeds.random() }));
    }
    list
}

/// The circumstances of one trial.
pub struct Circumstances {
    /// Ids to conceal.
    pub ids: Vec<&'static str>,
    /// How strong each is: about its part of the drive's force.
    pub strengths: Vec<f64>,
    /// Name of the noise family.
    pub noise: &'static str,
    /// Name of the excitation.
    pub excitation: &'static str,
    /// The mechanism without effects.
    pub bench: Bench,
}

/// Draws the circumstances of an assignment.
pub fn circumstances(assignment: &Assignment, generator: &mut ChaCha12Rng) -> Circumstances {
    let ids = ids(assignment.group, assignment.number, generator);
    let bench = Bench::from_seed(generator.random());
    let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
    let strengths = ids.iter().map(|_| uniform(0.01f64.ln(), 0.1f64.ln()).exp()).collect();
    let (noise, kind) = match uniform(0.0, 1.0) {
        u if u < 0.6 => ("white", Noise::White),
        _ => ("coloured", Noise::Autocorrelated { correlation_time_s: uniform(1e-3, 4e-3) }),
    };
    let highest_hz = 120.0;
    let (excitation, bench) = match uniform(0.0, 1.0) {
        u if u < 0.5 => ("multisine", bench),
        u if u < 0.75 => {
            let excitation = Excitation::Multisine { highest_hz, odd: true };
            ("periodic odd multisine", Bench { excitation, samples: 8192, periods: Some(2), ..bench })
        }
        u if u < 0.9 => {
            let excitation = Excitation::Sweep { lowest_hz: 2.0, highest_hz };
            ("sweep", Bench { excitation, ..bench })
        }
        _ => ("steps", Bench { excitation: Excitation::Steps { hold_s: 0.05 }, ..bench }),
    };
    Circumstances { ids, strengths, noise, excitation, bench: Bench { noise: kind, ..bench } }
}

fn ids(group: Group, number: usize, generator: &mut ChaCha12Rng) -> Vec<&'static str> {
    let of = |known: bool| -> Vec<&'static str> {
        catalogue::ALL.iter().filter(|s| known_in_free_run(s) == Some(known)).map(|s| s.id).collect()
    };
    match group {
        Group::Null => Vec::new(),
        // In turn, so that each effect has its share.
        Group::Single => vec![of(true)[number % of(true).len()]],
        Group::Pair => of(true).sample(generator, 2).copied().collect(),
        Group::Outside => vec![of(false)[number % of(false).len()]],
    }
}

/// Whether the diagnosis of free runs has an effect in its catalogue; friction at one place it has under feedback alone. None
/// where an effect makes no sense in these mechanisms: friction beyond a play takes from a friction that they do not have.
pub(super) fn known_in_free_run(effect: &Specification) -> Option<bool> {
    match effect.id {
        "backlash" => None,
        "local_friction" => Some(false),
        _ => Some(effect.catalogued()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_its_trials() {
        let list = assignments(500, 1);
        assert_eq!(list.len(), 500);
        let mut generator = ChaCha12Rng::seed_from_u64(1);
        for specification in catalogue::ALL {
            let Some(known) = known_in_free_run(specification) else { continue };
            let group = if known { Group::Single } else { Group::Outside };
            let count = list
                .iter()
                .filter(|a| a.group == group)
                .filter(|a| ids(group, a.number, &mut generator) == [specification.id])
                .count();
            assert!(count >= 10, "{}: {count}", specification.id);
        }
    }
}
