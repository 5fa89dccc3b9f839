//! Simulates the calibration of a scanning mirror: the physics that *produces* a recording, in the way
//! of Fan et al., "Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling and
//! Correction" (2019). Nothing here knows how a recording is fitted.
//!
//! One [`Device`] is drawn from a seed; [`record`] steps it through a [`Protocol`] in closed loop on any
//! feedback function and returns what the log of the laboratory holds.
//!
//! ```
//! let device = twin::Device::from_seed(1);
//! let d = device.geometry.probe_distance_mm;
//! let log = twin::record(&device, &twin::Protocol::calibration(), 1, &|x1, x2| {
//!     twin::calculated_angle_rad(x1, x2, d)
//! });
//! assert_eq!(log.len(), 210);
//! ```
//!
//! Effects are hidden in a device by [`Device::with_effects`]; they act where they act in a real mirror, see
//! [`effects`]. What each of them adds to a row, and how the noise really varies, is known to
//! [`contributions`] and [`noise_covariance`] and to nobody who is given the recording:
//!
//! ```
//! use twin::{Device, Protocol, Temperature, contributions};
//!
//! let effect = "thermal_zero_drift:coefficient_arcsec_per_k=0.2".parse()?;
//! let device = Device::from_seed(1).with_effects(vec![effect])?;
//! let protocol = Protocol { temperature: Temperature::chamber(), ..Protocol::fine() };
//! let added = contributions(&device, &protocol, 1, &|x1, x2| twin::calculated_angle_rad(x1, x2, 12.0));
//! assert_eq!((added.len(), added[0].len()), (1, 552));
//! # Ok::<(), twin::EffectError>(())
//! ```

pub mod angular_error;
pub mod autocollimator;
mod chain;
pub mod controller;
pub mod device;
pub mod drive;
pub mod dynamic;
pub mod effects;
pub mod encoder;
pub mod environment;
pub mod geometry;
pub mod log;
pub mod noise;
mod orthogonal;
pub mod probes;
pub mod protocol;
mod record;
pub mod sensor;
pub mod streams;
pub mod temperature;
pub mod truth;
pub mod units;

pub use device::Device;
pub use effects::{EffectError, Injected};
pub use geometry::calculated_angle_rad;
pub use log::{Reading, write_csv, write_file};
pub use noise::Noise;
pub use protocol::Protocol;
pub use record::{
    Corrector, Feedback, contributions, record, record_corrected, record_noiseless, record_with_truth,
};
pub use temperature::Temperature;
pub use truth::{Truth, noise_covariance};
