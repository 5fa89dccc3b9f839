//! Intervals of values, for what may stand under a root, a logarithm or a division.

/// From the least to the largest value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Least value.
    pub from: f64,
    /// Largest value.
    pub to: f64,
}

impl Interval {
    /// One value.
    pub fn point(value: f64) -> Interval {
        Interval { from: value, to: value }
    }

    /// The least that holds all `values`; none where there is none or one is no number.
    pub fn around(values: impl IntoIterator<Item = f64>) -> Option<Interval> {
        let mut all: Option<Interval> = None;
        for value in values {
            if value.is_nan() {
                return None;
            }
            let before = all.unwrap_or(Interval::point(value));
            all = Some(Interval { from: before.from.min(value), to: before.to.max(value) });
        }
        all
    }

    /// That of a function that never falls.
    pub(crate) fn rising(self, function: impl Fn(f64) -> f64) -> Interval {
        Interval { from: function(self.from), to: function(self.to) }
    }

    /// That of values which a function of two numbers takes at its corners.
    pub(crate) fn corners(a: Interval, b: Interval, function: impl Fn(f64, f64) -> f64) -> Interval {
        let at = [(a.from, b.from), (a.from, b.to), (a.to, b.from), (a.to, b.to)].map(|(a, b)| {
            let value = function(a, b);
            // 0 · ∞ where nothing times anything is nothing.
            if value.is_nan() { 0.0 } else { value }
        });
        Interval {
            from: at.iter().copied().fold(f64::INFINITY, f64::min),
            to: at.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Whether it holds a value.
    pub fn holds(self, value: f64) -> bool {
        self.from <= value && value <= self.to
    }
}
