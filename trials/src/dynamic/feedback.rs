//! Recordings under feedback: the mirror in its position loop, with and without an effect concealed in it. What
//! is predicted there is the drive, and what raises a false alarm is another thing than in an open mechanism.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use fitter::plant::{Hold, PlantEffect};
use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use twin::Device;
use twin::dynamic::effects::find;
use twin::dynamic::{Context, Model, PositionLoop, Typical};

use crate::answer::Answer;
use crate::error::CampaignError;
use crate::programs::{Nominal, Programs};
use crate::score::{Figure, Share};
use crate::workspace::{Batches, Folders, answer_of, put, threads};

/// What the programs are told.
const PLANT: &str = include_str!("feedback.toml");
/// Rows of a recording: eight seconds.
const ROWS: usize = 16_384;
/// Samples of the controller per second.
const RATE_HZ: f64 = 2000.0;
/// Noise of the recorded angle in arcseconds, beside the loop's own.
const NOISE_ARCSEC: f64 = 0.3;
/// Effects that a motion under feedback shows.
const CONCEALED: [&str; 8] = [
    "coulomb_friction",
    "stribeck_friction",
    "cubic_stiffness",
    "quadratic_stiffness",
    "quadratic_damping",
    "bouc_wen_hysteresis",
    "cogging",
    "torque_constant_droop",
];
/// What is in every such recording: the lag of amplifier and coils, and half a sample of the held drive.
const ALWAYS: [&str; 3] = ["drive_lag", "transport_delay", "sensor_lag"];

/// One recording.
struct Trial {
    stem: String,
    concealed: Option<&'static str>,
}

/// Conceals, records, has diagnosed and scores: every second recording is a null.
///
/// # Errors
/// [`CampaignError`].
pub fn run(
    programs: &Programs,
    count: usize,
    seed: u64,
    jobs: usize,
    out: &Path,
) -> Result<Vec<Figure>, CampaignError> {
    let folders = Folders::prepare(out, Nominal::Plant, PLANT)?;
    programs.begin("recording", count);
    let draw = |number: usize| -> Result<Trial, CampaignError> {
        let trial = Trial {
            stem: format!("f{number:06}"),
            concealed: (number % 2 == 1).then(|| CONCEALED[number / 2 % CONCEALED.len()]),
        };
        let text = record(trial.concealed, seed.wrapping_mul(1_000_003).wrapping_add(number as u64))?;
        put(&folders.blind.join(format!("{}.csv", trial.stem)), &text)?;
        programs.watch.advance(1);
        Ok(trial)
    };
    let trials: Vec<Trial> =
        threads(jobs)?.install(|| (0..count).into_par_iter().map(draw).collect::<Result<_, _>>())?;
    let files: Vec<String> = trials.iter().map(|t| format!("{}.csv", t.stem)).collect();
    programs.begin("diagnosing", files.len());
    let batches = Batches { programs, nominal: Nominal::Plant, jobs };
    batches.diagnose(&folders.blind, &files, &folders.diagnosed, None)?;

    let (mut alarms, mut named, mut alone) = (Share::default(), Share::default(), Share::default());
    for trial in &trials {
        let answer = answer_of(&folders.diagnosed, &trial.stem)?;
        match trial.concealed {
            None => alarms.count(answer.as_ref().is_none_or(|a| !beyond_the_loop(a).is_empty())),
            Some(id) => {
                let said = answer.as_ref().map(beyond_the_loop).unwrap_or_default();
                named.count(said.first() == Some(&id));
                alone.count(said == [id]);
            }
        }
    }
    Ok(vec![
        Figure::reported("under feedback: false alarms on nulls, the amplifier's lag apart", alarms),
        Figure::reported("under feedback: single effects named first, that lag apart", named),
        Figure::reported("under feedback: and no other", alone),
    ])
}

/// The named effects that are not of the loop itself.
fn beyond_the_loop(answer: &Answer) -> Vec<&str> {
    answer.effects.iter().map(|e| e.id.as_str()).filter(|id| !ALWAYS.contains(id)).collect()
}

/// A recording as text: a mirror of 20 to 45 Hz that follows slow sines of about 0.3° (rms).
fn record(concealed: Option<&str>, seed: u64) -> Result<String, CampaignError> {
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
    let mut plan = PositionLoop {
        omega_rad_per_s: TAU * uniform(20.0, 45.0),
        damping_ratio: uniform(0.06, 0.2),
        rate_hz: RATE_HZ,
        bandwidth_rad_per_s: uniform(180.0, 260.0),
        ..PositionLoop::default()
    };
    let tones: Vec<[f64; 3]> =
        (0..8).map(|_| [uniform(0.2, 8.0), uniform(0.0, TAU), uniform(0.1f64, 0.2).to_radians()]).collect();
    let strength = uniform(0.02f64.ln(), 0.1f64.ln()).exp();
    let command: Vec<f64> = (0..ROWS)
        .map(|k| {
            let t = k as f64 / RATE_HZ;
            tones.iter().map(|[hz, phase, size]| size * (TAU * hz * t + phase).sin()).sum()
        })
        .collect();
    let device = Device::from_seed(seed);
    let correct = |x1: f64, x2: f64| device.probes.error.true_angle_rad(x2 - x1);
    if let Some(specification) = concealed.and_then(find) {
        // Sizes of the motion without it.
        let bare = plan.run(&device, &command, &correct, seed)?;
        let drive: Vec<f64> = bare.iter().map(|s| s.drive_a).collect();
        let stiffness = plan.omega_rad_per_s.powi(2);
        let model = Model {
            damping: 2.0 * plan.damping_ratio * plan.omega_rad_per_s,
            stiffness,
            gains: vec![stiffness / device.drive.stiffness_a_per_rad],
            effects: Vec::new(),
            hold: Hold::ZeroOrder,
            context: Context { feedback: false },
        };
        let typical = Typical { highest_hz: 8.0, ..Typical::of(&model, &[drive], 1.0 / RATE_HZ) };
        let drawn = (specification.draw)(strength, &typical, &mut generator);
        plan.effects.push(PlantEffect::new(specification.id, &drawn));
    }
    let arcsec = |angle_rad: f64| angle_rad.to_degrees() * 3600.0;
    let mut text = String::from("t_s,drive,position,command\n");
    for sample in plan.run(&device, &command, &correct, seed)? {
        // The sum of twelve uniform numbers is as good as normal.
        let noise = NOISE_ARCSEC * ((0..12).map(|_| generator.random::<f64>()).sum::<f64>() - 6.0);
        let (angle, wanted) = (arcsec(sample.true_rad) + noise, arcsec(sample.command_rad));
        // Writing to memory does not fail.
        let _ = writeln!(text, "{:.6},{:.6},{angle:.3},{wanted:.3}", sample.t_s, sample.drive_a);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_comes_again_from_its_seed_and_follows_its_command() {
        let text = record(Some("cubic_stiffness"), 7).unwrap();
        assert_eq!(text, record(Some("cubic_stiffness"), 7).unwrap());
        assert_ne!(text, record(None, 7).unwrap());
        let rows: Vec<Vec<f64>> =
            text.lines().skip(1).map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        assert_eq!(rows.len(), ROWS);
        let rms = |of: &dyn Fn(&Vec<f64>) -> f64| {
            (rows.iter().map(|r| of(r).powi(2)).sum::<f64>() / rows.len() as f64).sqrt()
        };
        // The loop lags behind a command of a few hertz, but follows it.
        assert!(rms(&|r| r[2] - r[3]) < 0.5 * rms(&|r| r[3]));
    }
}
