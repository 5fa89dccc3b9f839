//! What counts: found, located, a wrong name alone, and the gain on a fresh recording.

use std::collections::BTreeMap;

use serde::Serialize;

use super::draw::Truth;
use super::plan::{Condition, Device, FAMILIES, Family, ORDINARY};
use crate::answer::{Answer, Verdict};
use crate::score::{Figure, Share};
use crate::statistics::percentile;

/// A gain that is worth measuring, as a part of the base's mean square on the fresh recording; by judgement.
const WORTHWHILE: f64 = 0.05;
/// A fresh recording is made worse where its rms is so many times that of the base alone.
const WORSE: f64 = 1.03;
/// A model realises the gain where it reaches this part of the oracle's.
const REALISED: f64 = 0.9;
/// A wrong name alone that reaches less than this part loses the gain.
const LOSES: f64 = 0.8;

/// Mean squares of the error of the corrected reading on a fresh recording, in the square of the reading's unit.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Fresh {
    /// By the base alone, as `fit` makes it.
    pub base: f64,
    /// By what was handed on.
    pub handed_on: f64,
    /// By the oracle.
    pub oracle: f64,
}

/// A dependence on a further column is described where the model reaches this part of the oracle's gain.
const DESCRIBED: f64 = 0.95;
/// The kinds that one further column alone carries: linearly, squared, lagged.
const FURTHER: [&str; 6] =
    ["ooc_purge_flow", "ooc_swelling", "ooc_self_heating", "ooc_vibration", "ooc_coolant", "ooc_stray_light"];

/// One recording, unsealed.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// What was concealed.
    #[serde(flatten)]
    pub truth: Truth,
    /// The answer in words.
    pub said: String,
    /// A verdict other than `consistent`.
    pub found: bool,
    /// The quantity that carries it is among those located.
    pub located: bool,
    /// Named in full, and only by effects of the catalogue.
    pub named_alone: bool,
    /// Effects that are named.
    pub named: usize,
    /// Terms of the handed-on model that hold on any recording.
    pub terms: usize,
    /// On the fresh recording; none where a model was refused.
    pub fresh: Option<Fresh>,
    /// The part of the oracle's gain that was realised; none where there was nothing to gain, or nothing that could be
    /// corrected.
    pub gain: Option<f64>,
    /// Whether the fresh recording was made worse.
    pub harmed: bool,
}

impl Row {
    /// What the answer to a recording and its worth are.
    pub fn new(truth: Truth, answer: Option<&Answer>, terms: usize, fresh: Option<Fresh>) -> Self {
        let located = |a: &Answer| {
            let is = |name: &String| truth.depends_on.contains(name);
            a.locations.iter().any(|l| is(&l.variable) || l.times.as_ref().is_some_and(is))
        };
        let named_alone = |a: &Answer| {
            a.verdict == Verdict::Explained
                && !a.effects.is_empty()
                && a.effects.iter().all(|effect| catalogued(&effect.id))
        };
        let counts = truth.lasts && truth.condition != Condition::ColumnsMissing;
        let gain = |f: &Fresh| (f.base - f.handed_on) / (f.base - f.oracle);
        Self {
            said: answer.map_or_else(|| "refused".to_owned(), Answer::sentence),
            found: answer.is_some_and(Answer::detects),
            located: answer.is_some_and(located),
            named_alone: truth.kind.is_some() && answer.is_some_and(named_alone),
            named: answer.map_or(0, |a| a.effects.len()),
            terms,
            gain: fresh.filter(|f| counts && f.base - f.oracle > WORTHWHILE * f.base).as_ref().map(gain),
            harmed: fresh.is_some_and(|f| f.handed_on > WORSE * WORSE * f.base),
            fresh,
            truth,
        }
    }

    /// What was to be gained, and what of it was, in units of the noise.
    fn gained(&self) -> Option<[f64; 2]> {
        let (gain, fresh) = (self.gain?, self.fresh?);
        let most = (fresh.base - fresh.oracle) / self.truth.noise.powi(2);
        Some([most, gain * most])
    }
}

fn catalogued(id: &str) -> bool {
    id == "turn_slope" || twin::effects::find(id).is_some_and(|s| s.catalogued())
}

/// The recordings of one kind, noise or condition.
#[derive(Debug, Clone, Serialize)]
pub struct Line {
    /// Of which they are.
    pub what: String,
    /// How many.
    pub recordings: u64,
    /// Found.
    pub found: u64,
    /// Rightly located.
    pub located: u64,
    /// With a name of the catalogue alone.
    pub named_alone: u64,
    /// Of these, those that lose the gain.
    pub named_and_lost: u64,
    /// Whose fresh recording was made worse.
    pub harmed: u64,
    /// Whose gain is counted.
    pub counted: u64,
    /// Of them those that realise nine tenths.
    pub realised: u64,
    /// Part of the oracle's gain, of all together.
    pub pooled: Option<f64>,
    /// The same of the median recording.
    pub median: Option<f64>,
}

impl Line {
    fn of(what: &str, rows: &[&Row]) -> Self {
        let lost = |row: &Row| row.named_alone && row.gain.is_some_and(|gain| gain < LOSES);
        let gains: Vec<f64> = rows.iter().filter_map(|row| row.gain).collect();
        let mut sums = [0.0; 2];
        for gained in rows.iter().filter_map(|row| row.gained()) {
            sums.iter_mut().zip(gained).for_each(|(sum, value)| *sum += value);
        }
        Self {
            what: what.to_owned(),
            recordings: rows.len() as u64,
            found: count(rows, |row| row.found),
            located: count(rows, |row| row.located),
            named_alone: count(rows, |row| row.named_alone),
            named_and_lost: count(rows, lost),
            harmed: count(rows, |row| row.harmed),
            counted: gains.len() as u64,
            realised: count(rows, |row| row.gain.is_some_and(|gain| gain >= REALISED)),
            pooled: (sums[0] > 0.0).then(|| sums[1] / sums[0]),
            median: percentile(&gains, 0.5),
        }
    }
}

fn count(rows: &[&Row], is: impl Fn(&Row) -> bool) -> u64 {
    rows.iter().filter(|row| is(row)).count() as u64
}

/// Recordings of nothing, of one noise family.
#[derive(Debug, Clone, Serialize)]
pub struct NullLine {
    /// The family.
    pub family: String,
    /// How many.
    pub recordings: u64,
    /// A verdict other than `consistent`.
    pub alarms: u64,
    /// With an effect named.
    pub named: u64,
    /// With terms that hold on any recording.
    pub terms: u64,
    /// Whose fresh recording was made worse.
    pub harmed: u64,
}

/// Everything that was measured.
#[derive(Debug, Serialize)]
pub struct Score {
    /// The summary.
    pub figures: Vec<Figure>,
    /// By kind.
    pub kinds: Vec<Line>,
    /// By kind in motion.
    pub motion: Vec<Line>,
    /// By effect of the catalogue, which was left out of it.
    pub left_out: Vec<Line>,
    /// By noise.
    pub families: Vec<Line>,
    /// By condition.
    pub conditions: Vec<Line>,
    /// By ρ.
    pub strengths: Vec<Line>,
    /// Of recordings of nothing.
    pub nulls: Vec<NullLine>,
    /// Every recording.
    pub rows: Vec<Row>,
}

impl Score {
    /// How many answers were not right: nothing found, the gain not realised, a fresh recording made worse, or something
    /// found where nothing was.
    pub fn missed(&self) -> usize {
        let right = |row: &&Row| match row.truth.kind {
            Some(_) => row.found && !row.harmed && row.gain.is_none_or(|gain| gain >= REALISED),
            None => !row.found,
        };
        self.rows.len() - self.rows.iter().filter(right).count()
    }
}

/// Scores the recordings.
pub fn score(rows: &[Row]) -> Score {
    let concealed = rows.iter().filter(|row| row.truth.kind.is_some());
    let (left_out, beyond): (Vec<&Row>, Vec<&Row>) = concealed.partition(|row| row.truth.left_out);
    let (motion, beyond): (Vec<&Row>, Vec<&Row>) =
        beyond.into_iter().partition(|row| row.truth.device == Device::Motion);
    let lines = |key: &dyn Fn(&Row) -> String| lines(&beyond, key);
    let device = |row: &Row| if row.truth.device == Device::Mirror { " (mirror)" } else { "" };
    let kind = |row: &Row| format!("{}{}", row.truth.kind.clone().unwrap_or_default(), device(row));
    let mut figures = if beyond.is_empty() { Vec::new() } else { figures(&beyond) };
    figures.extend(figures_of_nulls(rows));
    if !motion.is_empty() {
        figures.extend(figures_in_motion(&motion));
    }
    if !left_out.is_empty() {
        let all = Line::of("all", &left_out);
        figures.push(least("left out of the catalogue: gain realised, pooled", 0.9, all.pooled));
    }
    Score {
        figures,
        kinds: lines(&kind),
        motion: self::lines(&motion, &kind),
        left_out: self::lines(&left_out, &kind),
        families: lines(&|row| row.truth.family.clone()),
        conditions: lines(&|row| row.truth.condition.name().to_owned()),
        strengths: lines(&|row| strength(row.truth.rho)),
        nulls: nulls(rows),
        rows: rows.to_vec(),
    }
}

/// ρ by its range, in an order that is that of the text.
fn strength(rho: f64) -> String {
    let range = [(15.0, "08 to 15"), (30.0, "15 to 30")].into_iter().find(|(most, _)| rho < *most);
    range.map_or("30 to 60", |(_, range)| range).to_owned()
}

/// The rows by a key.
fn lines(rows: &[&Row], key: &dyn Fn(&Row) -> String) -> Vec<Line> {
    let mut groups: BTreeMap<String, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        groups.entry(key(row)).or_default().push(row);
    }
    groups.iter().map(|(what, rows)| Line::of(what, rows)).collect()
}

/// A part that must reach a least value.
fn least(figure: &str, least: f64, part: Option<f64>) -> Figure {
    let measured = part.map_or("none".to_owned(), |part| format!("{:.1} %", 100.0 * part));
    Figure::new(figure, format!("≥ {} %", 100.0 * least), measured, part.map(|part| part >= least))
}

/// Alarms in noise that is forgotten from reading to reading, and terms for firmware in noise that lasts.
fn figures_of_nulls(rows: &[Row]) -> Vec<Figure> {
    let (mut alarms, mut terms) = (Share::default(), Share::default());
    for row in rows.iter().filter(|row| row.truth.kind.is_none()) {
        match FAMILIES[..ORDINARY].iter().any(|family| family.name == row.truth.family) {
            true => alarms.count(row.found),
            false => terms.count(row.terms > 0),
        }
    }
    [
        ("nothing concealed, ordinary noise: alarms", alarms),
        ("nothing concealed, lasting noise: terms for firmware", terms),
    ]
    .into_iter()
    .filter(|(_, share)| share.of > 0)
    .map(|(figure, share)| Figure::at_most(figure, 0.01, share))
    .collect()
}

fn nulls(rows: &[Row]) -> Vec<NullLine> {
    let family = |family: &Family| {
        let of: Vec<&Row> =
            rows.iter().filter(|r| r.truth.kind.is_none() && r.truth.family == family.name).collect();
        NullLine {
            family: family.name.to_owned(),
            recordings: of.len() as u64,
            alarms: count(&of, |row| row.found),
            named: count(&of, |row| row.named > 0),
            terms: count(&of, |row| row.terms > 0),
            harmed: count(&of, |row| row.harmed),
        }
    };
    FAMILIES.iter().map(family).filter(|line| line.recordings > 0).collect()
}

/// A free run over a fresh drive comes so close to the noise of its read-out.
const AS_THE_NOISE: f64 = 1.3;

fn figures_in_motion(rows: &[&Row]) -> Vec<Figure> {
    let all = Line::of("all", rows);
    let mut close = Share::default();
    for row in rows {
        // What is left of the position without noise, and the noise beside it.
        let left = row.fresh.map(|fresh| 1.0 + fresh.handed_on / row.truth.noise.powi(2));
        close.count(left.is_some_and(|left| left.sqrt() <= AS_THE_NOISE));
    }
    vec![
        Figure::reported("in motion: found", Share { hits: all.found, of: all.recordings }),
        least("in motion: gain realised on a fresh drive, pooled", 0.8, all.pooled),
        Figure::at_least("in motion: free run within 1.3 of the noise", 0.5, close),
        Figure::reported(
            "in motion: a fresh drive made worse",
            Share { hits: all.harmed, of: all.recordings },
        ),
    ]
}

fn figures(rows: &[&Row]) -> Vec<Figure> {
    let all = Line::of("all", rows);
    let share = |hits, of| Share { hits, of };
    let mut further = Share::default();
    let one_further = |row: &&&Row| row.truth.kind.as_deref().is_some_and(|kind| FURTHER.contains(&kind));
    for gain in rows.iter().filter(|row| row.truth.rho >= 10.0).filter(one_further).filter_map(|row| row.gain)
    {
        further.count(gain >= DESCRIBED);
    }
    vec![
        Figure::reported("beyond the catalogue: found", share(all.found, all.recordings)),
        Figure::reported("rightly located", share(all.located, all.recordings)),
        least("gain realised on a fresh recording, pooled", 0.9, all.pooled),
        least("the same, median recording", 0.95, all.median),
        Figure::at_least("recordings with nine tenths of the gain", 0.75, share(all.realised, all.counted)),
        Figure::at_least("a dependence on one further column, ρ ≥ 10: 95 % of the gain", 0.98, further),
        Figure::at_most("a fresh recording made worse (> 3 %)", 0.002, share(all.harmed, all.recordings)),
        Figure::reported("a catalogued name alone", share(all.named_alone, all.recordings)),
        Figure::at_most(
            "of it, losing more than 20 % of the gain",
            0.02,
            share(all.named_and_lost, all.recordings),
        ),
    ]
}
