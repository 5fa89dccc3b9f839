//! What `run.c` does, with the generated Rust.

#[path = "../src/corrected_angle.rs"]
mod generated;

use std::io::{Read, Write};

use generated::{CorrectedAngle, PageError};

fn main() {
    let mut input = Vec::new();
    std::io::stdin().read_to_end(&mut input).unwrap();
    let mut rest = &input[..];
    let mut out = Vec::new();
    fn word(rest: &mut &[u8]) -> u32 {
        let (head, tail) = rest.split_at(4);
        *rest = tail;
        u32::from_le_bytes(head.try_into().unwrap())
    }
    while !rest.is_empty() {
        let bytes = word(&mut rest) as usize;
        let (page, tail) = rest.split_at(bytes);
        rest = tail;
        let count = word(&mut rest);
        let loaded = CorrectedAngle::load(page);
        let status: i32 = match loaded {
            Ok(_) => 0,
            Err(PageError::Short) => 1,
            Err(PageError::Magic) => 2,
            Err(PageError::Version) => 3,
            Err(PageError::Length) => 4,
            Err(PageError::Crc) => 5,
            Err(PageError::Structure) => 6,
            Err(PageError::Bound) => 7,
            Err(PageError::Coefficient) => 8,
        };
        out.extend(status.to_le_bytes());
        for _ in 0..count {
            let s = word(&mut rest) as i32;
            if let Ok(coefficients) = &loaded {
                out.extend(coefficients.corrected(s).to_le_bytes());
            }
        }
    }
    std::io::stdout().write_all(&out).unwrap();
}
