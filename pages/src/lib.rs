//! What was calibrated and what the correction leaves, as one self-contained page and SVG files.
//!
//! The figures of the calibration are the error before the correction, the order that was chosen, the model and
//! what it leaves of each point; of a sensor that turns also its harmonics. Those of the correction are of a
//! verification recording where one is given, else of the recording that was fitted.

mod after;
mod axes;
pub mod budget;
mod cells;
mod chart;
mod colour;
mod distribution;
mod figures;
mod hover;
mod interval;
mod marks;
mod polar;
mod thin;
mod turning;
mod verification;

use fitter::Fit;
use fitter::apply::ApplyError;
use fitter::coefficients::Coefficients;
use fitter::error_model::Sensor;
use fitter::faults::BadRow;
use fitter::recording::Recording;
use minijinja::{Environment, context};
use serde::Serialize;

pub use after::{Corrected, PointErrors};
pub use cells::{Cell, Map};
pub use chart::{Chart, Mark, Scale, Series};
pub use colour::Colour;
pub use distribution::distribution;

/// One drawing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// What it is called: `error`, `order` …; of a second verification `mean-2` ….
    pub name: String,
    /// What it shows.
    pub title: String,
    /// What is to be seen in it, with its figures.
    pub caption: String,
    /// SVG with CSS variables for colours, for the page.
    svg: String,
}

impl Figure {
    /// Draws a chart; says in the caption how many of its points are drawn where that is not all of them.
    pub fn of(name: &str, title: &str, caption: String, chart: Chart) -> Figure {
        Figure::scaled(name, title, caption, chart, Scale::Even)
    }

    /// The same over axes that are divided otherwise.
    pub fn scaled(name: &str, title: &str, caption: String, mut chart: Chart, scale: Scale) -> Figure {
        let (drawn, of) = chart.thin();
        let thinned = format!(" Drawn are {drawn} of {of} readings or means; the others lie under them.");
        let caption = if drawn < of { caption + &thinned } else { caption };
        Figure { svg: chart.draw(scale), name: name.to_string(), title: title.to_string(), caption }
    }

    /// Draws a map.
    pub fn map(name: &str, title: &str, caption: String, map: &Map) -> Figure {
        Figure { svg: map.draw(), name: name.to_string(), title: title.to_string(), caption }
    }

    /// The SVG for a page that has the CSS variables of the colours.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// An SVG file of its own, in the colours of a light page.
    pub fn file(&self) -> String {
        colour::standing_alone(&self.svg, colour::Page::Light)
    }

    /// The same in the colours of a dark page.
    pub fn dark_file(&self) -> String {
        colour::standing_alone(&self.svg, colour::Page::Dark)
    }
}

/// What stands on every page beside what was found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Beside {
    /// What the next commands are for, and the commands.
    pub next: Vec<(String, String)>,
    /// The files that are written.
    pub written: Vec<String>,
}

/// Where pages are rendered: with the head and the style that all share, and what stands beside. The templates are part of the program
/// and rendered by tests: they cannot fail on other data.
pub fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    for (name, part) in [
        ("style.css", include_str!("style.css")),
        ("head.html", include_str!("head.html")),
        ("beside.html", include_str!("beside.html")),
        ("budget.html", include_str!("budget.html")),
    ] {
        let _ = environment.add_template(name, part);
    }
    environment
}

/// What stands on the page beside the figures.
pub struct Text<'a> {
    /// The cells that were left out before the fit.
    pub bad_rows: &'a [BadRow],
    /// The summary of the fit as plain text.
    pub summary: &'a str,
    /// The uncertainty budget of the correction, with the name of the routine; none where there is none.
    pub budget: Option<(&'a str, &'a fitter::budget::Budget)>,
    /// The next commands and the files.
    pub beside: &'a Beside,
}

/// A calibration with its fit, and the recordings that verify it.
pub struct Report<'a> {
    recording: &'a Recording,
    fit: &'a Fit,
    corrected: Vec<Corrected>,
}

impl<'a> Report<'a> {
    /// Corrects the verification recordings, or the fitted one where there is none.
    ///
    /// # Errors
    /// [`ApplyError`] where a verification does not fit the sensor.
    pub fn of(
        recording: &'a Recording,
        fit: &'a Fit,
        verifications: &[Recording],
    ) -> Result<Report<'a>, ApplyError> {
        let corrected = if verifications.is_empty() {
            vec![Corrected::fitted(recording, fit)]
        } else {
            (verifications.iter())
                .map(|verification| Corrected::of(verification, &fit.coefficients))
                .collect::<Result<_, _>>()?
        };
        Ok(Report { recording, fit, corrected })
    }

    /// All figures in their order.
    pub fn figures(&self) -> Vec<Figure> {
        let mut figures = figures::calibration(self.recording, self.fit);
        for (index, corrected) in self.corrected.iter().enumerate() {
            let suffix = if index == 0 { String::new() } else { format!("-{}", index + 1) };
            figures.extend(verification::figures(corrected, &self.fit.coefficients, &suffix));
        }
        figures
    }

    /// The error before and after in one picture; after is of the first verification. None where nothing was
    /// corrected.
    pub fn overview(&self) -> Option<Figure> {
        self.corrected.first().map(|corrected| figures::overview(self.fit, corrected))
    }

    /// The page.
    pub fn page(&self, figures: &[Figure], text: &Text) -> String {
        let file = &self.fit.coefficients;
        let statistics = file.statistics.as_ref();
        let spread = |spread: &fitter::statistics::Spread| {
            context! {
                rms => digits(spread.rms),
                max => digits(spread.max),
                mean => digits(spread.max_of_point_means),
            }
        };
        let verified: Vec<_> = (self.corrected.iter())
            .map(|corrected| {
                context! {
                    name => corrected.name.clone(),
                    own => corrected.fitted,
                    rms => digits(corrected.rms()),
                    max => digits(corrected.largest()),
                    mean => digits(corrected.largest_mean()),
                    deviation => corrected.largest_deviation().map(digits),
                }
            })
            .collect();
        let values = context! {
            recording => file.recording.file.clone(),
            rows => file.recording.rows,
            passes => file.recording.passes,
            unit => file.units.statistics.clone(),
            model => model_name(file),
            sha256 => file.recording.sha256.clone(),
            before => statistics.map(|s| spread(&s.before)),
            after => statistics.map(|s| spread(&s.after)),
            verified => verified,
            bad_rows => text.bad_rows
                .iter()
                .map(|bad| format!("line {}, {} {}: {}", bad.line, bad.column, bad.value, bad.reason))
                .collect::<Vec<String>>(),
            notes => self.fit.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
            depends => fitter::dependence::pointer(&self.fit.dependences, &file.recording.file),
            directions => file.turn.as_ref().map(|turn| turn.directions.statement.clone()),
            slope => file.turn.as_ref().and_then(|turn| turn.slope.as_ref()).map(|s| capital(&s.statement)),
            budget => text.budget.map(|(name, of)| context! { name, ..budget::shown(of) }),
            summary => text.summary,
            beside => minijinja::value::Serde(text.beside),
            figures => minijinja::value::Serde(figures),
        };
        rendered(include_str!("page.html"), values)
    }
}

/// A page of values.
fn rendered(page: &str, values: minijinja::Value) -> String {
    environment().render_named_str("page.html", page, values).unwrap_or_else(|error| {
        format!("<!doctype html><title>report</title><p>The report could not be rendered: {error}</p>")
    })
}

/// A sentence begins with a capital.
fn capital(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or(String::new(), |first| first.to_uppercase().chain(rest).collect())
}

/// What was fitted, for a reader.
fn model_name(file: &Coefficients) -> String {
    match &file.turn {
        Some(turn) if turn.whole => {
            let mut name = match turn.amplitudes.len() {
                1 => "one harmonic of the turn".to_string(),
                count => format!("{count} harmonics of the turn"),
            };
            for (also, is) in
                [(", a slope over it", turn.slope.is_some()), (", a lag", turn.directions.lag_corrected)]
            {
                name += if is { also } else { "" };
            }
            name
        }
        _ => format!("a polynomial of order {}", file.base.order),
    }
}

/// The angle (degrees; direct: the sensor's unit) of a value in the internal unit.
fn angle(sensor: &Sensor, internal: f64) -> f64 {
    match sensor {
        Sensor::EddyCurrentPair { .. } => internal.to_degrees(),
        Sensor::Direct { .. } => internal,
    }
}

/// Its unit.
fn angle_unit(sensor: &Sensor) -> &str {
    match sensor {
        Sensor::EddyCurrentPair { .. } => "deg",
        Sensor::Direct { unit, .. } => unit,
    }
}

/// Four significant digits, for a reader.
pub(crate) fn digits(value: f64) -> String {
    fitter::figures::plain(value).replace('-', "−")
}
