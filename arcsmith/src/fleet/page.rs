//! `fleet.html`: the page over all units.

use diagnosis::fleet::FALSE_ALARMS;
use diagnosis::report::{probability, without_unit};
use fitter::figures::{figure, with_interval};
use minijinja::{Value, context};
use pages::{Beside, Chart, Colour, Figure, Mark, Series, environment};

use super::results::Results;
use super::summary::{LEFT, Parameter, Summary};

/// Rows of a table, and parameters that are drawn, at most; the tables hold all.
const MOST_ROWS: usize = 50;
const MOST_DRAWN: usize = 10;
/// Points with error bars, at most.
const MOST_BARS: usize = 200;
/// Columns of a histogram, at most.
const MOST_COLUMNS: f64 = 60.0;

/// The page.
pub fn page(summary: &Summary, results: &Results, beside: &Beside) -> String {
    let parameters = &summary.parameters;
    let rows =
        |of: &dyn Fn(&Parameter) -> Option<Value>| parameters.iter().filter_map(of).collect::<Vec<Value>>();
    let lots = |one: &Parameter| {
        let lots = one.lots.as_ref().filter(|lots| lots.means.p_value < FALSE_ALARMS)?;
        let mean = |(name, (mean, ci95)): (&String, (&f64, &[f64; 2]))| {
            format!("{name}: {}", with_interval(*mean, *ci95, &one.unit_of_measure))
        };
        let means = lots.means.means.iter().zip(&lots.means.ci95);
        let means: Vec<String> = lots.lots.iter().zip(means).map(mean).take(MOST_ROWS).collect();
        Some(
            context! { name => name(&one.effect, &one.parameter, &one.unit_of_measure), means, p => probability(lots.means.p_value) },
        )
    };
    let change = |one: &Parameter, change: f64, ci95: [f64; 2], p: f64, what: &str| {
        let value = with_interval(change, ci95, &one.unit_of_measure);
        context! { name => name(&one.effect, &one.parameter, &one.unit_of_measure), value, p => probability(p), what }
    };
    let trends = |one: &Parameter| {
        let trend = one.trend.as_ref().filter(|trend| trend.p_value < FALSE_ALARMS)?;
        Some(change(one, trend.slope, trend.ci95, trend.p_value, "per unit of time"))
    };
    let drifts = |one: &Parameter| {
        let drift = one.drift.as_ref()?;
        let what = if drift.of_same_units { "same units" } else { "two fleets" };
        let moved = drift.p_value < FALSE_ALARMS;
        let row = change(one, drift.change, drift.ci95, drift.p_value, what);
        Some(context! { moved, ..row })
    };
    let outlying = summary.outlying.iter().take(MOST_ROWS).map(|one| {
        let what = name(&one.effect, &one.parameter, &one.unit_of_measure);
        let value = figure(one.value, &one.unit_of_measure);
        context! { unit => &*one.unit, what, value, z => format!("{:+.1}", one.z), p => probability(one.p_value) }
    });
    let figures: Vec<Figure> = parameters
        .iter()
        .filter(|one| one.pooled.spread > 0.0)
        .take(MOST_DRAWN)
        .enumerate()
        .flat_map(|(k, one)| drawn(k + 1, one, results))
        .collect();
    let failed = summary
        .failed
        .iter()
        .take(MOST_ROWS)
        .map(|one| context! { unit => &*one.unit, error => &*one.error });
    let values = context! {
        units => summary.units,
        failures => summary.failed.len(),
        failed => failed.collect::<Vec<_>>(),
        verdicts => &summary.verdicts,
        physics => summary.physics.iter().map(|one| context! {
            effect => one.effect.replace('_', " "), units => one.units, share => format!("{:.1} %", 100.0 * one.share),
            lots => one.by_lot.iter().map(|(lot, count)| format!("{lot}: {count}")).take(MOST_ROWS).collect::<Vec<_>>().join(", "),
        }).collect::<Vec<_>>(),
        shown => parameters.iter().filter(|one| one.shown_by_fleet.is_some()).map(sentence).collect::<Vec<_>>(),
        common => rows(&|one| one.common.then(|| pooled(one))),
        differs => rows(&|one| (!one.common).then(|| pooled(one))),
        lots => rows(&lots),
        trends => rows(&trends),
        drifts => rows(&drifts),
        outlying => outlying.collect::<Vec<_>>(),
        departing => summary.outlying.len(),
        most => MOST_ROWS,
        figures => minijinja::value::Serde(&figures),
        beside => minijinja::value::Serde(beside),
    };
    environment().render_named_str("page.html", include_str!("page.html"), values).unwrap_or_else(|error| {
        format!("<!doctype html><title>fleet</title><p>The page could not be rendered: {error}</p>")
    })
}

/// A parameter's name for a reader, without the unit that stands beside its value.
pub fn name(effect: &str, parameter: &str, unit_of_measure: &str) -> String {
    let parameter = match parameter {
        LEFT => "rms of what is left".to_string(),
        other => without_unit(other, unit_of_measure),
    };
    format!("{effect} {parameter}").trim().replace('_', " ")
}

/// What the fleet shows of a parameter.
pub fn sentence(one: &Parameter) -> String {
    let Parameter { pooled, unit_of_measure, named_by, .. } = one;
    let at = if one.at.is_empty() { String::new() } else { format!(" at {}", one.at) };
    let instead = match &one.alternatives[..] {
        [] => String::new(),
        others => format!(", or {}", others.join(", ")),
    };
    let mean = with_interval(pooled.mean, pooled.mean_ci95, unit_of_measure);
    let spread = with_interval(pooled.spread, pooled.spread_ci95, unit_of_measure);
    format!(
        "{}{at}{instead}: mean {mean}, spread between units {spread}; named in {named_by} of {} units",
        name(&one.effect, &one.parameter, &one.unit_of_measure),
        pooled.units
    )
}

fn pooled(one: &Parameter) -> Value {
    let Parameter { pooled, unit_of_measure: unit, .. } = one;
    context! {
        name => name(&one.effect, &one.parameter, &one.unit_of_measure),
        at => &*one.at,
        of => if one.of_every_unit { "every unit" } else { "units that name it" },
        units => pooled.units,
        mean => with_interval(pooled.mean, pooled.mean_ci95, unit),
        spread => with_interval(pooled.spread, pooled.spread_ci95, unit),
        p => probability(pooled.p_same),
    }
}

/// How a parameter is distributed, and its course over time where units have one.
fn drawn(number: usize, one: &Parameter, results: &Results) -> Vec<Figure> {
    let values: Vec<f64> = one.estimates.iter().map(|(_, estimate)| estimate.value).collect();
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let title = name(&one.effect, &one.parameter, &one.unit_of_measure);
    let axis = format!("{} ({})", without_unit(&one.parameter, &one.unit_of_measure), one.unit_of_measure);
    let caption = match one.of_every_unit {
        true => format!("Estimates of {} units, each with its own error.", values.len()),
        false => format!("Of the {} units that name the effect, which favours large values.", values.len()),
    };
    // The square root of their number (Sturges is too few for hundreds of units).
    let count = (values.len() as f64).sqrt().ceil().clamp(1.0, MOST_COLUMNS);
    let width = ((high - low) / count).max(f64::MIN_POSITIVE);
    let mut heights = vec![0.0; count as usize];
    values
        .iter()
        .for_each(|value| heights[(((value - low) / width) as usize).min(count as usize - 1)] += 1.0);
    let columns =
        (0..).zip(heights).map(|(k, height)| (low + width * (f64::from(k) + 0.5), height)).collect();
    let histogram = Chart {
        label: "Histogram of the units",
        x: axis.clone(),
        y: "units".into(),
        series: vec![Series::new("", Mark::Columns, Colour::Second, columns)],
    };
    let mut figures = vec![Figure::of(&format!("distribution-{number}"), &title, caption, histogram)];
    let timed: Vec<(f64, f64, f64)> = (one.estimates.iter())
        .filter_map(|(k, estimate)| {
            Some((results.units[*k].unit.time?, estimate.value, 2.0 * estimate.error))
        })
        .collect();
    if !timed.is_empty() {
        let points = timed.iter().map(|(time, value, _)| (*time, *value)).collect();
        let few = timed.len() <= MOST_BARS;
        let bars = timed.iter().filter(|_| few).map(|(_, _, half)| *half).collect();
        let mark = if few { Mark::Dots } else { Mark::Haze };
        let course = Chart {
            label: "Estimates over time",
            x: "time".into(),
            y: axis,
            series: vec![Series::new("", mark, Colour::First, points).with_bars(bars)],
        };
        let caption = if few { "Bars are two standard errors." } else { "Without error bars." }.to_string();
        figures.push(Figure::of(&format!("time-{number}"), &format!("{title} over time"), caption, course));
    }
    figures
}
