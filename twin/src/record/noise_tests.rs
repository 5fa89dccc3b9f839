//! The noise of a recording against the covariance that is said to be true.

use super::*;
use crate::noise::Noise;
use crate::truth::noise_covariance;

/// Mean over rows of variance and of the covariance with the next row, measured over many recordings of one
/// device and as stated.
fn measured_and_stated(noise: Noise) -> [[f64; 2]; 2] {
    let device = Device::from_seed(2);
    let protocol = Protocol { noise, passes: 2, ..Protocol::calibration() };
    let calculated = |x1, x2| calculated_angle_rad(x1, x2, 12.0);
    let runs = 1500;
    let (mut measured, mut stated) = ([0.0; 2], [0.0; 2]);
    for seed in 0..runs {
        let noisy = record_with_truth(&device, &protocol, seed, &calculated);
        let quiet = record_noiseless(&device, &protocol, seed, &calculated);
        let error: Vec<f64> =
            noisy.iter().zip(&quiet).map(|((_, a), (_, b))| a.error_arcsec - b.error_arcsec).collect();
        let truths: Vec<Truth> = noisy.iter().map(|(_, truth)| *truth).collect();
        let rows = truths.len();
        let covariance = noise_covariance(&truths, &protocol.noise);
        for i in 0..rows - 1 {
            let weight = 1.0 / (runs as f64 * (rows - 1) as f64);
            measured[0] += weight * error[i] * error[i];
            measured[1] += weight * error[i] * error[i + 1];
            stated[0] += weight * covariance[i * rows + i];
            stated[1] += weight * covariance[i * rows + i + 1];
            assert_eq!(covariance[i * rows + i + 1], covariance[(i + 1) * rows + i]);
            approx::assert_relative_eq!(
                covariance[i * rows + i].sqrt(),
                truths[i].noise_arcsec(),
                epsilon = 1e-12
            );
        }
    }
    [measured, stated]
}

#[test]
fn the_stated_covariance_is_that_of_the_recordings() {
    // About 10⁵ readings: a standard error of 0.5 % of the variance, of 3 % with outliers; autocorrelated
    // readings count for a third.
    for (noise, tolerance, lag) in [
        (Noise::White, 0.02, 0.0),
        (Noise::autocorrelated(), 0.03, 0.6),
        (Noise::heteroscedastic(), 0.02, 0.0),
        (Noise::outliers(), 0.06, 0.0),
    ] {
        let [measured, stated] = measured_and_stated(noise);
        approx::assert_relative_eq!(measured[0], stated[0], max_relative = tolerance);
        assert!((measured[1] - stated[1]).abs() < tolerance * stated[0], "{measured:?} {stated:?}");
        assert!((stated[1] / stated[0] - lag).abs() < 0.05, "{noise:?}: {stated:?}");
    }
}

#[test]
fn outliers_are_as_frequent_as_said_and_growing_noise_grows() {
    let device = Device::from_seed(2);
    let calculated = |x1, x2| calculated_angle_rad(x1, x2, 12.0);
    let record =
        |noise, seed| record_with_truth(&device, &Protocol { noise, ..Protocol::fine() }, seed, &calculated);
    let rows: Vec<_> = (0..40).flat_map(|seed| record(Noise::outliers(), seed)).collect();
    let share = rows.iter().filter(|(_, truth)| truth.outlier).count() as f64 / rows.len() as f64;
    // 22 080 readings at 2 %: a standard error of 0.1 %.
    approx::assert_abs_diff_eq!(share, 0.02, epsilon = 0.004);
    let rows = record(Noise::heteroscedastic(), 1);
    let at = |deg: f64| rows.iter().find(|(r, _)| r.command_deg == deg).map(|(_, t)| t.noise_arcsec());
    let ratio = at(1.7).zip(at(0.0)).map(|(edge, centre)| edge / centre).unwrap();
    approx::assert_abs_diff_eq!(ratio, 4.0, epsilon = 0.1);
}
