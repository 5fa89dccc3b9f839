//! One chart, drawn by `plotters` as SVG whose colours are CSS variables, so that one drawing serves a light and
//! a dark page.

use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

use super::{marks, thin};

/// Size of a chart in its own units; the page scales it to the column.
pub(super) const SIZE: (u32, u32) = (560, 340);
/// Size of the text: readable where a phone shows the chart at three fifths.
const TEXT: u32 = 18;
/// Width of a letter of the text, and what stands between an axis and its name: the name, and room around it.
const LETTER: i32 = 10;
const NAME: i32 = 34;
/// Labels of the ordinate, and letters of the longest where it is logarithmic: 0.001.
const TICKS: usize = 6;
const LOGARITHMIC_LETTERS: i32 = 5;
/// Circles of a chart that show their values where the pointer rests on them, at most: more are too dense to point at.
const MOST_TITLES: usize = 600;

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Colour {
    /// Measured before, backward, testing.
    First,
    /// Modelled, forward, training.
    Second,
    /// What is only there to compare with.
    Soft,
    /// What points something out.
    Ink,
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
    /// Columns from zero, as wide as the points are apart.
    Columns,
    /// A ring around each point, which marks it among others.
    Ring,
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
    /// Half the length of the error bar of each point; blank where there are none.
    pub bars: Vec<f64>,
}

impl Series {
    /// A series without error bars.
    pub fn new(name: &str, mark: Mark, colour: Colour, points: Vec<(f64, f64)>) -> Series {
        Series { name: name.to_string(), points, mark, colour, bars: Vec::new() }
    }

    /// The same with error bars of half these lengths.
    pub fn with_bars(self, bars: Vec<f64>) -> Series {
        Series { bars, ..self }
    }

    /// Leaves these points and their error bars.
    pub(super) fn keep(&mut self, kept: &[usize]) {
        self.points = kept.iter().map(|index| self.points[*index]).collect();
        self.bars = kept.iter().filter_map(|index| self.bars.get(*index).copied()).collect();
    }

    /// Half the width of a column.
    pub(super) fn half_width(&self) -> f64 {
        match self.points.as_slice() {
            [first, second, ..] => 0.5 * (second.0 - first.0),
            _ => 0.5,
        }
    }

    /// The ends of what is drawn: of points, error bars and columns.
    fn ends(&self) -> Vec<(f64, f64)> {
        let half = if self.mark == Mark::Columns { self.half_width() } else { 0.0 };
        let bars = self.bars.iter().copied().chain(std::iter::repeat(0.0));
        (self.points.iter().zip(bars))
            .flat_map(|((x, y), bar)| [(x - half, y - bar), (x + half, y + bar)])
            .collect()
    }
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
    /// Leaves out what lies under other marks; how many points are left, of how many.
    pub(super) fn thin(&mut self) -> (usize, usize) {
        thin::to_pixels(&mut self.series)
    }

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
        let head = format!("<svg role=\"img\" aria-label=\"{}\" ", escaped(self.label));
        themed(&self.titled(&svg.replacen("<svg ", &head, 1)))
    }

    /// Gives every circle its values, which a browser shows where the pointer rests on it.
    fn titled(&self, svg: &str) -> String {
        let named = self.named().filter(|series| series.mark != Mark::Line).map(|_| None);
        let circles = self.series.iter().flat_map(|series| {
            marks::circled(series).into_iter().map(move |point| Some((series.name.as_str(), point)))
        });
        let titles: Vec<Option<(&str, (f64, f64))>> = named.chain(circles).collect();
        if titles.len() > MOST_TITLES {
            return svg.to_string();
        }
        let mut parts = svg.split("<circle ");
        let mut text = parts.next().unwrap_or_default().to_string();
        for (part, title) in parts.zip(titles) {
            let title = title.map(|(name, (x, y))| {
                let name = if name.is_empty() { String::new() } else { format!("{name}: ") };
                let values =
                    format!("{name}{} {}, {} {}", self.x, super::digits(x), self.y, super::digits(y));
                format!("><title>{}</title></circle>", escaped(&values))
            });
            text += "<circle ";
            text += &part.replacen("/>", title.as_deref().unwrap_or("/>"), 1);
        }
        text
    }

    /// The series that the legend names.
    fn named(&self) -> impl Iterator<Item = &Series> {
        self.series.iter().filter(|series| !series.name.is_empty())
    }

    fn draw_into(&self, svg: &mut String, logarithmic: bool) -> Result<(), Box<dyn std::error::Error>> {
        let ends = self.series.iter().flat_map(Series::ends);
        let all: Vec<(f64, f64)> = ends.filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
        let range = |of: fn(&(f64, f64)) -> f64| range(all.iter().map(of)).ok_or("no point");
        let (x, y) = (range(|p| p.0)?, range(|p| p.1)?);
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        self.legend(&root)?;
        let x = widened(x, 0.03);
        let mut builder = ChartBuilder::on(&root);
        builder.margin(10).margin_top(30).margin_right(16).x_label_area_size(50);
        if logarithmic {
            builder.y_label_area_size(NAME + LETTER * LOGARITHMIC_LETTERS);
            let chart = builder.build_cartesian_2d(x.0..x.1, (y.0 / 1.4..y.1 * 1.4).log_scale())?;
            self.fill(chart, x, !logarithmic)?;
        } else {
            let from_zero = |series: &Series| matches!(series.mark, Mark::Stems | Mark::Columns);
            let y = if self.series.iter().any(from_zero) { (y.0.min(0.0), y.1.max(0.0)) } else { y };
            let y = widened(y, 0.08);
            builder.y_label_area_size(NAME + LETTER * longest_tick(y));
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
        for series in self.named() {
            let colour = series.colour.of();
            if series.mark == Mark::Line {
                root.draw(&PathElement::new([(x - 8, 16), (x + 6, 16)], colour.stroke_width(3)))?;
            } else if series.mark == Mark::Ring {
                root.draw(&Circle::new((x, 16), 5, colour.stroke_width(2)))?;
            } else {
                root.draw(&Circle::new((x, 16), 5, colour.filled()))?;
            }
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
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_labels(7)
            .y_labels(TICKS)
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
            marks::draw(&mut chart, series)?;
        }
        Ok(())
    }
}

/// A tick's label.
fn tick(value: &f64) -> String {
    super::digits(if value.abs() < 1e-12 { 0.0 } else { *value })
}

/// Letters of the longest label at the ticks of a range.
fn longest_tick((low, high): (f64, f64)) -> i32 {
    let range: plotters::coord::types::RangedCoordf64 = (low..high).into();
    let ticks = range.key_points(plotters::coord::ranged1d::BoldPoints(TICKS));
    ticks.iter().map(|value| tick(value).chars().count()).max().unwrap_or(1) as i32
}

/// As text within SVG.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

impl Colour {
    pub(super) fn of(self) -> RGBColor {
        match self {
            Colour::First => FIRST,
            Colour::Second => SECOND,
            Colour::Soft => SOFT,
            Colour::Ink => INK,
        }
    }
}

/// Least and largest of some values.
pub(super) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, value| {
        Some(range.map_or((value, value), |(low, high): (f64, f64)| (low.min(value), high.max(value))))
    })
}

fn widened((low, high): (f64, f64), part: f64) -> (f64, f64) {
    let room = part * (high - low).max(1e-9 * low.abs().max(high.abs())).max(1e-12);
    (low - room, high + room)
}

impl Colour {
    /// The CSS variable of its name.
    pub(super) fn variable(self) -> &'static str {
        match self {
            Colour::First => "var(--before)",
            Colour::Second => "var(--after)",
            Colour::Soft => "var(--soft)",
            Colour::Ink => "var(--ink)",
        }
    }
}

/// Puts CSS variables in the place of the stand-in colours, and leaves the size to the page.
fn themed(svg: &str) -> String {
    // What is said here of every circle is what SVG takes it for anyway.
    let short = svg.replace(" opacity=\"1\"", "").replace(" stroke=\"none\" stroke-width=\"1\"", "");
    NAMES.iter().fold(short, |svg, (code, name, _)| {
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
