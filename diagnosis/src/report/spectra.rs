//! Spectra: the recorded position, what both simulations leave of it, noise and distortion.

use super::Section;
use super::draw::{Curve, LOGARITHMIC, Role, curves};
use crate::dynamic::DynamicRecording;
use crate::dynamic::diagnose::Predicted;
use crate::dynamic::linear::plan::Plan;
use crate::dynamic::linear::verdict::responses;
use crate::dynamic::spectrum::band::power_spectrum;
use crate::dynamic::spectrum::distortion::free_lines;
use crate::dynamic::spectrum::experiments::segment_length;
use crate::dynamic::spectrum::growth::{Growth, growth, size};
use crate::thresholds::report::spectra::POINTS;

/// Titles and charts.
pub fn charts(recording: &DynamicRecording, own: &Predicted, unit: &str) -> Vec<(String, String)> {
    let plan = Plan::new(recording);
    let mut charts = Vec::new();
    for group in &plan.groups {
        let rows: Vec<_> = group.fitted.iter().chain(&group.held).cloned().collect();
        let Some(first) = rows.first() else { continue };
        let length = plan.period.unwrap_or_else(|| segment_length(first.len()));
        let sum = |of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            let mut total = vec![0.0; length / 2 + 1];
            for run in &rows {
                for output in 0..recording.positions.len() {
                    let record: Vec<f64> = run.clone().map(|row| of(output, row)).collect();
                    for (t, p) in total.iter_mut().zip(power_spectrum(&record, length)) {
                        *t += p / rows.len() as f64;
                    }
                }
            }
            total
        };
        let predicted = |columns: &[Vec<f64>], output: usize, row: usize| {
            columns.get(output).map_or(f64::NAN, |c| c[row])
        };
        let recorded = sum(&|o, r| recording.positions[o][r]);
        let before = sum(&|o, r| recording.positions[o][r] - predicted(&own.before, o, r));
        let after = sum(&|o, r| recording.positions[o][r] - predicted(&own.after, o, r));
        let unit_hz = 1.0 / (length as f64 * recording.step_s);
        let mut drawn = vec![
            Curve { role: Role::Recorded, points: levels(&recorded, unit_hz) },
            Curve { role: Role::Before, points: levels(&before, unit_hz) },
            Curve { role: Role::After, points: levels(&after, unit_hz) },
        ];
        let data = plan.experiments(recording, &rows);
        let noise = data.each.iter().map(|e| e.noise.as_ref()).collect::<Option<Vec<_>>>();
        if let Some(noise) = noise.filter(|n| !n.is_empty()) {
            let mut total = vec![0.0; length / 2 + 1];
            for one in &noise {
                for (line, &k) in data.lines.iter().enumerate() {
                    let own = &one[line * data.outputs..(line + 1) * data.outputs];
                    // Variance of the mean over periods, one line: two sides, and as of single periods.
                    let periods = (rows[0].len() / length).max(1) as f64;
                    total[k] += 2.0 * periods * own.iter().sum::<f64>() / noise.len() as f64;
                }
            }
            drawn.push(Curve { role: Role::Noise, points: levels(&total, unit_hz) });
        }
        let title = if plan.groups.len() > 1 {
            format!("Spectrum at amplitude {}", super::digits(group.amplitude))
        } else {
            "Spectrum".to_string()
        };
        let label = format!("level (dB re 1 {unit} rms per line)");
        charts.extend(curves((LOGARITHMIC, &label), &drawn).map(|svg| (title, svg)));
    }
    charts.truncate(4);
    charts
}

/// Mean levels in dB over bins of equal ratio.
fn levels(power: &[f64], unit_hz: f64) -> Vec<(f64, f64)> {
    let first = unit_hz.log10();
    let last = (power.len().max(2) as f64 * unit_hz).log10();
    let mut sums = vec![(0.0, 0.0, 0usize); POINTS];
    for (k, p) in power.iter().enumerate().skip(1).filter(|(_, p)| **p > 0.0) {
        let f = (k as f64 * unit_hz).log10();
        let bin = (((f - first) / (last - first) * POINTS as f64) as usize).min(POINTS - 1);
        sums[bin].0 += f;
        sums[bin].1 += p;
        sums[bin].2 += 1;
    }
    sums.iter().filter(|s| s.2 > 0).map(|s| (s.0 / s.2 as f64, 10.0 * (s.1 / s.2 as f64).log10())).collect()
}

/// Distortion on the lines that the multisine leaves free: even and odd.
pub fn free(recording: &DynamicRecording, unit: &str) -> Option<Section> {
    let plan = Plan::new(recording);
    let length = plan.period?;
    let (even, odd) =
        free_lines(&recording.drives, &recording.positions, &recording.runs, length, recording.step_s);
    if even.len() + odd.len() < 8 {
        return None;
    }
    let levels = |lines: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let every = lines.len().div_ceil(POINTS).max(1);
        let group = |c: &[(f64, f64)]| {
            let n = c.len() as f64;
            let mean = |of: fn(&(f64, f64)) -> f64| c.iter().map(of).sum::<f64>() / n;
            (mean(|l| l.0).log10(), 10.0 * (2.0 * mean(|l| l.1)).max(1e-300).log10())
        };
        lines.chunks(every).map(group).collect()
    };
    let drawn = [
        Curve { role: Role::Before, points: levels(&even) },
        Curve { role: Role::After, points: levels(&odd) },
    ];
    let label = format!("level (dB re 1 {unit} rms per line)");
    let svg = curves((LOGARITHMIC, &label), &drawn)?;
    Some(Section {
        title: "Distortion on the free lines",
        legend: vec![("before", "even".into()), ("after", "odd".into())],
        note: ".".into(),
        charts: vec![("Lines that the drive leaves free".into(), svg)],
    })
}

/// The response around the strongest resonance, at the lowest and the highest amplitude.
pub fn shift(recording: &DynamicRecording) -> Option<Section> {
    let all = responses(recording, &Plan::new(recording));
    let [(low, first), .., (high, last)] = all.as_slice() else { return None };
    let (a, b) = (size(first), size(last));
    let top = (0..a.len()).max_by(|i, j| a[*i].total_cmp(&a[*j]))?;
    let range = top - top / 4..(top + top / 4).min(a.len());
    let every = (range.len() / POINTS).max(1);
    let points = |g: &[f64]| -> Vec<(f64, f64)> {
        range.clone().step_by(every).map(|k| (first.frequency_hz[k], 10.0 * g[k].log10())).collect()
    };
    let drawn =
        [Curve { role: Role::Before, points: points(&a) }, Curve { role: Role::After, points: points(&b) }];
    let svg = curves(("frequency (Hz)", "gain (dB)"), &drawn)?;
    let amplitude = |value: f64| format!("amplitude {}", super::digits(value));
    Some(Section {
        title: "Response at the strongest resonance",
        legend: vec![("before", amplitude(*low)), ("after", amplitude(*high))],
        note: ".".into(),
        charts: vec![("At the lowest and the highest amplitude".into(), svg)],
    })
}

/// Gain and resonances by amplitude, where there are several.
pub fn growth_rows(recording: &DynamicRecording) -> Vec<Growth> {
    let all = responses(recording, &Plan::new(recording));
    if all.len() < 2 { Vec::new() } else { growth(&all) }
}
