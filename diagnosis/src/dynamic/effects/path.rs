//! What acts on the way of the drive or of the reading without a formula of its own: the simulation does what
//! [`Part`] says with its one parameter.

use super::{DynamicEffect, FASTER, Facts, MEAN_POSITIONS, Part, Physics, Scale, amount, shape};
use crate::numerics::Number;

/// Such an effect.
pub struct Path {
    facts: Facts,
    /// Where a search starts, in steps from row to row; at zero where there is none.
    starts: &'static [f64],
    /// Whether its parameter is positive.
    positive: bool,
}

/// Offset of the read-out: an offset of the sensor.
///
/// y = x + o; o in p
///
/// Source: Fraden, Handbook of Modern Sensors (2016).
pub static SENSOR_OFFSET: Path = Path {
    facts: Facts {
        id: super::SENSOR_OFFSET,
        title: "Offset of the read-out",
        variable: "position",
        confused_with: &["drive_offset", "quadratic_stiffness"],
        part: Part::SensorOffset,
        parameters: &[amount("offset", "p")],
        experiment: MEAN_POSITIONS,
        ..Facts::USUAL
    },
    starts: &[],
    positive: false,
};

/// Hysteresis after Rayleigh: domains of a piezo, or of iron at low fields, switch at thresholds of equal density, so that gain and loss grow with the amplitude of the drive.
///
/// w = u + c R(u), R = R_r + ½(u − u_r)|u − u_r| from every reversal, u|u| from rest; c in 1/u
///
/// Source: Lord Rayleigh, Phil. Mag. 23 (1887) 225; Damjanovic, J. Appl. Phys. 82 (1997) 1788 (piezo).
pub static RAYLEIGH_HYSTERESIS: Path = Path {
    facts: Facts {
        id: super::RAYLEIGH_HYSTERESIS,
        title: "Hysteresis of the actuator (Rayleigh)",
        variable: "history",
        confused_with: &["drive_saturation", "bouc_wen_hysteresis", "coulomb_friction"],
        part: Part::DriveMemory,
        parameters: &[amount("coefficient", "1/u")],
        ..Facts::USUAL
    },
    starts: &[],
    positive: false,
};

/// Transport delay of the drive: a pure delay between the recorded drive and the force: a bus, a sampled controller.
///
/// w(t) = u(t − T); T in s
///
/// Source: Åström & Wittenmark, Computer-Controlled Systems (1997), section 2.3.
pub static TRANSPORT_DELAY: Path = Path {
    facts: Facts {
        id: super::TRANSPORT_DELAY,
        title: "Transport delay of the drive",
        variable: "frequency_hz",
        confused_with: &["drive_lag", "sensor_lag"],
        part: Part::Delay,
        parameters: &[amount("delay_s", "s")],
        experiment: FASTER,
        ..Facts::USUAL
    },
    starts: &[],
    positive: true,
};

/// Lag of the drive: an amplifier or a coil of finite bandwidth: first-order lag of the force.
///
/// τ w′ = u − w; τ in s
///
/// Source: Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998).
pub static DRIVE_LAG: Path = Path {
    facts: Facts {
        id: super::DRIVE_LAG,
        title: "Lag of the drive",
        variable: "frequency_hz",
        confused_with: &["transport_delay", "sensor_lag"],
        part: Part::DriveLag,
        parameters: &[shape("time_constant_s", "s")],
        experiment: FASTER,
        ..Facts::USUAL
    },
    starts: &[0.2, 1.0, 4.0],
    positive: true,
};

/// Lag of the read-out: a sensor or filter of finite bandwidth: first-order lag of the reading.
///
/// τ y′ = x − y; τ in s
///
/// Source: Fraden, Handbook of Modern Sensors (2016).
pub static SENSOR_LAG: Path = Path {
    facts: Facts {
        id: "sensor_lag",
        title: "Lag of the read-out",
        variable: "frequency_hz",
        confused_with: &["drive_lag", "transport_delay"],
        part: Part::SensorLag,
        parameters: &[shape("time_constant_s", "s")],
        experiment: FASTER,
        ..Facts::USUAL
    },
    starts: &[0.2, 1.0, 4.0],
    positive: true,
};

impl<T: Number> Physics<T> for Path {}

impl DynamicEffect for Path {
    fn facts(&self) -> &Facts {
        &self.facts
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        match self.starts {
            [] => vec![vec![0.0]],
            steps => steps.iter().map(|step| vec![step * scale.step_s]).collect(),
        }
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        !self.positive || parameters[0] > 0.0
    }
}
