//! The report of dynamic trials, in the design of the static one.

use minijinja::context;

use super::score::{Case, Score, score};
use crate::report::{Page, Report, class, render};
use crate::score::reached;
use crate::workspace::{Campaign, Outcome};

impl Report<Score> {
    /// Scores a campaign of dynamic trials.
    pub fn of_dynamic(campaign: &Campaign<usize>, outcome: &Outcome<Case>) -> Self {
        let command = format!("trials dynamic --trials {} --seed {}", campaign.counts, campaign.seed);
        Self::of(command, outcome, score)
    }
}

impl Page for Report<Score> {
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
        let campaign = Campaign { counts: 2, seed: 1, jobs: 1, out: std::path::PathBuf::new() };
        let cases = vec![
            case(Group::Null, Vec::new(), &said("consistent", &[]), 0.9),
            case(Group::Null, Vec::new(), &said("explained", &[("cogging", &[])]), 0.9),
        ];
        let report = Report::of_dynamic(&campaign, &Outcome { cases, sealed: "00".to_owned() });
        let page = report.page();
        assert!(page.trim_end().ends_with("</html>"), "{page}");
        for figure in &report.score.figures {
            assert!(page.contains(&figure.figure), "{}", figure.figure);
        }
        assert!(page.contains("explained: cogging"));
    }
}
