//! The project file, `arcsmith.toml`: what a folder is about. From it every command takes what it is not told
//! ([`complete`]), `run` does what is stale ([`run`]), and `status` says what that is and why ([`status`]).
//!
//! The one idea: a project is nothing but the words of command lines. [`steps`] has those of its own commands; a command
//! that is typed is completed by the options that it lacks, and is then run as if all had been typed.

pub mod complete;
pub mod file;
pub mod init;
mod options;
mod parts;
mod perform;
pub mod run;
mod stale;
mod state;
pub mod status;
mod steps;
mod tree;

pub use fitter::input::PROJECT_FILE as FILE;
