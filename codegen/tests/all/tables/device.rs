//! A simulated encoder: eccentric, with a second harmonic and smaller ones, read with noise in whole counts.

use std::f64::consts::TAU;

use fitter::coefficients::Coefficients;
use fitter::mirror::Mirror;
use fitter::recording::{Purpose, Reading, Recording};
use fitter::table::{Cells, IN_MEMORY};

/// Counts of its turn.
pub const COUNTS: u32 = 16_384;
/// Readings of a calibration.
pub const READINGS: usize = 10_000;

/// Numbers that look drawn: SplitMix64 (Steele, Lea and Flood, 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x5851_f42d_4c95_7f2d))
    }

    /// From 0 to 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / 2f64.powi(53)
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }

    pub fn normal(&mut self) -> f64 {
        let (radius, angle) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * radius.ln()).sqrt() * (TAU * angle).cos()
    }
}

/// The encoder. Lengths in turns.
pub struct Device {
    /// Cosine and sine of the harmonics of the error, from the first.
    pub waves: Vec<(f64, f64)>,
    /// The reading at reference 0.
    pub zero: f64,
    /// Standard deviation of a reading.
    pub noise: f64,
}

impl Device {
    /// Eccentric by 0.2 to 1.5 degrees, a second harmonic of up to 0.4, a third and a fourth of up to 0.05, noise of 0.01
    /// to 0.05.
    pub fn draw(random: &mut Random) -> Device {
        let mut wave = |from: f64, to: f64| {
            let (size, phase) = (random.between(from, to) / 360.0, TAU * random.uniform());
            (size * phase.cos(), size * phase.sin())
        };
        let waves = vec![wave(0.2, 1.5), wave(0.05, 0.4), wave(0.0, 0.05), wave(0.0, 0.05)];
        Device { waves, zero: random.uniform(), noise: random.between(0.01, 0.05) / 360.0 }
    }

    /// The error at a reference.
    fn error(&self, reference: f64) -> f64 {
        let of = |(k, (a, b)): (usize, &(f64, f64))| {
            let phase = TAU * (k + 1) as f64 * reference;
            a * phase.cos() + b * phase.sin()
        };
        self.waves.iter().enumerate().map(of).sum()
    }

    /// The position, on the reference's scale, at which the reading without noise is this.
    pub fn position(&self, reading: f64) -> f64 {
        let mut position = reading - self.zero;
        for _ in 0..60 {
            position = reading - self.zero - self.error(position);
        }
        position
    }

    /// A reading at a reference, in whole counts of a turn.
    pub fn reading(&self, reference: f64, random: &mut Random) -> f64 {
        let seen = reference + self.zero + self.error(reference) + self.noise * random.normal();
        let counts = (seen * f64::from(COUNTS)).round().rem_euclid(f64::from(COUNTS));
        counts / f64::from(COUNTS)
    }

    /// The readings of two slow turns, and their references.
    pub fn calibration(&self, random: &mut Random) -> Vec<(f64, f64)> {
        let row = |row: usize| {
            let reference = 2.0 * row as f64 / READINGS as f64;
            (self.reading(reference, random), reference.fract())
        };
        (0..READINGS).map(row).collect()
    }

    /// Its coefficients in degrees, as if they were known.
    pub fn coefficients(&self) -> Coefficients {
        let waves: Vec<f64> = self.waves.iter().flat_map(|(a, b)| [360.0 * a, 360.0 * b]).collect();
        super::fixtures::encoder(360.0, 360.0 * self.zero, &waves)
    }
}

/// The coefficients in degrees that these readings give.
pub fn fitted(rows: &[(f64, f64)]) -> Coefficients {
    let column = |name: &str, values: Vec<f64>| (name.to_string(), Cells::Numbers(values.into()));
    let columns = vec![
        column("t_s", (0..rows.len()).map(|row| 0.005 * row as f64).collect()),
        column("pass", (0..rows.len()).map(|row| (2 * row / rows.len() + 1) as f64).collect()),
        column("direction", vec![1.0; rows.len()]),
        column("measured", rows.iter().map(|row| 360.0 * row.0).collect()),
        column("reference", rows.iter().map(|row| 360.0 * row.1).collect()),
    ];
    let recording = Recording::of_columns(IN_MEMORY, columns, &Reading::plain(Purpose::Fit)).unwrap();
    let mirror = "[sensor]\nkind = \"direct\"\nunit = \"deg\"\nrevolution = 360.0\n";
    let mirror = Mirror::parse("encoder.toml", mirror).unwrap();
    fitter::fit(&recording, &mirror, &fitter::Options::default()).unwrap().coefficients
}
