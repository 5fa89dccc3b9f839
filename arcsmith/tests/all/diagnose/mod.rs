//! `diagnose` on recordings made here, and on opened and real ones where the environment names them.

mod bad_input;
mod beyond_the_catalogue;
mod cli;
mod common;
mod correlated_noise;
mod declared;
mod declared_campaign;
mod dynamic;
mod dynamic_hidden;
mod dynamic_judged;
mod equations;
mod examples;
mod fine_steering_mirror;
mod harmonics;
mod intervals;
mod lasting_noise;
mod moving;
mod other_recordings;
mod page;
