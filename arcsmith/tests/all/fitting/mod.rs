//! `fit`, `apply` and `report` from outside.

mod bad_input;
mod cli;
#[path = "../../../../fitter/tests/all/common/mod.rs"]
mod common;
mod ingest;
mod pages;
mod report;
