//! The position feedback of a firmware, with the routine that `build.rs` generated.
#![no_std]
#![forbid(unsafe_code)]

mod generated {
    include!(concat!(env!("OUT_DIR"), "/corrected_angle.rs"));
}

/// Deviation of the mirror from the commanded angle in nanoradians, for the controller, from the two probes'
/// converters.
pub fn deviation_nrad(command_nrad: i32, x1_counts: u16, x2_counts: u16) -> i32 {
    command_nrad.saturating_sub(generated::corrected_angle(x1_counts, x2_counts))
}

#[cfg(test)]
mod tests {
    use super::deviation_nrad;

    #[test]
    fn a_mirror_turned_by_one_degree_is_a_degree_off_its_rest() {
        // s = 12 mm·tan 1° is 13726 counts of the difference, up to the error that is corrected, 0.14·1°.
        let off = f64::from(deviation_nrad(0, 32768 - 6863, 32768 + 6863)) * 1e-9;
        assert!((off.to_degrees() + 0.86).abs() < 0.02, "{}", off.to_degrees());
    }
}
