//! Spectra: the recorded position, what both simulations leave of it, noise and distortion.

use fitter::report::{Chart, Colour, Figure, Mark, Scale, Series};

use super::Section;
use crate::dynamic::DynamicRecording;
use crate::dynamic::diagnose::Predicted;
use crate::dynamic::linear::plan::{Group, Plan};
use crate::dynamic::linear::verdict::responses;
use crate::dynamic::spectrum::Response;
use crate::dynamic::spectrum::band::power_spectrum;
use crate::dynamic::spectrum::distortion::free_lines;
use crate::dynamic::spectrum::experiments::segment_length;
use crate::dynamic::spectrum::growth::{Growth, growth};
use crate::thresholds::report::spectra::{LEAST_LINES, MOST_AMPLITUDES, POINTS, RESONANCE};

/// A spectrum over the frequency in decades.
fn spectrum(name: &str, title: &str, unit: &str, series: Vec<Series>) -> Figure {
    let chart = Chart {
        label: "Level of each line against the frequency",
        x: "frequency (Hz, logarithmic)".to_string(),
        y: format!("level (dB re 1 {unit} rms per line)"),
        series,
    };
    Figure::scaled(name, title, String::new(), chart, Scale::Decades)
}

/// A spectrum at every amplitude.
pub fn charts(recording: &DynamicRecording, own: &Predicted, unit: &str) -> Vec<Figure> {
    let plan = Plan::new(recording);
    let groups = plan.groups.iter().take(MOST_AMPLITUDES).enumerate();
    let figures = groups.map(|(index, group)| {
        let title = match plan.groups.len() {
            1 => "Spectrum".to_string(),
            _ => format!("Spectrum at amplitude {}", super::digits(group.amplitude)),
        };
        spectrum(&format!("spectrum-{}", index + 1), &title, unit, levels_of(recording, own, &plan, group))
    });
    figures.collect()
}

/// Levels of the position that was recorded, of what both simulations leave, and of the noise where periods tell it.
fn levels_of(recording: &DynamicRecording, own: &Predicted, plan: &Plan, group: &Group) -> Vec<Series> {
    let rows = group.rows();
    let Some(first) = rows.first() else { return Vec::new() };
    let length = plan.period.unwrap_or_else(|| segment_length(first.len()));
    let unit_hz = 1.0 / (length as f64 * recording.step_s);
    let of = |name: &str, colour, value: &dyn Fn(usize, usize) -> f64| {
        let mut total = vec![0.0; length / 2 + 1];
        for run in &rows {
            for output in 0..recording.positions.len() {
                let record: Vec<f64> = run.clone().map(|row| value(output, row)).collect();
                for (t, p) in total.iter_mut().zip(power_spectrum(&record, length)) {
                    *t += p / rows.len() as f64;
                }
            }
        }
        Series::new(name, Mark::Curve, colour, levels(&total, unit_hz))
    };
    let left = |columns: &[Vec<f64>], output: usize, row: usize| {
        recording.positions[output][row] - columns.get(output).map_or(f64::NAN, |c| c[row])
    };
    let mut drawn = vec![
        of("recorded", Colour::Ink, &|o, r| recording.positions[o][r]),
        of("left before", Colour::First, &|o, r| left(&own.before, o, r)),
        of("left after", Colour::Second, &|o, r| left(&own.after, o, r)),
    ];
    let data = plan.experiments(recording, &rows);
    let noise = data.each.iter().map(|e| e.noise.as_ref()).collect::<Option<Vec<_>>>();
    if let Some(noise) = noise.filter(|n| !n.is_empty()) {
        let mut total = vec![0.0; length / 2 + 1];
        for one in &noise {
            for (line, &k) in data.lines.iter().enumerate() {
                let own = &one[line * data.outputs..(line + 1) * data.outputs];
                // Variance of the mean over periods, one line: two sides, and as of single periods.
                let periods = (first.len() / length).max(1) as f64;
                total[k] += 2.0 * periods * own.iter().sum::<f64>() / noise.len() as f64;
            }
        }
        drawn.push(Series::new("noise", Mark::Curve, Colour::Soft, levels(&total, unit_hz)));
    }
    drawn
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
    let drawn = vec![
        Series::new("even", Mark::Curve, Colour::First, levels(&even)),
        Series::new("odd", Mark::Curve, Colour::Second, levels(&odd)),
    ];
    Some(Section {
        title: "Distortion on the free lines",
        note: String::new(),
        figures: vec![spectrum("free-lines", "Lines that the drive leaves free", unit, drawn)],
    })
}

/// The measured response around the strongest resonance, at the lowest and the highest amplitude, with its intervals where
/// there are more experiments than drives.
pub fn resonance(recording: &DynamicRecording) -> Option<Section> {
    let all = responses(recording, &Plan::new(recording));
    let (_, first) = all.first()?;
    let lowest = first.size();
    // Where the drive has no power, noise is divided by nothing.
    let known =
        |line: &usize| first.half_interval.as_ref().is_none_or(|half| half[*line] < 0.5 * lowest[*line]);
    let lines = (0..lowest.len()).filter(known);
    let top = lines.max_by(|i, j| lowest[*i].total_cmp(&lowest[*j]))?;
    let reach = (top / 4).max(LEAST_LINES);
    let range = top.saturating_sub(reach)..(top + reach).min(lowest.len());
    let ends = if all.len() > 1 { vec![&all[0], &all[all.len() - 1]] } else { vec![&all[0]] };
    let series = ends.iter().zip([Colour::First, Colour::Second]).map(|((amplitude, response), colour)| {
        let name = format!("amplitude {}", super::digits(*amplitude));
        gain(&name, colour, response, range.clone())
    });
    let series: Vec<Series> = series.collect();
    let bars = series.iter().any(|series| !series.bars.is_empty());
    let chart = Chart {
        label: "Gain against the frequency around the strongest resonance",
        x: "frequency (Hz)".to_string(),
        y: "gain (dB)".to_string(),
        series,
    };
    let caption =
        if bars { "The bars are 95 % intervals, from the scatter over runs or segments." } else { "" };
    let title = "Measured frequency response";
    Some(Section {
        title: "Response at the strongest resonance",
        note: String::new(),
        figures: vec![Figure::of("resonance", title, caption.to_string(), chart)],
    })
}

/// The gain in dB on some lines, thinned.
fn gain(name: &str, colour: Colour, response: &Response, lines: std::ops::Range<usize>) -> Series {
    let size = response.size();
    let every = (lines.len() / RESONANCE).max(1);
    let lines = || lines.clone().step_by(every).filter(|line| size[*line] > 0.0);
    let points = lines().map(|line| (response.frequency_hz[line], 10.0 * size[line].log10())).collect();
    // A small part of a power is as many nepers, 10/ln 10 dB each.
    let half = |line: usize, half: &[f64]| 10.0 / std::f64::consts::LN_10 * half[line] / size[line];
    let bars = response.half_interval.as_ref();
    let bars = bars.map_or(Vec::new(), |known| lines().map(|line| half(line, known)).collect());
    Series::new(name, Mark::Both, colour, points).with_bars(bars)
}

/// Gain and resonances by amplitude, where there are several.
pub fn growth_rows(recording: &DynamicRecording) -> Vec<Growth> {
    let all = responses(recording, &Plan::new(recording));
    if all.len() < 2 { Vec::new() } else { growth(&all) }
}
