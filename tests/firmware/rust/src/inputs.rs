//! Inputs by their number, 0 … 2³² − 1, and the digest of outputs; the same as in `../c/inputs.h`.

use crate::routine::{Arguments, Returned};

/// A fixed scattering of 32 bits.
#[cfg(any(state, not(one_argument)))]
fn scatter(index: u32) -> u32 {
    let h = index.wrapping_mul(0x9e37_79b1);
    (h ^ (h >> 15)).wrapping_mul(0x85eb_ca77)
}

/// The arguments that stand for a number. One: its bit pattern. Two of 16 bits: its halves. Two wider ones: it
/// is the second, or as a float the difference, and the first is scattered. With a state: a reading that rises to
/// and fro, and a scattered further input of twelve bits.
#[inline(always)]
pub fn arguments(index: u32) -> Arguments {
    #[cfg(all(one_argument, float))]
    return (f32::from_bits(index),);
    #[cfg(all(one_argument, not(float)))]
    return (index as _,);
    #[cfg(all(not(one_argument), float))]
    {
        let first = scatter(index) as i32 as f32 * (1.0 / 4_294_967_296.0);
        // With one NaN, whichever the difference is: which one an addition gives is left to the machine.
        let is_nan = index & 0x7fff_ffff > 0x7f80_0000;
        let second = if is_nan { f32::from_bits(0x7fc0_0000) } else { first + f32::from_bits(index) };
        return (first, second);
    }
    #[cfg(state)]
    return (index.wrapping_add(scatter(index) >> 5) as _, (scatter(index.wrapping_add(1)) >> 20) as _);
    #[cfg(halves)]
    return ((index >> 16) as _, index as _);
    #[cfg(all(not(one_argument), not(float), not(halves), not(state)))]
    return (scatter(index) as _, index as _);
}

/// What the digest sees of the arguments.
#[inline(always)]
pub fn key(arguments: Arguments) -> u32 {
    #[cfg(one_argument)]
    return arguments.0.bits();
    #[cfg(not(one_argument))]
    return arguments.0.bits().wrapping_mul(0x27d4_eb2f).wrapping_add(arguments.1.bits());
}

/// As the 32 bits that the digest sees.
pub trait Bits {
    fn bits(self) -> u32;
}

macro_rules! integer_bits {
    ($($t:ty),*) => { $(impl Bits for $t {
        fn bits(self) -> u32 {
            self as u32
        }
    })* };
}
integer_bits!(i32, u32, u16, i16);

impl Bits for f32 {
    fn bits(self) -> u32 {
        self.to_bits()
    }
}

/// What one input and output add to the digest. For a given input, a bijection of the output.
fn mixed(key: u32, output: u32) -> u32 {
    let h = (output ^ key.wrapping_mul(0x9e37_79b1)).wrapping_mul(0x85eb_ca77);
    (h ^ (h >> 15)).wrapping_mul(0xc2b2_ae3d)
}

/// What a reading that was flagged as outside adds besides.
#[cfg(flag)]
const FLAGGED: u64 = 0x9e37_79b9_7f4a_7c15;

/// What one call adds to the digest.
#[inline(always)]
pub fn contribution(key: u32, returned: Returned) -> u64 {
    #[cfg(flag)]
    return match returned {
        Ok(value) => mixed(key, value.bits()).into(),
        Err(value) => FLAGGED.wrapping_add(mixed(key, value.bits()).into()),
    };
    #[cfg(not(flag))]
    return mixed(key, returned.bits()).into();
}
