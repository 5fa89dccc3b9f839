//! An error that repeats with the true angle: a grating, a resolver's poles, the teeth of a gear.
//!
//! The angle Θ in the argument is the true one. While a recording is diagnosed the reference gives it, up to
//! the phase; when a correction is applied, it is solved for.

use fitter::terms::{Operator, Periodic};

use super::{Effect, Experiment, Facts, Handed, PERIODIC_ERROR, Range, Reading, reading};
use crate::rows::Rows;
use crate::thresholds::effects::periodic_error::{FEW_PLACES, MOST_CYCLES, MOST_HARMONICS, STEEPEST};

/// See the module's description.
pub struct PeriodicError;

impl Effect for PeriodicError {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: PERIODIC_ERROR,
                title: "an error that repeats with the angle",
                formula: "A sin(2πΘ/p + φ) and further harmonics, Θ the true angle",
                source: "Heydemann, Determination and correction of quadrature fringe measurement errors in interferometers, Appl. Opt. 20 (1981) 3382–3384",
                size: "A positive, φ free; the strongest harmonic is up to some thousandths of the period",
                confused_with: &["local_defect", "sensor_clipping"],
                variable: "angle_deg",
                told_by: &[(Experiment::FinerSteps, "wave")],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        if rows.whole_turn().is_some() {
            return Err("the base holds the harmonics of the turn".into());
        }
        if rows.len() >= 24 { Ok(()) } else { Err("too few rows for a periodic error".into()) }
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        let (low, high) = rows.stroke();
        let range = self.ranges(rows)[0];
        let (fewest, most) = ((high - low) / range.high, (high - low) / range.low);
        // Read at few places far apart, the likelihood has as high a top at every period that differs by one cycle from
        // place to place: the right one must be met exactly.
        let spacing = if rows.positions() < FEW_PLACES && rows.len() > 10 * FEW_PLACES { 0.1 } else { 0.35 };
        let mut cycles = fewest;
        let mut starts = Vec::new();
        while cycles <= most {
            starts.push(vec![(high - low) / cycles, 1.0]);
            cycles += spacing;
        }
        starts
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        let (low, high) = rows.stroke();
        let stroke = high - low;
        // Longer periods are polynomials; shorter ones than two and a fifth steps cannot be told from longer.
        let most = (stroke / (2.2 * rows.step())).clamp(2.0, MOST_CYCLES);
        vec![
            Range { low: stroke / most, high: stroke / 1.5, logarithmic: true, whole: false },
            Range { low: 1.0, high: 1.0, logarithmic: false, whole: true },
        ]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let turn = std::f64::consts::TAU / shape[0];
        let origin = crate::numerics::mean(&rows.truth);
        let first: (Vec<f64>, Vec<f64>) = rows.truth.iter().map(|t| (turn * (t - origin)).sin_cos()).unzip();
        let mut columns = vec![first.0, first.1];
        // sin and cos of (h+1) x from those of h x and x: one call per row whatever the number of harmonics.
        for h in 1..shape[1] as usize {
            let (sine, cosine) = (&columns[2 * h - 2], &columns[2 * h - 1]);
            let next: (Vec<f64>, Vec<f64>) = (0..rows.len())
                .map(|i| {
                    let (s, c) = (columns[0][i], columns[1][i]);
                    (sine[i] * c + cosine[i] * s, cosine[i] * c - sine[i] * s)
                })
                .unzip();
            columns.extend([next.0, next.1]);
        }
        columns
    }

    fn plausible_at(&self, shape: &[f64], amplitudes: &[f64]) -> bool {
        let slope = |h: usize| std::f64::consts::TAU * (h + 1) as f64 / shape[0];
        let steepest: f64 =
            amplitudes.chunks_exact(2).enumerate().map(|(h, a)| slope(h) * a[0].hypot(a[1])).sum();
        steepest < STEEPEST
    }

    fn richer(&self, rows: &Rows, shape: &[f64]) -> Option<Vec<f64>> {
        let harmonics = shape[1] + 1.0;
        let resolved = shape[0] / harmonics >= 2.2 * rows.step();
        (harmonics <= MOST_HARMONICS && resolved).then(|| vec![shape[0], harmonics])
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        // The phase is counted here from the mean of the reference; a coefficients file counts it from α₀, which
        // is taken into account when the file is made.
        let count = shape[1] as usize;
        let origin = crate::numerics::mean(&rows.truth);
        let mut map = vec![vec![0.0; 2 * count]; 2 * count];
        for h in 0..count {
            let phase = std::f64::consts::TAU * (h + 1) as f64 * origin / shape[0];
            let (sine, cosine) = phase.sin_cos();
            // a sin(x − φ) + b cos(x − φ) = (b cos φ − a sin φ) cos x + (a cos φ + b sin φ) sin x
            map[2 * h][2 * h] = -sine;
            map[2 * h][2 * h + 1] = cosine;
            map[2 * h + 1][2 * h] = cosine;
            map[2 * h + 1][2 * h + 1] = sine;
        }
        Handed { operator: Operator::Periodic(Periodic::of(shape[0], count as u16)), map }
    }

    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let size = |h: usize| amplitudes[2 * h].hypot(amplitudes[2 * h + 1]);
        let strongest = (0..amplitudes.len() / 2).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0);
        let unit = rows.unit.as_str();
        vec![
            reading(format!("amplitude_{unit}"), size(strongest), unit),
            reading(format!("period_{unit}"), shape[0] / (strongest + 1) as f64, unit),
            reading("harmonics", (amplitudes.len() / 2) as f64, "1"),
        ]
    }
}
