//! What no named effect explains, described by forms without a name, and where these leave structure by curves: they compete
//! with the named effects in one search that is calibrated as a whole, so that one is taken only where chance would not bring it
//! about in all of them.

use fitter::Coefficients;
use fitter::error_model::Sensor;

use crate::alone::stands_alone;
use crate::attempt::Attempt;
use crate::dictionary::Kind;
use crate::effects::{Effect, composed, curves};
use crate::explain::Outset;
use crate::generic::observables;
use crate::thresholds::compose::MOST_COLUMNS;
use crate::verdict::{EMPIRICAL, NamedEffect, Said};

/// The effects with the forms of dependences on the columns that tell most, and on the angle's past; without them where one
/// named effect stands alone.
pub fn with_forms(effects: &[Effect], attempt: &Attempt, outset: &Outset, sensor: &Sensor) -> Vec<Effect> {
    let forms = composed(&strs(&telling_columns(attempt)), sensor, &ids(effects));
    if stands_alone(attempt, outset, &forms) { effects.to_vec() } else { [effects, &forms].concat() }
}

/// The effects with curves over the same columns, in place of the forms; without them where no structure is left.
pub fn with_curves(effects: &[Effect], attempt: &Attempt, sensor: &Sensor) -> Vec<Effect> {
    if !attempt.leaves_structure() {
        return effects.to_vec();
    }
    [effects, &curves(&strs(&telling_columns(attempt)), sensor, &ids(effects))].concat()
}

fn strs(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

fn ids(effects: &[Effect]) -> Vec<&str> {
    effects.iter().map(|effect| effect.id.as_str()).collect()
}

/// The columns that tell most, by their names in expressions, the strongest first.
fn telling_columns(attempt: &Attempt) -> Vec<String> {
    let search = &attempt.explanation.search;
    let survey = search.survey();
    let strength = |column: &str| {
        let of_column = |family: usize| match &search.dictionary.families[family].kind {
            Kind::Generic(place) => place.variable == column || place.times.as_deref() == Some(column),
            _ => false,
        };
        let found = survey.iter().filter(|found| of_column(found.term.family));
        found.map(|found| found.surprise).fold(0.0, f64::max)
    };
    let mut columns: Vec<(f64, String)> =
        observables(search.rows).into_iter().map(|column| (strength(&column.name), column.name)).collect();
    columns.sort_by(|a, b| b.0.total_cmp(&a.0));
    let in_expressions =
        |name: String| if name == "common_mode_um" { "common_mode".to_string() } else { name };
    columns.into_iter().take(MOST_COLUMNS).map(|(_, name)| in_expressions(name)).collect()
}

/// Numbers the forms that were found, the strongest first, wherever they are named.
pub fn number(said: &mut Said, judged: &mut [String], file: Option<&mut Coefficients>) {
    let mut terms = file.map_or_else(Vec::new, |file| file.terms.iter_mut().collect());
    let forms = said.effects.iter_mut().filter(|effect| effect.kind == EMPIRICAL);
    let number = |(k, effect): (usize, &mut NamedEffect)| {
        let id = std::mem::replace(&mut effect.id, format!("empirical_{}", k + 1));
        (id, effect.id.clone())
    };
    let mut numbered: Vec<(String, String)> = forms.enumerate().map(number).collect();
    // The name of a form may be the end of another's.
    numbered.sort_by_key(|(id, _)| std::cmp::Reverse(id.len()));
    for (id, name) in &numbered {
        terms.iter_mut().filter(|term| term.effect == *id).for_each(|term| term.effect.clone_from(name));
        let texts = said.unidentifiable.iter_mut().chain(judged.iter_mut());
        texts.for_each(|text| *text = text.replace(id.as_str(), name));
    }
}
