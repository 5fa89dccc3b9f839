//! False alarms, and the detection of single effects.

use serde::Serialize;

use super::{Case, Figure, Share, Sheet, Unsealed};
use crate::answer::Answer;
use crate::benchmark;
use crate::curve::{self, Curve};
use crate::plan::FAMILIES;
use crate::statistics::{lower_limit, quantile, upper_limit};
use crate::truth::Group;

/// Nulls of one noise family that it takes to show the figure.
const NULLS: u64 = 2000;

/// False alarms of one noise family.
#[derive(Debug, Clone, Serialize)]
pub struct FalseAlarms {
    /// The family.
    pub family: String,
    /// How many of how many nulls.
    pub share: Share,
    /// One-sided upper 95 % limit (Clopper–Pearson).
    pub upper: f64,
}

pub(super) fn figures(cases: &[Case], sheet: &mut Sheet) -> (Vec<FalseAlarms>, Option<Curve>, Option<Curve>) {
    let mut families = Vec::new();
    let mut all = Share::default();
    for (family, _) in FAMILIES {
        let nulls = cases.iter().filter(|c| c.truth.group == Group::Null && c.truth.family == family);
        let quiet = sheet.share("false alarm", nulls, |_, answer| !answer.detects());
        let share = Share { hits: quiet.of - quiet.hits, of: quiet.of };
        (all.hits, all.of) = (all.hits + share.hits, all.of + share.of);
        let upper = upper_limit(share.hits, share.of, 0.95);
        let few = share.of < NULLS;
        let remark = if few { format!(" (fewer than {NULLS})") } else { String::new() };
        sheet.figures.push(Figure {
            figure: format!("false alarms, {family} noise"),
            wanted: "≤ 1 %, upper limit ≤ 1.5 %".to_owned(),
            measured: match share.value() {
                Some(value) => format!(
                    "{:.2} % ({}/{}), upper limit {:.2} %{remark}",
                    100.0 * value,
                    share.hits,
                    share.of,
                    100.0 * upper
                ),
                None => "none".to_owned(),
            },
            // Fewer nulls can refute the figure, but not show it.
            passed: match share.value() {
                Some(_) if few && lower_limit(share.hits, share.of, 0.95) <= 0.01 => None,
                value => value.map(|value| value <= 0.01 && upper <= 0.015),
            },
        });
        families.push(FalseAlarms { family: family.to_owned(), share, upper });
    }

    let single = |c: &&Case| matches!(c.truth.group, Group::Weak | Group::Strong | Group::Step);
    let visible = cases.iter().filter(single).filter(|c| c.truth.least_rho() >= 6.0);
    sheet.least(("detection where ρ ≥ 6", 0.98), "detection, ρ ≥ 6", visible, |_, a| a.detects());

    let points: Vec<curve::Point> =
        cases.iter().filter(single).map(|c| (c.truth.least_rho(), c.said(Answer::detects))).collect();
    // No alarm among a number of nulls still has an expected rate: half an alarm more.
    let false_alarm = (all.hits as f64 + 0.5) / (all.of as f64 + 1.0);
    let curve = if all.of > 0 { curve::fit(&points, false_alarm.min(0.5)) } else { None };
    let measured = curve.as_ref().map_or("not determined".to_owned(), |c| {
        let Curve { half, width, shift, .. } = c;
        let ideal = 100.0 * c.false_alarm;
        format!("{shift:.2} (half at ρ {half:.2}, width {width:.2}; ideal at {ideal:.2} % false alarms)")
    });
    let figure = "shift in ρ of the detection curve from the ideal one";
    sheet.figures.push(Figure::new(figure, "≤ 0.7", measured, curve.as_ref().map(|c| c.shift <= 0.7)));
    let benchmark = benchmark_figures(cases, false_alarm, sheet);
    (families, curve, benchmark)
}

/// The detector that knows the noise and the formulas, and the answers to the same trials beside it.
fn benchmark_figures(cases: &[Case], false_alarm: f64, sheet: &mut Sheet) -> Option<Curve> {
    let shown: Vec<(&Case, bool)> = cases.iter().filter_map(|c| Some((c, c.benchmark?))).collect();
    let points = |hit: &dyn Fn(&Case, bool) -> bool| -> Vec<curve::Point> {
        shown.iter().map(|(c, found)| (c.truth.least_rho(), hit(c, *found))).collect()
    };
    let informed = curve::fit(&points(&|_, found| found), benchmark::FALSE_ALARMS);
    let ours = curve::fit(&points(&|c, _| c.said(Answer::detects)), false_alarm.min(0.5));
    let mut tell = |figure: &str, measured: Option<String>| {
        let measured = measured.unwrap_or_else(|| "not determined".to_owned());
        sheet.figures.push(Figure::noted(figure, measured));
    };
    tell(
        "the same shift of a detector that knows the noise and searches the table alone",
        informed.as_ref().map(|c| format!("{:.2} (half at ρ {:.2}, width {:.2})", c.shift, c.half, c.width)),
    );
    tell(
        "shift of the answers from that detector, on the same trials",
        informed.as_ref().zip(ours.as_ref()).map(|(informed, ours)| {
            let ninety = |c: &Curve| c.half + quantile(0.9) * c.width;
            format!(
                "{:.2} at one half, {:.2} at nine tenths",
                ours.half - informed.half,
                ninety(ours) - ninety(informed)
            )
        }),
    );
    informed
}
