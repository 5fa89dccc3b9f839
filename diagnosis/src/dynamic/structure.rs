//! What is left once no catalogued effect helps any more: does the residual depend on anything that the
//! mechanism does? Families of forces without a physical name, each of several shapes of one observable,
//! are screened as the effects are; the strongest families say where the mismatch lives.

use rayon::prelude::*;

use super::data::Data;
use super::effects::{DynamicEffect, Facts, Flow, Parameter, Physics};
use super::estimate::Fitted;
use super::gram::grams;
use super::model::Term;
use super::screen::gained;
use crate::dynamic::data::CHOOSE;
use crate::numerics::Number;
use crate::thresholds::dynamic::gram::MOST_FREE;

/// A force of one shape of one observable.
///
/// Source: Masri & Caughey, A nonparametric identification technique, J. Appl. Mech. 46 (1979).
struct Shape {
    family: usize,
    index: usize,
}

/// The families: the observable in `locations`, the one that multiplies it, and the number of shapes.
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
    Parameter { name: "amount", unit: "1", shape: false },
    Parameter { name: "stroke", unit: "p", shape: true },
    Parameter { name: "speed", unit: "p/s", shape: true },
    Parameter { name: "drive", unit: "u", shape: true },
    Parameter { name: "force", unit: "p/s²", shape: true },
    Parameter { name: "rate", unit: "1/s", shape: true },
    Parameter { name: "duration", unit: "s", shape: true },
];

static SHAPES: [[Shape; 6]; 8] = {
    const fn family(family: usize) -> [Shape; 6] {
        [
            Shape { family, index: 0 },
            Shape { family, index: 1 },
            Shape { family, index: 2 },
            Shape { family, index: 3 },
            Shape { family, index: 4 },
            Shape { family, index: 5 },
        ]
    }
    [family(0), family(1), family(2), family(3), family(4), family(5), family(6), family(7)]
};

impl<T: Number> Physics<T> for Shape {
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let size = |k: usize| parameters[k].value();
        let x = *flow.position * (1.0 / size(1));
        let v = *flow.velocity * (1.0 / size(2));
        let w = *flow.drive * (1.0 / size(3));
        let t = T::from_f64(2.0 * flow.time / size(6) - 1.0);
        // Rises at once and then stands: a smooth sign.
        let sign = |a: T, width: f64| a / (a.abs() + T::from_f64(width));
        let shape = match (self.family, self.index) {
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
        *flow.acceleration = *flow.acceleration - parameters[0] * shape * size(4);
    }
}

const fn facts(states: usize) -> Facts {
    Facts {
        id: "a force without a name",
        title: "Structure",
        parameters: &PARAMETERS,
        states,
        ..Facts::USUAL
    }
}

impl DynamicEffect for Shape {
    fn facts(&self) -> &Facts {
        const FACTS: [Facts; 2] = [facts(0), facts(1)];
        &FACTS[usize::from(self.family >= 6)]
    }
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
    /// Number of shapes.
    pub shapes: usize,
    /// From where to where in the observable; none where that is its whole range.
    pub at: Option<(f64, f64)>,
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
    let mut found: Vec<Structure> = FAMILIES
        .par_iter()
        .enumerate()
        .filter_map(|(family, (variable, times, shapes))| {
            let count = (*shapes).min(MOST_FREE - base);
            if count == 0 {
                return None;
            }
            let model = SHAPES[family][..count].iter().fold(present.model.clone(), |model, shape| {
                let parameters = std::iter::once(0.0).chain(sizes).map(|s: f64| s.max(0.0)).collect();
                let free = (0..PARAMETERS.len()).map(|k| k == 0).collect();
                model.with(Term { effect: shape, parameters, free, probe: true })
            });
            let whole = grams(&model, &present.states, data, whitening).ok()?;
            let lanes: Vec<usize> = (0..base + count).collect();
            let (fitted_gain, gain) = gained(&whole, base, &lanes);
            let rows = whole.rows[CHOOSE].max(1) as f64;
            let part = 1.0 - (-gain / rows).exp();
            Some(Structure { variable, times: *times, part, gain, fitted_gain, shapes: count, at: None })
        })
        .collect();
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found
}
