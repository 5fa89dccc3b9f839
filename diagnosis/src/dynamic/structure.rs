//! What is left once no catalogued effect helps any more: does the residual depend on anything that the
//! mechanism does? Families of forces without a physical name, each of several shapes of one observable,
//! are screened as the effects are; the strongest families say where the mismatch lives.

use numerics::parallel;
use physics::number::Number;

use super::data::Data;
use super::effects::{DynamicEffect, Flow, Law, Parameter, amount, shape as size};
use super::estimate::{Fitted, Simulated};
use super::model::Term;
use super::screen::gained;
use crate::dynamic::data::CHOOSE;
use crate::thresholds::dynamic::gram::MOST_FREE;

/// The families: the observable in `locations`, the one that multiplies it, and the number of shapes.
///
/// Source: Masri & Caughey, A nonparametric identification technique, J. Appl. Mech. 46 (1979).
const FAMILIES: [(&str, Option<&str>, usize); 8] = [
    ("position", None, 5),
    ("velocity", None, 5),
    ("velocity", Some("position"), 5),
    ("drive", None, 5),
    ("drive", Some("position"), 5),
    ("t_s", None, 6),
    ("history", None, 3),
    ("frequency_hz", None, 3),
];

/// Amount, then the sizes of position, velocity, drive, gain and rate, and the duration.
const PARAMETERS: [Parameter; 7] = [
    amount("amount", "1"),
    size("stroke", "p"),
    size("speed", "p/s"),
    size("drive", "u"),
    size("force", "p/s²"),
    size("rate", "1/s"),
    size("duration", "s"),
];

/// A force of one shape of one observable.
static SHAPES: [[DynamicEffect; 6]; 8] = {
    const fn force(family: usize, index: usize) -> DynamicEffect {
        DynamicEffect {
            id: "a force without a name",
            title: "Structure",
            law: Law::Shape { family, index },
            parameters: &PARAMETERS,
            states: if family >= 6 { 1 } else { 0 },
            ..DynamicEffect::USUAL
        }
    }
    const fn family(k: usize) -> [DynamicEffect; 6] {
        [force(k, 0), force(k, 1), force(k, 2), force(k, 3), force(k, 4), force(k, 5)]
    }
    [family(0), family(1), family(2), family(3), family(4), family(5), family(6), family(7)]
};

/// The force of shape `index` of a family, against the motion.
#[inline(always)]
pub fn shape<T: Number>(family: usize, index: usize, parameters: &[T], flow: &mut Flow<T>) -> T {
    let size = |k: usize| parameters[k].value();
    let x = *flow.position * (1.0 / size(1));
    let v = *flow.velocity * (1.0 / size(2));
    let w = *flow.drive * (1.0 / size(3));
    let t = T::from_f64(2.0 * flow.time / size(6) - 1.0);
    // Rises at once and then stands: a smooth sign.
    let sign = |a: T, width: f64| a / (a.abs() + T::from_f64(width));
    let shape = match (family, index) {
        (0, 0) => x * x,
        (0, 1) => x * x * x,
        (0, 2) => x * x * x * x,
        (0, 3) => x * x * x * x * x,
        (0, _) => x.abs(),
        (1, 0) => v * v,
        (1, 1) => v * v.abs(),
        (1, 2) => v * v * v,
        (1, 3) => sign(v, 0.1),
        (1, _) => sign(v, 0.7),
        (2, 0) => x * v,
        (2, 1) => x * x * v,
        (2, 2) => x * v * v,
        (2, 3) => x.abs() * v,
        (2, _) => x * x * x * v,
        (3, 0) => w * w,
        (3, 1) => w * w.abs(),
        (3, 2) => w * w * w,
        (3, 3) => sign(w, 0.05),
        (3, _) => sign(w, 0.4),
        (4, 0) => w * x,
        (4, 1) => w * x * x,
        (4, 2) => w.abs() * x,
        (4, 3) => w * w * x,
        (4, _) => w * v,
        (5, 0) => t,
        (5, 1) => t * x,
        (5, 2) => t * v,
        (5, 3) => t * w,
        (5, 4) => t * t * x,
        (5, _) => t * t * w,
        (6, index) => {
            let width = T::from_f64(size(1) * [0.03, 0.15, 0.5][index.min(2)]);
            let (speed, z) = (*flow.velocity, flow.states[0]);
            flow.rates[0] = speed - (speed.abs() * z + speed * z.abs()) * 0.5 / width;
            z / width
        }
        (_, index) => {
            let rate = size(5) * [0.3, 1.0, 3.0][index.min(2)];
            flow.rates[0] = (w - flow.states[0]) * rate;
            flow.states[0]
        }
    };
    parameters[0] * shape * size(4)
}

/// What a family would explain of a residual.
#[derive(Debug, Clone)]
pub struct Structure {
    /// The observable.
    pub variable: &'static str,
    /// The observable that multiplies it.
    pub times: Option<&'static str>,
    /// Part of the residual's variance that it explains on rows that did not fit it.
    pub part: f64,
    /// −2 log likelihood gained there.
    pub gain: f64,
    /// The same where it was fitted.
    pub fitted_gain: f64,
    pub shapes: usize,
    /// From where to where in the observable; none where that is its whole range.
    pub at: Option<(f64, f64)>,
}

impl Structure {
    /// What explains a part of the squared residual of so many rows by so many numbers, wherever it is fitted.
    pub fn of_part(
        (variable, times): (&'static str, Option<&'static str>),
        part: f64,
        rows: usize,
        shapes: usize,
        at: Option<(f64, f64)>,
    ) -> Structure {
        let gain = -(rows as f64) * (1.0 - part).max(1e-12).ln();
        Structure { variable, times, part, gain, fitted_gain: gain, shapes, at }
    }
}

/// All families beside a model, the strongest first.
pub fn structure(present: &Fitted, data: &Data, whitening: &[f64]) -> Vec<Structure> {
    let base = present.model.free();
    let scale = &data.scale;
    let sizes = [
        scale.stroke,
        scale.speed,
        scale.drive,
        (present.model.nominal[2] * scale.drive).abs(),
        scale.rate,
        data.duration_s,
    ];
    let of_family = |family: usize| {
        let (variable, times, shapes) = &FAMILIES[family];
        let count = (*shapes).min(MOST_FREE - base);
        if count == 0 {
            return None;
        }
        let model = SHAPES[family][..count].iter().fold(present.model.clone(), |model, shape| {
            let parameters = std::iter::once(0.0).chain(sizes).map(|s: f64| s.max(0.0)).collect();
            let free = (0..PARAMETERS.len()).map(|k| k == 0).collect();
            model.with(Term { effect: shape, parameters, free, probe: true })
        });
        let whole = model.normal(&present.states, data, whitening).ok()?;
        let lanes: Vec<usize> = (0..base + count).collect();
        let (fitted_gain, gain) = gained(&whole, base, &lanes);
        let rows = whole.rows[CHOOSE].max(1) as f64;
        let part = 1.0 - (-gain / rows).exp();
        Some(Structure { variable, times: *times, part, gain, fitted_gain, shapes: count, at: None })
    };
    let mut found: Vec<Structure> =
        parallel::indices(0..FAMILIES.len(), of_family).into_iter().flatten().collect();
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found
}
