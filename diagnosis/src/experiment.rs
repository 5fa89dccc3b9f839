//! What to record next: a menu of experiments, each with the explanations that it separates.

use fitter::figures::plain;

use crate::rows::Rows;
use crate::verdict::{Location, NamedEffect, Verdict};

/// An experiment and the groups of effects between which it decides.
struct Experiment {
    separates: &'static [&'static [&'static str]],
    advice: &'static str,
}

/// The menu; the first that separates most of the pairs in question is proposed.
const MENU: &[Experiment] = &[
    Experiment {
        separates: &[
            &["thermal_zero_drift", "thermal_lag", "thermal_gain_drift"],
            &["time_drift", "warmup_drift", "mount_step"],
        ],
        advice: "repeat with the temperature held at three levels (for example 20, 30 and 40 °C), visited upward and \
                 downward, two passes both ways at each: what follows the temperature returns with it, what follows \
                 time does not",
    },
    Experiment {
        separates: &[&["thermal_zero_drift"], &["thermal_lag"]],
        advice: "step the temperature by 10 K within a minute and record passes for an hour: a lag approaches \
                 exponentially, a zero drift follows at once",
    },
    Experiment {
        separates: &[&["time_drift"], &["warmup_drift"], &["mount_step"]],
        advice: "repeat at constant temperature for three times as long, without switching off in between: a warm-up \
                 dies away, a drift goes on, a step stays",
    },
    Experiment {
        separates: &[&["backlash"], &["hysteresis"], &["read_lag"]],
        advice: "record nested loops both ways over the full, half and a tenth of the stroke, at two speeds: backlash \
                 keeps its width, hysteresis shrinks with the loop, a lag grows with the speed",
    },
    Experiment {
        separates: &[&["local_defect"], &["sensor_clipping"], &["periodic_error"]],
        advice: "repeat with a quarter of the angle step over the range in question and beyond it, both ways",
    },
    Experiment {
        separates: &[
            &["common_mode_leakage"],
            &["cross_axis_coupling"],
            &["coil_crosstalk"],
            &["thermal_zero_drift", "thermal_gain_drift", "thermal_lag"],
            &["backlash", "hysteresis"],
            &["time_drift", "warmup_drift", "mount_step"],
        ],
        advice: "at three fixed angles change one thing at a time: translate the mount by 5 µm, tilt the second axis by \
                 10 arcsec, add a weight so that the coil current changes, and hold the temperature meanwhile",
    },
];

/// What separates lag, gain and backlash, where all rows were read in one direction.
const BOTH_WAYS: &str = "record the same range in both directions, at two speeds: a backlash stays when the direction is \
                         reversed, a lag grows with the speed, a gain does neither";

/// What to record next: the experiment that decides between what is named and its alternatives, or that would
/// explain what is not; in both directions, where this recording has one only.
pub fn next(
    rows: &Rows,
    effects: &[NamedEffect],
    locations: &[Location],
    verdict: Verdict,
) -> Option<String> {
    let deciding = deciding(effects, locations, verdict);
    if rows.both_directions() || verdict == Verdict::Consistent {
        return deciding;
    }
    Some(deciding.map_or_else(|| BOTH_WAYS.to_string(), |advice| format!("{BOTH_WAYS}; and {advice}")))
}

fn deciding(effects: &[NamedEffect], locations: &[Location], verdict: Verdict) -> Option<String> {
    let pairs: Vec<(&str, &str)> = effects
        .iter()
        .flat_map(|e| e.alternatives.iter().map(move |a| (e.id.as_str(), a.as_str())))
        .collect();
    if !pairs.is_empty() {
        let apart = |experiment: &Experiment, (a, b): &(&str, &str)| {
            let group = |id: &str| experiment.separates.iter().position(|g| g.contains(&id));
            matches!((group(a), group(b)), (Some(i), Some(j)) if i != j)
        };
        // The first pair of the strongest effect counts most.
        let best = MENU.iter().rev().max_by_key(|e| {
            let first = usize::from(apart(e, &pairs[0]));
            100 * first + pairs.iter().filter(|p| apart(e, p)).count()
        });
        return best.map(|e| e.advice.to_string());
    }
    if matches!(verdict, Verdict::Unexplained | Verdict::PartlyExplained) {
        let generic = locations.first()?;
        let variable = generic.variable.as_str();
        let advice = match variable {
            "t_s" | "pass" => "repeat the same schedule twice on different days: what returns belongs to the schedule, what does not to the day".to_string(),
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
