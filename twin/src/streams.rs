//! Independent streams of random numbers from one seed: what is drawn for one purpose never shifts what
//! is drawn for another, so that two recordings differ only in what was meant to differ.

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// What a stream of random numbers is for. The number is part of the format: changing it changes
/// every recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// The traits of a device.
    Device = 1,
    /// When each reading is taken.
    Timing = 2,
    /// Temperature, plate translation and second axis.
    Environment = 3,
    /// Repeatability of the probes.
    Probes = 4,
    /// Noise and zero of the autocollimator.
    Autocollimator = 5,
    /// What the controller leaves.
    Controller = 6,
    /// Noise of the slow channels: thermometer, second axis, coil current.
    Housekeeping = 7,
    /// What really differs from one settled position to the next: second axis and coil current.
    Settling = 8,
}

/// The generator of `seed` for one purpose.
pub fn stream(seed: u64, purpose: Stream) -> ChaCha12Rng {
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    generator.set_stream(purpose as u64);
    generator
}
