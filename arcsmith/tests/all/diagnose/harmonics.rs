//! A steep periodic error is handed on as it will be used: fitted to the corrected reading, with as many harmonics
//! as are asked for.

use std::path::Path;

use crate::diagnose::common::{run, scene};
use fitter::terms::Operator;
use fitter::{Coefficients, Recording};

const PERIOD: f64 = 0.25;
/// cos and sin of harmonics 1 … 3 of the true position: a slope of up to a half.
const HARMONICS: [[f64; 2]; 3] = [[-0.016, 0.012], [0.0014, 0.0], [0.0, -0.0009]];

/// One move over eleven periods: `measured` and `reference` in mm, read to half a micrometre.
fn recording(path: &Path) {
    let mut text = String::from("t_s,pass,direction,measured,reference\n");
    for i in 0..900 {
        let truth = 1.0 + 0.003 * f64::from(i);
        let error: f64 = (1..)
            .zip(HARMONICS)
            .map(|(k, [a, b])| {
                let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) * truth / PERIOD).sin_cos();
                a * cosine + b * sine
            })
            .sum();
        // Rounding alone would repeat with the period: a scatter that does not.
        let scatter = 2e-4 * (f64::from((i * 7919) % 101) / 50.5 - 1.0);
        text += &format!("{:.2},0,1,{:.6},{:.6}\n", 0.01 * f64::from(i), truth + error + scatter, truth);
    }
    std::fs::write(path, text).expect("a file");
}

fn rms(recording: &Recording, file: &Coefficients) -> f64 {
    let applied = fitter::apply(recording, file).expect("corrected readings");
    let fitter::recording::Readings::Direct { reference: Some(reference), .. } = &recording.readings else {
        panic!("a direct sensor with a reference")
    };
    let errors: Vec<f64> = applied.corrected.iter().zip(reference).map(|(c, r)| c - r).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn one_harmonic_is_fitted_without_the_others() {
    let scene = scene();
    let folder = scene.folder.path();
    let (path, mirror) = (folder.join("stage.csv"), folder.join("stage.toml"));
    recording(&path);
    std::fs::write(&mirror, "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n").expect("a file");
    let text = |p: &Path| p.display().to_string();
    let mut files = Vec::new();
    for (name, more) in [("all", &[][..]), ("one", &["--harmonics", "1"][..])] {
        let out = folder.join(name);
        let (recording, mirror, out_text) = (text(&path), text(&mirror), text(&out));
        let mut arguments = vec![&*recording, "--mirror", &mirror, "--out", &out_text, "--no-report"];
        arguments.extend(more);
        let output = run(&arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        files.push(fitter::coefficients::read(&out.join("stage.coefficients.json")).expect("coefficients"));
    }
    let [all, one] = &files[..] else { panic!("two files") };
    let numbers = |file: &Coefficients| match &file.terms[0].operator {
        Operator::Periodic(periodic) => periodic.harmonics.clone(),
        other => panic!("{other:?}"),
    };
    assert!(numbers(all).starts_with(&[1, 2, 3]), "{:?}", numbers(all));
    assert_eq!(numbers(one), [1]);
    assert_eq!(one.terms[0].covariance.len(), 2);

    // Cutting the others off leaves more than fitting without them.
    let mut cut = all.clone();
    cut.terms[0].coefficients[2..].fill(0.0);
    let recording = Recording::read(&path).expect("the recording");
    let [all, one, cut] = [all, one, &cut].map(|file| rms(&recording, file));
    // 0.2 µm evenly distributed to either side is 0.115 µm rms, up to twice that on the steepest flank.
    assert!(all < 2.5e-4, "{all}");
    assert!(one < 0.99 * cut && one > 2.0 * all, "one {one}, cut {cut}, all {all}");
}
