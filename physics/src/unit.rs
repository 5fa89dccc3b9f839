//! Units: a factor and powers of base units. What has another dimension cannot be added; what has the same is converted.
//!
//! A plane angle is a dimension of its own, so that arcseconds are never added to kelvin or to a pure number; only the
//! radian is one. A name
//! that is no known unit is a base unit of its own (`p`, the unit of a position; `strain`).

use std::collections::BTreeMap;
use std::fmt;

use winnow::ascii::{digit1, space0};
use winnow::combinator::{alt, delimited, opt, preceded, repeat, terminated};
use winnow::prelude::*;
use winnow::token::take_while;

/// Exponents are held in this part of one, so that square and cube roots are exact.
const PARTS: i32 = 12;

/// A unit: so many of the product of powers of base units.
#[derive(Debug, Clone)]
pub struct Unit {
    /// The units that it was made of, with their exponents in twelfths, none zero.
    written: Vec<(String, i32)>,
    scale: f64,
    /// Exponents of base units in twelfths, none zero.
    bases: BTreeMap<String, i32>,
}

/// Name, size, and base units with whole exponents.
type Known = (&'static str, f64, &'static [(&'static str, i32)]);

const KNOWN: &[Known] = &[
    ("1", 1.0, &[]),
    ("%", 1e-2, &[]),
    ("pct", 1e-2, &[]),
    ("ppm", 1e-6, &[]),
    ("rad", 1.0, &[("rad", 1)]),
    ("mrad", 1e-3, &[("rad", 1)]),
    ("urad", 1e-6, &[("rad", 1)]),
    ("µrad", 1e-6, &[("rad", 1)]),
    ("deg", std::f64::consts::PI / 180.0, &[("rad", 1)]),
    ("arcmin", std::f64::consts::PI / 10_800.0, &[("rad", 1)]),
    ("arcsec", std::f64::consts::PI / 648_000.0, &[("rad", 1)]),
    ("m", 1.0, &[("m", 1)]),
    ("mm", 1e-3, &[("m", 1)]),
    ("um", 1e-6, &[("m", 1)]),
    ("µm", 1e-6, &[("m", 1)]),
    ("nm", 1e-9, &[("m", 1)]),
    ("l", 1e-3, &[("m", 3)]),
    ("s", 1.0, &[("s", 1)]),
    ("ms", 1e-3, &[("s", 1)]),
    ("us", 1e-6, &[("s", 1)]),
    ("µs", 1e-6, &[("s", 1)]),
    ("min", 60.0, &[("s", 1)]),
    ("h", 3600.0, &[("s", 1)]),
    ("Hz", 1.0, &[("s", -1)]),
    ("kHz", 1e3, &[("s", -1)]),
    ("kg", 1.0, &[("kg", 1)]),
    ("g", 1e-3, &[("kg", 1)]),
    ("K", 1.0, &[("K", 1)]),
    ("mK", 1e-3, &[("K", 1)]),
    ("°C", 1.0, &[("K", 1)]),
    ("A", 1.0, &[("A", 1)]),
    ("mA", 1e-3, &[("A", 1)]),
    ("N", 1.0, &[("kg", 1), ("m", 1), ("s", -2)]),
    ("mN", 1e-3, &[("kg", 1), ("m", 1), ("s", -2)]),
    ("Pa", 1.0, &[("kg", 1), ("m", -1), ("s", -2)]),
    ("hPa", 1e2, &[("kg", 1), ("m", -1), ("s", -2)]),
    ("kPa", 1e3, &[("kg", 1), ("m", -1), ("s", -2)]),
    ("bar", 1e5, &[("kg", 1), ("m", -1), ("s", -2)]),
    ("J", 1.0, &[("kg", 1), ("m", 2), ("s", -2)]),
    ("W", 1.0, &[("kg", 1), ("m", 2), ("s", -3)]),
    ("V", 1.0, &[("kg", 1), ("m", 2), ("s", -3), ("A", -1)]),
    ("mV", 1e-3, &[("kg", 1), ("m", 2), ("s", -3), ("A", -1)]),
    ("Ohm", 1.0, &[("kg", 1), ("m", 2), ("s", -3), ("A", -2)]),
];

/// Ends of a column's name that stand for a unit written otherwise.
const SUFFIXES: &[(&str, &str)] = &[
    ("c", "K"),
    ("a", "A"),
    ("ma", "mA"),
    ("v", "V"),
    ("mv", "mV"),
    ("n", "N"),
    ("w", "W"),
    ("pa", "Pa"),
    ("hpa", "hPa"),
    ("kpa", "kPa"),
    ("hz", "Hz"),
    ("khz", "kHz"),
    ("ohm", "Ohm"),
    ("ue", "ppm"),
    ("l_min", "l/min"),
];

impl Unit {
    /// A pure number.
    pub fn one() -> Unit {
        Unit { written: Vec::new(), scale: 1.0, bases: BTreeMap::new() }
    }

    /// The unit with a name, or a base unit of that name.
    pub fn named(name: &str) -> Unit {
        let (scale, bases) = match KNOWN.iter().find(|known| known.0 == name) {
            Some((_, scale, bases)) => (*scale, bases.to_vec()),
            None => (1.0, vec![(name, 1)]),
        };
        let bases = bases.into_iter().map(|(base, power)| (base.to_string(), PARTS * power)).collect();
        let written = if name == "1" { Vec::new() } else { vec![(name.to_string(), PARTS)] };
        Unit { written, scale, bases }
    }

    /// Reads a unit: `arcsec/A^2`, `1/(p^2 s^2)`, `V^0.5/s`, `l/min`.
    ///
    /// # Errors
    /// A sentence with the place that is no unit.
    pub fn parse(text: &str) -> Result<Unit, String> {
        let unit = delimited(space0, product, space0).parse(text).map_err(|error| {
            let found = &text[error.offset()..];
            let found = if found.is_empty() { "the end".to_string() } else { format!("`{found}`") };
            format!("`{text}` is no unit: found {found}, expected a product of units such as arcsec/A^2")
        })?;
        if unit.scale.is_normal() {
            Ok(unit)
        } else {
            Err(format!("`{text}` is no unit: its size is beyond all numbers"))
        }
    }

    /// The unit of a column by the end of its name: `humidity_pct`, `flow_l_min`, `strain_ue`; of `common_mode`, which two
    /// probes make, micrometres. A name without an end that says a unit is a unit of its own.
    pub fn of_column(name: &str) -> Unit {
        if name == "common_mode" {
            return Unit::named("um");
        }
        let ends = name.match_indices('_').map(|(at, _)| &name[at + 1..]);
        for end in ends {
            if let Some((_, unit)) = SUFFIXES.iter().find(|(suffix, _)| *suffix == end) {
                return Unit::parse(unit).unwrap_or_else(|_| Unit::one());
            }
            if KNOWN.iter().any(|known| known.0 == end) {
                return Unit::named(end);
            }
        }
        Unit::named(name.rsplit_once('_').map_or(name, |(_, end)| end))
    }

    /// How many of `other` one of it is; none where the dimensions differ.
    pub fn in_units_of(&self, other: &Unit) -> Option<f64> {
        let plain = || Some(self.without_radians()? == other.without_radians()?);
        let same = self.bases == other.bases || plain() == Some(true);
        same.then(|| self.scale / other.scale)
    }

    /// The dimension, the radian being a pure number: sin x is x for small x. None where an angle is in another unit.
    fn without_radians(&self) -> Option<BTreeMap<String, i32>> {
        let is_angle = |name: &String| name != "rad" && Unit::named(name).bases.contains_key("rad");
        let mut bases = self.bases.clone();
        bases.remove("rad");
        (!self.written.iter().any(|(name, _)| is_angle(name))).then_some(bases)
    }

    /// The product.
    pub fn times(&self, other: &Unit) -> Unit {
        let mut bases = self.bases.clone();
        for (base, power) in &other.bases {
            *bases.entry(base.clone()).or_default() += power;
        }
        bases.retain(|_, power| *power != 0);
        let mut written = self.written.clone();
        for (name, power) in &other.written {
            match written.iter_mut().find(|(own, _)| own == name) {
                Some((_, own)) => *own += power,
                None => written.push((name.clone(), *power)),
            }
        }
        written.retain(|(_, power)| *power != 0);
        Unit { written, scale: self.scale * other.scale, bases }
    }

    /// Its power; none where the exponent of a unit would be no twelfth of a whole number.
    pub fn power(&self, exponent: f64) -> Option<Unit> {
        let scaled = |power: &i32| {
            let scaled = f64::from(*power) * exponent;
            (scaled == scaled.round() && scaled.abs() <= 1e6).then_some(scaled as i32)
        };
        let mut bases = BTreeMap::new();
        for (base, power) in &self.bases {
            bases.insert(base.clone(), scaled(power)?);
        }
        bases.retain(|_, power| *power != 0);
        let written: Option<Vec<_>> =
            self.written.iter().map(|(name, power)| Some((name.clone(), scaled(power)?))).collect();
        let mut written = written?;
        written.retain(|(_, power)| *power != 0);
        Some(Unit { written, scale: self.scale.powf(exponent), bases })
    }

    /// It with `unit` in place of the base unit `name`.
    pub fn with(&self, name: &str, unit: &Unit) -> Unit {
        let power = self.written.iter().find(|(own, _)| own == name).map_or(0, |(_, power)| *power);
        let power = f64::from(power) / f64::from(PARTS);
        match (Unit::named(name).power(-power), unit.power(power)) {
            (Some(without), Some(with)) if power != 0.0 => self.times(&without).times(&with),
            _ => self.clone(),
        }
    }

    /// Whether it is 1 without a dimension.
    pub fn is_one(&self) -> bool {
        self.bases.is_empty() && self.scale == 1.0
    }
}

/// Units are equal where a value in one is the same value in the other.
impl PartialEq for Unit {
    fn eq(&self, other: &Unit) -> bool {
        self.in_units_of(other).is_some_and(|ratio| (ratio - 1.0).abs() < 1e-12)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = |(name, power): &(String, i32)| match power.abs() {
            PARTS => name.clone(),
            power if power % PARTS == 0 => format!("{name}^{}", power / PARTS),
            power => format!("{name}^{}", f64::from(power) / f64::from(PARTS)),
        };
        let (above, below): (Vec<_>, Vec<_>) = self.written.iter().partition(|(_, power)| *power > 0);
        let [above, below] =
            [above, below].map(|parts: Vec<_>| parts.into_iter().map(part).collect::<Vec<_>>());
        f.write_str(&if above.is_empty() { "1".to_string() } else { above.join(" ") })?;
        match &below[..] {
            [] => Ok(()),
            [one] => write!(f, "/{one}"),
            several => write!(f, "/({})", several.join(" ")),
        }
    }
}

/// Factors one after another, divided from left to right.
fn product(input: &mut &str) -> ModalResult<Unit> {
    let first = factor.parse_next(input)?;
    let sign = delimited(space0, opt(alt(('*', '·', '/'))), space0);
    repeat(0.., (sign, factor))
        .fold(
            move || first.clone(),
            |unit, (sign, next): (Option<char>, Unit)| {
                let next = if sign == Some('/') { next.power(-1.0).unwrap_or_else(Unit::one) } else { next };
                unit.times(&next)
            },
        )
        .parse_next(input)
}

/// A name or a product in brackets, with its power.
fn factor(input: &mut &str) -> ModalResult<Unit> {
    let name = alt((
        take_while(1.., |c: char| c.is_alphabetic() || "_%°µ".contains(c)),
        terminated("1", winnow::combinator::not(winnow::token::one_of('0'..='9'))),
    ));
    let base = alt((delimited(('(', space0), product, (space0, ')')), name.map(Unit::named)));
    (base, opt(preceded((space0, '^', space0), exponent)))
        .verify_map(|(unit, power)| power.map_or(Some(unit.clone()), |power| unit.power(power)))
        .parse_next(input)
}

/// A number, or a quotient in brackets.
fn exponent(input: &mut &str) -> ModalResult<f64> {
    let decimal = || (opt('-'), digit1, opt(('.', digit1))).take().parse_to::<f64>();
    let quotient = (decimal(), (space0, '/', space0), decimal()).map(|(above, _, below)| above / below);
    let bracketed = delimited(('(', space0), alt((quotient, decimal())), (space0, ')'));
    alt((bracketed, decimal())).parse_next(input)
}

#[cfg(test)]
mod tests {
    use super::Unit;

    fn unit(text: &str) -> Unit {
        Unit::parse(text).unwrap()
    }

    #[test]
    fn units_are_products_of_powers() {
        assert_eq!(unit("V"), unit("W/A"));
        assert_eq!(unit("1/(p^2 s^2)"), unit("1/p^2/s^2"));
        assert_eq!(unit("V^0.5/s").power(2.0), Some(unit("V/s^2")));
        assert_eq!(unit("deg").in_units_of(&unit("arcsec")).map(f64::round), Some(3600.0));
        assert_eq!(unit("arcsec").in_units_of(&unit("K")), None);
        assert_ne!(unit("arcsec"), unit("1"));
        assert_eq!(unit("arcsec/A^2").to_string(), "arcsec/A^2");
        assert_eq!(unit("arcsec").times(&unit("1/K")).to_string(), "arcsec/K");
    }

    #[test]
    fn a_column_says_its_unit_at_its_end() {
        for (column, expected) in [
            ("temperature_c", "K"),
            ("coil_a", "A"),
            ("flow_l_min", "l/min"),
            ("humidity_pct", "%"),
            ("x1_mm", "mm"),
        ] {
            assert_eq!(Unit::of_column(column), unit(expected), "{column}");
        }
        assert_ne!(Unit::of_column("load"), unit("1"));
    }

    #[test]
    fn what_is_no_unit_is_refused_at_its_place() {
        for text in ["", "arcsec/", "arcsec//K", "K^x", "2 K", "(K", "K^(1/0)", "m^1e9"] {
            assert!(Unit::parse(text).is_err(), "{text}");
        }
    }
}
