//! The report: one self-contained HTML page per recording, for light and dark, desk and phone.

mod charts;
mod compare;
mod formula;
mod map;
mod partial;
mod spectra;
mod surface;
mod traces;

pub use compare::{compared, of_comparison};
use fitter::figures;
use fitter::plant::Kind;
use minijinja::{Value, context};
use pages::{Beside, Figure, environment};
use serde::Serialize;

use crate::diagnosis::{Diagnosis, Outcome};
use crate::dynamic::{DynamicOutcome, DynamicRecording};
use crate::thresholds::report::MOST_CHARTS;
use crate::verdict::{Location, NamedEffect, Parameter, Verdict, angle_name};

/// What a page shows beside the answer itself.
#[derive(Serialize)]
struct Page<'a> {
    answer: &'a Diagnosis,
    beside: &'a Beside,
    /// Unit of the root mean squares, and what they are of.
    unit: &'a str,
    of: &'static str,
    /// What was recorded, and how it was modelled.
    recorded: String,
    model: String,
    sentence: String,
    effects: Vec<Value>,
    plant: Vec<Value>,
    /// The mismatch map, and how to read it.
    map: Option<(String, String)>,
    /// Gain and resonances by amplitude.
    growth: Vec<Value>,
    /// Everything that is modelled in one line.
    formula: Option<String>,
    sections: Vec<Section>,
}

/// Charts under one title.
#[derive(Serialize)]
struct Section {
    title: &'static str,
    /// How its figures are read; blank where they say it.
    note: String,
    figures: Vec<Figure>,
}

impl Page<'_> {
    fn render(&self) -> String {
        let mut environment = environment();
        environment.add_filter("digits", digits);
        environment.add_filter("figure", |value: Option<f64>, unit: &str| {
            value.map_or("–".to_string(), |value| figure(value, unit))
        });
        environment.add_filter("gain", |gain: Value, unit: &str| -> Result<String, minijinja::Error> {
            let ci95 = gain.get_attr("ci95")?;
            let end = |k: usize| ci95.get_item(&k.into()).and_then(f64::try_from);
            let value = f64::try_from(gain.get_attr("value")?)?;
            Ok(typeset(&figures::with_interval(value, [end(0)?, end(1)?], unit)))
        });
        environment.add_filter("percent", percent);
        environment.add_filter("probability", probability);
        environment.add_filter("readable", |variable: &str| readable(variable));
        let page = environment.render_named_str(
            "page.html",
            include_str!("page.html"),
            minijinja::value::Serde(self),
        );
        page.unwrap_or_else(|error| {
            format!("<!doctype html><title>report</title><p>The report could not be rendered: {error}</p>")
        })
    }
}

/// The page of a calibration.
pub fn page(outcome: &Outcome, beside: &Beside) -> String {
    let d = &outcome.diagnosis;
    let (rows, passes) = (outcome.rows.len(), outcome.rows.passes().len());
    let (before, after) = (residual(outcome, false), residual(outcome, true));
    let mut shown: Vec<(String, Option<String>)> =
        d.locations.iter().map(|l| (l.variable.clone(), l.times.clone())).take(MOST_CHARTS).collect();
    for usual in [angle_name(&outcome.rows), "t_s".into()] {
        if shown.len() < 2 && !shown.iter().any(|(v, _)| *v == usual) {
            shown.push((usual, None));
        }
    }
    let chart = |(variable, times): &(String, Option<String>)| {
        charts::residuals(outcome, variable, times.as_deref(), &before, &after)
    };
    let model = if d.effects.is_empty() { LOCATED } else { NAMED };
    let residuals = Section {
        title: "Residual before and after",
        note: format!("Before: {SIMULATION}; after: {model}. Lines are running means."),
        figures: shown.iter().map(chart).collect(),
    };
    let parts = Section {
        title: "What the effects add",
        note: "Dots: the residual with the effect's own part. Band: 95 %, for the shape that was found."
            .into(),
        figures: partial::figures(outcome, &after),
    };
    let scatter = scatter(&after, &format!("the residual {model}"), &d.noise_floor.unit);
    let mut sections = vec![parts, residuals, scatter];
    sections.retain(|section| !section.figures.is_empty());
    let base = formula::base(outcome);
    Page {
        answer: d,
        beside,
        unit: &d.noise_floor.unit,
        of: "rms",
        recorded: format!("{rows} readings in {}", plural(passes, "pass", "passes")),
        model: format!("; base: {base}"),
        sentence: sentence(d, &d.noise_floor.unit),
        effects: d.effects.iter().map(catalogued).collect(),
        plant: Vec::new(),
        map: Some(map::mismatch(outcome, &before, &after)),
        growth: Vec::new(),
        sections,
        formula: formula::of_calibration(d, &base),
    }
    .render()
}

/// The page of a moving mechanism: spectra and traces are of `recording` itself, the figures of the held-out one
/// where one was given.
pub fn of_motion(recording: &DynamicRecording, outcome: &DynamicOutcome, beside: &Beside) -> String {
    let d = &outcome.diagnosis;
    let plant = &outcome.plant.plant;
    let feedback = plant.feedback.is_some();
    let unit = if feedback { &plant.drive_unit } else { &plant.position_unit };
    let spectra = if feedback { Vec::new() } else { spectra::charts(recording, &outcome.own, unit) };
    let surface =
        if plant.kind == Kind::SecondOrder { surface::charts(recording, plant) } else { Vec::new() };
    let growth = spectra::growth_rows(recording).into_iter().map(|g| {
        context! {
            amplitude => digits(g.amplitude),
            gain => digits(g.gain),
            phase => digits(g.phase_rad.to_degrees()),
            resonances => g.resonances_hz.iter().map(|f| digits(*f)).collect::<Vec<_>>().join(", "),
        }
    });
    let periods = if recording.period.is_some() { " Noise is from repeated periods." } else { "" };
    let mut sections = vec![Section {
        title: "Spectra",
        note: format!("What is left before: by the {SIMULATION}; after: {NAMED}.{periods}"),
        figures: spectra,
    }];
    if !feedback {
        sections.extend(spectra::free(recording, unit));
        sections.extend(spectra::resonance(recording));
    }
    let left = traces::left(recording, &outcome.own, feedback);
    sections.extend([
        Section {
            title: "Restoring force",
            note: "The acceleration that the nominal plant alone does not account for; orange: positive, blue: negative."
                .into(),
            figures: surface,
        },
        Section {
            title: "Simulated against recorded",
            note: format!("Before: {SIMULATION}; after: {NAMED}."),
            figures: traces::charts(recording, &outcome.own, unit, feedback),
        },
        scatter(&left, &format!("what is left {NAMED}"), unit),
    ]);
    sections.retain(|section| !section.figures.is_empty());
    let runs = plural(recording.runs.len(), "run", "runs");
    Page {
        answer: d,
        beside,
        unit,
        of: if feedback { "rms of the drive" } else { "rms of the position" },
        recorded: format!("{} rows in {runs} at {} Hz", recording.rows(), digits(1.0 / recording.step_s)),
        model: String::new(),
        sentence: sentence(d, unit),
        effects: d.effects.iter().map(effect).collect(),
        plant: d.plant.iter().map(parameter).collect(),
        map: None,
        growth: growth.collect(),
        sections,
        formula: formula::of_motion(d, &outcome.plant),
    }
    .render()
}

const SIMULATION: &str = "simulation alone";
const NAMED: &str = "with the named effects";
const LOCATED: &str = "with the named effects and what was located";

/// How the residual is distributed.
fn scatter(residual: &[f64], whose: &str, unit: &str) -> Section {
    let figures = pages::distribution(residual, "", whose, unit);
    Section { title: "Is the residual noise?", note: String::new(), figures }
}

fn plural(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// Residual of the base alone, or of the augmented model, row by row.
fn residual(outcome: &Outcome, augmented: bool) -> Vec<f64> {
    let model = if augmented { &outcome.after } else { &outcome.before };
    outcome.rows.error.iter().zip(model.value()).map(|(e, v)| e - v).collect()
}

/// The verdict in a sentence.
fn sentence(d: &Diagnosis, unit: &str) -> String {
    let names: Vec<String> = d.effects.iter().map(|e| e.title.clone()).collect();
    let names = match names.len() {
        0 | 1 => names.concat(),
        n => format!("{} and {}", names[..n - 1].join(", "), names[n - 1]),
    };
    let places: Vec<String> = d.locations.iter().take(2).map(place).collect();
    let depends = match places.len() {
        0 => String::new(),
        _ => format!(" depends on {}", places.join(" and on ")),
    };
    let open = d.effects.iter().any(|e| !e.alternatives.is_empty());
    let caveat =
        if open { " This recording alone cannot exclude the alternatives listed below." } else { "" };
    let held = match (d.fit.before.held_out_rms, d.fit.after.held_out_rms) {
        (Some(b), Some(a)) => {
            format!(" On held-out data the error falls from {} to {} rms.", figure(b, unit), figure(a, unit))
        }
        _ => String::new(),
    };
    match d.verdict {
        Verdict::Consistent => format!(
            "The recording agrees with its simulation: nothing is found beyond a noise of {} per reading.",
            figure(d.noise_floor.value, unit)
        ),
        Verdict::Explained | Verdict::Described => {
            format!(
                "The recording departs from its simulation: {names}; what is left is noise.{held}{caveat}"
            )
        }
        Verdict::PartlyExplained => format!(
            "The recording departs from its simulation: {names}. Something else is in it that no effect in the catalogue \
             explains: the error{depends}.{held}{caveat}"
        ),
        Verdict::Unexplained => format!(
            "The recording departs from its simulation: the error{depends}, in a way that no effect in the catalogue \
             explains."
        ),
    }
}

fn place(location: &Location) -> String {
    match &location.times {
        Some(times) => format!("{} × {}", readable(&location.variable), readable(times)),
        None => readable(&location.variable),
    }
}

/// An effect for its card.
fn effect(e: &NamedEffect) -> Value {
    context! {
        id => &e.id,
        title => &e.title,
        formula => formula::of_effect(e),
        correctable => e.runtime_correctable,
        share => e.share,
        p_value => e.p_value,
        parameters => e.parameters.iter().map(parameter).collect::<Vec<_>>(),
        alternatives => e.alternatives.iter().map(|a| a.replace('_', " ")).collect::<Vec<_>>(),
        readings => &e.form.readings,
        declaration => &e.form.declaration,
    }
}

/// The same with what the catalogue says of it.
fn catalogued(e: &NamedEffect) -> Value {
    let listed = crate::effects::listed();
    let known = listed.iter().find(|c| c.id == e.id).map(|c| {
        context! {
            source => &c.source,
            size => &c.size,
            confused => c.confused_with.iter().map(|id| id.replace('_', " ")).collect::<Vec<_>>().join(", "),
        }
    });
    context! { known => known, ..effect(e) }
}

/// In per cent, without decimals.
fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share.min(1.0))
}

/// A column's name for a reader.
fn readable(variable: &str) -> String {
    match variable {
        "angle_deg" => "angle (deg)",
        "t_s" => "time (s)",
        "temperature_c" => "temperature (°C)",
        "common_mode_um" => "common mode (µm)",
        "cross_arcsec" => "second axis (arcsec)",
        "coil_a" => "coil current (A)",
        "frequency_hz" => "frequency (Hz)",
        other => match other.strip_prefix("position_") {
            Some(unit) => return format!("position ({unit})"),
            None => other,
        },
    }
    .to_string()
}

/// A parameter for the table of an effect.
fn parameter(p: &Parameter) -> minijinja::Value {
    let ([value, from, to], unit) = figures::cells(p.value, p.ci95, &p.unit);
    context! {
        name => without_unit(&p.name, &p.unit),
        value => typeset(&value),
        unit => if unit == "1" { String::new() } else { unit },
        from => typeset(&from),
        to => typeset(&to),
    }
}

/// A parameter's name without the unit that stands beside its value.
pub fn without_unit(name: &str, unit: &str) -> String {
    let unit = unit.split(['/', '^', '·']).next().unwrap_or_default().to_lowercase();
    name.split('_').take_while(|word| *word != unit).collect::<Vec<_>>().join(" ")
}

/// Four significant digits.
fn digits(value: f64) -> String {
    typeset(&figures::plain(value))
}

/// A root mean square with its unit.
fn figure(value: f64, unit: &str) -> String {
    typeset(&figures::figure(value, unit))
}

/// With the sign that is as wide as a digit.
fn typeset(text: &str) -> String {
    text.replace('-', "−")
}

/// A probability in text: one digit and its power of ten where it is small; below 10⁻¹² no model of noise holds.
pub fn probability(p: f64) -> String {
    if p < 1e-12 {
        "< 10⁻¹²".into()
    } else if p < 1e-3 {
        let exponent = p.log10().floor();
        let digits = format!("{}", -exponent);
        let raised: String =
            digits.chars().filter_map(|c| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(c as usize - 48)).collect();
        format!("{:.0}·10⁻{raised}", (p / 10f64.powf(exponent)).min(9.0))
    } else {
        format!("{p:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::{probability, without_unit};

    #[test]
    fn names_and_probabilities_read_well() {
        assert_eq!(without_unit("time_constant_s", "s"), "time constant");
        assert_eq!(without_unit("coefficient_arcsec_per_k", "arcsec/K"), "coefficient");
        assert_eq!(without_unit("harmonics", "1"), "harmonics");
        assert_eq!(probability(2.2e-8), "2·10⁻⁸");
        assert_eq!(probability(0.25), "0.250");
    }
}
