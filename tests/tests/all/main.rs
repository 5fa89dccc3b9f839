//! All tests of this crate from outside, in one binary.

mod any_device;
mod bad_input;
mod c_compilers;
mod check;
mod closed_loop;
mod default_routine;
mod documentation;
mod gappa;
mod miri;
mod overflow_checks;
mod paper;
mod physics_in_firmware;
mod real_sensor;
