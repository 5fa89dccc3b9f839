//! One chart, drawn by `plotters` as SVG.

use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

use super::axes::{self, BELOW, Drawn, Plane, TEXT, decade, tick, width_beside};
use super::colour::{Colour, INK, SOFT, themed};
use super::hover::titled;
use super::{digits, marks, thin};

/// Size of a chart in its own units; the page scales it to the column.
pub(super) const SIZE: (u32, u32) = (560, 340);
/// Dots of a chart that show their values where the pointer rests on them, at most: more are too dense to point at.
const MOST_TITLES: usize = 600;

/// How the axes are divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Evenly.
    Even,
    /// The ordinate by its logarithm.
    Logarithmic,
    /// Abscissas are log₁₀ of what stands at the ticks.
    Decades,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Points alone.
    Dots,
    /// The same, seen through: what lies among them is seen as well.
    Haze,
    /// A line alone.
    Line,
    /// A line whose points show their values.
    Curve,
    /// Dots on a line.
    Both,
    /// Dots on a stem from zero.
    Stems,
    /// Columns from zero, as wide as the points are apart.
    Columns,
    /// A ring around each point, which marks it among others.
    Ring,
    /// An area seen through, whose outline the points are.
    Band,
}

impl Mark {
    /// Whether it is a dot by itself.
    pub(super) fn is_dot(self) -> bool {
        matches!(self, Mark::Dots | Mark::Haze)
    }

    /// Whether it is a line without dots, or an area about one.
    pub(super) fn is_line(self) -> bool {
        matches!(self, Mark::Line | Mark::Curve | Mark::Band)
    }
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

    /// The SVG, whose marks show their values where the pointer rests on them; blank where there is no finite point.
    pub fn draw(&self, scale: Scale) -> String {
        let mut svg = String::new();
        // Drawing into a string fails only where a range is empty; then there is nothing to show.
        if self.draw_into(&mut svg, scale).is_err() {
            return String::new();
        }
        themed(&titled(&svg, self.label, "circle", self.titles(scale).into_iter()))
    }

    /// The values of every circle in the order of the drawing: those of the legend have none.
    fn titles(&self, scale: Scale) -> Vec<Option<String>> {
        let dots = self.series.iter().filter(|series| !series.mark.is_line());
        let dense = dots.map(|series| marks::circled(series).len()).sum::<usize>() > MOST_TITLES;
        let legend = self.named().filter(|series| !series.mark.is_line()).map(|_| None);
        let circles = self.series.iter().flat_map(|series| {
            let shown = series.mark.is_line() || !dense;
            let title = move |point| shown.then(|| self.title(series, point, scale));
            marks::circled(series).into_iter().map(title)
        });
        legend.chain(circles).collect()
    }

    fn title(&self, series: &Series, (x, y): (f64, f64), scale: Scale) -> String {
        let name = if series.name.is_empty() { String::new() } else { format!("{}: ", series.name) };
        let x = if scale == Scale::Decades { decade(x) } else { digits(x) };
        format!("{name}{} {x}, {} {}", self.x, self.y, digits(y))
    }

    /// The series that the legend names.
    fn named(&self) -> impl Iterator<Item = &Series> {
        self.series.iter().filter(|series| !series.name.is_empty())
    }

    fn draw_into(&self, svg: &mut String, scale: Scale) -> Drawn {
        let ends = self.series.iter().flat_map(Series::ends);
        let all: Vec<(f64, f64)> = ends.filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
        let range = |of: fn(&(f64, f64)) -> f64| range(all.iter().map(of)).ok_or("no point");
        let (x, y) = (range(|p| p.0)?, range(|p| p.1)?);
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        self.legend(&root)?;
        let x = widened(x, 0.03);
        let mut builder = ChartBuilder::on(&root);
        builder.margin(10).margin_top(30).margin_right(16).x_label_area_size(BELOW);
        if scale == Scale::Logarithmic {
            builder.y_label_area_size(width_beside(None));
            let chart = builder.build_cartesian_2d(x.0..x.1, (y.0 / 1.4..y.1 * 1.4).log_scale())?;
            self.fill(chart, tick, None)?;
        } else {
            let from_zero = |series: &Series| matches!(series.mark, Mark::Stems | Mark::Columns);
            let y = if self.series.iter().any(from_zero) { (y.0.min(0.0), y.1.max(0.0)) } else { y };
            let y = widened(y, 0.08);
            builder.y_label_area_size(width_beside(Some(y)));
            let chart = builder.build_cartesian_2d(x.0..x.1, y.0..y.1)?;
            match scale {
                Scale::Decades => self.fill(chart, decade, None)?,
                _ => self.fill(chart, tick, (y.0..y.1).contains(&0.0).then_some(x))?,
            }
        }
        root.present()?;
        Ok(())
    }

    /// Names of the series above the chart, each in its colour.
    fn legend(&self, root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>) -> Drawn {
        let mut x = 84;
        for series in self.named() {
            let colour = series.colour.of();
            if series.mark.is_line() {
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

    /// Axes and series; a line at zero from end to end of `zero`.
    fn fill<Y>(
        &self,
        mut chart: Plane<'_, '_, Y>,
        abscissa: fn(f64) -> String,
        zero: Option<(f64, f64)>,
    ) -> Drawn
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        axes::draw(&mut chart, (&self.x, &self.y), abscissa)?;
        if let Some((from, to)) = zero {
            chart.draw_series(LineSeries::new([(from, 0.0), (to, 0.0)], SOFT.stroke_width(1)))?;
        }
        for series in &self.series {
            marks::draw(&mut chart, series)?;
        }
        Ok(())
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
