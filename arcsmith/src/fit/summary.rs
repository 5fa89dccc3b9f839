//! What a fit prints: one screen, or JSON.

use std::fmt::Write;

use clap::builder::styling::Style;
use fitter::dependence;
use fitter::faults::BadRow;
use fitter::figures::{figure, plain, plus_minus};
use fitter::order::OrderSelection;
use fitter::turn::Turn;
use fitter::{Coefficients, Fit};
use serde_json::{Value, json};

use crate::terminal::{FIGURE, LABEL, WARNING, line, with_options};

/// So many harmonics are listed unless everything is.
const LISTED: usize = 6;
/// So many cells that cannot be readings are listed unless everything is.
const LISTED_CELLS: usize = 4;

/// The summary with colours for a terminal; `verbose` adds the curve of the selection.
pub fn styled(fit: &Fit, verbose: bool) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = write_summary(&mut text, fit, verbose);
    text
}

/// The summary without colours.
pub fn plain_text(fit: &Fit) -> String {
    anstream::adapter::strip_str(&styled(fit, false)).to_string()
}

/// One line for each of the first cells that were left out, and how many more there are; then the findings that removed
/// nothing.
pub fn left_out(bad_rows: &[BadRow], notes: &[String], verbose: bool) -> String {
    let listed = if verbose { usize::MAX } else { LISTED_CELLS };
    let mut text = String::new();
    for bad in bad_rows.iter().take(listed) {
        let BadRow { line: number, column, value, reason } = bad;
        text +=
            &format!("{WARNING}{:<12}{WARNING:#} line {number}, {column} {value}: {reason}\n", "left out");
    }
    if bad_rows.len() > listed {
        text += &format!("{LABEL}{:<12}{LABEL:#} and {} more (-v lists them)\n", "", bad_rows.len() - listed);
    }
    for note in notes.iter().take(listed) {
        text += &line("found", note);
    }
    text
}

fn write_summary(text: &mut String, fit: &Fit, verbose: bool) -> std::fmt::Result {
    let file = &fit.coefficients;
    let (recording, range) = (&file.recording, &file.valid_range);
    writeln!(text, "{}: {} readings in {} passes", recording.file, recording.rows, recording.passes)?;
    for note in &fit.notes {
        *text += &line("note", &note.to_string());
    }
    *text += &line(
        "range",
        &format!(
            "{} from {} to {} {}",
            range.variable,
            plain(range.from),
            plain(range.to),
            file.units.reading
        ),
    );
    write_choice(text, file, verbose)?;
    if let Some(zero) = file.identification.as_ref().and_then(|found| found.zero.as_ref()) {
        let error = zero.standard_error_arcsec.map_or(String::new(), |e| format!(" ± {e:.2}"));
        *text += &line("zero", &format!("{:.3}{error} arcsec, {}", zero.alpha0_arcsec, zero.from));
    }
    write_statistics(text, file)?;
    if file.whole_turn() {
        write_harmonics(text, file, verbose)?;
    } else {
        write_coefficients(text, file)?;
    }
    if let Some(turn) = &file.turn {
        *text += &line("directions", &turn.directions.statement);
        write_beside(text, turn, &file.units.statistics);
    }
    if let Some(found) = dependence::pointer(&fit.dependences, &recording.file) {
        *text += &format!("{WARNING}{:<12}{WARNING:#} {found}\n", "note");
    }
    Ok(())
}

/// What is corrected beside the harmonics, and what is left without it.
fn write_beside(text: &mut String, turn: &Turn, unit: &str) {
    if let Some(slope) = &turn.slope {
        *text += &line("slope", slope.statement.trim_start_matches("slope over the turn: "));
    }
    if let Some(left) = &turn.left {
        let mut said = format!("harmonics alone leave {} rms", figure(left.harmonics_alone_rms, unit));
        if turn.slope.is_some() {
            let lag = if turn.directions.lag_corrected { " and the lag" } else { "" };
            said += &format!(
                ", harmonics{lag} fitted without the slope {}",
                figure(left.without_slope_rms, unit)
            );
        }
        *text += &line("in part", &said);
    }
}

/// What was chosen, and why.
fn write_choice(text: &mut String, file: &Coefficients, verbose: bool) -> std::fmt::Result {
    let turn = file.turn.as_ref().filter(|turn| turn.whole);
    let (label, chosen) = match turn {
        Some(turn) => ("harmonics", turn.amplitudes.len()),
        None => ("order", file.base.order),
    };
    let selection = turn.map_or(file.order_selection.as_ref(), |turn| turn.harmonics.as_ref());
    let Some(selection) = selection else {
        *text += &line(label, &format!("{chosen}, as given"));
        return Ok(());
    };
    *text += &line(label, &order_line(chosen, label, selection));
    if verbose {
        writeln!(text, "  {label:<10} {:>12} {:>12} {}", "training", "testing", selection.unit)?;
        for score in &selection.curve {
            writeln!(text, "  {:<10} {:>12.5} {:>12.5}", score.order, score.training, score.testing)?;
        }
    }
    Ok(())
}

fn write_statistics(text: &mut String, file: &Coefficients) -> std::fmt::Result {
    let Some(statistics) = &file.statistics else { return Ok(()) };
    let unit = &statistics.unit;
    for (name, spread, style) in
        [("before", &statistics.before, Style::new()), ("after", &statistics.after, FIGURE)]
    {
        *text += &line(
            name,
            &format!(
                "rms {style}{}{style:#}, largest {}, largest mean of a point {}",
                figure(spread.rms, unit),
                figure(spread.max, unit),
                figure(spread.max_of_point_means, unit)
            ),
        );
    }
    if let Some(scatter) = &statistics.between_passes {
        let weighted = if scatter.weighted { ", uneven: rows are weighted by it" } else { "" };
        *text += &line(
            "noise",
            &format!("{} per reading between passes{weighted}", figure(scatter.standard_deviation, unit)),
        );
    }
    Ok(())
}

fn write_coefficients(text: &mut String, file: &Coefficients) -> std::fmt::Result {
    let Some(identification) = &file.identification else { return Ok(()) };
    writeln!(text, "{LABEL}coefficients{LABEL:#}")?;
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
        *text += &line("open", &with_options(&open.message()));
    }
    Ok(())
}

fn write_harmonics(text: &mut String, file: &Coefficients, verbose: bool) -> std::fmt::Result {
    let Some(turn) = &file.turn else { return Ok(()) };
    let unit = &file.units.statistics;
    *text += &line(
        "turn",
        &format!(
            "{} {unit}; wraps unwound: {} of measured, {} of reference",
            turn.revolution, turn.wraps.measured, turn.wraps.reference
        ),
    );
    *text += &line("offset", &format!("{} {unit}", plain(file.base.coefficients[0])));
    let listed = if verbose { turn.amplitudes.len() } else { LISTED.min(turn.amplitudes.len()) };
    for wave in &turn.amplitudes[..listed] {
        let amplitude = plus_minus(wave.amplitude, wave.standard_error.unwrap_or(0.0), unit);
        let name = format!("harmonic {}", wave.harmonic);
        writeln!(text, "  {name:<11} {amplitude}, phase {:.2} deg", wave.phase_deg)?;
    }
    if listed < turn.amplitudes.len() {
        writeln!(text, "  and {} more (-v lists them)", turn.amplitudes.len() - listed)?;
    }
    Ok(())
}

fn order_line(chosen: usize, what: &str, selection: &OrderSelection) -> String {
    let testing = |order: usize| {
        (selection.curve.iter().find(|score| score.order == order))
            .map_or(String::from("not determined"), |score| figure(score.testing, &selection.unit))
    };
    let best = selection.smallest_testing_error;
    let by = format!(
        "{} of {} held out by {}, {} splits",
        selection.held_out_groups, selection.groups, selection.held_out_by, selection.splits
    );
    if selection.rule == "given" {
        format!("{chosen}, as given; testing error {} ({by})", testing(chosen))
    } else {
        format!(
            "{FIGURE}{chosen}{FIGURE:#}: testing error {}, the smallest {} at {what} {best} (rule: {}; {by})",
            testing(chosen),
            testing(best),
            selection.rule
        )
    }
}

/// The summary of a fit for programs.
pub fn json(fit: &Fit) -> Value {
    let file = &fit.coefficients;
    let turn = file.turn.as_ref().filter(|turn| turn.whole);
    let selection = turn.map_or(file.order_selection.as_ref(), |turn| turn.harmonics.as_ref());
    let chosen = selection.and_then(|s| s.curve.iter().find(|score| score.order == s.chosen));
    json!({
        "recording": file.recording,
        "range": file.valid_range,
        "unit": file.units.statistics,
        "order": file.base.order,
        "harmonics": turn.map(|turn| turn.amplitudes.len()),
        "rule": selection.map(|selection| &selection.rule),
        "testing_error": chosen.map(|score| score.testing),
        "training_error": chosen.map(|score| score.training),
        "zero": file.identification.as_ref().and_then(|found| found.zero.as_ref()),
        "before": file.statistics.as_ref().map(|statistics| &statistics.before),
        "after": file.statistics.as_ref().map(|statistics| &statistics.after),
        "noise": file.statistics.as_ref().and_then(|statistics| statistics.between_passes.as_ref()),
        "parameters": file.identification.as_ref().map(|found| &found.parameters),
        "amplitudes": turn.map(|turn| &turn.amplitudes),
        "directions": file.turn.as_ref().map(|turn| &turn.directions),
        "slope": turn.and_then(|turn| turn.slope.as_ref()),
        "left": turn.and_then(|turn| turn.left.as_ref()),
        "notes": fit.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "depends_on": fit.dependences.iter()
            .map(|found| json!({"variable": found.variable, "p_value": found.p_value}))
            .collect::<Vec<_>>(),
    })
}
