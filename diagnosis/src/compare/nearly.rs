//! A form without a name that is nearly a catalogued effect. Where an effect is far out of the noise, a form with more
//! coefficients says a little more than it, and takes its place. The other recording often cannot determine that many: so the
//! effect is compared, and what the form adds beyond it belongs to its recording alone.

use numerics::{add_scaled, dot, least_squares};

use crate::base::base_columns;
use crate::diagnosis::{FoundTerm, Outcome};
use crate::effects::Effect;
use crate::thresholds::compare::NEARLY;

use super::events::Event;

/// Takes every form of a diagnosis for the catalogued effect that it nearly is. What these forms add beyond their effects,
/// over the recording's rows.
pub fn take_forms_for_effects(outcome: &mut Outcome, catalogue: &[Effect]) -> Vec<Event> {
    let base = base_columns(&outcome.rows, outcome.after.order);
    let rows = &outcome.rows;
    let without_shape =
        |e: &&Effect| !e.is_form() && !e.of_one_time && e.ranges(rows).is_empty() && e.testable(rows).is_ok();
    let candidates: Vec<&Effect> = catalogue.iter().filter(without_shape).collect();
    let is_form = |term: &&mut FoundTerm| term.effect.as_ref().is_some_and(Effect::is_form);
    let mut beyond = Vec::new();
    for term in outcome.found.iter_mut().filter(is_form) {
        let left = |effect: &Effect| left_by(&effect.signature(rows, &[]), &base, &term.contribution);
        let whole = left_by(&[], &base, &term.contribution);
        let all = candidates.iter().map(|effect| (left(effect), *effect));
        let Some((more, effect)) = all.min_by(|a, b| square(&a.0).total_cmp(&square(&b.0))) else { continue };
        if square(&more) < NEARLY * square(&whole) {
            term.effect = Some(effect.clone());
            term.place = effect.place.clone();
            term.shape.clear();
            beyond.push(vec![more]);
        }
    }
    beyond
}

/// What the base and further columns leave of a contribution.
fn left_by(columns: &[Vec<f64>], base: &[Vec<f64>], contribution: &[f64]) -> Vec<f64> {
    let columns = [base, columns].concat();
    let fit = least_squares(&columns, contribution);
    let mut left = contribution.to_vec();
    fit.coefficients.iter().zip(&columns).for_each(|(c, column)| add_scaled(&mut left, -c, column));
    left
}

fn square(values: &[f64]) -> f64 {
    dot(values, values)
}
