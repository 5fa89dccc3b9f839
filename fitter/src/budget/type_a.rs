//! What the recording itself showed: type A.
//!
//! All in [`crate::coefficients::Units::statistics`]. Places are readings. Readings that follow one another may correlate: each
//! row then tells less, by [`independent`] and [`of_fitted`].

use super::Component;
use crate::coefficients::{Coefficients, Correlation, PointStatistics, Scatter};

/// Part of the range on either side of a place from which points are taken together there.
const REACH: f64 = 0.1;
/// So few points are not taken together: the nearest so many are.
const FEWEST_POINTS: usize = 5;

/// The part of the readings that would tell as much about a variance if they were independent: (1 − ρ²)/(1 + ρ²) of a
/// first-order autocorrelation ρ (Bartlett 1946).
pub fn independent(file: &Coefficients) -> f64 {
    let squared = correlation(file).map_or(0.0, |correlation| correlation.neighbours.powi(2));
    (1.0 - squared) / (1.0 + squared)
}

/// By how much correlated readings make the variance of what was fitted to them larger.
pub fn of_fitted(file: &Coefficients) -> f64 {
    correlation(file).map_or(1.0, |correlation| correlation.of_fitted)
}

fn correlation(file: &Coefficients) -> Option<Correlation> {
    file.recorded.as_ref()?.correlation
}

/// The scatter of one reading, at a place. Where passes repeat their angles, it is the scatter between them, at the place
/// where it is uneven over the range; of a diagnosed file its noise floor; else what the fit leaves, in which noise and lack
/// of fit cannot be told apart. The stated noise of the reference is taken off. None where nothing says it.
pub fn repeatability(file: &Coefficients, at: f64) -> Option<Component> {
    let unit = &file.units.statistics;
    let fitted = file.identification.as_ref();
    let rows = (file.recording.rows.saturating_sub(file.count_of_all())).max(1) as f64;
    let floor = file.diagnosis.as_ref().map(|d| d.noise_floor).filter(|floor| *floor > 0.0);
    let (what, deviation, freedom) = match (floor, scatter(file)) {
        (Some(floor), _) => ("noise floor of the diagnosis", floor, rows),
        (None, Some(scatter)) if scatter.weighted => {
            let (variance, freedom) = pooled(&near(file, at));
            ("scatter of one reading between passes, near the place", variance.sqrt(), freedom)
        }
        (None, Some(scatter)) => {
            let freedom = scatter.degrees_of_freedom as f64;
            ("scatter of one reading between passes", scatter.standard_deviation, freedom)
        }
        (None, None) => {
            let what = "what the fit leaves of one reading, lack of fit included";
            let of_fit =
                fitted.map(|i| (i.residual_standard_deviation, i.degrees_of_freedom as f64)).or_else(|| {
                    let noise = file.noise()?;
                    Some((noise, rows))
                });
            let (deviation, freedom) = of_fit.filter(|(_, freedom)| *freedom > 0.0)?;
            (what, deviation, freedom)
        }
    };
    let of_reference = file.recorded.as_ref().and_then(|r| r.reference.repeatability).unwrap_or(0.0);
    let own = (deviation * deviation - of_reference * of_reference).max(0.0);
    // The variance of a difference is that of what was estimated: u⁴/ν stays.
    let freedom = independent(file) * freedom * (own / (deviation * deviation)).powi(2);
    let less = if of_reference > 0.0 { ", less that of the reference" } else { "" };
    let what = format!("repeatability: {what}{less}");
    Some(Component::observed("repeatability", &what, unit, own.sqrt(), freedom.max(1.0)))
}

/// What the fit leaves of the means at the calibration points near a place, beyond what the noise of a mean makes of them.
/// `interval` is the standard uncertainty of the model at every point of the file's statistics: the fit follows the noise
/// of a mean by as much. Of a diagnosed file it is what the diagnosis left beyond the noise. None where no angle repeats.
pub fn lack_of_fit(file: &Coefficients, at: f64, interval: &[f64]) -> Option<Component> {
    let unit = &file.units.statistics;
    let what = "lack of fit: means near the place, beyond their noise";
    if let Some(diagnosed) = &file.diagnosis {
        let rows = file.recording.rows.saturating_sub(file.count_of_all()).max(1) as f64;
        let what = "lack of fit: what the diagnosis left beyond the noise";
        return Some(Component::observed(
            "lack_of_fit",
            what,
            unit,
            diagnosed.left(),
            independent(file) * rows,
        ));
    }
    scatter(file)?;
    let points = near(file, at);
    let all = &file.statistics.as_ref()?.points;
    if interval.len() != all.len() || points.is_empty() {
        return None;
    }
    let (variance, _) = pooled(&points);
    let count = points.len() as f64;
    let (mut squares, mut noise) = (0.0, 0.0);
    for (k, point) in &points {
        squares += point.mean_after.powi(2) / count;
        noise += (variance / point.readings as f64 - interval[*k].powi(2)).max(0.0) / count;
    }
    let left = (squares - noise).max(0.0);
    let count = independent(file) * count;
    let freedom = if squares > 0.0 { count * (left / squares).powi(2) } else { count };
    // Near the noise the difference itself is hardly known; it is then small beside the noise as well.
    Some(Component::observed("lack_of_fit", what, unit, left.sqrt(), freedom.max(1.0)))
}

/// What all readings of a pass share, in the mean over the passes that was fitted; less what noise that lasts from row to row
/// makes of it, which is in the interval of the model. None of a single pass.
pub fn pass_offset(file: &Coefficients) -> Option<Component> {
    let offset = file.recorded.as_ref()?.pass_offset?;
    let passes = offset.passes as f64;
    let what = "passes: what all readings of one share, in their mean";
    let in_model = (of_fitted(file) - 1.0) * file.noise()?.powi(2) / file.recording.rows.max(1) as f64;
    let variance = (offset.standard_deviation.powi(2) / passes - in_model).max(0.0);
    Some(Component::observed("pass_offset", what, &file.units.statistics, variance.sqrt(), passes - 1.0))
}

/// What the recording does not tell, for want of passes or of repeated angles.
pub fn missing(file: &Coefficients) -> Vec<String> {
    let mut missing = Vec::new();
    if file.recording.passes < 2 {
        missing.push(format!(
            "repeatability and lack of fit apart, type A: they need two passes or more, the recording has {}; what the fit \
             leaves stands for both",
            file.recording.passes
        ));
    } else if file.diagnosis.is_none() && !repeats(file) {
        missing.push(
            "repeatability and lack of fit apart, type A: no angle comes again in another pass; what the fit leaves stands for \
             both"
                .to_string(),
        );
    }
    if file.covariance_of_all().is_none() {
        missing
            .push("the interval of what was fitted: the file has no covariance of it; fit again".to_string());
    }
    missing
}

/// Whether angles were read again in other passes.
pub fn repeats(file: &Coefficients) -> bool {
    scatter(file).is_some()
}

fn scatter(file: &Coefficients) -> Option<&Scatter> {
    let scatter = file.statistics.as_ref()?.between_passes.as_ref()?;
    (scatter.degrees_of_freedom > 0).then_some(scatter)
}

/// The calibration points near a place, with their numbers; round the turn of a sensor that turns.
fn near(file: &Coefficients, at: f64) -> Vec<(usize, &PointStatistics)> {
    let Some(statistics) = &file.statistics else { return Vec::new() };
    let range = &file.valid_range;
    let turn = file.turn.as_ref().filter(|turn| turn.whole).map(|turn| turn.revolution);
    let distance = |point: &PointStatistics| {
        let apart = point.reading - at;
        turn.map_or(apart, |turn| apart - turn * (apart / turn).round()).abs()
    };
    let mut points: Vec<(usize, &PointStatistics)> = statistics.points.iter().enumerate().collect();
    points.sort_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
    let within = points.iter().take_while(|(_, p)| distance(p) <= REACH * (range.to - range.from)).count();
    points.truncate(within.max(FEWEST_POINTS));
    points
}

/// The variance of one reading that points have together, and its degrees of freedom.
fn pooled(points: &[(usize, &PointStatistics)]) -> (f64, f64) {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for (_, point) in points {
        let own = point.readings.saturating_sub(1) as f64;
        squares += own * point.standard_deviation.unwrap_or(0.0).powi(2);
        freedom += own;
    }
    (squares / f64::max(freedom, 1.0), freedom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, default_recording, fit};

    fn file() -> Coefficients {
        let (recording, mirror) = default_recording().unwrap();
        fit(&recording, &mirror, &Options::default()).unwrap().coefficients
    }

    /// A constant error of all means is found as such, whatever noise made the means scatter before.
    #[test]
    fn what_is_left_of_the_means_is_lack_of_fit() {
        let mut file = file();
        let points = file.statistics.as_mut().unwrap().points.iter_mut();
        points.for_each(|point| point.mean_after = 3.0);
        let exact = vec![0.0; file.statistics.as_ref().unwrap().points.len()];
        let found = lack_of_fit(&file, 0.0, &exact).unwrap();
        // 0.5″ in six passes: 0.2″ of a mean are noise.
        assert!((found.value - (9.0f64 - 0.04).sqrt()).abs() < 0.01, "{found:?}");
        // Means of no error at all are below the noise, not of a negative lack.
        file.statistics.as_mut().unwrap().points.iter_mut().for_each(|point| point.mean_after = 0.0);
        assert_eq!(lack_of_fit(&file, 0.0, &exact).unwrap().value, 0.0);
        assert_eq!(lack_of_fit(&file, 0.0, &[]), None);
    }

    #[test]
    fn uneven_noise_is_that_of_the_place() {
        let mut file = file();
        let statistics = file.statistics.as_mut().unwrap();
        statistics.between_passes.as_mut().unwrap().weighted = true;
        for point in &mut statistics.points {
            point.standard_deviation = Some(if point.reading < 0.0 { 0.2 } else { 0.8 });
        }
        let at = |place| repeatability(&file, place).unwrap();
        assert_eq!((at(-0.3).value, at(0.3).value), (0.2, 0.8));
        // Five degrees of freedom of each point within a tenth of the range on either side.
        assert!((25.0..45.0).contains(&at(-0.3).degrees_of_freedom.unwrap()), "{:?}", at(-0.3));
    }

    #[test]
    fn an_offset_of_the_passes_is_less_in_their_mean() {
        let mut file = file();
        let offset = crate::coefficients::PassOffset { standard_deviation: 0.6, passes: 9 };
        file.recorded.as_mut().unwrap().pass_offset = Some(offset);
        let found = pass_offset(&file).unwrap();
        assert_eq!((found.value, found.degrees_of_freedom), (0.2, Some(8.0)));
    }
}
