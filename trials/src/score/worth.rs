//! What the augmented models are worth on fresh recordings of the same devices.

use serde::Serialize;
use twin::effects::{Scope, catalogue};

use super::{Case, Figure, Share, Sheet, Unsealed};
use crate::answer::Answer;
use crate::fresh::Fresh;
use crate::statistics::percentile;
use crate::truth::Group;

/// Worth on fresh recordings.
#[derive(Debug, Clone, Serialize)]
pub struct Worth {
    /// Recordings compared.
    pub compared: usize,
    /// Median and 95th percentile of rms / rms of a model that knows the effects.
    pub informed: Option<[f64; 2]>,
    /// The same beside a model that knows the covariance of the noise as well.
    pub fully_informed: Option<[f64; 2]>,
    /// Median and 95th percentile of rms / rms of the base model alone.
    pub base: Option<[f64; 2]>,
    /// Median and 95th percentile of the first, on rows inside the range of the coefficients alone.
    pub inside: Option<[f64; 2]>,
    /// Gains that were claimed, and how many of them were realised.
    pub realised: Share,
    /// Rows of the fresh recordings outside the range of the coefficients.
    pub extrapolated_rows: usize,
    /// All their rows.
    pub rows: usize,
}

pub(super) fn figures(cases: &[Case], sheet: &mut Sheet) -> Worth {
    let drawn = cases.iter().filter(|c| c.truth.group != Group::Twice);
    let compared: Vec<(&Case, &Fresh)> = drawn.filter_map(|c| c.fresh.as_ref().map(|f| (c, f))).collect();
    let of = |ratio: fn(&Fresh) -> Option<f64>| {
        let ratios: Vec<f64> = compared.iter().filter_map(|(_, fresh)| ratio(fresh)).collect();
        Some([percentile(&ratios, 0.5)?, percentile(&ratios, 0.95)?])
    };
    let informed = of(|f| Some(f.answer_arcsec / f.informed_arcsec));
    for (case, fresh) in &compared {
        let ratio = fresh.answer_arcsec / fresh.informed_arcsec;
        if ratio > 1.10 {
            sheet.miss("rms on a fresh recording", *case, format!("{ratio:.2} times; {}", case.sentence()));
        }
    }
    let wanted = [("median", 1.02), ("95th percentile", 1.10)];
    for (index, (word, most)) in wanted.into_iter().enumerate() {
        let figure = format!("rms on a fresh recording / that of a model told the ids, {word}");
        let measured =
            informed.map_or("none".to_owned(), |t| format!("{:.3} (of {})", t[index], compared.len()));
        let passed = informed.map(|t| t[index] <= most);
        sheet.figures.push(Figure::new(figure, format!("≤ {most:.2}"), measured, passed));
    }

    let inside = of(|f| Some(f.inside_ratio));
    let percentiles = inside.map_or("none".to_owned(), |[median, most]| format!("{median:.3}, {most:.3}"));
    let figure = "the same on rows inside the calibrated range alone: median, 95th percentile";
    sheet.figures.push(Figure::noted(figure, percentiles));

    let mut realised = Share::default();
    for (case, fresh) in &compared {
        let lasting = |id: &str| catalogue::find(id).is_some_and(|s| s.scope == Scope::Device);
        if !case.truth.effects.iter().all(|e| lasting(&e.id)) || !case.said(claims_gain) {
            continue;
        }
        let hit = fresh.answer_arcsec < fresh.base_arcsec;
        realised.count(hit);
        if !hit {
            let said =
                format!("rms {:.3} from {:.3}; {}", fresh.answer_arcsec, fresh.base_arcsec, case.sentence());
            sheet.miss("gain realised", *case, said);
        }
    }
    sheet.figures.push(Figure::at_least("gain claimed is realised on a fresh recording", 0.95, realised));
    Worth {
        compared: compared.len(),
        informed,
        fully_informed: of(|f| f.fully_informed_arcsec.map(|least| f.answer_arcsec / least)),
        base: of(|f| Some(f.answer_arcsec / f.base_arcsec)),
        inside,
        realised,
        extrapolated_rows: compared.iter().map(|(_, f)| f.extrapolated).sum(),
        rows: compared.iter().map(|(_, f)| f.rows).sum(),
    }
}

/// How much worse than the base alone a second recording of a device may come out with the handed-on model, and
/// how often of all devices; and what none may be.
const WORSE: (f64, f64) = (1.03, 0.003);
const MUCH_WORSE: f64 = 1.10;

/// Devices that were recorded twice: rms of the second by the model of the first / by the base alone of the first.
#[derive(Debug, Clone, Serialize)]
pub struct Harm {
    /// Devices compared.
    pub compared: usize,
    /// More than 3 % worse.
    pub worse: Share,
    /// More than 10 % worse.
    pub much_worse: Share,
    /// Median, 5th percentile (the gain) and the largest of the ratios.
    pub ratios: Option<[f64; 3]>,
}

pub(super) fn harm(cases: &[Case], sheet: &mut Sheet) -> Harm {
    let twice = cases.iter().filter(|c| c.truth.group == Group::Twice);
    let ratio = |case: &Case| case.fresh.as_ref().and_then(|f| Some(f.answer_arcsec / f.fit_arcsec?));
    let compared: Vec<(&Case, f64)> = twice.filter_map(|case| Some((case, ratio(case)?))).collect();
    let (mut worse, mut much_worse) = (Share::default(), Share::default());
    for (case, ratio) in &compared {
        worse.count(*ratio > WORSE.0);
        much_worse.count(*ratio > MUCH_WORSE);
        if *ratio > WORSE.0 {
            sheet.miss(
                "second recording",
                *case,
                format!("{ratio:.3} times the base alone; {}", case.sentence()),
            );
        }
    }
    for (share, limit, most) in [(worse, WORSE.0, WORSE.1), (much_worse, MUCH_WORSE, 0.0)] {
        if !compared.is_empty() {
            let worse = 100.0 * (limit - 1.0);
            let figure = format!("second recordings more than {worse:.0} % worse than by the base alone");
            sheet.figures.push(Figure::at_most(figure, most, share));
        }
    }
    let ratios: Vec<f64> = compared.iter().map(|(_, ratio)| *ratio).collect();
    let at = |part| percentile(&ratios, part);
    Harm {
        compared: compared.len(),
        worse,
        much_worse,
        ratios: at(0.5).zip(at(0.05)).zip(at(1.0)).map(|((median, gain), most)| [median, gain, most]),
    }
}

/// Whether an improvement is claimed: an interval above zero, or where there is none a smaller figure.
fn claims_gain(answer: &Answer) -> bool {
    match (&answer.fit.gain, answer.fit.before.held_out_rms, answer.fit.after.held_out_rms) {
        (Some(gain), ..) => gain.ci95[0] > 0.0,
        (None, Some(before), Some(after)) => after < before,
        _ => false,
    }
}
