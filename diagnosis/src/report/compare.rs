//! The page of two recordings that were compared.

use fitter::figures;
use minijinja::context;
use numerics::{mean, range};
use pages::{Beside, Chart, Colour, Figure, Mark, Series, environment};

use super::{digits, figure, probability, readable, typeset};
use crate::compare::{Comparison, Estimate, Kind, Points};
use crate::thresholds::report::charts::BINS;

fn how(kind: Kind) -> &'static str {
    match kind {
        Kind::Came => "came",
        Kind::Went => "went",
        _ => "changed",
    }
}

/// What changed in one sentence.
pub fn compared(c: &Comparison) -> String {
    let of: Vec<String> =
        c.changes.iter().map(|change| format!("{} {}", change.id, how(change.kind))).collect();
    let (then, now) = (&c.then.recording, &c.now.recording);
    match of.is_empty() {
        true => format!("{then} and {now}: nothing changed"),
        false => format!("{now} against {then}: {}", of.join(", ")),
    }
}

/// The page; in motion there are no points.
pub fn of_comparison(c: &Comparison, points: Option<&Points>, beside: &Beside) -> String {
    let estimate = |e: &Option<Estimate>, unit: &str| {
        e.as_ref().map_or("–".into(), |e| typeset(&figures::with_interval(e.value, e.ci95, unit)))
    };
    let change = |change: &crate::compare::Change| {
        let parameters = change.parameters.iter().map(|q| {
            context! {
                name => q.name.as_str(),
                then => estimate(&q.then, &q.unit),
                now => estimate(&q.now, &q.unit),
                difference => estimate(&q.difference, &q.unit),
            }
        });
        let place = change.place.as_ref().map(|place| {
            let times = place.times.as_ref().map_or_else(String::new, |t| format!(" × {}", readable(t)));
            format!("{}{times}, {} to {}", readable(&place.variable), digits(place.from), digits(place.to))
        });
        context! {
            id => change.id.as_str(),
            title => change.title.as_str(),
            how => how(change.kind),
            place,
            p => probability(change.p_value),
            rms => change.rms.map(|rms| figure(rms, &c.unit)),
            parameters => parameters.collect::<Vec<_>>(),
            alternatives => change.alternatives.clone(),
            same => change.held_out.as_ref().map(|h| figure(h.same, &c.unit)),
            changed => change.held_out.as_ref().map(|h| figure(h.changed, &c.unit)),
            gain => change.held_out.as_ref().map(|h| {
                typeset(&figures::with_interval(h.gain.value, h.gain.ci95, &c.unit))
            }),
        }
    };
    let visible = |v: &crate::compare::Visible| {
        let parameter = v.parameter.as_ref().map(|(name, value)| format!("{name} {}", digits(*value)));
        context! { id => v.id.as_str(), rms => v.rms.map(|rms| figure(rms, &c.unit)), parameter }
    };
    let side = |s: &crate::compare::Side| {
        context! {
            recording => s.recording.as_str(),
            verdict => s.verdict.word().replace('_', " "),
            effects => s.effects.join(", "),
            noise => figure(s.noise, &c.unit),
        }
    };
    let page = environment().render_named_str(
        "compare.html",
        include_str!("compare.html"),
        context! {
            verdict => c.verdict,
            notes => c.notes.clone(),
            sentence => compared(c),
            sides => [side(&c.then), side(&c.now)],
            changes => c.changes.iter().map(change).collect::<Vec<_>>(),
            left => c.left.map(|left| figure(left, &c.unit)),
            visible => c.would_have_seen.iter().map(visible).collect::<Vec<_>>(),
            alarms => format!("{:.2} %", 100.0 * c.false_alarms),
            difference => points.map(|points| difference(c, points)),
            beside => minijinja::value::Serde(beside),
        },
    );
    page.unwrap_or_else(|error| {
        format!("<!doctype html><title>comparison</title><p>The page could not be rendered: {error}</p>")
    })
}

/// What the model of the earlier recording leaves of the later one, and what the changes say of it.
fn difference(c: &Comparison, Points { variable, rows }: &Points) -> String {
    let unit = &c.unit;
    let mut points = rows.clone();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let size = points.len().div_ceil(BINS).max(1);
    let of = |chunk: &[[f64; 3]], k: usize| mean(&chunk.iter().map(|p| p[k]).collect::<Vec<f64>>());
    let running = |k: usize| points.chunks(size).map(|chunk| (of(chunk, 0), of(chunk, k))).collect();
    let (low, high) = range(&points.iter().map(|p| p[1]).collect::<Vec<f64>>());
    let mut series = vec![
        Series::new(
            "left now where nothing differs",
            Mark::Haze,
            Colour::First,
            points.iter().map(|p| (p[0], p[1])).collect(),
        ),
        Series::new("", Mark::Curve, Colour::First, running(1)),
    ];
    if !c.changes.is_empty() && high > low {
        series.push(Series::new("the changes", Mark::Curve, Colour::Second, running(2)));
    }
    let chart = Chart {
        label: "What a common model leaves of the later recording",
        x: readable(variable),
        y: format!("left ({unit})"),
        series,
    };
    Figure::of("difference", "", String::new(), chart).svg().to_string()
}
