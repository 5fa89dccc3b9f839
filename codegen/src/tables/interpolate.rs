//! Straight lines between entries at equal distances: how far they are from what is wanted, and the entries for which that
//! is least.

use super::chain;
use super::ring::Ring;

/// Places between two entries at which the lines are compared: the search is no proof, and what is wanted is smooth.
const PLACES: usize = 16;
/// Candidates on either side of an entry, and how often they are drawn closer: each time to a quarter.
const AROUND: i32 = 8;
const STEPS: usize = 3;

/// The places between entries, with what is wanted there.
pub struct Lines {
    /// Of every stretch: the part of it that lies before the place, and what is wanted. The last entry's has no places
    /// where the entries do not go round.
    stretches: Vec<Vec<(f64, f64)>>,
}

impl Lines {
    /// With so many entries round the turn; what is wanted is in turns.
    pub fn new(ring: &Ring, entries: usize) -> Lines {
        Lines::of(entries, entries, |turns| ring.at(turns - turns.floor()))
    }

    /// With so many entries, the first at the beginning and the last at the end of a range; what is wanted is a function of
    /// the part of the range.
    pub fn along(entries: usize, wanted: impl Fn(f64) -> f64) -> Lines {
        let mut lines = Lines::of(entries - 1, entries, wanted);
        let end = lines.stretches[entries - 2][PLACES].1;
        lines.stretches[entries - 1] = vec![(0.0, end)];
        lines
    }

    fn of(stretches: usize, entries: usize, wanted: impl Fn(f64) -> f64) -> Lines {
        let stretch = |node: usize| {
            let place = |k: usize| {
                let part = k as f64 / PLACES as f64;
                (part, wanted((node as f64 + part) / stretches as f64))
            };
            if node < stretches { (0..=PLACES).map(place).collect() } else { Vec::new() }
        };
        Lines { stretches: (0..entries).map(stretch).collect() }
    }

    /// Number of entries.
    pub fn entries(&self) -> usize {
        self.stretches.len()
    }

    /// What is wanted at an entry's place.
    pub fn at(&self, node: usize) -> f64 {
        self.stretches[node][0].1
    }

    /// The largest distance in a stretch of the line from `left` to `right`.
    pub fn distance(&self, node: usize, left: f64, right: f64) -> f64 {
        let off = |(part, wanted): &(f64, f64)| (left + (right - left) * part - wanted).abs();
        self.stretches[node].iter().map(off).fold(0.0, f64::max)
    }

    /// The largest distance of the lines between these entries.
    pub fn worst(&self, entry: impl Fn(usize) -> f64) -> f64 {
        let next = |node: usize| (node + 1) % self.entries();
        (0..self.entries()).map(|i| self.distance(i, entry(i), entry(next(i)))).fold(0.0, f64::max)
    }

    /// The entries, of any precision, whose lines are nearest, and how near.
    pub fn best(&self) -> (Vec<f64>, f64) {
        let entries = self.entries();
        let mut best: Vec<f64> = (0..entries).map(|node| self.at(node)).collect();
        let next = |node: usize| (node + 1) % entries;
        let mut least = self.worst(|node| best[node]);
        let mut reach = least;
        for _ in 0..STEPS {
            let moved =
                |node: usize, k: usize| best[node] + reach * f64::from(k as i32 - AROUND) / f64::from(AROUND);
            let candidates = vec![2 * AROUND as usize + 1; entries];
            let (choice, found) =
                chain::ring(&candidates, |i, a, b| self.distance(i, moved(i, a), moved(next(i), b)));
            let values: Vec<f64> = choice.iter().enumerate().map(|(node, k)| moved(node, *k)).collect();
            if found < least {
                (best, least) = (values, found);
            }
            reach *= 0.25;
        }
        (best, least)
    }
}
