//! The exact corrected position of a sensor that turns, enclosed: Θ with Θ + P(Θ) = m − c, P the harmonics of the
//! turn and c the constant of the coefficients file, all of them taken as the exact numbers that they are as `f64`.
//!
//! Positions are words of 64 bits, the turn being 2⁶⁴: what wraps round does so by itself. Newton's method
//! proposes a solution; its residual, computed in integers with a stated error, tells how far it can be off,
//! because the slope of Θ + P(Θ) is at least 1 − L, L being the harmonics' steepest slope together.

use fitter::coefficients::Coefficients;

use super::TurnError;
use super::phase::{self, Circle, ONE_LOG2};
use super::wraps::Wraps;
use crate::exact::{Interval, pi};

/// Most steps of Newton's method; each squares the distance.
const STEPS: usize = 60;

/// The function.
#[derive(Debug, Clone)]
pub struct Truth {
    circle: &'static Circle,
    /// c, in words.
    zero: u64,
    /// Harmonic number, coefficients of cosine and sine in words.
    waves: Vec<(u64, i64, i64)>,
    /// Upper bound of the slope of P.
    steepest: f64,
    /// P is evaluated within so many words.
    error: f64,
}

/// A position and how far it may be off, in words.
#[derive(Debug, Clone, Copy)]
pub struct Enclosed {
    /// The position.
    pub word: u64,
    /// The largest distance from the exact one.
    pub radius: f64,
}

impl Truth {
    /// Of coefficients of a whole turn.
    ///
    /// # Errors
    /// [`TurnError`] where the error is not one of a turn, or too steep or too large to be turned round.
    pub fn new(coefficients: &Coefficients) -> Result<Self, TurnError> {
        let wraps = Wraps::of(coefficients)?;
        let revolution = coefficients.turn.as_ref().ok_or(TurnError::NotATurn)?.revolution;
        let unit = Interval::from_f64(revolution);
        let turns = |value: f64| Interval::from_f64(value).div(&unit);
        let zero = wraps.zero;
        let zero_turns = turns(zero - (zero / revolution).round() * revolution);
        let mut truth = Truth {
            circle: Circle::shared(),
            zero: 0,
            waves: Vec::new(),
            steepest: 0.0,
            // The constant's rounding, and that of the residual's sum.
            error: 2.0,
        };
        truth.zero = word(&zero_turns).ok_or(TurnError::Large)? as u64;
        let mut steepest = Interval::zero();
        for (k, cosine, sine) in &wraps.waves {
            let (a, b) = (turns(*cosine), turns(*sine));
            let slope =
                &(&pi() * &(&a.magnitude() + &b.magnitude())) * &Interval::from_int(2 * i64::from(*k));
            steepest = (&steepest + &slope).upper();
            let words = (word(&a).ok_or(TurnError::Large)?, word(&b).ok_or(TurnError::Large)?);
            let largest = words.0.unsigned_abs().max(words.1.unsigned_abs()) as f64;
            // Cosine and sine, the rounding of both coefficients, and of both products.
            truth.error += 2.0 * (largest * phase::ERROR as f64 * 2f64.powi(-(ONE_LOG2 as i32)) + 2.0);
            truth.waves.push((u64::from(*k), words.0, words.1));
        }
        truth.steepest = steepest.to_f64_up();
        if truth.steepest >= STEEPEST {
            return Err(TurnError::Steep { slope: truth.steepest });
        }
        Ok(truth)
    }

    /// P and its slope at a position.
    fn waves(&self, position: u64) -> (i64, f64) {
        let (mut value, mut slope) = (0i128, 0.0);
        for &(k, a, b) in &self.waves {
            let (cosine, sine) = self.circle.cos_sin(position.wrapping_mul(k));
            value += i128::from(phase::product(a, cosine)) + i128::from(phase::product(b, sine));
            let in_turns = 2f64.powi(-64 - ONE_LOG2 as i32);
            slope += std::f64::consts::TAU
                * k as f64
                * in_turns
                * (b as f64 * cosine as f64 - a as f64 * sine as f64);
        }
        (value as i64, slope)
    }

    /// The corrected position at a reading.
    pub fn at(&self, reading: u64) -> Enclosed {
        let observed = reading.wrapping_sub(self.zero);
        let mut best: Option<(u64, u64)> = None;
        let mut position = observed.wrapping_sub(self.waves(observed).0 as u64);
        for _ in 0..STEPS {
            let (value, slope) = self.waves(position);
            let rest = position.wrapping_add(value as u64).wrapping_sub(observed) as i64;
            let size = rest.unsigned_abs();
            if best.is_some_and(|(_, smallest)| size >= smallest) {
                break;
            }
            best = Some((position, size));
            position = position.wrapping_sub((rest as f64 / (1.0 + slope)) as i64 as u64);
        }
        let (word, rest) = best.unwrap_or((position, u64::MAX));
        // Rounded up: a few operations of relative error 2⁻⁵³.
        let radius = (rest as f64 + self.error) / (1.0 - self.steepest) * (1.0 + 1e-12) + 1.0;
        Enclosed { word, radius }
    }

    /// How far a position moves at most when the reading moves by 1.
    pub fn gain(&self) -> f64 {
        1.0 / (1.0 - self.steepest) * (1.0 + 1e-12)
    }

    /// How far the zero is from the reference's, in words: c.
    pub fn zero(&self) -> u64 {
        self.zero
    }
}

/// The slope from which on no inverse is claimed.
const STEEPEST: f64 = 0.999;

/// A part of a turn, less than half in magnitude, as a word.
fn word(turns: &Interval) -> Option<i64> {
    let half = Interval::pow2(-1);
    // Exactly half a turn either way is the same place.
    if !turns.magnitude().certainly_le(&half) {
        return None;
    }
    turns.mul_pow2(63).round_to_i64().map(|halves| halves.saturating_mul(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::turn::fixtures::encoder;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        /// The fitter's solution in floats agrees to what floats allow, whatever the unit and the zero.
        #[test]
        fn the_fitters_own_solution_is_enclosed(
            zero in -400.0..400.0f64,
            waves in prop::collection::vec(-1.5..1.5f64, 2..9),
            at in prop::collection::vec(any::<u64>(), 50),
        ) {
            let waves = &waves[..waves.len() / 2 * 2];
            let file = encoder(360.0, zero, waves);
            let truth = Truth::new(&file).unwrap();
            for reading in at {
                let reading = reading >> 16 << 16;
                let found = truth.at(reading);
                let expected = fitter::turn::corrected(&file, reading as f64 * 360.0 / 2f64.powi(64)).unwrap();
                let off = found.word as f64 / 2f64.powi(64) - expected / 360.0;
                prop_assert!((off - off.round()).abs() < 1e-14, "{off}");
                prop_assert!(found.radius < 1e6, "{}", found.radius);
            }
        }
    }

    #[test]
    fn what_has_no_inverse_is_refused() {
        assert!(matches!(Truth::new(&encoder(360.0, 0.0, &[60.0, 0.0])), Err(TurnError::Steep { .. })));
        let mut file = encoder(360.0, 0.0, &[1.0, 0.0]);
        file.base.coefficients.extend([0.5, 0.1]);
        assert!(matches!(Truth::new(&file), Err(TurnError::Polynomial { order: 2 })));
    }
}
