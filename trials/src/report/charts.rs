//! The detection curve.

use pages::{Chart, Colour, Mark, Scale, Series};

use crate::curve::Curve;
use crate::statistics::{ideal_detection, phi};

/// Strength up to which the curve is drawn; beyond, everything is detected.
const UP_TO: f64 = 10.0;

/// Probability of detection against ρ: bins with their intervals, the fitted ogive, the isotonic steps, and
/// the ideal detector.
pub(super) fn detection(curve: &Curve) -> String {
    let line = |name: &str, colour, points| Series::new(name, Mark::Line, colour, points);
    let along = |share: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=200).map(|i| UP_TO * f64::from(i) / 200.0).map(|rho| (rho, share(rho))).collect()
    };
    let mut steps = Vec::new();
    let mut last = 0.0;
    for (rho, share) in curve.isotonic.iter().copied().filter(|(rho, _)| *rho <= UP_TO) {
        steps.extend([(rho, last), (rho, share)]);
        last = share;
    }
    steps.push((UP_TO, last));
    let mut series = vec![
        line("ideal", Colour::Soft, along(&|rho| ideal_detection(rho, curve.false_alarm))),
        line("isotonic steps", Colour::First, steps),
        line("fitted ogive", Colour::Second, along(&|rho| phi((rho - curve.half) / curve.width))),
    ];
    for bin in curve.bins.iter().filter(|bin| bin.to <= UP_TO) {
        let middle = 0.5 * (bin.from + bin.to);
        let share = vec![(middle, bin.hits as f64 / bin.of as f64)];
        series.push(line("", Colour::Second, bin.limits.map(|limit| (middle, limit)).to_vec()));
        series.push(Series { mark: Mark::Dots, ..line("", Colour::Second, share) });
    }
    let label = "share detected against strength";
    Chart { label, x: "strength ρ".into(), y: "share detected".into(), series }.draw(Scale::Even)
}
