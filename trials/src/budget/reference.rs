//! The error of a reference with a stated accuracy ±a.
//!
//! What is assumed: it is systematic, the same in every reading at a place, and at every place as likely to be anywhere
//! within ±a. Of half of the devices it is a constant; of the others a triangular wave with a phase that is anything, so
//! long that the model can follow it: of an angle or length a quarter of it lies in the range, a scale error that turns
//! back at its limits; round a turn it is one.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

/// Periods of the wave over a range, and round a turn.
pub const A_QUARTER: f64 = 0.25;
/// See [`A_QUARTER`].
pub const ONE: f64 = 1.0;

/// The error of one calibration.
pub struct Reference {
    accuracy: f64,
    /// Periods over the range.
    periods: f64,
    /// Where in its period the range begins.
    phase: f64,
}

impl Reference {
    /// Draws the error of a reference with this accuracy, of so many periods over the range where it is a wave.
    pub fn draw(accuracy: f64, periods: f64, generator: &mut ChaCha12Rng) -> Reference {
        let periods = if generator.random::<f64>() < 0.5 { periods } else { 0.0 };
        Reference { accuracy, periods, phase: generator.random() }
    }

    /// The error where `part` of the range lies below.
    pub fn error(&self, part: f64) -> f64 {
        let place = (self.phase + self.periods * part).rem_euclid(1.0);
        self.accuracy * ((4.0 * place - 2.0).abs() - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn the_error_is_anywhere_within_its_limits_alike() {
        let mut generator = ChaCha12Rng::seed_from_u64(1);
        const COUNT: usize = 20_000;
        let errors: Vec<f64> =
            (0..COUNT).map(|_| Reference::draw(2.0, 0.25, &mut generator).error(0.3)).collect();
        for quarter in 0..4 {
            let (from, to) = (f64::from(quarter) - 2.0, f64::from(quarter) - 1.0);
            let share = errors.iter().filter(|e| (from..to).contains(*e)).count() as f64 / COUNT as f64;
            assert!((share - 0.25).abs() < 0.015, "{from}: {share}");
        }
    }
}
