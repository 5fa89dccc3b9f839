//! The position feedback of a firmware, with the module as it was generated and committed.
#![no_std]
#![forbid(unsafe_code)]

use corrected_angle::corrected_angle_q31;

/// Deviation of the mirror from the commanded angle, both in 2⁻³² rad, for the controller.
///
/// - `s_q31`: s = x₂ − x₁, of which 2³¹ stand for 0.5 mm.
pub fn deviation(command: i32, s_q31: i32) -> i32 {
    command.saturating_sub(corrected_angle_q31(s_q31))
}

/// A table for a start-up test, computed by the compiler: the routine is `const`.
pub const REST: i32 = corrected_angle_q31(0);
