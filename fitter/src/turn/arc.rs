//! Values on a circle: where they stand close together.

/// The part `value` − turn·n that lies in −turn/2 … turn/2.
pub(super) fn wrapped(value: f64, turn: f64) -> f64 {
    value - turn * (value / turn).round()
}

/// The part that lies in 0 … turn.
pub(super) fn within(value: f64, turn: f64) -> f64 {
    let rest = value - turn * (value / turn).floor();
    if rest >= turn { 0.0 } else { rest }
}

/// A stretch of a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    /// Where it begins, in 0 … turn.
    pub from: f64,
    pub length: f64,
}

impl Arc {
    pub fn holds(&self, value: f64, turn: f64) -> bool {
        within(value - self.from, turn) <= self.length
    }

    pub fn middle(&self) -> f64 {
        self.from + 0.5 * self.length
    }
}

/// The shortest arc that holds all values, and the gap before its beginning. At least one value.
pub(super) fn hull(values: &[f64], turn: f64) -> Arc {
    let mut sorted: Vec<f64> = values.iter().map(|value| within(*value, turn)).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    let (mut widest, mut from) = (sorted[0] + turn - sorted[last], sorted[0]);
    for pair in sorted.windows(2) {
        if pair[1] - pair[0] > widest {
            (widest, from) = (pair[1] - pair[0], pair[1]);
        }
    }
    Arc { from, length: turn - widest }
}

/// The arc of a given length that holds most values, and how many: the first of several.
pub(super) fn densest(values: &[f64], turn: f64, length: f64) -> (Arc, usize) {
    let mut sorted: Vec<f64> = values.iter().map(|value| within(*value, turn)).collect();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len();
    let (mut best, mut from, mut end) = (0, 0, 0);
    for start in 0..count {
        end = end.max(start);
        let value = |index: usize| sorted[index % count] + turn * (index / count) as f64;
        while end < start + count && value(end) - value(start) <= length {
            end += 1;
        }
        if end - start > best {
            (best, from) = (end - start, start);
        }
    }
    (Arc { from: sorted[from], length }, best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_pass_over_the_end_of_the_turn() {
        let values = [350.0, 355.0, 2.0, 8.0, -1.0];
        let arc = hull(&values, 360.0);
        assert_eq!((arc.from, arc.length), (350.0, 18.0));
        assert!(arc.holds(0.0, 360.0) && !arc.holds(9.0, 360.0));
        let (arc, count) = densest(&[350.0, 355.0, 2.0, 8.0, 90.0, 180.0, 181.0], 360.0, 20.0);
        assert_eq!((arc.from, count), (350.0, 4));
        assert_eq!((wrapped(-181.0, 360.0), within(-1.0, 360.0), within(-1e-20, 360.0)), (179.0, 359.0, 0.0));
    }
}
