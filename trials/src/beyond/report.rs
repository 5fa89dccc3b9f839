//! The report: JSON with every recording, and its tables in Markdown.

use super::plan::Counts;
use super::score::{Line, NullLine, Row, Score, score};
use crate::report::{Page, Report};
use crate::score::Figure;
use crate::workspace::{Campaign, Outcome};

impl Report<Score> {
    /// Scores a campaign beyond the catalogue.
    pub fn of_beyond(campaign: &Campaign<Counts>, outcome: &Outcome<Row>) -> Self {
        let counts = &campaign.counts;
        let mut command = format!(
            "trials beyond --trials {} --nulls {} --seed {}",
            counts.trials, counts.nulls, campaign.seed
        );
        if counts.motion > 0 {
            command += &format!(" --motion {}", counts.motion);
        }
        if counts.left_out > 0 {
            command += &format!(" --leave-out {}", counts.left_out);
        }
        command.extend(counts.kinds.iter().map(|id| format!(" --kind {id}")));
        Self::of(command, outcome, score)
    }
}

impl Page for Report<Score> {
    const FILE: &str = "report.md";

    /// The figures and tables in Markdown.
    fn page(&self) -> String {
        let mut text = format!("```sh no-run: minutes\narcsmith {}\n```\n\n", self.command);
        text += &table(
            "figure | wanted | measured",
            self.score.figures.iter().map(|Figure { figure, wanted, measured, passed }| {
                let missed = if *passed == Some(false) { " (missed)" } else { "" };
                format!("{figure} | {wanted} | {measured}{missed}")
            }),
        );
        for (title, lines) in [
            ("kind", &self.score.kinds),
            ("kind in motion", &self.score.motion),
            ("left out of the catalogue", &self.score.left_out),
            ("noise", &self.score.families),
            ("condition", &self.score.conditions),
            ("ρ", &self.score.strengths),
        ] {
            if !lines.is_empty() {
                text += &format!("\n{}", of_lines(title, lines));
            }
        }
        if !self.score.nulls.is_empty() {
            text += &format!("\n{}", nulls(&self.score.nulls));
        }
        text
    }
}

/// A table in Markdown: titles and rows of cells, already between bars.
fn table(titles: &str, rows: impl Iterator<Item = String>) -> String {
    let rule = "|---".repeat(titles.matches('|').count() + 1);
    let rows: String = rows.map(|row| format!("| {row} |\n")).collect();
    format!("| {titles} |\n{rule}|\n{rows}")
}

fn of_lines(title: &str, lines: &[Line]) -> String {
    let titles = format!(
        "{title} | recordings | found | located | catalogued name alone | of it, gain lost | gain counted | pooled | \
         median | ≥ 90 % | made worse"
    );
    let percent = |part: Option<f64>| part.map_or("–".to_owned(), |part| format!("{:.0} %", 100.0 * part));
    let row = |line: &Line| {
        let Line { what, recordings, found, located, named_alone, named_and_lost, .. } = line;
        let Line { counted, realised, harmed, .. } = line;
        let (pooled, median) = (percent(line.pooled), percent(line.median));
        format!(
            "{what} | {recordings} | {found} | {located} | {named_alone} | {named_and_lost} | {counted} | {pooled} | \
             {median} | {realised} | {harmed}"
        )
    };
    table(&titles, lines.iter().map(row))
}

fn nulls(lines: &[NullLine]) -> String {
    let titles = "nothing concealed, noise | recordings | alarms | named | terms for firmware | made worse";
    let row = |NullLine { family, recordings, alarms, named, terms, harmed }: &NullLine| {
        format!("{family} | {recordings} | {alarms} | {named} | {terms} | {harmed}")
    };
    table(titles, lines.iter().map(row))
}
