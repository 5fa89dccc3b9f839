
/// Appended to `batch.rs`: the digest of the routine's outputs over 2²⁰ inputs, spread over all words.
fn main() {
    let mut digest = 0u64;
    for i in 0..1u32 << 20 {
        // An odd number near 2³²/2²⁰, so that low bits occur as well; both ends of the type.
        let first = i.wrapping_mul(4_097).wrapping_add(0x8000_0000);
        let near = first.wrapping_add(i & 0xffff).wrapping_sub(0x8000);
        let second = if i % 2 == 0 { near } else { i.wrapping_mul(0x9e37_79b1) };
        let (bits, inside) = run(angle::ROUTINE, first, second);
        digest = digest.rotate_left(5).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(bits) ^ u64::from(inside);
    }
    println!("{digest:016x}");
}
