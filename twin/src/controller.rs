//! The position loop in its steady state: it turns the mirror until the feedback lands on the command.

/// The angle is sought to this accuracy in radians, 2·10⁻⁶ arcsec.
const TOLERANCE_RAD: f64 = 1e-11;

/// The true angle in radians, between −`stop_rad` and `stop_rad`, at which `feedback` (in radians, of the
/// true angle in radians, increasing) lands on `command_rad`.
///
/// The feedback may be a staircase, as of a routine in whole numbers: the angle is then an edge of the
/// step that crosses the command. A command that cannot be reached drives the mirror against its stop.
///
/// The search is the ITP method of Oliveira and Takahashi (2020): never more steps than bisection needs,
/// few where the feedback is smooth.
pub fn settle(feedback: impl Fn(f64) -> f64, command_rad: f64, stop_rad: f64) -> f64 {
    let deviation = |angle| feedback(angle) - command_rad;
    let (mut low, mut high) = (-stop_rad, stop_rad);
    let (mut at_low, mut at_high) = (deviation(low), deviation(high));
    // A feedback that is not a number also counts as out of reach.
    if at_low >= 0.0 || at_low.is_nan() {
        return low;
    }
    if at_high <= 0.0 || at_high.is_nan() {
        return high;
    }
    let scale = 0.2 / (high - low);
    let half_tolerance = 0.5 * TOLERANCE_RAD;
    let mut allowance = half_tolerance * 2f64.powf(((high - low) / TOLERANCE_RAD).log2().ceil() + 1.0);
    while high - low > TOLERANCE_RAD {
        let middle = 0.5 * (low + high);
        let radius = allowance - 0.5 * (high - low);
        let chord = (at_high * low - at_low * high) / (at_high - at_low);
        let towards_middle = (middle - chord).signum();
        let truncated = chord + towards_middle * (scale * (high - low).powi(2)).min((middle - chord).abs());
        let trial =
            if (truncated - middle).abs() <= radius { truncated } else { middle - towards_middle * radius };
        let at_trial = deviation(trial);
        if at_trial > 0.0 {
            (high, at_high) = (trial, at_trial);
        } else if at_trial < 0.0 {
            (low, at_low) = (trial, at_trial);
        } else {
            return trial;
        }
        allowance *= 0.5;
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::cell::Cell;

    proptest! {
        #[test]
        fn a_smooth_feedback_lands_on_the_command(command in -0.026f64..0.026, bend in -5.0f64..5.0) {
            let evaluations = Cell::new(0);
            let feedback = |x: f64| {
                evaluations.set(evaluations.get() + 1);
                1.1 * x + bend * x * x
            };
            let angle = settle(feedback, command, 0.031);
            prop_assert!((1.1 * angle + bend * angle * angle - command).abs() < 2e-11);
            prop_assert!(evaluations.get() < 40, "{}", evaluations.get());
        }

        #[test]
        fn a_staircase_lands_on_the_step_of_the_command(command in -0.026f64..0.026) {
            let step = 1e-7;
            let feedback = |x: f64| (x / step).floor() * step;
            let angle = settle(feedback, command, 0.031);
            prop_assert!((angle - command).abs() <= 1.001 * step);
        }
    }

    #[test]
    fn what_cannot_be_reached_ends_at_the_stop() {
        assert_eq!(settle(|x| x, 1.0, 0.03), 0.03);
        assert_eq!(settle(|x| x, -1.0, 0.03), -0.03);
        assert_eq!(settle(|_| f64::NAN, 0.0, 0.03), -0.03);
    }
}
