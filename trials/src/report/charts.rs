//! The detection curve, drawn by `plotters` as SVG whose colours are CSS variables, so that one drawing serves
//! light and dark.

use plotters::prelude::*;

use crate::curve::Curve;
use crate::statistics::{ideal_detection, phi};

/// Size in the chart's own units; the page scales it to the column.
const SIZE: (u32, u32) = (620, 380);
/// Strength up to which the curve is drawn; beyond, everything is detected.
const UP_TO: f64 = 10.0;

/// Stand-ins for the page's colours: what is drawn in them is given the CSS variable of that name.
const INK: RGBColor = RGBColor(1, 2, 3);
const GRID: RGBColor = RGBColor(1, 2, 4);
const IDEAL: RGBColor = RGBColor(1, 2, 5);
const MEASURED: RGBColor = RGBColor(1, 2, 6);
const NAMES: [(&str, &str); 4] =
    [("#010203", "--ink"), ("#010204", "--grid"), ("#010205", "--ideal"), ("#010206", "--measured")];

/// Probability of detection against ρ: bins with their intervals, the fitted ogive, the isotonic steps, and
/// the ideal detector.
pub(super) fn detection(curve: &Curve) -> String {
    let mut svg = String::new();
    // Drawing into a string fails only where a range is empty, and these are not.
    match draw(&mut svg, curve) {
        Ok(()) => themed(&svg),
        Err(_) => String::new(),
    }
}

fn draw(svg: &mut String, curve: &Curve) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .margin(10)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d(0.0..UP_TO, 0.0..1.02)?;
    let text = ("sans-serif", 17).into_font().color(&INK);
    chart
        .configure_mesh()
        .x_desc("strength ρ")
        .y_desc("share detected")
        .x_labels(11)
        .y_labels(6)
        .label_style(text.clone())
        .axis_desc_style(text)
        .axis_style(GRID)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .draw()?;
    let strengths = || (0..=200).map(|i| UP_TO * f64::from(i) / 200.0);
    let ideal = strengths().map(|rho| (rho, ideal_detection(rho, curve.false_alarm)));
    chart.draw_series(LineSeries::new(ideal, IDEAL.stroke_width(3)))?;
    let mut steps = Vec::new();
    let mut last = 0.0;
    for (rho, share) in curve.isotonic.iter().copied().filter(|(rho, _)| *rho <= UP_TO) {
        steps.extend([(rho, last), (rho, share)]);
        last = share;
    }
    steps.push((UP_TO, last));
    chart.draw_series(LineSeries::new(steps, MEASURED.mix(0.45).stroke_width(1)))?;
    let fitted = strengths().map(|rho| (rho, phi((rho - curve.half) / curve.width)));
    chart.draw_series(LineSeries::new(fitted, MEASURED.stroke_width(3)))?;
    for bin in curve.bins.iter().filter(|bin| bin.to <= UP_TO) {
        let middle = 0.5 * (bin.from + bin.to);
        let [low, high] = bin.limits;
        chart.draw_series([PathElement::new([(middle, low), (middle, high)], MEASURED.stroke_width(2))])?;
        let share = bin.hits as f64 / bin.of as f64;
        chart.draw_series([Circle::new((middle, share), 4, MEASURED.filled())])?;
    }
    root.present()?;
    drop(chart);
    drop(root);
    Ok(())
}

/// Puts CSS variables in the place of the stand-in colours, and leaves the size to the page.
fn themed(svg: &str) -> String {
    let mut out = svg.to_owned();
    for (code, name) in NAMES {
        for attribute in ["fill", "stroke"] {
            let stand_in = format!("{attribute}=\"{code}\"");
            out = out.replace(&stand_in, &format!("style=\"{attribute}:var({name})\""));
        }
    }
    out
}
