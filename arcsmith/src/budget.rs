//! `budget`: the uncertainty of a corrected reading after the GUM.

use clap::Args;
use codegen::certificate::{Certificate, OfRoutine};
use codegen::cli::{Arguments, source};
use codegen::generate::generate;
use codegen::options::Options;
use codegen::refused;
use fitter::budget::{Budget, Combined, Component};
use fitter::figures::number;
use fitter::{Coefficients, output, text_safety};
use pages::Beside;
use pages::budget::{freedom, page};
use serde_json::json;

use crate::next;
use crate::terminal::{FIGURE, LABEL, Result, WARNING, line, summarise};

/// Arguments of `budget`: those of `generate`, but that `--out` is a page.
#[derive(Args)]
#[command(
    mut_arg("out", |out| out
        .value_name("FILE.html")
        .help("Write the budget as a page that can be printed for a calibration record")
        .hide_default_value(true)
        .default_value(NOWHERE)),
    // A project states these for its routine; a budget does not change with them.
    mut_args(|arg| if WITHOUT_EFFECT.contains(&arg.get_id().as_str()) { arg.hide(true) } else { arg }),
    after_help = "\
Examples:
  arcsmith budget --coefficients coefficients.json
  arcsmith budget --coefficients coefficients.json --format q31 --input x1x2-counts --bits 16 --gain 1.2207e-5
  arcsmith budget --demo --out budget.html
  arcsmith budget --coefficients encoder.json --bits 14 --json | jq '.budgets[0].budget.range'"
)]
pub struct BudgetArgs {
    #[command(flatten)]
    arguments: Arguments,
}

/// Options of `generate` that do not matter here.
const WITHOUT_EFFECT: [&str; 8] =
    ["check", "devices", "margin", "page_address", "pages_for", "source", "c_shift", "name"];

/// Where no page is asked for: a path that is none.
const NOWHERE: &str = "-";

pub fn run(args: &BudgetArgs) -> Result<()> {
    let arguments = &args.arguments;
    if !arguments.devices.is_empty() || arguments.check {
        return Err(refused!("budget goes with neither --devices nor --check").mend(
            "give the coefficients of one device; generate states the budgets of many in their certificate",
        ));
    }
    source::tell(arguments)?;
    let out = Some(&arguments.out).filter(|out| out.as_os_str() != NOWHERE);
    if let Some(out) = out {
        output::not_the_input(out, &source::source(arguments)?.files())?;
    }
    let (coefficients, sha256) = arguments.load()?;
    let certificate = arguments.of(&coefficients, &sha256)?.0.certificate;
    let budgets = &certificate.budgets;
    if budgets.is_empty() {
        return Err(refused!("the coefficients do not say what a recording showed of the noise")
            .mend("fit a recording with this program: it writes that into the file"));
    }
    if let Some(out) = out {
        let named: Vec<_> = budgets.iter().map(|of| (of.routine.as_str(), &of.budget)).collect();
        let next = vec![next::after_budget(&certificate.command)];
        let beside = Beside { next, written: vec![text_safety::path(out)] };
        let page = page(&named, &origin(&coefficients, &certificate), &beside);
        output::write_whole(out, |file| file.write_all(page.as_bytes()))?;
    }
    let written = out.map(|out| out.display().to_string());
    summarise(
        arguments.common,
        || {
            json!({
                "recording": certificate.recording,
                "coefficients_sha256": certificate.coefficients_sha256,
                "budgets": budgets,
                "written": written,
            })
        },
        || {
            let tables: String = budgets.iter().map(|of| styled(&of.routine, &of.budget)).collect();
            tables + &written.as_ref().map_or_else(String::new, |path| line("written", path))
        },
    );
    Ok(())
}

/// The budget of the first routine that `generate` makes without options; none where it makes none.
pub fn of_usual(coefficients: &Coefficients) -> Option<OfRoutine> {
    let options = Options { leave_out_unreachable: true, ..Options::default() };
    generate(coefficients, "", &options).ok()?.certificate.budgets.into_iter().next()
}

/// Where a budget comes from, for a record.
fn origin(coefficients: &Coefficients, certificate: &Certificate) -> Vec<String> {
    let recording = &coefficients.recording;
    vec![
        format!(
            "Recording {}: {} readings in {} passes, SHA-256 {}.",
            recording.file, recording.rows, recording.passes, recording.sha256
        ),
        format!("Coefficients: SHA-256 {}.", certificate.coefficients_sha256),
        format!("{}; {}.", certificate.tool, certificate.command.replacen("codegen", "arcsmith", 1)),
    ]
}

/// A budget as tables for a terminal.
fn styled(routine: &str, budget: &Budget) -> String {
    let [low, high] = budget.expanded().map(number);
    let (unit, percent) = (&budget.unit, 100.0 * budget.coverage);
    let mut text = format!("{routine}: U = {FIGURE}{low} … {high} {unit}{FIGURE:#} for {percent} %\n");
    text += &line("measurand", &budget.measurand);
    text += &line("formula", &budget.formula);
    text += &line("largest at", &format!("{} = {} {}", budget.place, number(budget.at), budget.place_unit));
    let head = ["quantity", "type", "value", "distribution", "divisor", "c", &format!("|c|·u/{unit}"), "ν"];
    let rows = budget.components.iter().map(row).collect();
    text += &columns(head.map(str::to_string).to_vec(), rows);
    let place = format!("{}/{}", budget.place, budget.place_unit);
    let head =
        [&*place, &format!("result/{unit}"), &format!("u_c/{unit}"), "ν_eff", "k", &format!("U/{unit}")];
    let rows = budget.range.iter().map(|place| {
        let Combined { standard_uncertainty, degrees_of_freedom, coverage_factor, expanded } = place.combined;
        let freedom = freedom(degrees_of_freedom);
        let [at, result] = [place.at, place.result].map(number);
        vec![at, result, number(standard_uncertainty), freedom, number(coverage_factor), number(expanded)]
    });
    text += &columns(head.map(str::to_string).to_vec(), rows.collect());
    for not in &budget.not_included {
        text += &line("not in it", not);
    }
    for missing in &budget.missing {
        text += &format!("{WARNING}{:<12}{WARNING:#} {missing}\n", "missing");
    }
    text
}

fn row(of: &Component) -> Vec<String> {
    vec![
        of.what.clone(),
        format!("{:?}", of.evaluation),
        format!("{} {}", number(of.value), of.unit),
        of.distribution.name().to_string(),
        number(of.divisor),
        number(of.sensitivity),
        number(of.contribution),
        freedom(of.degrees_of_freedom),
    ]
}

/// A table with a head, its columns as wide as they need to be.
fn columns(head: Vec<String>, rows: Vec<Vec<String>>) -> String {
    let all: Vec<&Vec<String>> = std::iter::once(&head).chain(&rows).collect();
    let width = |k: usize| all.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let one = |row: &[String]| {
        let cells: Vec<String> =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        cells.join("  ").trim_end().to_string()
    };
    let below: String = rows.iter().map(|row| format!("  {}\n", one(row))).collect();
    format!("  {LABEL}{}{LABEL:#}\n{below}", one(&head))
}
