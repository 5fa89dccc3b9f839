//! Outside the table: hum of the mains on the drive, w = u + A·sin(2πft + φ).

use super::specification::{ANY, uniform};
use super::{Action, DriveElement, Parameter, Specification};
use crate::signal::Flow;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_mains_hum",
    title: "hum of the mains on the drive",
    depends_on: &["t_s", "frequency_hz"],
    parameters: &[
        Parameter { name: "amplitude", unit: "drive unit", default: None, range: ANY },
        Parameter {
            name: "frequency_hz",
            unit: "Hz",
            default: Some(50.0),
            range: (f64::MIN_POSITIVE, f64::INFINITY),
        },
        Parameter { name: "phase_rad", unit: "rad", default: Some(0.0), range: ANY },
    ],
    build: |values, _| {
        Ok(Action::Drive(Box::new(Hum {
            amplitude: values["amplitude"],
            omega: std::f64::consts::TAU * values["frequency_hz"],
            phase_rad: values["phase_rad"],
        })))
    },
    draw: |strength, typical, generator| {
        // The mains are never exactly at their frequency, and never at one of the excitation's.
        vec![
            ("amplitude", std::f64::consts::SQRT_2 * strength * typical.drive),
            ("frequency_hz", uniform(generator, 49.9, 50.1)),
            ("phase_rad", uniform(generator, 0.0, std::f64::consts::TAU)),
        ]
    },
};

#[derive(Debug)]
struct Hum {
    amplitude: f64,
    omega: f64,
    phase_rad: f64,
}

impl DriveElement for Hum {
    fn pass(&self, t_s: f64, drive: Flow, _: &[f64], _: &mut [f64]) -> Flow {
        let (sin, cos) = (self.omega * t_s + self.phase_rad).sin_cos();
        Flow {
            value: drive.value + self.amplitude * sin,
            rate: drive.rate + self.amplitude * self.omega * cos,
        }
    }
}
