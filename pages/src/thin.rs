//! Thins points out to what a chart can show, so that a page of a million readings stays small and is drawn at once.

use super::chart::{Mark, Series};

/// Dots of a chart, at most: some 100 kB, and more than the eye tells apart.
const MOST_DOTS: usize = 1500;
/// Columns of a chart in which a line shows a lowest and a highest value: its width in its own units.
const COLUMNS: f64 = 470.0;
/// The first grid of dots: cells across and down, each as large as a dot.
const CELLS: (f64, f64) = (235.0, 130.0);

/// Leaves out what lies under other marks of its colour; how many points are left, of how many.
pub(super) fn to_pixels(series: &mut [Series]) -> (usize, usize) {
    // Lines are models and what they are compared with.
    let counted: Vec<bool> = series.iter().map(|one| !one.mark.is_line()).collect();
    let count = |series: &[Series]| -> usize {
        series.iter().zip(&counted).filter(|(_, counted)| **counted).map(|(one, _)| one.points.len()).sum()
    };
    let all = count(series);
    let Some(span) = Span::of(series) else { return (0, all) };
    for one in series.iter_mut().filter(|one| !one.mark.is_dot() && one.mark != Mark::Band) {
        if one.points.len() as f64 > 2.0 * COLUMNS {
            let kept = extremes(&one.points, &span);
            one.keep(&kept);
            one.mark = if one.mark == Mark::Both { Mark::Line } else { one.mark };
        }
    }
    let mut cells = CELLS;
    while count_dots(series) > MOST_DOTS {
        one_in_each_cell(series, &span, cells);
        cells = (cells.0 / 1.5, cells.1 / 1.5);
    }
    (count(series), all)
}

fn count_dots(series: &[Series]) -> usize {
    series.iter().filter(|one| one.mark.is_dot()).map(|one| one.points.len()).sum()
}

/// Where all points lie.
struct Span {
    low: (f64, f64),
    size: (f64, f64),
}

impl Span {
    fn of(series: &[Series]) -> Option<Span> {
        let points = || series.iter().flat_map(|one| &one.points);
        let (x, y) =
            (super::chart::range(points().map(|p| p.0))?, super::chart::range(points().map(|p| p.1))?);
        let size = |(low, high): (f64, f64)| (high - low).max(f64::MIN_POSITIVE);
        Some(Span { low: (x.0, y.0), size: (size(x), size(y)) })
    }

    /// The cell of a point in a grid of so many.
    fn cell(&self, point: (f64, f64), cells: (f64, f64)) -> (u32, u32) {
        let of = |value: f64, low: f64, size: f64, cells: f64| ((value - low) / size * cells) as u32;
        (of(point.0, self.low.0, self.size.0, cells.0), of(point.1, self.low.1, self.size.1, cells.1))
    }
}

/// The lowest and the highest point of every run of points that fall into one column.
fn extremes(points: &[(f64, f64)], span: &Span) -> Vec<usize> {
    let column = |index: usize| span.cell(points[index], (COLUMNS, 1.0)).0;
    let mut kept = Vec::new();
    let mut start = 0;
    while start < points.len() {
        let end = (start..points.len()).find(|index| column(*index) != column(start)).unwrap_or(points.len());
        let by_height = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
        let (low, high) = ((start..end).min_by(by_height), (start..end).max_by(by_height));
        let mut pair: Vec<usize> = low.into_iter().chain(high).collect();
        pair.sort_unstable();
        pair.dedup();
        kept.extend(pair);
        start = end;
    }
    kept
}

/// The first dot of each colour in each cell.
fn one_in_each_cell(series: &mut [Series], span: &Span, cells: (f64, f64)) {
    let mut taken = std::collections::HashSet::new();
    for one in series.iter_mut().filter(|one| one.mark.is_dot()) {
        let colour = one.colour;
        let kept: Vec<usize> = (0..one.points.len())
            .filter(|index| taken.insert((colour, span.cell(one.points[*index], cells))))
            .collect();
        one.keep(&kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Colour;

    fn many(mark: Mark) -> Vec<Series> {
        let points = (0..100_000).map(|i| (f64::from(i), f64::from(i * 7919 % 10_007))).collect();
        vec![Series::new("", mark, Colour::First, points)]
    }

    #[test]
    fn few_points_are_left_of_many_and_the_extremes_among_them() {
        for mark in [Mark::Dots, Mark::Line, Mark::Both, Mark::Stems] {
            let mut series = many(mark);
            let (drawn, of) = to_pixels(&mut series);
            let left = series[0].points.len();
            assert!((500..=MOST_DOTS).contains(&left), "{mark:?}: {left}");
            assert!(mark == Mark::Line || (drawn, of) == (left, 100_000));
            let (low, high) = crate::chart::range(series[0].points.iter().map(|p| p.1)).unwrap();
            assert!(low < 100.0 && high > 9_900.0, "{mark:?}: {low} … {high}");
        }
    }

    #[test]
    fn few_points_stay_as_they_are() {
        let mut series = many(Mark::Dots);
        series[0].points.truncate(MOST_DOTS);
        assert_eq!(to_pixels(&mut series), (MOST_DOTS, MOST_DOTS));
    }
}
