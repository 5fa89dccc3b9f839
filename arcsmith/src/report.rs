//! `report`.

use std::path::PathBuf;

use clap::Args;
use codegen::refused;
use fitter::output::{self, FileSet};
use fitter::text_safety;
use pages::{Beside, Report, Text};
use serde_json::json;

use crate::budget;
use crate::fit::{ModelArgs, summary};
use crate::next;
use crate::terminal::{Common, Result, line, summarise};
use codegen::cli::recording;

/// Arguments of `report`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith report calibration.csv --mirror mirror.toml --out report.html
  arcsmith report calibration.csv verification.csv --mirror mirror.toml   after the correction: of the second
  arcsmith report encoder.csv --mirror encoder.toml --no-svg")]
pub struct ReportArgs {
    /// The calibration recording, then any that verify its correction
    #[arg(required = true, value_parser = recording())]
    recordings: Vec<PathBuf>,
    /// Where to write the page; the SVG files stand beside it (report-error.svg …)
    #[arg(long, default_value = "report.html")]
    out: PathBuf,
    /// Draw the error before and after the correction as one SVG; beside it, as FILE-dark.svg, for a dark page
    #[arg(long, value_name = "FILE.svg")]
    overview: Option<PathBuf>,
    /// Write the page alone
    #[arg(long)]
    no_svg: bool,
    #[command(flatten)]
    model: ModelArgs,
}

pub fn run(args: &ReportArgs, common: Common) -> Result<()> {
    let inputs: Vec<_> = args.recordings.iter().chain([&args.model.mirror]).map(PathBuf::as_path).collect();
    for out in std::iter::once(&args.out).chain(&args.overview) {
        output::not_the_input(out, &inputs)?;
    }
    let Some((calibration, verifications)) = args.recordings.split_first() else {
        return Err(refused!("no recording was given"));
    };
    let (screened, fit) = args.model.fit(calibration, common)?;
    let recording = &screened.recording;
    let sensor = &fit.coefficients.sensor;
    let verifications = (verifications.iter())
        .map(|path| args.model.read_other(path, sensor, common))
        .collect::<Result<Vec<_>>>()?;
    let report = Report::of(recording, &fit, &verifications)?;
    let figures = report.figures();
    let plain = summary::plain_text(&fit);
    let budget = budget::of_usual(&fit.coefficients);
    let mut written = vec![text_safety::path(&args.out)];
    let mut set = FileSet::new();
    let stem = args.out.file_stem().map_or_else(|| "report".into(), |stem| stem.to_string_lossy());
    for figure in figures.iter().filter(|_| !args.no_svg) {
        let path = args.out.with_file_name(format!("{stem}-{}.svg", figure.name));
        set.put(&path, figure.file())?;
        written.push(text_safety::path(&path));
    }
    if let (Some(light), Some(figure)) = (&args.overview, report.overview()) {
        let stem = light.file_stem().map_or_else(|| "overview".into(), |stem| stem.to_string_lossy());
        let dark = light.with_file_name(format!("{stem}-dark.svg"));
        for (path, text) in [(light, figure.file()), (&dark, figure.dark_file())] {
            set.put(path, text)?;
            written.push(text_safety::path(path));
        }
    }
    let model = &args.model;
    let next = next::after_report(calibration, &model.mirror, &model.typed_map(), &model.typed());
    let beside = Beside { next, written };
    let text = Text {
        bad_rows: &screened.bad_rows,
        budget: budget.as_ref().map(|of| (of.routine.as_str(), &of.budget)),
        summary: &plain,
        beside: &beside,
    };
    set.put(&args.out, report.page(&figures, &text))?;
    set.commit()?;
    let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
    summarise(
        common,
        || {
            let mut value = summary::json(&fit);
            value["bad_rows"] = json!(screened.bad_rows);
            value["figures"] = json!(names);
            value["written"] = json!(beside.written);
            value
        },
        || {
            let svg = if args.no_svg { "" } else { ", and each as SVG beside it" };
            summary::styled(&fit, common.verbose)
                + &summary::left_out(&screened.bad_rows, &screened.notes, common.verbose)
                + &line("figures", &names.join(", "))
                + &line("written", &format!("{}{svg}", args.out.display()))
        },
    );
    Ok(())
}
