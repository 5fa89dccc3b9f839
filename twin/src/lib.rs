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

pub mod angular_error;
pub mod autocollimator;
pub mod controller;
pub mod device;
pub mod drive;
pub mod environment;
pub mod geometry;
pub mod log;
pub mod noise;
pub mod probes;
pub mod protocol;
mod record;
pub mod streams;
pub mod units;

pub use device::Device;
pub use geometry::calculated_angle_rad;
pub use log::{Reading, write_csv, write_file};
pub use protocol::Protocol;
pub use record::{Truth, record, record_with_truth};
