//! Independent streams of random numbers from one seed: what is drawn for one purpose never shifts what
//! is drawn for another, so that two recordings differ only in what was meant to differ.

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// What a stream of random numbers is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// The traits of a device.
    Device,
    /// When each reading is taken.
    Timing,
    /// Temperature, plate translation and second axis.
    Environment,
    /// Repeatability of the probes.
    Probes,
    /// Noise and zero of the autocollimator.
    Autocollimator,
    /// What the controller leaves.
    Controller,
    /// Noise of the slow channels: thermometer, second axis, coil current.
    Housekeeping,
    /// What really differs from one settled position to the next: second axis and coil current.
    Settling,
    /// The order of the angles, where it is random.
    Order,
    /// Which readings are outliers.
    Outliers,
    /// How the mount sits in one pass.
    Seat(u32),
    /// The excitation of one run.
    Excitation(u32),
    /// Noise of the position in one run.
    ReadOut(u32),
    /// Traits of a direct sensor.
    Sensor,
    /// The course of one column of a direct sensor's surroundings.
    Surroundings(u32),
}

impl Stream {
    /// The number is part of the format: changing one changes every recording.
    fn number(self) -> u64 {
        match self {
            Self::Device => 1,
            Self::Timing => 2,
            Self::Environment => 3,
            Self::Probes => 4,
            Self::Autocollimator => 5,
            Self::Controller => 6,
            Self::Housekeeping => 7,
            Self::Settling => 8,
            Self::Order => 9,
            Self::Outliers => 10,
            Self::Sensor => 11,
            Self::Seat(pass) => 1000 + u64::from(pass),
            Self::Surroundings(column) => (3 << 40) + u64::from(column),
            Self::Excitation(run) => (1 << 40) + u64::from(run),
            Self::ReadOut(run) => (2 << 40) + u64::from(run),
        }
    }
}

/// The generator of `seed` for one purpose.
pub fn stream(seed: u64, purpose: Stream) -> ChaCha12Rng {
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    generator.set_stream(purpose.number());
    generator
}
