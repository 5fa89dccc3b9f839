//! What stands on the way of the drive or of the read-out: delays, lags, offsets, limits.

use std::f64::consts::{SQRT_2, TAU};

use super::specification::{ANY, NOT_NEGATIVE, POSITIVE, sign, uniform};
use super::{Action, Element, Parameter, Specification};
use crate::signal::Flow;

/// The drive takes effect later: w(t) = u(t − T), of a bus or a sampled controller.
pub const TRANSPORT_DELAY: Specification = Specification {
    id: "transport_delay",
    title: "a delay of the drive",
    depends_on: &["frequency_hz", "acceleration", "velocity", "history"],
    parameters: &[Parameter::needed("delay_s", "s", NOT_NEGATIVE)],
    build: |values, _| Action::Drive(Box::new(Late { delay_s: values["delay_s"] })),
    draw: |strength, typical, _| vec![("delay_s", strength / typical.corner_rad_per_s())],
};

struct Late {
    delay_s: f64,
}

impl Element for Late {
    fn delay_s(&self) -> f64 {
        self.delay_s
    }
}

/// The inductance of the coils: τ w′ = u − w.
pub const DRIVE_LAG: Specification = Specification {
    id: "drive_lag",
    title: "a drive that follows with a time constant",
    depends_on: &["frequency_hz", "acceleration", "velocity", "history"],
    parameters: &[Parameter::needed("time_constant_s", "s", POSITIVE)],
    build: |values, _| Action::Drive(Box::new(Lag { time_constant_s: values["time_constant_s"] })),
    draw: |strength, typical, _| vec![("time_constant_s", strength / typical.corner_rad_per_s())],
};

/// The filter of the sensor: τ y′ = x − y.
pub const SENSOR_LAG: Specification = Specification {
    id: "sensor_lag",
    title: "a read-out that follows with a time constant",
    build: |values, _| Action::ReadOut(Box::new(Lag { time_constant_s: values["time_constant_s"] })),
    ..DRIVE_LAG
};

struct Lag {
    time_constant_s: f64,
}

impl Element for Lag {
    fn states(&self) -> usize {
        1
    }

    fn pass(&self, _: f64, input: Flow, own: &[f64], rates: &mut [f64]) -> Flow {
        rates[0] = (input.value - own[0]) / self.time_constant_s;
        Flow { value: own[0], rate: rates[0] }
    }
}

/// The amplifier adds a constant: w = u + o. Under feedback the drive is what is predicted and the constant
/// is part of it: w = u − o.
pub const DRIVE_OFFSET: Specification = Specification {
    id: "drive_offset",
    title: "a constant part of the drive",
    depends_on: &["position", "drive", "t_s"],
    parameters: &[Parameter::needed("offset", "drive unit", ANY)],
    build: |values, context| {
        let added = if context.feedback { -1.0 } else { 1.0 } * values["offset"];
        Action::drive(move |_, drive| Flow { value: drive.value + added, rate: drive.rate })
    },
    draw: |strength, typical, generator| vec![("offset", sign(generator) * strength * typical.drive)],
};

/// The zero of the sensor: y = x + o.
pub const SENSOR_OFFSET: Specification = Specification {
    id: "sensor_offset",
    title: "a constant part of the read-out",
    depends_on: &["position", "drive", "t_s"],
    parameters: &[Parameter::needed("offset", "position unit", ANY)],
    build: |values, _| {
        let offset = values["offset"];
        Action::read_out(move |_, position| Flow { value: position.value + offset, rate: position.rate })
    },
    draw: |strength, typical, generator| vec![("offset", sign(generator) * strength * typical.position)],
};

/// The amplifier gives no more than its limit: w = u within ±limit.
pub const DRIVE_SATURATION: Specification = Specification {
    id: "drive_saturation",
    title: "an amplifier at its limit",
    depends_on: &["drive", "amplitude"],
    parameters: &[Parameter::needed("limit", "drive unit", POSITIVE)],
    build: |values, _| {
        let limit = values["limit"];
        Action::drive(move |_, drive| {
            let value = drive.value.clamp(-limit, limit);
            Flow { value, rate: if value == drive.value { drive.rate } else { 0.0 } }
        })
    },
    draw: |strength, typical, _| vec![("limit", typical.largest_drive * (1.0 - strength).max(0.1))],
};

/// Outside the table: the output stage of the amplifier has a gap around zero: w = 0 within ±z, u ∓ z beyond.
pub const DEAD_ZONE: Specification = Specification {
    id: "ooc_dead_zone",
    title: "an amplifier that is dead around zero",
    depends_on: &["drive", "amplitude"],
    parameters: &[Parameter::needed("half_width", "drive unit", NOT_NEGATIVE)],
    build: |values, _| {
        let half_width = values["half_width"];
        Action::drive(move |_, drive| {
            let value = drive.value - drive.value.clamp(-half_width, half_width);
            Flow { value, rate: if value == 0.0 { 0.0 } else { drive.rate } }
        })
    },
    draw: |strength, typical, _| vec![("half_width", strength * typical.drive)],
};

/// Outside the table: hum of the mains on the drive, w = u + A·sin(2πft + φ).
pub const MAINS_HUM: Specification = Specification {
    id: "ooc_mains_hum",
    title: "hum of the mains on the drive",
    depends_on: &["t_s", "frequency_hz"],
    parameters: &[
        Parameter::needed("amplitude", "drive unit", ANY),
        Parameter::usual("frequency_hz", "Hz", 50.0, POSITIVE),
        Parameter::usual("phase_rad", "rad", 0.0, ANY),
    ],
    build: |values, _| {
        let (amplitude, phase_rad) = (values["amplitude"], values["phase_rad"]);
        let omega = TAU * values["frequency_hz"];
        Action::drive(move |t_s, drive| {
            let (sin, cos) = (omega * t_s + phase_rad).sin_cos();
            Flow { value: drive.value + amplitude * sin, rate: drive.rate + amplitude * omega * cos }
        })
    },
    draw: |strength, typical, generator| {
        // The mains are never exactly at their frequency, and never at one of the excitation's.
        vec![
            ("amplitude", SQRT_2 * strength * typical.drive),
            ("frequency_hz", uniform(generator, 49.9, 50.1)),
            ("phase_rad", uniform(generator, 0.0, TAU)),
        ]
    },
};
