//! What the figures of a file say of its model: what it explains, what it leaves, and the noise.

use super::{Coefficients, Diagnosed};
use crate::acceptance::VERDICTS;

impl Diagnosed {
    /// Root mean square of what the model leaves beyond the noise.
    pub fn left(&self) -> f64 {
        (self.after_rms.powi(2) - self.noise_floor.powi(2)).max(0.0).sqrt()
    }

    /// Root mean square of what was found beside the base model.
    pub fn named(&self) -> f64 {
        (self.before_rms.powi(2) - self.after_rms.powi(2)).max(0.0).sqrt()
    }

    /// What contradicts itself; none if it can be used.
    pub(super) fn contradiction(&self) -> Option<String> {
        if !VERDICTS.contains(&self.verdict.as_str()) {
            return Some(format!("`diagnosis` has the verdict `{}`", self.verdict));
        }
        let figures = [self.before_rms, self.after_rms, self.noise_floor];
        let bad = figures.into_iter().find(|figure| !(figure.is_finite() && *figure >= 0.0));
        bad.map(|figure| format!("`diagnosis` holds the figure {figure}"))
    }
}

impl Coefficients {
    /// The standard deviation of one reading's noise, in [`super::Units::statistics`]: the diagnosis's floor; of a file
    /// of `fit` the scatter between passes; where no angle was read twice, what the fit leaves. None where the file
    /// says nothing of it.
    pub fn noise(&self) -> Option<f64> {
        let diagnosed = self.diagnosis.as_ref().map(|d| d.noise_floor);
        let statistics = self.statistics.as_ref();
        let between = || statistics.and_then(|s| s.between_passes.as_ref()).map(|s| s.standard_deviation);
        let known = |value: &f64| value.is_finite() && *value > 0.0;
        (diagnosed.filter(known))
            .or_else(|| between().filter(known))
            .or_else(|| statistics.map(|s| s.after.rms).filter(known))
            .or_else(|| self.identification.as_ref().map(|i| i.residual_standard_deviation).filter(known))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_model::{ErrorModel, Sensor};

    #[test]
    fn what_is_left_and_what_was_named_are_beyond_the_noise() {
        let figures = |before_rms, after_rms, noise_floor| Diagnosed {
            verdict: "explained".into(),
            before_rms,
            after_rms,
            noise_floor,
        };
        let some = figures(13.0, 5.0, 3.0);
        assert_eq!((some.left(), some.named()), (4.0, 12.0));
        // Below the floor, or worse than before, by chance.
        let none = figures(1.0, 1.01, 1.02);
        assert_eq!((none.left(), none.named()), (0.0, 0.0));
    }

    #[test]
    fn the_noise_is_the_best_figure_that_there_is() {
        let sensor = Sensor::Direct { unit: "mm".into(), revolution: None };
        let model = ErrorModel { sensor, centre: 0.0, coefficients: vec![0.1] };
        let mut file = Coefficients::of_model(&model, -1.0, 1.0, "by hand");
        assert_eq!(file.noise(), None);
        let (recording, mirror) = crate::default_recording().unwrap();
        let fitted = crate::fit(&recording, &mirror, &crate::Options::default()).unwrap().coefficients;
        let statistics = fitted.statistics.unwrap();
        let between = statistics.between_passes.as_ref().unwrap().standard_deviation;
        file.statistics = Some(statistics.clone());
        assert_eq!(file.noise(), Some(between));
        file.statistics.as_mut().unwrap().between_passes = None;
        assert_eq!(file.noise(), Some(statistics.after.rms));
        let (before_rms, after_rms, noise_floor) = (3.0, 2.0, 0.7);
        file.diagnosis = Some(Diagnosed { verdict: "described".into(), before_rms, after_rms, noise_floor });
        assert_eq!(file.noise(), Some(0.7));
    }
}
