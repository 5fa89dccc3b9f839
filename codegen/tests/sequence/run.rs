//! Runs a generated routine with a state over words from standard input, two each, and writes its results.

#[path = "../src/corrected_angle_q31.rs"]
mod generated;

use std::io::{Read, Write};

fn main() {
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).unwrap();
    let words: Vec<i32> =
        bytes.chunks_exact(4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let mut state = generated::CorrectedAngleQ31::new(words[0], words[1] as u16);
    let results = words.chunks_exact(2).flat_map(|w| state.update(w[0], w[1] as u16).to_le_bytes());
    std::io::stdout().write_all(&results.collect::<Vec<u8>>()).unwrap();
}
