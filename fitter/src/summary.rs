//! What `fitter fit` prints: one screen.

use std::fmt::Write;

use crate::fit::Fit;
use crate::order::OrderSelection;

/// The summary of a fit, for people.
pub fn summary(fit: &Fit) -> String {
    let file = &fit.coefficients;
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = write_summary(&mut text, fit, file);
    text
}

fn write_summary(text: &mut String, fit: &Fit, file: &crate::Coefficients) -> std::fmt::Result {
    let (recording, range) = (&file.recording, &file.valid_range);
    writeln!(text, "{}: {} readings in {} passes", recording.file, recording.rows, recording.passes)?;
    writeln!(
        text,
        "range        {} from {:.4} to {:.4} {}",
        range.variable, range.from, range.to, file.units.reading
    )?;
    if let Some(selection) = &file.order_selection {
        writeln!(text, "order        {}", order_line(file.base.order, selection))?;
    } else {
        writeln!(text, "order        {}, as given", file.base.order)?;
    }
    if let Some(identification) = &file.identification {
        if let Some(zero) = &identification.zero {
            let error = zero.standard_error_arcsec.map_or(String::new(), |e| format!(" ± {e:.2}"));
            writeln!(text, "zero         {:.3}{error} arcsec, {}", zero.alpha0_arcsec, zero.from)?;
        }
        let unit = &file.units.statistics;
        if let Some(statistics) = &file.statistics {
            for (name, spread) in [("before", &statistics.before), ("after", &statistics.after)] {
                writeln!(
                    text,
                    "{name:<12} rms {:.4} {unit}, largest {:.4} {unit}, largest mean of a point {:.4} {unit}",
                    spread.rms, spread.max, spread.max_of_point_means
                )?;
            }
            if let Some(scatter) = &statistics.between_passes {
                writeln!(
                    text,
                    "noise        {:.4} {unit} per reading between passes{}",
                    scatter.standard_deviation,
                    if scatter.weighted { ", uneven: rows are weighted by it" } else { "" }
                )?;
            }
        }
        writeln!(text, "coefficients")?;
        for parameter in &identification.parameters {
            let interval = parameter
                .ci95
                .map_or(String::new(), |[low, high]| format!("   95 %: {low:>13.5e} … {high:>13.5e}"));
            writeln!(
                text,
                "  {:<10} {:>13.5e} {:<7}{interval}",
                parameter.name, parameter.value, parameter.unit
            )?;
        }
        for open in &identification.unidentifiable {
            writeln!(text, "open         {}", open.statement)?;
        }
    }
    for note in &fit.notes {
        writeln!(text, "note         {note}")?;
    }
    if let Some(line) = crate::dependence::pointer(&fit.dependences, &recording.file) {
        writeln!(text, "note         {line}")?;
    }
    Ok(())
}

fn order_line(chosen: usize, selection: &OrderSelection) -> String {
    let testing = |order: usize| {
        (selection.curve.iter().find(|score| score.order == order))
            .map_or(String::from("?"), |score| format!("{:.4}", score.testing))
    };
    let best = selection.smallest_testing_error;
    let by = format!(
        "{} of {} held out by {}, {} splits",
        selection.held_out_groups, selection.groups, selection.held_out_by, selection.splits
    );
    if selection.rule == "given" {
        format!("{chosen}, as given; testing error {} {} ({by})", testing(chosen), selection.unit)
    } else {
        format!(
            "{chosen}: testing error {} {}, within one standard error of the smallest, {} at order {best} ({by})",
            testing(chosen),
            selection.unit,
            testing(best)
        )
    }
}
