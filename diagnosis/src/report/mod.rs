//! The report: one self-contained HTML page per recording, for light and dark, desk and phone.

pub(crate) mod charts;
mod map;

use fitter::faults::BadRow;
use fitter::figures;
use minijinja::{Environment, context};

use crate::diagnosis::Outcome;
use crate::verdict::{Parameter, Verdict, angle_name};

/// Most observables that get a chart of the residual.
const CHARTS: usize = 4;

/// The page.
pub fn page(outcome: &Outcome) -> String {
    let d = &outcome.diagnosis;
    let mut shown: Vec<(String, Option<String>)> =
        d.locations.iter().map(|l| (l.variable.clone(), l.times.clone())).take(CHARTS).collect();
    for usual in [angle_name(&outcome.rows), "t_s".into()] {
        if shown.len() < 2 && !shown.iter().any(|(v, _)| *v == usual) {
            shown.push((usual, None));
        }
    }
    let before = residual(outcome, false);
    let after = residual(outcome, true);
    let charts: Vec<_> = shown
        .iter()
        .map(|(variable, times)| {
            let title = match times {
                Some(times) => format!("{} (times {})", readable(variable), readable(times)),
                None => readable(variable),
            };
            context! {
                title => title,
                svg => charts::residuals(outcome, variable, times.as_deref(), &before, &after),
            }
        })
        .collect();
    let locations: Vec<_> = d
        .locations
        .iter()
        .map(|l| {
            context! {
                variable => readable(&l.variable),
                times => l.times.as_deref().map(readable),
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
            let catalogued = crate::effects::catalogue().into_iter().find(|c| c.id == e.id);
            context! {
                id => e.id.clone(),
                title => e.title.clone(),
                formula => catalogued.as_ref().map_or("", |c| c.formula),
                source => catalogued.as_ref().map_or("", |c| c.source),
                size => catalogued.as_ref().map_or("", |c| c.size),
                confused => catalogued.as_ref().map_or_else(String::new, |c| {
                    c.confused_with.iter().map(|id| id.replace('_', " ")).collect::<Vec<_>>().join(", ")
                }),
                share => format!("{:.0} %", 100.0 * e.share),
                p => probability(e.p_value),
                parameters => e.parameters.iter().map(parameter).collect::<Vec<_>>(),
                alternatives => e.alternatives.iter().map(|a| a.replace('_', " ")).collect::<Vec<_>>(),
                correctable => e.runtime_correctable,
            }
        })
        .collect();
    let fit = &d.fit;
    let unit = &d.noise_floor.unit;
    let rms = |v: Option<f64>| v.map_or("–".to_string(), |v| figure(v, unit));
    let (map, map_key) = map::mismatch(outcome, &before, &after);
    let environment = environment();
    let values = context! {
        recording => d.recording.clone(),
        verdict => word(d.verdict),
        class => class(d.verdict),
        sentence => sentence(outcome),
        floor => figure(d.noise_floor.value, unit),
        floor_from => d.noise_floor.from.clone(),
        correlation => digits(d.noise_floor.autocorrelation),
        rows => outcome.rows.len(),
        passes => outcome.rows.passes().len(),
        order => outcome.after.order,
        map => map,
        map_key => map_key,
        charts => charts,
        locations => locations,
        effects => effects,
        held_out_by => fit.held_out_by.clone(),
        before_train => rms(Some(fit.before.train_rms)),
        before_held => rms(fit.before.held_out_rms),
        after_train => rms(Some(fit.after.train_rms)),
        after_held => rms(fit.after.held_out_rms),
        gain => fit.gain.as_ref().map(|g| typeset(&figures::with_interval(g.value, g.ci95, unit))),
        of_explainable => fit.of_explainable.map(|f| format!("{:.0} %", 100.0 * f)),
        judged => d.judged.clone(),
        withheld => d.withheld.clone(),
        bad_rows => d.bad_rows.iter().map(bad_row).collect::<Vec<String>>(),
        unidentifiable => d.unidentifiable.clone(),
        next => d.next_experiment.clone(),
    };
    // The template is part of the program and rendered by a test: it cannot fail on other data.
    environment.render_named_str("page.html", include_str!("page.html"), values).unwrap_or_else(|error| {
        format!("<!doctype html><title>report</title><p>The report could not be rendered: {error}</p>")
    })
}

/// A cell that was left out, in a sentence.
fn bad_row(b: &BadRow) -> String {
    format!("line {}, column {}: found {}, {}; the row was left out", b.line, b.column, b.value, b.reason)
}

/// The templates that pages share. They are part of the program: adding them cannot fail on other data.
pub(crate) fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    let _ = environment.add_template("style.css", include_str!("style.css"));
    environment
}

/// Residual of the base alone, or of the augmented model, row by row.
fn residual(outcome: &Outcome, augmented: bool) -> Vec<f64> {
    let model = if augmented { &outcome.after } else { &outcome.before };
    outcome.rows.error.iter().zip(model.value()).map(|(e, v)| e - v).collect()
}

pub(crate) fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Consistent => "consistent",
        Verdict::Explained => "explained",
        Verdict::PartlyExplained => "partly explained",
        Verdict::Unexplained => "unexplained",
    }
}

pub(crate) fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Consistent => "good",
        Verdict::Explained => "named",
        Verdict::PartlyExplained | Verdict::Unexplained => "open",
    }
}

/// The verdict in a sentence.
fn sentence(outcome: &Outcome) -> String {
    let d = &outcome.diagnosis;
    let unit = &d.noise_floor.unit;
    let names: Vec<String> = d.effects.iter().map(|e| e.title.clone()).collect();
    let names = match names.len() {
        0 | 1 => names.concat(),
        n => format!("{} and {}", names[..n - 1].join(", "), names[n - 1]),
    };
    let place = d.locations.first().map_or_else(String::new, |l| match &l.times {
        Some(times) => format!("{} times {}", readable(&l.variable), readable(times)),
        None => readable(&l.variable),
    });
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
            "The recording agrees with its simulation: nothing is left beyond a noise of {} per reading.",
            figure(d.noise_floor.value, unit)
        ),
        Verdict::Explained => {
            format!(
                "The recording departs from its simulation by {names}; what is left is noise.{held}{caveat}"
            )
        }
        Verdict::PartlyExplained => format!(
            "The recording departs from its simulation by {names}, and by something else that depends on {place} and \
             that no effect in the catalogue explains.{held}{caveat}"
        ),
        Verdict::Unexplained => format!(
            "The recording departs from its simulation: the error depends on {place}, in a way that no effect in the \
             catalogue explains."
        ),
    }
}

/// A column's name for a reader.
pub(crate) fn readable(variable: &str) -> String {
    match variable {
        "angle_deg" => "angle (deg)",
        "t_s" => "time (s)",
        "temperature_c" => "temperature (°C)",
        "common_mode_um" => "common mode (µm)",
        "cross_arcsec" => "second axis (arcsec)",
        "coil_a" => "coil current (A)",
        other => match other.strip_prefix("position_") {
            Some(unit) => return format!("position ({unit})"),
            None => other,
        },
    }
    .to_string()
}

/// A parameter for the table of an effect.
pub(crate) fn parameter(p: &Parameter) -> minijinja::Value {
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
pub(crate) fn without_unit(name: &str, unit: &str) -> String {
    let unit = unit.split(['/', '^', '·']).next().unwrap_or_default().to_lowercase();
    name.split('_').take_while(|word| *word != unit).collect::<Vec<_>>().join(" ")
}

/// Four significant digits.
pub(crate) fn digits(value: f64) -> String {
    typeset(&figures::plain(value))
}

/// A root mean square with its unit.
pub(crate) fn figure(value: f64, unit: &str) -> String {
    typeset(&figures::figure(value, unit))
}

/// With the sign that is as wide as a digit.
fn typeset(text: &str) -> String {
    text.replace('-', "−")
}

pub(crate) fn probability(p: f64) -> String {
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
