//! What is known of an effect before it is injected: its name, its parameters and where it shows.

use super::{Mechanism, Values};
use crate::device::Device;

/// Whether an effect is the same on a second recording of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// It belongs to the device and holds on any recording.
    Device,
    /// It happened in the time of one recording: a step, a drift since switch-on.
    Recording,
}

/// How a parameter is drawn where a random effect is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drawn {
    /// The strength, to which the effect is proportional: drawn as +1 or −1, to be scaled.
    Strength,
    /// The strength of an effect that knows one sign only: drawn as 1, to be scaled.
    PositiveStrength,
    /// Uniformly between two values.
    Uniform(f64, f64),
    /// A whole number between two values, both included.
    Whole(u32, u32),
    /// Uniformly between two fractions of the recording's duration, in seconds.
    OfDuration(f64, f64),
    /// An angle in degrees of either sign, its size between two fractions of the commanded stroke.
    EitherSide(f64, f64),
    /// A length in degrees between so many steps and a fraction of the whole stroke.
    FromSteps(f64, f64),
    /// As `FromSteps`, in arcseconds.
    PeriodFromSteps(f64, f64),
}

/// One parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Its name, with the unit in it.
    pub name: &'static str,
    /// Its unit as printed.
    pub unit: &'static str,
    /// What it is where it is not given; none where it must be given.
    pub default: Option<f64>,
    /// The least and the largest value that make sense.
    pub range: (f64, f64),
    /// How it is drawn.
    pub drawn: Drawn,
}

impl Parameter {
    /// One that must be given.
    pub(super) const fn needed(
        name: &'static str,
        unit: &'static str,
        range: (f64, f64),
        drawn: Drawn,
    ) -> Self {
        Self { name, unit, default: None, range, drawn }
    }

    /// The strength of an effect of either sign, up to `most`.
    pub(super) const fn strength(name: &'static str, unit: &'static str, most: f64) -> Self {
        Self::needed(name, unit, (-most, most), Drawn::Strength)
    }

    /// The same with a value where it is not given.
    pub(super) const fn or(self, default: f64) -> Self {
        Self { default: Some(default), ..self }
    }

    /// Whether the effect is proportional to it.
    pub fn is_strength(&self) -> bool {
        matches!(self.drawn, Drawn::Strength | Drawn::PositiveStrength)
    }
}

/// A mechanism, or what is wrong with the values that it was to be made from.
pub type Made = Result<Box<dyn Mechanism>, String>;

/// Makes the mechanism of an effect for a device from its values.
pub type Build = fn(&Values, &Device) -> Made;

/// What is known of an effect.
pub struct Specification {
    /// Its id; outside the table of effects it begins with `ooc_`.
    pub id: &'static str,
    /// What it is, in words.
    pub title: &'static str,
    /// Whether a second recording of the device shows it again.
    pub scope: Scope,
    /// The variables of which any may rightly be named as the place where it shows.
    pub depends_on: &'static [&'static str],
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// How its mechanism is made.
    pub build: Build,
}

impl Specification {
    /// Whether it stands in the table of effects.
    pub fn catalogued(&self) -> bool {
        !self.id.starts_with("ooc_")
    }

    /// The parameter that the effect is proportional to.
    pub fn strength(&self) -> Option<&'static Parameter> {
        self.parameters.iter().find(|p| p.is_strength())
    }
}
