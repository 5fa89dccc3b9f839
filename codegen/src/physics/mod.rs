//! Further physics in the routine: the terms that a diagnosis found and firmware can correct at run time.
//!
//! The function of the reading stays as it is designed (`fused`, `piecewise`); between its last
//! sum and the output's format the terms are subtracted, from further inputs and from a state that is kept from
//! call to call (`extend`). Every word of that is bounded as it is written (`builder`), over all words of all inputs
//! and all states that can be reached; what it is off adds to the bound of the function. Which terms are generated,
//! and which are left out or refused and why, is decided in `selection`.

mod builder;
mod error;
mod exponent;
mod expression;
mod extend;
mod further;
mod periodic;
mod product;
mod rows;
mod selection;
mod shape;
mod sum;
mod warm_up;
mod words;

use fitter::error_model::Sensor;
use fitter::terms::{Operator, Term};
use fitter::units::ARCSEC_PER_RAD;

use crate::extent::LeftOut;

pub use builder::{ErrorAccount, Known, Tracked};
pub use error::PhysicsError;
pub(crate) use expression::Tree;
pub use further::{Further, FurtherEncoding};
pub(crate) use selection::by_time;

type Result<T = (), E = PhysicsError> = std::result::Result<T, E>;

/// The terms of a coefficients file as a routine has them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Physics {
    /// Those that are generated.
    pub terms: Vec<Term>,
    /// The further inputs.
    pub further: Vec<Further>,
    /// Seconds between two calls, where a term needs it.
    pub period_s: f64,
    /// The sensor whose reading the terms observe.
    pub sensor: Option<Sensor>,
    /// What is left out, and why.
    pub left_out: Vec<LeftOut>,
}

/// The observable of this name for a reading in its unit, where it is a function of that.
pub(crate) fn of_reading(sensor: &Sensor, name: &str, reading: f64) -> Option<f64> {
    match name {
        "s_mm" | "measured" => Some(reading),
        "angle_deg" => Some(sensor.calculated(reading).to_degrees()),
        "angle_arcsec" => Some(sensor.calculated(reading) * ARCSEC_PER_RAD),
        _ => None,
    }
}

impl Physics {
    /// Whether nothing is added to the function of the reading.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// An observable of the reading, in its unit, where it is one.
    pub(crate) fn of_reading(&self, name: &str, reading: f64) -> Option<f64> {
        self.sensor.as_ref().and_then(|sensor| of_reading(sensor, name, reading))
    }

    /// The expression of a term with its coefficients, where it is one.
    pub(crate) fn tree(&self, term: &Term) -> Option<Tree> {
        let Operator::Expression(expressed) = &term.operator else { return None };
        let pair = matches!(self.sensor, Some(Sensor::EddyCurrentPair { .. }));
        // It was read where the term was lowered.
        Tree::of(expressed, &term.coefficients, pair).ok()
    }

    /// The reference mean of an observable, where a product has one.
    fn mean(&self, observable: &str) -> Option<f64> {
        let factors = self.terms.iter().filter_map(|t| match &t.operator {
            Operator::Product(product) => Some(&product.factors),
            _ => None,
        });
        let lags = self.terms.iter().filter_map(|t| match &t.operator {
            Operator::Lag(lag) if lag.observable == observable => Some(lag.mean),
            _ => None,
        });
        factors
            .flatten()
            .find(|f| f.observable == observable)
            .map(|f| f.mean)
            .or_else(|| lags.into_iter().next())
    }
}
