//! The noise of a reading, as far as the residual itself shows it. A bound from the residual's own past alone lets a
//! motion of the mechanism that no model follows pass for correlated noise, so three further bounds are taken: noise
//! has no more power where the mechanism resonates than on either side of it, none that depends on how the mechanism
//! moves, and as much at one time as at another.

use super::data::Data;
use super::estimate::Fitted;
use super::noise::Autoregression;
use super::spectrum::band::add_segments;
use super::structure::Structure;
use crate::thresholds::AT_FLOOR;
use crate::thresholds::dynamic::floor::{
    BANDS, BEYOND, BLOCKS, CHANCE, DEPENDS, LAGS, LEAST_BLOCK, LEAST_BLOCKS, LEAST_STRETCH, LEAST_STRETCHES,
    PERIODS, QUARTILE,
};
use crate::thresholds::dynamic::remainder::COLOURED;

/// The noise of a reading, and what of the residual is above it.
pub struct Floor {
    /// Standard deviation of a reading.
    pub level: f64,
    /// What it follows from.
    pub from: &'static str,
    /// Where the residual is above it.
    pub place: Structure,
}

/// The lowest bound of the noise; none where the residual is within `AT_FLOOR` of every one.
pub fn bound(
    found: &Fitted,
    (residual, simulated): (&[f64], &[f64]),
    data: &Data,
    noise: &Autoregression,
) -> Option<Floor> {
    let all = [
        by_time(residual, data),
        by_motion(residual, simulated, data, noise),
        by_band(residual, found, data),
    ];
    let rms = power(data.runs.iter().flat_map(|r| &residual[r.clone()])).sqrt();
    all.into_iter()
        .flatten()
        .filter(|floor| rms > AT_FLOOR * floor.level)
        .min_by(|a, b| a.level.total_cmp(&b.level))
        // Once the residual is known to be more, the noise is no more than its own past leaves of it.
        .map(|floor| Floor { level: floor.level.min(COLOURED * noise.innovation), ..floor })
}

fn power<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(s, n), x| (s + x * x, n + 1));
    sum / count.max(1) as f64
}

/// The bound by frequency: the residual's power in bands, those around the resonance no higher than those on either
/// side of it.
fn by_band(residual: &[f64], found: &Fitted, data: &Data) -> Option<Floor> {
    let resonance_hz = found.model.nominal[1].max(0.0).sqrt() / std::f64::consts::TAU;
    let wanted = PERIODS / (resonance_hz * data.step_s);
    let longest = data.runs.iter().map(|r| r.len()).max()?;
    if !wanted.is_finite() || wanted > longest as f64 {
        return None;
    }
    let length = (wanted as usize).next_power_of_two().max(LEAST_STRETCH);
    let mut lines = vec![0.0; length / 2];
    let stretches: usize =
        data.runs.iter().map(|run| add_segments(&mut lines, &residual[run.clone()], length)).sum();
    if stretches < LEAST_STRETCHES {
        return None;
    }
    let line_hz = 1.0 / (length as f64 * data.step_s);
    // The mean and what a window smears it into are left out.
    let first = 2usize;
    let mut bands: Vec<(f64, f64, f64, f64)> = Vec::new();
    let mut from = first;
    while from < lines.len() {
        let to = ((from as f64 * 2f64.powf(1.0 / BANDS)).ceil() as usize).max(from + 1).min(lines.len());
        let density = lines[from..to].iter().sum::<f64>() / (to - from) as f64;
        // Half of two stretches that overlap, and two of three neighbouring lines, are the same.
        let count = (0.5 * stretches as f64 * (to - from) as f64).max(1.0);
        bands.push((from as f64 * line_hz, to as f64 * line_hz, density, CHANCE / count.sqrt()));
        from = to;
    }
    let beyond = bands.iter().find(|b| b.0 > BEYOND * resonance_hz)?.2;
    let (mut ceiling, mut kept, mut whole) = (f64::INFINITY, 0.0, 0.0);
    let mut above: Option<(f64, f64)> = None;
    for (from, to, density, chance) in &bands {
        let width = to - from;
        whole += width * density;
        let inside = *from <= BEYOND * resonance_hz;
        let noise = if inside { density.min(ceiling.max(beyond * (1.0 + chance))) } else { *density };
        if noise < *density {
            above = Some((above.map_or(*from, |a| a.0), *to));
        }
        kept += width * noise;
        ceiling = ceiling.min(density * (1.0 + chance));
    }
    let part = 1.0 - kept / whole.max(f64::MIN_POSITIVE);
    let rows: usize = data.runs.iter().map(|r| r.len()).sum();
    let rms = power(data.runs.iter().flat_map(|r| &residual[r.clone()])).sqrt();
    above.map(|at| Floor {
        level: rms * (1.0 - part).max(0.0).sqrt(),
        from: "the residual beside the resonance",
        place: Structure::of_part(("frequency_hz", None), part, rows, 1, Some(at)),
    })
}

/// The bound by motion: what is left of the innovation's power where the mechanism stands still. A clock that jitters
/// by δt adds v·δt to a reading.
fn by_motion(residual: &[f64], simulated: &[f64], data: &Data, noise: &Autoregression) -> Option<Floor> {
    let order = noise.coefficients.len();
    let (mut squares, mut speeds, mut sizes) = (Vec::new(), Vec::new(), Vec::new());
    for run in &data.runs {
        let middle = numerics::mean(&simulated[run.clone()]);
        for k in run.start + order.max(1)..run.end.saturating_sub(1) {
            let past: f64 = noise.coefficients.iter().enumerate().map(|(j, c)| c * residual[k - 1 - j]).sum();
            squares.push((residual[k] - past).powi(2));
            speeds.push(((simulated[k + 1] - simulated[k - 1]) / (2.0 * data.step_s)).powi(2));
            sizes.push((simulated[k] - middle).powi(2));
        }
    }
    let all = [("t_s", Some("velocity"), speeds), ("position", None, sizes)];
    let rms = power(data.runs.iter().flat_map(|r| &residual[r.clone()])).sqrt();
    let of = |(variable, times, drivers): (&'static str, Option<&'static str>, Vec<f64>)| {
        let still = standing(&squares, &drivers)?;
        let part = 1.0 - still / numerics::mean(&squares);
        Some(Floor {
            level: rms * (1.0 - part).max(0.0).sqrt(),
            from: "readings of the mechanism at rest",
            place: Structure::of_part((variable, times), part, squares.len(), 1, None),
        })
    };
    all.into_iter().filter_map(of).min_by(|a, b| a.level.total_cmp(&b.level))
}

/// The mean of `squares` where `drivers` is zero, by a straight line; none where they do not depend on it.
fn standing(squares: &[f64], drivers: &[f64]) -> Option<f64> {
    let (middle, mean) = (numerics::mean(drivers), numerics::mean(squares));
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y) in drivers.iter().zip(squares) {
        xx += (x - middle) * (x - middle);
        xy += (x - middle) * (y - mean);
    }
    let slope = xy / xx.max(f64::MIN_POSITIVE);
    // Each deviation with its own variance: kicks that come by chance count for no more than they are.
    let scatter: f64 = (drivers.iter().zip(squares))
        .map(|(x, y)| ((x - middle) * (y - mean - slope * (x - middle))).powi(2))
        .sum();
    let error = scatter.sqrt() / xx.max(f64::MIN_POSITIVE);
    (slope > DEPENDS * error).then(|| (mean - slope * middle).max(0.0))
}

/// The bound by time: the power of the quietest quarter of the blocks, which noise that is alike over several samples
/// lets scatter.
fn by_time(residual: &[f64], data: &Data) -> Option<Floor> {
    let rows: usize = data.runs.iter().map(|r| r.len()).sum();
    let length = (rows / BLOCKS).max(LEAST_BLOCK);
    let starts = data.runs.iter().flat_map(|r| (r.start..(r.end + 1).saturating_sub(length)).step_by(length));
    let blocks: Vec<(usize, f64)> = starts.map(|k| (k, power(residual[k..k + length].iter()))).collect();
    if blocks.len() < LEAST_BLOCKS {
        return None;
    }
    let mut sorted: Vec<f64> = blocks.iter().map(|b| b.1).collect();
    sorted.sort_by(f64::total_cmp);
    let whole = power(data.runs.iter().flat_map(|r| &residual[r.clone()]));
    let longest = data.runs.iter().max_by_key(|r| r.len())?.clone();
    let x = &residual[longest];
    let lagged = |lag: usize| x.iter().zip(&x[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let own = lagged(0).max(f64::MIN_POSITIVE);
    let alike = 1.0 + 2.0 * (1..LAGS.min(x.len())).map(|lag| (lagged(lag) / own).powi(2)).sum::<f64>();
    let scatter = (2.0 * alike / length as f64).sqrt();
    let quiet = sorted[blocks.len() / 4] / (1.0 - QUARTILE * scatter).max(1.0 - QUARTILE);
    let part = 1.0 - quiet / whole.max(f64::MIN_POSITIVE);
    let loudest = blocks.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
    let run = data.runs.iter().position(|r| r.contains(&loudest))?;
    let start_s = data.starts_s[run] + (loudest - data.runs[run].start) as f64 * data.step_s;
    (part > 0.0).then(|| Floor {
        level: quiet.sqrt(),
        from: "the quiet quarter of the recording",
        place: Structure::of_part(
            ("t_s", None),
            part,
            rows,
            1,
            Some((start_s, start_s + length as f64 * data.step_s)),
        ),
    })
}
