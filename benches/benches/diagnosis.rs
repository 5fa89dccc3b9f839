//! Diagnosis of a 210-row recording, report apart: once with nothing in it, once with a step of the mount.
//! Figure to hold: under 50 ms on two cores.

use criterion::{Criterion, criterion_group, criterion_main};
use diagnosis::{Options, diagnose};
use fitter::Recording;
use fitter::recording::Readings;

/// Height of the step in arcsec, four times the scatter of a reading.
const STEP_ARCSEC: f64 = 2.0;

fn with_step(recording: &Recording) -> Recording {
    let mut stepped = recording.clone();
    let from = recording.rows() / 2;
    if let Readings::Pair { reference_arcsec: Some(reference), .. } = &mut stepped.readings {
        reference[from..].iter_mut().for_each(|r| *r -= STEP_ARCSEC);
    }
    stepped
}

fn diagnosis(criterion: &mut Criterion) {
    let (recording, mirror) = fitter::default_recording().expect("the embedded recording is sound");
    assert_eq!(recording.rows(), 210);
    let options = Options::default();
    for (name, recording) in [("nothing", recording.clone()), ("a step", with_step(&recording))] {
        criterion.bench_function(&format!("diagnosis, 210 rows with {name} in them"), |bencher| {
            bencher.iter(|| diagnose(&recording, &mirror, None, None, &options).expect("a diagnosis"));
        });
    }
}

criterion_group!(benches, diagnosis);
criterion_main!(benches);
