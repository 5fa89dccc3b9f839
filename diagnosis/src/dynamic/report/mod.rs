//! The report of a dynamic recording: one self-contained HTML page, in the design of the static one.

mod draw;
mod spectra;
mod surface;
mod traces;

use fitter::plant::Kind;
use minijinja::context;

use super::{DynamicOutcome, DynamicRecording};
use crate::report::{class, digits, environment, figure, parameter, probability, word};
use crate::verdict::{Location, Verdict};

/// The page of one recording. `held_out` is the recording that the outcome's figures are of, where one was
/// given; the spectra and traces are of `recording` itself.
pub fn page(recording: &DynamicRecording, outcome: &DynamicOutcome) -> String {
    let d = &outcome.diagnosis;
    let plant = &outcome.plant.plant;
    let feedback = plant.feedback.is_some();
    let unit = if feedback { &plant.drive_unit } else { &plant.position_unit };
    let locations: Vec<_> = d
        .locations
        .iter()
        .map(|l| {
            context! {
                variable => place(l),
                from => digits(l.from),
                to => digits(l.to),
                share => format!("{:.0} %", 100.0 * l.share.min(1.0)),
                p => probability(l.p_value),
            }
        })
        .collect();
    let effects: Vec<_> = d
        .effects
        .iter()
        .map(|e| {
            context! {
                id => e.id.clone(),
                title => e.title.clone(),
                share => format!("{:.0} %", 100.0 * e.share),
                p => probability(e.p_value),
                parameters => e.parameters.iter().map(parameter).collect::<Vec<_>>(),
                alternatives => e.alternatives.iter().map(|a| a.replace('_', " ")).collect::<Vec<_>>(),
            }
        })
        .collect();
    let rms = |v: Option<f64>| v.map_or("–".to_string(), |v| figure(v, unit));
    let fit = &d.fit;
    let spectra = if feedback { Vec::new() } else { spectra::charts(recording, &outcome.own, unit) };
    let growth: Vec<_> = spectra::growth_rows(recording)
        .into_iter()
        .map(|g| {
            context! {
                amplitude => digits(g.amplitude),
                gain => digits(g.gain),
                phase => digits(g.phase_rad.to_degrees()),
                resonances => g.resonances_hz.iter().map(|f| digits(*f)).collect::<Vec<_>>().join(", "),
            }
        })
        .collect();
    let surface =
        if plant.kind == Kind::SecondOrder { surface::charts(recording, plant) } else { Vec::new() };
    let traces = traces::charts(recording, &outcome.own, unit, feedback);
    let chart = |(title, svg): &(String, String)| context! { title => title, svg => svg };
    let values = context! {
        recording => d.recording.clone(),
        verdict => word(d.verdict),
        class => class(d.verdict),
        sentence => sentence(outcome, unit),
        floor => figure(d.noise_floor.value, unit),
        floor_from => d.noise_floor.from.clone(),
        correlation => digits(d.noise_floor.autocorrelation),
        rows => recording.rows(),
        runs => recording.runs.len(),
        periodic => recording.period.is_some(),
        rate => digits(1.0 / recording.step_s),
        predicted => if feedback { "drive" } else { "position" },
        spectra => spectra.iter().map(chart).collect::<Vec<_>>(),
        surface => surface.iter().map(chart).collect::<Vec<_>>(),
        traces => traces.iter().map(chart).collect::<Vec<_>>(),
        growth => growth,
        locations => locations,
        effects => effects,
        plant => d.plant.iter().map(parameter).collect::<Vec<_>>(),
        judged => d.judged.clone(),
        held_out_by => fit.held_out_by.clone(),
        before_train => rms(Some(fit.before.train_rms)),
        before_held => rms(fit.before.held_out_rms),
        after_train => rms(Some(fit.after.train_rms)),
        after_held => rms(fit.after.held_out_rms),
        unidentifiable => d.unidentifiable.clone(),
        next => d.next_experiment.clone(),
    };
    // The template is part of the program and rendered by a test: it cannot fail on other data.
    environment().render_named_str("dynamic.html", include_str!("page.html"), values).unwrap_or_else(
        |error| {
            format!("<!doctype html><title>report</title><p>The report could not be rendered: {error}</p>")
        },
    )
}

/// The verdict in a sentence.
fn sentence(outcome: &DynamicOutcome, unit: &str) -> String {
    let d = &outcome.diagnosis;
    let names: Vec<String> = d.effects.iter().map(|e| e.title.clone()).collect();
    let names = match names.len() {
        0 | 1 => names.concat(),
        n => format!("{} and {}", names[..n - 1].join(", "), names[n - 1]),
    };
    let held = match (d.fit.before.held_out_rms, d.fit.after.held_out_rms) {
        (Some(before), Some(after)) => format!(
            " On held-out data the error of the free simulation falls from {} to {} rms.",
            figure(before, unit),
            figure(after, unit)
        ),
        _ => String::new(),
    };
    let alternatives = d.effects.iter().any(|e| !e.alternatives.is_empty());
    let caveat =
        if alternatives { " This recording alone cannot exclude the alternatives listed below." } else { "" };
    let places: Vec<String> = d.locations.iter().take(2).map(place).collect();
    let where_it_is =
        if places.is_empty() { String::new() } else { format!(" on {}", places.join(" and on ")) };
    match d.verdict {
        Verdict::Consistent => format!(
            "The recording agrees with its simulation: nothing is found beyond {} per reading.",
            figure(d.noise_floor.value, unit)
        ),
        Verdict::Explained => format!(
            "The recording departs from its simulation by {names}; what is left is noise.{held}{caveat}"
        ),
        Verdict::PartlyExplained => format!(
            "The recording departs from its simulation by {names}; with that, something is left that no effect \
             in the catalogue explains.{held}{caveat}"
        ),
        Verdict::Unexplained => format!(
            "The recording departs from its simulation: the error depends{where_it_is}, in a way that no effect in \
             the catalogue explains."
        ),
    }
}

fn place(location: &Location) -> String {
    let name = |variable: &str| match variable {
        "frequency_hz" => "frequency (Hz)".to_string(),
        other => crate::report::readable(other),
    };
    match &location.times {
        Some(times) => format!("{} × {}", name(&location.variable), name(times)),
        None => name(&location.variable),
    }
}
