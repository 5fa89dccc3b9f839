//! The figures of a sensor that turns: its harmonics, and the error around the turn.

use std::f64::consts::TAU;

use fitter::Fit;
use fitter::figures::NORMAL_95;

use super::chart::{Chart, Mark, Series};
use super::colour::Colour;
use super::{Figure, digits, figures, polar};

/// Points of the model's curve around the turn.
const AROUND: usize = 360;

/// None of a sensor that does not turn.
pub(super) fn figures(fit: &Fit, offset: f64, means: &[f64]) -> Vec<Figure> {
    let file = &fit.coefficients;
    let Some(turn) = file.turn.as_ref().filter(|turn| turn.whole && !turn.amplitudes.is_empty()) else {
        return Vec::new();
    };
    let unit = file.sensor.error_unit();
    let scale = file.sensor.per_internal();
    let amplitude = |a: &fitter::turn::Amplitude| (f64::from(a.harmonic), scale * a.amplitude);
    let bars = turn.amplitudes.iter().map(|a| NORMAL_95 * scale * a.standard_error.unwrap_or(0.0)).collect();
    let strongest = turn.amplitudes.iter().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
    let strongest = strongest.map_or(String::new(), |a| {
        format!("The strongest is harmonic {}: {} {unit}. ", a.harmonic, digits(scale * a.amplitude))
    });
    let harmonics = Figure::of(
        "harmonics",
        "Harmonics of the turn",
        format!("{strongest}The bars are 95 % intervals."),
        Chart {
            label: "Amplitude of each harmonic of the turn",
            x: "periods in a turn".to_string(),
            y: format!("amplitude ({unit})"),
            series: vec![
                Series::new("", Mark::Stems, Colour::Second, turn.amplitudes.iter().map(amplitude).collect())
                    .with_bars(bars),
            ],
        },
    );
    let radians = |reading: f64| TAU * (reading - turn.from) / turn.revolution;
    let model = (0..=AROUND)
        .map(|i| {
            let reading = turn.from + turn.revolution * i as f64 / AROUND as f64;
            (radians(reading), scale * (figures::model(file, reading) - offset))
        })
        .collect();
    let measured = fit.points.reading.iter().map(|r| radians(*r)).zip(means.iter().copied()).collect();
    let plot = polar::Polar {
        label: "Error around the turn",
        unit,
        revolution: (turn.from, turn.revolution),
        reading_unit: &file.units.reading,
        measured,
        model,
    };
    let around = Figure {
        name: "around".to_string(),
        title: "Error around the turn".to_string(),
        caption: plot.caption(),
        svg: plot.draw(),
    };
    vec![harmonics, around]
}
