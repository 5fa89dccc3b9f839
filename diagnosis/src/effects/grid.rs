//! The ranges of an effect's shape parameters, and the shapes from which the search starts.

use physics::{Formula, Grid, Role, Scale, Starts};

use super::read::Figures;
use super::{Effect, Range};
use crate::rows::Rows;
use crate::thresholds::effects::grid::{LOGARITHMIC, MOST_ROWS, STARTS};

impl Effect {
    /// Ranges of the shape parameters.
    pub fn ranges(&self, rows: &Rows) -> Vec<Range> {
        self.ranges_by(&Figures::of(rows), rows)
    }

    fn ranges_by(&self, figures: &Figures, rows: &Rows) -> Vec<Range> {
        let none = vec![0.0; self.made.declared.parameters.len()];
        let at = |formula: &Formula| Effect::figure(figures, formula, &none);
        let whole = |low: f64, high: f64| Range { low, high, logarithmic: false, whole: true };
        let range = |index: &usize| match &self.parameter(*index).role {
            Role::Searched(grid) => {
                let (low, high) = (at(&grid.from), at(&grid.to));
                Range { low, high, logarithmic: scale(grid, low, high) != Scale::Linear, whole: false }
            }
            Role::Follows(from, _) => {
                Range { low: at(from), high: at(from), logarithmic: true, whole: false }
            }
            Role::Row => whole(2.0, rows.len() as f64 - 2.0),
            Role::Sum(_) | Role::Factor(_) => whole(1.0, 1.0),
        };
        let mut ranges: Vec<Range> = self.made.shaped.iter().map(range).collect();
        let forms = self.made.declared.adds.len();
        if forms > 1 {
            ranges.push(whole(0.0, (forms - 1) as f64));
        }
        ranges
    }

    /// Shapes from which the search starts; one empty shape where there is no shape parameter. Those of the last parameter
    /// change least often, since those of others may depend on it; the forms change most often.
    pub fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        let figures = Figures::of(rows);
        let ranges = self.ranges_by(&figures, rows);
        let mut starts = vec![vec![0.0; ranges.len()]];
        for k in (0..self.made.shaped.len()).rev() {
            let with = |start: &Vec<f64>| {
                self.starts_of((&figures, rows), k, &ranges[k], start)
                    .into_iter()
                    .map(|value| put(start, k, value))
                    .collect()
            };
            starts = starts.iter().flat_map::<Vec<Vec<f64>>, _>(with).collect();
        }
        if ranges.len() > self.made.shaped.len() {
            let forms = |start: &Vec<f64>| {
                (0..self.made.declared.adds.len())
                    .map(|form| put(start, ranges.len() - 1, form as f64))
                    .collect()
            };
            starts = starts.iter().flat_map::<Vec<Vec<f64>>, _>(forms).collect();
        }
        starts
    }

    /// The starts of shape parameter `k`, where those after it have the values of `shape`.
    fn starts_of(
        &self,
        (figures, rows): (&Figures, &Rows),
        k: usize,
        range: &Range,
        shape: &[f64],
    ) -> Vec<f64> {
        let values = self.values(rows, shape, &vec![0.0; self.made.factors.len()]);
        let Range { low, high, .. } = *range;
        match &self.parameter(self.made.shaped[k]).role {
            Role::Searched(grid) => {
                let scale = scale(grid, low, high);
                match &grid.starts {
                    Starts::At(all) => all.iter().map(|at| Effect::figure(figures, at, &values)).collect(),
                    Starts::Every(distance, ends) => {
                        let at = |formula| Effect::figure(figures, formula, &values);
                        let distance = at(distance);
                        if scale == Scale::Inverse {
                            let inverse = |k: i32| 1.0 / high + f64::from(k) * distance;
                            return (0..)
                                .map(inverse)
                                .take_while(|x| x * low <= 1.0)
                                .map(|x| 1.0 / x)
                                .collect();
                        }
                        let (from, to) =
                            if let [from, to] = &ends[..] { (at(from), at(to)) } else { (low, high) };
                        // Rounding makes no whole number of distances one less.
                        let count = ((to - from) / distance + 1e-9).floor().max(1.0);
                        (0..=count as usize).map(|k| from + (to - from) * k as f64 / count).collect()
                    }
                    Starts::Over(count) => {
                        let count = count.unwrap_or(STARTS);
                        let even = |k: usize| low + (high - low) * (k as f64 + 0.5) / count as f64;
                        let by_ratio =
                            |k: usize| low * (high / low).powf(k as f64 / (count.max(2) - 1) as f64);
                        let place = |k| if scale == Scale::Linear { even(k) } else { by_ratio(k) };
                        (0..count).map(place).collect()
                    }
                }
            }
            // The search tries every row; these stand for them where a few will do.
            Role::Row => {
                let stride = rows.len().div_ceil(MOST_ROWS).max(1);
                (2..rows.len().saturating_sub(1)).step_by(stride).map(|row| row as f64).collect()
            }
            _ => vec![low],
        }
    }

    /// Over what distance of shape parameter `k` (of its logarithm, where it is sought on that scale) the signature stays
    /// much the same; none where a hundredth of the range is little enough.
    pub fn spacing(&self, rows: &Rows, k: usize, shape: &[f64]) -> Option<f64> {
        let Role::Searched(grid) = &self.parameter(*self.made.shaped.get(k)?).role else { return None };
        let values = self.values(rows, shape, &vec![0.0; self.made.factors.len()]);
        Some(Effect::figure(&Figures::of(rows), grid.alike.as_ref()?, &values))
    }
}

fn put(shape: &[f64], k: usize, value: f64) -> Vec<f64> {
    let mut shape = shape.to_vec();
    shape[k] = value;
    shape
}

/// The scale of a parameter from `low` to `high`.
fn scale(grid: &Grid, low: f64, high: f64) -> Scale {
    let by_ratio = low > 0.0 && high > LOGARITHMIC * low;
    grid.scale.unwrap_or(if by_ratio { Scale::Logarithmic } else { Scale::Linear })
}
