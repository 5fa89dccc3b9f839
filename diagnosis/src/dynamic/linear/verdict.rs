//! What is said of a recording of a linear nominal: where it differs, what it is called, and by how much.

use numerics::mean_and_error;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::looped::{Looped, Stretch};
use super::modal::Modal;
use super::nominal;
use super::plan::{Group, Plan};
use super::sensitivity;
use crate::dynamic::DynamicRecording;
use crate::dynamic::spectrum::growth::{Growth, growth};
use crate::dynamic::spectrum::{Experiments, Response, response};
use crate::thresholds::dynamic::linear::verdict::{BLOCKS, HELD, OCTAVE, SMALLEST, WORTH};
use crate::verdict::{Location, NamedEffect, Parameter};

/// Gain of one model over another on stretches: the part of the residual's power that is gone, and the
/// probability of that by chance (paired by blocks, Student's t on the logarithm).
pub fn gain(before: &Looped, after: &Looped, stretches: &[Stretch]) -> Option<(f64, f64)> {
    let (mut logs, mut powers) = (Vec::new(), [0.0, 0.0]);
    for stretch in stretches {
        let (a, b) = (blocks(before, stretch)?, blocks(after, stretch)?);
        for (a, b) in a.iter().zip(&b) {
            logs.push((a / b.max(f64::MIN_POSITIVE)).ln());
            powers[0] += stretch.weight * stretch.weight * a;
            powers[1] += stretch.weight * stretch.weight * b;
        }
    }
    let (mean, error) = mean_and_error(&logs);
    let t = mean / error.max(1e-12);
    let p = StudentsT::new(0.0, 1.0, (logs.len() as f64 - 1.0).max(1.0)).map_or(1.0, |d| d.cdf(-t));
    Some((1.0 - powers[1] / powers[0].max(f64::MIN_POSITIVE), p.max(SMALLEST)))
}

/// Whether a gain is worth a name.
pub fn worth(gain: (f64, f64)) -> bool {
    gain.0 > WORTH && gain.1 < 1e-4
}

/// Residual power in blocks of the scored rows.
fn blocks(model: &Looped, stretch: &Stretch) -> Option<Vec<f64>> {
    let y = sensitivity::predict(model, stretch)?;
    let first = stretch.skip * model.linear.outputs;
    let rest: Vec<f64> =
        y[first..].iter().zip(&stretch.position[first..]).map(|(a, b)| (a - b).powi(2)).collect();
    Some(rest.chunks(rest.len().div_ceil(BLOCKS).max(1)).map(|c| c.iter().sum()).collect())
}

/// Responses of every amplitude on common lines; empty where the runs of one do not determine a response.
pub fn responses(recording: &DynamicRecording, plan: &Plan) -> Vec<(f64, Response)> {
    let all: Vec<(f64, Experiments)> =
        plan.groups.iter().map(|g| (g.amplitude, plan.experiments(recording, &g.rows()))).collect();
    let determined = all.iter().all(|(_, d)| d.each.len() > d.inputs);
    let common = all.windows(2).all(|w| w[0].1.lines == w[1].1.lines);
    if !determined || !common {
        return Vec::new();
    }
    all.iter().map(|(a, d)| (*a, response(d))).collect()
}

/// Where the linear model's residual lies: on the amplitude, and on which frequencies.
pub fn locations(
    recording: &DynamicRecording,
    plan: &Plan,
    linear: &Modal,
    responses: &[(f64, Response)],
) -> Vec<Location> {
    let mut found = Vec::new();
    let rows: Vec<_> = plan.groups.iter().flat_map(Group::rows).collect();
    let data = plan.experiments(recording, &rows);
    let left = nominal::error(linear, &data).powi(2);
    if let ([(from, _), .., (to, _)], true) = (responses, left > 0.0) {
        // A response of its own for every amplitude: what that leaves of the residual.
        let parts: Vec<f64> = responses
            .iter()
            .filter_map(|(_, r)| {
                Some(
                    r.residual.as_ref()?.iter().sum::<f64>()
                        / r.power.iter().sum::<f64>().max(f64::MIN_POSITIVE),
                )
            })
            .collect();
        let own = parts.iter().sum::<f64>() / parts.len().max(1) as f64;
        let share = (1.0 - own / left).clamp(0.0, 1.0);
        let count = (data.lines.len() * data.outputs) as f64;
        found.push(Location {
            variable: "amplitude".into(),
            times: None,
            from: *from,
            to: *to,
            share,
            p_value: chance(left / own.max(f64::MIN_POSITIVE), count),
        });
    }
    if let Some(band) = strongest_band(linear, &data) {
        found.push(band);
    }
    found.retain(|l| l.p_value < 1e-3);
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found
}

/// Probability that a ratio of mean powers over `count` lines arises by chance: its logarithm is normal with
/// variance 4/count for complex residuals in numerator and denominator.
fn chance(ratio: f64, count: f64) -> f64 {
    let z = ratio.max(1e-12).ln() / (4.0 / count.max(1.0)).sqrt();
    Normal::new(0.0, 1.0).map_or(1.0, |d| d.cdf(-z)).max(SMALLEST)
}

/// The narrowest run of third octaves that holds most of the residual.
fn strongest_band(linear: &Modal, data: &Experiments) -> Option<Location> {
    let frequencies = data.frequencies();
    let first = *frequencies.first()?;
    let band_of = |f: f64| ((f / first).log2() / OCTAVE) as usize;
    let count = band_of(*frequencies.last()?) + 1;
    let mut power = vec![0.0; count];
    let mut lines = vec![0usize; count];
    for (line, &z) in data.points().iter().enumerate() {
        let band = band_of(frequencies[line]);
        lines[band] += 1;
        data.left(line, &linear.response(z)).for_each(|(rest, _)| power[band] += rest);
    }
    let all: f64 = power.iter().sum();
    let mut best: Option<(usize, usize, f64)> = None;
    for from in 0..count {
        let mut sum = 0.0;
        for (to, band) in power.iter().enumerate().skip(from) {
            sum += band;
            if sum >= HELD * all {
                let better = best.is_none_or(|(a, b, s)| (to - from, -sum) < (b - a, -s));
                if better {
                    best = Some((from, to, sum));
                }
                break;
            }
        }
    }
    let (from, to, sum) = best?;
    let inside: usize = lines[from..=to].iter().sum();
    let expected = inside as f64 / frequencies.len() as f64;
    let share = sum / all.max(f64::MIN_POSITIVE);
    let lower = |band: usize| first * 2f64.powf(OCTAVE * band as f64);
    Some(Location {
        variable: "frequency_hz".into(),
        times: None,
        from: lower(from),
        to: lower(to + 1).min(*frequencies.last()?),
        share,
        p_value: chance(share / expected.max(f64::MIN_POSITIVE), inside as f64),
    })
}

/// The named hysteresis with what it does to gain and resonance.
pub fn hysteresis(
    after: &Looped,
    gain: (f64, f64),
    responses: &[(f64, Response)],
    exponent_error: f64,
) -> NamedEffect {
    let exponent = 1.0 + after.operator.exponent;
    let mut parameters = vec![Parameter::normal("growth_exponent", exponent, exponent_error, "1")];
    let followed: Vec<Growth> = growth(responses);
    if let [first, .., last] = followed.as_slice() {
        let percent = 100.0 * (last.gain - 1.0);
        parameters.push(Parameter::normal("gain_growth_percent", percent, 100.0 * last.gain_error, "%"));
        let shifts = first.resonances_hz.iter().zip(&last.resonances_hz);
        if let Some((from, to)) = shifts.max_by(|a, b| (a.1 - a.0).abs().total_cmp(&(b.1 - b.0).abs())) {
            // A peak is read to a fraction of a line.
            let lines = responses[0].1.frequency_hz.windows(2).map(|w| w[1] - w[0]);
            let line = lines.fold(f64::INFINITY, f64::min);
            parameters.push(Parameter::normal("resonance_hz", *from, 0.5 * line, "Hz"));
            parameters.push(Parameter::normal("resonance_shift_hz", to - from, 0.7 * line, "Hz"));
        }
    }
    NamedEffect {
        id: super::file::ID.into(),
        kind: crate::verdict::CATALOGUED,
        title: "hysteresis of the actuator (Rayleigh)".into(),
        formula: String::new(),
        p_value: gain.1,
        share: gain.0.clamp(0.0, 1.0),
        parameters,
        alternatives: Vec::new(),
        runtime_correctable: false,
        form: crate::verdict::Form::default(),
    }
}
