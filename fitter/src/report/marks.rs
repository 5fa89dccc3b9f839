//! The marks of a series: dots, lines, stems, columns and error bars.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::chart::{Mark, Series};

/// The coordinates that a series is drawn in.
pub(super) type Plane<'a, 'b, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, Y>>;

/// Radius of a dot, of one among many, and of the ring around a chosen one.
const DOT: i32 = 3;
const SMALL_DOT: i32 = 2;
const RING: i32 = 8;
/// Dots from which on they are small.
const MANY: usize = 300;

/// Draws a series; every circle that it draws stands for the point of that place in [`circled`].
pub(super) fn draw<Y>(chart: &mut Plane<'_, '_, Y>, series: &Series) -> Result<(), Box<dyn std::error::Error>>
where
    Y: Ranged<ValueType = f64>,
{
    let colour = series.colour.of();
    let points = || series.points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite());
    for ((x, y), half) in
        series.points.iter().zip(&series.bars).filter(|((x, y), _)| x.is_finite() && y.is_finite())
    {
        chart.draw_series(LineSeries::new([(*x, y - half), (*x, y + half)], colour.stroke_width(1)))?;
    }
    match series.mark {
        Mark::Stems => {
            for (x, y) in points() {
                chart.draw_series(LineSeries::new([(x, 0.0), (x, y)], colour.stroke_width(2)))?;
            }
        }
        Mark::Line | Mark::Both => {
            chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?;
        }
        Mark::Columns => {
            let half = series.half_width();
            let column = |(x, y): (f64, f64)| {
                Rectangle::new([(x - half, 0.0), (x + half, y)], colour.mix(0.55).filled())
            };
            chart.draw_series(points().map(column))?;
        }
        Mark::Ring => {
            chart.draw_series(points().map(|p| Circle::new(p, RING, colour.stroke_width(2))))?;
        }
        Mark::Dots => {}
    }
    if matches!(series.mark, Mark::Dots | Mark::Both | Mark::Stems) {
        let size = if series.points.len() > MANY { SMALL_DOT } else { DOT };
        chart.draw_series(points().map(|p| Circle::new(p, size, colour.filled())))?;
    }
    Ok(())
}

/// The points that are drawn as circles, in the order in which they are drawn.
pub(super) fn circled(series: &Series) -> Vec<(f64, f64)> {
    match series.mark {
        Mark::Line | Mark::Columns => Vec::new(),
        _ => series.points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect(),
    }
}
