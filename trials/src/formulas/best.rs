//! The best nonlinear parameters of a formula: a grid, then steps that halve.

use super::{Columns, Formula};
use crate::linear::{Basis, Whitener};

/// A formula at nonlinear parameters.
#[derive(Clone)]
pub struct Shaped {
    pub formula: &'static Formula,
    pub shape: Vec<f64>,
}

/// Places of the grid from which to climb where one is not enough: a wide bump beside a polynomial has more than one
/// summit.
pub const SEVERAL: usize = 8;

/// A recording and the metric in which formulas are fitted to it.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    pub columns: &'a Columns,
    pub whitener: &'a Whitener,
}

impl Search<'_> {
    /// The columns of a formula, whitened.
    pub fn white(&self, shaped: &Shaped) -> Vec<Vec<f64>> {
        let columns = (shaped.formula.signature)(self.columns, &shaped.shape);
        columns.iter().map(|c| self.whitener.whiten(c)).collect()
    }

    /// The nonlinear parameters at which `formula` explains most of the squared norm of `target` (whitened and
    /// orthogonal to `basis`), and how much that is: from the best places of the grid, so many of them.
    pub fn best(
        &self,
        formula: &'static Formula,
        basis: &Basis,
        target: &[f64],
        starts: usize,
    ) -> (Shaped, f64) {
        let grid = (formula.grid)(self.columns);
        let value =
            |shape: &[f64]| basis.explained(&self.white(&Shaped { formula, shape: shape.to_vec() }), target);
        let mut tried: Vec<(Vec<f64>, f64)> = grid.places.iter().map(|p| (p.clone(), value(p))).collect();
        tried.sort_by(|a, b| b.1.total_cmp(&a.1));
        let climbed =
            tried.into_iter().take(starts).map(|(place, first)| climb(place, first, &grid.spacing, &value));
        let (shape, explained) =
            climbed.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Vec::new(), f64::NEG_INFINITY));
        (Shaped { formula, shape }, explained)
    }

    /// Joint refinement of the nonlinear parameters of several formulas, so that together they explain most.
    pub fn jointly(&self, together: Vec<Shaped>, basis: &Basis, target: &[f64]) -> Vec<Shaped> {
        let grid = |shaped: &Shaped| (shaped.formula.grid)(self.columns).spacing;
        let spacing: Vec<f64> = together.iter().flat_map(grid).collect();
        if spacing.is_empty() {
            return together;
        }
        let start: Vec<f64> = together.iter().flat_map(|s| s.shape.clone()).collect();
        let at = |all: &[f64]| -> Vec<Shaped> {
            let mut rest = all;
            let mut own = |shaped: &Shaped| {
                let (own, others) = rest.split_at(shaped.shape.len());
                rest = others;
                Shaped { formula: shaped.formula, shape: own.to_vec() }
            };
            together.iter().map(&mut own).collect()
        };
        let value = |all: &[f64]| {
            let wide: Vec<Vec<f64>> = at(all).iter().flat_map(|s| self.white(s)).collect();
            basis.explained(&wide, target)
        };
        let first = value(&start);
        at(&climb(start, first, &spacing, &value).0)
    }
}

/// Coordinate steps of half the spacing, halved whenever none helps, down to a thousandth.
fn climb(start: Vec<f64>, first: f64, spacing: &[f64], value: &dyn Fn(&[f64]) -> f64) -> (Vec<f64>, f64) {
    let (mut place, mut best) = (start, first);
    let mut part = 0.5;
    while part > 1e-3 && !spacing.is_empty() {
        let mut moved = false;
        for k in 0..spacing.len() {
            for sign in [1.0, -1.0] {
                let mut tried = place.clone();
                tried[k] += sign * part * spacing[k];
                let explained = value(&tried);
                if explained > best {
                    (place, best, moved) = (tried, explained, true);
                }
            }
        }
        if !moved {
            part *= 0.5;
        }
    }
    (place, best)
}
