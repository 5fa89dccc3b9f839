//! Which trials there are: how many of each group, and in which circumstances.

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use twin::effects::catalogue;
use twin::{Noise, Protocol, Temperature};

use crate::truth::Group;

/// A noise family: its name, and its noise.
pub type Family = (&'static str, fn() -> Noise);

/// The noise families.
pub const FAMILIES: [Family; 4] = [
    ("white", || Noise::White),
    ("autocorrelated", Noise::autocorrelated),
    ("heteroscedastic", Noise::heteroscedastic),
    ("outliers", Noise::outliers),
];

/// The groups of trials with something concealed, and what part of the trials each gets.
const PARTS: [(Group, f64); 7] = [
    (Group::Weak, 0.24),
    (Group::Strong, 0.30),
    (Group::Step, 0.05),
    (Group::Pair, 0.14),
    (Group::Triple, 0.10),
    (Group::Ambiguous, 0.05),
    (Group::Outside, 0.12),
];

/// A schedule: its name, and its protocol.
pub type Schedule = (&'static str, fn() -> Protocol);

/// The schedules.
pub const SCHEDULES: [Schedule; 5] = [
    ("calibration", Protocol::calibration),
    ("coarse", Protocol::coarse),
    ("fine", Protocol::fine),
    ("random", Protocol::random),
    ("scan", Protocol::scan),
];

/// An effect in a schedule.
pub type Cell = (&'static str, &'static str);

/// Every catalogued effect in every schedule that can show it.
pub fn cells() -> Vec<Cell> {
    let catalogued = catalogue::ALL.iter().filter(|s| s.catalogued()).map(|s| s.id);
    let shown = |id: &str, schedule: &str| id != "read_lag" || schedule == "scan";
    catalogued
        .flat_map(|id| SCHEDULES.iter().map(move |(schedule, _)| (id, *schedule)))
        .filter(|(id, schedule)| shown(id, schedule))
        .collect()
}

/// A trial that is to be drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assignment {
    /// The group.
    pub group: Group,
    /// Its number within the group.
    pub number: usize,
    /// Seed of everything about it.
    pub seed: u64,
    /// What is concealed and how it is recorded, where that is not drawn.
    pub cell: Option<Cell>,
}

/// How many trials of each kind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Counts {
    /// With something concealed.
    pub trials: usize,
    /// With nothing, of each noise family.
    pub nulls: usize,
    /// For the intervals, of each effect in each schedule.
    pub intervals: usize,
    /// The effects whose intervals are looked at; all where empty.
    pub only: Vec<String>,
    /// Devices that are recorded twice.
    pub twice: usize,
    /// Whether each effect is left out of the catalogue in turn.
    pub without: bool,
}

/// All trials.
pub fn assignments(counts: &Counts, seed: u64) -> Vec<Assignment> {
    let mut seeds = ChaCha12Rng::seed_from_u64(seed);
    let mut list = Vec::new();
    let mut push = |group, count: usize, cell| {
        list.extend((0..count).map(|number| Assignment { group, number, seed: seeds.random(), cell }));
    };
    push(Group::Null, counts.nulls * FAMILIES.len(), None);
    for (group, part) in PARTS {
        push(group, (part * counts.trials as f64).round() as usize, None);
    }
    let wanted = |cell: &Cell| counts.only.is_empty() || counts.only.iter().any(|id| id == cell.0);
    for cell in cells().into_iter().filter(wanted) {
        push(Group::Interval, counts.intervals, Some(cell));
    }
    push(Group::Twice, counts.twice, None);
    list
}

/// The circumstances of one trial.
pub struct Circumstances {
    /// Ids to conceal.
    pub ids: Vec<&'static str>,
    /// ρ wanted of each.
    pub rho: Vec<f64>,
    /// Name of the noise family.
    pub family: &'static str,
    /// Name of the schedule.
    pub schedule: &'static str,
    /// Name of what the temperature does.
    pub temperature: &'static str,
    /// All of that as a protocol.
    pub protocol: Protocol,
}

/// Draws the circumstances of an assignment.
pub fn circumstances(assignment: &Assignment, generator: &mut ChaCha12Rng) -> Circumstances {
    let number = assignment.number;
    let ids = match assignment.cell {
        Some((id, _)) => vec![id],
        None => ids(assignment.group, number, generator),
    };
    let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
    let rho = ids
        .iter()
        .map(|_| match assignment.group {
            Group::Weak => uniform(0.5, 8.5),
            Group::Twice => uniform(1f64.ln(), 40f64.ln()).exp(),
            Group::Pair | Group::Triple => uniform(8.2f64.ln(), 30f64.ln()).exp(),
            _ => uniform(8.2f64.ln(), 40f64.ln()).exp(),
        })
        .collect();
    // Nulls take the families in turn, so that each has its number.
    let family = match assignment.group {
        Group::Null => FAMILIES[number % FAMILIES.len()],
        _ => FAMILIES[uniform(0.0, 4.0) as usize % 4],
    };
    let moves = ids.contains(&"read_lag");
    let schedule = match uniform(0.0, 1.0) {
        _ if let Some((_, schedule)) = assignment.cell => schedule,
        _ if moves => "scan",
        u if u < 0.3 => "calibration",
        u if u < 0.55 => "coarse",
        u if u < 0.8 => "fine",
        u if u < 0.9 => "random",
        _ => "scan",
    };
    let thermal =
        ids.iter().any(|id| catalogue::find(id).is_some_and(|s| s.depends_on.contains(&"temperature_c")));
    let temperature = match (assignment.group, uniform(0.0, 1.0)) {
        (Group::Ambiguous, _) => "ramp",
        (Group::Null, u) if u > 0.85 => "ramp",
        (_, u) if thermal && u < 0.6 => "chamber",
        (_, u) if thermal && u < 0.85 => "levels",
        (_, u) if u < 0.25 => "chamber",
        (_, u) if u < 0.35 => "levels",
        _ => "laboratory",
    };
    let protocol = Protocol {
        noise: family.1(),
        temperature: match temperature {
            "ramp" => Temperature::ramp(),
            "chamber" => Temperature::chamber(),
            "levels" => Temperature::levels(),
            _ => Temperature::Laboratory,
        },
        ..SCHEDULES.iter().find(|s| s.0 == schedule).map_or_else(Protocol::calibration, |s| s.1())
    };
    Circumstances { ids, rho, family: family.0, schedule, temperature, protocol }
}

fn ids(group: Group, number: usize, generator: &mut ChaCha12Rng) -> Vec<&'static str> {
    let catalogued: Vec<&'static str> =
        catalogue::ALL.iter().filter(|s| s.catalogued()).map(|s| s.id).collect();
    let outside: Vec<&'static str> =
        catalogue::ALL.iter().filter(|s| !s.catalogued()).map(|s| s.id).collect();
    let several = |count, generator: &mut ChaCha12Rng| catalogued.sample(generator, count).copied().collect();
    match group {
        Group::Null => Vec::new(),
        // In turn, so that each effect has its share.
        Group::Weak | Group::Strong | Group::Interval => vec![catalogued[number % catalogued.len()]],
        Group::Step => vec!["mount_step"],
        Group::Pair => several(2, generator),
        Group::Triple => several(3, generator),
        Group::Twice => several(1 + number % 3, generator),
        Group::Ambiguous => vec![["thermal_zero_drift", "time_drift"][number % 2]],
        Group::Outside => vec![outside[number % outside.len()]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_has_its_nulls_and_every_effect_its_trials() {
        let list = assignments(&Counts { trials: 1000, nulls: 7, ..Counts::default() }, 1);
        assert_eq!(list.iter().filter(|a| a.group == Group::Null).count(), 28);
        assert_eq!(list.len(), 1028);
        let strong: Vec<&Assignment> = list.iter().filter(|a| a.group == Group::Strong).collect();
        let mut generator = ChaCha12Rng::seed_from_u64(1);
        for id in catalogue::ALL.iter().filter(|s| s.catalogued()).map(|s| s.id) {
            let count = strong.iter().filter(|a| circumstances(a, &mut generator).ids == [id]).count();
            assert_eq!(count, 20, "{id}");
        }
    }

    #[test]
    fn a_lag_is_read_in_motion_and_the_ambiguous_have_a_ramp() {
        let mut generator = ChaCha12Rng::seed_from_u64(2);
        for assignment in assignments(&Counts { trials: 500, ..Counts::default() }, 3) {
            let drawn = circumstances(&assignment, &mut generator);
            assert!(!drawn.ids.contains(&"read_lag") || drawn.schedule == "scan");
            assert_eq!(assignment.group == Group::Ambiguous, drawn.temperature == "ramp");
        }
    }

    #[test]
    fn every_effect_has_its_intervals_in_every_schedule_that_shows_it() {
        let counts =
            Counts { intervals: 3, only: vec!["read_lag".into(), "backlash".into()], ..Counts::default() };
        let mut generator = ChaCha12Rng::seed_from_u64(4);
        let list = assignments(&counts, 5);
        assert_eq!(list.len(), 3 * (1 + SCHEDULES.len()));
        for assignment in list {
            let drawn = circumstances(&assignment, &mut generator);
            assert_eq!(assignment.cell, Some((drawn.ids[0], drawn.schedule)));
            assert!(drawn.rho[0] >= 8.0);
        }
    }
}
