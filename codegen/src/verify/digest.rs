//! The digest of a routine's outputs: one 64-bit number that Rust, C, the interpreter and a microcontroller
//! can all compute, over any set of inputs, in any order and in any number of parts.
//!
//! Each input and its output are mixed into 32 bits by additions and multiplications of 32-bit words, and the
//! mixed words are added up in 64 bits. For a given input the mixing is a bijection of the output: one output
//! that differs always changes the digest; where several differ, they cancel by chance in one of 2³² cases.
//!
//! ```text
//! key(w)      = w                        one argument, as its 32 bits (16 bits: zero extended)
//! key(w₁,w₂)  = w₁·0x27d4eb2f + w₂       two arguments
//! h = output ⊕ key·0x9e3779b1;  h = h·0x85ebca77;  h = h ⊕ (h >> 15);  h = h·0xc2b2ae3d   (mod 2³²)
//! digest = Σ h + 0x9e3779b97f4a7c15 for every reading flagged as outside                  (mod 2⁶⁴)
//! ```

/// What a flagged reading adds.
pub const FLAGGED: u64 = 0x9e37_79b9_7f4a_7c15;

/// The key of one or two argument words.
pub fn key(words: &[u32]) -> u32 {
    words[1..].iter().fold(words[0], |key, word| key.wrapping_mul(0x27d4_eb2f).wrapping_add(*word))
}

/// What one input and output contribute to the digest, apart from the flag.
pub fn mixed(key: u32, output: u32) -> u32 {
    let h = (output ^ key.wrapping_mul(0x9e37_79b1)).wrapping_mul(0x85eb_ca77);
    (h ^ (h >> 15)).wrapping_mul(0xc2b2_ae3d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fixed values, so that an implementation elsewhere can be held against this one.
    #[test]
    fn known_values() {
        assert_eq!(mixed(key(&[0]), 0), 0);
        assert_eq!(mixed(key(&[1]), 0), 0xabdd_1347);
        assert_eq!(mixed(key(&[0xdead_beef]), 0x0123_4567), 0xb18a_9152);
        assert_eq!(key(&[3, 5]), 3u32.wrapping_mul(0x27d4_eb2f) + 5);
    }

    proptest! {
        #[test]
        fn one_different_output_always_shows(key in any::<u32>(), a in any::<u32>(), b in any::<u32>()) {
            prop_assert_eq!(mixed(key, a) == mixed(key, b), a == b);
        }
    }
}
