//! The C pair in `generated/c`, linked by `build.rs`.

mod c {
    unsafe extern "C" {
        // `int32_t corrected_angle_q31(int32_t)` and `float corrected_angle_f32(float)`: no state, no pointers.
        pub safe fn corrected_angle_q31(s_q31: i32) -> i32;
        pub safe fn corrected_angle_f32(s_mm: f32) -> f32;
    }
}

/// The compiled C of the default q31 routine.
pub fn c_q31(s_q31: i32) -> i32 {
    c::corrected_angle_q31(s_q31)
}

/// The compiled C of the default f32 routine.
pub fn c_f32(s_mm: f32) -> f32 {
    c::corrected_angle_f32(s_mm)
}
