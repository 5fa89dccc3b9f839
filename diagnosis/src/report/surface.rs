//! The restoring-force surface: the acceleration that the nominal plant does not account for, over position
//! and velocity.
//!
//! Source: S. F. Masri, T. K. Caughey, J. Appl. Mech. 46 (1979) 433–447. Derivatives are those of a local
//! polynomial of order three (A. Savitzky, M. Golay, Anal. Chem. 36 (1964) 1627–1639).

use fitter::plant::Plant;
use pages::{Cell, Chart, Colour, Figure, Map, Mark, Series};

use crate::dynamic::DynamicRecording;
use crate::thresholds::report::surface::{LEAST, REACH};

/// Cells along position and velocity.
const CELLS: (usize, usize) = (20, 14);

/// Position, velocity and missing acceleration of every row that has them.
fn force(recording: &DynamicRecording, plant: &Plant) -> Option<Vec<[f64; 3]>> {
    let (damping, stiffness) = (plant.damping?, plant.stiffness.unwrap_or(0.0));
    let gain = plant.gain.as_ref()?.get(0)?;
    let (x, u) = (recording.positions.first()?, recording.drives.first()?);
    let h = recording.step_s;
    let natural = std::f64::consts::TAU / stiffness.max(damping * damping).max(1e-12).sqrt();
    let reach = ((REACH * natural / h).round() as usize).clamp(2, 200);
    let (first, second) = derivative_weights(reach, h);
    let mut out = Vec::new();
    for run in &recording.runs {
        for t in run.start + reach..run.end.saturating_sub(reach) {
            let window = &x[t - reach..=t + reach];
            let dot = |w: &[f64]| w.iter().zip(window).map(|(w, x)| w * x).sum::<f64>();
            let (v, a) = (dot(&first), dot(&second));
            // The drive over the same window, so that both sides are smoothed alike.
            let drive =
                u[t - reach..=t + reach].iter().zip(smoothing(reach)).map(|(u, w)| w * u).sum::<f64>();
            let position = window.iter().zip(smoothing(reach)).map(|(x, w)| w * x).sum::<f64>();
            out.push([position, v, a + damping * v + stiffness * position - gain * drive]);
        }
    }
    (out.len() > 100).then_some(out)
}

/// Weights of the first and second derivative of a local cubic over −reach … reach.
fn derivative_weights(reach: usize, h: f64) -> (Vec<f64>, Vec<f64>) {
    let n: Vec<f64> = (0..=2 * reach).map(|k| k as f64 - reach as f64).collect();
    let moment = |power: i32| n.iter().map(|k| k.powi(power)).sum::<f64>();
    let (s0, s2, s4, s6) = (moment(0), moment(2), moment(4), moment(6));
    let odd = s2 * s6 - s4 * s4;
    let even = s0 * s4 - s2 * s2;
    let first = n.iter().map(|k| (s6 * k - s4 * k.powi(3)) / odd / h).collect();
    let second = n.iter().map(|k| 2.0 * (s0 * k * k - s2) / even / (h * h)).collect();
    (first, second)
}

/// Weights of the value of a local quadratic.
fn smoothing(reach: usize) -> impl Iterator<Item = f64> {
    let k = move |i: usize| i as f64 - reach as f64;
    let (mut s0, mut s2, mut s4) = (0.0, 0.0, 0.0);
    for i in 0..=2 * reach {
        s0 += 1.0;
        s2 += k(i).powi(2);
        s4 += k(i).powi(4);
    }
    (0..=2 * reach).map(move |i| (s4 - s2 * k(i).powi(2)) / (s0 * s4 - s2 * s2))
}

/// None for a plant without numbers.
pub fn charts(recording: &DynamicRecording, plant: &Plant) -> Vec<Figure> {
    let Some(rows) = force(recording, plant) else { return Vec::new() };
    let limit = |i: usize| -> f64 {
        let mut all: Vec<f64> = rows.iter().map(|r| r[i].abs()).collect();
        all.sort_by(f64::total_cmp);
        all[(all.len() - 1) * 995 / 1000].max(f64::MIN_POSITIVE)
    };
    let (x_most, v_most) = (limit(0), limit(1));
    let (columns, lines) = CELLS;
    let mut sums = vec![(0.0, 0usize); columns * lines];
    let bin = |value: f64, most: f64, count: usize| {
        // A value just below the largest may be rounded onto the far edge.
        (value.abs() < most).then(|| (((value / most + 1.0) / 2.0 * count as f64) as usize).min(count - 1))
    };
    for [x, v, f] in &rows {
        if let (Some(i), Some(j)) = (bin(*x, x_most, columns), bin(*v, v_most, lines)) {
            let cell = &mut sums[j * columns + i];
            cell.0 += f;
            cell.1 += 1;
        }
    }
    let mean = |cell: &(f64, usize)| (cell.1 >= LEAST).then(|| cell.0 / cell.1 as f64);
    let largest = sums.iter().filter_map(mean).fold(0.0, |m: f64, f| m.max(f.abs())).max(f64::MIN_POSITIVE);
    let edge = |k: usize, most: f64, count: usize| most * (2.0 * k as f64 / count as f64 - 1.0);
    let cells: Vec<Cell> = sums
        .iter()
        .enumerate()
        .filter_map(|(k, cell)| {
            let (i, j) = (k % columns, k / columns);
            Some(Cell {
                from: (edge(i, x_most, columns), edge(j, v_most, lines)),
                to: (edge(i + 1, x_most, columns), edge(j + 1, v_most, lines)),
                value: mean(cell)?,
            })
        })
        .collect();
    let unit = &plant.position_unit;
    let (position, velocity) = (format!("position ({unit})"), format!("velocity ({unit}/s)"));
    let acceleration = format!("acceleration ({unit}/s²)");
    let section = |axis: usize, most: f64| -> Vec<(f64, f64)> {
        let mut sums = [(0.0, 0usize); 32];
        for row in &rows {
            if let Some(k) = bin(row[axis], most, 32) {
                sums[k].0 += row[2];
                sums[k].1 += 1;
            }
        }
        let middle = |k: usize| 0.5 * (edge(k, most, 32) + edge(k + 1, most, 32));
        sums.iter().enumerate().filter_map(|(k, s)| Some((middle(k), mean(s)?))).collect()
    };
    let curve = |name: &str, over: &str, x: &str, points| {
        let series = vec![Series::new("", Mark::Curve, Colour::Ink, points)];
        let chart =
            Chart { label: "Missing acceleration", x: x.to_string(), y: acceleration.clone(), series };
        Figure::of(name, &format!("Mean over {over}"), String::new(), chart)
    };
    let surface = Map {
        label: "Missing acceleration over position and velocity",
        names: [&position, &velocity, &acceleration],
        ranges: [(-x_most, x_most), (-v_most, v_most)],
        full: largest,
        cells,
    };
    let caption = format!("Full colour from {} {unit}/s² on.", super::digits(largest));
    vec![
        Figure::map("surface", "Over position and velocity", caption, &surface),
        curve("over-position", "position", &position, section(0, x_most)),
        curve("over-velocity", "velocity", &velocity, section(1, v_most)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_a_cubic_are_exact() {
        let h = 0.01;
        let (first, second) = derivative_weights(5, h);
        let x = |t: f64| 2.0 + 3.0 * t - 4.0 * t * t + 5.0 * t.powi(3);
        let window: Vec<f64> = (0..11).map(|k| x((k as f64 - 5.0) * h)).collect();
        let dot = |w: &[f64]| w.iter().zip(&window).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&first) - 3.0).abs() < 1e-9);
        assert!((dot(&second) + 8.0).abs() < 1e-6);
        let value: f64 = smoothing(5).zip(&window).map(|(a, b)| a * b).sum();
        assert!((value - 2.0).abs() < 1e-6);
    }
}
