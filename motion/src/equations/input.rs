//! An input between its samples.

use crate::signal::Signal;

/// A cubic in the part s of its time that has passed: a + b s + c s² + d s³.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// Where it begins, s since the first row.
    pub from_s: f64,
    /// One over its length, 1/s.
    pub per_s: f64,
    /// a, b, c and d.
    pub cubic: [f64; 4],
}

impl Piece {
    /// One that holds no time.
    pub const NONE: Piece = Piece { from_s: f64::INFINITY, per_s: 1.0, cubic: [0.0; 4] };

    /// Whether it is the piece of a time.
    #[inline(always)]
    pub fn holds(&self, t_s: f64) -> bool {
        (0.0..1.0).contains(&((t_s - self.from_s) * self.per_s))
    }

    /// The value at a time.
    #[inline(always)]
    pub fn value(&self, t_s: f64) -> f64 {
        let ([a, b, c, d], s) = (self.cubic, (t_s - self.from_s) * self.per_s);
        a + s * (b + s * (c + s * d))
    }

    /// Its rate there, per second.
    #[inline(always)]
    pub fn rate(&self, t_s: f64) -> f64 {
        let ([_, b, c, d], s) = (self.cubic, (t_s - self.from_s) * self.per_s);
        (b + s * (2.0 * c + 3.0 * s * d)) * self.per_s
    }
}

/// An input between its samples.
pub trait Input: Sync {
    /// The piece that `within_s` since the first row lies in.
    fn piece(&self, within_s: f64) -> Piece;
}

impl Input for Signal {
    fn piece(&self, within_s: f64) -> Piece {
        Signal::piece(self, within_s)
    }
}
