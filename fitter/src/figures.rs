//! Figures for people: as many digits as their uncertainty supports, in a unit that shows them. Files for programs keep
//! every digit.

/// Standard deviations on either side of a normal estimate within which it lies with 95 %.
pub const NORMAL_95: f64 = 1.959_963_985;
/// Significant digits of a half-width of an interval (Guide to the Expression of Uncertainty in Measurement, 7.2.6).
const OF_UNCERTAINTY: i32 = 2;
/// Significant digits of a root mean square and of every figure without an uncertainty: of a hundred readings it is known
/// to a part in fourteen, of ten thousand to one in a hundred and forty.
const OF_FIGURE: i32 = 3;
/// Significant digits of a place.
const OF_PLACE: i32 = 4;
/// Most digits of a figure: more stand behind no measurement.
const MOST: i32 = 9;
/// Plain decimals from here on; below, and from [`LONG`] on, powers of ten.
const SHORT: f64 = 1e-4;
/// See [`SHORT`].
const LONG: f64 = 1e7;

/// Units of one kind, the largest first: name, in how many of the first, and the smallest value that is shown in it.
type Family = &'static [(&'static str, f64, f64)];

/// Degrees stay degrees down to a thousandth and arcseconds down to a hundredth, as angles are read; other values are
/// shown in a unit of which they have one at least.
const FAMILIES: [Family; 7] = [
    &[("m", 1.0, 1.0), ("mm", 1e-3, 1.0), ("um", 1e-6, 1.0), ("nm", 1e-9, 1.0), ("pm", 1e-12, 0.0)],
    &[
        ("deg", 1.0, 1e-3),
        ("arcsec", 1.0 / 3600.0, 1e-2),
        ("mas", 1.0 / 3.6e6, 1.0),
        ("uas", 1.0 / 3.6e9, 0.0),
    ],
    &[("rad", 1.0, 1.0), ("mrad", 1e-3, 1.0), ("urad", 1e-6, 1.0), ("nrad", 1e-9, 0.0)],
    &[("s", 1.0, 1.0), ("ms", 1e-3, 1.0), ("us", 1e-6, 1.0), ("ns", 1e-9, 0.0)],
    &[("V", 1.0, 1.0), ("mV", 1e-3, 1.0), ("uV", 1e-6, 1.0), ("nV", 1e-9, 0.0)],
    &[("A", 1.0, 1.0), ("mA", 1e-3, 1.0), ("uA", 1e-6, 1.0), ("nA", 1e-9, 0.0)],
    &[("K", 1.0, 1.0), ("mK", 1e-3, 1.0), ("uK", 1e-6, 0.0)],
];
/// The unit in which the data stand is kept down to this.
const OWN: f64 = 0.1;

/// The unit in which a value of this size is shown, and by what to multiply. A unit that is in no family, `arcsec/K` for
/// example, stays.
pub fn shown_in(size: f64, unit: &str) -> (f64, String) {
    let own = || (1.0, unit.to_string());
    let size = size.abs();
    if size == 0.0 || !size.is_finite() {
        return own();
    }
    let place = |family: &Family| family.iter().position(|(name, ..)| *name == unit);
    let Some((family, from)) = FAMILIES.iter().find_map(|family| Some((family, place(family)?))) else {
        return own();
    };
    let scale = |name: f64| family[from].1 / name;
    if size >= family[from].2.min(OWN) {
        return own();
    }
    let fits = family[from..].iter().find(|(_, of, least)| size * scale(*of) >= *least);
    fits.map_or_else(own, |(name, of, _)| (scale(*of), (*name).to_string()))
}

/// A number with so many decimals, or as a power of ten where decimals would hide or drown it.
fn decimal(value: f64, decimals: i32, size: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    if !(SHORT..LONG).contains(&size) {
        let digits = (exponent(value) + decimals).clamp(0, MOST) as usize;
        return format!("{value:.digits$e}");
    }
    let decimals = decimals.clamp(0, MOST) as usize;
    let text = format!("{value:.decimals$}");
    // What rounds to zero has no sign.
    if text.trim_start_matches('-').bytes().all(|b| b == b'0' || b == b'.') {
        text.trim_start_matches('-').to_string()
    } else {
        text
    }
}

/// The power of ten of the first digit.
fn exponent(value: f64) -> i32 {
    if value == 0.0 || !value.is_finite() { 0 } else { value.abs().log10().floor() as i32 }
}

/// Decimals that give so many significant digits of a size.
fn decimals(size: f64, digits: i32) -> i32 {
    digits - 1 - exponent(size)
}

/// A number to three significant digits, trailing zeros included: `0.0712`, `12.0`, `1250`.
pub fn number(value: f64) -> String {
    decimal(value, decimals(value, OF_FIGURE), value.abs())
}

/// A root mean square, or another figure whose uncertainty is not known, with its unit: `71.2 um`.
///
/// # Example
/// ```
/// use fitter::figures::figure;
/// assert_eq!(figure(0.0000034, "mm"), "3.40 nm");
/// assert_eq!(figure(0.0471, "deg"), "0.0471 deg");
/// assert_eq!(figure(0.0, "mm"), "0 mm");
/// ```
pub fn figure(value: f64, unit: &str) -> String {
    let (scale, unit) = shown_in(value, unit);
    with_unit(&number(scale * value), &unit)
}

/// A value and the half-width of its 95 % interval: `34.0 ± 1.2 ms`.
pub fn plus_minus(value: f64, half_width: f64, unit: &str) -> String {
    let (texts, unit) = together(&[value], half_width, unit);
    if texts.1.is_empty() {
        with_unit(&texts.0[0], &unit)
    } else {
        with_unit(&format!("{} ± {}", texts.0[0], texts.1), &unit)
    }
}

/// A value with its 95 % interval, `3.02 ms [2.95, 3.10]`, both ends with the value's digits.
///
/// # Example
/// ```
/// use fitter::figures::with_interval;
/// assert_eq!(with_interval(0.0030412, [0.0030299, 0.0030527], "s"), "3.041 ms [3.030, 3.053]");
/// assert_eq!(with_interval(2.0, [f64::NEG_INFINITY, 3.0], "mm"), "2.00 mm");
/// ```
pub fn with_interval(value: f64, ci95: [f64; 2], unit: &str) -> String {
    let half_width = 0.5 * (ci95[1] - ci95[0]);
    let ((texts, uncertainty), unit) = together(&[value, ci95[0], ci95[1]], half_width, unit);
    let text = with_unit(&texts[0], &unit);
    if uncertainty.is_empty() { text } else { format!("{text} [{}, {}]", texts[1], texts[2]) }
}

/// A value and the ends of its interval for the cells of a table, in the unit that comes last; ends that say nothing are
/// empty.
pub fn cells(value: f64, ci95: [f64; 2], unit: &str) -> ([String; 3], String) {
    let ((texts, uncertainty), unit) = together(&[value, ci95[0], ci95[1]], 0.5 * (ci95[1] - ci95[0]), unit);
    let known = !uncertainty.is_empty();
    let mut texts =
        texts.into_iter().enumerate().map(|(k, text)| if known || k == 0 { text } else { String::new() });
    let mut next = || texts.next().unwrap_or_default();
    ([next(), next(), next()], unit)
}

/// A place or another number that is no estimate: four significant digits at most, and none that say nothing.
pub fn plain(value: f64) -> String {
    let text = decimal(value, decimals(value, OF_PLACE), value.abs());
    match text.split_once('e') {
        None if text.contains('.') => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        _ => text,
    }
}

/// Values in one unit to two digits of the half-width, and the half-width; empty where it says nothing.
fn together(values: &[f64], half_width: f64, unit: &str) -> ((Vec<String>, String), String) {
    let (scale, unit) = shown_in(values[0], unit);
    let known = half_width.is_finite() && half_width > 0.0;
    let size = (scale * values[0]).abs();
    let half_width = scale * half_width;
    let counted = !known && is_bare(&unit) && values[0].fract() == 0.0;
    let decimals = match (known, counted) {
        (true, _) => decimals(half_width, OF_UNCERTAINTY),
        // A number of something.
        (false, true) => 0,
        (false, false) => decimals(size, OF_FIGURE),
    };
    // An interval of many sizes of the value shows the value to one digit at least.
    let decimals = if size > 0.0 { decimals.max(-exponent(size)) } else { decimals };
    let size = if size > 0.0 { size } else { half_width };
    let texts = values.iter().map(|value| decimal(scale * value, decimals, size)).collect();
    ((texts, if known { decimal(half_width, decimals, size) } else { String::new() }), unit)
}

fn is_bare(unit: &str) -> bool {
    unit.is_empty() || unit == "1"
}

fn with_unit(text: &str, unit: &str) -> String {
    if is_bare(unit) { text.to_string() } else { format!("{text} {unit}") }
}

/// A range in few digits that does not reach beyond the recorded one.
pub fn inside([from, to]: [f64; 2]) -> String {
    // A thousandth of the width, as a power of ten.
    let step = 10f64.powf(((to - from).abs().max(f64::MIN_POSITIVE) / 1000.0).log10().ceil());
    let decimals = (-step.log10().round()).max(0.0) as usize;
    let (from, to) = ((from / step).ceil() * step, (to / step).floor() * step);
    format!("{from:.decimals$}..{to:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_and_units_follow_the_uncertainty() {
        assert_eq!(plus_minus(0.0340123, 0.00123, "s"), "34.0 ± 1.2 ms");
        assert_eq!(plus_minus(-0.8731, 0.0123, "deg"), "-0.873 ± 0.012 deg");
        assert_eq!(plus_minus(12_345.678, 120.0, "counts"), "12346 ± 120 counts");
        assert_eq!(plus_minus(0.5, 0.0, "mm"), "0.500 mm");
        assert_eq!(figure(0.000012, "deg"), "0.0432 arcsec");
        assert_eq!(figure(0.000202, "mm"), "202 nm");
        assert_eq!(figure(202.0, "mm"), "202 mm");
        assert_eq!(figure(1.5e-6, "counts"), "1.50e-6 counts");
        assert_eq!(figure(0.0123, "arcsec/K"), "0.0123 arcsec/K");
        assert_eq!(with_interval(9.0, [9.0, 9.0], "1"), "9");
        assert_eq!(figure(f64::NAN, "mm"), "NaN mm");
        assert_eq!(with_interval(-0.012, [-0.3, 0.28], "deg"), "-0.01 deg [-0.30, 0.28]");
        assert_eq!(with_interval(1e300, [-1e308, 1e308], "arcsec"), "1.00e300 arcsec");
        assert_eq!(number(0.0999999), "0.1000");
        assert_eq!(
            (plain(-12.5), plain(0.25), plain(3.25e-12)),
            ("-12.5".into(), "0.25".into(), "3.250e-12".into())
        );
        let (texts, unit) = cells(0.0030412, [0.0029, 0.0032], "s");
        assert_eq!((texts.join(" "), unit.as_str()), ("3.04 2.90 3.20".to_string(), "ms"));
    }

    #[test]
    fn a_range_stays_within_what_was_recorded() {
        assert_eq!(inside([14.80716, 39.21684]), "14.9..39.2");
        assert_eq!(inside([-0.012, 0.034_567]), "-0.0120..0.0345");
        assert_eq!(inside([-12_345.6, 23_456.7]), "-12300..23400");
    }
}
