//! Units at the edges: angles are radians and lengths millimetres inside, and every other unit stands
//! in a name. This is the only place where a conversion factor is written down.

/// Arcseconds in one radian, 180·3600/π, to the last bit of an `f64`.
pub const ARCSEC_PER_RAD: f64 = 206_264.806_247_096_36;

/// Converts an angle from radians to arcseconds.
pub fn arcsec_from_rad(angle_rad: f64) -> f64 {
    angle_rad * ARCSEC_PER_RAD
}

/// Converts an angle from arcseconds to radians.
pub fn rad_from_arcsec(angle_arcsec: f64) -> f64 {
    angle_arcsec / ARCSEC_PER_RAD
}

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// In metres.
    Length,
    /// In turns.
    Angle,
    /// In seconds.
    Time,
    /// In kelvin.
    Temperature,
    /// In amperes.
    Current,
    /// In volts.
    Voltage,
}

/// A unit by its name: value in the dimension's own unit = scale·value + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// What it measures.
    pub dimension: Dimension,
    scale: f64,
    offset: f64,
}

/// Names of units in the order of [`Unit::named`]'s table, for messages.
pub const UNIT_NAMES: &str = "m, mm, um, nm, in; deg, arcmin, arcsec, mas, rad, mrad, urad, turn, grad, 14bit; s, ms, us, \
                              min, h; c, k, f; a, ma, ua; v, mv, uv";

impl Unit {
    /// The unit of that name, upper and lower case alike; `14bit` is the count of an encoder of 14 bits.
    pub fn named(name: &str) -> Option<Unit> {
        use Dimension::{Angle, Current, Length, Temperature, Time, Voltage};
        let of = |dimension, scale| Some(Unit { dimension, scale, offset: 0.0 });
        let name = name.trim().to_lowercase().replace(['µ', 'μ'], "u").replace('°', "deg");
        match name.as_str() {
            "m" => of(Length, 1.0),
            "mm" => of(Length, 1e-3),
            "um" | "micron" => of(Length, 1e-6),
            "nm" => of(Length, 1e-9),
            "in" | "inch" => of(Length, 0.0254),
            "turn" | "turns" | "rev" => of(Angle, 1.0),
            "deg" | "degree" | "degrees" => of(Angle, 1.0 / 360.0),
            "grad" | "gon" => of(Angle, 1.0 / 400.0),
            "arcmin" => of(Angle, 1.0 / 21_600.0),
            "arcsec" => of(Angle, 1.0 / 1_296_000.0),
            "mas" => of(Angle, 1.0 / 1_296_000_000.0),
            "rad" => of(Angle, 1.0 / std::f64::consts::TAU),
            "mrad" => of(Angle, 1e-3 / std::f64::consts::TAU),
            "urad" => of(Angle, 1e-6 / std::f64::consts::TAU),
            "s" | "sec" => of(Time, 1.0),
            "ms" => of(Time, 1e-3),
            "us" => of(Time, 1e-6),
            "ns" => of(Time, 1e-9),
            "min" => of(Time, 60.0),
            "h" => of(Time, 3600.0),
            "k" => of(Temperature, 1.0),
            "c" | "degc" => Some(Unit { dimension: Temperature, scale: 1.0, offset: 273.15 }),
            "f" | "degf" => {
                let scale = 5.0 / 9.0;
                Some(Unit { dimension: Temperature, scale, offset: 273.15 - 32.0 * scale })
            }
            "a" => of(Current, 1.0),
            "ma" => of(Current, 1e-3),
            "ua" => of(Current, 1e-6),
            "v" => of(Voltage, 1.0),
            "mv" => of(Voltage, 1e-3),
            "uv" => of(Voltage, 1e-6),
            other => {
                let bits: u32 = other.strip_suffix("bit")?.parse().ok()?;
                (1..=32).contains(&bits).then(|| 0.5f64.powi(bits as i32)).and_then(|scale| of(Angle, scale))
            }
        }
    }

    /// The unit of which `count` make a turn.
    pub fn part_of_turn(count: f64) -> Unit {
        Unit { dimension: Dimension::Angle, scale: 1.0 / count, offset: 0.0 }
    }

    /// Factor and offset that turn values of this unit into another; none where they measure different things.
    pub fn into(self, other: Unit) -> Option<(f64, f64)> {
        let factor = self.scale / other.scale;
        (self.dimension == other.dimension).then(|| (factor, (self.offset - other.offset) / other.scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_by_name() {
        let convert = |value: f64, from: &str, to: &str| {
            let (factor, offset) = Unit::named(from)?.into(Unit::named(to)?)?;
            Some(factor * value + offset)
        };
        for (value, from, to, expected) in [
            (250.0, "µm", "mm", 0.25),
            (1.0, "deg", "arcsec", 3600.0),
            (1.0, "rad", "arcsec", ARCSEC_PER_RAD),
            (8192.0, "14bit", "deg", 180.0),
            (2.0, "min", "s", 120.0),
            (212.0, "F", "C", 100.0),
            (300.0, "K", "degC", 26.85),
            (5.0, "mA", "A", 0.005),
        ] {
            approx::assert_relative_eq!(convert(value, from, to).unwrap(), expected, max_relative = 1e-14);
        }
        assert_eq!(convert(1.0, "mm", "deg"), None);
        assert_eq!(Unit::named("furlong"), None);
        assert_eq!(Unit::named("99bit"), None);
    }
}
