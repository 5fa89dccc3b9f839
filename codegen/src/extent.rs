//! How much a term that is left out of a routine can be: its largest value over the valid range and over what the
//! recording covers of its other observables.

use fitter::coefficients::Coefficients;
use fitter::terms::{Operator, Side, Term};

use crate::physics::of_reading;

/// How large a term gets.
#[derive(Debug, Clone, PartialEq)]
pub enum Extent {
    /// At most so much, in the unit of the statistics.
    AtMost(f64),
    /// So much, at the speed of the recording, in the reading's unit per second.
    AtSpeed(f64, f64),
    /// So much for every unit of the reading per second.
    PerSpeed(f64),
    /// Nothing is known of what the term depends on.
    Unknown,
}

impl Extent {
    /// Of a term over a range of readings.
    pub fn of(term: &Term, file: &Coefficients, range: (f64, f64)) -> Extent {
        let ends = |name: &str| ends(name, file, range);
        let weight = term.coefficients.first().copied().unwrap_or(0.0).abs();
        let known =
            |value: Option<f64>| value.filter(|v| v.is_finite()).map_or(Extent::Unknown, Extent::AtMost);
        match &term.operator {
            Operator::Product(product) => known(product.factors.iter().try_fold(weight, |size, factor| {
                let [low, high] = ends(&factor.observable)?;
                let largest = (low - factor.mean).abs().max((high - factor.mean).abs());
                Some(size * largest.powi(factor.power.into()))
            })),
            Operator::Play(play) => {
                let halves = play.elements.iter().zip(&term.coefficients);
                Extent::AtMost(halves.map(|(element, c)| element.half_width * c.abs()).sum())
            }
            Operator::Lag(lag) => known(
                ends(&lag.observable)
                    .map(|[low, high]| weight * (low - lag.mean).abs().max((high - lag.mean).abs())),
            ),
            Operator::Rate(rate) if of_reading(&file.sensor, &rate.observable, 0.0).is_some() => {
                let speeds = file.turn.as_ref().and_then(|turn| turn.directions.speed_per_s);
                match speeds {
                    Some([_, fast]) => Extent::AtSpeed(weight * fast.abs(), fast.abs()),
                    None => Extent::PerSpeed(weight),
                }
            }
            Operator::Rate(_) | Operator::Expression(_) => Extent::Unknown,
            Operator::Hinge(hinge) => known(ends(&hinge.observable).map(|[low, high]| {
                let beyond = match hinge.side {
                    Side::Above => high - hinge.threshold,
                    Side::Below => hinge.threshold - low,
                };
                weight * beyond.max(0.0)
            })),
            Operator::Gaussian(_) | Operator::Exponential(_) | Operator::Step(_) => Extent::AtMost(weight),
            Operator::Periodic(_) => {
                let pairs = term.coefficients.chunks_exact(2);
                Extent::AtMost(pairs.map(|pair| pair[0].hypot(pair[1])).sum())
            }
        }
    }

    /// The value where there is one.
    pub fn value(&self) -> Option<f64> {
        match self {
            Extent::AtMost(value) | Extent::AtSpeed(value, _) => Some(*value),
            Extent::PerSpeed(_) | Extent::Unknown => None,
        }
    }

    /// For the head of a file; `unit` is that of the statistics.
    pub fn in_words(&self, unit: &str) -> String {
        let figure = |value: f64| format!("{value:.2e}");
        match self {
            Extent::AtMost(value) => format!("up to {} {unit}", figure(*value)),
            Extent::AtSpeed(value, speed) => {
                format!("up to {} {unit} at the recorded speed, {} a second", figure(*value), figure(*speed))
            }
            Extent::PerSpeed(value) => {
                format!("{} {unit} for every unit of the reading a second", figure(*value))
            }
            Extent::Unknown => "of a size that the file does not tell".into(),
        }
    }
}

/// A term that a routine does not have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{effect}: {why}")]
pub struct LeftOut {
    /// The effect.
    pub effect: String,
    /// Why, and how large it is.
    pub why: String,
    /// Its largest value, where it is an error of the device that stays uncorrected and its size is known.
    pub size: Option<f64>,
}

impl LeftOut {
    /// Of a term; `counts` where it is an error of the device.
    pub fn of(term: &Term, file: &Coefficients, range: (f64, f64), why: &str, counts: bool) -> LeftOut {
        let extent = Extent::of(term, file, range);
        LeftOut {
            effect: term.effect.clone(),
            why: format!("{why}; it is {}", extent.in_words(&file.units.statistics)),
            size: extent.value().filter(|_| counts),
        }
    }
}

/// The ends between which an observable lies.
fn ends(name: &str, file: &Coefficients, range: (f64, f64)) -> Option<[f64; 2]> {
    match [range.0, range.1].map(|reading| of_reading(&file.sensor, name, reading)) {
        [Some(low), Some(high)] => Some([low, high]),
        _ if name == "direction" => Some([-1.0, 1.0]),
        _ => file.observed.get(name).copied(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::turn::fixtures::encoder;
    use fitter::terms::{Gaussian, Hinge, Lag, Periodic, Play, Product, Rate, Scope};

    #[test]
    fn the_largest_value_of_every_kind_of_term() {
        let mut file = encoder(360.0, 0.0, &[0.1, 0.0]);
        file.observed.insert("temperature_c".into(), [10.0, 25.0]);
        let of = |file: &Coefficients, operator: Operator, coefficients: &[f64]| {
            let (effect, scope) = ("some".to_string(), Scope::Device);
            let term =
                Term { effect, scope, operator, coefficients: coefficients.to_vec(), covariance: Vec::new() };
            Extent::of(&term, file, (0.0, 360.0))
        };
        let at_most = |operator, coefficients: &[f64], value: f64| {
            let found = of(&file, operator, coefficients);
            assert!(found.value().is_some_and(|v| (v - value).abs() < 1e-12), "{found:?} is not {value}");
        };
        let product = |name: &str, mean| Operator::Product(Product::of(name, mean));
        at_most(product("measured", 100.0), &[-0.01], 2.6);
        at_most(product("temperature_c", 22.0), &[0.5], 6.0);
        assert_eq!(of(&file, product("coil_a", 0.0), &[1.0]), Extent::Unknown);
        at_most(Operator::Lag(Lag::of("temperature_c", 60.0, 20.0)), &[0.1], 1.0);
        at_most(Operator::Gaussian(Gaussian::of("measured", 3.0, 1.0)), &[-0.3], 0.3);
        let hinge = |side| Operator::Hinge(Hinge::of("measured", 350.0, side));
        at_most(hinge(Side::Above), &[0.2], 2.0);
        at_most(hinge(Side::Below), &[0.2], 70.0);
        at_most(Operator::Periodic(Periodic::of(17.0, 2)), &[0.3, 0.4, 0.0, -0.1], 0.6);
        at_most(Operator::Play(Play::of("measured", &[0.02])), &[1.0], 0.02);
        let lag = || Operator::Rate(Rate::of("measured"));
        assert_eq!(of(&file, lag(), &[0.034]), Extent::PerSpeed(0.034));
        assert_eq!(
            of(&file, lag(), &[0.034]).in_words("deg"),
            "3.40e-2 deg for every unit of the reading a second"
        );
        file.turn.as_mut().unwrap().directions.speed_per_s = Some([10.0, 20.0]);
        let told = of(&file, lag(), &[-0.034]).in_words("deg");
        assert_eq!(told, "up to 6.80e-1 deg at the recorded speed, 2.00e1 a second");
    }
}
