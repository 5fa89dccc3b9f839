//! Whether a comparison of two recordings says what changed: pairs of recordings of one simulated device are taken in other
//! surroundings, with other noise, another schedule and another zero of the reference; nothing is changed, or one effect is
//! made stronger or weaker, or one comes. The same of mechanisms in motion, and of drives in their position loop.

mod feedback;
mod motion;

use std::path::Path;

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use twin::effects::{Scope, catalogue};
use twin::{Injected, Protocol, write_csv};

use crate::draw::Trial;
use crate::error::CampaignError;
use crate::plan::{Assignment, circumstances};
use crate::programs::{Nominal, Programs};
use crate::score::{Figure, Share};
use crate::truth::{CAN_TELL, Group};
use crate::workspace::{empty_folder, put};

/// By how many joint standard errors an effect's strength moves.
const MOVED_BY: f64 = 6.0;
/// How far a new effect stands out of the noise of both recordings: where the earlier one hardly shows it, that it was not
/// there before is not known either.
const CAME_BY: f64 = 8.0;
/// Draws of one pair before it is left out: not every effect shows in every surrounding.
const TRIES: u64 = 40;

/// What happens between the recordings of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Nothing.
    Same,
    /// An effect becomes stronger or weaker.
    Moved,
    /// An effect comes.
    Came,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Same, Kind::Moved, Kind::Came];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Same => "nothing changed",
            Kind::Moved => "moved",
            Kind::Came => "came",
        }
    }

    /// The folder of its pairs.
    pub fn folder(self) -> &'static str {
        match self {
            Kind::Same => "same",
            Kind::Moved => "moved",
            Kind::Came => "came",
        }
    }
}

/// What is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Of {
    /// Calibrations.
    Calibrations,
    /// A mechanism in motion.
    Motion,
    /// A drive in its position loop.
    Feedback,
}

impl Of {
    /// All of them.
    pub const ALL: [Of; 3] = [Of::Calibrations, Of::Motion, Of::Feedback];

    /// The folder of its pairs.
    pub fn folder(self) -> &'static str {
        match self {
            Of::Calibrations => "calibrations",
            Of::Motion => "motion",
            Of::Feedback => "feedback",
        }
    }
}

/// A pair of recordings.
struct Pair {
    then: String,
    now: String,
    /// The nominal mirror or plant.
    nominal: String,
    /// What changed.
    id: Option<String>,
    /// Whether one of the recordings that have the effect can tell it from every other one.
    can_tell: bool,
}

/// What of a comparison is scored.
#[derive(Deserialize)]
struct Answer {
    changes: Vec<Said>,
}

/// One change that was said.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Said {
    /// What changed.
    pub id: String,
    /// How.
    pub kind: String,
    /// Its family-wise p-value.
    pub p_value: f64,
    /// What else would explain it nearly as well.
    #[serde(default)]
    pub alternatives: Vec<String>,
}

/// The answer to one pair.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The pair's number.
    pub pair: usize,
    /// To which effect something happened.
    pub id: Option<String>,
    /// Whether one of the recordings that have the effect can tell it from every other one.
    pub can_tell: bool,
    /// What was said.
    pub said: Vec<Said>,
}

/// What was measured.
#[derive(Debug, Clone, Serialize)]
pub struct Compared {
    /// What was recorded.
    pub of: Of,
    /// What happened between the recordings.
    pub kind: Kind,
    /// Pairs with a change that was there, or with any where nothing changed.
    pub found: Share,
    /// Pairs in which the change has the right name.
    pub named: Share,
    /// The same of those whose recordings can tell.
    pub distinguishable: Share,
    /// Pairs in which the change has the right name, or one beside which that is listed where no recording can tell.
    pub listed: Share,
    /// Pairs in which nothing else is said to have changed.
    pub alone: Share,
    /// Every pair.
    pub rows: Vec<Row>,
}

impl Compared {
    /// Held against what is wanted.
    pub fn figures(&self) -> Vec<Figure> {
        let kind = match self.of {
            Of::Calibrations => self.kind.name().to_string(),
            Of::Motion => format!("in motion, {}", self.kind.name()),
            Of::Feedback => format!("under feedback, {}", self.kind.name()),
        };
        match self.kind {
            Kind::Same => vec![Figure::at_most(format!("{kind}: alarms"), 0.01, self.found)],
            Kind::Moved | Kind::Came => {
                let named = if self.kind == Kind::Moved { 0.95 } else { 0.97 };
                let distinguishable = format!("{kind}: with the right name, where a recording can tell");
                let mut figures = vec![
                    Figure::at_least(format!("{kind}: found"), named, self.found),
                    Figure::at_least(format!("{kind}: with the right name"), named, self.named),
                ];
                figures.extend(
                    self.distinguishable
                        .value()
                        .map(|_| Figure::reported(distinguishable, self.distinguishable)),
                );
                figures.push(Figure::at_least(
                    format!("{kind}: with the right name, or listed where no recording can tell"),
                    named,
                    self.listed,
                ));
                figures.push(Figure::at_least(
                    format!("{kind}: nothing else said to have changed"),
                    0.95,
                    self.alone,
                ));
                figures
            }
        }
    }
}

/// Compares so many pairs of a kind, each in a folder of its own below `out`.
///
/// # Errors
/// [`CampaignError::Threads`], [`CampaignError::Unstarted`], or that of writing a file.
pub fn run(
    programs: &Programs,
    (of, kind): (Of, Kind),
    pairs: usize,
    seed: u64,
    jobs: usize,
    out: &Path,
) -> Result<Compared, CampaignError> {
    programs.begin(kind.name(), pairs);
    let pool = crate::workspace::threads(jobs)?;
    let one = |number: usize| {
        let Some(pair) = draw(of, kind, number, seed) else { return Ok(None) };
        let said = answer(programs, of, &pair, &out.join(format!("{number:05}")))?;
        programs.watch.advance(1);
        Ok(said.map(|said| Row { pair: number, id: pair.id, can_tell: pair.can_tell, said }))
    };
    let rows: Vec<Option<Row>> =
        pool.install(|| (0..pairs).into_par_iter().map(one).collect::<Result<_, CampaignError>>())?;
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    let none = Share::default();
    let mut compared = Compared {
        of,
        kind,
        found: none,
        named: none,
        distinguishable: none,
        listed: none,
        alone: none,
        rows,
    };
    for row in &compared.rows {
        compared.found.count(!row.said.is_empty());
        let named = row.said.iter().any(|said| Some(&said.id) == row.id.as_ref());
        compared.named.count(named);
        if row.can_tell {
            compared.distinguishable.count(named);
        }
        let is_listed = |said: &Said| row.id.as_ref().is_some_and(|id| said.alternatives.contains(id));
        compared.listed.count(named || (!row.can_tell && row.said.iter().any(is_listed)));
        compared.alone.count(row.said.len() <= 1);
    }
    Ok(compared)
}

/// What the program says of a pair; none where it refuses it.
fn answer(
    programs: &Programs,
    of: Of,
    pair: &Pair,
    folder: &Path,
) -> Result<Option<Vec<Said>>, CampaignError> {
    empty_folder(folder)?;
    let nominal = if of == Of::Calibrations { Nominal::Mirror } else { Nominal::Plant };
    for (name, text) in [("then.csv", &pair.then), ("now.csv", &pair.now), (nominal.file(), &pair.nominal)] {
        put(&folder.join(name), text)?;
    }
    if let Err(reason) = programs.compare(folder, ["then.csv", "now.csv"], nominal, folder)? {
        programs.watch.warn(&format!("{}: {reason}", folder.display()));
        return Ok(None);
    }
    let text = std::fs::read_to_string(folder.join("compare.json")).unwrap_or_default();
    Ok(serde_json::from_str::<Answer>(&text).ok().map(|answer| answer.changes))
}

/// Draws a pair; none where the effect does not show in both surroundings.
fn draw(of: Of, kind: Kind, number: usize, seed: u64) -> Option<Pair> {
    (0..TRIES).find_map(|attempt| {
        let mut generator = ChaCha12Rng::seed_from_u64(seed);
        generator.set_stream(((kind as u64) << 50) + ((number as u64) << 8) + attempt);
        match of {
            Of::Calibrations => pair(kind, number, &mut generator),
            Of::Motion => motion::pair(kind, number, &mut generator),
            Of::Feedback => Some(feedback::pair(kind, number, &mut generator)),
        }
    })
}

fn pair(kind: Kind, number: usize, generator: &mut ChaCha12Rng) -> Option<Pair> {
    // Of the pairs in which nothing changes every other has an effect.
    let group = if kind == Kind::Same && number.is_multiple_of(2) { Group::Null } else { Group::Strong };
    let of_device = |id: &str| catalogue::find(id).is_some_and(|s| s.scope == Scope::Device);
    let assignment = |generator: &mut ChaCha12Rng| {
        let number = if kind == Kind::Same { number / 2 } else { number };
        Assignment { group, number, seed: generator.random(), cell: None }
    };
    let first = Trial::draw(&assignment(generator), "then.csv".into()).ok()?;
    let other = circumstances(&assignment(generator), &mut ChaCha12Rng::seed_from_u64(generator.random()));
    let mut then = Trial { fresh_seed: generator.random(), ..first };
    let effects: Vec<Injected> = then.device.effects().cloned().collect();
    let lasting: Vec<Injected> = effects.iter().filter(|e| of_device(&e.id)).cloned().collect();
    if kind != Kind::Same && lasting.is_empty() {
        return None;
    }
    let again = |effects: Vec<Injected>, seed: u64| -> Option<Trial> {
        let device = then.device.with_effects(effects).ok()?;
        // The same kind of noise: another one would be a change.
        let protocol = Protocol { noise: then.protocol.noise, ..other.protocol.clone() };
        protocol.suits(&device).ok()?;
        Some(Trial { truth: then.truth.clone(), device, protocol, seed, fresh_seed: seed })
    };
    let seed = generator.random();
    let mut now = again(lasting.clone(), seed)?;
    let id = lasting.first().map(|effect| effect.id.clone()).filter(|_| kind != Kind::Same);
    if id.is_some() {
        let (before, after) = (then.truth.effects.first()?.rho, now.rho()?.into_iter().next()?);
        let joint_error = (before.powi(-2) + after.powi(-2)).sqrt();
        let factor = match kind {
            Kind::Came => CAME_BY * joint_error,
            _ => {
                let moved = MOVED_BY * joint_error;
                if moved < 0.8 && generator.random() { 1.0 - moved } else { 1.0 + moved }
            }
        };
        now = again(lasting.iter().map(|effect| effect.scaled(factor)).collect(), seed)?;
        if kind == Kind::Came {
            let reached = now.rho()?.into_iter().next()? / after;
            if (reached / factor - 1.0).abs() > 0.05 {
                return None;
            }
            then.device = then.device.with_effects(Vec::new()).ok()?;
        }
    }
    let tells = |trial: &Trial| {
        trial.device.effects().next().is_some()
            && trial.left_by_imitation().is_none_or(|left| left >= CAN_TELL)
    };
    let can_tell = id.is_some() && (tells(&then) || tells(&now));
    // The reference is zeroed anew.
    let zero_arcsec = generator.random_range(-5.0..5.0);
    let csv = |trial: &Trial, zero: f64| {
        let mut log = trial.record();
        log.iter_mut().for_each(|reading| reading.reference_arcsec += zero);
        let mut csv = Vec::new();
        // Writing into memory has no way to fail.
        let _ = write_csv(&log, &mut csv);
        String::from_utf8_lossy(&csv).into_owned()
    };
    let mirror = format!("[geometry]\nprobe_distance_mm = {:?}\ninitial_gap_mm = 0.3\n", then.distance_mm());
    Some(Pair { then: csv(&then, 0.0), now: csv(&now, zero_arcsec), nominal: mirror, id, can_tell })
}
