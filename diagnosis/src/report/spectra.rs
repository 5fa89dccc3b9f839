//! Spectra: the recorded position, what both simulations leave of it, noise and distortion.

use pages::{Chart, Colour, Figure, Mark, Scale, Series};
use statrs::distribution::{ChiSquared, ContinuousCDF};

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
fn spectrum(name: &str, title: &str, caption: &str, unit: &str, series: Vec<Series>) -> Figure {
    let chart = Chart {
        label: "Level of each line against the frequency",
        x: "frequency (Hz, logarithmic)".to_string(),
        y: format!("level (dB re 1 {unit} rms per line)"),
        series,
    };
    Figure::scaled(name, title, caption.to_string(), chart, Scale::Decades)
}

const BANDS: &str = "The bands are 95 % intervals of what is left, as far as it is noise.";

/// A spectrum at every amplitude.
pub fn charts(recording: &DynamicRecording, own: &Predicted, unit: &str) -> Vec<Figure> {
    let plan = Plan::new(recording);
    let groups = plan.groups.iter().take(MOST_AMPLITUDES).enumerate();
    let figures = groups.map(|(index, group)| {
        let title = match plan.groups.len() {
            1 => "Spectrum".to_string(),
            _ => format!("Spectrum at amplitude {}", super::digits(group.amplitude)),
        };
        let series = levels_of(recording, own, &plan, group);
        spectrum(&format!("spectrum-{}", index + 1), &title, BANDS, unit, series)
    });
    figures.collect()
}

/// Levels of the position that was recorded, of what both simulations leave, with their bands, and of the noise where
/// periods tell it.
fn levels_of(recording: &DynamicRecording, own: &Predicted, plan: &Plan, group: &Group) -> Vec<Series> {
    let rows = group.rows();
    let Some(first) = rows.first() else { return Vec::new() };
    let length = plan.period.unwrap_or_else(|| segment_length(first.len()));
    let unit_hz = 1.0 / (length as f64 * recording.step_s);
    let of = |value: &dyn Fn(usize, usize) -> f64| {
        let mut total = vec![0.0; length / 2 + 1];
        for run in &rows {
            for output in 0..recording.positions.len() {
                let record: Vec<f64> = run.clone().map(|row| value(output, row)).collect();
                for (t, p) in total.iter_mut().zip(power_spectrum(&record, length)) {
                    *t += p / rows.len() as f64;
                }
            }
        }
        levels(&total, unit_hz)
    };
    let left = |columns: &[Vec<f64>], output: usize, row: usize| {
        recording.positions[output][row] - columns.get(output).map_or(f64::NAN, |c| c[row])
    };
    let curve = |name: &str, colour, levels: &[Level]| {
        Series::new(name, Mark::Curve, colour, levels.iter().map(|level| level.at).collect())
    };
    let segments = rows.iter().map(|run| independent_segments(run.len(), length)).sum();
    let before = of(&|o, r| left(&own.before, o, r));
    let after = of(&|o, r| left(&own.after, o, r));
    let mut drawn = vec![
        band(&before, segments, Colour::First),
        band(&after, segments, Colour::Second),
        curve("recorded", Colour::Ink, &of(&|o, r| recording.positions[o][r])),
        curve("left before", Colour::First, &before),
        curve("left after", Colour::Second, &after),
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
        drawn.push(curve("noise", Colour::Soft, &levels(&total, unit_hz)));
    }
    drawn
}

/// The level of a bin of lines.
struct Level {
    /// log₁₀ of the frequency in Hz, and the level in dB.
    at: (f64, f64),
    /// Lines in the bin.
    lines: usize,
}

/// Mean levels in dB over bins of equal ratio.
fn levels(power: &[f64], unit_hz: f64) -> Vec<Level> {
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
    let level = |(f, p, lines): &(f64, f64, usize)| {
        let count = *lines as f64;
        Level { at: (f / count, 10.0 * (p / count).log10()), lines: *lines }
    };
    sums.iter().filter(|s| s.2 > 0).map(level).collect()
}

/// As many independent segments as those of a record that overlap by half are worth under Hann's window: the powers of
/// neighbours have the correlation 1/36 (P. D. Welch, IEEE Trans. Audio Electroacoust. 15, 1967).
fn independent_segments(rows: usize, length: usize) -> f64 {
    let length = length.clamp(1, rows.max(1));
    let count = (1 + (rows - length) / (length / 2).max(1)) as f64;
    count / (1.0 + 2.0 * (1.0 - 1.0 / count) / 36.0)
}

/// The 95 % intervals of levels, were they those of Gaussian noise, by the χ² distribution. Hann's window makes powers of
/// neighbouring lines correlated by 4/9, and of next ones by 1/36; several positions count as one.
fn band(levels: &[Level], segments: f64, colour: Colour) -> Series {
    let edges = levels.iter().filter_map(|Level { at: (f, level), lines }| {
        let lines = *lines as f64;
        let correlated = 2.0 * (4.0 / 9.0 * (1.0 - 1.0 / lines) + (1.0 - 2.0 / lines).max(0.0) / 36.0);
        let freedom = 2.0 * segments * lines / (1.0 + correlated);
        let distribution = ChiSquared::new(freedom).ok()?;
        let edge = |p: f64| (*f, level + 10.0 * (freedom / distribution.inverse_cdf(p)).log10());
        Some((edge(0.025), edge(0.975)))
    });
    let (mut outline, lower): (Vec<_>, Vec<_>) = edges.unzip();
    outline.extend(lower.into_iter().rev());
    Series::new("", Mark::Band, colour, outline)
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
        figures: vec![spectrum("free-lines", "Lines that the drive leaves free", "", unit, drawn)],
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

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// White noise has the same level everywhere: 95 % of the bands hold it.
    #[test]
    fn bands_hold_the_level_of_noise() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (rows, length) = (4096, 512);
        let (mut within, mut all) = (0, 0);
        for _ in 0..100 {
            // Sums of twelve uniform numbers are normal enough.
            let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let record: Vec<f64> = (0..rows).map(|_| normal()).collect();
            let levels = levels(&power_spectrum(&record, length), 1.0);
            let band = band(&levels, independent_segments(rows, length), Colour::First).points;
            let level = 10.0 * (2.0 / length as f64).log10();
            // The last line is one-sided.
            for k in 0..levels.len() - 1 {
                let (upper, lower) = (band[k].1, band[band.len() - 1 - k].1);
                within += usize::from((lower..upper).contains(&level));
                all += 1;
            }
        }
        let share = within as f64 / all as f64;
        // Some 15000 bins, of which neighbours depend on each other.
        assert!((share - 0.95).abs() < 0.01, "{share} of {all}");
    }
}
