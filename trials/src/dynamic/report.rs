//! The report of dynamic trials: JSON for programs, and one self-contained HTML page for people, in the design
//! of the static one.

use std::path::Path;

use minijinja::context;
use serde::Serialize;

use super::campaign::{Campaign, Outcome};
use super::score::{Score, score};
use crate::report::{class, render};
use crate::summary::reached;
use crate::workspace::{CampaignError, put};

/// What is reported of a campaign.
#[derive(Serialize)]
pub struct Report {
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
    pub score: Score,
}

impl Report {
    /// Scores a campaign.
    pub fn new(campaign: &Campaign, outcome: &Outcome) -> Self {
        Self {
            schema: 1,
            command: format!("trials dynamic --trials {} --seed {}", campaign.trials, campaign.seed),
            sealed_sha256: outcome.sealed.clone(),
            recordings: outcome.cases.len(),
            score: score(&outcome.cases),
        }
    }

    /// Writes `report.json` and `report.html` into `folder`.
    ///
    /// # Errors
    /// [`CampaignError::Write`].
    pub fn write(&self, folder: &Path) -> Result<(), CampaignError> {
        // Plain numbers, names and lists: cannot fail.
        let json = serde_json::to_string_pretty(self).unwrap_or_default();
        put(&folder.join("report.json"), &(json + "\n"))?;
        put(&folder.join("report.html"), &self.page())
    }

    fn page(&self) -> String {
        let share = |share: crate::score::Share| share.to_string();
        let rows = |rows: &[super::score::Row]| -> Vec<[String; 3]> {
            rows.iter().map(|row| [row.name.clone(), share(row.right), share(row.mentioned)]).collect()
        };
        render(
            include_str!("page.html"),
            context! {
                report => minijinja::Value::from(minijinja::value::Serde(self)),
                classes => self.score.figures.iter().map(class).collect::<Vec<_>>(),
                all_reached => reached(&self.score.figures),
                effects => rows(&self.score.effects),
                circumstances => rows(&self.score.circumstances),
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::score::tests::{case, said};
    use super::super::truth::Group;
    use super::*;

    #[test]
    fn the_page_is_whole_and_says_every_figure_and_miss() {
        let campaign = Campaign { trials: 2, seed: 1, jobs: 1, out: std::path::PathBuf::new() };
        let cases = vec![
            case(Group::Null, Vec::new(), &said("consistent", &[]), 0.9),
            case(Group::Null, Vec::new(), &said("explained", &[("cogging", &[])]), 0.9),
        ];
        let report = Report::new(&campaign, &Outcome { cases, sealed: "00".to_owned() });
        let page = report.page();
        assert!(page.trim_end().ends_with("</html>"), "{page}");
        for figure in &report.score.figures {
            assert!(page.contains(&figure.figure), "{}", figure.figure);
        }
        assert!(page.contains("explained: cogging"));
    }
}
