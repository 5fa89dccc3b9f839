//! The real recording of a slit on a stage, whose encoder has a periodic error: the figures that it must
//! show, where the folder with `slit-train.csv.gz`, `slit-test.csv.gz` and `slit.toml` is given.

use std::path::Path;

use fitter::Recording;
use fitter::recording::{Purpose, Readings};

use crate::answer::Answer;
use crate::error::CampaignError;
use crate::linear::deviation;
use crate::programs::{Nominal, Programs};
use crate::score::Figure;
use crate::workspace::unwritable;

/// The period of the slit in millimetres, and how well it must be found.
const PERIOD_MM: (f64, f64) = (0.25, 1e-4);
/// Largest rms in millimetres with the strongest harmonic alone, and with all that were found.
const RMS_MM: (f64, f64) = (2.5e-3, 1.0e-3);

/// Diagnoses `slit-train` of `folder` into `out` and tries the model on `slit-test`.
///
/// # Errors
/// [`CampaignError`].
pub fn figures(
    programs: &Programs,
    folder: &Path,
    out: &Path,
    jobs: usize,
) -> Result<Vec<Figure>, CampaignError> {
    let out = std::path::absolute(out).map_err(unwritable(out))?;
    std::fs::create_dir_all(&out).map_err(unwritable(&out))?;
    for (from, to) in [("slit-train.csv.gz", "slit-train.csv.gz"), ("slit.toml", "mirror.toml")] {
        std::fs::copy(folder.join(from), out.join(to)).map_err(unwritable(&folder.join(from)))?;
    }
    let refused = |program, what| move |reason| CampaignError::Refused { program, what, reason };
    let file = "slit-train.csv.gz";
    let one_folder = out.join("one-harmonic");
    for (into, options) in [(&out, &[][..]), (&one_folder, &["--harmonics", "1"][..])] {
        programs
            .diagnose(Nominal::Mirror, &out, &[file.to_owned()], into, options, jobs)?
            .map_err(refused("diagnose", file))?;
    }
    let answer = Answer::read(&out.join("slit-train.json"))?;
    let [one, all] = [&one_folder, &out].map(|into| into.join("slit-train.coefficients.json"));

    let test = folder.join("slit-test.csv.gz");
    let mut rms = Vec::new();
    for coefficients in [&one, &all] {
        let angles = coefficients.with_extension("csv");
        programs.apply(&test, coefficients, &angles)?.map_err(refused("apply", "slit-test.csv.gz"))?;
        rms.push(rms_mm(&test, &angles)?);
    }
    Ok(figures_of(&answer, rms[0], rms[1]))
}

fn figures_of(answer: &Answer, one_mm: f64, all_mm: f64) -> Vec<Figure> {
    let named = answer.effects.iter().find(|e| e.id == "periodic_error");
    let period = named.and_then(|e| e.parameters.iter().find(|p| p.name == "period_mm")).map(|p| p.value);
    let right = period.is_some_and(|p| (p - PERIOD_MM.0).abs() <= PERIOD_MM.1);
    let says =
        answer.unidentifiable.iter().any(|line| ["lag", "gain", "backlash"].iter().all(|w| line.contains(w)));
    let rms = |figure: &str, most: f64, measured: f64| {
        let (wanted, passed) = (format!("≤ {:.1} µm", 1e3 * most), measured <= most);
        Figure::new(figure, wanted, format!("{:.2} µm", 1e3 * measured), Some(passed))
    };
    let found = period.map_or_else(String::new, |period| format!("{period:.6} mm; "));
    vec![
        Figure::new(
            "slit-train: `periodic_error` first, and its period",
            "0.2500 ± 0.0001 mm",
            found + &answer.sentence(),
            Some(right && answer.first() == Some("periodic_error")),
        ),
        rms("slit-test, offset removed: rms with the strongest harmonic alone", RMS_MM.0, one_mm),
        rms("slit-test, offset removed: rms with all harmonics", RMS_MM.1, all_mm),
        Figure::new(
            "slit-train: says that one forward move cannot separate lag, gain and backlash",
            "said",
            if says { "said" } else { "not said" },
            Some(says),
        ),
    ]
}

/// rms in millimetres of corrected readings about the reference, their mean difference removed.
fn rms_mm(test: &Path, angles: &Path) -> Result<f64, CampaignError> {
    let recording = Recording::read_for(test, Purpose::Fit, &mut |_| {})?;
    let wrong = || CampaignError::Angles { path: angles.to_owned() };
    let Readings::Direct { reference: Some(reference), .. } = &recording.readings else {
        return Err(wrong());
    };
    let (corrected, _) = crate::fresh::read_column(angles, "corrected_mm").ok_or_else(wrong)?;
    if corrected.len() != reference.len() {
        return Err(wrong());
    }
    Ok(deviation(&corrected.iter().zip(reference).map(|(c, r)| c - r).collect::<Vec<f64>>()))
}
