//! Drawings by `plotters` as SVG whose colours are CSS variables, so that one drawing serves light and dark.

use plotters::coord::Shift;
use plotters::prelude::*;

/// Size of a chart in its own units; the page scales it to the column.
pub const SIZE: (u32, u32) = (560, 330);

/// Labels of the ordinate; width of a letter, and what its name and the room around it take.
const TICKS: usize = 6;
const LETTER: usize = 10;
const NAME: usize = 32;
/// Dots that show their values where the pointer rests on them, at most: more are too dense to point at.
const MOST_TITLES: usize = 600;

/// Stand-ins for the page's colours: what is drawn in them is given the CSS variable of that name.
pub(super) const INK: RGBColor = RGBColor(1, 2, 3);
pub(super) const GRID: RGBColor = RGBColor(1, 2, 4);
pub(super) const BEFORE: RGBColor = RGBColor(1, 2, 5);
pub(super) const AFTER: RGBColor = RGBColor(1, 2, 6);
const NAMES: [(&str, &str); 4] =
    [("#010203", "--ink"), ("#010204", "--grid"), ("#010205", "--before"), ("#010206", "--after")];

/// Label of an abscissa whose values are log₁₀ of a frequency in Hz; its ticks are written in Hz.
pub const LOGARITHMIC: &str = "frequency (Hz, logarithmic)";

/// What a curve stands for; it decides the colour.
#[derive(Clone, Copy, PartialEq)]
pub enum Role {
    /// Recorded.
    Recorded,
    /// Of the simulation alone.
    Before,
    /// With what was found.
    After,
    /// Noise.
    Noise,
}

impl Role {
    fn style(self) -> ShapeStyle {
        match self {
            Role::Recorded => INK.stroke_width(2),
            Role::Before => BEFORE.stroke_width(2),
            Role::After => AFTER.stroke_width(2),
            Role::Noise => INK.mix(0.4).stroke_width(1),
        }
    }
}

/// A curve.
pub struct Curve {
    /// What it stands for.
    pub role: Role,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

/// Curves over labelled axes; `None` where there is nothing finite to draw.
pub fn curves(labels: (&str, &str), curves: &[Curve]) -> Option<String> {
    let points = || curves.iter().flat_map(|c| &c.points).filter(|p| p.0.is_finite() && p.1.is_finite());
    let span = |of: fn(&(f64, f64)) -> f64| {
        points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(of(p)), b.max(of(p))))
    };
    let ((left, right), (bottom, top)) = (span(|p| p.0), span(|p| p.1));
    if !(right > left && top >= bottom) {
        return None;
    }
    let room = 0.06 * (top - bottom).max(1e-12);
    axes(labels, (left, right), (bottom - room, top + room), |chart| {
        for curve in curves {
            let finite = curve.points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite());
            chart.draw_series(LineSeries::new(finite, curve.role.style()))?;
        }
        Ok(())
    })
}

type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A cell of a map: its corners and a value from −1 to 1.
pub struct Cell {
    /// Lower left corner.
    pub from: (f64, f64),
    /// Upper right corner.
    pub to: (f64, f64),
    /// The value: its sign is the colour, its size the strength.
    pub value: f64,
}

/// A map of cells over labelled axes.
pub fn map(labels: (&str, &str), x: (f64, f64), y: (f64, f64), cells: &[Cell]) -> Option<String> {
    axes(labels, x, y, |chart| {
        chart.draw_series(cells.iter().map(|cell| {
            let colour = if cell.value > 0.0 { BEFORE } else { AFTER };
            Rectangle::new([cell.from, cell.to], colour.mix(cell.value.abs().clamp(0.04, 1.0)).filled())
        }))?;
        Ok(())
    })
}

/// What `draw` draws over labelled axes; none where there is nothing to show.
pub(super) fn axes(
    (x_label, y_label): (&str, &str),
    x: (f64, f64),
    y: (f64, f64),
    draw: impl Fn(&mut Chart) -> Drawn,
) -> Option<String> {
    let mut svg = String::new();
    let whole = |svg: &mut String| -> Drawn {
        let root: DrawingArea<SVGBackend, Shift> = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .x_label_area_size(44)
            .y_label_area_size((NAME + LETTER * longest_tick(y)) as u32)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        let text = ("sans-serif", 17).into_font().color(&INK);
        chart
            .configure_mesh()
            .x_desc(x_label)
            .y_desc(y_label)
            .x_labels(6)
            .y_labels(TICKS)
            .x_label_formatter(&|v| if x_label == LOGARITHMIC { frequency(*v) } else { short(*v) })
            .y_label_formatter(&|v| short(*v))
            .label_style(text.clone())
            .axis_desc_style(text)
            .axis_style(GRID)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .draw()?;
        draw(&mut chart)?;
        root.present()?;
        Ok(())
    };
    // Drawing into a string fails only where a range is empty; then there is nothing to show.
    whole(&mut svg).ok()?;
    Some(themed(&svg))
}

/// Letters of the longest label at the ticks of an ordinate.
fn longest_tick((low, high): (f64, f64)) -> usize {
    let range: plotters::coord::types::RangedCoordf64 = (low..high).into();
    let ticks = range.key_points(plotters::coord::ranged1d::BoldPoints(TICKS));
    ticks.iter().map(|value| short(*value).chars().count()).max().unwrap_or(1)
}

/// Gives every dot its values, in the order in which the dots are drawn.
pub(super) fn titled(svg: &str, titles: &[String]) -> String {
    let mut parts = svg.split("<circle ");
    let mut text = parts.next().unwrap_or_default().to_string();
    for (index, part) in parts.enumerate() {
        text += "<circle ";
        text += &match titles.get(index).filter(|_| titles.len() <= MOST_TITLES) {
            Some(title) => part.replacen("/>", &format!("><title>{}</title></circle>", escaped(title)), 1),
            None => part.to_string(),
        };
    }
    text
}

/// As text within SVG.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// A tick's label of a logarithmic frequency: two digits.
fn frequency(logarithm: f64) -> String {
    let value = 10f64.powf(logarithm);
    let scale = 10f64.powi(value.log10().floor() as i32 - 1);
    short((value / scale).round() * scale)
}

/// A tick's label: few digits, powers of ten where the number is very large or small.
fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.0e}").replace('-', "−");
    }
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// Puts CSS variables in the place of the stand-in colours, and leaves size to the page.
pub(super) fn themed(svg: &str) -> String {
    let mut out = svg.to_string();
    for (code, name) in NAMES {
        for attribute in ["fill", "stroke"] {
            out = out
                .replace(&format!("{attribute}=\"{code}\""), &format!("style=\"{attribute}:var({name})\""));
        }
    }
    out
}
