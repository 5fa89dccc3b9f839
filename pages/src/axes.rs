//! Labelled axes, with room for the longest label of the ordinate.

use std::ops::Range;

use plotters::coord::ranged1d::{BoldPoints, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::colour::{GRID, INK};
use super::digits;

/// The coordinates that a chart is drawn in.
pub(super) type Plane<'a, 'b, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, Y>>;
pub(super) type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Size of the text: readable where a phone shows the chart at three fifths.
pub(super) const TEXT: u32 = 18;
/// Height of the labels and the name of the abscissa.
pub(super) const BELOW: u32 = 50;
/// Width of a letter of the text, and what stands between an axis and its name: the name, and room around it.
const LETTER: i32 = 10;
const NAME: i32 = 34;
/// Labels of the abscissa, at most, and of the ordinate, and letters of its longest where it is logarithmic: 0.001.
const ACROSS: usize = 7;
const TICKS: usize = 6;
const LOGARITHMIC_LETTERS: i32 = 5;

/// Width of the labels and the name of an ordinate; none: a logarithmic one.
pub(super) fn width_beside(range: Option<(f64, f64)>) -> i32 {
    NAME + LETTER * range.map_or(LOGARITHMIC_LETTERS, longest_tick)
}

/// Draws the axes under their names. `abscissa` writes a value of the abscissa.
pub(super) fn draw<Y>(
    chart: &mut Plane<'_, '_, Y>,
    (x, y): (&str, &str),
    abscissa: fn(f64) -> String,
) -> Drawn
where
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let text = ("sans-serif", TEXT).into_font().color(&INK);
    let range = chart.x_range();
    let width = chart.plotting_area().dim_in_pixel().0 as i32;
    chart
        .configure_mesh()
        .x_desc(x)
        .y_desc(y)
        .x_labels(labels_across(range.start..range.end, abscissa, width))
        .y_labels(TICKS)
        .x_label_formatter(&|value| abscissa(*value))
        .y_label_formatter(&|value| tick(*value))
        .label_style(text.clone())
        .axis_desc_style(text)
        .axis_style(GRID)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .draw()?;
    Ok(())
}

/// A value as it stands at a tick.
pub(super) fn tick(value: f64) -> String {
    digits(if value.abs() < 1e-12 { 0.0 } else { value })
}

/// A value of an abscissa in decades, log₁₀ of it: two digits.
pub(super) fn decade(logarithm: f64) -> String {
    let scale = 10f64.powf(logarithm.floor() - 1.0);
    digits((10f64.powf(logarithm) / scale).round() * scale)
}

/// Letters of the longest label at the ticks of a range.
fn longest_tick((low, high): (f64, f64)) -> i32 {
    ticks(low..high, TICKS, tick).1
}

/// So many labels that they do not touch on this width.
fn labels_across(range: Range<f64>, abscissa: fn(f64) -> String, width: i32) -> usize {
    let fits = |labels: &usize| {
        let (count, longest) = ticks(range.clone(), *labels, abscissa);
        count * LETTER * (longest + 1) <= width
    };
    (2..=ACROSS).rev().find(fits).unwrap_or(2)
}

/// The number of ticks of a range that has room for so many, and the letters of their longest label.
fn ticks(range: Range<f64>, most: usize, label: fn(f64) -> String) -> (i32, i32) {
    let range: RangedCoordf64 = range.into();
    let ticks = range.key_points(BoldPoints(most));
    let longest = ticks.iter().map(|value| label(*value).chars().count()).max().unwrap_or(1);
    (ticks.len() as i32, longest as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_written_to_two_digits() {
        assert_eq!(decade(2.0), "100");
        assert_eq!(decade(3.5), "3200");
        assert_eq!(decade(-0.5), "0.32");
    }

    #[test]
    fn long_labels_are_fewer() {
        assert_eq!(labels_across(-4.0..4.0, tick, 430), ACROSS);
        let few = labels_across(-6e5..6e5, tick, 430);
        assert!((2..ACROSS).contains(&few), "{few}");
    }
}
