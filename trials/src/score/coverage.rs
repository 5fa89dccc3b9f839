//! Whether the 95 % intervals hold the truth, wherever a concealed effect was named.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Case, Figure, Share, Sheet};
use crate::answer::Parameter;
use crate::statistics::{binomial_p_value, percentile};
use crate::truth::Group;

/// What the intervals claim, and what is wanted of each effect's in each schedule.
const CLAIMED: f64 = 0.95;
const WANTED: std::ops::RangeInclusive<f64> = 0.92..=0.98;
/// The chance of calling any parameter inconsistent although all are right, over all of them.
const OVER_ALL: f64 = 0.01;

/// Coverage of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Covered {
    /// The effect.
    pub id: String,
    /// The parameter.
    pub parameter: String,
    /// How many intervals hold the truth.
    pub share: Share,
    /// Two-sided binomial p-value against 95 %.
    pub p_value: f64,
    /// Whether it is consistent with 95 %, at 1 % over all parameters.
    pub consistent: bool,
}

/// Coverage of one parameter in one schedule.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// The effect.
    pub id: String,
    /// The parameter.
    pub parameter: String,
    /// The schedule.
    pub schedule: String,
    /// How many intervals hold the truth.
    pub covered: Share,
    /// How many lie above the truth.
    pub above: u64,
    /// How many estimates lie inside their own interval.
    pub own: Share,
    /// The median width beside the median of |truth|.
    pub width: f64,
    /// Whether the coverage is refuted to lie within 92 and 98 % (two-sided, 1 % over all cells).
    pub refuted: bool,
}

/// The parameters of concealed effects that were named, each with its truth. A number of harmonics is counted,
/// not measured.
fn parameters_of(case: &Case) -> Vec<(&str, &Parameter, f64)> {
    let Some(answer) = &case.answer else { return Vec::new() };
    let mut list = Vec::new();
    for effect in &case.truth.effects {
        let Some(named) = answer.effects.iter().find(|n| n.id == effect.id) else { continue };
        for parameter in named.parameters.iter().filter(|p| p.name != "harmonics") {
            let Some(truth) = effect.parameters.get(&parameter.name) else { continue };
            list.push((effect.id.as_str(), parameter, *truth));
        }
    }
    list
}

fn holds([from, to]: [f64; 2], value: f64) -> bool {
    from <= value && value <= to
}

/// The intervals of effects that are found for certain, by schedule.
pub(super) fn by_schedule(cases: &[Case], sheet: &mut Sheet) -> Vec<Cell> {
    /// Effect, parameter and schedule.
    type Key<'a> = (&'a str, &'a str, &'a str);
    let mut cells: BTreeMap<Key, Vec<(&Parameter, f64)>> = BTreeMap::new();
    for case in cases.iter().filter(|c| c.truth.group == Group::Interval) {
        for (id, parameter, truth) in parameters_of(case) {
            let key = (id, parameter.name.as_str(), case.truth.schedule.as_str());
            cells.entry(key).or_default().push((parameter, truth));
            if !holds(parameter.ci95, truth) {
                let [from, to] = parameter.ci95;
                let said = format!("{} {} in [{from}, {to}], truth {truth}", parameter.name, parameter.value);
                sheet.miss("coverage by schedule", case, said);
            }
        }
    }
    let count = cells.len().max(1) as f64;
    let cell = |((id, parameter, schedule), stated): (Key, Vec<(&Parameter, f64)>)| {
        let (mut covered, mut own) = (Share::default(), Share::default());
        for (parameter, truth) in &stated {
            covered.count(holds(parameter.ci95, *truth));
            own.count(holds(parameter.ci95, parameter.value));
        }
        let median = |of: &dyn Fn(&(&Parameter, f64)) -> f64| {
            percentile(&stated.iter().map(of).collect::<Vec<f64>>(), 0.5).unwrap_or(0.0)
        };
        let width = median(&|(p, _)| p.ci95[1] - p.ci95[0]) / median(&|(_, truth)| truth.abs());
        // The nearest share that is wanted.
        let nearest = covered.value().unwrap_or(CLAIMED).clamp(*WANTED.start(), *WANTED.end());
        let inside = covered.value().is_some_and(|value| WANTED.contains(&value));
        let p_value = binomial_p_value(covered.hits, covered.of, nearest);
        Cell {
            id: id.to_owned(),
            parameter: parameter.to_owned(),
            schedule: schedule.to_owned(),
            covered,
            above: stated.iter().filter(|(p, truth)| *truth < p.ci95[0]).count() as u64,
            own,
            width,
            refuted: !inside && p_value < OVER_ALL / count,
        }
    };
    let rows: Vec<Cell> = cells.into_iter().map(cell).collect();
    if !rows.is_empty() {
        of_cells(&rows, sheet);
    }
    rows
}

/// Which of the rows are wrong, in words; and how many.
fn listed<T>(rows: &[T], wrong: impl Fn(&T) -> bool, name: impl Fn(&T) -> String) -> (usize, String) {
    let names: Vec<String> = rows.iter().filter(|row| wrong(row)).map(name).collect();
    let measured = match names.len() {
        0 => format!("none of {}", rows.len()),
        count => format!("{count} of {}: {}", rows.len(), names.join(", ")),
    };
    (names.len(), measured)
}

/// What the cells say together.
fn of_cells(rows: &[Cell], sheet: &mut Sheet) {
    let name =
        |r: &Cell| format!("{} {} {} {}/{}", r.id, r.parameter, r.schedule, r.covered.hits, r.covered.of);
    let outside = |cell: &Cell| cell.covered.value().is_some_and(|value| !WANTED.contains(&value));
    let figure = "effect × parameter × schedule whose intervals do not hold the truth in 92 to 98 %";
    sheet.figures.push(Figure::noted(figure, listed(rows, outside, name).1));
    let (refuted, measured) = listed(rows, |cell| cell.refuted, name);
    let figure = "the same beyond chance (1 % over all)";
    sheet.figures.push(Figure::new(figure, "none", measured, Some(refuted == 0)));
    let mut own = Share::default();
    rows.iter().for_each(|r| {
        own.hits += r.own.hits;
        own.of += r.own.of;
    });
    sheet.figures.push(Figure::at_least("estimates inside their own interval", 1.0, own));
}

pub(super) fn figures(cases: &[Case], sheet: &mut Sheet) -> Vec<Covered> {
    let mut shares: BTreeMap<(String, String), Share> = BTreeMap::new();
    let mut pooled = Share::default();
    let drawn = |c: &&Case| !c.truth.ambiguous() && !matches!(c.truth.group, Group::Interval | Group::Twice);
    for case in cases.iter().filter(drawn) {
        for (id, parameter, truth) in parameters_of(case) {
            let hit = holds(parameter.ci95, truth);
            shares.entry((id.to_owned(), parameter.name.clone())).or_default().count(hit);
            pooled.count(hit);
        }
    }
    let count = shares.len().max(1) as f64;
    let rows: Vec<Covered> = shares
        .into_iter()
        .map(|((id, parameter), share)| {
            let p_value = binomial_p_value(share.hits, share.of, CLAIMED);
            Covered { id, parameter, share, p_value, consistent: p_value >= OVER_ALL / count }
        })
        .collect();
    let passed = pooled.value().map(|value| (0.93..=0.97).contains(&value));
    let figure = "coverage of the 95 % intervals, pooled";
    sheet.figures.push(Figure::new(figure, "93–97 %", pooled.to_string(), passed));
    let (wrong, measured) = listed(&rows, |r| !r.consistent, |r| format!("{} {}", r.id, r.parameter));
    let figure = "parameters whose coverage is inconsistent with 95 % (binomial, 1 % over all)";
    let passed = (!rows.is_empty()).then_some(wrong == 0);
    sheet.figures.push(Figure::new(figure, "none", measured, passed));
    rows
}
