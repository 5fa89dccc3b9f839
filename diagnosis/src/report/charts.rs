//! Charts of the residual before and after.

use plotters::prelude::*;

use super::draw::{AFTER, BEFORE, axes, titled};
use super::{digits, readable};
use crate::diagnosis::Outcome;
use crate::numerics::{mean, range};
use crate::thresholds::report::charts::{BINS, MOST_POINTS};
use crate::verdict::values_of;

/// Residual against one observable, before and after, with running means. Of a product the residual is turned
/// over where the other observable is below its middle, so that what changes sign with it shows as one curve.
pub(super) fn residuals(
    outcome: &Outcome,
    variable: &str,
    times: Option<&str>,
    before: &[f64],
    after: &[f64],
) -> String {
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
    let both = [(&before, BEFORE), (&after, AFTER)];
    let (low, high) = range(&x);
    let margin = 0.03 * (high - low).max(1e-9);
    let (bottom, top) = limits(&before, &after);
    let stride = stride(x.len());
    let mut titles = Vec::new();
    for (values, _) in both {
        let shown = x.iter().zip(values).step_by(stride).filter(|(_, y)| **y >= bottom && **y <= top);
        titles.extend(shown.map(|(x, y)| {
            format!("{} {}, residual {} {}", readable(variable), digits(*x), digits(*y), rows.unit)
        }));
    }
    let drawn = axes((&readable(variable), &label), (low - margin, high + margin), (bottom, top), |chart| {
        for (values, colour) in both {
            let points = x.iter().zip(values).step_by(stride).filter(|(_, y)| **y >= bottom && **y <= top);
            let dot = |(x, y): (&f64, &f64)| Circle::new((*x, *y), 2, colour.mix(0.45).filled());
            chart.draw_series(points.map(dot))?;
        }
        for (values, colour) in both {
            chart.draw_series(LineSeries::new(running(&x, values), colour.stroke_width(3)))?;
        }
        Ok(())
    });
    drawn.map_or(String::new(), |svg| titled(&svg, &titles))
}

/// Every how many rows one is drawn.
fn stride(rows: usize) -> usize {
    rows.div_ceil(MOST_POINTS).max(1)
}

/// How many readings are drawn of how many; blank where it is all of them.
pub(super) fn drawn_of(rows: usize) -> String {
    match stride(rows) {
        1 => String::new(),
        stride => format!(" Drawn are {} of {rows} readings.", rows.div_ceil(stride)),
    }
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
