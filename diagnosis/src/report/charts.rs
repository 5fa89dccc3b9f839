//! Charts of the residual before and after.

use numerics::{mean, range};
use pages::{Chart, Colour, Figure, Mark, Series};

use super::readable;
use crate::diagnosis::Outcome;
use crate::thresholds::report::charts::BINS;
use crate::verdict::values_of;

/// Residual against one observable, before and after, with running means. Of a product the residual is turned
/// over where the other observable is below its middle, so that what changes sign with it shows as one curve.
pub(super) fn residuals(
    outcome: &Outcome,
    variable: &str,
    times: Option<&str>,
    before: &[f64],
    after: &[f64],
) -> Figure {
    let rows = &outcome.rows;
    let x = values_of(rows, variable);
    let turned = |residual: &[f64]| -> Vec<f64> {
        let Some(times) = times else { return residual.to_vec() };
        let other = values_of(rows, times);
        let (low, high) = range(&other);
        let middle = 0.5 * (low + high);
        residual.iter().zip(&other).map(|(r, v)| if *v < middle { -r } else { *r }).collect()
    };
    let label = match times {
        Some(times) => format!("residual · sign of {} ({})", short(times), rows.unit),
        None => format!("residual ({})", rows.unit),
    };
    let (before, after) = (turned(before), turned(after));
    let (bottom, top) = limits(&before, &after);
    let dots = |name: &str, colour, values: &[f64]| {
        let shown = x.iter().copied().zip(values.iter().copied()).filter(|(_, y)| *y >= bottom && *y <= top);
        Series::new(name, Mark::Haze, colour, shown.collect())
    };
    let means = |colour, values: &[f64]| Series::new("", Mark::Curve, colour, running(&x, values));
    let title = match times {
        Some(times) => format!("{} (times {})", readable(variable), readable(times)),
        None => readable(variable),
    };
    let chart = Chart {
        label: &format!("Residual against {}", readable(variable)),
        x: readable(variable),
        y: label,
        series: vec![
            dots("before", Colour::First, &before),
            dots("after", Colour::Second, &after),
            means(Colour::First, &before),
            means(Colour::Second, &after),
        ],
    };
    let outside = before.iter().chain(&after).filter(|y| **y < bottom || **y > top).count();
    let caption = match outside {
        0 => String::new(),
        outside => format!("{outside} of {} residuals lie outside the chart.", 2 * rows.len()),
    };
    Figure::of(&format!("residual-{variable}"), &title, caption, chart)
}

/// A column's name for a reader, without its unit.
fn short(variable: &str) -> String {
    readable(variable).split(" (").next().unwrap_or_default().to_string()
}

/// Limits of the ordinate: the central 99 % of both, with room.
fn limits(before: &[f64], after: &[f64]) -> (f64, f64) {
    let mut all: Vec<f64> = before.iter().chain(after).copied().collect();
    all.sort_by(f64::total_cmp);
    let at = |part: f64| all[((all.len() - 1) as f64 * part) as usize];
    let (low, high) = (at(0.005), at(0.995));
    let room = 0.08 * (high - low).max(1e-9);
    (low - room, high + room)
}

/// Means over bins of equal count along x.
fn running(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
    let size = x.len().div_ceil(BINS).max(1);
    let mut points: Vec<(f64, f64)> = order
        .chunks(size)
        .map(|chunk| {
            let of = |v: &[f64]| mean(&chunk.iter().map(|&i| v[i]).collect::<Vec<f64>>());
            (of(x), of(y))
        })
        .collect();
    points.dedup_by(|a, b| a.0 == b.0);
    points
}
