//! Play: what follows a quantity across a gap of ±r, alone or as the mean of several with gaps evenly up to r.
//! (Brokate & Sprekels, Hysteresis and Phase Transitions, 1996, chapter 2.)

use std::ops::RangeInclusive;

use super::{Operation, Operator};
use crate::evaluate::{Time, Value, parameters};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};

/// See the module.
pub struct Play {
    operation: Operation,
    name: &'static str,
    usage: &'static str,
    elements: usize,
}

pub static PLAY: Play =
    Play { operation: Operation::Play, name: "play", usage: "play(e, r) or play(e, r, start)", elements: 1 };
/// Distributed play, as a flexure has it.
pub static PLAYS: Play = Play {
    operation: Operation::Plays,
    name: "plays",
    usage: "plays(e, r) or plays(e, r, start)",
    elements: ELEMENTS,
};
/// Elements of a distributed play; the k-th has the gap k/8·r.
pub const ELEMENTS: usize = 8;

impl Operator for Play {
    fn operation(&self) -> Operation {
        self.operation
    }

    fn name(&self) -> &'static str {
        self.name
    }

    fn arguments(&self) -> RangeInclusive<usize> {
        2..=3
    }

    fn usage(&self) -> &'static str {
        self.usage
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        common(of)
    }

    fn interval(&self, of: &[Interval]) -> Result<Interval, String> {
        if of[1].from < 0.0 {
            return Err(format!("the gap runs down to {}, expected none below zero", of[1].from));
        }
        let start = of.get(2).unwrap_or(&of[0]);
        Ok(Interval { from: of[0].from.min(start.from), to: of[0].to.max(start.to) })
    }

    fn value(&self, of: &[Value], time: &Time) -> Value {
        let indices = parameters(of);
        let count = time.t_s.len();
        let part = 1.0 / self.elements as f64;
        let mut rows = vec![0.0; count];
        let mut slopes: Vec<(usize, Vec<f64>)> = indices.iter().map(|p| (*p, vec![0.0; count])).collect();
        for element in 1..=self.elements {
            let share = element as f64 * part;
            let start = of.get(2).unwrap_or(&of[0]);
            let mut state = start.at(0);
            let mut states: Vec<f64> = indices.iter().map(|p| start.slope(*p, 0)).collect();
            for row in 0..count {
                let (value, gap) = (of[0].at(row), share * of[1].at(row));
                // Which side of the gap carries it along; a state that is NaN takes any value.
                let side = match () {
                    () if state.is_nan() => 0.0,
                    () if value - gap > state => -1.0,
                    () if value + gap < state => 1.0,
                    () => f64::NAN,
                };
                if !side.is_nan() {
                    state = value + side * gap;
                    for (index, own) in indices.iter().zip(&mut states) {
                        *own = of[0].slope(*index, row) + side * share * of[1].slope(*index, row);
                    }
                }
                rows[row] += part * state;
                for ((_, slopes), own) in slopes.iter_mut().zip(&states) {
                    slopes[row] += part * own;
                }
            }
        }
        Value { rows, slopes }
    }

    fn remembers(&self) -> bool {
        true
    }
}
