//! What to record next: a menu of experiments that separate explanations.

use fitter::figures::plain;

use crate::effects::Effect;
use crate::rows::Rows;
use crate::verdict::{Location, NamedEffect, Verdict};

/// The menu; the first that separates most of the pairs in question is proposed. An effect says in which of them it
/// shows itself, and how: effects that do different things there are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Experiment {
    /// The temperature held at several levels.
    Levels,
    /// A step of the temperature.
    Jump,
    /// A longer recording at constant temperature.
    Longer,
    /// Nested loops both ways, at two speeds.
    Loops,
    /// Finer steps over the range in question.
    FinerSteps,
    /// One influence changed at a time, at fixed angles.
    OneByOne,
}

impl Experiment {
    const MENU: [Experiment; 6] = [
        Experiment::Levels,
        Experiment::Jump,
        Experiment::Longer,
        Experiment::Loops,
        Experiment::FinerSteps,
        Experiment::OneByOne,
    ];

    /// Its name in declarations.
    fn name(self) -> &'static str {
        match self {
            Experiment::Levels => "levels",
            Experiment::Jump => "jump",
            Experiment::Longer => "longer",
            Experiment::Loops => "loops",
            Experiment::FinerSteps => "finer_steps",
            Experiment::OneByOne => "one_by_one",
        }
    }

    /// The experiment of a name.
    pub fn named(name: &str) -> Option<Experiment> {
        Experiment::MENU.into_iter().find(|experiment| experiment.name() == name)
    }

    /// All names.
    pub fn names() -> String {
        Experiment::MENU.map(|experiment| format!("`{}`", experiment.name())).join(", ")
    }

    fn advice(self) -> &'static str {
        match self {
            Experiment::Levels => {
                "repeat with the temperature held at three levels (for example 20, 30 and 40 °C), visited upward and \
                 downward, two passes both ways at each: what follows the temperature returns with it, what follows \
                 time does not"
            }
            Experiment::Jump => {
                "step the temperature by 10 K within a minute and record passes for an hour: a lag approaches \
                 exponentially, a zero drift follows at once"
            }
            Experiment::Longer => {
                "repeat at constant temperature for three times as long, without switching off in between: a warm-up \
                 dies away, a drift goes on, a step stays"
            }
            Experiment::Loops => {
                "record nested loops both ways over the full, half and a tenth of the stroke, at two speeds: backlash \
                 keeps its width, hysteresis shrinks with the loop, a lag grows with the speed"
            }
            Experiment::FinerSteps => {
                "repeat with a quarter of the angle step over the range in question and beyond it, both ways"
            }
            Experiment::OneByOne => {
                "at three fixed angles change one thing at a time: translate the mount by 5 µm, tilt the second axis by \
                 10 arcsec, add a weight so that the coil current changes, and hold the temperature meanwhile"
            }
        }
    }

    /// Whether two effects do different things in it.
    fn separates(self, catalogue: &[Effect], (a, b): &(&str, &str)) -> bool {
        let shown = |id: &str| {
            let effect = catalogue.iter().find(|e| e.id == id)?;
            effect.told_by.iter().find(|(experiment, _)| *experiment == self).map(|(_, how)| how.as_str())
        };
        matches!((shown(a), shown(b)), (Some(a), Some(b)) if a != b)
    }
}

/// What separates lag, gain and backlash, where all rows were read in one direction.
const BOTH_WAYS: &str = "record the same range in both directions, at two speeds: a backlash stays when the direction is \
                         reversed, a lag grows with the speed, a gain does neither";

/// What separates the device's physics from what happened once.
const SAME_AGAIN: &str = "repeat the same schedule twice on different days: what returns belongs to the schedule, what does not to \
                          the day";

/// What to record next: the experiment that decides between what is named and its alternatives, or that would
/// explain what is not; in both directions, where this recording has one only.
pub fn next(
    rows: &Rows,
    catalogue: &[Effect],
    effects: &[NamedEffect],
    locations: &[Location],
    verdict: Verdict,
) -> Option<String> {
    let deciding = deciding(catalogue, effects, locations, verdict);
    if rows.both_directions() || verdict == Verdict::Consistent {
        return deciding;
    }
    Some(deciding.map_or_else(|| BOTH_WAYS.to_string(), |advice| format!("{BOTH_WAYS}; and {advice}")))
}

fn deciding(
    catalogue: &[Effect],
    effects: &[NamedEffect],
    locations: &[Location],
    verdict: Verdict,
) -> Option<String> {
    let pairs: Vec<(&str, &str)> = effects
        .iter()
        .flat_map(|e| e.alternatives.iter().map(move |a| (e.id.as_str(), a.as_str())))
        .collect();
    if !pairs.is_empty() {
        // The first pair of the strongest effect counts most.
        let separated = |e: &&Experiment| {
            let first = usize::from(e.separates(catalogue, &pairs[0]));
            100 * first + pairs.iter().filter(|p| e.separates(catalogue, p)).count()
        };
        let best = Experiment::MENU.iter().rev().max_by_key(separated).filter(|e| separated(e) > 0);
        return Some(best.map_or(SAME_AGAIN, |e| e.advice()).to_string());
    }
    if matches!(verdict, Verdict::Unexplained | Verdict::PartlyExplained) {
        let generic = locations.first()?;
        let variable = generic.variable.as_str();
        let advice = match variable {
            "t_s" | "pass" => SAME_AGAIN.to_string(),
            "direction" | "history" | "velocity" => "record nested loops both ways over the full, half and a tenth of the stroke, starting once from either end".to_string(),
            angle if angle == "angle_deg" || angle.starts_with("position_") => "repeat with a quarter of the angle step over the range in question, both ways".to_string(),
            other => format!(
                "vary {other} alone over {} … {} at three fixed angles, upward and downward, everything else held",
                plain(generic.from),
                plain(generic.to)
            ),
        };
        return Some(advice);
    }
    None
}
