//! Which recordings there are: kinds, noise, conditions.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use twin::Noise;
use twin::effects::{Scope, catalogue};

use super::lab::Lab;

/// Which device is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Device {
    /// The scanning mirror.
    Mirror,
    /// The position sensor.
    Sensor,
    /// A mechanism in motion.
    Motion,
}

/// A kind of noise.
#[derive(Debug, Clone, Copy)]
pub struct Family {
    /// Its name.
    pub name: &'static str,
    /// The noise.
    pub noise: fn() -> Noise,
    /// The step that the reference is rounded to, in standard deviations of the noise; 0 where it is not.
    pub step: f64,
}

const fn family(name: &'static str, noise: fn() -> Noise) -> Family {
    Family { name, noise, step: 0.0 }
}

/// The families. The first four are forgotten from reading to reading, the others last.
pub const FAMILIES: [Family; 8] = [
    family("white", || Noise::White),
    family("heavy-tailed", Noise::outliers),
    family("correlated", Noise::autocorrelated),
    Family { name: "quantised", noise: || Noise::White, step: 2.0 },
    family("flicker", || Noise::Flicker),
    family("random walk", || Noise::RandomWalk),
    family("popcorn", || Noise::Popcorn),
    family("bursts", || Noise::Bursts),
];
/// White noise, and noise that is correlated over some samples of a motion.
const IN_MOTION: [Family; 2] =
    [FAMILIES[0], family("correlated", || Noise::Autocorrelated { correlation_time_s: 2e-3 })];
/// How many of them are forgotten from reading to reading.
pub const ORDINARY: usize = 4;

/// In what the recording falls short.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// In nothing.
    Plain,
    /// The columns that carry the effect are not recorded.
    ColumnsMissing,
    /// The thermometer is read once a minute, and its reading held.
    ThermometerHeld,
    /// The positions of a pass come in random order.
    RandomOrder,
    /// Passes begin and end where they like.
    UnequalPasses,
    /// The way back is not recorded.
    ForwardOnly,
    /// About a hundred.
    FewRows,
    /// More than a thousand.
    ManyRows,
}

/// All conditions.
pub const CONDITIONS: [Condition; 8] = [
    Condition::Plain,
    Condition::ColumnsMissing,
    Condition::ThermometerHeld,
    Condition::RandomOrder,
    Condition::UnequalPasses,
    Condition::ForwardOnly,
    Condition::FewRows,
    Condition::ManyRows,
];

impl Condition {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::ColumnsMissing => "columns missing",
            Self::ThermometerHeld => "thermometer held",
            Self::RandomOrder => "random order",
            Self::UnequalPasses => "unequal passes",
            Self::ForwardOnly => "forward only",
            Self::FewRows => "few rows",
            Self::ManyRows => "many rows",
        }
    }

    /// In what a fresh recording of the device falls short for the sake of this one: what is not recorded then is not
    /// to be corrected.
    pub fn afresh(self) -> Self {
        if matches!(self, Self::ColumnsMissing | Self::ForwardOnly) { self } else { Self::Plain }
    }

    /// What it makes of a recording; the schedule has seen to order and number of rows already.
    pub fn falls_on(self, lab: &mut Lab, carriers: &[&str], generator: &mut ChaCha12Rng) {
        match self {
            Self::ColumnsMissing => lab.columns.retain(|(name, _)| !carriers.contains(&name.as_str())),
            Self::ThermometerHeld => {
                let t_s = lab.column("t_s").to_vec();
                lab.change("temperature_c", |temperature_c| {
                    let mut held = 0;
                    for row in 0..temperature_c.len() {
                        if t_s[row] - t_s[held] >= 60.0 {
                            held = row;
                        }
                        temperature_c[row] = temperature_c[held];
                    }
                });
            }
            Self::UnequalPasses => {
                let ends = lab.measured.iter().fold(0.0, |most: f64, m| most.max(m.abs()));
                let passes = lab.column("pass").to_vec();
                let mut limits = std::collections::BTreeMap::new();
                let mut inside = |row: usize| {
                    let mut end = || ends * (1.1 - generator.random_range(0.0f64..1.0).powi(2));
                    let (low, high) = *limits.entry(passes[row] as i64).or_insert_with(|| (-end(), end()));
                    (low..=high).contains(&lab.measured[row])
                };
                let kept: Vec<bool> = (0..lab.rows()).map(&mut inside).collect();
                lab.keep(&kept);
            }
            Self::ForwardOnly => {
                let kept: Vec<bool> = lab.column("direction").iter().map(|d| *d > 0.0).collect();
                lab.keep(&kept);
            }
            Self::Plain | Self::RandomOrder | Self::FewRows | Self::ManyRows => {}
        }
    }
}

/// What is concealed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Concealable {
    /// Its id.
    pub id: &'static str,
    /// The device that has it.
    pub device: Device,
    /// Whether a fresh recording of the device shows it again.
    pub lasts: bool,
    /// The variables that carry it.
    pub depends_on: &'static [&'static str],
    /// Whether the catalogue has it, and it is left out there.
    pub left_out: bool,
}

/// Variables that every recording holds.
const ALWAYS: [&str; 8] =
    ["t_s", "pass", "direction", "history", "angle_deg", "command_deg", "position_mm", "common_mode_um"];

impl Concealable {
    /// The recorded columns that carry it, those apart without which there is no recording.
    pub fn carriers(&self) -> Vec<&'static str> {
        let further = |name: &&str| !ALWAYS.contains(name);
        self.depends_on.iter().copied().filter(further).collect()
    }
}

/// All kinds that can be concealed: those outside the catalogue, and the catalogue's own, to be left out of it.
pub fn kinds() -> Vec<Concealable> {
    let of = |device, id, depends_on| Concealable { id, device, lasts: true, depends_on, left_out: false };
    let mirror = catalogue::ALL.iter().map(move |s| Concealable {
        lasts: s.scope == Scope::Device,
        left_out: s.catalogued(),
        ..of(Device::Mirror, s.id, s.depends_on)
    });
    let sensor =
        twin::sensor::ALL.into_iter().flatten().map(move |kind| of(Device::Sensor, kind.id, kind.depends_on));
    let motion = twin::dynamic::rig::ALL.iter().map(move |kind| of(Device::Motion, kind.id, kind.depends_on));
    sensor.chain(mirror).chain(motion).collect()
}

/// A recording that is to be drawn.
#[derive(Debug, Clone, Copy)]
pub struct Assignment {
    /// What is concealed; nothing in a null.
    pub concealed: Option<Concealable>,
    /// The device.
    pub device: Device,
    /// The noise.
    pub family: Family,
    /// In what it falls short.
    pub condition: Condition,
    /// ρ that is wanted.
    pub rho: f64,
    /// Seed of everything about it.
    pub seed: u64,
}

/// What is asked for.
#[derive(Debug, Clone, Default)]
pub struct Counts {
    /// Recordings of each kind that the catalogue lacks.
    pub trials: usize,
    /// Recordings of each kind in motion.
    pub motion: usize,
    /// Recordings of each effect of the catalogue, which is left out of it.
    pub left_out: usize,
    /// Recordings of nothing in each noise family.
    pub nulls: usize,
    /// The kinds that are concealed; all where empty.
    pub kinds: Vec<String>,
}

/// Least and largest ρ, drawn evenly in the logarithm.
const RHO: [f64; 2] = [8.0, 60.0];
/// Part of the recordings in noise that is forgotten from reading to reading.
const FORGOTTEN: f64 = 0.8;
/// Part of the recordings that fall short in nothing.
const PLAIN: f64 = 0.4;

/// All recordings.
pub fn assignments(counts: &Counts, seed: u64) -> Vec<Assignment> {
    let mut seeds = ChaCha12Rng::seed_from_u64(seed);
    let mut list = Vec::new();
    let wanted = |kind: &Concealable| counts.kinds.is_empty() || counts.kinds.iter().any(|id| id == kind.id);
    for kind in kinds().into_iter().filter(wanted) {
        let count = match kind.device {
            Device::Motion => counts.motion,
            _ if kind.left_out => counts.left_out,
            _ => counts.trials,
        };
        for _ in 0..count {
            list.push(assigned(Some(kind), kind.device, None, seeds.random()));
        }
    }
    for family in FAMILIES {
        for number in 0..counts.nulls {
            let device = if number % 2 == 0 { Device::Sensor } else { Device::Mirror };
            list.push(assigned(None, device, Some(family), seeds.random()));
        }
    }
    list
}

fn assigned(concealed: Option<Concealable>, device: Device, family: Option<Family>, seed: u64) -> Assignment {
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
    let rho = uniform(RHO[0].ln(), RHO[1].ln()).exp();
    let (from, to) = match uniform(0.0, 1.0) < FORGOTTEN {
        true => (0, ORDINARY),
        false => (ORDINARY, FAMILIES.len()),
    };
    let drawn = match (device, uniform(0.0, 1.0)) {
        (Device::Motion, part) => IN_MOTION[usize::from(part > 0.6)],
        (_, part) => FAMILIES[from + (part * (to - from) as f64) as usize],
    };
    let condition = match uniform(0.0, 1.0) < PLAIN {
        true => Condition::Plain,
        false => CONDITIONS[uniform(1.0, CONDITIONS.len() as f64) as usize],
    };
    // Where no column carries it none can be missing.
    let carried = concealed.is_none_or(|kind| !kind.carriers().is_empty());
    let plain = condition == Condition::ColumnsMissing && !carried;
    let condition = if plain { Condition::Plain } else { condition };
    Assignment { concealed, device, family: family.unwrap_or(drawn), condition, rho, seed }
}
