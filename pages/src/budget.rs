//! An uncertainty budget as tables: of text, and of a page.

use fitter::budget::{Budget, Combined, Component};
use minijinja::{Value, context};

use super::{Beside, digits};

/// A page of budgets, with what they are of, that can be printed for a calibration record. `origin` are sentences on where
/// they come from.
pub fn page(budgets: &[(&str, &Budget)], origin: &[String], beside: &Beside) -> String {
    let budgets: Vec<Value> =
        budgets.iter().map(|(name, budget)| context! { name => *name, ..shown(budget) }).collect();
    super::rendered(
        include_str!("budget_page.html"),
        context! { budgets, origin => origin.to_vec(), beside => minijinja::value::Serde(beside) },
    )
}

/// Everything of a budget as it is shown.
pub(super) fn shown(budget: &Budget) -> Value {
    let components: Vec<Value> = budget.components.iter().map(component).collect();
    let range: Vec<Value> = (budget.range.iter())
        .map(|place| {
            let Combined { standard_uncertainty, degrees_of_freedom, coverage_factor, expanded } =
                place.combined;
            context! {
                at => digits(place.at), result => digits(place.result), u => digits(standard_uncertainty),
                freedom => freedom(degrees_of_freedom), factor => digits(coverage_factor),
                expanded => digits(expanded),
            }
        })
        .collect();
    let [low, high] = budget.expanded().map(digits);
    context! {
        measurand => &*budget.measurand, missing => &budget.missing, formula => &*budget.formula,
        not_included => &budget.not_included, unit => &*budget.unit, place => &*budget.place,
        place_unit => &*budget.place_unit, at => digits(budget.at), percent => digits(100.0 * budget.coverage),
        expanded => if low == high { high } else { format!("{low} to {high}") },
        components, range,
    }
}

fn component(of: &Component) -> Value {
    context! {
        what => &*of.what, evaluation => format!("{:?}", of.evaluation), unit => &*of.unit,
        value => digits(of.value), distribution => of.distribution.name(), divisor => digits(of.divisor),
        u => digits(of.standard_uncertainty), sensitivity => digits(of.sensitivity),
        contribution => digits(of.contribution), freedom => freedom(of.degrees_of_freedom),
    }
}

/// Degrees of freedom, truncated to the next lower integer (GUM G.4.1).
pub fn freedom(value: Option<f64>) -> String {
    value.map_or_else(|| "∞".to_string(), |freedom| format!("{}", freedom.floor()))
}
