//! The filter of the sensor: τ y′ = x − y.

use super::{Action, Parameter, ReadOut, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "sensor_lag",
    title: "a read-out that follows with a time constant",
    depends_on: &["frequency_hz", "acceleration", "velocity", "history"],
    parameters: &[Parameter {
        name: "time_constant_s",
        unit: "s",
        default: None,
        range: (f64::MIN_POSITIVE, f64::INFINITY),
    }],
    build: |values, _| Ok(Action::ReadOut(Box::new(Filter { time_constant_s: values["time_constant_s"] }))),
    draw: |strength, typical, _| vec![("time_constant_s", strength / typical.corner_rad_per_s())],
};

#[derive(Debug)]
struct Filter {
    time_constant_s: f64,
}

impl ReadOut for Filter {
    fn states(&self) -> usize {
        1
    }

    fn read(&self, position: f64, own: &[f64], rates: &mut [f64]) -> f64 {
        rates[0] = (position - own[0]) / self.time_constant_s;
        own[0]
    }
}
