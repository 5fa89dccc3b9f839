//! What acts in the autocollimator, its mount and its table: it reads another angle than the mirror's.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_distr::StandardNormal;

use super::{Drawn, Mechanism, Parameter, Scope, Specification, read};
use crate::environment::LABORATORY_C;
use crate::streams::{Stream, stream};

/// ρ t: the table of the autocollimator creeps and turns it evenly.
pub(super) const TIME_DRIFT: Specification = Specification {
    id: "time_drift",
    title: "the zero drifts evenly with time",
    scope: Scope::Recording,
    depends_on: &["t_s"],
    parameters: &[Parameter::strength("rate_arcsec_per_h", "arcsec/h", 1e4)],
    build: |values, _| {
        let arcsec_per_s = values["rate_arcsec_per_h"] / 3600.0;
        read(move |pose| -arcsec_per_s * pose.t_s)
    },
};

/// A (1 − e^(−t/τ)): the electronics of the autocollimator warm up at t = 0 and turn its optics in proportion to their
/// own rise in temperature.
pub(super) const WARMUP_DRIFT: Specification = Specification {
    id: "warmup_drift",
    title: "the zero drifts after switch-on and comes to rest",
    scope: Scope::Recording,
    depends_on: &["t_s"],
    parameters: &[
        Parameter::strength("amplitude_arcsec", "arcsec", 1e3),
        Parameter::needed("time_constant_s", "s", (1.0, 1e5), Drawn::OfDuration(0.08, 0.3)),
    ],
    build: |values, _| {
        let (amplitude_arcsec, time_constant_s) = (values["amplitude_arcsec"], values["time_constant_s"]);
        // exp_m1 is e^x − 1 without cancellation.
        read(move |pose| amplitude_arcsec * (-pose.t_s / time_constant_s).exp_m1())
    },
};

/// h for t ≥ t₀: the autocollimator slips in its mount.
pub(super) const MOUNT_STEP: Specification = Specification {
    id: "mount_step",
    title: "the mount slips once",
    scope: Scope::Recording,
    depends_on: &["t_s"],
    parameters: &[
        Parameter::strength("step_arcsec", "arcsec", 1e3),
        Parameter::needed("time_s", "s", (0.0, 1e7), Drawn::OfDuration(0.15, 0.85)),
    ],
    build: |values, _| {
        let (step_arcsec, time_s) = (values["step_arcsec"], values["time_s"]);
        read(move |pose| if pose.t_s >= time_s { -step_arcsec } else { 0.0 })
    },
};

/// τ dθ/dt: the autocollimator's camera integrates, so that what it reads is the angle of a moment before the probes were
/// sampled. It shows only where the mirror moves while it is read.
///
/// In true angle this adds τ dΘ/dt; the table's θ is the calculated angle, a nearly constant factor larger.
/// The delay of the camera is chosen so that the two agree over the stroke.
pub(super) const READ_LAG: Specification = Specification {
    id: "read_lag",
    title: "the reference is read later than the probes",
    scope: Scope::Device,
    depends_on: &["velocity", "direction"],
    parameters: &[Parameter::strength("delay_s", "s", 10.0)],
    build: |values, device| {
        Ok(Box::new(Camera { delay_s: values["delay_s"] / device.true_per_calculated() }))
    },
};

#[derive(Clone)]
struct Camera {
    delay_s: f64,
}

impl Mechanism for Camera {
    fn reference_delay_s(&self) -> f64 {
        self.delay_s
    }
}

/// Outside the table: creep that heat hastens, κ (T − 27 °C) t. The mount creeps at a rate that goes with the
/// temperature.
pub(super) const AGING: Specification = Specification {
    id: "ooc_aging",
    title: "creep hastened by heat",
    scope: Scope::Recording,
    depends_on: &["temperature_c", "t_s", "history"],
    parameters: &[Parameter::strength("coefficient_arcsec_per_k_h", "arcsec/(K h)", 1e4)],
    build: |values, _| {
        let arcsec_per_k_h = values["coefficient_arcsec_per_k_h"];
        read(move |pose| -arcsec_per_k_h * (pose.temperature_c - LABORATORY_C) * pose.t_s / 3600.0)
    },
};

/// Outside the table: κ · cross². A beam that leaves the plane of measurement meets the scale at a slant.
pub(super) const CROSS_SQUARE: Specification = Specification {
    id: "ooc_cross_square",
    title: "the square of the second axis",
    scope: Scope::Device,
    depends_on: &["cross_arcsec"],
    parameters: &[Parameter::strength("coefficient_per_arcsec", "1/arcsec", 20.0)],
    build: |values, _| {
        let per_arcsec = values["coefficient_per_arcsec"];
        read(move |pose| -per_arcsec * pose.cross_arcsec * pose.cross_arcsec)
    },
};

/// Outside the table: the mount reseats at random whenever the passes change, by a normal deviate of its own for every
/// pass. `pattern` is the seed of the deviates.
pub(super) const RESEATING: Specification = Specification {
    id: "ooc_reseating",
    title: "the mount reseats at random between passes",
    scope: Scope::Recording,
    depends_on: &["pass", "t_s", "history", "direction"],
    parameters: &[
        Parameter::needed("deviation_arcsec", "arcsec", (0.0, 1e3), Drawn::PositiveStrength),
        Parameter::needed("pattern", "1", (0.0, 4e9), Drawn::Whole(0, 1_000_000)).or(1.0),
    ],
    build: |values, _| {
        let (deviation_arcsec, pattern) = (values["deviation_arcsec"], values["pattern"] as u64);
        read(move |pose| {
            let mut generator = stream(pattern, Stream::Seat(pose.pass));
            -deviation_arcsec * generator.sample::<f64, _>(StandardNormal)
        })
    },
};

/// Outside the table: the building sways, A sin(2πt/P + φ), and the table of the autocollimator with it.
pub(super) const SWAY: Specification = Specification {
    id: "ooc_sway",
    title: "the table sways with time",
    scope: Scope::Recording,
    depends_on: &["t_s", "history"],
    parameters: &[
        Parameter::needed("amplitude_arcsec", "arcsec", (-1e3, 1e3), Drawn::PositiveStrength),
        Parameter::needed("period_s", "s", (1.0, 1e6), Drawn::OfDuration(0.1, 0.3)),
        Parameter::needed("phase_deg", "deg", (-360.0, 360.0), Drawn::Uniform(0.0, 360.0)).or(0.0),
    ],
    build: |values, _| {
        let (amplitude_arcsec, period_s) = (values["amplitude_arcsec"], values["period_s"]);
        let phase = values["phase_deg"].to_radians();
        read(move |pose| -amplitude_arcsec * (TAU * pose.t_s / period_s + phase).sin())
    },
};
