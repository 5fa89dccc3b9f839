//! A sensor that reports a position, on its calibration bench: capacitive, inductive or optical, with a smooth
//! characteristic of its own and with physics that stands in no table of effects.
//!
//! The bench runs in steps of half a second. Surroundings change and mechanisms move on in every step, whether or not
//! a reading is taken at its end, so that what they remember is what happened between the readings too. Everything
//! here belongs to the device: a fresh recording shows it again. To add a kind: its declaration in the file of what
//! it depends on.

mod bench;
mod environment;
mod path;
mod surroundings;
mod temperature;

pub use bench::{Bench, Row, Schedule};
pub use surroundings::{COLUMNS, Column, Surroundings, TEMPERATURE};

/// Where the sensor stands at the end of a step of the bench.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Length of the step in seconds.
    pub step_s: f64,
    /// True position in millimetres, from −1 to 1.
    pub x_mm: f64,
    /// What the sensor would report without the physics in question, in millimetres.
    pub raw_mm: f64,
    /// The surroundings.
    pub around: Surroundings,
}

/// What a mechanism adds to the reading at unit strength. It is asked in every step, in the order of time.
pub type Physics = Box<dyn FnMut(&Moment) -> f64 + Send>;

/// Draws a number evenly between two.
pub type Uniform<'a> = &'a mut dyn FnMut(f64, f64) -> f64;

/// A kind of physics.
pub struct Kind {
    /// Its id, which begins with `ooc_`: it stands in no table of effects.
    pub id: &'static str,
    /// What it is.
    pub title: &'static str,
    /// The recorded columns that carry it, position, time and direction apart.
    pub columns: &'static [Column],
    /// The variables of which any may rightly be named as the place where it shows.
    pub depends_on: &'static [&'static str],
    /// Draws the numbers that shape it; times in parts of the duration, which is given in seconds.
    pub shape: fn(Uniform, f64) -> Vec<f64>,
    /// Makes the mechanism from them.
    pub build: fn(&[f64]) -> Physics,
}

/// All kinds.
pub const ALL: [&[Kind]; 3] = [environment::KINDS, temperature::KINDS, path::KINDS];

/// The kind with this id.
pub fn find(id: &str) -> Option<&'static Kind> {
    ALL.into_iter().flatten().find(|kind| kind.id == id)
}

/// A first-order body of a time constant: follows what it is given, exactly where that is held over a step.
#[derive(Default)]
struct Lag(Option<f64>);

impl Lag {
    /// Its state after a step; it begins in equilibrium.
    fn follow(&mut self, input: f64, step_s: f64, time_constant_s: f64) -> f64 {
        let before = self.0.unwrap_or(input);
        let now = input + (before - input) * (-step_s / time_constant_s).exp();
        self.0 = Some(now);
        now
    }
}

#[cfg(test)]
mod tests;
