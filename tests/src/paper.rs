//! The paper's experiment on simulated mirrors: calibrate, fit, generate, put the generated q31 routine into
//! the loop, verify. One seed is one device with its calibration and its verification.

use codegen::interpret::{Word, interpret};
use codegen::options::{Options, RoutineOptions};
use codegen::{format::Format, input, routine};
use fitter::order::OrderScore;
use fitter::{Mirror, Recording};
use rayon::prelude::*;
use twin::{Device, Protocol, Reading};

/// The figures of one device, in arcseconds unless they say otherwise.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Seed of device and calibration.
    pub seed: u64,
    /// Largest angular error before the correction, in degrees.
    pub before_deg: f64,
    /// The order that was chosen.
    pub order: usize,
    /// Training and testing errors of all candidate orders.
    pub curve: Vec<OrderScore>,
    /// The largest fit error of the averaged points (the paper's Figure 7b).
    pub fit_error: f64,
    /// The largest mean error of a point within ±1.3° after the correction (Figure 9b).
    pub mean_error: f64,
    /// As `mean_error`, of all points, ±1.4°.
    pub mean_error_all: f64,
    /// The largest standard deviation of a point after the correction (Figure 10).
    pub deviation: f64,
    /// Root mean square of all mean errors.
    pub mean_error_rms: f64,
    /// The bound of the generated routine.
    pub bound: f64,
}

/// Verification angles beyond this, in degrees, stand at the edge of what was calibrated.
const INNER_DEG: f64 = 1.3;

/// The recording of a verification is another one than that of the calibration: other noise, another zero.
const VERIFICATION_SEED: u64 = 1 << 32;

/// Full scale of the displacements' Q31 words in millimetres; the probes measure 0.5 mm.
const FULL_SCALE_MM: f64 = 0.5;

/// The calibration recording of a device, as a user has it: through the text of the file.
///
/// # Panics
/// Where the simulation writes what the fitter refuses.
pub fn calibration(device: &Device, seed: u64) -> Recording {
    let d = device.geometry.probe_distance_mm;
    let log =
        twin::record(device, &Protocol::calibration(), seed, &|x1, x2| twin::calculated_angle_rad(x1, x2, d));
    let mut text = Vec::new();
    twin::write_csv(&log, &mut text).unwrap_or_else(|e| panic!("writing into memory: {e}"));
    Recording::from_bytes("calibration.csv", &text).unwrap_or_else(|e| panic!("{e}"))
}

/// The routine that goes into the loop: two displacements as Q31 words in, an integer angle out.
pub fn loop_options() -> Options {
    let input = input::Input {
        arity: input::Arity::Probes,
        encoding: input::Encoding::Q31 { full_scale: Some(FULL_SCALE_MM) },
    };
    Options {
        routines: vec![RoutineOptions { input, ..RoutineOptions::of(Format::Q31) }],
        ..Options::default()
    }
}

/// A displacement in millimetres as the word that the loop's routine takes.
pub fn displacement_word(x_mm: f64) -> i32 {
    (x_mm / FULL_SCALE_MM * 2f64.powi(31)).round() as i32
}

/// A verification recording of `device` with `angle_rad` (of two words, in radians) as feedback.
pub fn verification(device: &Device, seed: u64, angle_rad: &dyn Fn(i32, i32) -> f64) -> Vec<Reading> {
    twin::record(device, &Protocol::verification(), seed + VERIFICATION_SEED, &|x1, x2| {
        angle_rad(displacement_word(x1), displacement_word(x2))
    })
}

/// The whole experiment for one seed.
///
/// # Panics
/// Where a step of it fails, which none may.
pub fn experiment(seed: u64) -> Outcome {
    let device = Device::from_seed(seed);
    let recording = calibration(&device, seed);
    let fit = fitter::fit(&recording, &Mirror::paper(), &fitter::Options::default())
        .unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    let options = loop_options();
    let routine = routine::design(&fit.coefficients, &options, &options.routines[0])
        .unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    let (program, lsb_rad) = (&routine.design.program, routine.design.unit.to_f64());
    let angle_rad = |x1: i32, x2: i32| {
        let arguments = [Word::Int(x1.into()), Word::Int(x2.into())];
        match interpret(program, &arguments).unwrap_or_else(|e| panic!("seed {seed}: {e}")).word {
            Word::Int(angle) => angle as f64 * lsb_rad,
            Word::Float(_) => unreachable!("the routine returns an integer"),
        }
    };
    let points = errors_by_point(&verification(&device, seed, &angle_rad), &angle_rad);
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0f64, |max, v| max.max(v.abs()));
    let statistics = fit.coefficients.statistics.as_ref().unwrap_or_else(|| panic!("a fit has statistics"));
    let inner = |p: &&Point| p.command_deg.abs() <= INNER_DEG;
    Outcome {
        seed,
        before_deg: statistics.before.max / 3600.0,
        order: fit.coefficients.base.order,
        curve: fit.coefficients.order_selection.map(|selection| selection.curve).unwrap_or_default(),
        fit_error: statistics.after.max_of_point_means,
        mean_error: largest(&mut points.iter().filter(inner).map(|p| p.mean)),
        mean_error_all: largest(&mut points.iter().map(|p| p.mean)),
        deviation: largest(&mut points.iter().map(|p| p.deviation)),
        mean_error_rms: (points.iter().map(|p| p.mean * p.mean).sum::<f64>() / points.len() as f64).sqrt(),
        bound: routine.design.bound.total * fitter::units::ARCSEC_PER_RAD,
    }
}

/// What was measured at one commanded angle after the correction.
struct Point {
    command_deg: f64,
    mean: f64,
    deviation: f64,
}

/// Mean and standard deviation, in arcseconds, of corrected less measured angle at every commanded angle. The
/// zero of the autocollimator is its mean reading where the corrected angle is commanded to be 0 (Eq. 7).
fn errors_by_point(log: &[Reading], angle_rad: &dyn Fn(i32, i32) -> f64) -> Vec<Point> {
    let error = |r: &Reading| {
        let corrected_rad = angle_rad(displacement_word(r.x1_mm), displacement_word(r.x2_mm));
        corrected_rad * fitter::units::ARCSEC_PER_RAD - r.reference_arcsec
    };
    let mut commands: Vec<f64> = log.iter().map(|r| r.command_deg).collect();
    commands.sort_by(f64::total_cmp);
    commands.dedup();
    let at =
        |command: f64| -> Vec<f64> { log.iter().filter(|r| r.command_deg == command).map(error).collect() };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let zero = mean(&at(0.0));
    let point = |&command_deg: &f64| {
        let errors = at(command_deg);
        let middle = mean(&errors);
        let squares: f64 = errors.iter().map(|e| (e - middle) * (e - middle)).sum();
        let deviation = (squares / (errors.len() as f64 - 1.0)).sqrt();
        Point { command_deg, mean: middle - zero, deviation }
    };
    commands.iter().map(point).collect()
}

/// The experiment for the seeds 1 to `count`, on all processors; in the order of the seeds.
pub fn campaign(count: u64) -> Vec<Outcome> {
    (1..=count).into_par_iter().map(experiment).collect()
}

/// The share of outcomes for which something holds.
pub fn share(outcomes: &[Outcome], holds: impl Fn(&Outcome) -> bool) -> f64 {
    outcomes.iter().filter(|o| holds(o)).count() as f64 / outcomes.len() as f64
}

/// The value below which a part `at` of the outcomes lies.
pub fn quantile(outcomes: &[Outcome], at: f64, value: impl Fn(&Outcome) -> f64) -> f64 {
    let mut values: Vec<f64> = outcomes.iter().map(value).collect();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * at).round() as usize]
}

/// Training and testing error of an order, root mean square over the outcomes that have it.
pub fn curve(outcomes: &[Outcome], order: usize) -> Option<(f64, f64)> {
    let scores: Vec<&OrderScore> =
        outcomes.iter().flat_map(|o| o.curve.iter().filter(|score| score.order == order)).collect();
    let root_mean = |value: &dyn Fn(&OrderScore) -> f64| {
        (scores.iter().map(|score| value(score).powi(2)).sum::<f64>() / scores.len() as f64).sqrt()
    };
    (!scores.is_empty()).then(|| (root_mean(&|s| s.training), root_mean(&|s| s.testing)))
}
