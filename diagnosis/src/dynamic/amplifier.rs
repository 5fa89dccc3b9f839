//! An amplifier's offset and limit: what it makes of a stretch of the drive. Where there is a limit no stretch is more than a
//! parabola: [`Data::course`](super::data::Data::course) takes the drive of a model that has one so.

use physics::number::Number;

use super::signal::{Piece, along};

/// What an amplifier does to the drive: an offset, then a limit, whichever was found first.
#[derive(Debug, Clone, Copy)]
pub struct Amplifier<T> {
    /// Sum of the offsets.
    pub offset: Option<T>,
    /// The narrowest limit on either side.
    pub limit: Option<T>,
}

/// Crossings of a parabola with the limit on either side.
const MOST_CROSSINGS: usize = 4;

impl<T: Number> Amplifier<T> {
    /// The drive behind it.
    #[inline]
    pub fn pass(&self, drive: T) -> T {
        let drive = self.offset.map_or(drive, |offset| drive + offset);
        self.limit.map_or(drive, |limit| drive.clamp(limit))
    }

    /// The drive behind it along a parabola, in parts on none of which the limit begins or ends: on each it is a parabola again.
    /// `lift` takes the drive's numbers, which may have no derivatives, to those of offset and limit.
    #[inline(always)]
    pub fn parts<L: Number>(
        self,
        piece: Piece<L>,
        lift: impl Fn(L) -> T,
    ) -> impl Iterator<Item = ([T; 4], L)> {
        let places = self.crossings(piece.cubic.map(L::value));
        (0..=MOST_CROSSINGS).filter(move |i| *i == 0 || places[*i] < 1.0).map(move |i| {
            let [from, to] = [places[i], places[i + 1]];
            let cubic = match (from, to) {
                (0.0, 1.0) => piece.cubic,
                _ => along(piece.cubic, L::from_f64(from), L::from_f64(to - from)),
            };
            (self.stretch(cubic.map(&lift)), piece.part * (to - from))
        })
    }

    /// The same of a stretch on which the limit neither begins nor ends.
    #[inline(always)]
    fn stretch(&self, [a, b, c, d]: [T; 4]) -> [T; 4] {
        let a = self.offset.map_or(a, |offset| a + offset);
        let middle = a + b * 0.5 + c * 0.25 + d * 0.125;
        match self.limit {
            Some(limit) if middle.value().abs() > limit.value() => {
                let zero = T::from_f64(0.0);
                [middle.clamp(limit), zero, zero, zero]
            }
            _ => [a, b, c, d],
        }
    }

    /// Whether the limit is surely not reached along a stretch.
    pub fn is_open(&self, [a, b, c, d]: [f64; 4]) -> bool {
        let a = a + self.offset.map_or(0.0, |offset| offset.value());
        self.limit.is_none_or(|limit| a.abs() + b.abs() + c.abs() + d.abs() <= limit.value())
    }

    /// Where along a parabola the limit begins or ends, ascending, between 0 and as many ones as there are no such places.
    fn crossings(&self, [a, b, c, _]: [f64; 4]) -> [f64; MOST_CROSSINGS + 2] {
        let mut places = [1.0; MOST_CROSSINGS + 2];
        places[0] = 0.0;
        let Some(limit) = self.limit.filter(|_| !self.is_open([a, b, c, 0.0])) else { return places };
        if b == 0.0 && c == 0.0 {
            return places;
        }
        let a = a + self.offset.map_or(0.0, |offset| offset.value());
        for (side, level) in [limit.value(), -limit.value()].into_iter().enumerate() {
            // The roots of a + b r + c r² without cancellation; of a line one of them is infinite or no number.
            let a = a - level;
            let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
            for (place, root) in places[2 * side + 1..].iter_mut().zip([q / c, a / q]) {
                if root > 0.0 && root < 1.0 {
                    *place = root;
                }
            }
        }
        places.sort_unstable_by(f64::total_cmp);
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamic::lag::moments;
    use physics::number::Dual;

    /// Mean and slope by the limit of a parabola that rises through one limit and of one that crosses both, against the mean of
    /// many points.
    #[test]
    fn a_limit_is_exact_along_a_parabola() {
        for cubic in
            [[0.2, 1.0, 0.0, 0.0], [-1.0, 8.0, -7.0, 0.0], [0.1, 0.2, 0.1, 0.0], [2.0, 0.0, 0.0, 0.0]]
        {
            let mean = |limit: Dual<1>| {
                let amplifier = Amplifier { offset: Some(Dual::from_f64(0.1)), limit: Some(limit) };
                let parts = amplifier.parts(Piece { cubic, part: 1.0 }, Dual::from_f64);
                parts.fold(Dual::from_f64(0.0), |sum: Dual<1>, (cubic, part)| sum + moments(cubic)[0] * part)
            };
            let found = mean(Dual::variable(0.6, 0));
            let sampled = |limit: f64| {
                let amplifier = Amplifier { offset: Some(0.1), limit: Some(limit) };
                let at = |i: u32| (f64::from(i) + 0.5) / 1e5;
                let drive = |r: f64| cubic[0] + r * (cubic[1] + r * cubic[2]);
                (0..100_000).map(|i| amplifier.pass(drive(at(i)))).sum::<f64>() / 1e5
            };
            assert!((found.value() - sampled(0.6)).abs() < 1e-8, "{cubic:?}");
            let slope = (sampled(0.6 + 1e-4) - sampled(0.6 - 1e-4)) / 2e-4;
            assert!((found.slopes[0] - slope).abs() < 1e-3, "{cubic:?}: {} {slope}", found.slopes[0]);
        }
    }
}
