//! The marks of a series: dots, lines, stems, columns and error bars.

use plotters::prelude::*;

use super::axes::{Drawn, Plane};
use super::chart::{Mark, Series};

/// Radius of a dot, of one among many, of the ring around a chosen one, and of what shows the value of a curve.
const DOT: i32 = 3;
const SMALL_DOT: i32 = 2;
const RING: i32 = 8;
const TARGET: i32 = 5;
/// Dots from which on they are small.
const MANY: usize = 300;
/// Strength of dots and of bands that are seen through, and of dots that are not seen: of none, `plotters` draws nothing.
const HAZE: f64 = 0.45;
const BAND: f64 = 0.22;
const UNSEEN: f64 = 0.004;
/// Points of a curve that show their values, at most: as many as can be pointed at.
const MOST_TARGETS: usize = 120;

/// Draws a series; every circle that it draws stands for the point of that place in [`circled`].
pub(super) fn draw<Y>(chart: &mut Plane<'_, '_, Y>, series: &Series) -> Drawn
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
        Mark::Line | Mark::Curve | Mark::Both => {
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
        Mark::Band => {
            chart.draw_series([Polygon::new(points().collect::<Vec<_>>(), colour.mix(BAND).filled())])?;
        }
        Mark::Dots | Mark::Haze => {}
    }
    let size = if series.points.len() > MANY { SMALL_DOT } else { DOT };
    let dot = match series.mark {
        Mark::Dots | Mark::Both | Mark::Stems => Some((size, colour.filled())),
        Mark::Haze => Some((size, colour.mix(HAZE).filled())),
        Mark::Curve => Some((TARGET, colour.mix(UNSEEN).filled())),
        Mark::Line | Mark::Columns | Mark::Ring | Mark::Band => None,
    };
    if let Some((size, style)) = dot {
        chart.draw_series(circled(series).into_iter().map(|p| Circle::new(p, size, style)))?;
    }
    Ok(())
}

/// The points that are drawn as circles, in the order in which they are drawn; of a curve they are not seen.
pub(super) fn circled(series: &Series) -> Vec<(f64, f64)> {
    let every = match series.mark {
        Mark::Line | Mark::Columns | Mark::Band => return Vec::new(),
        Mark::Curve => series.points.len().div_ceil(MOST_TARGETS).max(1),
        _ => 1,
    };
    series.points.iter().copied().step_by(every).filter(|p| p.0.is_finite() && p.1.is_finite()).collect()
}
