//! A page of flash: little-endian words of 32 bits, the last the CRC-32 of all before it.
//!
//! | word | what |
//! |---|---|
//! | 0 | magic, `ARCU` |
//! | 1 | version of the layout, [`VERSION`] |
//! | 2 | length of the page in bytes |
//! | 3 | structure: what routine the coefficients are for |
//! | 4 | what was proved for this unit, in 1/256 of the result's unit, rounded up |
//! | 5 | first eight digits of the SHA-256 of the device's coefficients file |
//! | 6 … | coefficients, constant first |
//! | last | CRC-32 (IEEE 802.3, as of zip and Ethernet) |

/// `ARCU` in the order of bytes.
pub const MAGIC: u32 = u32::from_le_bytes(*b"ARCU");

/// Version of the layout.
pub const VERSION: u32 = 1;

/// Words before the coefficients.
pub const HEAD_WORDS: usize = 6;

/// The page's contents.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// See the module.
    pub structure: u32,
    /// See the module.
    pub proved: u32,
    /// See the module.
    pub origin: u32,
    /// Constant first.
    pub coefficients: Vec<i32>,
}

impl Page {
    /// Bytes of a page of so many coefficients.
    pub fn length(coefficients: usize) -> usize {
        4 * (HEAD_WORDS + coefficients + 1)
    }

    /// The page as it is written to flash.
    pub fn bytes(&self) -> Vec<u8> {
        let length = Page::length(self.coefficients.len()) as u32;
        let head = [MAGIC, VERSION, length, self.structure, self.proved, self.origin];
        let mut bytes: Vec<u8> = head.iter().flat_map(|word| word.to_le_bytes()).collect();
        bytes.extend(self.coefficients.iter().flat_map(|c| c.to_le_bytes()));
        let crc = crc32(&bytes);
        bytes.extend(crc.to_le_bytes());
        bytes
    }
}

/// CRC-32 of IEEE 802.3: reflected polynomial 0xEDB88320, all ones before and after.
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(
            crc ^ u32::from(*byte),
            |crc, _| {
                if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 }
            },
        )
    })
}

/// Bytes at an address as Intel HEX, 16 in a record.
pub fn intel_hex(bytes: &[u8], address: u32) -> String {
    let mut text = String::new();
    let mut record = |kind: u8, address: u16, data: &[u8]| {
        let mut all = vec![data.len() as u8, (address >> 8) as u8, address as u8, kind];
        all.extend(data);
        let sum = all.iter().fold(0u8, |sum, byte| sum.wrapping_sub(*byte));
        all.push(sum);
        text.push(':');
        all.iter().for_each(|byte| text.push_str(&format!("{byte:02X}")));
        text.push('\n');
    };
    let mut upper = None;
    for (index, chunk) in bytes.chunks(16).enumerate() {
        let at = address.wrapping_add(16 * index as u32);
        if upper != Some(at >> 16) {
            upper = Some(at >> 16);
            record(4, 0, &[(at >> 24) as u8, (at >> 16) as u8]);
        }
        record(0, at as u16, chunk);
    }
    record(1, 0, &[]);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crc_is_the_usual_one() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn hex_records_are_those_of_the_format() {
        // The example of the format's description.
        let bytes =
            [0x21, 0x46, 0x01, 0x36, 0x01, 0x21, 0x47, 0x01, 0x36, 0x00, 0x7e, 0xfe, 0x09, 0xd2, 0x19, 0x01];
        let hex = intel_hex(&bytes, 0x0100);
        assert_eq!(hex.lines().nth(1), Some(":10010000214601360121470136007EFE09D2190140"));
        assert_eq!(hex.lines().last(), Some(":00000001FF"));
    }
}
