//! Damage below the structure of a file, and compression.

use std::io::Write;
use std::sync::OnceLock;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::draw::Draw;

/// Flips bits, overwrites, repeats, removes or cuts off bytes.
pub fn damage(draw: &mut Draw, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        return;
    }
    let at = draw.below(bytes.len());
    match draw.below(6) {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(at..(at + 1 + draw.below(8)).min(bytes.len()))),
        2 => {
            let part = bytes[at..(at + 64).min(bytes.len())].to_vec();
            bytes.splice(at..at, part);
        }
        3 => bytes[at] = *draw.pick(&[0, 0xff, 0x7f, 0x80, b'"', b'\n', b',', b'{']),
        // A footer or a header, where lengths and offsets stand.
        4 => {
            let near = draw.below(bytes.len().min(64));
            let at = if draw.one_in(2) { near } else { bytes.len() - 1 - near };
            bytes[at] = draw.byte();
        }
        _ => (0..1 + draw.below(8)).for_each(|_| {
            let at = draw.below(bytes.len());
            bytes[at] ^= 1 << draw.below(8);
        }),
    }
}

/// Compressed as `.csv.gz`.
pub fn gz(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    // Writing into memory has no way to fail.
    let _ = packed.write_all(bytes);
    packed.finish().unwrap_or_default()
}

/// A `.csv.gz` of a few hundred kB that unpacks to 2 GB: members of one endless line.
pub fn bomb() -> Vec<u8> {
    static MEMBER: OnceLock<Vec<u8>> = OnceLock::new();
    MEMBER.get_or_init(|| gz(&vec![b'1'; 64 << 20])).repeat(32)
}
