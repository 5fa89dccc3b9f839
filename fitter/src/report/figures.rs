//! Which figure shows what.

use super::after::Corrected;
use super::chart::{Chart, Colour, Mark, Series};
use super::{Figure, angle, angle_unit, digits};
use crate::coefficients::Coefficients;
use crate::fit::Fit;
use crate::recording::Recording;
use crate::statistics::PointMoments;

/// Points of a drawn model curve.
const CURVE: usize = 400;

fn series(name: &str, mark: Mark, colour: Colour, points: Vec<(f64, f64)>) -> Series {
    Series { name: name.to_string(), points, mark, colour }
}

fn figure(number: &str, title: &str, caption: String, svg: String) -> Figure {
    Figure { number: number.to_string(), title: title.to_string(), caption, svg }
}

/// Figures 5, 6 and 7.
pub(super) fn calibration(recording: &Recording, fit: &Fit) -> Vec<Figure> {
    let file = &fit.coefficients;
    let sensor = &file.sensor;
    let (unit, shown) = (sensor.error_unit(), angle_unit(sensor));
    let reading = format!(
        "{} ({})",
        if file.units.reading == "mm" && shown == "deg" { "s = x₂ − x₁" } else { "reading" },
        file.units.reading
    );
    let scale = sensor.per_internal();
    let points = &fit.points;
    // Where a sensor that turns has its zero is no error.
    let offset = if file.whole_turn() { file.base.coefficients[0] } else { 0.0 };
    let error = |row: usize| fit.calibrated.error[row] - offset;
    let means = PointMoments::of(points, |row| scale * error(row)).mean;
    let left = PointMoments::of(points, |row| scale * fit.residual[row]).mean;
    let rows = 0..recording.rows();
    let calculated = |row: usize| sensor.calculated(fit.calibrated.reading[row]);
    let calibrated: Vec<(f64, f64)> = (rows.clone())
        .map(|row| (angle(sensor, calculated(row)), angle(sensor, calculated(row) - error(row))))
        .collect();
    let ends = [fit.calibrated.from, fit.calibrated.to].map(|x| angle(sensor, sensor.calculated(x)));
    let largest = means.iter().fold(0.0f64, |max, mean| max.max(mean.abs()));
    let fit_error = left.iter().fold(0.0f64, |max, mean| max.max(mean.abs()));
    let by_reading = |values: &[f64]| points.reading.iter().copied().zip(values.iter().copied()).collect();
    let mut figures = vec![
        figure(
            "5a",
            "Calibrated against calculated angle",
            "An ideal sensor's readings would lie on the line.".to_string(),
            Chart {
                label: "Figure 5a: calibrated angle against calculated angle",
                x: format!("calculated ({shown})"),
                y: format!("calibrated ({shown})"),
                series: vec![
                    series("ideal", Mark::Line, Colour::Soft, vec![(ends[0], ends[0]), (ends[1], ends[1])]),
                    series("calibrated", Mark::Dots, Colour::First, calibrated),
                ],
            }
            .draw(),
        ),
        figure(
            "5b",
            "Error before the correction",
            format!("Means over the passes; up to {} {unit}.", digits(largest)),
            Chart {
                label: "Figure 5b: error before the correction against the reading",
                x: reading.clone(),
                y: format!("error ({unit})"),
                series: vec![series("calibrated error", Mark::Both, Colour::First, by_reading(&means))],
            }
            .draw(),
        ),
    ];
    figures.extend(selection(file));
    figures.push(fitted(fit, offset, &reading, by_reading(&means)));
    figures.push(figure(
        "7b",
        "Fit error of each point",
        format!("Means over the passes; up to {} {unit}.", digits(fit_error)),
        Chart {
            label: "Figure 7b: fit error of each calibration point",
            x: reading,
            y: format!("fit error ({unit})"),
            series: vec![series("fit error", Mark::Stems, Colour::Second, by_reading(&left))],
        }
        .draw(),
    ));
    figures
}

/// Figure 7a: the mean error at each point over the reading, and the model's.
fn fitted(fit: &Fit, offset: f64, reading: &str, means: Vec<(f64, f64)>) -> Figure {
    let file = &fit.coefficients;
    let curve = (0..=CURVE)
        .map(|i| {
            let x = fit.calibrated.from + (fit.calibrated.to - fit.calibrated.from) * i as f64 / CURVE as f64;
            (x, file.sensor.per_internal() * (model(file, x) - offset))
        })
        .collect();
    figure(
        "7a",
        "Error and fitted model",
        format!("The model is {}.", super::model_name(file)),
        Chart {
            label: "Figure 7a: calibrated error and the fitted curve",
            x: reading.to_string(),
            y: format!("error ({})", file.sensor.error_unit()),
            series: vec![
                series("calibrated error", Mark::Dots, Colour::First, means),
                series("model", Mark::Line, Colour::Second, curve),
            ],
        }
        .draw(),
    )
}

/// The error before and after the correction in one picture, for a reader in a hurry.
pub(super) fn overview(fit: &Fit, corrected: &Corrected) -> Figure {
    let file = &fit.coefficients;
    let sensor = &file.sensor;
    let unit = &file.units.statistics;
    let scale = sensor.per_internal();
    let offset = if file.whole_turn() { file.base.coefficients[0] } else { 0.0 };
    let square = |error: f64| error * error;
    let before =
        PointMoments::of(&fit.points, |row| square(scale * (fit.calibrated.error[row] - offset))).mean;
    let angles = fit.points.reading.iter().map(|reading| angle(sensor, sensor.calculated(*reading)));
    let before: Vec<(f64, f64)> = angles.zip(before).map(|(angle, mean)| (angle, mean.sqrt())).collect();
    // The standard deviation is that about the mean of the point.
    let after = (corrected.points.iter())
        .map(|(angle, mean, deviation)| (*angle, mean.hypot(deviation.unwrap_or(0.0))))
        .collect();
    let shown = |points: Vec<(f64, f64)>| points.into_iter().filter(|p| p.1 > 0.0).collect();
    let largest = before.iter().fold(0.0f64, |max, point| max.max(point.1));
    figure(
        "overview",
        "Error before and after the correction",
        format!("Up to {} {unit} before, {} {unit} rms after.", digits(largest), digits(corrected.rms())),
        Chart {
            label: "Error before and after the correction against the angle",
            x: format!("angle ({})", angle_unit(sensor)),
            y: format!("rms error ({unit})"),
            series: vec![
                series("before", Mark::Both, Colour::First, shown(before)),
                series("after", Mark::Both, Colour::Second, shown(after)),
            ],
        }
        .draw_logarithmic(),
    )
}

/// The model's error at a reading, in the internal unit; of a sensor that turns with its harmonics.
fn model(file: &Coefficients, reading: f64) -> f64 {
    match (&file.turn, crate::turn::corrected(file, reading)) {
        (Some(turn), Some(corrected)) => {
            let apart = reading - corrected;
            let constant = file.base.coefficients[0];
            constant + (apart - constant) - turn.revolution * ((apart - constant) / turn.revolution).round()
        }
        _ => file.error_model().error(reading),
    }
}

/// Figure 6, where the order was chosen.
fn selection(file: &Coefficients) -> Option<Figure> {
    let turn = file.turn.as_ref().filter(|turn| turn.whole);
    let selection = turn.map_or(file.order_selection.as_ref(), |turn| turn.harmonics.as_ref())?;
    let what = if turn.is_some() { "number of harmonics" } else { "order n" };
    let of = |pick: fn(&crate::order::OrderScore) -> f64| {
        selection.curve.iter().map(|score| (score.order as f64, pick(score))).filter(|p| p.1 > 0.0).collect()
    };
    let chosen = selection.chosen;
    let word = if selection.rule == "given" { "given" } else { "chosen" };
    Some(figure(
        "6",
        "Training and testing error",
        format!(
            "{chosen} was {word}; the smallest testing error is at {}. {} of {} groups held out by {}, {} splits.",
            selection.smallest_testing_error,
            selection.held_out_groups,
            selection.groups,
            selection.held_out_by,
            selection.splits
        ),
        Chart {
            label: "Figure 6: training and testing error against the order",
            x: what.to_string(),
            y: format!("rms error ({})", selection.unit),
            series: vec![
                series("testing", Mark::Both, Colour::First, of(|score| score.testing)),
                series("training", Mark::Both, Colour::Second, of(|score| score.training)),
            ],
        }
        .draw_logarithmic(),
    ))
}

/// Figures 9 and 10.
pub(super) fn verification(corrected: &Corrected, file: &Coefficients, suffix: &str) -> Vec<Figure> {
    let unit = &file.units.statistics;
    let x = format!("corrected ({})", angle_unit(&file.sensor));
    let whose = if corrected.fitted { "the recording that was fitted" } else { corrected.name.as_str() };
    let mut passes: Vec<(i32, i8)> = corrected.pass.clone();
    passes.sort_unstable();
    passes.dedup();
    let mut named = (false, false);
    let by_pass = passes
        .iter()
        .map(|pass| {
            let mut points: Vec<(f64, f64)> = (0..corrected.pass.len())
                .filter(|row| corrected.pass[*row] == *pass)
                .map(|row| (corrected.angle[row], corrected.error[row]))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (name, colour, seen) = if pass.1 > 0 {
                ("forward", Colour::Second, &mut named.0)
            } else {
                ("backward", Colour::First, &mut named.1)
            };
            // The legend names a direction once.
            let name = if std::mem::replace(seen, true) { "" } else { name };
            series(name, if points.len() > 120 { Mark::Dots } else { Mark::Both }, colour, points)
        })
        .collect();
    let means = corrected.points.iter().map(|(angle, mean, _)| (*angle, *mean)).collect();
    let deviations: Vec<(f64, f64)> =
        corrected.points.iter().filter_map(|(angle, _, deviation)| Some((*angle, (*deviation)?))).collect();
    let number = |number: &str| format!("{number}{suffix}");
    let mut figures = vec![
        figure(
            &number("9a"),
            "Errors after the correction, pass by pass",
            format!(
                "Of {whose}: {} {unit} rms, up to {} {unit}.",
                digits(corrected.rms()),
                digits(corrected.largest())
            ),
            Chart {
                label: "Figure 9a: errors after the correction of every pass",
                x: x.clone(),
                y: format!("error ({unit})"),
                series: by_pass,
            }
            .draw(),
        ),
        figure(
            &number("9b"),
            "Mean error of each point",
            format!("Of {whose}: up to {} {unit}.", digits(corrected.largest_mean())),
            Chart {
                label: "Figure 9b: mean error of each point after the correction",
                x: x.clone(),
                y: format!("mean error ({unit})"),
                series: vec![series("mean error", Mark::Stems, Colour::Second, means)],
            }
            .draw(),
        ),
    ];
    if let Some(largest) = corrected.largest_deviation() {
        figures.push(figure(
            &number("10"),
            "Standard deviation of each point",
            format!("Of {whose}: up to {} {unit}.", digits(largest)),
            Chart {
                label: "Figure 10: standard deviation of each point",
                x,
                y: format!("standard deviation ({unit})"),
                series: vec![series("standard deviation", Mark::Stems, Colour::Second, deviations)],
            }
            .draw(),
        ));
    }
    figures
}
