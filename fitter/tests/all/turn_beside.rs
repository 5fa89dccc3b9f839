//! What a sensor that turns is corrected for beside its harmonics: a slope over the turn, and a lag.

use crate::common;

use std::fmt::Write;

use common::encoder::{Encoder, turning};
use common::normal;
use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Observables, Operator, Rate, Term};
use fitter::{Options, Recording, apply, fit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// A resolver on a drive that stands, turns forward, stands, turns back and stands: what it does wrong.
struct Resolver {
    /// The error grows by so many degrees in a turn.
    slope: f64,
    lag_s: f64,
    /// Standard deviation of a reading in degrees.
    noise: f64,
    /// Where the axis stands first, in degrees of the reading.
    start: f64,
    turns: f64,
    /// Only the way there, or only the way back.
    half: Option<bool>,
}

const RESOLVER: Resolver =
    Resolver { slope: -0.9, lag_s: 0.02, noise: 0.003, start: 0.3, turns: 1.0, half: None };

/// What four starts and stops at once leave in degrees: for as long as the lag the reading does not show that it moves.
const STARTS: f64 = 0.05;

impl Resolver {
    /// When it begins to turn, stops, begins to turn back, stops, and the recording ends: 10 s a turn.
    fn times(&self) -> [f64; 5] {
        [2.0, 12.0, 14.0, 24.0, 26.0].map(|time| time * self.turns)
    }

    /// Position at a time, in degrees from the start.
    fn position(&self, time: f64) -> f64 {
        let ([there, _, back, ..], way) = (self.times(), 10.0 * self.turns);
        let up = ((time - there) / way).clamp(0.0, 1.0) - ((time - back) / way).clamp(0.0, 1.0);
        360.0 * self.turns * up
    }

    fn csv(&self, seed: u64) -> String {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut text = String::from("t_s,pass,direction,measured,reference\n");
        let [from, to, again, until, end] = self.times();
        for row in 0..(100.0 * end) as usize {
            let time = 0.01 * row as f64;
            let back = time > 0.5 * (to + again);
            let (reference, seen) = (self.position(time), self.position(time - self.lag_s));
            let wave = 1.7 * (2.0 * seen.to_radians() - 1.2).cos() + 0.1 * (4.0 * seen.to_radians()).sin();
            let measured =
                seen + self.start + wave + self.slope * (seen / 360.0) + self.noise * normal(&mut random);
            if self.half.is_some_and(|half| half != back) {
                continue;
            }
            let turning = (from..to).contains(&time) || (again..until).contains(&time);
            let pass = 2 * i32::from(back) + i32::from(turning);
            let direction = if back && turning { -1 } else { 1 };
            let (measured, reference) = (measured.rem_euclid(360.0), reference.rem_euclid(360.0));
            writeln!(text, "{time:.2},{pass},{direction},{measured:.5},{reference:.5}").unwrap();
        }
        text
    }

    fn recording(&self, seed: u64) -> Recording {
        Recording::from_bytes("resolver.csv", self.csv(seed).as_bytes()).unwrap()
    }
}

fn fitted(recording: &Recording) -> fitter::Fit {
    fit(recording, &turning("deg", 360.0), &Options::default()).unwrap()
}

fn term<'a>(file: &'a Coefficients, effect: &str) -> Option<&'a Term> {
    file.terms.iter().find(|term| term.effect == effect)
}

/// Root mean square about the mean of what a file leaves of a recording's errors.
fn left(file: &Coefficients, recording: &Recording) -> f64 {
    let applied = apply(recording, file).unwrap();
    assert!(
        applied.extrapolated.iter().all(|outside| !outside) && applied.notes.is_empty(),
        "{:?}",
        applied.notes
    );
    let apart = |row: usize| {
        let apart = applied.corrected[row] - recording.reference(row).unwrap();
        apart - 360.0 * (apart / 360.0).round()
    };
    let errors: Vec<f64> = (0..recording.rows()).map(apart).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    (errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn lag_and_slope_are_found_wherever_the_reading_wraps_and_apply_takes_them_off() {
    for (seed, start) in [(1, 0.3), (2, 90.0), (3, 200.0), (4, 359.0)] {
        let recording = Resolver { start, ..RESOLVER }.recording(seed);
        let fit = fitted(&recording);
        let file = &fit.coefficients;
        let turn = file.turn.as_ref().unwrap();
        let lag = turn.directions.lag_s.as_ref().unwrap();
        assert!((lag.value - 0.02).abs() < 5e-4 && turn.directions.lag_corrected, "{start}: {lag:?}");
        let coefficient = term(file, "read_lag").unwrap().coefficients[0];
        assert!((coefficient + lag.value).abs() < 1e-9, "a reading behind has an error against its rate");
        let slope = turn.slope.as_ref().unwrap();
        assert!((slope.per_turn.value + 0.9).abs() < 0.02, "{start}: {slope:?}");
        assert!(slope.statement.contains("deg per turn, does not repeat"), "{}", slope.statement);
        assert!((turn.amplitudes[1].amplitude - 1.7).abs() < 0.01, "{:?}", turn.amplitudes);
        let (after, applied) = (file.statistics.as_ref().unwrap().after.rms, left(file, &recording));
        assert!(after < STARTS && (after - applied).abs() < 0.03 * after, "{start}: {after}, {applied}");
        // Harmonics alone leave the lag of 36 deg/s and the slope.
        let in_part = turn.left.as_ref().unwrap();
        assert!(in_part.harmonics_alone_rms > 0.5, "{in_part:?}");
        assert!(in_part.without_slope_rms > after && in_part.without_slope_rms < 0.3, "{in_part:?}");
        let said = &turn.directions.statement;
        assert!(said.contains("a lag of ") && said.contains("ms (corrected)"), "{said}");
    }
}

/// The way there corrects the way back, on whichever turn each recording began.
#[test]
fn one_way_corrects_the_other() {
    for start in [0.3, 120.0, 359.5] {
        let (there, back) = (
            Resolver { start, half: Some(false), ..RESOLVER }.recording(5),
            Resolver { start, half: Some(true), ..RESOLVER }.recording(6),
        );
        let (a, b) = (fitted(&there).coefficients, fitted(&back).coefficients);
        for (file, other) in [(&a, &back), (&b, &there)] {
            assert!(term(file, "turn_slope").is_some() && term(file, "read_lag").is_some());
            let rms = left(file, other);
            assert!(rms < STARTS, "{start}: {rms}");
        }
    }
}

#[test]
fn an_encoder_without_lag_and_slope_gets_neither() {
    for seed in 0..8 {
        for encoder in [
            Encoder { step_s: vec![0.01, 0.03], ..Encoder::eccentric(12 + (seed as u32 % 3) * 2) },
            Encoder { turns: 1, ..Encoder::eccentric(14) },
            Encoder { friction: 1e-3, ..Encoder::eccentric(14) },
        ] {
            let file = fitted(&encoder.recording(360.0, seed)).coefficients;
            assert_eq!(file.terms.len(), 1, "{seed}: {:?}", file.terms);
            let text = file.to_json();
            assert!(!["\"slope\": {", "lag_corrected", "\"left\""].iter().any(|key| text.contains(key)));
        }
    }
}

/// Friction and a lag at two speeds: the lag is corrected, the friction is told.
#[test]
fn friction_stays_beside_the_lag() {
    let both = Encoder { friction: 1e-3, lag_s: 2e-3, step_s: vec![0.01, 0.03], ..Encoder::eccentric(16) };
    let file = fitted(&both.recording(360.0, 5)).coefficients;
    let directions = &file.turn.as_ref().unwrap().directions;
    assert!(
        directions.lag_corrected && (directions.half_distance.as_ref().unwrap().value + 0.36).abs() < 0.01
    );
    assert!(directions.statement.contains("friction or backlash"), "{}", directions.statement);
}

/// Over several turns a slope is what accumulates; where nothing does there is none.
#[test]
fn a_slope_accumulates_over_several_turns() {
    let file = |slope: f64| {
        let recording = Resolver { turns: 3.0, slope, ..RESOLVER }.recording(7);
        let file = fitted(&recording).coefficients;
        assert!(left(&file, &recording) < STARTS);
        file
    };
    let growing = file(-0.9);
    let per_turn = growing.turn.as_ref().unwrap().slope.as_ref().unwrap().per_turn.value;
    assert!((per_turn + 0.9).abs() < 0.01, "{per_turn}");
    assert!(term(&file(0.0), "turn_slope").is_none());
}

#[test]
fn a_wrap_is_no_spike_in_a_rate() {
    let recording = Resolver { start: 120.0, ..RESOLVER }.recording(8);
    let sensor = Sensor::Direct { unit: "deg".into(), revolution: Some(360.0) };
    let rates = Operator::Rate(Rate::of("measured"))
        .columns(&Observables { recording: &recording, sensor: &sensor })
        .unwrap();
    let largest = rates[0].iter().fold(0.0f64, |max, rate| max.max(rate.abs()));
    assert!(largest < 45.0, "{largest}");
}

/// 359.95 and −0.05 degrees are the same place, in a file that knows the turn by its sensor alone as well.
#[test]
fn the_range_of_a_part_counts_within_the_turn() {
    let sensor = Sensor::Direct { unit: "deg".into(), revolution: Some(360.0) };
    let model = ErrorModel { sensor, centre: 0.0, coefficients: vec![0.5] };
    let file = Coefficients::of_model(&model, -20.0, 10.0, "by hand");
    let text = "t_s,pass,direction,measured,reference\n0,0,1,350,0\n1,0,1,-0.05,0\n2,0,1,359.95,0\n3,0,1,370,0\n4,0,1,90,0\n";
    let recording = Recording::from_bytes("part.csv", text.as_bytes()).unwrap();
    let applied = apply(&recording, &file).unwrap();
    assert_eq!(applied.extrapolated, [false, false, false, false, true]);
    for (corrected, expected) in applied.corrected.iter().zip([349.5, -0.55, 359.45, 369.5, 89.5]) {
        assert!((corrected - expected).abs() < 1e-9, "{corrected}");
    }
}

/// A recorded resolver: two periods of 1.7° in a turn, a lag of 34 ms, and −0.9° over the turn (reference fit: 0.047°).
#[test]
fn a_recorded_resolver() {
    let Some(folder) = std::env::var_os("ARCSMITH_RECORDINGS").map(std::path::PathBuf::from) else {
        println!("skipped: set ARCSMITH_RECORDINGS to a folder with resolver-3.csv.gz");
        return;
    };
    let read = |name: &str| Recording::read(&folder.join(name)).unwrap();
    let (whole, there, back) =
        (read("resolver-3.csv.gz"), read("resolver-3a.csv.gz"), read("resolver-3b.csv.gz"));
    let file = fitted(&whole).coefficients;
    let turn = file.turn.as_ref().unwrap();
    let (lag, slope) = (turn.directions.lag_s.as_ref().unwrap(), turn.slope.as_ref().unwrap());
    assert!(
        (lag.value - 0.034).abs() < 0.003 && (slope.per_turn.value + 0.9).abs() < 0.05,
        "{lag:?} {slope:?}"
    );
    assert!((turn.amplitudes[1].amplitude - 1.69).abs() < 0.02);
    let (rms, in_part) = (left(&file, &whole), turn.left.as_ref().unwrap());
    assert!(rms < 0.08 && in_part.without_slope_rms < 0.27, "{rms} {in_part:?}");
    let rms = left(&fitted(&there).coefficients, &back);
    assert!(rms < 0.18, "{rms}");
}
