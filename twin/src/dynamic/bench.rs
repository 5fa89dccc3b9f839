//! A mirror in motion on its bench: drawn from a seed, excited, and recorded through its read-out with noise.

use fitter::plant::{Hold, PlantEffect};
use motion::model::REST;
use motion::{Context, Model, RunError, Series, Start, Typical};
use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use super::excitation::Excitation;
use crate::effects::EffectError;
use crate::noise::{Noise, Source};
use crate::streams::{Stream, stream};
use crate::units::round_to;

/// Decimals of time, drive and position in a recording.
pub const DECIMALS: [usize; 3] = [6, 6, 3];

/// A mechanism with its excitation and the noise of its read-out; position in arcseconds, drive in amperes.
#[derive(Debug, Clone, PartialEq)]
pub struct Bench {
    /// The mechanism and what is hidden in it.
    pub model: Model,
    /// With what it is driven.
    pub excitation: Excitation,
    /// Root mean square of the drive in A.
    pub drive_a: f64,
    /// Time from sample to sample in seconds.
    pub sample_s: f64,
    /// Samples of a run, or of a period where it is periodic.
    pub samples: usize,
    /// Periods in the steady state that are recorded; none where the recording begins at rest.
    pub periods: Option<u32>,
    /// Independent runs, each with an excitation of its own.
    pub runs: u32,
    /// Standard deviation of the noise of the position in arcseconds.
    pub noise_arcsec: f64,
    /// Its kind; every sample for itself, or alike in samples that follow soon.
    pub noise: Noise,
}

impl Bench {
    /// The mirror of `seed`: a resonance between 20 and 45 Hz, damped by 6 to 20 % of the critical damping,
    /// deflected by about 1500″ (rms), recorded from rest for 8 s at 2 kHz with a multisine up to 120 Hz.
    pub fn from_seed(seed: u64) -> Self {
        let mut generator = stream(seed, Stream::Device);
        let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
        let omega = std::f64::consts::TAU * uniform(20.0, 45.0);
        let damping = 2.0 * uniform(0.06, 0.2) * omega;
        let drive_a = uniform(0.04, 0.1);
        let deflection_arcsec = uniform(1100.0, 2000.0);
        let hold = match uniform(0.0, 3.0) {
            u if u < 1.0 => Hold::ZeroOrder,
            u if u < 2.0 => Hold::FirstOrder,
            _ => Hold::BandLimited,
        };
        let model = Model {
            damping,
            stiffness: omega * omega,
            gains: vec![1.0],
            effects: Vec::new(),
            hold,
            context: Context { feedback: false },
        };
        let mut bench = Self {
            model,
            excitation: Excitation::Multisine { highest_hz: 120.0, odd: false },
            drive_a,
            sample_s: 5e-4,
            samples: 16_384,
            periods: None,
            runs: 1,
            noise_arcsec: 0.9,
            noise: Noise::White,
        };
        // The gain is what deflects the mirror that far.
        let unit = Typical::of(&bench.model, &[bench.drive(seed, 0)], bench.sample_s);
        bench.model.gains = vec![deflection_arcsec / unit.position];
        bench
    }

    /// The same with these effects hidden in it.
    ///
    /// # Errors
    /// An effect that is not known or makes no sense.
    pub fn with_effects(&self, effects: Vec<PlantEffect>) -> Result<Self, EffectError> {
        Ok(Self { model: self.model.with(effects)?, ..self.clone() })
    }

    /// Typical sizes of the motion of the bare mechanism.
    pub fn typical(&self, seed: u64) -> Typical {
        let typical = Typical::of(&self.model, &[self.drive(seed, 0)], self.sample_s);
        Typical { highest_hz: self.excitation.highest_hz(), ..typical }
    }

    /// The drive of a run (of a period, where it is periodic), as the converter puts it out.
    pub fn drive(&self, seed: u64, run: u32) -> Vec<f64> {
        let mut generator: ChaCha12Rng = stream(seed, Stream::Excitation(run));
        let samples = self.excitation.samples(self.samples, self.sample_s, &mut generator);
        samples.into_iter().map(|u| round_to(self.drive_a * u, DECIMALS[1] as i32)).collect()
    }

    /// The recording of `seed`.
    ///
    /// # Errors
    /// A mechanism that cannot be simulated.
    pub fn record(&self, seed: u64) -> Result<Series, RunError> {
        let mut series = self.record_noiseless(seed)?;
        for run in 1..=self.runs {
            let mut source = Source::start(&self.noise, 1, stream(seed, Stream::ReadOut(run)));
            for row in 0..series.t_s.len() {
                if series.run.as_ref().is_none_or(|runs| runs[row] == i64::from(run)) {
                    series.positions[0][row] += self.noise_arcsec * source.draw(0, series.t_s[row]);
                }
            }
        }
        let places = DECIMALS[2] as i32;
        series.positions[0].iter_mut().for_each(|position| *position = round_to(*position, places));
        Ok(series)
    }

    /// The recording of `seed` without noise and rounding.
    ///
    /// # Errors
    /// A mechanism that cannot be simulated.
    pub fn record_noiseless(&self, seed: u64) -> Result<Series, RunError> {
        let (mut t_s, mut drives, mut positions) = (Vec::new(), Vec::new(), Vec::new());
        let mut run_of = (self.runs > 1).then(Vec::new);
        let mut period_of = self.periods.map(|_| Vec::new());
        for run in 1..=self.runs {
            let one = self.drive(seed, run - 1);
            let (drive, start) = match self.periods {
                None => (one, REST),
                Some(periods) => (one.repeat(periods as usize), Start::Steady { period: self.samples }),
            };
            let count = drive.len();
            let position = self.model.simulate(std::slice::from_ref(&drive), self.sample_s, start)?;
            t_s.extend((0..count).map(|k| k as f64 * self.sample_s));
            if let Some(runs) = &mut run_of {
                runs.resize(runs.len() + count, i64::from(run));
            }
            if let Some(periods) = &mut period_of {
                periods.extend((0..count).map(|k| 1 + (k / self.samples) as i64));
            }
            drives.extend(drive);
            positions.extend(position);
        }
        Ok(Series {
            t_s: t_s.into(),
            run: run_of,
            period: period_of,
            drives: vec![drives.into()],
            positions: vec![positions.into()],
            ..Series::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rms(values: &[f64]) -> f64 {
        (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
    }

    #[test]
    fn a_recording_comes_again_from_its_seed_and_has_its_noise() {
        let bench = Bench { samples: 4096, ..Bench::from_seed(5) };
        let recorded = bench.record(9).unwrap();
        assert_eq!(recorded, bench.record(9).unwrap());
        let clean = bench.record_noiseless(9).unwrap();
        let noise: Vec<f64> =
            recorded.positions[0].iter().zip(&clean.positions[0]).map(|(a, b)| a - b).collect();
        // Five standard errors of a deviation from 4096 values.
        assert!((rms(&noise) / 0.9 - 1.0).abs() < 5.0 / 8192f64.sqrt(), "{}", rms(&noise));
        let follows: f64 = noise.windows(2).map(|n| n[0] * n[1]).sum::<f64>() / 4096.0 / 0.81;
        assert!(follows.abs() < 5.0 / 64.0);
        let coloured = Bench { noise: Noise::Autocorrelated { correlation_time_s: 2e-3 }, ..bench };
        let recorded = coloured.record(9).unwrap();
        let noise: Vec<f64> =
            recorded.positions[0].iter().zip(&clean.positions[0]).map(|(a, b)| a - b).collect();
        let follows: f64 = noise.windows(2).map(|n| n[0] * n[1]).sum::<f64>() / 4096.0 / 0.81;
        assert!((follows - (-0.25f64).exp()).abs() < 0.2, "{follows}");
        assert!(rms(&clean.positions[0]) > 500.0);
    }

    #[test]
    fn a_steady_state_repeats_and_runs_differ() {
        let bench = Bench { samples: 2048, periods: Some(2), runs: 2, ..Bench::from_seed(6) };
        let series = bench.record_noiseless(3).unwrap();
        assert_eq!(series.t_s.len(), 8192);
        let x = &series.positions[0];
        let apart: Vec<f64> = (0..2048).map(|k| x[k] - x[k + 2048]).collect();
        assert!(rms(&apart) < 1e-4, "{}", rms(&apart));
        assert!(rms(&(0..2048).map(|k| x[k] - x[k + 4096]).collect::<Vec<_>>()) > 100.0);
    }
}
