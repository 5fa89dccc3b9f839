//! The fuzzer of the program `arcsmith`: inputs and options damaged at random, each case in a process of its own.
//!
//! A case is determined by its seed and its number. [`seeds`] are files that the program writes itself,
//! and what is run on them; [`table`], [`document`], [`bytes`] and [`options`] damage one of them;
//! [`process`] runs the program with limits, and [`judge`] says what it must not have done. [`kept`] are the
//! failures found so far.

pub mod bytes;
pub mod case;
pub mod document;
pub mod draw;
pub mod judge;
pub mod kept;
pub mod options;
pub mod process;
pub mod seeds;
pub mod summary;
pub mod table;
pub mod written;
