//! `trials`
fn main() {}
