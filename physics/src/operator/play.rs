//! Play: what follows a quantity across a gap of ±r, alone or as the mean of several with gaps evenly up to r.
//! (Brokate & Sprekels, Hysteresis and Phase Transitions, 1996, chapter 2.)

use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value, parameters};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};

/// See the module.
pub struct Play {
    form: Form,
    elements: usize,
}

pub static PLAY: Play =
    Play { form: Form::new(Operation::Play, "play", "play(e, r) or play(e, r, start)", 2..=3), elements: 1 };
/// Elements of a distributed play unless they are stated; the k-th of n has the gap k/n·r.
pub const ELEMENTS: usize = 8;
/// Distributed play, as a flexure has it.
pub static PLAYS: Play = Play {
    form: Form::new(
        Operation::Plays,
        "plays",
        "plays(e, r), plays(e, r, start) or plays(e, r, start, how_many)",
        2..=4,
    ),
    elements: ELEMENTS,
};

/// Elements that are run abreast, since each waits for its own last value.
const ABREAST: usize = 12;
/// Most elements of one operator.
const MOST: f64 = 64.0;

/// The mean of plays of constant gaps evenly up to `gap`, some of them at a time.
fn abreast<const ABREAST: usize>(x: &Value, gap: f64, start: f64, elements: usize, count: usize) -> Vec<f64> {
    let part = 1.0 / elements as f64;
    let mut apart = vec![0.0; count];
    for first in (0..elements).step_by(ABREAST) {
        // Beyond the last one a gap of nothing, which is never apart.
        let gap_of = |k: usize| if first + k < elements { gap * (first + k + 1) as f64 * part } else { 0.0 };
        let gaps: [f64; ABREAST] = std::array::from_fn(gap_of);
        let mut states = [start; ABREAST];
        for (row, apart) in apart.iter_mut().enumerate() {
            let x = x.at(row);
            for (state, gap) in states.iter_mut().zip(&gaps) {
                let above = if *state < x - gap { x - gap } else { *state };
                *state = if above > x + gap { x + gap } else { above };
                *apart += x - *state;
            }
        }
    }
    apart.iter().enumerate().map(|(row, apart)| x.at(row) - part * apart).collect()
}

impl Operator for Play {
    fn form(&self) -> &Form {
        &self.form
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        let (unit, mut factors) = common(&of[..of.len().min(3)])?;
        if let Some(how_many) = of.get(3) {
            how_many
                .number()
                .filter(|n| n.fract() == 0.0 && (1.0..=MOST).contains(n))
                .ok_or_else(|| UnitError::Needs(how_many.unit(), "a whole number of elements, 64 at most"))?;
            factors.push(1.0);
        }
        Ok((unit, factors))
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
        let elements = of.get(3).map_or(self.elements, |how_many| how_many.at(0) as usize);
        let first = of.get(2).unwrap_or(&of[0]).at(0);
        if indices.is_empty() && of[1].rows.len() == 1 && !first.is_nan() {
            let run = if elements == 1 { abreast::<1> } else { abreast::<ABREAST> };
            return Value { rows: run(&of[0], of[1].at(0), first, elements, count), slopes: Vec::new() };
        }
        let part = 1.0 / elements as f64;
        let mut rows = vec![0.0; count];
        let mut slopes: Vec<(usize, Vec<f64>)> = indices.iter().map(|p| (*p, vec![0.0; count])).collect();
        for element in 1..=elements {
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
