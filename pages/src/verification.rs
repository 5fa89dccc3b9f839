//! The figures of what the correction leaves: pass by pass, point by point.

use fitter::coefficients::Coefficients;

use super::after::Corrected;
use super::chart::{Chart, Mark, Series};
use super::colour::Colour;
use super::distribution::distribution;
use super::interval::half_of;
use super::{Figure, angle_unit, digits};

/// Readings of a pass, and of all, up to which those of a pass are joined by a line: beyond, lines hide each other.
const JOINED: (usize, usize) = (120, 1500);

/// In the order of the page; `suffix` tells several recordings apart.
pub(super) fn figures(corrected: &Corrected, file: &Coefficients, suffix: &str) -> Vec<Figure> {
    let unit = &file.units.statistics;
    let x = format!("corrected ({})", angle_unit(&file.sensor));
    let whose = if corrected.fitted { "the recording that was fitted" } else { corrected.name.as_str() };
    let name = |name: &str| format!("{name}{suffix}");
    let mut figures = vec![
        Figure::of(
            &name("passes"),
            "Errors after the correction, pass by pass",
            format!(
                "Of {whose}: {} {unit} rms, up to {} {unit}.",
                digits(corrected.rms()),
                digits(corrected.largest())
            ),
            Chart {
                label: "Errors after the correction of every pass",
                x: x.clone(),
                y: format!("error ({unit})"),
                series: by_pass(corrected),
            },
        ),
        mean(corrected, &name("mean"), whose, &x, unit),
    ];
    if let Some(largest) = corrected.largest_deviation() {
        let deviations =
            corrected.points.iter().filter_map(|point| Some((point.angle, point.deviation?))).collect();
        figures.push(Figure::of(
            &name("scatter"),
            "Standard deviation of each point",
            format!("Of {whose}: up to {} {unit}.", digits(largest)),
            Chart {
                label: "Standard deviation of each point",
                x,
                y: format!("standard deviation ({unit})"),
                series: vec![Series::new("standard deviation", Mark::Stems, Colour::Second, deviations)],
            },
        ));
    }
    figures.extend(distribution(&corrected.error, suffix, whose, unit));
    figures
}

fn by_pass(corrected: &Corrected) -> Vec<Series> {
    let mut passes: std::collections::BTreeMap<(i32, i8), Vec<(f64, f64)>> = Default::default();
    for (row, pass) in corrected.pass.iter().enumerate() {
        passes.entry(*pass).or_default().push((corrected.angle[row], corrected.error[row]));
    }
    let mut named = (false, false);
    let series = passes.into_iter().map(|(pass, mut points)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (name, colour, seen) = if pass.1 > 0 {
            ("forward", Colour::Second, &mut named.0)
        } else {
            ("backward", Colour::First, &mut named.1)
        };
        // The legend names a direction once.
        let name = if std::mem::replace(seen, true) { "" } else { name };
        let joined = points.len() <= JOINED.0 && corrected.pass.len() <= JOINED.1;
        Series::new(name, if joined { Mark::Both } else { Mark::Dots }, colour, points)
    });
    series.collect()
}

fn mean(corrected: &Corrected, name: &str, whose: &str, x: &str, unit: &str) -> Figure {
    let freedom = |readings: usize| readings.saturating_sub(1);
    let scatter =
        corrected.points.iter().filter_map(|point| Some((point.deviation?, freedom(point.readings))));
    let (squares, all) =
        scatter.fold((0.0, 0), |(squares, all), (d, f)| (squares + d * d * f as f64, all + f));
    let bars = half_of(squares, all, corrected.points.iter().map(|point| point.readings));
    let explained = if bars.is_empty() { "" } else { " The bars are 95 % intervals of the mean." };
    let means = corrected.points.iter().map(|point| (point.angle, point.mean)).collect();
    Figure::of(
        name,
        "Mean error of each point",
        format!("Of {whose}: up to {} {unit}.{explained}", digits(corrected.largest_mean())),
        Chart {
            label: "Mean error of each point after the correction",
            x: x.to_string(),
            y: format!("mean error ({unit})"),
            series: vec![Series::new("mean error", Mark::Dots, Colour::Second, means).with_bars(bars)],
        },
    )
}
