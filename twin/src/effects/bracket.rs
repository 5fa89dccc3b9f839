//! What turns the probes against the frame, or bends the pads: they see a rotation that the frame did not make.

use std::f64::consts::TAU;

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification, seen};
use crate::environment::LABORATORY_C;
use crate::units::{arcsec_from_rad, rad_from_arcsec};

/// k (T − T̄): the bracket that carries both probes turns with its temperature against the mount.
pub(super) const THERMAL_ZERO_DRIFT: Specification = Specification {
    id: "thermal_zero_drift",
    title: "the zero drifts with the temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
    parameters: &[Parameter::strength("coefficient_arcsec_per_k", "arcsec/K", 100.0)],
    build: |values, _| {
        let arcsec_per_k = values["coefficient_arcsec_per_k"];
        seen(move |pose| rad_from_arcsec(arcsec_per_k * (pose.temperature_c - LABORATORY_C)))
    },
};

/// k (T_L − T̄) with τ dT_L/dt = T − T_L: the bracket turns with a temperature of its own, which follows that of the
/// base plate. Before the first reading it has followed it for long.
pub(super) const THERMAL_LAG: Specification = Specification {
    id: "thermal_lag",
    title: "the zero follows the temperature with a delay",
    scope: Scope::Device,
    depends_on: &["temperature_c", "history", "t_s"],
    parameters: &[
        Parameter::strength("coefficient_arcsec_per_k", "arcsec/K", 100.0),
        Parameter::needed("time_constant_s", "s", (1.0, 1e5), Drawn::OfDuration(0.05, 0.2)),
    ],
    build: |values, _| {
        Ok(Box::new(Bracket {
            arcsec_per_k: values["coefficient_arcsec_per_k"],
            time_constant_s: values["time_constant_s"],
            last: None,
        }))
    },
};

#[derive(Clone)]
struct Bracket {
    arcsec_per_k: f64,
    time_constant_s: f64,
    last: Option<Last>,
}

/// Time, temperature of the base plate and of the bracket at the last reading.
#[derive(Clone, Copy)]
struct Last {
    t_s: f64,
    base_c: f64,
    bracket_c: f64,
}

impl Mechanism for Bracket {
    fn advance(&mut self, pose: &Pose) {
        let base_c = pose.temperature_c;
        let bracket_c = match self.last {
            None => base_c,
            Some(last) => {
                // Exact for a temperature that runs straight from reading to reading.
                let step_s = pose.t_s - last.t_s;
                let behind = if step_s > 0.0 { (base_c - last.base_c) / step_s } else { 0.0 };
                let behind = behind * self.time_constant_s;
                let kept = (-step_s / self.time_constant_s).exp();
                base_c - behind + (last.bracket_c - last.base_c + behind) * kept
            }
        };
        self.last = Some(Last { t_s: pose.t_s, base_c, bracket_c });
    }

    fn seen_rotation_rad(&self, _pose: &Pose) -> f64 {
        let bracket_c = self.last.map_or(LABORATORY_C, |last| last.bracket_c);
        rad_from_arcsec(self.arcsec_per_k * (bracket_c - LABORATORY_C))
    }
}

/// χ · cross: the probes do not sit at the same height, so that a rotation about the second axis moves the two pads
/// differently along X. χ is the difference in height relative to d.
pub(super) const CROSS_AXIS_COUPLING: Specification = Specification {
    id: "cross_axis_coupling",
    title: "the second axis couples into the angle",
    scope: Scope::Device,
    depends_on: &["cross_arcsec"],
    parameters: &[Parameter::strength("coefficient_arcsec_per_arcsec", "1", 20.0)],
    build: |values, _| {
        let relative = values["coefficient_arcsec_per_arcsec"];
        seen(move |pose| relative * rad_from_arcsec(pose.cross_arcsec))
    },
};

/// A sin(2πΘ/p + φ) of the true angle: the pads carry a grain of the period p. Against the calculated angle it is
/// implicit, since that carries the error itself. Further harmonics fall off threefold each.
pub(super) const PERIODIC_ERROR: Specification = Specification {
    id: "periodic_error",
    title: "a periodic error of the true angle",
    scope: Scope::Device,
    depends_on: &["angle_deg"],
    parameters: &[
        Parameter::needed("amplitude_arcsec", "arcsec", (-1e3, 1e3), Drawn::PositiveStrength),
        Parameter::needed("period_arcsec", "arcsec", (1.0, 1e5), Drawn::PeriodFromSteps(2.6, 0.2)),
        Parameter::needed("phase_deg", "deg", (-360.0, 360.0), Drawn::Uniform(0.0, 360.0)).or(0.0),
        Parameter::needed("harmonics", "1", (1.0, 8.0), Drawn::Whole(1, 1)).or(1.0),
    ],
    build: |values, _| {
        let (amplitude, period) = (values["amplitude_arcsec"], values["period_arcsec"]);
        let (phase, harmonics) = (values["phase_deg"].to_radians(), values["harmonics"]);
        if harmonics.fract() != 0.0 {
            return Err(format!("`harmonics` is {harmonics}, expected a whole number"));
        }
        // Every harmonic's slope is at most 2πA/p, the falling amplitude making up for the frequency.
        if TAU * amplitude.abs() * harmonics / period > 0.5 {
            return Err(format!(
                "an amplitude of {amplitude} arcsec in a period of {period} arcsec could turn the reading back"
            ));
        }
        let amplitude_rad = rad_from_arcsec(amplitude);
        seen(move |pose| {
            let turn = TAU * arcsec_from_rad(pose.mirror_rad) / period + phase;
            (1..=harmonics as u32)
                .map(f64::from)
                // The phases of a ramp would make a saw-tooth; a radian apart they make no special shape.
                .map(|n| amplitude_rad / 3f64.powf(n - 1.0) * (n * turn + (n - 1.0)).sin())
                .sum()
        })
    },
};

/// Outside the table: A · H with τ dH/dt = (i / 0.1 A)² − H. The coils heat up with the square of their current and
/// bend the frame. Cold at the start.
pub(super) const COIL_HEATING: Specification = Specification {
    id: "ooc_coil_heating",
    title: "the coils heat up with the square of their current",
    scope: Scope::Device,
    depends_on: &["history", "coil_a", "t_s", "pass", "angle_deg", "direction"],
    parameters: &[
        Parameter::strength("amplitude_arcsec", "arcsec", 1e3),
        Parameter::needed("time_constant_s", "s", (1.0, 1e5), Drawn::OfDuration(0.03, 0.15)),
    ],
    build: |values, _| {
        Ok(Box::new(Coils {
            amplitude_rad: rad_from_arcsec(values["amplitude_arcsec"]),
            time_constant_s: values["time_constant_s"],
            heat: 0.0,
            t_s: 0.0,
        }))
    },
};

/// The current to which the heating refers, about that at the end of the stroke.
const CURRENT_A: f64 = 0.1;

#[derive(Clone)]
struct Coils {
    amplitude_rad: f64,
    time_constant_s: f64,
    heat: f64,
    t_s: f64,
}

impl Mechanism for Coils {
    fn advance(&mut self, pose: &Pose) {
        // The pose still holds the current of the position that the mirror was held in.
        let kept = (-(pose.t_s - self.t_s) / self.time_constant_s).exp();
        self.heat = kept * self.heat + (1.0 - kept) * (pose.coil_a / CURRENT_A).powi(2);
        self.t_s = pose.t_s;
    }

    fn seen_rotation_rad(&self, _pose: &Pose) -> f64 {
        self.amplitude_rad * self.heat
    }
}

/// Outside the table: a plate pushed either way along X strains its suspension, and the strain turns the pads against
/// the frame.
pub(super) const COMMON_MODE_SQUARE: Specification = Specification {
    id: "ooc_common_mode_square",
    title: "the square of the common motion of the plate",
    scope: Scope::Device,
    depends_on: &["common_mode_um"],
    parameters: &[Parameter::strength("coefficient_arcsec_per_um2", "arcsec/µm²", 200.0)],
    build: |values, _| {
        let arcsec_per_um2 = values["coefficient_arcsec_per_um2"];
        seen(move |pose| rad_from_arcsec(arcsec_per_um2 * (1e3 * pose.translation_mm).powi(2)))
    },
};

/// Outside the table: γ·10⁻⁶ Θ·direction. Friction in the bearing twists the frame in proportion to the load of the
/// flexure.
pub(super) const DIRECTION_GAIN: Specification = Specification {
    id: "ooc_direction_gain",
    title: "a gain that depends on the direction of travel",
    scope: Scope::Device,
    depends_on: &["direction", "angle_deg", "history"],
    parameters: &[Parameter::strength("coefficient_ppm", "ppm", 1e5)],
    build: |values, _| {
        let part = 1e-6 * values["coefficient_ppm"];
        seen(move |pose| part * pose.direction * pose.mirror_rad)
    },
};

/// Outside the table: remanence after the largest excursion, A · sign · e^(−|φ − φ_end| / width). A pad that comes close
/// to a probe keeps some magnetisation, of the sign of the last excursion, which fades as the pad moves away.
pub(super) const REMANENCE: Specification = Specification {
    id: "ooc_remanence",
    title: "remanence of the pads after the largest excursion",
    scope: Scope::Device,
    depends_on: &["history", "direction", "angle_deg", "command_deg"],
    parameters: &[
        Parameter::strength("amplitude_arcsec", "arcsec", 1e3),
        Parameter::needed("width_deg", "deg", (0.05, 5.0), Drawn::Uniform(0.4, 1.0)).or(0.6),
        Parameter::needed("beyond_deg", "deg", (0.0, 1.8), Drawn::Uniform(1.1, 1.3)).or(1.2),
    ],
    build: |values, _| {
        Ok(Box::new(Pads {
            amplitude_rad: rad_from_arcsec(values["amplitude_arcsec"]),
            width_rad: values["width_deg"].to_radians(),
            beyond_rad: values["beyond_deg"].to_radians(),
            end_rad: 0.0,
        }))
    },
};

#[derive(Clone)]
struct Pads {
    amplitude_rad: f64,
    width_rad: f64,
    /// Excursions beyond this leave a trace.
    beyond_rad: f64,
    /// Where the last such excursion went; 0 before the first.
    end_rad: f64,
}

impl Pads {
    /// Where the last such excursion went, that to here included.
    fn end_with(&self, here: f64) -> f64 {
        let further = here.abs() > self.end_rad.abs() || here * self.end_rad < 0.0;
        if here.abs() > self.beyond_rad && further { here } else { self.end_rad }
    }
}

impl Mechanism for Pads {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        let end_rad = self.end_with(pose.frame_rad);
        if end_rad == 0.0 {
            return 0.0;
        }
        let away = (pose.frame_rad - end_rad).abs() / self.width_rad;
        self.amplitude_rad * end_rad.signum() * (-away).exp()
    }

    fn settled(&mut self, pose: &Pose) {
        self.end_rad = self.end_with(pose.frame_rad);
    }
}

/// Outside the table: A tanh((T − T_s)/w). An adhesive softens: the bracket lets go of its stress where the temperature
/// passes T_s.
pub(super) const SOFTENING: Specification = Specification {
    id: "ooc_softening",
    title: "an adhesive softens at one temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
    parameters: &[
        Parameter::strength("amplitude_arcsec", "arcsec", 1e3),
        Parameter::needed("softening_c", "°C", (-40.0, 100.0), Drawn::Uniform(25.0, 30.0)).or(27.0),
        Parameter::needed("width_k", "K", (0.01, 50.0), Drawn::Uniform(0.3, 1.0)).or(0.5),
    ],
    build: |values, _| {
        let amplitude_rad = rad_from_arcsec(values["amplitude_arcsec"]);
        let (softening_c, width_k) = (values["softening_c"], values["width_k"]);
        seen(move |pose| amplitude_rad * ((pose.temperature_c - softening_c) / width_k).tanh())
    },
};

/// Outside the table: κ (T − 27 °C)². Two metals of the bracket whose expansions cancel in the first order only.
pub(super) const TEMPERATURE_SQUARE: Specification = Specification {
    id: "ooc_temperature_square",
    title: "the zero goes with the square of the temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
    parameters: &[Parameter::strength("coefficient_arcsec_per_k2", "arcsec/K²", 100.0)],
    build: |values, _| {
        let arcsec_per_k2 = values["coefficient_arcsec_per_k2"];
        seen(move |pose| rad_from_arcsec(arcsec_per_k2 * (pose.temperature_c - LABORATORY_C).powi(2)))
    },
};
