//! What a routine with terms of further physics is held against: the fitted model itself in `f64`, call by call,
//! written from the definitions of [`fitter::terms`] and knowing nothing of words, with a bound of what `f64` rounds.
//!
//! Every operation of `f64` and of its mathematical library is off by less than 2⁻⁵¹ of its result; a term is a
//! chain of a few of them, counted here as 2⁻⁴⁸ of the largest number in the chain. The play does not enlarge what its
//! input is off; a lag adds one such error a call, of which all but the last 1/(1 − e^(−T/τ)) have faded; a periodic
//! term's solution is off by the residual over 1 − L, L being the steepest slope.

use fitter::error_model::Sensor;
use fitter::terms::{Operator, Periodic, Side, Term};

use super::expression::{Cell, Running};
use crate::physics::{Further, FurtherEncoding, Tree};
use crate::routine::Routine;
use crate::verify::fast_reference::FastReference;

/// What a chain of operations may be off, relative to the largest number in it.
pub(super) const CHAIN: f64 = 1.0 / (1u64 << 48) as f64;

/// A further input as its words are read.
struct Input {
    name: String,
    lsb: f64,
    zero: f64,
    /// Smallest and largest word of its box.
    words: (f64, f64),
}

/// What a term keeps from call to call.
#[derive(Clone, Default)]
struct Kept {
    /// Outputs of the plays, or the lagged value.
    values: Vec<f64>,
    /// The observable at the call before.
    before: f64,
    /// Of an expression.
    cells: Vec<Cell>,
}

/// The model of a routine, somewhere in a sequence of calls.
pub struct Model<'a> {
    fast_reference: &'a FastReference,
    routine: &'a Routine,
    terms: &'a [Term],
    /// Of the terms that are expressions.
    trees: Vec<Option<Tree>>,
    inputs: Vec<Input>,
    period_s: f64,
    /// What one output word is, in the unit of the statistics.
    unit: f64,
    /// The reading by its own words: offset and slope.
    reading: (f64, f64),
    kept: Vec<Kept>,
    calls: u64,
}

/// The exact result of a call in output words, and what the number given here may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// The value.
    pub words: f64,
    /// Its own error.
    pub error: f64,
}

impl<'a> Model<'a> {
    /// The model of a designed routine.
    pub fn new(routine: &'a Routine, fast_reference: &'a FastReference) -> Self {
        let statistic = match routine.physics.sensor {
            Some(Sensor::EddyCurrentPair { .. }) => fitter::units::ARCSEC_PER_RAD,
            _ => 1.0,
        };
        Model {
            fast_reference,
            routine,
            terms: &routine.physics.terms,
            trees: routine.physics.terms.iter().map(|term| routine.physics.tree(term)).collect(),
            inputs: routine.physics.further.iter().map(|f| Input::new(routine, f)).collect(),
            period_s: routine.physics.period_s,
            unit: routine.design.unit.to_f64() * statistic,
            reading: measured_by_word(routine),
            kept: vec![Kept::default(); routine.physics.terms.len()],
            calls: 0,
        }
    }

    /// The next call, the first of a sequence where `begins`: the reading in its own words, and the words of the
    /// further inputs.
    pub fn call(&mut self, begins: bool, reading: f64, further: &[f64]) -> Expected {
        if begins {
            self.calls = 0;
        }
        let base = self.fast_reference.at(reading);
        let (lo, hi) = self.fast_reference.range;
        let limited = if reading >= lo { reading.min(hi) } else { lo };
        let measured = self.reading.0 + self.reading.1 * limited;
        let values: Vec<f64> = self.inputs.iter().zip(further).map(|(input, w)| input.value(*w)).collect();
        let (mut sum, mut size, mut off) = (0.0, 0.0, 0.0);
        for (index, term) in self.terms.iter().enumerate() {
            let mut kept = std::mem::take(&mut self.kept[index]);
            let observe = |name: &str| self.observe(name, measured, &values);
            let calls = (begins, self.calls);
            if let Some(tree) = &self.trees[index] {
                let (cells, observe, period_s) = (&mut kept.cells, &observe, self.period_s);
                let near = Running { cells, next: 0, observe, calls, period_s }.value(tree);
                sum += near.value;
                size += near.value.abs();
                off += near.error;
            } else {
                let (value, largest) = one(term, &observe, &mut kept, calls, self.period_s);
                sum += value;
                size += largest;
            }
            self.kept[index] = kept;
        }
        self.calls += 1;
        let observed = base * self.unit - sum;
        let mut error = self.fast_reference.error * self.unit + (size + observed.abs()) * CHAIN + off;
        let periodic: Vec<(&Periodic, &[f64])> = (self.terms.iter())
            .filter_map(|t| match &t.operator {
                Operator::Periodic(p) => Some((p, t.coefficients.as_slice())),
                _ => None,
            })
            .collect();
        let truth = solve(&periodic, observed, &mut error);
        Expected { words: truth / self.unit, error: error / self.unit }
    }

    fn observe(&self, name: &str, measured: f64, further: &[f64]) -> f64 {
        let given = || self.inputs.iter().position(|input| input.name == name).map(|i| further[i]);
        self.routine.physics.of_reading(name, measured).or_else(given).unwrap_or(f64::NAN)
    }
}

/// The reading, in its unit, by its own words: offset and slope.
pub(super) fn measured_by_word(routine: &Routine) -> (f64, f64) {
    let plan = &routine.plan;
    let per_word = plan.map.slope.to_f64() / plan.reading_word.1.to_f64();
    (plan.map.offset.to_f64() - per_word * plan.reading_word.0.to_f64(), per_word)
}

impl Input {
    fn new(routine: &Routine, further: &Further) -> Self {
        let (lsb, zero) = match further.encoding {
            FurtherEncoding::Q31 => {
                let largest = further.from.abs().max(further.to.abs());
                let power = (-1000..1000).map(|e| 2f64.powi(e)).find(|p| *p >= largest).unwrap_or(1.0);
                (2.0 * power / 2f64.powi(31), 0.0)
            }
            FurtherEncoding::Counts { gain, offset, .. } => (gain, offset),
        };
        let words = further.words(&routine.design.program).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        Input { name: further.observable.clone(), lsb, zero, words }
    }

    fn value(&self, word: f64) -> f64 {
        (word.clamp(self.words.0, self.words.1) - self.zero) * self.lsb
    }
}

/// A term's value and the largest number on the way to it.
fn one(
    term: &Term,
    observe: &dyn Fn(&str) -> f64,
    kept: &mut Kept,
    (begins, calls): (bool, u64),
    period_s: f64,
) -> (f64, f64) {
    let w = term.coefficients[0];
    match &term.operator {
        Operator::Product(product) => {
            let (mut value, mut size) = (w, w.abs());
            for factor in &product.factors {
                let v = observe(&factor.observable);
                value *= (v - factor.mean).powi(factor.power.into());
                size *= (v.abs() + factor.mean.abs()).powi(factor.power.into());
            }
            (value, size)
        }
        Operator::Play(play) => {
            let v = observe(&play.observable);
            if begins {
                kept.values = play.elements.iter().map(|e| e.initial.unwrap_or(v)).collect();
            }
            let (mut value, mut size) = (0.0, 0.0);
            for ((p, e), w) in kept.values.iter_mut().zip(&play.elements).zip(&term.coefficients) {
                *p = p.clamp(v - e.half_width, v + e.half_width);
                value += w * (v - *p);
                // What the observable was off at any call so far.
                size += w.abs() * (v.abs() + p.abs() + e.half_width);
            }
            (value, size)
        }
        Operator::Lag(lag) => {
            let v = observe(&lag.observable);
            if begins {
                (kept.values, kept.before) = (vec![lag.initial.unwrap_or(v)], v);
            } else {
                let ratio = period_s / lag.time_constant_s;
                let gone = -(-ratio).exp_m1();
                let state = kept.values[0];
                let moved = gone * (kept.before - state) + (v - kept.before) * (1.0 - gone / ratio);
                (kept.values[0], kept.before) = (state + moved, v);
            }
            let fading = (calls as f64).min(1.0 + lag.time_constant_s / period_s);
            let size = w.abs() * (v.abs() + kept.values[0].abs() + lag.mean.abs());
            (w * (kept.values[0] - lag.mean), size * (1.0 + 0.25 * fading))
        }
        Operator::Rate(rate) => {
            let v = observe(&rate.observable);
            let before = if begins { v } else { kept.before };
            kept.before = v;
            (w * (v - before) / period_s, w.abs() * (v.abs() + before.abs()) / period_s)
        }
        Operator::Hinge(hinge) => {
            let v = observe(&hinge.observable);
            let beyond = if hinge.side == Side::Above { v - hinge.threshold } else { hinge.threshold - v };
            (w * beyond.max(0.0), w.abs() * (v.abs() + hinge.threshold.abs()))
        }
        Operator::Gaussian(gaussian) => {
            let v = observe(&gaussian.observable);
            let z = (v - gaussian.centre) / gaussian.width;
            let size = 1.0 + (v.abs() + gaussian.centre.abs()) / gaussian.width;
            (w * (-0.5 * z * z).exp(), w.abs() * size)
        }
        Operator::Exponential(e) => {
            let v = observe(&e.observable);
            let v = if v.is_nan() { calls as f64 * period_s } else { v };
            let size = 1.0 + (v.abs() + e.start.abs()) / e.scale;
            let risen = if v < e.start { 0.0 } else { -(-(v - e.start) / e.scale).exp_m1() };
            (w * risen, w.abs() * size)
        }
        Operator::Step(step) => {
            let v = observe(&step.observable);
            // Words compare exactly: within what the conversion rounds, the threshold counts as reached.
            let reached = v >= step.at - 4.0 * f64::EPSILON * (v.abs() + step.at.abs());
            (if reached { w } else { 0.0 }, w.abs())
        }
        // The first is of the result itself and solved in the end, the second is not evaluated here.
        Operator::Periodic(_) | Operator::Expression(_) => (0.0, 0.0),
    }
}

/// Θ + P(Θ) = observed by Newton's method from inside the bracket that the amplitudes give; what it may be off is
/// added to `error`.
fn solve(periodic: &[(&Periodic, &[f64])], observed: f64, error: &mut f64) -> f64 {
    if periodic.is_empty() {
        return observed;
    }
    let at = |truth: f64| {
        periodic.iter().fold((truth - observed, 1.0), |(rest, slope), (p, c)| {
            let (value, rate) = p.value_and_slope(c, truth);
            (rest + value, slope + rate)
        })
    };
    let reach: f64 = periodic.iter().flat_map(|(_, c)| c.iter()).map(|c| c.abs()).sum();
    let (mut low, mut high) = (observed - reach, observed + reach);
    let mut truth = observed;
    for _ in 0..60 {
        let (rest, slope) = at(truth);
        if rest > 0.0 {
            high = truth
        } else {
            low = truth
        }
        let newton = truth - rest / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == truth {
            break;
        }
        truth = next;
    }
    let steepest: f64 = periodic.iter().map(|(p, c)| p.steepest(c)).sum();
    // The phase is a small part of a large number of turns.
    let turned: f64 =
        periodic.iter().map(|(p, c)| p.steepest(c) * observed.abs() + p.period * p.steepest(c)).sum();
    let rounded = (observed.abs() + reach + turned) * CHAIN;
    *error = (*error + at(truth).0.abs() + rounded) / (1.0 - steepest);
    truth
}
