//! A sensor that reports the angle itself: a magnetic encoder on the mirror's shaft, calibrated against a
//! reference on the other side of a coupling.
//!
//! The magnet is not centred under the chip, the chip's bridges do not match: the reading errs by harmonics of
//! the turn of the *true* angle, Θ + Σ A_h sin(hΘ + φ_h), wraps round at a revolution, comes late where the shaft
//! turns, and is rounded to the converter's counts. Friction in the seals drags the coupling behind, so that the
//! two ends differ by its play between the directions.

use std::io::{self, Write};
use std::path::Path;

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::log::write_as;
use crate::noise::{Noise, Source};
use crate::streams::{Stream, stream};
use crate::units::round_to;
use fitter::output::OutputError;

/// One harmonic of the turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// How often it repeats in a turn.
    pub order: u32,
    /// Its amplitude in degrees.
    pub amplitude_deg: f64,
    /// Its phase in radians.
    pub phase_rad: f64,
}

/// An encoder in its mount.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoder {
    /// Counts of a revolution.
    pub counts: u32,
    /// What the reading errs by over a turn.
    pub harmonics: Vec<Harmonic>,
    /// Half the width of the play between encoder and reference, in degrees.
    pub half_width_deg: f64,
    /// How late the reading is, in seconds.
    pub delay_s: f64,
    /// Standard deviation of one reading, in degrees.
    pub noise_deg: f64,
    /// Standard deviation of the reference, in degrees.
    pub reference_noise_deg: f64,
    /// Where the encoder's zero stands on the reference's scale, in degrees.
    pub zero_deg: f64,
}

impl Encoder {
    /// The encoder of `seed`: 14 bits; eccentric by up to 0.4°, with smaller second and fourth harmonics.
    pub fn from_seed(seed: u64) -> Self {
        let mut generator = stream(seed, Stream::Sensor);
        let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
        let turn = std::f64::consts::TAU;
        let mut harmonic = |order, from, to| Harmonic {
            order,
            amplitude_deg: uniform(from, to),
            phase_rad: uniform(0.0, turn),
        };
        let harmonics = vec![harmonic(1, 0.15, 0.4), harmonic(2, 0.05, 0.15), harmonic(4, 0.01, 0.05)];
        Self {
            counts: 1 << 14,
            harmonics,
            half_width_deg: uniform(0.01, 0.04),
            delay_s: uniform(1e-4, 5e-4),
            noise_deg: 0.01,
            reference_noise_deg: 0.001,
            zero_deg: uniform(-180.0, 180.0),
        }
    }

    /// What the encoder reports in degrees, neither wrapped nor rounded, at a true angle in degrees.
    pub fn reported_deg(&self, true_deg: f64) -> f64 {
        let error =
            |h: &Harmonic| h.amplitude_deg * (f64::from(h.order) * true_deg.to_radians() + h.phase_rad).sin();
        true_deg + self.zero_deg + self.harmonics.iter().map(error).sum::<f64>()
    }
}

/// In what the columns `measured` and `reference` are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Degrees; a revolution is 360.
    Degrees,
    /// Counts of the encoder, to fractions in the reference; a revolution is all of them.
    Counts,
}

/// How the shaft is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    /// Turns of one pass; passes go forward and backward in turn.
    pub turns: f64,
    /// Passes.
    pub passes: u32,
    /// Readings of a turn.
    pub readings_per_turn: u32,
    /// Speed in degrees per second; read while it turns.
    pub speed_deg_per_s: f64,
    /// By how much the speed of every second pair of passes differs, as a factor: at one speed alone a lag is a
    /// constant of each direction.
    pub speed_factor: f64,
    /// The kind of noise.
    pub noise: Noise,
    /// Whether readings wrap round at a revolution.
    pub wraps: bool,
    /// The unit.
    pub unit: Unit,
}

impl Default for Turning {
    /// Six passes over 1.2 turns with 120 readings each, at 30 and 60 °/s.
    fn default() -> Self {
        Self {
            turns: 1.2,
            passes: 6,
            readings_per_turn: 120,
            speed_deg_per_s: 30.0,
            speed_factor: 2.0,
            noise: Noise::White,
            wraps: true,
            unit: Unit::Degrees,
        }
    }
}

/// One reading, in the unit of the recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time since the start in seconds.
    pub t_s: f64,
    /// Number of the pass, from 1.
    pub pass: u32,
    /// +1 forward, −1 backward.
    pub direction: i8,
    /// What the encoder reports.
    pub measured: f64,
    /// What the reference reads.
    pub reference: f64,
    /// Temperature in °C.
    pub temperature_c: f64,
}

/// Records the encoder.
pub fn record(encoder: &Encoder, turning: &Turning, seed: u64) -> Vec<Row> {
    let mut noise = Source::start(&turning.noise, 2, stream(seed, Stream::Probes));
    let mut housekeeping = stream(seed, Stream::Housekeeping);
    let mut timing = stream(seed, Stream::Timing);
    let per_unit = match turning.unit {
        Unit::Degrees => 1.0,
        Unit::Counts => f64::from(encoder.counts) / 360.0,
    };
    let wrapped = |deg: f64| if turning.wraps { deg.rem_euclid(360.0) } else { deg };
    let count = (turning.turns * f64::from(turning.readings_per_turn)).round().max(1.0) as u32;
    let step_deg = 360.0 / f64::from(turning.readings_per_turn);
    let (mut t_s, mut shaft_deg) = (0.0, 0.0f64);
    let mut rows = Vec::new();
    for pass in 1..=turning.passes.max(1) {
        let forward = pass % 2 == 1;
        let sign = if forward { 1.0 } else { -1.0 };
        let faster = (pass - 1) / 2 % 2 == 1;
        let speed = turning.speed_deg_per_s * if faster { turning.speed_factor } else { 1.0 };
        for index in 0..=count {
            // Readings are triggered by a clock that runs beside the motion.
            let early_deg = 0.2 * step_deg * (timing.random::<f64>() - 0.5);
            let place = if forward { index } else { count - index };
            let reference_deg = f64::from(place) * step_deg + early_deg;
            // Play: the encoder's end follows when the reference's has crossed it.
            shaft_deg = shaft_deg
                .clamp(reference_deg - encoder.half_width_deg, reference_deg + encoder.half_width_deg);
            let late_deg = sign * speed * encoder.delay_s;
            let seen_deg =
                encoder.reported_deg(shaft_deg - late_deg) + encoder.noise_deg * noise.draw(0, t_s);
            let resolution = 360.0 / f64::from(encoder.counts);
            let measured_deg = wrapped((seen_deg / resolution).round() * resolution);
            let read_deg = reference_deg + encoder.reference_noise_deg * noise.draw(1, t_s);
            let digits = if turning.unit == Unit::Degrees { 5 } else { 3 };
            rows.push(Row {
                t_s: round_to(t_s, 4),
                pass,
                direction: sign as i8,
                measured: round_to(measured_deg * per_unit, digits),
                reference: round_to(wrapped(read_deg) * per_unit, digits),
                temperature_c: round_to(25.0 + 0.02 * housekeeping.sample::<f64, _>(StandardNormal), 3),
            });
            t_s += step_deg / speed;
        }
        t_s += 1.0;
    }
    rows
}

/// Writes the rows as CSV, header first.
pub fn write_csv(rows: &[Row], mut to: impl Write) -> io::Result<()> {
    writeln!(to, "t_s,pass,direction,measured,reference,temperature_c")?;
    for r in rows {
        writeln!(
            to,
            "{:.4},{},{},{},{},{:.3}",
            r.t_s, r.pass, r.direction, r.measured, r.reference, r.temperature_c
        )?;
    }
    to.flush()
}

/// Writes the file at `path`, `.csv` or `.csv.gz`, whole or not at all.
///
/// # Errors
/// [`OutputError`].
pub fn write_file(rows: &[Row], path: &Path) -> Result<(), OutputError> {
    write_as(path, |to| write_csv(rows, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The difference of two angles on a circle, in degrees.
    fn apart(a: f64, b: f64) -> f64 {
        (a - b + 180.0).rem_euclid(360.0) - 180.0
    }

    fn ideal() -> Encoder {
        Encoder {
            harmonics: Vec::new(),
            half_width_deg: 0.0,
            delay_s: 0.0,
            noise_deg: 0.0,
            reference_noise_deg: 0.0,
            zero_deg: 0.0,
            counts: 1 << 20,
        }
    }

    #[test]
    fn an_ideal_encoder_reads_the_reference_and_wraps() {
        let rows = record(&ideal(), &Turning::default(), 1);
        assert_eq!(rows.len(), 6 * 145);
        assert!(rows.iter().all(|r| apart(r.measured, r.reference).abs() < 1e-3));
        assert!(rows.iter().all(|r| (0.0..360.0 + 1e-9).contains(&r.measured)));
        assert!(rows.windows(2).any(|w| w[0].measured - w[1].measured > 300.0));
        assert!(rows.windows(2).all(|w| w[1].t_s > w[0].t_s));
        let counts = record(&ideal(), &Turning { unit: Unit::Counts, ..Turning::default() }, 1);
        assert!((counts[10].measured - rows[10].measured / 360.0 * f64::from(1 << 20)).abs() < 4.0);
    }

    #[test]
    fn play_and_lag_part_the_directions() {
        let gap = |encoder: &Encoder, speed_factor: f64, passes: std::ops::RangeInclusive<u32>| {
            let rows = record(encoder, &Turning { speed_factor, ..Turning::default() }, 1);
            // Away from the turning points, where the play is still crossed.
            let mean = |sign: i8| {
                let all: Vec<f64> = rows
                    .iter()
                    .filter(|r| {
                        r.direction == sign
                            && passes.contains(&r.pass)
                            && (30.0..330.0).contains(&r.reference)
                    })
                    .map(|r| apart(r.measured, r.reference))
                    .collect();
                all.iter().sum::<f64>() / all.len() as f64
            };
            mean(1) - mean(-1)
        };
        let play = Encoder { half_width_deg: 0.05, ..ideal() };
        // Forward the encoder hangs behind.
        assert!((gap(&play, 1.0, 1..=6) + 0.1).abs() < 1e-3);
        let lag = Encoder { delay_s: 1e-3, ..ideal() };
        assert!((gap(&lag, 2.0, 1..=2) + 0.06).abs() < 1e-3);
        assert!((gap(&lag, 2.0, 3..=4) + 0.12).abs() < 1e-3);
    }

    #[test]
    fn the_error_has_the_harmonics_of_the_true_angle() {
        let encoder =
            Encoder { harmonics: vec![Harmonic { order: 2, amplitude_deg: 0.3, phase_rad: 0.4 }], ..ideal() };
        for row in record(&encoder, &Turning::default(), 2) {
            let expected = 0.3 * (2.0 * row.reference.to_radians() + 0.4).sin();
            assert!((apart(row.measured, row.reference) - expected).abs() < 1e-3);
        }
    }
}
