//! The parameters of what changed, then and now, with intervals that allow for everything else.

use numerics::{add_scaled, centred, dot};
use serde::Serialize;

use crate::calibrate::log_tail;
use crate::effects::Reading;
use crate::thresholds::NORMAL_95;

use super::design::{Design, Fitted, What, White};

/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy, Serialize)]
#[non_exhaustive]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

impl Estimate {
    pub(super) fn new(value: f64, half: f64) -> Estimate {
        Estimate { value, ci95: [value - half, value + half] }
    }
}

/// One parameter then and now.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// In the earlier recording; none where only the difference is determined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub then: Option<Estimate>,
    /// In the later one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub now: Option<Estimate>,
    /// Now less then; of a ratio the ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<Estimate>,
}

impl Quantity {
    /// A ratio of now to then.
    pub(super) fn ratio(name: &str, value: f64, ci95: [f64; 2]) -> Quantity {
        let difference = Some(Estimate { value, ci95 });
        Quantity { name: name.into(), unit: "1".into(), then: None, now: None, difference }
    }
}

/// The parameters of a part that differs.
pub fn quantities(design: &Design, fitted: &Fitted, what: What, wide: f64) -> Vec<Quantity> {
    match what {
        What::Gain => gain(design, fitted, wide),
        What::Base => Vec::new(),
        What::Amplitude(k) | What::Shape(k, _) => readings(design, fitted, k, wide),
    }
}

/// The difference of the slope, in the error's unit per unit of the angle.
fn gain(design: &Design, fitted: &Fitted, wide: f64) -> Vec<Quantity> {
    let Some(part) = design.part(What::Gain) else { return Vec::new() };
    let Some([k]) = fitted.of(design, part).1.as_deref().and_then(|d| <[usize; 1]>::try_from(d).ok()) else {
        return Vec::new();
    };
    let (theta, column) = (centred(&design.both.rows.theta), centred(&design.parts[part].columns[0]));
    let per = dot(&theta, &column) / dot(&theta, &theta);
    let n = fitted.solution.coefficients.len();
    let error = fitted.solution.inverse[k * n + k].max(0.0).sqrt();
    let difference = Estimate::new(fitted.solution.coefficients[k] * per, half(error * per.abs(), wide));
    let (name, unit) = ("gain".into(), "1".into());
    vec![Quantity { name, unit, then: None, now: None, difference: Some(difference) }]
}

/// The reported parameters of an effect, with intervals by the first derivatives.
fn readings(design: &Design, fitted: &Fitted, k: usize, wide: f64) -> Vec<Quantity> {
    let shared = &design.shared[k];
    let Some(effect) = &shared.effect else { return Vec::new() };
    let involved: Vec<(What, Vec<usize>, Option<Vec<usize>>)> = (0..design.parts.len())
        .filter(|part| design.parts[*part].what.effect() == Some(k))
        .map(|part| {
            let (common, differences) = fitted.of(design, part);
            (design.parts[part].what, common, differences)
        })
        .collect();
    // The parameters of both recordings by the coefficients of the fit.
    let at = |c: &[f64]| -> [Vec<Reading>; 2] {
        let mut shape = shared.shape.clone();
        let mut amplitudes = [Vec::new(), Vec::new()];
        for (what, common, differences) in &involved {
            let then: Vec<f64> = common.iter().map(|i| c[*i]).collect();
            let more = |i: usize| differences.as_ref().map_or(0.0, |d| c[d[i]]);
            let now: Vec<f64> = then.iter().enumerate().map(|(i, v)| v + more(i)).collect();
            match what {
                What::Shape(_, j) => {
                    shape[0][*j] += then[0];
                    shape[1][*j] += now[0];
                }
                _ => amplitudes = [then, now],
            }
        }
        [0, 1].map(|r| effect.readings(&design.both.rows, &shape[r], &amplitudes[r]))
    };
    let (coefficients, n) = (&fitted.solution.coefficients, fitted.solution.coefficients.len());
    let all: Vec<usize> =
        involved.iter().flat_map(|(_, c, d)| c.iter().chain(d.iter().flatten())).copied().collect();
    let [then, now] = at(coefficients);
    let error = |i: usize| fitted.solution.inverse[i * n + i].max(0.0).sqrt();
    // By every coefficient the change of every parameter: then, now, now less then.
    let slopes: Vec<Vec<[f64; 3]>> = all
        .iter()
        .map(|i| {
            let step = 0.1 * error(*i);
            let moved = |by: f64| {
                let mut c = coefficients.clone();
                c[*i] += by;
                at(&c)
            };
            let ([a, b], [c, d]) = (moved(step), moved(-step));
            let slope = |k: usize| {
                let (then, now) =
                    ((a[k].value - c[k].value) / (2.0 * step), (b[k].value - d[k].value) / (2.0 * step));
                if step > 0.0 { [then, now, now - then] } else { [0.0; 3] }
            };
            (0..then.len()).map(slope).collect()
        })
        .collect();
    let spread = |k: usize, of: usize| {
        let variance: f64 = (0..all.len() * all.len())
            .map(|ij| {
                let (i, j) = (ij / all.len(), ij % all.len());
                slopes[i][k][of] * fitted.solution.inverse[all[i] * n + all[j]] * slopes[j][k][of]
            })
            .sum();
        half(variance.max(0.0).sqrt(), wide)
    };
    // What the recordings show together has a shape, but how strong it is in each of them nobody knows.
    let twice: Vec<f64> = shared.amplitudes[1].iter().map(|amplitude| 2.0 * amplitude).collect();
    let twice = effect.readings(&design.both.rows, &shared.shape[1], &twice);
    let once = effect.readings(&design.both.rows, &shared.shape[1], &shared.amplitudes[1]);
    let of_shape = |k: usize| (twice[k].value - once[k].value).abs() < 0.5 * once[k].value.abs();
    let one = |(k, (a, b)): (usize, (&Reading, &Reading))| {
        let known = |value: f64, of: usize| {
            let known = shared.together.is_none() || of_shape(k);
            known.then(|| Estimate::new(value, spread(k, of)))
        };
        Quantity {
            name: a.name.clone(),
            unit: a.unit.clone(),
            then: known(a.value, 0),
            now: known(b.value, 1),
            difference: Some(Estimate::new(b.value - a.value, spread(k, 2))),
        }
    };
    then.iter().zip(&now).enumerate().map(one).collect()
}

/// The p-value that a part's amplitudes are zero in a recording.
pub fn presence(design: &Design, fitted: &Fitted, part: usize, recording: usize) -> f64 {
    let (common, differences) = fitted.of(design, part);
    let n = fitted.solution.coefficients.len();
    let lanes = |k: usize| -> Vec<usize> {
        let later = differences.as_ref().filter(|_| recording == 1);
        std::iter::once(common[k]).chain(later.map(|d| d[k])).collect()
    };
    // The strongest of the amplitudes, for each of which it was looked.
    let square = |k: usize| -> f64 {
        let lanes = lanes(k);
        let value: f64 = lanes.iter().map(|i| fitted.solution.coefficients[*i]).sum();
        let variance: f64 = lanes
            .iter()
            .flat_map(|i| lanes.iter().map(move |j| (i, j)))
            .map(|(i, j)| fitted.solution.inverse[i * n + j])
            .sum();
        if variance > 0.0 { value * value / variance } else { 0.0 }
    };
    let most = (0..common.len()).map(square).fold(0.0, f64::max);
    (common.len() as f64 * (-log_tail(most, 1)).exp()).min(1.0)
}

/// Adds to a difference, one value per row of both recordings in their unit, what the shapes of effect `k` make of it: where
/// they differ already, and where a fit moves them at amplitudes that differ.
pub fn add_shapes(design: &Design, fitted: &Fitted, k: usize, difference: &mut [f64]) {
    let (shared, both) = (&design.shared[k], design.both);
    let (Some(effect), [then, now]) = (&shared.effect, &shared.shape) else { return };
    let before = &shared.amplitudes[0];
    if then != now {
        let [as_then, as_now] = [then, now].map(|shape| both.columns(|rows| effect.signature(rows, shape)));
        for ((a, b), amplitude) in as_then.iter().zip(&as_now).zip(before) {
            add_scaled(difference, *amplitude, b);
            add_scaled(difference, -amplitude, a);
        }
    }
    if !fitted.changed.iter().any(|part| design.parts[*part].what == What::Amplitude(k)) {
        return;
    }
    for (j, range) in shared.free_shapes(both) {
        let Some(part) = design.part(What::Shape(k, j)) else { continue };
        let moved = fitted.solution.coefficients[fitted.of(design, part).0[0]];
        add_scaled(difference, moved, &design.parts[part].columns[0]);
        add_scaled(difference, -moved, &shared.derivative(both, j, &range, [before, before]));
    }
}

/// The smallest difference of a part that would have been seen: its rms over the later recording, and the same of
/// its one parameter. None where nothing of it is determined.
pub fn smallest(
    design: &Design,
    fitted: &Fitted,
    white: &White,
    part: usize,
    visible: impl Fn(usize) -> f64,
) -> Option<(f64, Option<(String, f64)>)> {
    let mut changed = fitted.changed.clone();
    if !changed.contains(&part) {
        changed.push(part);
    }
    let wider = design.fit(white, &changed);
    let lanes = wider.of(design, part).1?;
    let n = wider.solution.coefficients.len();
    let at = |i: usize, j: usize| wider.solution.inverse[lanes[i] * n + lanes[j]];
    let rank = (0..lanes.len()).filter(|k| at(*k, *k) > 0.0).count();
    if rank == 0 {
        return None;
    }
    let columns: Vec<Vec<f64>> =
        design.parts[part].columns.iter().map(|c| centred(&c[design.both.split..])).collect();
    let rows = columns[0].len();
    let variance: f64 = (0..lanes.len())
        .flat_map(|i| (0..lanes.len()).map(move |j| (i, j)))
        .map(|(i, j)| at(i, j) * dot(&columns[i], &columns[j]) / rows as f64)
        .sum();
    let length = visible(rank);
    let parameter = match design.parts[part].what {
        What::Amplitude(k) if rank == 1 && lanes.len() == 1 => {
            let effect = design.shared[k].effect.as_ref()?;
            let of =
                |amplitude: f64| effect.readings(&design.both.rows, &design.shared[k].shape[1], &[amplitude]);
            let (with, without) = (of(length * at(0, 0).sqrt()), of(0.0));
            let first = with.first().zip(without.first());
            first.map(|(with, without)| (with.name.clone(), (with.value - without.value).abs()))
        }
        _ => None,
    };
    Some((length * (variance / rank as f64).max(0.0).sqrt(), parameter))
}

/// Half width of a normal 95 % interval.
fn half(error: f64, wide: f64) -> f64 {
    NORMAL_95 * wide * error
}
