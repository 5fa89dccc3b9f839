//! Terms: what further physical effects add to the angular error, as a closed set of operators.
//!
//! A term's value on a row is Σ coefficient·column, each column being what its operator makes of the
//! row's observables (and, for operators with memory, of the rows before). Values are in the unit of the
//! statistics: arcseconds, or the direct sensor's unit. They add to Δθ_M, so that the corrected angle is
//! θ − Δθ − Σ terms. One file per operator; an effect that can be written with these operators can be applied
//! and generated without knowing how it was found.

mod evaluate;
mod exponential;
mod expression;
mod gaussian;
mod hinge;
mod lag;
mod observables;
mod periodic;
mod play;
mod product;
mod rate;
mod step;

use serde::{Deserialize, Serialize};

pub use evaluate::{Evaluated, evaluate};
pub use exponential::Exponential;
pub use expression::{Expressed, Factor as ExpressionFactor, Fixed};
pub use gaussian::Gaussian;
pub use hinge::{Hinge, Side};
pub use lag::Lag;
pub use observables::{Missing, Observables, depends_on_angle};
pub use periodic::Periodic;
pub(crate) use periodic::solve as solve_periodic;
pub use play::{Element, Play};
pub use product::{Factor, Product};
pub use rate::Rate;
pub use step::Step;

/// On which recordings a term holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scope {
    /// On any recording of the device.
    Device,
    /// On the recording it was found in only: a step at a past time, a drift since switch-on.
    Recording,
}

/// What a term does with its observables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Operator {
    /// Product of observables and powers of s.
    Product(Product),
    /// Play (backlash), or a sum of plays (hysteresis).
    Play(Play),
    /// First-order lag of an observable.
    Lag(Lag),
    /// Saturating exponential.
    Exponential(Exponential),
    /// Step.
    Step(Step),
    /// Harmonics of the true angle.
    Periodic(Periodic),
    /// Gaussian bump.
    Gaussian(Gaussian),
    /// A slope beyond a threshold.
    Hinge(Hinge),
    /// Rate of change.
    Rate(Rate),
    /// An expression of physics.
    Expression(Expressed),
}

/// One term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// The id of the effect that named it (`thermal_zero_drift`).
    pub effect: String,
    /// On which recordings it holds.
    pub scope: Scope,
    /// The operator with its nonlinear parameters, reference means and initial state.
    pub operator: Operator,
    /// One coefficient per column of the operator, in the unit of the statistics per unit of the column.
    pub coefficients: Vec<f64>,
    /// Covariance of the coefficients, row by row; empty where it is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
}

impl Operator {
    /// As it stands in the file.
    pub fn kind(&self) -> &'static str {
        match self {
            Operator::Product(_) => "product",
            Operator::Play(_) => "play",
            Operator::Lag(_) => "lag",
            Operator::Exponential(_) => "exponential",
            Operator::Step(_) => "step",
            Operator::Periodic(_) => "periodic",
            Operator::Gaussian(_) => "gaussian",
            Operator::Hinge(_) => "hinge",
            Operator::Rate(_) => "rate",
            Operator::Expression(_) => "expression",
        }
    }

    /// Number of columns, and so of coefficients.
    pub fn width(&self) -> usize {
        match self {
            Operator::Play(play) => play.elements.len(),
            Operator::Periodic(periodic) => 2 * periodic.harmonics.len(),
            Operator::Expression(expression) => expression.factors.len(),
            _ => 1,
        }
    }

    /// The observables it reads (those of [`Observables::get`]); the true angle of `periodic` is none.
    pub fn observables(&self) -> Vec<&str> {
        match self {
            Operator::Product(product) => {
                product.factors.iter().map(|factor| factor.observable.as_str()).collect()
            }
            Operator::Play(play) => vec![&play.observable],
            Operator::Lag(lag) => vec![&lag.observable, "t_s"],
            Operator::Exponential(exponential) => vec![&exponential.observable],
            Operator::Step(step) => vec![&step.observable],
            Operator::Periodic(_) => Vec::new(),
            Operator::Gaussian(gaussian) => vec![&gaussian.observable],
            Operator::Hinge(hinge) => vec![&hinge.observable],
            Operator::Rate(rate) => vec![&rate.observable, "t_s"],
            Operator::Expression(expression) => expression.observables.iter().map(String::as_str).collect(),
        }
    }

    /// The columns over all rows, one vector each; a row with a blank in an observable has NaN. Of
    /// `periodic` there is none before the true angle is known: see [`Periodic::columns_at`].
    ///
    /// # Errors
    /// [`Missing`] if the recording has not the observable.
    pub fn columns(&self, observables: &Observables) -> Result<Vec<Vec<f64>>, Missing> {
        match self {
            Operator::Product(product) => Ok(vec![product.column(observables)?]),
            Operator::Play(play) => play.columns(observables),
            Operator::Lag(lag) => Ok(vec![lag.column(observables)?]),
            Operator::Exponential(exponential) => Ok(vec![exponential.column(observables)?]),
            Operator::Step(step) => Ok(vec![step.column(observables)?]),
            Operator::Periodic(_) => Ok(Vec::new()),
            Operator::Gaussian(gaussian) => Ok(vec![gaussian.column(observables)?]),
            Operator::Hinge(hinge) => Ok(vec![hinge.column(observables)?]),
            Operator::Rate(rate) => Ok(vec![rate.column(observables)?]),
            Operator::Expression(expression) => expression.columns(observables),
        }
    }

    /// The unit of coefficient `k`, the values of the term being in `unit`. A column's name says its own.
    pub fn coefficient_unit(&self, k: usize, unit: &str) -> String {
        let column = match self {
            Operator::Product(product) => {
                let power = |f: &Factor| if f.power > 1 { format!("^{}", f.power) } else { String::new() };
                let factors = product.factors.iter().map(|f| format!("{}{}", f.observable, power(f)));
                factors.collect::<Vec<_>>().join("·")
            }
            Operator::Play(Play { observable, .. })
            | Operator::Lag(Lag { observable, .. })
            | Operator::Hinge(Hinge { observable, .. }) => observable.clone(),
            Operator::Rate(rate) => format!("({}/s)", rate.observable),
            Operator::Expression(expression) => return expression.factors[k].unit.clone(),
            Operator::Exponential(_) | Operator::Step(_) | Operator::Periodic(_) | Operator::Gaussian(_) => {
                return unit.to_string();
            }
        };
        format!("{unit} per {column}")
    }

    /// Whether a row's columns depend on the rows before, those of a pair of probes or of a direct sensor.
    pub fn remembers(&self, pair: bool) -> bool {
        match self {
            Operator::Play(_) | Operator::Lag(_) | Operator::Rate(_) => true,
            Operator::Expression(expression) => {
                expression.sentence(pair).is_ok_and(|sentence| sentence.remembers())
            }
            Operator::Product(_)
            | Operator::Exponential(_)
            | Operator::Step(_)
            | Operator::Periodic(_)
            | Operator::Gaussian(_)
            | Operator::Hinge(_) => false,
        }
    }

    /// Whether every number of the operator beside its coefficients is known beforehand: no time constant, threshold, width,
    /// or period is fitted.
    pub fn is_linear(&self) -> bool {
        match self {
            Operator::Product(_) | Operator::Rate(_) => true,
            Operator::Expression(expression) => expression.parameters.is_empty(),
            Operator::Play(_)
            | Operator::Lag(_)
            | Operator::Exponential(_)
            | Operator::Step(_)
            | Operator::Periodic(_)
            | Operator::Gaussian(_)
            | Operator::Hinge(_) => false,
        }
    }

    /// Whether the term may be used outside the calibrated range: it does not depend on the angle, or no
    /// faster than a slope, or repeats, or is bounded by its own width wherever the angle is.
    pub fn extrapolates(&self) -> bool {
        match self {
            Operator::Product(product) => {
                let power: u32 = (product.factors.iter())
                    .filter(|factor| depends_on_angle(&factor.observable))
                    .map(|factor| u32::from(factor.power))
                    .sum();
                power <= 1
            }
            Operator::Play(_) | Operator::Lag(_) | Operator::Periodic(_) | Operator::Rate(_) => true,
            Operator::Exponential(Exponential { observable, .. })
            | Operator::Step(Step { observable, .. })
            | Operator::Gaussian(Gaussian { observable, .. })
            | Operator::Hinge(Hinge { observable, .. }) => !depends_on_angle(observable),
            Operator::Expression(expression) => {
                !expression.observables.iter().any(|observable| depends_on_angle(observable))
            }
        }
    }
}

impl Term {
    /// What contradicts itself in the term; none if it can be evaluated.
    pub fn contradiction(&self) -> Option<String> {
        let kind = self.operator.kind();
        let (width, found) = (self.operator.width(), self.coefficients.len());
        if width == 0 || width != found {
            return Some(format!("a `{kind}` term of {width} columns has {found} coefficients"));
        }
        if self.coefficients.iter().chain(self.covariance.iter().flatten()).any(|value| !value.is_finite()) {
            return Some(format!("a `{kind}` term has a coefficient or covariance that is not finite"));
        }
        let square = self.covariance.len() == width && self.covariance.iter().all(|row| row.len() == width);
        if !self.covariance.is_empty() && !square {
            return Some(format!("the covariance of a `{kind}` term is not {width} by {width}"));
        }
        let positive = |what: &str, value: f64| {
            (!(value.is_finite() && value > 0.0)).then(|| format!("`{what}` of a `{kind}` term is {value}"))
        };
        let finite = |what: &str, value: f64| {
            (!value.is_finite()).then(|| format!("`{what}` of a `{kind}` term is {value}"))
        };
        match &self.operator {
            Operator::Product(product) => product.contradiction(),
            Operator::Play(play) => play.elements.iter().find_map(|e| positive("half_width", e.half_width)),
            Operator::Lag(lag) => {
                positive("time_constant_s", lag.time_constant_s).or_else(|| finite("mean", lag.mean))
            }
            Operator::Exponential(e) => positive("scale", e.scale).or_else(|| finite("start", e.start)),
            Operator::Step(step) => finite("at", step.at),
            Operator::Periodic(periodic) => periodic.contradiction(&self.coefficients),
            Operator::Gaussian(g) => positive("width", g.width).or_else(|| finite("centre", g.centre)),
            Operator::Hinge(hinge) => finite("threshold", hinge.threshold),
            Operator::Rate(_) => None,
            Operator::Expression(expression) => expression.contradiction(),
        }
    }
}
