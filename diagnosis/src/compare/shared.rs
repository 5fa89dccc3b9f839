//! What was found in either recording, once each, with its shape in both.

use numerics::{dot, least_squares};

use crate::diagnosis::{FoundTerm, Outcome};
use crate::effects::{Effect, Place, Range};
use crate::generic;
use crate::thresholds::compare::{MAY_BE_AN_EVENT, SAME, SHAPE_STEP};

use super::joined::Joined;

/// An effect, or structure without a name, that was found in at least one of the recordings.
#[derive(Clone)]
pub struct Shared {
    /// The effect; none of structure.
    pub effect: Option<Effect>,
    /// Where it lives.
    pub place: Place,
    /// Its shape in each recording.
    pub shape: [Vec<f64>; 2],
    /// Its shape as the weaker recording has it, where both do.
    pub otherwise: Option<Vec<f64>>,
    /// Its family-wise p-value in each recording in which it was found.
    pub found: [Option<f64>; 2],
    /// The p-value of the difference that it explains, where the recordings show it together and neither does by itself.
    pub together: Option<f64>,
    /// The amplitudes in each recording, as last fitted.
    pub amplitudes: [Vec<f64>; 2],
}

impl Shared {
    /// What was found in one of the recordings (0: then, 1: now).
    pub fn of(term: &FoundTerm, recording: usize) -> Shared {
        let mut found = [None; 2];
        found[recording] = Some(term.p_value);
        Shared {
            effect: term.effect.clone(),
            place: term.place.clone(),
            shape: [term.shape.clone(), term.shape.clone()],
            otherwise: None,
            found,
            together: None,
            amplitudes: [Vec::new(), Vec::new()],
        }
    }

    /// An effect that the recordings show together, in the place of a difference with a p-value.
    pub fn together(effect: &Effect, shape: Vec<f64>, p_value: f64) -> Shared {
        Shared {
            effect: Some(effect.clone()),
            place: effect.place.clone(),
            shape: [shape.clone(), shape],
            otherwise: None,
            found: [None; 2],
            together: Some(p_value),
            amplitudes: [Vec::new(), Vec::new()],
        }
    }

    /// Takes note that it was found in the later recording as well, where it is the stronger or not. Which of an effect's forms
    /// it is (how it began) is each recording's own.
    pub fn found_again(&mut self, term: &FoundTerm, stronger: bool, both: &Joined) {
        self.found[1] = Some(self.found[1].unwrap_or(1.0).min(term.p_value));
        let Some(effect) = &self.effect else { return };
        let then = self.shape[0].clone();
        let with_form_of = |shape: &[f64], form: &[f64]| -> Vec<f64> {
            let ranges = effect.ranges(&both.rows);
            let own =
                shape.iter().zip(form).zip(&ranges).map(|((s, f), range)| if range.whole { *f } else { *s });
            let mixed: Vec<f64> = own.collect();
            let same =
                effect.signature(&both.rows, &mixed).len() == effect.signature(&both.rows, shape).len();
            if same { mixed } else { shape.to_vec() }
        };
        let (taken, other) = if stronger { (&term.shape, &then) } else { (&then, &term.shape) };
        self.shape = [with_form_of(taken, &then), with_form_of(taken, &term.shape)];
        self.otherwise = Some(other.clone());
    }

    /// With the shape that the weaker recording has.
    pub fn with_other_shape(&self) -> Option<Shared> {
        let other = self.otherwise.as_ref()?;
        let effect = self.effect.as_ref()?;
        let mut other_shape = self.clone();
        for shape in &mut other_shape.shape {
            shape.clone_from(other);
        }
        (!effect.begins_at_a_row && other != &self.shape[0]).then_some(other_shape)
    }

    /// The effect's id; none of structure.
    pub fn id(&self) -> Option<&str> {
        self.effect.as_ref().map(|effect| effect.id.as_str())
    }

    /// Its columns over both recordings.
    pub fn columns(&self, both: &Joined) -> Vec<Vec<f64>> {
        let Some(effect) = &self.effect else {
            let families = generic::families(&both.rows);
            let here = families.into_iter().find(|family| family.place == self.place);
            return here.and_then(|family| family.groups.into_iter().next_back()).unwrap_or_default();
        };
        let [then, now] = &self.shape;
        let mut columns = both.columns(|rows| effect.signature(rows, then));
        if then != now {
            let later = both.columns(|rows| effect.signature(rows, now));
            columns
                .iter_mut()
                .zip(later)
                .for_each(|(c, l)| c[both.split..].copy_from_slice(&l[both.split..]));
        }
        columns
    }

    /// The shape parameters that can be fitted.
    pub fn free_shapes(&self, both: &Joined) -> Vec<(usize, Range)> {
        let Some(effect) = self.effect.as_ref().filter(|e| !e.shape_follows && !e.begins_at_a_row) else {
            return Vec::new();
        };
        let ranges = effect.ranges(&both.rows).into_iter().enumerate();
        ranges
            .filter(|(j, range)| !range.whole && range.high > range.low && *j < self.shape[0].len())
            .collect()
    }

    /// The size of shape parameter `j` in a recording, or half its range, in the parameter's unit.
    pub fn size(&self, j: usize, range: &Range, recording: usize) -> f64 {
        if range.logarithmic { self.shape[recording][j] } else { 0.5 * (range.high - range.low) }
    }

    /// The recording that has more of it (0: then, 1: now).
    pub fn stronger(&self) -> usize {
        let [then, now] = self.amplitudes.each_ref().map(|amplitudes| dot(amplitudes, amplitudes));
        usize::from(now > then)
    }

    /// What it adds changes so with shape parameter `j` at the amplitudes of each recording.
    pub fn derivative(&self, both: &Joined, j: usize, range: &Range, amplitudes: [&Vec<f64>; 2]) -> Vec<f64> {
        let Some(effect) = &self.effect else { return vec![0.0; both.rows.len()] };
        let mut derivative = vec![0.0; both.rows.len()];
        for (recording, rows) in [(0, 0..both.split), (1, both.split..both.rows.len())] {
            let at = |by: f64| {
                let mut shape = self.shape[recording].clone();
                shape[j] = (shape[j] + by).clamp(range.low, range.high);
                (shape[j], both.columns(|rows| effect.signature(rows, &shape)))
            };
            let step = SHAPE_STEP
                * if range.logarithmic { self.shape[recording][j] } else { range.high - range.low };
            let ((high, above), (low, below)) = (at(step), at(-step));
            if high <= low {
                continue;
            }
            for ((a, b), amplitude) in above.iter().zip(&below).zip(amplitudes[recording]) {
                for i in rows.clone() {
                    derivative[i] += amplitude * (a[i] - b[i]) / (high - low);
                }
            }
        }
        derivative
    }
}

/// What was found of the device in either recording, once each; what cannot be compared is said.
pub fn shared(outcomes: &[Outcome; 2], both: &Joined, notes: &mut Vec<String>) -> Vec<Shared> {
    let mut all: Vec<Shared> = Vec::new();
    for (recording, outcome) in outcomes.iter().enumerate() {
        for term in &outcome.found {
            if let Some(effect) = &term.effect {
                if effect.of_one_time {
                    continue;
                }
                if let Err(reason) = effect.testable(&both.rows) {
                    notes.push(format!("{} is not compared: {reason} in both recordings", effect.id));
                    continue;
                }
            }
            let new = Shared::of(term, recording);
            let columns = new.columns(both);
            if columns.is_empty() {
                continue;
            }
            // Of what can be there more than once, what says nearly the same is one.
            let once = new.effect.as_ref().is_some_and(|effect| !effect.repeatable);
            let same = |known: &&mut Shared| {
                known.place == new.place
                    && known.id() == new.id()
                    && (once || alike(&columns, &known.columns(both)))
            };
            match all.iter_mut().find(same) {
                Some(known) if recording == 1 => {
                    // Where it is stronger its shape is known better.
                    let stronger = term.explained > strength(&outcomes[0], known);
                    known.found_again(term, stronger, both);
                }
                Some(_) => {}
                None => all.push(new),
            }
        }
    }
    all.retain(|shared| !happened_once(outcomes, shared));
    all
}

/// Whether something that was found in one recording only may as well have happened at one time of it.
fn happened_once(outcomes: &[Outcome; 2], shared: &Shared) -> bool {
    let (outcome, shape) = match shared.found {
        [Some(_), None] => (&outcomes[0], &shared.shape[0]),
        [None, Some(_)] => (&outcomes[1], &shared.shape[1]),
        _ => return false,
    };
    let is_this = |term: &&FoundTerm| {
        term.effect.as_ref().map(|effect| effect.id.as_str()) == shared.id() && term.shape == *shape
    };
    outcome.found.iter().find(is_this).is_some_and(|term| term.reach < MAY_BE_AN_EVENT)
}

/// What a recording has of an effect, in units of its noise.
fn strength(outcome: &Outcome, shared: &Shared) -> f64 {
    let own = outcome.found.iter().filter(|term| term.effect.as_ref().map(|e| e.id.as_str()) == shared.id());
    own.map(|term| term.explained).fold(0.0, f64::max)
}

/// Whether columns say nearly what others say.
fn alike(columns: &[Vec<f64>], others: &[Vec<f64>]) -> bool {
    let left: f64 = columns.iter().map(|column| least_squares(others, column).rss).sum();
    left < SAME * columns.iter().map(|column| dot(column, column)).sum::<f64>()
}
