//! The random choices of a case.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Numbers that arithmetic, parsers and units stumble over, as they are written.
const NUMBERS: &str = "0 -0 1 -1 2 3 9 16 17 0.1 0.5 -9999 1e-9 1e-17 1e-300 -1e-300 5e-324 1e6 65536 2147483648 \
    4294967296 1e17 1e20 9007199254740993 18446744073709551616 3.5e38 1e149 -1e155 1e300 -1e300 \
    1.7976931348623157e308 1e309 -1e309";

/// What is no finite decimal number.
const NO_NUMBERS: &str = "nan NaN inf -inf 0x1p3 1,5 1_000 1e --1 ١٢ \"";

/// Text that would leave the comment, the literal, the line, the attribute or the terminal it is put in;
/// [`super::written`] looks for the canary.
const TEXTS: &str = "*/ CANARY /*|\"; CANARY|<script>CANARY</script>|\"><b CANARY>|]]></script><script>CANARY|\
    line\nCANARY();|line\rCANARY();|line\u{2028}CANARY|CANARY \\|CANARY ??/|\u{202e}CANARY|\u{0}CANARY|\
    \u{1b}[31mCANARY|{{ CANARY }}{% CANARY|CANARY\u{85}|";

/// The random choices of one case.
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// Of case `number` of `seed`: every case has a stream of its own, so that it can be repeated alone.
    pub fn new(seed: u64, number: u64) -> Draw {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(number);
        Draw(rng)
    }

    /// A whole number below `end`; 0 where `end` is 0.
    pub fn below(&mut self, end: usize) -> usize {
        self.0.random_range(0..end.max(1))
    }

    /// Whether something happens that happens once in `n` times.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of them.
    ///
    /// # Panics
    /// Where there is none.
    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }

    /// One of the parts of a text.
    pub fn part<'a>(&mut self, text: &'a str, separator: char) -> &'a str {
        let parts: Vec<&str> = text.split(separator).collect();
        parts[self.below(parts.len())]
    }

    /// A random byte.
    pub fn byte(&mut self) -> u8 {
        self.0.next_u32() as u8
    }

    /// A number as text: mostly an extreme one, now and then a plain one of any size, or none at all.
    pub fn number(&mut self) -> String {
        match self.below(9) {
            0 => self.part(NO_NUMBERS, ' ').to_string(),
            1 | 2 => {
                format!("{:e}", self.0.random_range(-1.0..1.0_f64) * 10f64.powi(self.below(40) as i32 - 20))
            }
            _ => self.part(NUMBERS, ' ').to_string(),
        }
    }

    /// What a number that is right is multiplied by to be wrong.
    pub fn factor(&mut self) -> f64 {
        *self.pick(&[-1.0, 0.0, 0.5, 1.001, 2.0, 1e-3, 1e3, 206_264.8, 1e-10, 1e10, 1e-149, 1e149, 1e-300])
    }

    /// Text: hostile, long, or none.
    pub fn text(&mut self) -> String {
        match self.below(8) {
            1 => "x".repeat(100_000),
            2 => "µ°σ¹".repeat(1 + self.below(40)),
            _ => self.part(TEXTS, '|').to_string(),
        }
    }
}
