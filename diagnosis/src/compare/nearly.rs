//! A form without a name that is nearly a catalogued effect. Where an effect is far out of the noise, a form with more
//! coefficients says a little more than it, and takes its place. The other recording can seldom determine so many: there it is
//! the effect that is compared, and the little more belongs to its recording.

use crate::base::base_columns;
use crate::effects::Effect;
use crate::numerics::{add_scaled, dot, least_squares};
use crate::rows::Rows;
use crate::thresholds::compare::NEARLY;

/// The effect that a form nearly is.
pub struct Nearly {
    /// The effect, which has no shape.
    pub effect: Effect,
    /// What the form adds beyond it, and beyond the base.
    pub more: Vec<f64>,
}

impl Nearly {
    /// Of what a form adds at every row.
    pub fn of(contribution: &[f64], rows: &Rows, order: usize, catalogue: &[Effect]) -> Option<Nearly> {
        let base = base_columns(rows, order);
        let beside = |columns: &[Vec<f64>]| {
            let columns = [&base[..], columns].concat();
            let fit = least_squares(&columns, contribution);
            let mut left = contribution.to_vec();
            fit.coefficients.iter().zip(&columns).for_each(|(c, column)| add_scaled(&mut left, -c, column));
            left
        };
        let beyond_base = beside(&[]);
        let whole = dot(&beyond_base, &beyond_base);
        let without_shape = |e: &&Effect| {
            !e.is_form() && !e.of_one_time && e.ranges(rows).is_empty() && e.testable(rows).is_ok()
        };
        let left = |effect: &Effect| {
            let more = beside(&effect.signature(rows, &[]));
            (dot(&more, &more), more)
        };
        let all = catalogue.iter().filter(without_shape).map(|effect| (left(effect), effect));
        let ((square, more), effect) = all.min_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
        (square < NEARLY * whole).then(|| Nearly { effect: effect.clone(), more })
    }
}
