//! The figures of the calibration: the error, the order that was chosen, the model and what it leaves.

use fitter::Fit;
use fitter::coefficients::Coefficients;
use fitter::recording::Recording;
use fitter::statistics::PointMoments;

use super::after::Corrected;
use super::chart::{Chart, Mark, Scale, Series};
use super::colour::Colour;
use super::interval::half_intervals;
use super::{Figure, angle, angle_unit, digits, turning};

/// Points of a drawn model curve.
const CURVE: usize = 400;

/// In the order of the page.
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
    let bars = half_intervals(points, |row| scale * fit.residual[row]);
    let mut figures = vec![
        Figure::of(
            "angle",
            "Calibrated against calculated angle",
            "An ideal sensor's readings would lie on the line.".to_string(),
            Chart {
                label: "Calibrated angle against calculated angle",
                x: format!("calculated ({shown})"),
                y: format!("calibrated ({shown})"),
                series: vec![
                    Series::new(
                        "ideal",
                        Mark::Line,
                        Colour::Soft,
                        vec![(ends[0], ends[0]), (ends[1], ends[1])],
                    ),
                    Series::new("calibrated", Mark::Dots, Colour::First, calibrated),
                ],
            },
        ),
        Figure::of(
            "error",
            "Error before the correction",
            format!("Means over the passes; up to {} {unit}.", digits(largest)),
            Chart {
                label: "Error before the correction against the reading",
                x: reading.clone(),
                y: format!("error ({unit})"),
                series: vec![Series::new("calibrated error", Mark::Both, Colour::First, by_reading(&means))],
            },
        ),
    ];
    figures.extend(selection(file));
    figures.push(fitted(fit, offset, &reading, by_reading(&means)));
    figures.extend(turning::figures(fit, offset, &means));
    figures.push(Figure::of(
        "fit-error",
        "Fit error of each point",
        format!(
            "Means over the passes; up to {} {unit}.{}",
            digits(fit_error),
            if bars.is_empty() { "" } else { " The bars are their 95 % intervals." }
        ),
        Chart {
            label: "Fit error of each calibration point",
            x: reading,
            y: format!("fit error ({unit})"),
            series: vec![
                Series::new("fit error", Mark::Dots, Colour::Second, by_reading(&left)).with_bars(bars),
            ],
        },
    ));
    figures
}

/// The mean error at each point over the reading, and the model's.
fn fitted(fit: &Fit, offset: f64, reading: &str, means: Vec<(f64, f64)>) -> Figure {
    let file = &fit.coefficients;
    let curve = (0..=CURVE)
        .map(|i| {
            let x = fit.calibrated.from + (fit.calibrated.to - fit.calibrated.from) * i as f64 / CURVE as f64;
            (x, file.sensor.per_internal() * (model(file, x) - offset))
        })
        .collect();
    Figure::of(
        "model",
        "Error and fitted model",
        format!("The model is {}.", super::model_name(file)),
        Chart {
            label: "Calibrated error and the fitted curve",
            x: reading.to_string(),
            y: format!("error ({})", file.sensor.error_unit()),
            series: vec![
                Series::new("calibrated error", Mark::Dots, Colour::First, means),
                Series::new("model", Mark::Line, Colour::Second, curve),
            ],
        },
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
        .map(|point| (point.angle, point.mean.hypot(point.deviation.unwrap_or(0.0))))
        .collect();
    let shown = |points: Vec<(f64, f64)>| points.into_iter().filter(|p| p.1 > 0.0).collect();
    let largest = before.iter().fold(0.0f64, |max, point| max.max(point.1));
    Figure::scaled(
        "overview",
        "Error before and after the correction",
        format!("Up to {} {unit} before, {} {unit} rms after.", digits(largest), digits(corrected.rms())),
        Chart {
            label: "Error before and after the correction against the angle",
            x: format!("angle ({})", angle_unit(sensor)),
            y: format!("rms error ({unit})"),
            series: vec![
                Series::new("before", Mark::Both, Colour::First, shown(before)),
                Series::new("after", Mark::Both, Colour::Second, shown(after)),
            ],
        },
        Scale::Logarithmic,
    )
}

/// The model's error at a reading, in the internal unit; of a sensor that turns with its harmonics.
pub(super) fn model(file: &Coefficients, reading: f64) -> f64 {
    match (&file.turn, fitter::turn::corrected(file, reading)) {
        (Some(turn), Some(corrected)) => {
            let apart = reading - corrected;
            let constant = file.base.coefficients[0];
            constant + (apart - constant) - turn.revolution * ((apart - constant) / turn.revolution).round()
        }
        _ => file.error_model().error(reading),
    }
}

/// Training and testing error over the order, where it was chosen.
fn selection(file: &Coefficients) -> Option<Figure> {
    let turn = file.turn.as_ref().filter(|turn| turn.whole);
    let selection = turn.map_or(file.order_selection.as_ref(), |turn| turn.harmonics.as_ref())?;
    let what = if turn.is_some() { "number of harmonics" } else { "order n" };
    let of = |pick: fn(&fitter::order::OrderScore) -> f64| -> Vec<(f64, f64)> {
        selection.curve.iter().map(|score| (score.order as f64, pick(score))).filter(|p| p.1 > 0.0).collect()
    };
    let chosen = selection.chosen;
    let word = if selection.rule == "given" { "given" } else { "chosen" };
    let ringed = of(|score| score.testing).into_iter().filter(|p| p.0 == chosen as f64).collect();
    Some(Figure::scaled(
        "order",
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
            label: "Training and testing error against the order",
            x: what.to_string(),
            y: format!("rms error ({})", selection.unit),
            series: vec![
                Series::new("testing", Mark::Both, Colour::First, of(|score| score.testing)),
                Series::new("training", Mark::Both, Colour::Second, of(|score| score.training)),
                Series::new(word, Mark::Ring, Colour::Ink, ringed),
            ],
        },
        Scale::Logarithmic,
    ))
}
