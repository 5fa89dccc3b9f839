//! The report: JSON for programs, and one self-contained HTML page for people. Nothing in it depends on the
//! machine or the time, so that the same seed gives the same bytes.

mod charts;

use std::path::Path;

use fitter::output::FileSet;
use minijinja::context;
use serde::Serialize;

use crate::error::CampaignError;
use crate::plan::Counts;
use crate::score::{Case, Figure, Score, reached, score};
use crate::truth::CAN_TELL;
use crate::workspace::{Campaign, Outcome};

/// What is reported of a campaign with scores of type `S`.
#[derive(Serialize)]
pub struct Report<S> {
    /// Version of the form.
    pub schema: u32,
    /// What was run.
    pub command: String,
    /// SHA-256 of the sealed truth (`truth.jsonl`).
    pub sealed_sha256: String,
    /// Number of recordings.
    pub recordings: usize,
    /// What was measured.
    #[serde(flatten)]
    pub score: S,
}

/// The page of a report, for people.
pub trait Page {
    /// The name of its file.
    const FILE: &str = "report.html";

    /// Its text.
    fn page(&self) -> String;
}

impl<S: Serialize> Report<S>
where
    Report<S>: Page,
{
    /// Writes `report.json` and the page into `folder`.
    ///
    /// # Errors
    /// [`CampaignError::Output`].
    pub fn write(&self, folder: &Path) -> Result<(), CampaignError> {
        // Plain numbers, names and lists: cannot fail.
        let json = serde_json::to_string_pretty(self).unwrap_or_default();
        let mut set = FileSet::new();
        set.put(&folder.join(<Self as Page>::FILE), self.page())?;
        set.put(&folder.join("report.json"), json + "\n")?;
        set.commit().map(drop).map_err(CampaignError::from)
    }
}

impl<S> Report<S> {
    /// Scores what a campaign brought by `score`.
    pub(crate) fn of<C>(command: String, outcome: &Outcome<C>, score: impl Fn(&[C]) -> S) -> Self {
        let (sealed_sha256, recordings) = (outcome.sealed.clone(), outcome.cases.len());
        Self { schema: 1, command, sealed_sha256, recordings, score: score(&outcome.cases) }
    }
}

impl Report<Score> {
    /// Scores a campaign of static trials.
    pub fn of_static(campaign: &Campaign<Counts>, outcome: &Outcome<Case>) -> Self {
        let counts = &campaign.counts;
        let mut further = if counts.without { String::new() } else { " --skip-without".to_owned() };
        if counts.intervals > 0 {
            further += &format!(" --coverage {}", counts.intervals);
            further.extend(counts.only.iter().map(|id| format!(" --only {id}")));
        }
        if counts.twice > 0 {
            further += &format!(" --twice {}", counts.twice);
        }
        let command = format!(
            "trials static --trials {} --nulls {} --seed {}{further}",
            counts.trials, counts.nulls, campaign.seed
        );
        Self::of(command, outcome, score)
    }
}

impl Page for Report<Score> {
    fn page(&self) -> String {
        render(
            include_str!("page.html"),
            context! {
                report => minijinja::Value::from(minijinja::value::Serde(self)),
                classes => self.score.figures.iter().map(class).collect::<Vec<_>>(),
                all_reached => reached(&self.score.figures),
                chart => self.score.curve.as_ref().map(charts::detection),
                ids => crate::formulas::FORMULAS.iter().map(|f| f.id).collect::<Vec<_>>(),
                can_tell => CAN_TELL,
            },
        )
    }
}

/// A page from its template, with the style that all pages share.
pub(crate) fn render(page: &'static str, values: minijinja::Value) -> String {
    let mut environment = pages::environment();
    environment.set_auto_escape_callback(|_| minijinja::AutoEscape::Html);
    // The templates are part of the program and are rendered by its tests.
    let rendered = environment
        .add_template("campaign.css", include_str!("campaign.css"))
        .and_then(|()| environment.add_template("page.html", page))
        .and_then(|()| environment.get_template("page.html"))
        .and_then(|template| template.render(values));
    rendered.unwrap_or_else(|error| format!("<!doctype html><p>{error}"))
}

pub(crate) fn class(figure: &Figure) -> &'static str {
    match figure.passed {
        Some(true) => "pass",
        Some(false) => "fail",
        None => "unjudged",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::tests::some_cases;

    #[test]
    fn the_page_is_whole_and_says_every_figure() {
        let campaign = Campaign {
            counts: Counts { trials: 1, nulls: 1, without: true, ..Counts::default() },
            seed: 1,
            jobs: 1,
            out: std::path::PathBuf::new(),
        };
        let outcome = Outcome { cases: some_cases(), sealed: "00".to_owned() };
        let report = Report::of_static(&campaign, &outcome);
        let page = report.page();
        assert!(page.trim_end().ends_with("</html>"), "{page}");
        for figure in &report.score.figures {
            let escaped = figure.figure.replace('/', "&#x2f;");
            assert!(page.contains(&figure.figure) || page.contains(&escaped), "{}", figure.figure);
        }
        assert!(page.contains("<svg"));
        assert_eq!(page, Report::of_static(&campaign, &outcome).page());
    }
}
