//! What an effect of one column without memory adds, over that column: the residual with the effect's own part (the partial
//! residual), and the effect with its band.

use numerics::centred;
use pages::{Chart, Colour, Figure, Mark, Series};

use super::readable;
use crate::diagnosis::{FoundTerm, Outcome};
use crate::model::FittedTerm;
use crate::thresholds::NORMAL_95;
use crate::verdict::{angle_name, values_of};

/// A figure of every such effect that is handed on; `after` is the residual of all rows.
pub(super) fn figures(outcome: &Outcome, after: &[f64]) -> Vec<Figure> {
    let of = |(number, term): (usize, &FittedTerm)| {
        let found = outcome.found.iter().find(|found| found.family == term.term.family)?;
        figure(outcome, term, (number, found), after)
    };
    outcome.after.terms.iter().enumerate().filter_map(of).collect()
}

fn figure(
    outcome: &Outcome,
    term: &FittedTerm,
    (number, found): (usize, &FoundTerm),
    after: &[f64],
) -> Option<Figure> {
    let (rows, effect) = (&outcome.rows, found.effect.as_ref()?);
    let variable = match effect.argument(&term.term.shape)? {
        "angle" | "measured" | "true_angle" => angle_name(rows),
        "common_mode" => "common_mode_um".to_string(),
        column => column.to_string(),
    };
    let x = values_of(rows, &variable);
    // The level is that of the base.
    let (adds, spread) = (centred(&term.contribution), spread(term));
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
    order.dedup_by(|a, b| x[*a] == x[*b]);
    let at = |k: &usize, sigmas: f64| (x[*k], adds[*k] + sigmas * spread[*k]);
    let line = order.iter().map(|k| at(k, 0.0)).collect();
    let upper = order.iter().map(|k| at(k, NORMAL_95));
    let outline = upper.chain(order.iter().rev().map(|k| at(k, -NORMAL_95))).collect();
    let with_own = x.iter().zip(after.iter().zip(&adds)).map(|(x, (left, adds))| (*x, left + adds)).collect();
    let chart = Chart {
        label: &format!("What {} adds over {}", effect.title, readable(&variable)),
        x: readable(&variable),
        y: format!("adds ({})", rows.unit),
        series: vec![
            Series::new("residual with it", Mark::Haze, Colour::First, with_own),
            Series::new("", Mark::Band, Colour::Second, outline),
            Series::new("the effect", Mark::Line, Colour::Second, line),
        ],
    };
    Some(Figure::of(&format!("adds-{}-{}", number + 1, effect.id), &effect.title, String::new(), chart))
}

/// Standard deviation of what a term adds to each row, about its mean over the rows.
fn spread(term: &FittedTerm) -> Vec<f64> {
    let columns: Vec<Vec<f64>> = term.term.columns.iter().map(|column| centred(column)).collect();
    let n = columns.len();
    let variance = |row: usize| -> f64 {
        (0..n * n).map(|k| columns[k / n][row] * term.covariance[k] * columns[k % n][row]).sum()
    };
    (0..term.contribution.len()).map(|row| variance(row).max(0.0).sqrt()).collect()
}
