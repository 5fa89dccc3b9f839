//! A whole `codegen` run without arguments: the embedded recording is fitted, both routines are designed and
//! bounded, everything is rendered and written. Figure to hold: under 2 s.

use codegen::generate::generate;
use codegen::options::Options;
use codegen::source::Source;
use criterion::{Criterion, criterion_group, criterion_main};

fn codegen_run(criterion: &mut Criterion) {
    let options = Options::default();
    let mut group = criterion.benchmark_group("codegen");
    group.sample_size(10);
    group.bench_function("whole run, embedded recording, q31 and f32", |bencher| {
        bencher.iter(|| {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let (coefficients, sha256) = Source::Embedded.load().expect("the embedded recording is sound");
            let generated = generate(&coefficients, &sha256, &options).expect("the default has its routines");
            let written =
                codegen::files::write(folder.path(), &generated.files).expect("the folder is empty");
            assert_eq!(written, generated.files.len());
        });
    });
    group.finish();
}

criterion_group!(benches, codegen_run);
criterion_main!(benches);
