//! Times, passes and directions that contradict the rows before and after.

use super::scale::{least, median, with_tail};
use super::{Fault, limits};
use crate::recording::Recording;

/// Faults among the rows `kept`.
pub fn faults(recording: &Recording, kept: &[usize]) -> Vec<Fault> {
    if kept.len() < limits::FEWEST_ROWS {
        return Vec::new();
    }
    let mut found = times(recording, kept);
    let rest: Vec<usize> =
        kept.iter().copied().filter(|row| found.iter().all(|fault| fault.row != *row)).collect();
    found.extend(numbers(recording, &rest));
    found
}

fn times(recording: &Recording, kept: &[usize]) -> Vec<Fault> {
    let t: Vec<f64> = kept.iter().map(|row| recording.time_s[*row]).collect();
    let n = t.len();
    let mut found: Vec<Fault> = Vec::new();
    let mut list = |k: usize, size: f64, reason: String| {
        if found.iter().all(|fault| fault.row != kept[k]) {
            found.push(Fault::new(kept[k], "t_s", t[k], size, reason));
        }
    };
    // After a pause of years nothing of the recording is left that could be compared.
    if let Some(k) = (1..n).find(|k| (t[*k] - t[k - 1]).abs() > limits::LONGEST_PAUSE_S) {
        let smaller = if 2 * k <= n { 0..k } else { k..n };
        let away = t[k] - t[k - 1];
        let beside = if smaller.contains(&k) { k - 1 } else { k };
        for other in smaller.filter(|other| (t[*other] - t[beside]).abs() > limits::LONGEST_PAUSE_S) {
            list(
                other,
                f64::INFINITY,
                format!("{away:.1e} s between two rows: no recording takes that long"),
            );
        }
        return found;
    }
    // Times that do not grow with the others, if they are few and stand alone.
    let growing = if t.is_sorted() { vec![true; n] } else { longest_growing(&t) };
    let back: Vec<usize> = (0..n).filter(|k| !growing[*k]).collect();
    let alone = |k: &usize| (*k == 0 || growing[k - 1]) && growing.get(k + 1).copied().unwrap_or(true);
    let mut gaps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > 0.0).collect();
    let usual = median(&mut gaps);
    if back.iter().all(alone) && back.len() as f64 <= limits::MOST_AFFECTED * n as f64 {
        for k in back {
            let expected = match (k.checked_sub(1).map(|k| t[k]), t.get(k + 1)) {
                (Some(before), Some(after)) => 0.5 * (before + after),
                (Some(before), None) => before + usual,
                (None, after) => after.copied().unwrap_or(0.0) - usual,
            };
            let away = t[k] - expected;
            // Two rows that have changed places are in a wrong order, not wrong.
            if away.abs() > limits::BACKWARD * usual {
                let size = away.abs() / usual;
                list(
                    k,
                    size,
                    format!("{away:+.3} s away from the rows before and after, {size:.0} intervals"),
                );
            }
        }
    } else {
        return found;
    }
    // A lone first or last row, far from all others.
    for (k, beside, rest) in [(0, 1, t[n - 1] - t[1]), (n - 1, n - 2, t[n - 2] - t[0])] {
        let apart = (t[k] - t[beside]).abs();
        if rest > 0.0 && apart > limits::LONE_END * rest {
            let reason = format!("{apart:.3} s away from all other rows, which take {rest:.3} s");
            list(k, apart / rest, reason);
        }
    }
    // In stretches that share a row at either side, where memory would go with all rows.
    let stretches = n.div_ceil(limits::STRETCH);
    for stretch in 0..stretches {
        let first = (stretch * n / stretches).saturating_sub(1);
        for (k, size, reason) in uneven(&t[first..((stretch + 1) * n / stretches + 1).min(n)]) {
            list(first + k, size, reason);
        }
    }
    found
}

/// Single times by which one interval is too long and the next too short, or the other way round. Beside a pause the
/// other interval alone tells it.
fn uneven(t: &[f64]) -> Vec<(usize, f64, String)> {
    let gaps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    let usual: Vec<f64> = (0..gaps.len())
        .map(|k| {
            let (start, end) = (k.saturating_sub(6), (k + 7).min(gaps.len()));
            median(&mut gaps[start..end].to_vec())
        })
        .collect();
    let away: Vec<f64> = gaps.iter().zip(&usual).map(|(gap, usual)| gap - usual).collect();
    let between_pauses = gaps.iter().zip(&usual).map(|(gap, usual)| *gap <= limits::PAUSE * usual.abs());
    let mut absolute: Vec<f64> =
        away.iter().zip(between_pauses).filter(|(_, kept)| *kept).map(|(a, _)| a.abs()).collect();
    let scatter = with_tail(&mut absolute).max(least(&gaps)).max(limits::OF_RESOLUTION * printed(t));
    let beside_pause = |k: &usize| t[k + 1] - t[k - 1] > (limits::PAUSE + 1.0) * usual[*k].abs();
    let (beside, within): (Vec<usize>, Vec<usize>) = (1..t.len() - 1).partition(beside_pause);
    let shifted = within.into_iter().filter_map(|k| {
        let (before, after) = (away[k - 1], away[k]);
        let shift = 0.5 * (before - after);
        let opposite = before * after < 0.0 && before.abs().min(after.abs()) > 0.6 * shift.abs();
        // Every shift is seen in two intervals.
        let size = shift.abs() / (scatter * std::f64::consts::FRAC_1_SQRT_2);
        let whole = (before + after).abs() < limits::OUTLIER * scatter;
        (opposite && whole && size >= limits::OUTLIER).then_some((k, shift, size))
    });
    shifted
        .chain(shifted_beside_pauses(&beside, &away, scatter))
        .filter(|(k, shift, _)| shift.abs() > limits::OF_INTERVAL * usual[*k].abs())
        .map(|(k, shift, size)| {
            let reason = format!(
                "{shift:+.3} s away from where the rows before and after put it: {size:.0} times the scatter of the \
                 intervals"
            );
            (k, size, reason)
        })
        .collect()
}

/// Of the rows beside a pause those whose interval to the other side is not that of the others: row, by how much, and
/// how many times their scatter.
fn shifted_beside_pauses(rows: &[usize], away: &[f64], scatter: f64) -> Vec<(usize, f64, f64)> {
    if rows.len() < limits::FEWEST_BESIDE_PAUSES {
        return Vec::new();
    }
    // How much longer than usual the interval is that is no pause, and which way a longer one shifts the row.
    let longer = |k: &usize| {
        let (before, after) = (away[k - 1], away[*k]);
        if before.abs() < after.abs() { (before, 1.0) } else { (after, -1.0) }
    };
    let middle = median(&mut rows.iter().map(|k| longer(k).0).collect::<Vec<f64>>());
    let mut absolute: Vec<f64> = rows.iter().map(|k| (longer(k).0 - middle).abs()).collect();
    let scatter = scatter.max(with_tail(&mut absolute));
    let sized = rows.iter().map(|k| {
        let (longer, sign) = longer(k);
        (*k, sign * longer, (longer - middle).abs() / scatter)
    });
    sized.filter(|(_, _, size)| *size >= limits::OUTLIER).collect()
}

/// The last decimal in which the times are printed; 0 beyond a microsecond.
fn printed(t: &[f64]) -> f64 {
    let whole = |step: &f64| t.iter().all(|t| (t / step - (t / step).round()).abs() < 1e-6 * (1.0 + t.abs()));
    [1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6].into_iter().find(whole).unwrap_or(0.0)
}

/// Which times belong to the longest series that never falls.
fn longest_growing(t: &[f64]) -> Vec<bool> {
    // The last row of the series of every length, and the row before each in its series.
    let mut ends: Vec<usize> = Vec::new();
    let mut before = vec![usize::MAX; t.len()];
    for (k, time) in t.iter().enumerate() {
        let at = ends.partition_point(|end| t[*end] <= *time);
        before[k] = if at > 0 { ends[at - 1] } else { usize::MAX };
        if at == ends.len() { ends.push(k) } else { ends[at] = k }
    }
    let mut growing = vec![false; t.len()];
    let mut now = ends.last().copied().unwrap_or(usize::MAX);
    while now != usize::MAX {
        growing[now] = true;
        now = before[now];
    }
    growing
}

/// A pass number or a direction that only one row of its surroundings has.
fn numbers(recording: &Recording, kept: &[usize]) -> Vec<Fault> {
    let mut passes = Vec::new();
    let mut directions = Vec::new();
    for rows in kept.windows(3) {
        let [pass_before, pass, pass_after] = [rows[0], rows[1], rows[2]].map(|row| recording.pass[row]);
        if pass_before == pass_after && pass != pass_before {
            let reason = format!("the rows before and after are of pass {pass_before}");
            passes.push(Fault::new(rows[1], "pass", f64::from(pass), f64::INFINITY, reason));
        }
        let [before, now, after] = [rows[0], rows[1], rows[2]].map(|row| recording.direction[row]);
        if pass_before == pass && pass == pass_after && before == after && now != before {
            directions.push((rows[1], before));
        }
    }
    // Where rows alternate, it is the order of the recording.
    let few = |count: usize| count as f64 <= (0.01 * kept.len() as f64).max(1.0);
    let mut found = if few(passes.len()) { passes } else { Vec::new() };
    let others_agree = |row: usize, direction: i8| {
        let of_pass =
            kept.iter().filter(|other| recording.pass[**other] == recording.pass[row] && **other != row);
        of_pass.clone().count() >= 4 && of_pass.clone().all(|other| recording.direction[*other] == direction)
    };
    if few(directions.len()) {
        found.extend(directions.into_iter().filter(|(row, d)| others_agree(*row, *d)).map(|(row, d)| {
            let reason = format!("all other rows of pass {} have direction {d}", recording.pass[row]);
            Fault::new(row, "direction", f64::from(recording.direction[row]), f64::INFINITY, reason)
        }));
    }
    found
}
