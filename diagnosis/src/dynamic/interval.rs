//! Intervals of 95 % that are of the estimate's size: a parameter that a recording hardly determines has a wide
//! interval, not an infinite one.

use crate::thresholds::NORMAL_95;
use crate::thresholds::dynamic::interval::{MOST, STRAIGHT};

/// What a parameter is to its effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sort {
    /// It multiplies the effect.
    Amount,
    /// It is positive and shapes it.
    Shape,
    /// It is an angle in rad.
    Phase,
}

/// The interval around an estimate with a standard deviation.
pub fn around(value: f64, deviation: f64, sort: Sort) -> [f64; 2] {
    let half = if deviation.is_finite() { NORMAL_95 * deviation } else { f64::MAX };
    let straight = |most: f64| [value - half.min(most), value + half.min(most)];
    match sort {
        Sort::Shape if !(deviation.is_finite() && deviation <= STRAIGHT * value.abs()) => {
            let factor = (half / value.abs()).min(MOST.ln()).exp();
            [value / factor, value * factor]
        }
        Sort::Phase => straight(std::f64::consts::PI),
        _ => straight(MOST * value.abs()),
    }
}

/// Whether an interval says that the recording does not determine an amount.
pub fn undetermined(value: f64, [low, high]: [f64; 2]) -> bool {
    low < 0.0 && high > 0.0 && high - low >= 1.99 * MOST * value.abs() && high - low > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_finite_and_holds_its_estimate() {
        for sort in [Sort::Amount, Sort::Shape, Sort::Phase] {
            for value in [1e-12, 0.3, 7e9] {
                for deviation in [0.0, 0.1 * value, 3.0 * value, 1e200, f64::INFINITY, f64::NAN] {
                    let [low, high] = around(value, deviation, sort);
                    assert!(low <= value && value <= high, "{sort:?} {value} {deviation}: {low} {high}");
                    assert!(
                        high - low <= 2001.0 * value.max(1.0),
                        "{sort:?} {value} {deviation}: {low} {high}"
                    );
                    assert!(sort != Sort::Shape || low > 0.0);
                }
            }
        }
        assert!(undetermined(0.3, around(0.3, f64::INFINITY, Sort::Amount)));
        assert!(!undetermined(0.3, around(0.3, 1.0, Sort::Amount)));
    }
}
