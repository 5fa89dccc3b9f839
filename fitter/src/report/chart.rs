//! One chart, drawn by `plotters` as SVG whose colours are CSS variables, so that one drawing serves a light and
//! a dark page.

use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

/// Size of a chart in its own units; the page scales it to the column.
const SIZE: (u32, u32) = (560, 340);
/// Size of the text: readable where a phone shows the chart at three fifths.
const TEXT: u32 = 18;
/// Most points of a series that are drawn; of more evenly chosen ones.
const MOST_POINTS: usize = 2000;

/// Stand-ins for the page's colours: what is drawn in them is given the CSS variable of that name.
const INK: RGBColor = RGBColor(1, 2, 3);
const GRID: RGBColor = RGBColor(1, 2, 4);
const FIRST: RGBColor = RGBColor(1, 2, 5);
const SECOND: RGBColor = RGBColor(1, 2, 6);
const SOFT: RGBColor = RGBColor(1, 2, 7);
/// Stand-in, CSS variable, colours on a light and on a dark page.
const NAMES: [(&str, &str, [&str; 2]); 5] = [
    ("#010203", "--ink", ["#1d2430", "#e6e9ee"]),
    ("#010204", "--grid", ["#d5dae1", "#3a4250"]),
    ("#010205", "--before", ["#c2571a", "#f0935a"]),
    ("#010206", "--after", ["#1f6fb2", "#6cb2ee"]),
    ("#010207", "--soft", ["#5a6473", "#9aa4b2"]),
];
/// The ground of a light and of a dark page.
const GROUND: [&str; 2] = ["#ffffff", "#0d1117"];

/// What a drawing of its own stands on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Page {
    Light,
    Dark,
}

/// What a series is drawn in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Colour {
    /// Measured before, backward, testing.
    First,
    /// Modelled, forward, training.
    Second,
    /// What is only there to compare with.
    Soft,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// Points alone.
    Dots,
    /// A line alone.
    Line,
    /// Dots on a line.
    Both,
    /// Dots on a stem from zero.
    Stems,
}

/// Points of one kind.
pub struct Series {
    /// In the legend; nothing where blank.
    pub name: String,
    /// Abscissa and ordinate.
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub mark: Mark,
    /// In what.
    pub colour: Colour,
}

/// A chart before it is drawn.
pub struct Chart<'a> {
    /// For those who do not see it.
    pub label: &'a str,
    /// What the abscissa is.
    pub x: String,
    /// What the ordinate is.
    pub y: String,
    /// What is drawn, the first lowest.
    pub series: Vec<Series>,
}

impl Chart<'_> {
    /// The SVG; blank where there is no finite point.
    pub fn draw(&self) -> String {
        self.drawn(false)
    }

    /// The same with a logarithmic ordinate.
    pub fn draw_logarithmic(&self) -> String {
        self.drawn(true)
    }

    fn drawn(&self, logarithmic: bool) -> String {
        let mut svg = String::new();
        // Drawing into a string fails only where a range is empty; then there is nothing to show.
        if self.draw_into(&mut svg, logarithmic).is_err() {
            return String::new();
        }
        let label = self.label.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let head = format!("<svg role=\"img\" aria-label=\"{label}\" ");
        themed(&svg.replacen("<svg ", &head, 1))
    }

    fn draw_into(&self, svg: &mut String, logarithmic: bool) -> Result<(), Box<dyn std::error::Error>> {
        let all = || {
            self.series
                .iter()
                .flat_map(|series| &series.points)
                .filter(|p| p.0.is_finite() && p.1.is_finite())
        };
        let (x, y) =
            (range(all().map(|p| p.0)).ok_or("no point")?, range(all().map(|p| p.1)).ok_or("no point")?);
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        self.legend(&root)?;
        let x = widened(x, 0.03);
        let mut builder = ChartBuilder::on(&root);
        builder.margin(10).margin_top(30).margin_right(16).x_label_area_size(50).y_label_area_size(70);
        if logarithmic {
            let chart = builder.build_cartesian_2d(x.0..x.1, (y.0 / 1.4..y.1 * 1.4).log_scale())?;
            self.fill(chart, x, !logarithmic)?;
        } else {
            let stems = self.series.iter().any(|series| series.mark == Mark::Stems);
            let y = if stems { (y.0.min(0.0), y.1.max(0.0)) } else { y };
            let y = widened(y, 0.08);
            let chart = builder.build_cartesian_2d(x.0..x.1, y.0..y.1)?;
            self.fill(chart, x, !logarithmic)?;
        }
        root.present()?;
        Ok(())
    }

    /// Names of the series above the chart, each in its colour.
    fn legend(
        &self,
        root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let mut x = 84;
        for series in self.series.iter().filter(|series| !series.name.is_empty()) {
            root.draw(&Circle::new((x, 16), 5, series.colour.of().filled()))?;
            let font = ("sans-serif", TEXT).into_font().color(&INK);
            root.draw(&Text::new(series.name.clone(), (x + 10, 7), font))?;
            x += 30 + 9 * series.name.chars().count() as i32;
        }
        Ok(())
    }

    fn fill<Y>(
        &self,
        mut chart: ChartContext<'_, SVGBackend<'_>, Cartesian2d<plotters::coord::types::RangedCoordf64, Y>>,
        x: (f64, f64),
        zero: bool,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let text = ("sans-serif", TEXT).into_font().color(&INK);
        let tick = |value: &f64| super::digits(if value.abs() < 1e-12 { 0.0 } else { *value });
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_labels(7)
            .y_labels(6)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .label_style(text.clone())
            .axis_desc_style(text)
            .axis_style(GRID)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .draw()?;
        if zero {
            chart.draw_series(LineSeries::new([(x.0, 0.0), (x.1, 0.0)], SOFT.stroke_width(1)))?;
        }
        for series in &self.series {
            let stride = series.points.len().div_ceil(MOST_POINTS).max(1);
            let points: Vec<(f64, f64)> = series
                .points
                .iter()
                .copied()
                .filter(|p| p.0.is_finite() && p.1.is_finite())
                .step_by(stride)
                .collect();
            let colour = series.colour.of();
            if series.mark == Mark::Stems {
                for (x, y) in &points {
                    chart.draw_series(LineSeries::new([(*x, 0.0), (*x, *y)], colour.stroke_width(2)))?;
                }
            }
            if matches!(series.mark, Mark::Line | Mark::Both) {
                chart.draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?;
            }
            if series.mark != Mark::Line {
                let size = if points.len() > 300 { 2 } else { 3 };
                chart.draw_series(points.iter().map(|p| Circle::new(*p, size, colour.filled())))?;
            }
        }
        Ok(())
    }
}

impl Colour {
    fn of(self) -> RGBColor {
        match self {
            Colour::First => FIRST,
            Colour::Second => SECOND,
            Colour::Soft => SOFT,
        }
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, value| {
        Some(range.map_or((value, value), |(low, high): (f64, f64)| (low.min(value), high.max(value))))
    })
}

fn widened((low, high): (f64, f64), part: f64) -> (f64, f64) {
    let room = part * (high - low).max(1e-9 * low.abs().max(high.abs())).max(1e-12);
    (low - room, high + room)
}

/// Puts CSS variables in the place of the stand-in colours, and leaves the size to the page.
fn themed(svg: &str) -> String {
    NAMES.iter().fold(svg.to_string(), |svg, (code, name, _)| {
        ["fill", "stroke"].iter().fold(svg, |svg, attribute| {
            svg.replace(&format!("{attribute}=\"{code}\""), &format!("style=\"{attribute}:var({name})\""))
        })
    })
}

/// The SVG with the colours of a page, and a ground to stand on.
pub(super) fn standing_alone(svg: &str, page: Page) -> String {
    let coloured = NAMES.iter().fold(svg.to_string(), |svg, (_, name, colours)| {
        svg.replace(&format!("var({name})"), colours[page as usize])
    });
    let fill = GROUND[page as usize];
    let ground = format!("<rect width=\"{}\" height=\"{}\" fill=\"{fill}\"/>", SIZE.0, SIZE.1);
    match coloured.find('>') {
        Some(end) => format!("{}\n{ground}{}", &coloured[..=end], &coloured[end + 1..]),
        None => coloured,
    }
}
