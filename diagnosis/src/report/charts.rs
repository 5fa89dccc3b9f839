//! Charts of the residual before and after, drawn by `plotters` as SVG whose colours are CSS variables, so
//! that one drawing serves light and dark.

use plotters::prelude::*;

use super::readable;
use crate::diagnosis::Outcome;
use crate::rows::{mean, range};
use crate::thresholds::report::charts::{BINS, MOST_POINTS};
use crate::verdict::values_of;

/// Size of a chart in its own units; the page scales it to the column.
const SIZE: (u32, u32) = (560, 330);

/// Stand-ins for the page's colours: what is drawn in them is given the CSS variable of that name.
pub(crate) const INK: RGBColor = RGBColor(1, 2, 3);
pub(crate) const GRID: RGBColor = RGBColor(1, 2, 4);
pub(crate) const BEFORE: RGBColor = RGBColor(1, 2, 5);
pub(crate) const AFTER: RGBColor = RGBColor(1, 2, 6);
const NAMES: [(&str, &str); 4] =
    [("#010203", "--ink"), ("#010204", "--grid"), ("#010205", "--before"), ("#010206", "--after")];

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
    let mut svg = String::new();
    // Drawing into a string fails only where a range is empty; then there is nothing to show.
    if draw(&mut svg, &x, &readable(variable), &label, &turned(before), &turned(after)).is_err() {
        return String::new();
    }
    themed(&svg)
}

/// A column's name for a reader, without its unit.
fn short(variable: &str) -> String {
    readable(variable).split(" (").next().unwrap_or_default().to_string()
}

fn draw(
    svg: &mut String,
    x: &[f64],
    label: &str,
    ordinate: &str,
    before: &[f64],
    after: &[f64],
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    let (low, high) = range(x);
    let margin = 0.03 * (high - low).max(1e-9);
    let (bottom, top) = limits(before, after);
    let mut chart = ChartBuilder::on(&root)
        .margin(10)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d(low - margin..high + margin, bottom..top)?;
    let text = ("sans-serif", 17).into_font().color(&INK);
    chart
        .configure_mesh()
        .x_desc(label)
        .y_desc(ordinate)
        .x_labels(6)
        .y_labels(6)
        .label_style(text.clone())
        .axis_desc_style(text)
        .axis_style(GRID)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .draw()?;
    let stride = x.len().div_ceil(MOST_POINTS);
    for (values, colour) in [(before, BEFORE), (after, AFTER)] {
        let points = x.iter().zip(values).step_by(stride);
        chart.draw_series(
            points
                .filter(|(_, y)| **y >= bottom && **y <= top)
                .map(|(x, y)| Circle::new((*x, *y), 2, colour.mix(0.45).filled())),
        )?;
    }
    for (values, colour) in [(before, BEFORE), (after, AFTER)] {
        chart.draw_series(LineSeries::new(running(x, values), colour.stroke_width(3)))?;
    }
    root.present()?;
    drop(chart);
    drop(root);
    Ok(())
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

/// Puts CSS variables in the place of the stand-in colours, and leaves size to the page.
pub(crate) fn themed(svg: &str) -> String {
    let mut out = svg.to_string();
    for (code, name) in NAMES {
        for attribute in ["fill", "stroke"] {
            out = out
                .replace(&format!("{attribute}=\"{code}\""), &format!("style=\"{attribute}:var({name})\""));
        }
    }
    out
}
