//! The right name, the right place, the right set.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Case, Sheet};
use crate::answer::{Answer, Verdict};
use crate::truth::{Concealed, Group};

/// ρ from which on a name is expected.
const NAMED: f64 = 8.0;
/// σ per row from which on the time of a step is expected to within a row.
const STEEP: f64 = 3.5;

/// Rows: what was concealed. Columns: what was said first; then the right one among the alternatives of
/// another name, unexplained, consistent, refused.
#[derive(Debug, Clone, Serialize)]
pub struct Confusion {
    /// The columns.
    pub columns: Vec<String>,
    /// One row for each effect.
    pub rows: Vec<(String, Vec<u64>)>,
}

pub(super) fn figures(cases: &[Case], sheet: &mut Sheet) -> Confusion {
    let strong = || cases.iter().filter(|c| c.truth.group == Group::Strong && c.truth.least_rho() >= NAMED);
    let distinguishable = || strong().filter(|c| c.truth.can_tell());
    let first = |c: &Case, a: &Answer| a.first() == Some(&c.truth.effects[0].id);
    let mentioned = |c: &Case, a: &Answer| a.mentions(&c.truth.effects[0].id);
    let figure = ("right name first, ρ ≥ 8, where the recording can tell", 0.98);
    sheet.least(figure, "right name first", distinguishable(), first);
    let figure = ("named or among the alternatives, likewise", 0.995);
    sheet.least(figure, "named or alternative", distinguishable(), mentioned);
    sheet.tell("right name first, ρ ≥ 8, all recordings", strong(), first);
    sheet.tell("named or among the alternatives, all recordings", strong(), mentioned);

    let figure = ("right observable first in locations, ρ ≥ 8", 0.98);
    let located = |c: &Case, a: &Answer| a.located_on(&c.truth.effects[0].depends_on);
    sheet.least(figure, "right observable first", strong(), located);
    let steep = cases.iter().filter(|c| {
        matches!(c.truth.group, Group::Strong | Group::Step)
            && c.truth.effects[0].parameters.get("step_arcsec").is_some_and(|h| {
                h.abs() >= STEEP * c.truth.noise_arcsec && c.truth.effects[0].step_window_s.is_some()
            })
    });
    let figure = ("time of a step to within one row, step ≥ 3.5 σ", 0.98);
    sheet.least(figure, "time of a step", steep, |c, a| timed(&c.truth.effects[0], a));

    let exact = |c: &Case, a: &Answer| a.ids() == c.truth.ids();
    let several = [(Group::Pair, "two", "set of two", 0.93), (Group::Triple, "three", "set of three", 0.85)];
    for (group, word, miss, least) in several {
        let of_group =
            || cases.iter().filter(move |c| c.truth.group == group && c.truth.least_rho() >= NAMED);
        let name = format!("{word} effects, each ρ ≥ 8, where the recording can tell: the exact set");
        sheet.least((name, least), miss, of_group().filter(|c| c.truth.can_tell()), exact);
        sheet.tell(format!("{word} effects, all recordings: the exact set"), of_group(), exact);
    }

    let ambiguous = cases.iter().filter(|c| c.truth.ambiguous());
    let figure = ("temperature that ran with time: both named, and the deciding experiment", 0.95);
    sheet.least(figure, "temperature with time", ambiguous, |_, a| {
        a.next_experiment.is_some() && a.mentions("thermal_zero_drift") && a.mentions("time_drift")
    });
    confusion(strong())
}

/// Whether a step is reported to within a row of its time.
fn timed(step: &Concealed, answer: &Answer) -> bool {
    let reported = answer
        .effects
        .iter()
        .filter(|e| e.id == step.id)
        .flat_map(|e| e.parameters.iter().filter(|p| p.name == "time_s"))
        .map(|p| p.value)
        .next();
    match (reported, step.step_window_s) {
        // Half a hundredth of a second for the rounding of the logged times.
        (Some(time_s), Some([after, until])) => time_s > after + 0.005 && time_s <= until + 0.005,
        _ => false,
    }
}

fn confusion<'a>(cases: impl Iterator<Item = &'a Case>) -> Confusion {
    let catalogued: Vec<String> = crate::formulas::FORMULAS.iter().map(|f| f.id.to_owned()).collect();
    let mut columns = catalogued.clone();
    columns.extend(["alternatives", "unexplained", "consistent", "refused"].map(str::to_owned));
    let place = |name: &str| columns.iter().position(|c| c == name);
    let mut rows: BTreeMap<usize, Vec<u64>> = BTreeMap::new();
    for case in cases {
        let truth = &case.truth.effects[0].id;
        let said = match &case.answer {
            None => "refused",
            Some(a) if a.verdict == Verdict::Consistent => "consistent",
            Some(a) => match a.first() {
                None => "unexplained",
                Some(first) if first == truth => first,
                Some(_) if a.mentions(truth) => "alternatives",
                Some(first) => first,
            },
        };
        // A name outside the table counts as no name.
        let column = place(said).or_else(|| place("unexplained"));
        if let (Some(row), Some(column)) = (place(truth), column) {
            rows.entry(row).or_insert_with(|| vec![0; columns.len()])[column] += 1;
        }
    }
    let rows = rows.into_iter().map(|(row, counts)| (columns[row].clone(), counts)).collect();
    Confusion { columns, rows }
}
