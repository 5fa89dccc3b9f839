//! Median and scatter that a tenth of the rows cannot disturb.

use super::limits;

/// The median of finite values; NaN of none. The order of `values` is lost.
pub fn median(values: &mut [f64]) -> f64 {
    let n = values.len();
    if n == 0 {
        return f64::NAN;
    }
    let (_, &mut upper, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        return upper;
    }
    let lower = values[..n / 2].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}

/// Quantile `part` of finite values, which are sorted.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * part).round() as usize]
}

/// From where to where finite values go, but for some far out: those beyond twice the range of the middle four fifths.
pub fn range(values: &[f64]) -> (f64, f64) {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return (0.0, 0.0) };
    let (low, high) = (quantile(&sorted, 0.1), quantile(&sorted, 0.9));
    let beyond = 2.0 * (high - low);
    (first.max(low - beyond), last.min(high + beyond))
}

/// Finite values from −1 to 1 over their [`range`]; those far out go beyond, and blanks stay blank.
pub fn scaled(values: &[f64]) -> Vec<f64> {
    let (low, high) = range(values);
    let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).max(f64::MIN_POSITIVE));
    values.iter().map(|value| (value - middle) / half).collect()
}

/// Mean of the smaller nine tenths of normal absolute values, over their standard deviation.
const TRIMMED: f64 = 0.6573;
/// 97 % quantile of normal absolute values, over their standard deviation.
const AT_97: f64 = 2.17;

/// Standard deviation of deviations of which a tenth may be anything; `absolute` is sorted in place.
pub fn trimmed(absolute: &mut [f64]) -> f64 {
    if absolute.is_empty() {
        return 0.0;
    }
    absolute.sort_unstable_by(f64::total_cmp);
    let kept = (absolute.len() * 9).div_ceil(10);
    absolute[..kept].iter().sum::<f64>() / kept as f64 / TRIMMED
}

/// As [`trimmed`], and no less than a heavy tail asks for.
pub fn with_tail(absolute: &mut [f64]) -> f64 {
    let body = trimmed(absolute);
    if absolute.len() < 60 { body } else { body.max(quantile(absolute, 0.97) / AT_97) }
}

/// The smallest step between values of a column, above the rounding of binary numbers; 0 of a constant.
pub fn resolution(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let size = sorted.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
    let step = |pair: &[f64]| pair[1] - pair[0];
    let least = 1e-12 * size;
    let smallest = sorted.windows(2).map(step).filter(|d| *d > least).fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

/// What the scatter of a column of these values is at least.
pub fn least(values: &[f64]) -> f64 {
    let size = values.iter().filter(|v| v.is_finite()).fold(0.0_f64, |size, v| size.max(v.abs()));
    (limits::OF_RESOLUTION * resolution(values)).max(limits::ROUNDING * size).max(f64::MIN_POSITIVE)
}
