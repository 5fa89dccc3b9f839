//! Simulated against recorded, where the simulation alone errs most; and what is left over all rows.

use pages::{Chart, Colour, Figure, Mark, Series};

use crate::dynamic::DynamicRecording;
use crate::dynamic::diagnose::Predicted;
use crate::thresholds::report::traces::{CLOSE, ENVELOPE};

/// What the model after leaves of every row that is scored, of all columns that are predicted.
pub fn left(recording: &DynamicRecording, own: &Predicted, feedback: bool) -> Vec<f64> {
    let columns = if feedback { &recording.drives } else { &recording.positions };
    let rows = || recording.runs.iter().flat_map(|run| run.start + recording.unscored()..run.end);
    let apart = columns.iter().zip(&own.after).flat_map(|(recorded, after)| {
        rows().filter_map(move |row| Some(recorded.get(row)? - after.get(row)?))
    });
    apart.filter(|left| left.is_finite()).collect()
}

/// Under feedback the drive is what is predicted.
pub fn charts(recording: &DynamicRecording, own: &Predicted, unit: &str, feedback: bool) -> Vec<Figure> {
    let columns = if feedback { &recording.drives } else { &recording.positions };
    let size = |k: usize| -> f64 {
        own.before[k].iter().zip(&columns[k]).map(|(a, b)| (a - b).powi(2)).filter(|e| e.is_finite()).sum()
    };
    let count = columns.len().min(own.before.len()).min(own.after.len());
    let Some(worst) = (0..count).max_by(|a, b| size(*a).total_cmp(&size(*b))) else { return Vec::new() };
    let (recorded, before, after) = (&columns[worst], &own.before[worst], &own.after[worst]);
    let rows = recorded.len().min(before.len()).min(after.len());
    let error = |row: usize| (recorded[row] - before[row]).powi(2);
    let block = |start: usize| -> f64 { (start..start + CLOSE).map(error).sum() };
    let starts = recording.runs.iter().flat_map(|run| {
        let first = run.start + recording.unscored();
        (first..run.end).step_by(CLOSE).filter(move |s| s + CLOSE <= run.end && s + CLOSE <= rows)
    });
    let Some(start) = starts.max_by(|a, b| block(*a).total_cmp(&block(*b))) else { return Vec::new() };
    let t = |row: usize| recording.t_s[row];
    let close = |name: &str, colour, values: &[f64]| {
        let points = (start..start + CLOSE).map(|row| (t(row), values[row])).collect();
        Series::new(name, Mark::Curve, colour, points)
    };
    let what = if feedback { "drive" } else { "position" };
    let name = if count > 1 { format!("{what} {}", worst + 1) } else { what.to_string() };
    let near = Chart {
        label: "Recorded and simulated over time",
        x: "time (s)".to_string(),
        y: format!("{name} ({unit})"),
        series: vec![
            close("recorded", Colour::Ink, recorded),
            close("before", Colour::First, before),
            close("after", Colour::Second, after),
        ],
    };
    // Rms of the residual block by block; rows, since time may start again with every run.
    let width = rows.div_ceil(ENVELOPE).max(1);
    let envelope = |name: &str, colour, values: &[f64]| {
        let block = |from: usize| {
            let to = (from + width).min(rows);
            let sum: f64 = (from..to).map(|row| (recorded[row] - values[row]).powi(2)).sum();
            (from as f64, (sum / (to - from) as f64).sqrt())
        };
        Series::new(name, Mark::Curve, colour, (0..rows).step_by(width).map(block).collect())
    };
    let left = Chart {
        label: "Root mean square of the residual over the rows",
        x: "row".to_string(),
        y: format!("rms of the residual ({unit})"),
        series: vec![envelope("before", Colour::First, before), envelope("after", Colour::Second, after)],
    };
    let blank = String::new;
    vec![
        Figure::of(
            "trace",
            &format!("Recorded and simulated {name}, where the simulation errs most"),
            blank(),
            near,
        ),
        Figure::of("residual", &format!("What is left of {name} over the recording"), blank(), left),
    ]
}
