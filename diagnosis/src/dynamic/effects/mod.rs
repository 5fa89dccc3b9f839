//! The catalogue of dynamic effects: a declaration each, one line in [`CATALOGUE`]. An effect acts on the drive on its
//! way to the mechanism, on the mechanism's acceleration, or on the position on its way to the recording; its formula
//! is written once ([`Law`]) and evaluated with and without derivatives.

mod bouc_wen_hysteresis;
mod flexible_mode;
mod force;
mod friction;
mod law;
mod path;

use physics::number::Number;
use pulp::{Arch, Simd, WithSimd};

use crate::thresholds::dynamic::effects::MOST_STATES;
pub use law::Law;

/// What a force sees of the mechanism, and what it changes.
pub struct Flow<'a, T> {
    /// The drive that reaches the mechanism.
    pub drive: &'a T,
    /// Position.
    pub position: &'a T,
    /// Velocity.
    pub velocity: &'a T,
    /// Gain of the nominal plant.
    pub gain: &'a T,
    /// Direction of motion as dry friction sees it: −1, 0 (stuck) or 1; held over a step of the integrator,
    /// which ends where the velocity changes its sign.
    pub direction: f64,
    /// Time since the start of the run, s.
    pub time: f64,
    /// Acceleration, to which the effect adds.
    pub acceleration: &'a mut T,
    /// The effect's own states.
    pub states: &'a [T],
    /// Their rates of change, to be set.
    pub rates: &'a mut [T],
}

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Delays the drive by its parameter.
    Delay,
    /// Changes the drive, without memory: its parameter is an offset or a limit.
    Drive,
    /// Lets the drive lag by its parameter.
    DriveLag,
    /// Adds to the drive its parameter times what Rayleigh's material remembers of it
    /// (`turns`).
    DriveMemory,
    /// Adds to the acceleration ([`Law::force`]).
    Force,
    /// Lets the read-out lag by its parameter.
    SensorLag,
    /// Adds its parameter to the read-out.
    SensorOffset,
}

/// A parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Its name in `plant.toml`.
    pub name: &'static str,
    /// Its unit; `p` stands for the position's unit and `u` for the drive's.
    pub unit: &'static str,
    /// Whether it shapes the effect (a period, a velocity) rather than multiplying it. A shape is positive and is sought on a
    /// logarithmic scale, unless it is a place.
    pub shape: bool,
    /// Whether it is a shape that is a place along the stroke, of either sign, and sought by parts of the width that follows it.
    pub place: bool,
    /// What it is where `plant.toml` does not give it; none where it has to.
    pub usual: Option<f64>,
}

impl Parameter {
    const fn usually(self, value: f64) -> Parameter {
        Parameter { usual: Some(value), ..self }
    }
}

/// Values by name.
pub type Given<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// Size of what a recording holds, from which start values follow.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Mean position.
    pub middle: f64,
    /// Largest distance of the position from its middle.
    pub stroke: f64,
    /// Root mean square of the velocity.
    pub speed: f64,
    /// Largest magnitude of the drive.
    pub drive: f64,
    /// Time from one row to the next, s.
    pub step_s: f64,
    /// Angular frequency at which the position moves most, rad/s.
    pub rate: f64,
    /// Lowest frequency of which several periods are in one run, Hz.
    pub slowest_hz: f64,
}

/// A physical effect beyond the nominal plant.
pub struct DynamicEffect {
    /// Identifier in the diagnosis and in `plant.toml`.
    pub id: &'static str,
    /// Name for a reader.
    pub title: &'static str,
    /// What it adds, for a reader: x is the position, v the velocity, u the drive, w the drive as it reaches the mechanism,
    /// y the reading; the parameters in their order.
    pub formula: &'static str,
    /// Ids of the effects that it is most easily taken for.
    pub confused_with: &'static [&'static str],
    /// The observable that it depends on, as in `locations`.
    pub variable: &'static str,
    /// Where it acts.
    pub part: Part,
    /// Its formula.
    pub law: Law,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// The first parameter that no search fits: it and those after it keep the value they were given.
    pub kept: usize,
    /// Whether the first kept parameter is the speed with which it creeps while it holds: v = c artanh(force/F), as
    /// asperities do, and as a simulation does that rounds the sign of the velocity off. Fixed at next to nothing unless
    /// the recording shows it, and no parameter of `plant.toml`. All its amounts together hold the mechanism.
    pub creeps: bool,
    /// Number of states of its own.
    pub states: usize,
    /// Its states at rest at a position.
    pub rest: fn(f64) -> [f64; MOST_STATES],
    /// Time after which its states do not depend any more on where they began, s; infinite where that is not known.
    pub memory_s: fn(&[f64]) -> f64,
    /// The fastest angular frequency that it brings into the equation of motion, rad/s.
    pub fastest: fn(&[f64]) -> f64,
    /// Whether its force changes within so short a way that a row needs two steps of the integrator.
    pub abrupt: bool,
    /// Whether its force goes with the gain of the plant.
    pub by_gain: bool,
    /// Parameters from which a search starts. What multiplies the effect is zero where its linearised signature is to
    /// say how large it is.
    pub starts: fn(&Scale) -> Vec<Vec<f64>>,
    /// Further ones, which a search along a recorded motion also tries.
    pub starts_along: fn(&Scale) -> Vec<Vec<f64>>,
    /// Parameters from which a search starts in the place of an effect, given by its id and parameters, that is a special case
    /// of this one or, to the recording, nearly the same.
    pub starts_from: fn(&str, &[f64], &Scale) -> Vec<Vec<f64>>,
    /// The effect that it is where only its first amount is not zero.
    pub special_case: Option<&'static DynamicEffect>,
    /// Whether these parameters can be this effect.
    pub plausible: fn(&[f64], &Scale) -> bool,
    /// The parameters as they are reported and written, each with its gradient.
    pub readings: fn(&DynamicEffect, &[f64]) -> Vec<Reading>,
    /// The reverse of `readings`: parameters from values by name; none where one is missing that has no usual value.
    pub parameters_from: fn(&DynamicEffect, Given) -> Option<Vec<f64>>,
    /// What to record to tell it from its alternatives.
    pub experiment: &'static str,
}

impl DynamicEffect {
    /// What holds of an effect with one amount unless it says otherwise.
    pub const USUAL: DynamicEffect = DynamicEffect {
        id: "",
        title: "",
        formula: "",
        confused_with: &[],
        variable: "",
        part: Part::Force,
        law: Law::None,
        parameters: &[],
        kept: usize::MAX,
        creeps: false,
        states: 0,
        rest: |_| [0.0; MOST_STATES],
        memory_s: |_| f64::INFINITY,
        fastest: |_| 0.0,
        abrupt: false,
        by_gain: false,
        starts: |_| vec![vec![0.0]],
        starts_along: |_| Vec::new(),
        starts_from: |_, _, _| Vec::new(),
        special_case: None,
        plausible: |_, _| true,
        readings: |effect, parameters| {
            let count = effect.creep().unwrap_or(parameters.len());
            plain_readings(effect.parameters, parameters, count)
        },
        parameters_from: |effect, value| {
            effect.parameters.iter().map(|p| value(p.name).or(p.usual)).collect()
        },
        experiment: "repeat the excitation at a third and at three times the amplitude",
    };

    /// The parameters as they are reported and written, each with its gradient.
    pub fn readings(&self, parameters: &[f64]) -> Vec<Reading> {
        (self.readings)(self, parameters)
    }

    /// The names that its parameters have in `plant.toml`.
    pub fn names(&self) -> Vec<&'static str> {
        self.readings(&vec![1.0; self.parameters.len()]).iter().map(|r| r.name).collect()
    }

    /// [`Law::force`] in the widest registers that the processor has.
    pub fn force_widely<T: Number>(&self, parameters: &[T], flow: &mut Flow<T>) {
        Arch::new().dispatch(Widely { law: &self.law, parameters, flow });
    }

    /// Which parameter is the speed of creep.
    pub fn creep(&self) -> Option<usize> {
        self.creeps.then_some(self.kept)
    }

    /// Whether it shifts the recording in time.
    pub fn is_late(&self) -> bool {
        matches!(self.part, Part::Delay | Part::DriveLag | Part::SensorLag)
    }

    /// Whether it limits the drive: it changes it, and has no amount.
    pub fn is_limit(&self) -> bool {
        self.part == Part::Drive && self.parameters.iter().all(|p| p.shape)
    }
}

/// A force, to be worked out in the widest registers that the processor has.
struct Widely<'a, 'f, T> {
    law: &'a Law,
    parameters: &'a [T],
    flow: &'a mut Flow<'f, T>,
}

impl<T: Number> WithSimd for Widely<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.law.force(self.parameters, self.flow);
    }
}

const MEAN_POSITIONS: &str =
    "record the same excitation about two other mean positions, and the read-out with the drive off";
const FASTER: &str =
    "excite up to the highest frequency that the drive reaches, sampled several times faster";
const SLOW_TRIANGLES: &str = "record slow triangles of several small amplitudes, with reversals at rest";

/// A parameter as it is reported.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Its name.
    pub name: &'static str,
    /// Its unit, as in [`Parameter::unit`].
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Derivatives along the effect's own parameters.
    pub gradient: Vec<f64>,
}

/// The first `count` parameters as they are.
fn plain_readings(known: &[Parameter], parameters: &[f64], count: usize) -> Vec<Reading> {
    let one = |k: usize| {
        let mut gradient = vec![0.0; parameters.len()];
        gradient[k] = 1.0;
        Reading { name: known[k].name, unit: known[k].unit, value: parameters[k], gradient }
    };
    (0..count).map(one).collect()
}

/// The speed of creep of a dry friction that holds.
const CREEP: Parameter = shape("creep_velocity", "p/s").usually(f64::MIN_POSITIVE);

/// All effects, in the order in which ties are broken: the simpler explanation first.
pub static CATALOGUE: [&DynamicEffect; 17] = [
    &path::DRIVE_OFFSET,
    &path::SENSOR_OFFSET,
    &force::CUBIC_STIFFNESS,
    &force::QUADRATIC_STIFFNESS,
    &friction::COULOMB,
    &force::QUADRATIC_DAMPING,
    &force::NONLINEAR_DAMPING,
    &force::TORQUE_CONSTANT_DROOP,
    &path::TRANSPORT_DELAY,
    &path::DRIVE_LAG,
    &path::SENSOR_LAG,
    &path::DRIVE_SATURATION,
    &path::RAYLEIGH_HYSTERESIS,
    &force::COGGING,
    &friction::STRIBECK,
    &bouc_wen_hysteresis::BOUC_WEN_HYSTERESIS,
    &flexible_mode::FLEXIBLE_MODE,
];

/// Effects that are seen along a recorded motion alone. In a free run what lies beyond a play is a mechanism of its own, and a
/// place is met too rarely.
pub static ALONG_A_MOTION: [&DynamicEffect; 2] = [&friction::LOCAL, &friction::BACKLASH];

/// All effects that a search under feedback tries, in the order of the catalogue.
pub fn under_feedback() -> impl Iterator<Item = &'static DynamicEffect> {
    CATALOGUE.into_iter().chain(ALONG_A_MOTION)
}

/// Ids of effects that a search treats apart.
pub const COULOMB_FRICTION: &str = "coulomb_friction";
#[allow(missing_docs)]
pub const CUBIC_STIFFNESS: &str = "cubic_stiffness";
#[allow(missing_docs)]
pub const DRIVE_LAG: &str = "drive_lag";
#[allow(missing_docs)]
pub const DRIVE_OFFSET: &str = "drive_offset";
#[allow(missing_docs)]
pub const RAYLEIGH_HYSTERESIS: &str = "rayleigh_hysteresis";
#[allow(missing_docs)]
pub const SENSOR_OFFSET: &str = "sensor_offset";
#[allow(missing_docs)]
pub const TRANSPORT_DELAY: &str = "transport_delay";

/// The effect with an id.
pub fn effect(id: &str) -> Option<&'static DynamicEffect> {
    under_feedback().find(|e| e.id == id)
}

/// The unit with the position's and the drive's put in.
pub fn unit_of(pattern: &str, position: &str, drive: &str) -> String {
    pattern
        .chars()
        .map(|c| match c {
            'p' => position.to_string(),
            'u' => drive.to_string(),
            other => other.to_string(),
        })
        .collect()
}

/// A parameter that multiplies its effect.
pub(super) const fn amount(name: &'static str, unit: &'static str) -> Parameter {
    Parameter { name, unit, shape: false, place: false, usual: None }
}

/// A parameter that shapes its effect.
pub(super) const fn shape(name: &'static str, unit: &'static str) -> Parameter {
    Parameter { name, unit, shape: true, place: false, usual: None }
}

/// A place along the stroke.
const fn place(name: &'static str, unit: &'static str) -> Parameter {
    Parameter { place: true, ..shape(name, unit) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_confusion_names_an_effect_of_the_catalogue() {
        for e in under_feedback() {
            for other in e.confused_with {
                assert!(effect(other).is_some(), "{}: {other}", e.id);
                assert_ne!(*other, e.id);
            }
        }
    }

    #[test]
    fn starts_have_all_parameters_and_readings_read_back() {
        let scale = Scale {
            middle: 300.0,
            stroke: 5000.0,
            speed: 2e5,
            drive: 0.3,
            step_s: 5e-4,
            rate: 200.0,
            slowest_hz: 1.0,
        };
        for e in under_feedback() {
            for start in [(e.starts)(&scale), (e.starts_along)(&scale)].concat() {
                assert_eq!(start.len(), e.parameters.len(), "{}", e.id);
                for (value, p) in start.iter().zip(e.parameters) {
                    assert!(!p.shape || p.place || *value > 0.0, "{} {}", e.id, p.name);
                }
                let some: Vec<f64> = start.iter().map(|v| if *v == 0.0 { 0.7 } else { *v }).collect();
                let readings = e.readings(&some);
                let known = |name: &str| readings.iter().find(|r| r.name == name).map(|r| r.value);
                let back = (e.parameters_from)(e, &known).unwrap();
                for (a, b) in e.readings(&back).iter().zip(&readings) {
                    assert!((a.value - b.value).abs() < 1e-9 * b.value.abs(), "{}: {back:?} {some:?}", e.id);
                }
            }
        }
    }
}
