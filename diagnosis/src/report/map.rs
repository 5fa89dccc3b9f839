//! The mismatch map: every observable cut into ranges, and in each the mean residual in units of its own
//! uncertainty, before and after.

use plotters::prelude::*;

use super::draw::{AFTER, BEFORE, INK, themed};
use super::readable;
use crate::diagnosis::Outcome;
use crate::generic;
use crate::numerics::range;
use crate::thresholds::report::map::{CELL, FULL, LEFT, LINE, RANGES};
use crate::verdict::{angle_name, values_of};

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
    let mut svg = String::new();
    if draw(&mut svg, outcome, &variables, before, after, level).is_err() {
        return (String::new(), String::new());
    }
    let key = format!(
        "Each cell is the mean residual over one range of the observable, from its lowest value (left) to its highest, \
         in units of its uncertainty; the colour is full from {FULL:.0} on. Upper row: simulation alone; lower \
         row: with the named effects."
    );
    (themed(&svg), key)
}

fn draw(
    svg: &mut String,
    outcome: &Outcome,
    variables: &[String],
    before: &[f64],
    after: &[f64],
    level: f64,
) -> Result<(), Box<dyn std::error::Error>> {
    let height = LINE * variables.len() as i32 + 10;
    let root = SVGBackend::with_string(svg, ((LEFT + CELL * RANGES as i32 + 8) as u32, height as u32))
        .into_drawing_area();
    let text = ("sans-serif", 17).into_font().color(&INK);
    for (k, variable) in variables.iter().enumerate() {
        let top = 6 + LINE * k as i32;
        root.draw(&Text::new(readable(variable), (2, top + 9), text.clone()))?;
        let values = values_of(&outcome.rows, variable);
        let (low, high) = range(&values);
        let cell_of =
            |v: f64| (((v - low) / (high - low).max(1e-300) * RANGES as f64) as usize).min(RANGES - 1);
        for (j, residual) in [before, after].into_iter().enumerate() {
            let mut sums = [(0.0, 0usize); RANGES];
            for (v, r) in values.iter().zip(residual) {
                let cell = &mut sums[cell_of(*v)];
                cell.0 += r;
                cell.1 += 1;
            }
            for (c, (sum, count)) in sums.iter().enumerate() {
                let x = LEFT + CELL * c as i32;
                let y = top + 17 * j as i32;
                let z = if *count > 0 { sum / (*count as f64).sqrt() / level } else { 0.0 };
                let colour = if z > 0.0 { BEFORE } else { AFTER };
                let strength = (z.abs() / FULL).min(1.0);
                let area = [(x, y), (x + CELL - 2, y + 15)];
                root.draw(&Rectangle::new(area, INK.mix(0.06).filled()))?;
                if strength > 0.05 {
                    root.draw(&Rectangle::new(area, colour.mix(strength).filled()))?;
                }
            }
        }
    }
    root.present()?;
    drop(root);
    Ok(())
}
