//! The mismatch map: every observable cut into ranges, and in each the mean residual in units of its own
//! uncertainty, before and after.

use std::fmt::Write;

use numerics::range;
use pages::Colour;

use super::{digits, readable};
use crate::diagnosis::Outcome;
use crate::generic;
use crate::thresholds::report::map::{CELL, FULL, LEFT, LINE, RANGES};
use crate::verdict::{angle_name, values_of};

/// Height of a row of cells, the gap to the next included.
const ROW: usize = 17;

/// The map as SVG, with a line that says how to read it.
pub(super) fn mismatch(outcome: &Outcome, before: &[f64], after: &[f64]) -> (String, String) {
    let rows = &outcome.rows;
    let mut variables: Vec<String> = vec![angle_name(rows), "t_s".into()];
    if rows.both_directions() {
        variables.push("direction".into());
    }
    variables.extend(generic::observables(rows).into_iter().map(|o| o.name));
    // Correlated readings count for fewer: the variance of their mean is larger by (1 + φ)/(1 − φ).
    let phi = outcome.diagnosis.noise_floor.autocorrelation;
    let level = (outcome.diagnosis.noise_floor.value * ((1.0 + phi) / (1.0 - phi)).sqrt()).max(1e-300);
    let (width, height) = (LEFT + CELL * RANGES + 8, LINE * variables.len() + 10);
    let mut svg = format!(
        "<svg role=\"img\" aria-label=\"Mismatch map\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\">\n"
    );
    for (k, variable) in variables.iter().enumerate() {
        let values = values_of(rows, variable);
        // Writing into a string cannot fail.
        let _ = line(&mut svg, 6 + LINE * k, variable, &values, [before, after], level);
    }
    let key = format!(
        "Each cell is the mean residual over one range of the observable, from its lowest value (left) to its highest, \
         in units of its uncertainty; the colour is full from {FULL:.0} on. Upper row: simulation alone; lower \
         row: with the named effects."
    );
    (svg + "</svg>\n", key)
}

/// The two rows of cells of an observable.
fn line(
    svg: &mut String,
    top: usize,
    variable: &str,
    values: &[f64],
    residuals: [&[f64]; 2],
    level: f64,
) -> std::fmt::Result {
    let ink = Colour::Ink.variable();
    let name = readable(variable);
    writeln!(
        svg,
        "<text x=\"2\" y=\"{}\" font-family=\"sans-serif\" font-size=\"13.5\" style=\"fill:{ink}\">{name}</text>",
        top + ROW + 4
    )?;
    let (low, high) = range(values);
    let width = (high - low).max(1e-300) / RANGES as f64;
    let cell_of = |v: f64| (((v - low) / width) as usize).min(RANGES - 1);
    for (j, residual) in residuals.into_iter().enumerate() {
        let mut sums = [(0.0, 0usize); RANGES];
        for (v, r) in values.iter().zip(residual) {
            let cell = &mut sums[cell_of(*v)];
            cell.0 += r;
            cell.1 += 1;
        }
        for (c, (sum, count)) in sums.iter().enumerate() {
            let z = if *count > 0 { sum / (*count as f64).sqrt() / level } else { 0.0 };
            let colour = if z > 0.0 { Colour::First } else { Colour::Second };
            let place = format!(
                "x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"",
                LEFT + CELL * c,
                top + ROW * j,
                CELL - 2,
                ROW - 2
            );
            let ends = [c, c + 1].map(|end| digits(low + width * end as f64));
            writeln!(svg, "<rect {place} opacity=\"0.06\" style=\"fill:{ink}\"/>")?;
            writeln!(
                svg,
                "<rect {place} opacity=\"{:.2}\" style=\"fill:{}\"><title>{name} {} to {}: {z:.1} σ of {count} \
                 readings</title></rect>",
                (z.abs() / FULL).min(1.0),
                colour.variable(),
                ends[0],
                ends[1],
            )?;
        }
    }
    Ok(())
}
