//! Generated routines as firmware: built in C and Rust for Cortex-M0, M3 and M4F, run under QEMU, their outputs
//! held against the host's by a digest, their instructions, flash and stack counted and compared with a
//! committed table.
//!
//! [`cases`] says what is generated, [`subject`] generates it, [`build`] compiles firmware around it,
//! [`machine`] runs that, [`measure`] does all this for every case, [`table`] keeps the figures, and
//! [`comparison`] sets them beside what engineers write otherwise.

pub mod build;
pub mod cases;
pub mod machine;
pub mod measure;
pub mod problem;
pub mod run;
pub mod subject;
pub mod table;
pub mod tools;
