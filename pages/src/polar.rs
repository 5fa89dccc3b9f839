//! A polar plot of the error around the turn: outside the middle circle it is positive, inside negative.

use std::f64::consts::TAU;
use std::fmt::Write;

use super::chart::SIZE;
use super::colour::Colour;
use super::digits;
use super::hover::escaped;

/// Centre of the plot, and the radius of the largest error, of none, and of the labels.
const CENTRE: (f64, f64) = (SIZE.0 as f64 / 2.0, SIZE.1 as f64 / 2.0);
const OUTER: f64 = 130.0;
const ZERO: f64 = 80.0;
const LABELS: f64 = 140.0;
/// Size of the text: that of the other charts.
const TEXT: f64 = 14.5;
/// Spokes of the turn.
const SPOKES: usize = 8;

/// What is drawn: angles in radians, errors in their unit.
pub(super) struct Polar<'a> {
    /// For those who do not see it.
    pub label: &'a str,
    /// Unit of the errors.
    pub unit: &'a str,
    /// Reading at angle 0, and of a turn.
    pub revolution: (f64, f64),
    /// Unit of the readings.
    pub reading_unit: &'a str,
    /// Means over the readings of an angle.
    pub measured: Vec<(f64, f64)>,
    /// The fitted curve.
    pub model: Vec<(f64, f64)>,
}

impl Polar<'_> {
    /// How it is read.
    pub fn caption(&self) -> String {
        format!(
            "The middle circle is no error, the outer one {} {}; readings in {}, anticlockwise.",
            digits(self.largest()),
            self.unit,
            self.reading_unit
        )
    }

    /// The SVG, with CSS variables for colours.
    pub fn draw(&self) -> String {
        let mut svg = format!(
            "<svg role=\"img\" aria-label=\"{}\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\" \
             xmlns=\"http://www.w3.org/2000/svg\">\n",
            escaped(self.label),
            SIZE.0,
            SIZE.1,
            SIZE.0,
            SIZE.1
        );
        // Writing into a string cannot fail.
        let _ = self.grid(&mut svg).and_then(|()| self.marks(&mut svg)).and_then(|()| self.legend(&mut svg));
        svg + "</svg>\n"
    }

    fn largest(&self) -> f64 {
        let all = self.measured.iter().chain(&self.model).map(|p| p.1.abs());
        all.fold(0.0, f64::max).max(f64::MIN_POSITIVE)
    }

    /// Where a point lies, in tenths of the unit of the chart.
    fn place(&self, (angle, error): (f64, f64)) -> (f64, f64) {
        at(angle, ZERO + (OUTER - ZERO) * error / self.largest())
    }

    fn grid(&self, svg: &mut String) -> std::fmt::Result {
        let (x, y) = CENTRE;
        for (radius, colour) in
            [(OUTER, "var(--grid)"), (ZERO, "var(--soft)"), (2.0 * ZERO - OUTER, "var(--grid)")]
        {
            let style = format!("fill:none;stroke:{colour}");
            writeln!(
                svg,
                "<ellipse cx=\"{x}\" cy=\"{y}\" rx=\"{radius}\" ry=\"{radius}\" style=\"{style}\"/>"
            )?;
        }
        for spoke in 0..SPOKES {
            let part = spoke as f64 / SPOKES as f64;
            let (from, to, text) = (at(TAU * part, 30.0), at(TAU * part, OUTER), at(TAU * part, LABELS));
            writeln!(
                svg,
                "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" style=\"stroke:var(--grid)\"/>",
                from.0, from.1, to.0, to.1
            )?;
            let anchor = match text.0 - x {
                side if side > 1.0 => "start",
                side if side < -1.0 => "end",
                _ => "middle",
            };
            writeln!(
                svg,
                "<text x=\"{}\" y=\"{}\" dy=\"0.35em\" text-anchor=\"{anchor}\" font-family=\"sans-serif\" \
                 font-size=\"{TEXT}\" style=\"fill:var(--ink)\">{}</text>",
                text.0,
                text.1,
                digits(self.revolution.0 + self.revolution.1 * part)
            )?;
        }
        Ok(())
    }

    fn marks(&self, svg: &mut String) -> std::fmt::Result {
        let curve: Vec<String> =
            self.model.iter().map(|point| self.place(*point)).map(|(x, y)| format!("{x},{y}")).collect();
        let stroke = format!("fill:none;stroke:{};stroke-width:2", Colour::Second.variable());
        writeln!(svg, "<polyline points=\"{}\" style=\"{stroke}\"/>", curve.join(" "))?;
        for point in &self.measured {
            let (x, y) = self.place(*point);
            let reading = digits(self.revolution.0 + self.revolution.1 * point.0 / TAU);
            let title = format!("{reading} {}: {} {}", self.reading_unit, digits(point.1), self.unit);
            writeln!(
                svg,
                "<circle cx=\"{x}\" cy=\"{y}\" r=\"2\" style=\"fill:{}\"><title>{}</title></circle>",
                Colour::First.variable(),
                escaped(&title)
            )?;
        }
        Ok(())
    }

    fn legend(&self, svg: &mut String) -> std::fmt::Result {
        for (line, (name, colour)) in
            [("measured", Colour::First), ("model", Colour::Second)].into_iter().enumerate()
        {
            let y = 20 + 26 * line;
            writeln!(svg, "<circle cx=\"20\" cy=\"{y}\" r=\"5\" style=\"fill:{}\"/>", colour.variable())?;
            writeln!(
                svg,
                "<text x=\"32\" y=\"{y}\" dy=\"0.35em\" font-family=\"sans-serif\" font-size=\"{TEXT}\" \
                 style=\"fill:var(--ink)\">{name}</text>"
            )?;
        }
        Ok(())
    }
}

/// A place at an angle and a radius, to a tenth.
fn at(angle: f64, radius: f64) -> (f64, f64) {
    let tenth = |value: f64| (10.0 * value).round() / 10.0;
    (tenth(CENTRE.0 + radius * angle.cos()), tenth(CENTRE.1 - radius * angle.sin()))
}
