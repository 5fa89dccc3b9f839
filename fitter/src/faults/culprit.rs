//! Which cell of a row is wrong: of every column it is asked how well it alone explains what the channels show.

use super::channels::{Channel, Channels};
use super::dependence::Dependence;
use super::{Fault, limits};
use crate::recording::{Readings, Recording};

/// What tells of a cell before anything is fitted.
const NEARBY: &str = "the rows nearby in time and angle and its own row's other columns";

/// The cells that are far out, row by row.
pub fn faults(channels: &Channels) -> Vec<Fault> {
    let recording = channels.recording;
    let mut found = Vec::new();
    let of = |row| of_sensor(recording, &channels.sensor, row);
    let of_sensor = beyond_the_tail((0..recording.rows()).filter_map(of).collect(), recording.rows());
    found.extend(unexplained(channels, of_sensor));
    for (name, deviation) in &channels.further {
        let values = recording.column(name).unwrap_or_default();
        let of = |row: usize| {
            let (away, size) = (deviation.away[row], deviation.away[row].abs() / deviation.scatter[row]);
            let (column, reason) = (name.to_string(), reason(away, name, NEARBY, size));
            let counts = size > limits::CLOSER_LOOK && !deviation.shared[row];
            counts.then(|| Fault { row, column, value: values[row], reason, size })
        };
        let all: Vec<Fault> = (0..recording.rows()).filter_map(of).collect();
        let far = beyond_the_tail(all, recording.rows());
        found.extend(far.into_iter().filter(|fault| !is_a_jump_at_an_end(values, fault.row)));
    }
    found
}

/// Whether a cell is the first or last of its column, and the column jumps elsewhere, at least half as far. At an end no cell on the
/// other side tells an outlier from a jump.
fn is_a_jump_at_an_end(values: &[f64], row: usize) -> bool {
    let last = values.len() - 1;
    if row != 0 && row != last {
        return false;
    }
    let step = |k: usize| (values[k + 1] - values[k]).abs();
    let own = step(row.min(last - 1));
    (1..last - 1).filter(|k| 2.0 * step(*k) >= own).count() >= limits::JUMPS
}

/// The outliers among deviations: beyond the limit, and beyond the tail that the others have.
pub(super) fn beyond_the_tail(mut deviations: Vec<Fault>, rows: usize) -> Vec<Fault> {
    deviations.sort_by(|a, b| b.size.total_cmp(&a.size));
    let excepted = ((limits::TAIL_PART * rows as f64) as usize).max(2);
    let tail = deviations.get(excepted).map_or(0.0, |fault| fault.size);
    let more = (rows as f64 / limits::USUAL_ROWS).max(1.0).log10();
    let limit = (limits::OUTLIER * (1.0 + limits::PER_DECADE * more)).max(limits::BEYOND_TAIL * tail);
    deviations.retain(|fault| fault.size >= limit);
    deviations
}

/// How far a cell is from what tells its value, and how many times the scatter that is.
pub(super) fn reason(away: f64, column: &str, what: &str, size: f64) -> String {
    let unit = column.rsplit_once('_').map_or(String::new(), |(_, unit)| format!(" {unit}"));
    let digits = 3i32.saturating_sub(away.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let away = if away.abs() < 1e9 { format!("{away:+.digits$}") } else { format!("{away:+.3e}") };
    let size = if size < 1e9 { format!("{size:.0}") } else { format!("{size:.0e}") };
    format!("{away}{unit} away from what {what} say: {size} times their scatter")
}

/// Those of the sensor's faults that no further column explains, in the channel that shows most of each.
fn unexplained(channels: &Channels, mut found: Vec<Fault>) -> Vec<Fault> {
    let shown = |c: &Channel, row: usize| c.deviation.away[row] / c.deviation.scatter[row];
    let most = |row: usize| {
        let size = |k: &usize| shown(&channels.sensor[*k], row).abs();
        (0..channels.sensor.len()).max_by(|a, b| size(a).total_cmp(&size(b)))
    };
    for (k, channel) in channels.sensor.iter().enumerate() {
        let is_own = |fault: &Fault| most(fault.row) == Some(k);
        if !found.iter().any(is_own) {
            continue;
        }
        let deviation: Vec<f64> = (0..channels.recording.rows()).map(|row| shown(channel, row)).collect();
        for column in &channels.recording.further {
            let Some(dependence) = Dependence::of(&column.values, &channels.angle, &deviation) else {
                continue;
            };
            found.retain(|fault| !(is_own(fault) && dependence.explains(fault.row, deviation[fault.row])));
        }
    }
    found
}

/// The one column of the sensor's that explains the row best, if it is far out.
fn of_sensor(recording: &Recording, channels: &[Channel], row: usize) -> Option<Fault> {
    let shown: Vec<f64> = channels.iter().map(|c| c.deviation.away[row] / c.deviation.scatter[row]).collect();
    // The channel that shows most must stand alone; the others only help to tell which column it is.
    let most = (0..channels.len()).max_by(|a, b| shown[*a].abs().total_cmp(&shown[*b].abs()))?;
    if shown[most].abs() < limits::CLOSER_LOOK || channels[most].deviation.shared[row] {
        return None;
    }
    // Size in multiples of the scatter, and the change of the column, for a signature of the channels.
    let explains = |signature: Vec<f64>| {
        let square: f64 = signature.iter().map(|s| s * s).sum();
        let along: f64 = signature.iter().zip(&shown).map(|(s, shown)| s * shown).sum();
        (along / square.sqrt(), along / square)
    };
    let signature = |column: &str| -> Vec<f64> {
        let factor = |c: &Channel| c.parts.iter().find(|p| p.0 == column).map_or(0.0, |p| p.1);
        channels.iter().map(|c| factor(c) / c.deviation.scatter[row]).collect()
    };
    let names = ["x1_mm", "x2_mm", "reference_arcsec", "measured", "reference", "command_deg"];
    let (name, (size, away)) = (names.into_iter())
        .filter(|name| channels.iter().any(|c| c.parts.iter().any(|part| part.0 == *name)))
        .map(|name| (name, explains(signature(name))))
        .max_by(|a, b| a.1.0.abs().total_cmp(&b.1.0.abs()))?;
    // Both targets moved along the axes of the probes: no reading is wrong.
    let together = channels.iter().position(|c| c.parts.len() == 2 && c.parts[0].1 == c.parts[1].1);
    let moved = together.map_or(0.0, |channel| {
        let mut signature = vec![0.0; channels.len()];
        signature[channel] = 1.0;
        explains(signature).0.abs()
    });
    let elsewhere = (0..channels.len()).filter(|c| Some(*c) != together);
    let elsewhere = elsewhere.fold(0.0_f64, |largest, c| largest.max(shown[c].abs()));
    if size.abs() < limits::CLOSER_LOOK || (moved > size.abs() && elsewhere < limits::OUTLIER) {
        return None;
    }
    let name = match name {
        "measured" | "reference" if channels.len() == 1 => jumping(recording, row),
        name => name,
    };
    let away =
        if name == "reference" && channels.len() == 1 { -channels[0].deviation.away[row] } else { away };
    let value = recording.values(name).map_or(f64::NAN, |values| values[row]);
    let size = size.abs();
    Some(Fault { row, column: name.to_string(), value, reason: reason(away, name, NEARBY, size), size })
}

/// Of measured and reference the one that stands out more from the rows before and after; nothing else tells them
/// apart.
pub(super) fn jumping(recording: &Recording, row: usize) -> &'static str {
    let Readings::Direct { measured, reference: Some(reference) } = &recording.readings else {
        return "measured";
    };
    let out = |values: &[f64]| {
        let (before, after) = (row.saturating_sub(1), (row + 1).min(values.len() - 1));
        (values[row] - 0.5 * (values[before] + values[after])).abs()
    };
    if out(reference) > out(measured) { "reference" } else { "measured" }
}
