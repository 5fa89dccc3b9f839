//! Calls every committed routine on words spread over the whole type.

use corrected_angle::{corrected_angle_f32, corrected_angle_q31};

fn main() {
    let mut calls = 0;
    for i in 0..2048u32 {
        let word = i.wrapping_mul(0x0020_0401).wrapping_add(0x8000_0000);
        let _ = std::hint::black_box(corrected_angle_q31(word as i32));
        let value = corrected_angle_f32(f32::from_bits(word));
        assert!(value.is_finite());
        calls += 2;
    }
    println!("{calls} calls");
}
