//! Order selection of a 210-row recording: 100 repeated 70/30 splits over orders 1–15, the jackknife over
//! passes included. Figure to hold: under 20 ms. The whole fit stands beside it.

use criterion::{Criterion, criterion_group, criterion_main};
use fitter::{Options, choose_order, fit};

fn order_selection(criterion: &mut Criterion) {
    let (recording, mirror) = fitter::default_recording().expect("the embedded recording is sound");
    assert_eq!(recording.rows(), 210);
    let options = Options::default();
    assert_eq!((options.splits.count, options.candidates.clone()), (100, 1..=15));
    criterion.bench_function("order selection, 210 rows, 100 splits, orders 1 to 15", |bencher| {
        bencher.iter(|| choose_order(&recording, &mirror, &options));
    });
    criterion.bench_function("whole fit, 210 rows", |bencher| {
        bencher.iter(|| fit(&recording, &mirror, &options));
    });
}

criterion_group!(benches, order_selection);
criterion_main!(benches);
